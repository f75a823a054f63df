"""Materials and tips by name, as the program has them: `bin/mlgimp -presets` lists them with their sources."""

import functools
import os
import re
import subprocess
from collections import namedtuple

from . import hints, units
from . import tips as shapes
from .errors import Error
from .program import ENVIRONMENT, find_program

Preset = namedtuple("Preset", "name values percents source")
Preset.__doc__ = """A material or a tip: its name; values, a dict of texts {option without prefix and dash: value with its unit}; percents, a dict of the
standard uncertainties of those that have one (per cent of the value); and where they come from."""


LAWS = "neo_hookean", "hypoelastic", "j2", "st_venant_kirchhoff", "linear", "viscoelastic", "anisotropic"  # of -NAME_model


@functools.lru_cache(maxsize=1)
def listed():
    """Returns the lines of all presets, ({name: Preset of a material}, {name: Preset of a tip})."""
    found = subprocess.run([find_program(), "-presets"], capture_output=True, text=True, check=False, env={**ENVIRONMENT, **os.environ})
    if found.returncode != 0:
        raise Error(f"{find_program()} -presets: {found.stderr.strip() or 'fails'}")
    materials, tips = {}, {}
    for line in found.stdout.splitlines():
        name, rest = line.split(": ", 1)
        words, source = re.fullmatch(r"(.*?) \((.*)\)", rest).groups()
        values, percents = {}, {}
        for word in words.split(", "):
            option, value, percent = re.fullmatch(r"-(?:NAME_)?(\w+) (\S+)(?: \+- (\S+) %)?", word).groups()
            values[option] = value
            if percent:
                percents[option] = float(percent)
        (tips if "indenter" in values else materials)[name] = Preset(name, values, percents, source)
    return materials, tips


def materials():
    """Returns {name: Preset} of the materials, for `law` of mlgimp.indent and -NAME_preset."""
    return dict(listed()[0])


def of_material(name):
    """Returns the Preset of an isotropic material; None where the name is that of a law. Raises an Error that lists the names."""
    if name in LAWS:
        return None
    known = materials()
    if name not in known:
        raise Error(f"law={name}: must be {hints.nearest_first(name, [*LAWS, *known])}a law, {', '.join(LAWS)}, or a material, {', '.join(known)}")
    if "elastic_constants" in known[name].values:
        raise Error(f"law={name}: is a crystal, which needs an orientation and a model in space: see options/silicon_001.opts and -NAME_preset")
    return known[name]


def written_out(options):
    """Returns the options of a case, {name: value}, with those that its materials by name give, where it has none of its own."""
    given = {}
    for name, value in options.items():
        if name.endswith("_preset") and value in materials():
            given |= {f"{name.removesuffix('_preset')}_{option}": text for option, text in materials()[value].values.items()}
    return {**given, **options}


def numbers(preset):
    """Returns {option: number in SI units} of those values of a Preset that are numbers."""
    found = {}
    for option, value in preset.values.items():
        try:
            [found[option]] = units.numbers_of(value)
        except (Error, ValueError):
            continue
    return found


def make_tip(name, given, spelt):
    """Returns the Tip (um) of a kind of tips.NEEDS, or of a tip of presets, whose sizes are those that are not given.

    given: {name of a size: value (degrees, um)}; spelt(name) and spelt(name, value): an argument as the user has it.
    """
    kind = name
    if name not in shapes.NEEDS:
        if name not in tips():
            known = [*shapes.NEEDS, *tips()]
            raise Error(f"{spelt('tip', name)}: must be {hints.nearest_first(name, known)}one of {', '.join(known)}; bin/mlgimp -presets lists those "
                        "with numbers")
        preset = tips()[name]
        known = {option.removeprefix("indenter_"): value for option, value in numbers(preset).items()}
        kind, given = preset.values["indenter"], {size: value if size == "half_angle" else 1e6 * value for size, value in known.items()} | given
    shapes.check_sizes(kind, {size: given.get(size) for size in shapes.RULES}, spelt)
    return shapes.make_tip(kind, **given)


def tips():
    """Returns {name: Preset} of the tips, for `tip` of mlgimp.indent and -indenter."""
    return dict(listed()[1])
