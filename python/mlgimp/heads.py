"""Columns of tables: those that a caller asks for as COLUMN:UNIT, and the names and units that stand above the rows."""

import re
from collections import namedtuple

from .errors import Error, ResultError

DEPTH_UNITS = {"nm": 1e-3, "um": 1.0, "mm": 1e3, "m": 1e6, "A": 1e-4}  # in um
LOAD_UNITS = {"nN": 1e-6, "uN": 1e-3, "mN": 1.0, "N": 1e3, "kN": 1e6}  # in mN
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}  # in s
STIFFNESS_UNITS = {"N/m": 1e-3, "mN/um": 1.0, "uN/nm": 1.0, "N/mm": 1.0, "kN/m": 1.0, "mN/nm": 1e3, "N/um": 1e3, "MN/m": 1e3}  # in mN/um
OTHER_UNITS = ("V", "mV", "uV", "Hz", "Pa", "kPa", "MPa", "GPa", "nm/s", "um/s", "mN/s", "%", "C", "K", "#", "-")
LONGER = {"sec": "s", "sec.": "s", "seconds": "s", "micron": "um", "microns": "um",  # other names of units
          "?N": "uN", "?m": "um", "\N{REPLACEMENT CHARACTER}N": "uN", "\N{REPLACEMENT CHARACTER}m": "um"}  # only mu is a letter that gets lost
UNITS = {*DEPTH_UNITS, *LOAD_UNITS, *TIME_UNITS, *STIFFNESS_UNITS, *OTHER_UNITS}
SPELT = {"\N{MICRO SIGN}": "u", "\N{GREEK SMALL LETTER MU}": "u", "\N{LATIN CAPITAL LETTER A WITH RING ABOVE}": "A",
         "\N{ANGSTROM SIGN}": "A", "\N{LATIN CAPITAL LETTER A WITH CIRCUMFLEX}": "",  # of a micro sign in UTF-8 that was read as Latin-1
          "\N{NO-BREAK SPACE}": " ", "\N{NARROW NO-BREAK SPACE}": " "}

Column = namedtuple("Column", "name factor units", defaults=({},))
Column.__doc__ = """A column of a file: name, or number from 1 on; values x factor are in the units of a Curve; factors by unit, of which
the file must not name one with another factor."""


# ---- columns that a caller asks for ----

def column_argument(units):
    """Returns a function that reads COLUMN:UNIT; a Column stays what it is."""
    def read(text):
        if isinstance(text, Column):
            return text
        if not isinstance(text, str):
            raise ValueError("must be a text COLUMN:UNIT")
        name, _, unit = text.rpartition(":")
        if not name or plain(unit) not in units:
            raise ValueError(f"must be COLUMN:UNIT with a unit of {', '.join(units)}")
        return Column(name, units[plain(unit)], units)
    return read


def column_of(name, given, units):
    """Returns the Column that a caller gives as COLUMN:UNIT, or as a Column."""
    try:
        return column_argument(units)(given)
    except ValueError as problem:
        raise Error(f"{name}={given}: {problem}") from None


def unit_of_column(column):
    """Returns the unit that a caller has given to a Column."""
    return next((name for name, factor in column.units.items() if factor == column.factor), "")


# ---- names and units above the rows ----

BRACKETS = re.compile(r"(.*?)[(\[{<]([^(\[{<]*)[)\]}>]")
BEHIND = re.compile(rf"(.+?)(?:\s*[/,]\s*|\s+in\s+)({'|'.join(map(re.escape, sorted(UNITS, key=len, reverse=True)))})")
BEFORE_NAME = re.compile(r"\s+(?![(\[]|(?:[num]?m|[numk]?N|m?s)(?:\s|$))")
AFTER_BLANK = re.compile(r"(.+?)[\s_]+(nm|um|mm|m|nN|uN|mN|kN|N|ms|us|min|s)")  # not A and h, which are letters of names as well


def plain(text):
    """Returns names or units in plain letters: u for mu, A for the letter of Angstrom."""
    return "".join(SPELT.get(letter, letter) for letter in text).strip()


