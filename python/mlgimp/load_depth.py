"""Load-depth curves of runs and of measurements, in the units of the laboratory: mN, um, s."""

import functools
import math
from collections import namedtuple
from pathlib import Path

import numpy as np

from . import checks, corrections, cycles, instruments, meanings, results, tables, tip_files, tips, zeros
from .corrections import Corrections
from .cycles import find_cycles
from .errors import ResultError
from .heads import DEPTH_UNITS, LOAD_UNITS, STIFFNESS_UNITS, TIME_UNITS, Column, column_argument, column_of  # units for the commands, too

Curve = namedtuple("Curve", "name time depth load area tip poisson plane notes cells block test_time stiffness tip_elastic "
                   "zero_error load_is_quasi_static creeps",
                   defaults=(*(None,) * 6, False, None))
Curve.__doc__ = """A curve in the order of the test: time (s) or None, depth (um), load (mN) of the whole tip, true contact area
(um^2) or None, all [rows]; its Tip or None; Poisson's ratio or None; whether it is plane strain; what to know about it; and of a
run, NaN where that is not known and None of a measured curve, how many cells half the width of the contact has, and how many of
these half widths lie between the tip and the nearest side of the model [rows]; and the time of the test that a run stands for (s)
[rows], None of one without it and of a measured curve, whose time is that; and the stiffness of the contact (mN/um) that an
instrument measures all the time by small oscillations [rows], NaN where it has none, or None; and of a run
with an elastic tip its modulus (GPa) and Poisson's ratio, or None; and the standard uncertainty of a zero of depths that was found
(um), else None; whether the load is that of a slow run without inertia and damping; and of a run whether a material creeps, else None."""

Test = namedtuple("Test", "name read")
Test.__doc__ = "A test in a file: its name, and a function without arguments that returns its Curve or raises a ResultError."

FREE = 0.05  # of the largest load: what a tip over the surface may seem to carry
SHUFFLED = 0.5  # von Neumann's ratio, mean square of steps over variance, is 2 for rows in random order


# ---- runs ----

def read_run(directory):
    """Returns the Curve of a result folder, with the load of the whole tip.

    A load is the mean since the last row, so the depth beside it is that in the middle between two rows. Of a slow test it is the one
    without what inertia and damping add.
    """
    history, summary = results.read_history(directory), results.read_summary(directory)
    options = summary.get("options", {})
    if len(history["time"]) < 2:
        raise ResultError(directory, f"history.csv has {len(history['time'])} rows; a curve needs at least 2: has the run begun?")
    if not results.has_indenter(history):
        raise ResultError(directory, "this run has no indenter, or one that has not moved")
    try:
        parts, tip, poisson = parts_of_tip(options), tip_of_run(options), poisson_of_run(options)
        plane, room = options.get("-geometry") == "plane_strain", room_beside_tip(options)
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ResultError(Path(directory) / "summary.json", "its options are not those of a run") from None
    first = np.append(True, history["time"][1:] > np.maximum.accumulate(history["time"])[:-1])  # where a restart has written rows twice
    history = {name: values[first] for name, values in history.items()}
    load = "load_quasi_static" if "load_quasi_static" in history else "load"
    if "measured_depth" in history:  # an instrument's, without its frame
        frame = parts / float(given(options, "-indenter_stiffness") or math.inf)
        history = {**history, "depth": history["measured_depth"] - frame * history[load]}
    middle = {name: (history[name][1:] + history[name][:-1]) / 2 for name in ("time", "depth")}
    area = 1e12 * parts * history["contact_area"][1:] if "contact_area" in history else None
    curve = Curve(Path(directory).resolve().name, middle["time"], 1e6 * middle["depth"], 1e3 * parts * history[load][1:], area,
                  None if plane else tip, poisson, plane, list(notes_on(options, parts, plane)))
    half = history.get("contact_half_width", np.full(len(history["time"]), np.nan))[1:]
    cells = half / results.finest_cells(summary, history["time"][1:])
    curve = curve._replace(cells=cells, block=room / np.where(half > 0, half, np.nan))
    modulus = 1e-9 * float(given(options, "-indenter_youngs_modulus") or math.inf)
    if modulus < math.inf:
        curve = curve._replace(tip_elastic=(modulus, float(given(options, "-indenter_poissons_ratio") or 0)), notes=[*curve.notes, "depths have the compression of the elastic tip, which the specimen's modulus is without"])
    curve = curve._replace(load_is_quasi_static=load == "load_quasi_static", creeps=creeps(options) if options else None)
    if "test_time" in history:
        curve = curve._replace(test_time=(history["test_time"][1:] + history["test_time"][:-1]) / 2)
    return curve._replace(notes=curve.notes + list(notes_on_waves(curve)))


