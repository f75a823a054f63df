"""Files of instruments, known by what is in them: the sheets or texts that hold tests, and what their heads say of tip, drift and frame."""

import re
from collections import namedtuple

from . import tables, tips, workbooks
from .errors import ResultError

Source = namedtuple("Source", "name lines mark numerals facts")
Source.__doc__ = """A text of a file, or a sheet of a workbook, by its name (None where it is the whole file): its Lines, what parts columns, how
numbers are written, and the Facts of its head."""

Facts = namedtuple("Facts", "instrument tip units columns notes", defaults=(None, None, {}, None, []))
Facts.__doc__ = """What the head of a file says: the instrument; its Tip; units of columns that do not say theirs, {"depth": unit}; the numbers of
the columns depth, load and time of a file without names; and notes. None or nothing where it does not say."""

HEAD = 400  # lines in which the head of a file is looked for
PAIR = re.compile(r"\s*([^:=\t(]*[^:=\t\s(])\s*(?:\(([^)]*)\))?\s*[:=\t]\s*([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*(\S*)\s*$")
OWN = re.compile(r"(H|E)_?it.*|HM|HVit|E\*|Er|S|h_?(m|max|c|p|r)|F_?m(ax)?|epsilon|m", re.I)  # results by the names of the norm
TEST_SHEET = re.compile(r"\s*test(?![a-z])", re.I)  # of NanoSuite; its other sheets are tables of results


# ---- sheets and texts ----

def sources(path):
    """Returns the Sources of a file, those of a workbook in the order of the numbers in their names."""
    content = tables.read_bytes(path)
    if not workbooks.is_workbook(content):
        texts, mark = tables.lines_of(path, tables.decoded(path, content))
        return [source(None, texts, mark)]
    sheets = [(name, lines) for name, lines in workbooks.lines_of_sheets(path, content) if any(line.strip() for line in lines)]
    tests = [sheet for sheet in sheets if TEST_SHEET.match(sheet[0])] or sheets
    if not tests:
        raise ResultError(path, "has no sheet with numbers")
    return [source(name, lines, "\t") for name, lines in sorted(tests, key=lambda sheet: in_order(sheet[0]))]


def in_order(name):
    """Returns a key that puts test 2 before test 10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]


def source(name, texts, mark):
    """Returns the Source of lines of text, from the head of the test on, where an instrument has other tables above it."""
    lines, numerals = tables.split(texts, mark)
    return Source(name, lines, mark, numerals, facts_of(lines, mark, numerals))


# ---- what heads say ----

def facts_of(lines, mark, numerals):
    """Returns the Facts of a text: those of the instrument that it is of, if that is known."""
    first = next((number for number, line in enumerate(lines) if len(line.words) > 2 and tables.is_row(line.words, numerals)), len(lines))
    head = [line.text for line in lines[:min(first, HEAD)]]
    given = pairs(head, numerals)
    if "Tip C0" in given and "Machine Comp" in given:
        return of_hysitron(given)
    if "Tip radius" in given and "k" in given:
        return of_optics11(given)
    if any("Name of the application" in text for text in head[:3]) or any(text.startswith("Indenter shape correction") for text in head):
        return Facts("Fischerscope", units={"depth": "um", "load": "mN", "time": "s"})
    if is_nanotest(lines, mark, numerals):
        return Facts("NanoTest", units={"depth": "nm", "load": "mN", "time": "s"}, columns=("2", "3", "1"),
                     notes=["without names of columns it is read as a NanoTest's: time in s, depth in nm, load in mN"])
    own = ", ".join(f"{name} {number:g} {unit}".rstrip() for name, (number, unit) in given.items() if OWN.fullmatch(name))
    return Facts(notes=[f"the instrument's own figures: {own}"] * bool(own))


def pairs(head, numerals):
    """Returns {name: (number, unit)} of the lines `name (unit): number unit` of a head."""
    found = {}
    for match in filter(None, map(PAIR.match, head)):
        number = numerals.read(match[3])
        if number is not None:
            found.setdefault(match[1].strip(), (number, match[2] or match[4]))
    return found


def of_hysitron(given):
    """Returns the Facts of a Hysitron .hld, whose area function is in nm.

    Frame and drift are off its displacements already: in a public file these are the displacements of the sensor's voltage by the head's
    polynomial, less the load times (load cell + 1.0 Machine Comp), less 1.1 Drift Rate times the time, to 0.03 nm.
    """
    coefficients = [given.get(f"Tip C{k}", (0.0, ""))[0] for k in range(6)]
    tip = tips.tip_of_function(coefficients, largest=given.get("Tip Usable Depth", (0.0, ""))[0]) if any(coefficients) else None
    frame, drift = 1e3 * given["Machine Comp"][0], given.get("Drift Rate", (0.0, ""))[0]
    notes = [f"the file's head has a frame of {frame:.4g} nm/mN and a drift of {drift:.4g} nm/s, which are off its displacements already"]
    return Facts("Hysitron", tip, notes=notes + ["its head has an area function, which is that of the tip unless another is given"] * bool(tip))


def of_optics11(given):
    """Returns the Facts of a Piuma or Chiaro: a ball whose radius is in the head; its Indentation is without the cantilever."""
    radius = given["Tip radius"][0]
    tip = tips.make_tip("sphere", radius=radius) if tips.RULES["radius"].good(radius) else None
    return Facts("Optics11", tip, notes=[f"its head has a ball with a radius of {radius:g} um, which is the tip unless another is given"] * bool(tip))


def is_nanotest(lines, mark, numerals):
    """Whether a text is the export of a NanoTest: three columns without names, parted by tabs, a time that begins at zero and does not
    fall, as rows of the approach have zero, and depths below zero in its first rows."""
    rows = [[numerals.read(word) for word in line.words] for line in lines if line.text.strip()]
    if mark != "\t" or len(rows) < tables.LEAST_ROWS or any(len(row) != 3 or None in row for row in rows):
        return False
    times = [row[0] for row in rows]
    return times[0] == 0 and all(a <= b for a, b in zip(times, times[1:])) and min(row[1] for row in rows[:tables.LEAST_ROWS]) < 0
