"""Load-depth curves of runs and of measurements, in the units of the laboratory: mN, um, s; and the cycles in them."""

import codecs
import csv
import math
import re
from collections import namedtuple
from pathlib import Path
from statistics import mode

import numpy as np

from . import checks, results, tips
from .errors import Error, ResultError

Curve = namedtuple("Curve", "name time depth load area tip poisson plane notes")
Curve.__doc__ = """A curve in the order of the test: time (s) or None, depth (um), load (mN) of the whole tip, true contact area
(um^2) or None, all [rows]; its Tip or None; Poisson's ratio or None; whether it is plane strain; what to know about it."""

Cycle = namedtuple("Cycle", "begin start end hold")
Cycle.__doc__ = """Rows of a loading and an unloading: the first of all, the first of the unloading, at the largest depth, the last, at the
lowest load, and the slice before the unloading in which the tip is at rest."""

DEPTH_UNITS = {"nm": 1e-3, "um": 1.0, "mm": 1e3, "m": 1e6, "A": 1e-4}  # in um
LOAD_UNITS = {"nN": 1e-6, "uN": 1e-3, "mN": 1.0, "N": 1e3, "kN": 1e6}  # in mN
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}  # in s
UNITS = {*DEPTH_UNITS, *LOAD_UNITS, *TIME_UNITS}  # as words under the names of columns, and in brackets behind them

FALL, RISE = 0.3, 0.1  # of the largest load: by so much it falls in an unloading, and rises again in the next loading
LEAST_LOAD = 0.01  # of the curve's largest: lower peaks are noise of the first contact
FREE = 0.05  # of the largest load: what a tip over the surface may seem to carry
SPIKE = 9  # rows: blows, where columns of a run come into contact, are shorter than half of it
LARGEST = 1e100  # number in a measured file, whose square is one too
SHUFFLED = 0.5  # von Neumann's ratio, mean square of steps over variance, is 2 for rows in random order


# ---- runs ----

def read_run(directory):
    """Returns the Curve of a result folder, with the load of the whole tip.

    A load is the mean since the last row, so the depth beside it is that in the middle between two rows. Of a slow test it is the one
    without what inertia and damping add.
    """
    history, options = results.read_history(directory), results.read_summary(directory).get("options", {})
    if len(history["time"]) < 2:
        raise ResultError(directory, f"history.csv has {len(history['time'])} rows; a curve needs at least 2: has the run begun?")
    if not results.has_indenter(history):
        raise ResultError(directory, "this run has no indenter, or one that has not moved")
    try:
        parts, tip, poisson = parts_of_tip(options), tip_of_run(options), poisson_of_run(options)
        plane = options.get("-geometry") == "plane_strain"
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ResultError(Path(directory) / "summary.json", "its options are not those of a run") from None
    first = np.append(True, history["time"][1:] > np.maximum.accumulate(history["time"])[:-1])  # where a restart has written rows twice
    history = {name: values[first] for name, values in history.items()}
    middle = {name: (history[name][1:] + history[name][:-1]) / 2 for name in ("time", "depth")}
    load = "load_quasi_static" if "load_quasi_static" in history else "load"
    area = 1e12 * parts * history["contact_area"][1:] if "contact_area" in history else None
    return Curve(Path(directory).resolve().name, middle["time"], 1e6 * middle["depth"], 1e3 * parts * history[load][1:], area,
                 None if plane else tip, poisson, plane, list(notes_on(options, parts, plane)))


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


def tip_of_run(options):
    """Returns the Tip of a run's options; None where they are not known."""
    kind = options.get("-indenter")
    if kind not in tips.NEEDS:
        return None
    given = {name: options.get(f"-indenter_{name}") for name in ("half_angle", "radius", "tip_radius", "faces")}
    sizes = {name: float(text) for name, text in given.items() if text is not None}
    sizes |= {name: 1e6 * sizes[name] for name in ("radius", "tip_radius") if name in sizes}
    return tips.make_tip(kind, **sizes | ({"faces": int(sizes["faces"])} if "faces" in sizes else {}))


def poisson_of_run(options):
    """Returns the Poisson's ratio of a run's materials; None where they differ or are not known."""
    ratios = {float(value) for name, value in options.items() if name.endswith("_poissons_ratio")}
    return ratios.pop() if len(ratios) == 1 else None


def numbers(text):
    """Returns the numbers of a list with commas."""
    return [float(part) for part in text.split(",")]


# ---- measurements ----

Column = namedtuple("Column", "name factor units", defaults=({},))
Column.__doc__ = """A column of a file: name, or number from 1 on; values x factor are in the units of Curve; factors by unit, of which the
file must not name one with another factor."""


def column_argument(units):
    """Returns a function that reads COLUMN:UNIT; a Column stays what it is."""
    def read(text):
        if isinstance(text, Column):
            return text
        if not isinstance(text, str):
            raise ValueError("must be a text COLUMN:UNIT")
        name, _, unit = text.rpartition(":")
        if not name or unit not in units:
            raise ValueError(f"must be COLUMN:UNIT with a unit of {', '.join(units)}")
        return Column(name, units[unit], units)
    return read