def notes_on(options, parts, plane):
    """Yields what to know about the loads of a run."""
    if not options:
        yield "summary.json has no options: the load is taken for that of the whole tip"
    if parts > 1:
        yield f"the model is one of {parts} equal parts: loads and areas are those of all"
    if options.get("-loads") or any(float(part) for part in str(options.get("-gravity", 0)).split(",")):
        yield ("loads or gravity move the surface, and depths count from where it was without them: what follows from depths is off by that, "
               "what follows from the true contact area is not")
    if plane:
        yield ("plane strain: depth and stiffness grow with the logarithm of the block's size, so that only the load over the true contact "
               "area is a property; loads are for the thickness of the run")


def notes_on_waves(curve):
    """Yields a line about falls of a run's load that are taken for waves."""
    if waves := cycles.waves(curve):
        pairs = ", ".join(f"{above:.4g} to {below:.4g}" for above, below in waves[:5])
        yield (f"the load falls {len(waves)} times by less than {cycles.WAVE:g} of itself while the tip goes back, which is taken for waves: "
               f"from {pairs} mN" + ", ..." * (len(waves) > 5))


def creeps(options):
    """Returns whether a material of a run's options creeps or relaxes with the time."""
    return any(name.endswith("_rate_law") and value not in ("none", "") or name.endswith("_model") and value == "viscoelastic"
               for name, value in options.items())


def parts_of_tip(options):
    """Returns how many models like that of a run's options make the whole tip: two for each side of symmetry that the tip is on."""
    return 2 ** len(mirror_axes(options))


def mirror_axes(options):
    """Returns the axes (0, 1) across the sides of symmetry that the tip is on, in a run's options; none in axisymmetry."""
    if not options or options.get("-geometry") == "axisymmetric":
        return []
    tip, lower, upper = (numbers(options[name]) for name in ("-indenter_tip", "-domain_lower", "-domain_upper"))
    near = 1e-6 * float(options["-cell_size"])
    return [axis for axis in range(len(tip) - 1) for side, place in (("lower", lower), ("upper", upper))
            if abs(tip[axis] - place[axis]) < near and options.get(f"-boundary_{'xyz'[axis]}_{side}") == "symmetry"]


def room_beside_tip(options):
    """Returns how far (m) the model of a run's options reaches from the tip, in the direction across in which that is least; NaN where
    it is not known."""
    if not options:
        return math.nan
    tip, lower, upper = (numbers(options[name]) for name in ("-indenter_tip", "-domain_lower", "-domain_upper"))
    return min(max(place - below, above - place) for place, below, above in list(zip(tip, lower, upper))[:-1])


def given(options, name):
    """Returns the text of an option of a run, None where it was not given."""
    return None if options.get(name) == "none" else options.get(name)


def tip_of_run(options):
    """Returns the Tip of a run's options; None where they are not known, or where its file is no longer there."""
    kind = options.get("-indenter")
    if kind == "area_function":
        return tip_of_area(options)
    try:
        if kind == "profile":
            return tip_files.tip_of_profile(options["-indenter_profile"])
        if kind == "height_map":
            size = given(options, "-indenter_map_size")
            return tip_files.tip_of_map(options["-indenter_map"], numbers(size) if size else None)
    except ResultError:
        return None
    if kind not in tips.NEEDS:
        return None
    found = {name: given(options, f"-indenter_{name}") for name in ("half_angle", "radius", "tip_radius", "edge_radius", "faces")}
    sizes = {name: float(text) for name, text in found.items() if text is not None}
    sizes |= {name: 1e6 * sizes[name] for name in ("radius", "tip_radius", "edge_radius") if name in sizes}
    return tips.make_tip(kind, **sizes | ({"faces": int(sizes["faces"])} if "faces" in sizes else {}))


