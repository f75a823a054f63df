"""Columns of instruments' files by what their heads mean: which one is the depth, the load, the time and the
stiffness, and in which unit."""

import re
import unicodedata
from collections import namedtuple

from . import tables
from .errors import ResultError
from .heads import DEPTH_UNITS, LOAD_UNITS, STIFFNESS_UNITS, TIME_UNITS, Column, heads_of, is_units, name_and_unit

UNITS_OF = {"depth": DEPTH_UNITS, "load": LOAD_UNITS, "time": TIME_UNITS, "stiffness": STIFFNESS_UNITS}
NAMES = {  # in English, German and French without accents; of several columns that with the earlier name counts
    "depth": (("displacement into surface",),
              ("penetration depth", "indentation depth", "penetration", "indentation", "pd", "eindringtiefe", "profondeur de penetration",
               "profondeur d indentation", "profondeur d enfoncement", "enfoncement", "eindringweg", "indentationstiefe"),
              ("depth", "h", "tiefe", "profondeur", "pen depth", "indent disp"),
              ("displacement", "disp", "weg", "verschiebung", "deplacement", "normal displacement", "indenter displacement", "tip displacement",
               "normal disp")),
    "load": (("load on sample", "force on surface"),
             ("load", "force", "fn", "f", "p", "normal force", "normal load", "indentation load", "indent load", "indentation force", "test force",
              "test load", "applied load", "applied force", "kraft", "last", "normalkraft", "prufkraft", "force normale", "force appliquee",
              "charge", "effort", "force a")),
    "time": (("time on sample", "time in contact", "test time"),
             ("time", "t", "zeit", "prufzeit", "messzeit", "temps", "elapsed time", "sampling time", "duree")),
    "stiffness": (("harmonic contact stiffness",), ("contact stiffness", "dynamic contact stiffness", "kontaktsteifigkeit", "raideur de contact")),
}
SYMBOLS = {"depth": {"h", "pd"}, "load": {"f", "p", "fn"}, "time": {"t"}, "stiffness": {"s"}}  # which may stand behind a name: Load F, Depth h
QUALIFIED = {"corrected", "corr", "korrigiert", "corrigee"}  # words that change nothing of what a name means
LOOK_BELOW = 4  # lines below the names in which a row of numbers must come: one of units, and blank ones

Found = namedtuple("Found", "line sets notes")
Found.__doc__ = """The line of the names (its place among the Lines), for each of the tests beside each other, mostly one, the Columns depth, load
and, if there are some, time and stiffness, and notes on them."""


def bare(name):
    """Returns the letters of a name, small, without accents, and with single blanks between words."""
    letters = "".join(letter for letter in unicodedata.normalize("NFKD", name.casefold()) if not unicodedata.combining(letter))
    return " ".join(re.findall(r"[^\W_]+", letters.replace("ß", "ss")))


def rank(what, name):
    """Returns how well a name means depth, load or time, the least being the best; None where it does not."""
    words = [word for word in bare(name).split() if word not in QUALIFIED]
    if len(words) > 1 and words[-1] in SYMBOLS[what]:
        words = words[:-1]
    return next((place for place, names in enumerate(NAMES[what]) if " ".join(words) in names), None)


def places_of(what, names, units):
    """Returns the places of the columns that mean depth, load or time best, of those whose unit is one of it or is not known."""
    ranks = {place: rank(what, name) for place, (name, unit) in enumerate(zip(names, units)) if not unit or unit in UNITS_OF[what]}
    ranks = {place: value for place, value in ranks.items() if value is not None}
    with_unit = {place: value for place, value in ranks.items() if units[place]} or ranks
    return [place for place, value in with_unit.items() if value == min(with_unit.values())]