def column_of(name, given, units):
    """Returns the Column that a caller gives as COLUMN:UNIT, or as a Column."""
    try:
        return column_argument(units)(given)
    except ValueError as problem:
        raise Error(f"{name}={given}: {problem}") from None


def read_measured(path, depth="depth:um", load="load:mN", time=None):
    """Returns the Curve of a text with columns, with or without lines of text above them.

    depth, load and time: "COLUMN:UNIT" with the name or number of the column, as "Displacement:nm", or a Column. What was
    measured on the way to the surface is left out.
    """
    columns = [column_of("depth", depth, DEPTH_UNITS), column_of("load", load, LOAD_UNITS)]
    if columns[0].name == columns[1].name:
        raise ResultError(path, f"depth and load are the same column, {columns[0].name}")
    columns += [column_of("time", time, TIME_UNITS)] if time is not None else []
    table = read_table(checks.path("path", path), columns)
    falls = np.flatnonzero(np.diff(table[:, 2]) < 0) if time is not None else []
    if len(falls):
        raise ResultError(path, f"the time falls in data row {falls[0] + 2}; rows must be in the order of the test")
    table = table[np.append(True, np.any(np.diff(table, axis=0) != 0, axis=1))]
    check_order_and_signs(path, *table.T[:2])
    approach = rows_of_approach(*table.T[:2])
    notes = [f"{approach} rows of the approach, with depths below zero and hardly a load, are left out"] * (approach > 0)
    depths, loads, *times = table[approach:].T
    return Curve(Path(path).name, times[0] if times else None, depths, loads, None, None, None, False, notes)


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


def read_table(path, wanted):
    """Returns the numbers of a text in some Columns times their factors, [rows][columns].

    Columns are parted by semicolons, tabs, commas or spaces, whichever the last row has first; beside semicolons and tabs a comma is
    a decimal point. Lines above the first row may have the names, also those that begin with #; other columns may hold words.
    """
    lines = [(number, line.strip(" ").lstrip("#")) for number, line in enumerate(read_text(path).splitlines(), start=1)]
    lines = [(number, line) for number, line in lines if line.strip()]
    if not lines:
        raise ResultError(path, "is empty")
    rows = (line for _, line in reversed(lines) if is_row(words_of(line, mark_of(line)), mark_of(line)))
    mark = mark_of(next(rows, lines[-1][1]))
    lines = [(number, words_of(line, mark)) for number, line in lines]
    widths = [len(words) for _, words in lines if is_row(words, mark)]
    if not widths:
        number, words = lines[-1]
        raise ResultError(path, f"has 0 rows of numbers; line {number} has {' '.join(words)[:60]!r}, and not two numbers")
    count = mode(widths)
    first = next(k for k, (_, words) in enumerate(lines) if len(words) == count and is_row(words, mark))
    heads = [words for _, words in lines[:first]]
    places = [place_of(path, heads, column.name, count) for column in wanted]
    for column, place in zip(wanted, places):
        check_unit(path, column, [words[place] for words in heads if len(words) == count])
    rows = [row_of(path, number, words, mark, places, count) for number, words in lines[first:]]
    if len(rows) < 10:
        raise ResultError(path, f"has {len(rows)} rows of numbers; a curve needs at least 10")
    return np.array(rows) * [column.factor for column in wanted]


def unit_of(word):
    """Returns what stands in brackets at the end of a word, or all of it, with a u for the letters mu."""
    return re.sub("[\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}]", "u", re.split(r"[(\[]", word.rstrip(")] "))[-1].strip())


def before_unit(word):
    """Returns what stands in a word before a unit in brackets."""
    return re.split(r"[(\[]", word)[0].strip()


def check_unit(path, column, words):
    """Refuses a column whose words above the numbers name another unit, by themselves or in brackets at their end."""
    for word in words:
        unit = unit_of(word)
        if column.units.get(unit, column.factor) != column.factor:
            given = next(name for name, factor in column.units.items() if factor == column.factor)
            raise ResultError(path, f"the column {column.name} is in {unit} by what stands above it, not in {given}")


def read_text(path):
    """Returns a file's text, in UTF-8, in UTF-16 with its mark, or as older programs for Windows write it."""
    try:
        content = Path(path).read_bytes()
    except OSError as problem:
        raise ResultError(path, f"cannot be read as text ({problem.strerror})") from None
    for encoding in ("utf-16",) if content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else ("utf-8-sig", "cp1252"):
        try:
            return content.decode(encoding)
        except ValueError:
            pass
    raise ResultError(path, "cannot be read as text (no text)")


def mark_of(line):
    """Returns what parts the columns of a line; None for spaces."""
    return next((mark for mark in ";\t," if mark in line.strip()), None)