def tip_of_area(options):
    """Returns the Tip of the area function of a run's options, whose units are SI."""
    in_metres, range_m = numbers(options["-indenter_area_coefficients"]), given(options, "-indenter_area_depths")
    coefficients = [c * 10.0 ** (9 * (2 - 2.0 ** (1 - k))) for k, c in enumerate(in_metres)]
    tip = tips.tip_of_function(coefficients, *(1e9 * depth for depth in (numbers(range_m) if range_m else ())))
    faces = given(options, "-indenter_faces")
    return tips.of_shape(tip, int(faces) if faces else None)


def poisson_of_run(options):
    """Returns the Poisson's ratio of a run's materials; None where they differ, are crystals or are not known."""
    if any(name.endswith("_elastic_constants") for name in options):
        return None
    ratios = {float(value) for name, value in options.items() if name.endswith("_poissons_ratio") and name != "-indenter_poissons_ratio"}
    return ratios.pop() if len(ratios) == 1 else None


def numbers(text):
    """Returns the numbers of a list with commas."""
    return [float(part) for part in text.split(",")]


# ---- measurements ----

def read_measured(path, depth=None, load=None, time=None, *, test=None, zero_depth=0, zero_load=0, drift=None, frame_compliance=None, stiffness=None):
    """Returns the Curve of a test in a text with columns, with or without lines of text above, between and below the rows, or in a sheet
    of a workbook.

    depth, load, time and stiffness: "COLUMN:UNIT" with the name or number of the column, as "Displacement:nm", or a Column; None: the column whose
    head says so, in the unit that stands there. test: which test of a file with several, from 1 on. zero_depth and zero_load: what the
    file has for the depth where the tip touches, and for the load of the free tip, in its own units, or how they are found, see
    zeros.py. drift (nm/s, or "auto", see drifts.py) and frame_compliance (nm/mN) are taken off the depths. What was measured on the way
    to the surface is left out.
    """
    tests = measured_tests(path, depth, load, time, zero_depth, zero_load, drift, frame_compliance, stiffness)
    if test is None and len(tests) > 1:
        raise ResultError(path, f"holds {len(tests)} tests: choose one by its number, test 1 to {len(tests)}")
    number = 1 if test is None else checks.whole("test", test, 1)
    if number > len(tests):
        raise ResultError(path, f"there is no test {number}; there are {len(tests)}")
    return tests[number - 1].read()


def read_tests(path, depth=None, load=None, time=None, *, zero_depth=0, zero_load=0, drift=None, frame_compliance=None, stiffness=None):
    """Returns the Curves of all tests in a text with columns or in a workbook; arguments are those of read_measured."""
    return [test.read() for test in measured_tests(path, depth, load, time, zero_depth, zero_load, drift, frame_compliance, stiffness)]


def measured_tests(path, depth=None, load=None, time=None, zero_depth=0, zero_load=0, drift=None, frame_compliance=None, stiffness=None):
    """Returns the Tests in a file, each with its name and a function without arguments that returns a Curve or raises a ResultError."""
    given = {"depth": depth, "load": load, "time": time, "stiffness": stiffness}
    asked = {name: column_of(name, value, meanings.UNITS_OF[name]) for name, value in given.items() if value is not None}
    if "depth" in asked and "load" in asked and asked["depth"].name == asked["load"].name:
        raise ResultError(path, f"depth and load are the same column, {asked['depth'].name}")
    wished = Corrections(zero_depth, zero_load, corrections.checked_drift(drift), corrections.checked_frame(frame_compliance))
    sources = instruments.sources(checks.path("path", path))
    tests = []
    for source in sources:
        name = " ".join(filter(None, (Path(path).name, source.name)))
        try:
            tests += tests_of_source(path, name, source, asked, wished)
        except ResultError as problem:
            if len(sources) == 1:
                raise
            tests.append(Test(name, functools.partial(refuse, problem)))
    return tests


def refuse(problem):
    raise problem


