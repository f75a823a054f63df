"""What a name that nothing knows may have meant: an argument of the function, a constant of a material, an option of the program."""

import difflib
import inspect
import re

from .errors import Error, RunError

LETTERS = 3  # a shorter name is like too many
ALIKE = 0.8  # of difflib's ratio: a letter or two of eight differ
SYNONYMS = {  # what books, other programs and people call an argument; capitals count where both are in use
    "youngs_modulus": ("E", "young", "youngs", "modulus", "elastic_modulus"),
    "poissons_ratio": ("nu", "v", "poisson", "poissons"),
    "density": ("rho", "mass_density"),
    "yield_stress": ("sy", "sigma_y", "sigma_0", "yield", "yield_strength", "yield_point", "Y"),
    "hardening_modulus": ("H", "tangent_modulus"), "hardening_exponent": ("n", "exponent"),
    "law": ("model", "material", "constitutive_law"), "tip": ("indenter", "shape", "kind"),
    "half_angle": ("angle", "alpha", "theta", "cone_angle", "semi_angle"), "radius": ("R", "r"),
    "depth": ("h", "max_depth", "hmax", "penetration", "displacement"), "load": ("P", "F", "force", "max_load", "Pmax"),
    "cells": ("mesh", "resolution", "elements"), "block": ("size", "block_size"), "tolerance": ("tol", "accuracy"),
    "ranks": ("np", "nproc", "processes", "cores", "cpus", "threads"), "file": ("name", "path", "options_file"),
    "indenter_friction": ("friction", "mu", "friction_coefficient"),
}
MEANT = {word: name for name, words in SYNONYMS.items() for word in words}
MEANT = {word.lower(): name for word, name in MEANT.items()} | MEANT


def arguments(*functions):
    """Returns the names of all arguments of functions that can be given by name, each once."""
    parameters = [each for function in functions for each in inspect.signature(function).parameters.values()]
    return list(dict.fromkeys(each.name for each in parameters if each.kind != each.VAR_KEYWORD))


def synonym(name, known):
    """Returns the one of the known names that a name is another word for; None where there is none."""
    found = MEANT.get(name, MEANT.get(name.lower()))
    return found if found in known else None


def alike(name, known, least=ALIKE):
    """Returns the one of the known names that is spelt nearly as a name; None where there is none."""
    return next(iter(difflib.get_close_matches(name.lower(), known, 1, least)), None)


def meant(name, known):
    """Returns the one of the known names that a name was probably to be: it differs from it, or from its beginning, in capitals or a few letters; None
    where there is none."""
    small = {each.lower(): each for each in known}
    if not isinstance(name, str) or len(name) < LETTERS:
        return None
    begun = {each[:len(name)]: each for each in reversed(small)}
    near = difflib.get_close_matches(name.lower(), small, 1, ALIKE) or [begun[each] for each in difflib.get_close_matches(name.lower(), begun, 1, ALIKE)]
    return small[near[0]] if near else None


def nearest_first(name, known):
    """Returns how a message begins its list of the known names: with the one that was probably meant."""
    found = meant(name, known)
    return f"{found}, which is nearest, or " if found else ""


def check_names(names, own, constants=()):
    """Refuses names that are another word for an argument of one's `own` or a constant, or are spelt nearly as such an argument; all
    others are left to the program."""
    for name in names:
        right = None if name in own else synonym(name, [*own, *constants]) or alike(name, own)
        if right:
            raise Error(f"{name}: there is no such argument; it may be {right}")


def of_unread(problem, names, options, prefix="", spelt=lambda option: option):
    """Returns a RunError of the program; where nothing reads an option that a caller has given, with a hint in the caller's words.

    names: what the caller may give by name; options: all of the program's, of which those of a material begin with NAME_; prefix: what
    the program's options have before the names; spelt(option): how the caller gives an option.
    """
    found = re.search(rf"-{prefix}(\w+): unknown or unused option[^;]*", str(problem))
    if not found:
        return problem
    name, constants = found[1], [option.removeprefix("NAME_") for option in options if option.startswith("NAME_")]
    general = [option for option in options if not option.startswith("NAME_")]
    right = next((option for option in (name, f"indenter_{name}", synonym(name, general)) if option in general), None)
    near = alike(name, [*names, *constants], 0.6)
    right, near = right or not near and alike(name, general), near or f"one of {', '.join(names)}, or a constant of the law"
    hint = "another law or kind of hardening has it" if name in constants else f"it may be {spelt(right) if right else near}"
    return RunError(f"{str(problem)[:found.end()]}; {hint}")