def find(path, source, asked):
    """Returns the Found of a Source: the first line that names a depth and a load with rows of numbers below it.

    asked: {"depth": Column, ...} of what the caller names. Raises a ResultError where there is no such line, or where the heads leave open
    which column or which unit it is.
    """
    lines = source.lines

    def is_row(words):
        return tables.is_row(words, source.numerals)
    for number, line in enumerate(lines):
        below = [each for each in lines[number + 1:number + 1 + LOOK_BELOW] if each.text.strip()]
        rows = [each for each in below if is_row(each.words)]
        if not rows or len(line.words) < 2 or is_row(line.words):
            continue
        heads = heads_of(line, source.mark, len(rows[0].words))
        pairs = [name_and_unit(word) for word in heads]
        row_of_units = next((each.words for each in below if is_units(each.words)), [])
        units = [unit if name else "" for name, unit in pairs]
        units = [unit or name_and_unit(row_of_units[place])[1] if place < len(row_of_units) else unit for place, unit in enumerate(units)]
        names = [name or word for (name, _), word in zip(pairs, heads)]
        places = {what: places_of(what, names, units) for what in NAMES if what not in asked}
        if any(not units[place] for place in places.get("stiffness", [])) or len(places.get("stiffness", [])) > 1:
            del places["stiffness"]  # it must be named
        if all(places.get(what, True) for what in ("depth", "load")):
            sets, notes = chosen(path, heads, units, places, source.facts.units)
            return Found(number, [[{**columns, **asked}[what] for what in NAMES if what in columns or what in asked] for columns in sets], notes)
    first = next((number for number, line in enumerate(lines) if is_row(line.words)), None)
    if first is None:
        raise tables.no_rows(path, lines)
    above = [line.words for line in lines[:first] if len(line.words) > 1 and not is_units(line.words)]
    there = ", ".join(above[-1])[:120] if above else f"only numbers 1 to {len(lines[first].words)}"
    raise ResultError(path, f"no columns of depth and load are known by their names; there are {there}: choose them by --depth and --load COLUMN:UNIT")


def chosen(path, heads, units, places, usual):
    """Returns [{"depth": Column, ...} of each test beside the others], mostly one, from the places of the names that mean depth, load and
    perhaps time, and notes."""
    tests = tests_beside(places)
    for what, found in places.items():
        if len(found) > 1 and len(tests) == 1 and what != "time":
            several = ", ".join(f"{heads[place]} in column {place + 1}" for place in found)
            raise ResultError(path, f"{len(found)} columns may be the {what}: {several}; choose one by --{what} COLUMN:UNIT")
    notes = [f"{len(tests)} tests stand beside each other"] * (len(tests) > 1)
    unit_of = {}
    for what, place in tests[0].items():
        unit = units[place] or usual.get(what) or {"depth": "um", "load": "mN"}.get(bare(heads[place])) or ("s" if what == "time" else "")
        if not unit:
            raise ResultError(path, f"no unit stands above the column {heads[place]}: say it by --{what} {heads[place]}:UNIT, "
                                    f"UNIT of {', '.join(UNITS_OF[what])}; there are {', '.join(heads)[:200]}")
        if not units[place] and not usual:
            notes.append(f"no unit stands above the column {heads[place]}: it is taken in {unit}")
        unit_of[what] = unit
    return [{what: column(heads, place, what, unit_of[what]) for what, place in test.items()} for test in tests], notes


def tests_beside(places):
    """Returns the places of each test, [{"depth": place, ...}]: of several, where columns of depth and load take turns, with as many of a time
    or one for all; else of one test."""
    depths, loads, times = (places.get(what, []) for what in ("depth", "load", "time"))
    count = len(depths)
    first, second = sorted((depths, loads))
    if count > 1 and count == len(loads) and all(a < b for a, b in zip(first, second)) and all(a < b for a, b in zip(second, first[1:])):
        times = times if len(times) == count else count * times[:1]
        return [{what: found[k] for what, found in (("depth", depths), ("load", loads), ("time", times)) if found} for k in range(count)]
    return [{what: found[0] for what, found in places.items() if found}]


def column(heads, place, what, unit):
    """Returns the Column of a place, by its name where no other has that."""
    name = heads[place] if heads.count(heads[place]) == 1 else str(place + 1)
    return Column(name, UNITS_OF[what][unit], UNITS_OF[what])
