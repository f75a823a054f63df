"""The common case: a tip is pressed slowly into a block of one material and drawn back. A few numbers become an options file."""

import math
from pathlib import Path

from . import checks, hints, instrument, load_depth, presets, tips, units
from .checks import Rule
from .errors import Error, RunError
from .options import named, write_options
from .program import option_names, output_folder, run

RATIO = 4  # of cells of neighbouring levels
BOX, GROWTH = 4.3, 3.4  # contact radii from the axis to the finest level's border; how much larger the next box is
LEAST_BOX = 32  # cells of its own that the finest level is wide, so that the contact stays away from the border
LARGEST_BOX = 0.6  # of the block: a level that would be larger is left out
ROOM = 2  # cells of the coarsest level over the block, for what piles up
TABOR, STRAIN = 2.8, 0.08  # hardness over the flow stress at this strain
REST = 0.1  # of the load, at which an unloading under load control ends
THREE_FACES = ("berkovich", "cube_corner")  # no symmetry across x

POISSONS_RATIO, DENSITY = {"poissons_ratio": 0.3}, {"density": 5000.0}  # where none is given; of a slow test the density does not count
HARDENING = ("yield_stress", "hardening_modulus", "hardening_exponent", "hardening_strain", "saturation_stress", "saturation_strain",
             "thermal_exponent", "melting_temperature", "reference_temperature", "initial_temperature")
INITIAL_TEMPERATURE = 293.0  # K, where -initial_temperature is not given
RULES = {
    "depth": Rule(lambda depth: 0 < depth <= 0.01, "in (0, 0.01] m; 200 nm are 200e-9 or \"200nm\""),
    "load": Rule(lambda load: 0 < load < math.inf, "a number > 0 in N; 10 mN are 10e-3"),
    "youngs_modulus": Rule(lambda modulus: 1e3 <= modulus < math.inf, "a number >= 1e3 in Pa; 70 GPa are 70e9"),
    "poissons_ratio": Rule(lambda nu: -1 < nu < 0.5, "in (-1, 0.5)"),
    "cells": Rule(lambda count: 4 <= count <= 100, "in [4, 100]"),
    "block": Rule(lambda width: 8 <= width <= 1000, "in [8, 1000] radii of the contact"),
    "half_angle": tips.RULES["half_angle"],
    "radius": Rule(lambda radius: 0 < radius <= 0.1, "in (0, 0.1] m; 5 um are 5e-6"),
    "tip_radius": Rule(lambda radius: 0 <= radius <= 0.1, "in [0, 0.1] m; 100 nm are 100e-9"),
} | dict.fromkeys(HARDENING, Rule(lambda value: 0 <= value < math.inf, "a number >= 0"))
STRESSES = ("youngs_modulus", "yield_stress", "hardening_modulus", "saturation_stress")
UNITS = {"depth": "a length", "radius": "a length", "tip_radius": "a length", "load": "a force", "half_angle": "an angle", "density": "a density"}
UNITS |= dict.fromkeys(STRESSES, "a stress") | dict.fromkeys(("melting_temperature", "reference_temperature", "initial_temperature"), "a temperature")
FLOW_STRESS = {  # Pa at a plastic strain, of the constants k of a hardening law; at rest, as nobody knows the rate before the run
    "linear": lambda k, a: k["yield_stress"] + k.get("hardening_modulus", 0) * a,
    "power": lambda k, a: k["yield_stress"] * (1 + k["youngs_modulus"] * a / k["yield_stress"]) ** k["hardening_exponent"],
    "swift": lambda k, a: k["yield_stress"] * (1 + a / k["hardening_strain"]) ** k["hardening_exponent"],
    "ludwik": lambda k, a: k["yield_stress"] + k["hardening_modulus"] * a ** k["hardening_exponent"],
    "voce": lambda k, a: (k["saturation_stress"]
                          - (k["saturation_stress"] - k["yield_stress"]) * math.exp(-a / k["saturation_strain"])),
    "johnson_cook": lambda k, a: FLOW_STRESS["ludwik"](k, a) * thermal_softening(k),
}