def name_and_unit(word):
    """Returns what stands in a head before its unit, and the unit: of Depth (nm), Depth/nm, Depth in nm, Depth_nm and Depth, nm."""
    word = plain(word)
    found = next(filter(None, (kind.fullmatch(word) for kind in (BRACKETS, BEHIND, AFTER_BLANK))), None)
    if found:
        return found[1].strip(" ,;:_/"), LONGER.get(found[2].strip(), found[2].strip())
    return ("", LONGER.get(word, word)) if word in UNITS or word in LONGER else (word, "")


def is_units(words):
    """Whether a line has units alone, by themselves or in brackets, or mostly such units as are no names of columns."""
    pairs = [name_and_unit(word) for word in words if word]
    units = [unit for name, unit in pairs if not name and unit in UNITS]
    return bool(pairs) and (len(units) == len(pairs) or 2 * sum(len(unit) > 1 for unit in units) > len(pairs))


def heads_of(line, mark, count):
    """Returns the words of a line above the rows; between blanks, a name that has blanks itself is parted by two of them or by its
    unit, if that gives as many words as the rows have."""
    if mark is not None or len(line.words) == count:
        return line.words
    text = re.sub(r"\s*/\s*", "/", plain(line.text))
    ways = [re.split(between, text) for between in (r"\t+|\s{2,}", r"\s*[,;]\s*", BEFORE_NAME, r"(?<=[)\]])\s+")]
    return next((words for words in ways if len(words) == count), line.words)


def matches(words, name):
    """Returns the places of a name among heads, to upper and lower case: those of its full spelling, else those before a unit."""
    wanted, plains = plain(name).lower(), [plain(word).lower() for word in words]
    return ([k for k, word in enumerate(plains) if word == wanted]
            or [k for k, word in enumerate(words) if name_and_unit(word)[0].lower() == wanted])


class Heads:
    """The line of names above the rows, with a line of units below it, if there are such lines."""

    def __init__(self, names=(), units=()):
        self.names = list(names)
        self.units = [unit if name else "" for name, unit in map(name_and_unit, self.names)]  # a depth may be called h
        for place, word in enumerate(units[:len(self.units)]):
            self.units[place] = self.units[place] or name_and_unit(word)[1]

    @classmethod
    def of(cls, lines, wanted):
        """Returns the Heads of the lowest of some lines of words that has all Columns that are asked for by name, or where none is, of
        the lowest that may be names; None where there is no such line."""
        by_name = [column for column in wanted if not column.name.isdigit()]
        for place, words in reversed(list(enumerate(lines))):
            if len(words) < 2 or is_units(words):
                continue
            if all(matches(words, column.name) for column in by_name) if by_name else not any(word[:1].isdigit() for word in words):
                return cls(words, next(filter(is_units, lines[place + 1:]), ()))
        return None

    def place_of(self, path, column, count):
        """Returns the place of a Column by its name or by its number; of several with the name that with its unit."""
        found = matches(self.names[:count], column.name)
        for fits in (lambda unit: column.units.get(unit) == column.factor, lambda unit: unit in column.units):
            chosen = [place for place in found if fits(self.units[place])]
            found = chosen if len(found) > 1 and len(chosen) == 1 else found
        if len(found) > 1:
            several = ", ".join(f"{self.names[place]} in column {place + 1}" for place in found)
            raise ResultError(path, f"there are {len(found)} columns {column.name}: {several}; choose one by its number")
        if not found and column.name.isdigit() and 1 <= int(column.name) <= count:
            found = [int(column.name) - 1]
        if not found:
            known = f"there are {', '.join(self.names)}" if self.names else f"columns have no names, only numbers 1 to {count}"
            raise ResultError(path, f"there is no column {column.name}; {known}")
        self.check_unit(path, column, found[0])
        return found[0]

    def check_unit(self, path, column, place):
        """Refuses a column of which the heads say another unit."""
        unit = self.units[place] if place < len(self.units) else ""
        if column.units and unit in UNITS and column.units.get(unit) != column.factor:
            raise ResultError(path, f"the column {column.name} is in {unit} by what stands above it, not in {unit_of_column(column)}")