def tests_of_source(path, name, source, asked, wished):
    """Returns the Tests of a Source, with the columns that are `asked` for by name, {"depth": Column}, or those that its heads name."""
    sets, lines, notes = columns_of(path, source, asked)
    notes, tests = [*source.facts.notes, *notes], []
    for columns in sets:
        offsets = {what: zeros.checked(what, getattr(wished, what), column.factor) for what, column in zip(("zero_depth", "zero_load"), columns)}
        others = [next(what for what, units in meanings.UNITS_OF.items() if column.units is units) for column in columns[2:]]
        tests += [(read, others, wished._replace(**offsets)) for read in tables.tests_of(path, lines, source.mark, source.numerals, columns)]
    names = [name + f" test {number}" * (len(tests) > 1) for number in range(1, len(tests) + 1)]
    tip, named = source.facts.tip, tuple(asked)
    return [Test(name, functools.partial(measured_curve, path, name, read, others, own, tip, notes, named))
            for name, (read, others, own) in zip(names, tests)]


def columns_of(path, source, asked):
    """Returns the Columns depth, load and perhaps time of a Source, a list of them for each of the tests beside each other; its Lines from
    their names on; and notes."""
    if "depth" in asked and "load" in asked:
        return [list(asked.values())], source.lines, []
    if source.facts.columns:
        columns = {what: Column(number, meanings.UNITS_OF[what][source.facts.units[what]], meanings.UNITS_OF[what]) for what, number in zip(meanings.UNITS_OF, source.facts.columns)}
        return [list((columns | asked).values())], source.lines, []
    found = meanings.find(path, source, asked)
    return found.sets, source.lines[found.line:], found.notes


def measured_curve(path, name, read, others, wished, tip, more_notes, named):
    """Returns the Curve of a test that read() gives: [rows][depth um, load mN, and what `others` names] and notes, with Corrections.
    named: the columns that the caller has named; a time that is not may begin anew with each segment, and a stiffness that is not may have
    no numbers."""
    table, notes = read()
    falls = np.flatnonzero(np.diff(table[:, 2]) < 0) if "time" in others else []
    if len(falls) and "time" in named:
        raise ResultError(path, f"the time falls in data row {falls[0] + 2}; rows must be in the order of the test")
    if len(falls):
        table = np.column_stack([table[:, :2], one_clock(table[:, 2], falls), table[:, 3:]])
        notes = [*notes, f"the time begins anew {len(falls)} times, first in data row {falls[0] + 2}, and is taken to go on there"]
    table = table[np.append(True, np.any(np.diff(np.nan_to_num(table), axis=0) != 0, axis=1))]
    curve = Curve(name, None, *table.T[:2], None, tip, None, False, notes)._replace(**dict(zip(others, table.T[2:])))
    if "stiffness" in others and "stiffness" not in named and not np.any(np.nan_to_num(curve.stiffness) > 0):
        curve, others = curve._replace(stiffness=None), [each for each in others if each != "stiffness"]
    curve = corrections.corrected(curve, wished)
    check_order_and_signs(path, curve.depth, curve.load)
    approach = rows_of_approach(curve.depth, curve.load)
    left_out = [f"{approach} rows of the approach, with depths below zero and hardly a load, are left out"] * (approach > 0)
    return curve._replace(notes=[*curve.notes, *left_out, *more_notes],
                          **{each: getattr(curve, each)[approach:] for each in ("depth", "load", *others)})


def one_clock(time, falls):
    """Returns times [rows] in which each clock goes on where the one before ended, a step later; falls: the last rows of clocks."""
    jumps = np.zeros(len(time))
    jumps[falls + 1] = time[falls] - time[falls + 1] + np.median(np.abs(np.diff(time)))
    return time + np.cumsum(jumps)


def check_order_and_signs(path, depth, load):
    """Refuses curves whose rows are not in the order of the test, and those whose depth or load has the other sign."""
    for what, values in (("depth", depth), ("load", load)):
        if len(values) > 1 and np.mean(np.diff(values) ** 2) > SHUFFLED * np.var(values):
            raise ResultError(path, f"the {what} jumps to and fro: rows must be in the order of the test")
    if -depth.min() > depth.max() and abs(load[np.argmin(depth)]) > FREE * np.abs(load).max():
        raise ResultError(path, "the depth goes below zero under load farther than above: into the surface is positive")
    if -load.min() > load.max():
        raise ResultError(path, "the load goes below zero farther than above: into the surface is positive")


def rows_of_approach(depth, load):
    """Returns how many rows at the beginning are those of a free tip over the surface, all but the last of them."""
    pressed = np.argmax(load > FREE * load.max())
    over = np.flatnonzero(depth[:pressed] < 0)
    return int(over[-1]) if len(over) else 0