def indent(law="j2", *, tip="berkovich", depth=None, load=None, test=None, file="indentation.opts", ranks=1, progress=None, overwrite=False,
           **case):
    """Indents a block of one material slowly, draws the tip back, and returns the Results.

    The options file is for the user to keep and to change; the results go to output/ and its name. Everything else is as in
    indentation_options. overwrite: replaces an options file and results that are there.
    """
    own = hints.arguments(indent, indentation_options)
    hints.check_names(case, own, HARDENING)
    groups = indentation_options(law, tip=tip, depth=depth, load=load, test=test, **case)
    checks.path("file", file)
    is_new = not Path(file).exists()
    if not (checks.flag("overwrite", overwrite) or is_new):
        raise Error(f"{file}: is there already; give overwrite=True, or another file")
    goal = {name: checked({name: value})[name] for name, value in (("depth", depth), ("load", load)) if value is not None}
    largest = f"{goal['depth']:.4g} m deep" if "depth" in goal else f"under {goal['load']:.4g} N" if "load" in goal else "a test with times"
    name = tip if isinstance(tip, str) else tip.options()["indenter"]
    write_options(file, groups, f"Indentation of {law} by {name}, {largest}, written by mlgimp.indent. All values are SI.\n"
                                "docs/options.md explains each option.")
    try:
        return run(file, ranks, progress=progress, **({"overwrite": True} if overwrite else {}))
    except Error as problem:
        if is_new and not has_begun(file):
            Path(file).unlink()  # so that the call may be put right and made again
        if isinstance(problem, RunError):
            raise hints.of_unread(problem, own, option_names(), "specimen_", "options={{{!r}: ...}}".format) from None
        raise


def has_begun(file):
    """Whether the run of an options file has written a history since the file was written."""
    history = output_folder({"options_file": file}) / "history.csv"
    return history.exists() and history.stat().st_mtime_ns >= Path(file).stat().st_mtime_ns