def words_of(line, mark):
    """Returns the columns of a line; a mark within quotes that close parts nothing."""
    words = line.split(mark)
    if mark and '"' in line and line.count('"') % 2 == 0 and len(line) < csv.field_size_limit():
        [words] = csv.reader([line], delimiter=mark, skipinitialspace=True)
    return [word.strip().strip('"') for word in words]


def to_number(word, mark):
    """Returns the number that a word is, or None where it is none, or none that a curve may have."""
    try:
        number = float(word.replace(",", ".") if mark in (";", "\t") else word)
    except ValueError:
        return None
    return number if abs(number) < LARGEST else None


def is_row(words, mark):
    """Whether at least two of the words are numbers: a depth and a load."""
    return sum(to_number(word, mark) is not None for word in words) >= 2


def row_of(path, number, words, mark, places, count):
    """Returns the numbers in some places of a line."""
    row = [to_number(words[place], mark) if place < len(words) else None for place in places]
    if None in row:
        place = places[row.index(None)]
        there = repr(words[place]) if place < len(words) else "nothing"
        raise ResultError(path, f"line {number} is no row of numbers: it has {there} in column {place + 1}")
    if len(words) != count:
        raise ResultError(path, f"line {number} has {len(words)} columns instead of {count}")
    return row


def place_of(path, names, name, count):
    """Returns the place of a column by its name, to upper and lower case, or by its number."""
    for words in reversed(names):
        matches = [k for k, word in enumerate(words[:count]) if word.lower() == name.lower()]
        matches = matches or [k for k, word in enumerate(words[:count]) if before_unit(word).lower() == name.lower()]
        if len(matches) == 1 or matches and words[matches[0]].lower() == name.lower():
            return matches[0]
    if re.fullmatch(r"\d+", name) and 1 <= int(name) <= count:
        return int(name) - 1
    heads = [words for words in names if len(words) > 1 and not all(unit_of(before_unit(word) or word) in UNITS for word in words)]
    known = f"; there are {', '.join(heads[-1])}" if heads else f"; columns have no names, only numbers 1 to {count}"
    raise ResultError(path, f"there is no column {name}{known}")


# ---- cycles ----

def noise(values):
    """Returns the standard deviation of what changes from row to row."""
    return 1.4826 * np.median(np.abs(np.diff(values, 3))) / math.sqrt(20) if len(values) > 3 else 0.0


def without_spikes(load):
    """Returns running medians over SPIKE rows, fewer in a curve of few."""
    half = min(SPIKE, len(load) // 20) // 2
    return np.median(np.lib.stride_tricks.sliding_window_view(np.pad(load, half, mode="edge"), 2 * half + 1), axis=1)


def find_cycles(curve):
    """Returns the Cycles of a curve: the load falls by FALL while the tip goes back, to a lowest value."""
    depth, load = curve.depth, without_spikes(curve.load)
    quiet, begin, found = 3 * noise(depth), 0, []
    for top, valley in peaks_and_valleys(load):
        if load[top] < max(LEAST_LOAD * load.max(), 10 * noise(load)):
            continue
        highest = depth[begin:valley + 1].max()
        rest = quiet + 1e-6 * abs(highest)
        start = begin + np.flatnonzero(depth[begin:valley + 1] >= highest - rest)[-1]
        if depth[valley] < depth[start] - rest and start < valley:
            check_loading(curve, begin, start, first=not found)
            found.append(Cycle(begin, start, valley, rows_at_rest(depth, begin, start, rest)))
            begin = valley
    if not found:
        raise ResultError(curve.name, f"there is no unloading: the load never falls by {100 * FALL:.0f} % while the tip goes back")
    return found


def check_loading(curve, begin, start, first):
    """Refuses an unloading that begins with no loading before it."""
    if first and curve.load[begin:start + 1].min() > 0.5 * curve.load[start]:
        raise ResultError(curve.name, "there is an unloading without a loading: the curve begins at more than half its load")


def rows_at_rest(depth, begin, start, rest):
    """Returns the last third of the rows up to start, at least one, in which the depth does not change but for noise."""
    moving = np.flatnonzero(np.abs(depth[begin:start + 1] - depth[start]) > 2 * rest)
    first = begin + (moving[-1] + 1 if len(moving) else 0)
    return slice(start - (start - first) // 3, start + 1)


def peaks_and_valleys(load):
    """Yields (row of a peak, row of the lowest load after it), where the load falls by FALL and rises again by RISE or ends."""
    top = bottom = 0
    falling = False
    for row, value in enumerate(load):
        if falling and value > load[bottom] + RISE * load[top]:
            yield top, bottom
            top, falling = row, False
        elif falling:
            bottom = row if value < load[bottom] else bottom
        elif value >= load[top]:
            top = row
        elif value < (1 - FALL) * load[top]:
            bottom, falling = row, True
    if falling:
        yield top, bottom