def indentation_options(law="j2", *, tip="berkovich", depth=None, load=None, test=None, youngs_modulus=None, poissons_ratio=None,
                        density=None, half_angle=None, radius=None, tip_radius=0.0, geometry="axisymmetric", cells=8, block=45.0,
                        unload=True, tolerance=0.02, frames=10, options=None, **constants):
    """Returns the options of an indentation in groups, a list of dicts, for write_options.

    Quantities are numbers in SI units, or texts with a unit: 200e-9 or "200nm", 70e9 or "70 GPa".
    law: a material of mlgimp.presets.materials(), such as "copper_ofhc", whose constants count where none are given; or
    -specimen_model, such as "j2" or "neo_hookean", with its constants by the names of the options: youngs_modulus (Pa),
    yield_stress (Pa), hardening_modulus (Pa, 0), hardening="power", ...; poissons_ratio 0.3; of a slow test the density (kg/m3) does not count.
    tip: one of mlgimp.presets.tips(), such as "berkovich_R50"; cone (half_angle in degrees), sphere and flat_punch (radius in m), berkovich, vickers, cube_corner, which in axisymmetry
    are the cones of the same area; tip_radius (m) rounds cones and pyramids. Or a Tip, of a laboratory's own shape and compliance.
    test: steps with durations of a test with its own clock, as [(10, "10mN"), (30, "hold"), (10, 0)], in place of
    depth (m) or load (N): the largest; the tip is drawn back until it is free, or to a tenth of the load; unload=False: not.
    geometry: axisymmetric, or 3d: a quarter model, of tips with three faces a half model.
    cells: of the finest level over the radius of the contact; block: width and height of the block in these radii. Load, hardness and
    modulus may be off by 0.7/cells of themselves, the true area by 1.3/cells, and the modulus is too large by 1.09/block: see
    `expected_error` of oliver_pharr().
    tolerance: share of the load that inertia and damping may add; the time of the run goes like its inverse.
    options: other options, which count more, as {"damping": 1e7}.
    """
    options = named(checks.mapping("options", options or {}))
    if "geometry" in options:
        raise Error("options: geometry must be given as the argument geometry, which grid and tip follow")
    given = [name for name, each in (("depth", depth), ("load", load), ("test", test)) if each is not None]
    if len(given) != 1:
        raise Error(f"{' and '.join(given)}: only one of depth, load and test may be given" if given else "depth, load, test: one of them must be given")
    kind, times, values = instrument.turns_of(test) if test is not None else (None, None, None)
    if test is not None:
        depth, load = instrument.largest_of(kind, values).values()
    goal = checked({"depth": depth} if load is None else {"load": load})
    depth, load = goal.get("depth"), goal.get("load")
    own = {"youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio, "density": density, **constants}
    material, constants = material_of(law, {name: value for name, value in own.items() if value is not None})
    cells, block = checked({"cells": cells, "block": block}).values()
    checks.flag("unload", unload)
    if isinstance(tip, str) and tip not in tips.NEEDS and tip in presets.tips():
        tip, half_angle, radius, tip_radius = sizes_of_preset(tip, half_angle, radius, tip_radius)
    shape = shape_of(tip, geometry, half_angle, radius, tip_radius)
    temperature = checked({"initial_temperature": options.get("initial_temperature", INITIAL_TEMPERATURE)})
    size = size_of_contact(shape, constants | temperature, depth, load)
    grid = grid_of(geometry, tip, float(f"{size / cells:.2g}"), cells, block)
    top = grid["block_upper"][-1]
    if test is not None:
        of_part = model_parts(geometry, tip) if kind == "load" else 1
        turns = {"test_times": times, f"indenter_{kind}s": [value / of_part for value in values]}
    elif depth is not None:
        turns = {"indenter_depths": (depth, depth_of_return(shape, constants | temperature, depth)) if unload else depth}
    else:
        largest = load / model_parts(geometry, tip)
        loads = (0, largest, REST * largest) if unload else (0, largest)
        turns = {"indenter_control": "load", "indenter_times": tuple(range(len(loads))), "indenter_loads": loads}
    groups = [
        grid["grid"], *grid["levels"],
        {"materials": "specimen", **{f"specimen_{name}": value for name, value in material.items()}},
        {"bodies": "block", "block_lower": grid["block_lower"], "block_upper": grid["block_upper"]},
        {**shape, "indenter_tip": [0.0] * (len(grid["block_lower"]) - 1) + [top]},
        {"quasi_static": True, "quasi_static_tolerance": tolerance, **turns}, {"frames": frames},
    ]
    return overridden(groups, options)


def material_of(law, given):
    """Returns the options of the material without its name, and all its constants in SI units.

    law: that of -NAME_model, or a material of presets.py; given: {constant: value}.
    """
    preset = presets.of_material(law)
    if preset is None:
        defaults = POISSONS_RATIO | DENSITY | ({"hardening_modulus": 0.0} if law == "j2" and "hardening" not in given else {})
        constants = checked({"youngs_modulus": None, **defaults, **given})
        return {"model": law, **constants}, constants
    own = checked(given)
    return {"preset": law, **own}, {**{name: value for name, value in preset.values.items() if name == "hardening"}, **presets.numbers(preset), **own}


def sizes_of_preset(tip, half_angle, radius, tip_radius):
    """Returns the kind and the sizes of a tip of presets.py; those that are given count more."""
    preset = presets.tips()[tip]
    known = presets.numbers(preset)
    return (preset.values["indenter"], known.get("indenter_half_angle") if half_angle is None else half_angle,
            known.get("indenter_radius") if radius is None else radius, tip_radius or known.get("indenter_tip_radius", 0.0))


def overridden(groups, options):
    """Returns the groups with other options: in place of those that are there, the rest as a group of their own."""
    known = {name for group in groups for name in group}
    rest = {name: value for name, value in options.items() if name not in known}
    return [{name: options.get(name, value) for name, value in group.items()} for group in groups] + [rest] * bool(rest)


# ---- checks ----

def checked(given):
    """Returns {name: value} with all numbers that the grid is computed from as float in SI units; the program looks at the rest."""
    plain = {name: units.argument(name, value, UNITS[name]) if name in UNITS else value for name, value in given.items()}
    return {name: checks.number(name, value, RULES[name]) if name in RULES else value for name, value in plain.items()}


# ---- tip and contact ----

def shape_of(tip, geometry, half_angle, radius, tip_radius):
    """Returns the options of the tip's shape."""
    if geometry not in ("axisymmetric", "3d"):
        raise Error(f"geometry={geometry}: must be axisymmetric or 3d")
    if isinstance(tip, instrument.Tip):
        if any((half_angle, radius, tip_radius)):
            raise Error("tip: sizes must stand in the Tip, not beside it")
        return tip.options()
    if not isinstance(tip, str) or tip not in tips.NEEDS or tip == "pyramid":
        kinds = [kind for kind in tips.NEEDS if kind != "pyramid"]
        near = hints.nearest_first(tip, [*kinds, *presets.tips()])
        raise Error(f"tip={tip}: must be {near}one of {', '.join([*kinds, *presets.tips()])} (mlgimp.presets.tips() has those with numbers)")
    sizes = {"half_angle": half_angle, "radius": radius, "tip_radius": None if tip_radius == 0 else tip_radius}
    sizes = {name: units.argument(name, value, UNITS[name]) for name, value in sizes.items()}
    tips.check_sizes(tip, sizes)
    sizes = checked({name: value for name, value in sizes.items() if value is not None})
    if tip in tips.PYRAMIDS and geometry == "axisymmetric":  # the cone with the same area at each depth
        tangent = math.sqrt(float(tips.make_tip(tip).area(1.0)) / math.pi)
        tip, sizes["half_angle"] = "cone", round(math.degrees(math.atan(tangent)), 2)
    return {"indenter": tip} | {f"indenter_{name}": value for name, value in sizes.items()}


def tip_of(shape):
    """Returns the Tip (um) of the options of a shape."""
    return load_depth.tip_of_run({f"-{name}": as_text(value) for name, value in shape.items()})


def as_text(value):
    """Returns a value as options have it."""
    return ",".join(map(repr, value)) if isinstance(value, (list, tuple)) else str(value)


def contact_modulus(constants):
    """Returns E/(1 - nu^2) in Pa."""
    return constants["youngs_modulus"] / (1 - constants["poissons_ratio"] ** 2)


def hardness(constants):
    """Returns Tabor's hardness of a metal in Pa, infinite for what does not flow or whose law is not known here."""
    law = FLOW_STRESS.get(constants.get("hardening", "linear"))
    if law is None or "yield_stress" not in constants:
        return math.inf
    try:
        return TABOR * law({"initial_temperature": INITIAL_TEMPERATURE, **constants}, STRAIN)
    except (KeyError, ZeroDivisionError) as problem:
        zero = [name for name in HARDENING if isinstance(problem, ZeroDivisionError) and constants.get(name) == 0]
        raise Error(f"{(zero or problem.args)[0]}: must be given, and > 0, for hardening={constants['hardening']}") from None


def thermal_softening(k):
    """Returns the part of its flow stress that a metal of johnson_cook has at the initial temperature."""
    initial = k["initial_temperature"]
    warmer = initial - k.get("reference_temperature", initial)
    if warmer <= 0:
        return 1.0
    if k["melting_temperature"] <= initial:
        raise Error(f"melting_temperature={k['melting_temperature']:g}: must be above initial_temperature {initial:g}")
    return 1 - (warmer / (k["melting_temperature"] - k["reference_temperature"])) ** k["thermal_exponent"]


def size_of_contact(shape, constants, depth, load):
    """Returns about the radius (m) of the contact: that of the tip's section at the depth, or that which bears the load."""
    if depth is not None:
        if shape["indenter"] == "sphere" and not depth < shape["indenter_radius"]:
            raise Error(f"depth={depth}: must be less than the radius of the sphere")
        return 1e-6 * math.sqrt(float(tip_of(shape).area(1e6 * depth)) / math.pi)
    if shape["indenter"] == "flat_punch":
        return shape["indenter_radius"]
    ball = shape.get("indenter_radius", shape.get("indenter_tip_radius", 0))
    elastic = (0.75 * load * ball / contact_modulus(constants)) ** (1 / 3)
    if shape["indenter"] != "sphere":
        tangent = math.sqrt(float(tip_of({**shape, "indenter_tip_radius": 0}).area(1.0)) / math.pi)
        elastic = max(elastic, math.sqrt(2 * load * tangent / math.pi / contact_modulus(constants)))
    return max(elastic, math.sqrt(load / math.pi / hardness(constants)))


def depth_of_return(shape, constants, depth):
    """Returns the depth (m) to which the tip is drawn back: beyond that where the contact ends, which is P/S or somewhat more."""
    beyond = 1.6
    radius = size_of_contact(shape, constants, depth, None)
    elastic = math.pi / 2 * min(hardness(constants), contact_modulus(constants)) / contact_modulus(constants) * radius / depth
    return float(f"{depth * max(0.0, 1 - beyond * elastic):.3g}")


# ---- grid ----

def model_parts(geometry, tip):
    """Returns how many models make the whole tip."""
    return 1 if geometry == "axisymmetric" else 2 ** sum(mirrors(tip))


def mirrors(tip):
    """Returns whether a model of space ends at the tip across x and across y."""
    return tip.mirrors() if isinstance(tip, instrument.Tip) else [tip not in THREE_FACES, True]


def grid_of(geometry, tip, cell, cells, block):
    """Returns the options of the background grid and the levels, and the block's corners; cell: edge of the finest cells in m.

    The finest box has BOX contact radii, the next GROWTH times more, until one would hold most of the block; each is a whole
    number of the next coarser cells, down from the block's top and up through the room over it.
    """
    widths, width = [], max(BOX * cells, LEAST_BOX)
    while width < LARGEST_BOX * block * cells:
        widths.append(width)
        width *= GROWTH
    levels = len(widths) + 1
    coarsest = RATIO ** (levels - 1)
    wide = coarsest * math.ceil(block * cells / coarsest)
    room = ROOM * coarsest
    mirrored = [True] if geometry == "axisymmetric" else mirrors(tip)  # across the axes but the last
    sides = {f"boundary_{'xyz'[axis]}_{side}": "symmetry" for axis in range(len(mirrored)) for side in ("lower", "upper")}

    def lower(width, bottom):
        return [round(each * cell, 15) for each in [0 if half else -width for half in mirrored] + [bottom]]

    def upper(width, top):
        return [round(each * cell, 15) for each in [width] * len(mirrored) + [top]]

    grid = {"geometry": geometry, "domain_lower": lower(wide, 0), "domain_upper": upper(wide, wide + room),
            "cell_size": round(coarsest * cell, 15), **sides, f"boundary_{'xyz'[len(mirrored)]}_lower": "symmetry"}
    boxes = [{"levels": levels, "refinement_ratio": RATIO}] * (levels > 1)
    for level, width in enumerate(reversed(widths), start=1):
        parent = RATIO ** (levels - level)
        width = parent * math.ceil(width / parent)
        boxes[0] |= {f"level_{level}_lower": lower(width, wide - width), f"level_{level}_upper": upper(width, wide + room)}
    if geometry == "axisymmetric":
        del grid["boundary_x_lower"]  # the axis
    return {"grid": grid, "levels": boxes, "block_lower": lower(wide, 0), "block_upper": upper(wide, wide)}
