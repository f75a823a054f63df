"""Tables in the texts of instruments: how a text is encoded, what parts its columns, how numbers are written, and several tests in
one file."""

import codecs
import csv
import functools
import itertools
import math
import re
import sys
import unicodedata
from collections import namedtuple
from pathlib import Path
from statistics import mode

import numpy as np

from .errors import ResultError
from .heads import STIFFNESS_UNITS, TIME_UNITS, Heads, heads_of

MARKS = (";", "\t", "|", ",", None)  # what may part columns; None: blanks
SAMPLE = 1000  # lines that are enough to see how a text is written
BINARY = 0.05  # of a text: control characters, which a third of the bytes of any other file are
LARGEST = 1e100  # number in a file, whose square is one too
LEAST_ROWS = 10  # of a test
JUMP = 3  # times the largest step of the depth between two rows: by more it goes back where another test begins
SURFACE = 0.05  # of the largest depth: less deep a test may begin

Line = namedtuple("Line", "number text words")
Line.__doc__ = "A line of a file: its number from 1 on, its text and its columns."

Test = namedtuple("Test", "places lines")
Test.__doc__ = "A test in a file: places of the columns that are asked for, and its Lines from the first row on, rows and others."


# ---- texts ----

def read_bytes(path):
    """Returns what is in a file."""
    try:
        return Path(path).read_bytes()
    except OSError as problem:
        raise ResultError(path, f"cannot be read as text ({problem.strerror})") from None


def decoded(path, content):
    """Returns bytes as text, in UTF-8, in UTF-16 with or without its mark, or as older programs for Windows write it."""
    for encoding in encodings_of(content):
        try:
            text = content.decode(encoding)
        except ValueError:
            continue
        if sum(unicodedata.category(letter) == "Cc" and letter not in "\t\n\r" for letter in text[:SAMPLE]) <= BINARY * min(len(text), SAMPLE):
            return text
    raise ResultError(path, "cannot be read as text (no text): export the test as text or as a workbook")


def encodings_of(content):
    """Returns the encodings that the first bytes of a text allow, the likeliest first; digits in UTF-16 have a zero on one side."""
    if content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return ("utf-16",)
    start = content[:SAMPLE]
    if 0 in start:
        return ("utf-16-le",) if start[1::2].count(0) > start[::2].count(0) else ("utf-16-be",)
    return "utf-8-sig", "cp1252", "latin-1"


def lines_of(path, text):
    """Returns the lines of a text, and what parts their columns. Lines are without blanks around them, and without # or % before."""
    texts = [line.strip(" \r\0").lstrip("#%") for line in re.split("\r\n|\n|\r", text)]
    sample = [text for text in texts if text.strip()]
    if not sample:
        raise ResultError(path, "is empty")
    return texts, mark_of(sample[::max(1, len(sample) // SAMPLE)])


def mark_of(texts):
    """Returns what parts the columns of a table: with it most lines are rows, and of these most words are numbers."""
    def rows_and_numbers(mark):
        lines = [words_of(text, mark) for text in texts]
        numerals = Numerals.of(lines)
        numbers = [sum(numerals.read(word) is not None for word in words) for words in lines]
        rows = [(len(words), count) for words, count in zip(lines, numbers) if count >= 2]
        width = mode(width for width, _ in rows) if rows else 0
        share = np.mean([count / width for own, count in rows if own == width]) if rows else 0
        return sum(own == width for own, _ in rows), share
    return max(MARKS, key=rows_and_numbers)


def words_of(text, mark):
    """Returns the columns of a line; a mark within quotes that close parts nothing."""
    quoted = '"' in text and text.count('"') % 2 == 0 and len(text) < csv.field_size_limit()
    if mark is None:
        words = [inside or word for inside, word in re.findall(r'"([^"]*)"|(\S+)', text)] if quoted else text.split()
    elif quoted:
        [words] = csv.reader([text], delimiter=mark, skipinitialspace=True)
    else:
        words = text.split(mark)
    return [word.strip().strip('"').strip() for word in words]


# ---- numbers ----

class Numerals:
    """How numbers are written: what parts fractions, and what parts thousands, which may be a comma, a dot or nothing."""

    LIKE = re.compile(r"[+-]?[\d.,]*\d[.,]?(?:[eEdD][+-]?\d+)?")  # a number with commas and dots

    def __init__(self, decimal=".", thousands=""):
        self.decimal, self.thousands = decimal, thousands
        self.groups = re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(thousands)}\d{{3}})+(?:{re.escape(decimal)}\d*)?(?:[eE][+-]?\d+)?")

    @classmethod
    def of(cls, lines):
        """Returns the Numerals of a table [lines][words].

        A number with both marks says which is which, and so does one with a mark twice. Else commas part fractions, but for those
        that part three digits each time where other numbers have dots.
        """
        found = [[word for word in words if cls.LIKE.fullmatch(usual(word))] for words in lines]
        numbers = [word for words in found if len(words) >= 2 for word in words]
        english, others = cls(".", ","), cls(",", ".")
        for style in (english, others):
            if any(word.count(style.thousands) > (style.decimal not in word) and style.is_grouped(word) for word in numbers):
                return style
        commas, dots = ([word for word in numbers if mark in word] for mark in ",.")
        return english if commas and dots and all(map(english.is_grouped, commas)) else cls("," if commas else ".")

    def is_grouped(self, word):
        """Whether a number has its thousands parted."""
        return self.thousands in word and self.groups.fullmatch(word) is not None

    def read(self, word):
        """Returns the number that a word is, or None where it is none, or none that a curve may have."""
        for spelling in (lambda: word, lambda: usual(word)):
            text = spelling()
            if self.thousands and self.is_grouped(text):
                text = text.replace(self.thousands, "")
            try:
                number = float(text.replace(self.decimal, "."))
            except ValueError:
                continue
            return number if abs(number) < LARGEST else None
        return None


def usual(word):
    """Returns a number as Python writes it, from one with Fortran's D, another minus, or blanks or apostrophes between thousands."""
    word = re.sub(r"(?<=\d)['\N{RIGHT SINGLE QUOTATION MARK}\s](?=\d{3}(?!\d))", "", word.replace("\N{MINUS SIGN}", "-"))
    return re.sub(r"(?<=[\d.,])[dD](?=[+-]?\d)", "e", word)


# ---- tests ----

def split(texts, mark):
    """Returns the Lines of texts, and how numbers in them are written, as Numerals."""
    lines = [Line(number, text, words_of(text, mark)) for number, text in enumerate(texts, start=1)]
    return lines, Numerals.of([line.words for line in lines])


def is_row(words, numerals):
    """Whether words are a row of numbers: at least two of them are."""
    return sum(numerals.read(word) is not None for word in words) >= 2


def tests_of(path, lines, mark, numerals, wanted):
    """Returns the tests in a file's Lines, each as a function without arguments that returns the numbers in some Columns times their factors,
    [rows][columns], with a list of notes, or raises a ResultError.

    Names and units may stand above the rows, also behind # or %; other columns may hold words, and lines of words may stand between
    and below the rows. Another test begins where behind such lines the depth, which is the first of the columns, jumps back or the
    time, the third, falls, and where the names come again and the depth does not go on from where it was.
    """
    are_numbers = [is_row(line.words, numerals) for line in lines]
    widths = [len(line.words) for line, good in zip(lines, are_numbers) if good]
    if not widths:
        raise no_rows(path, lines)
    table = Table(path, wanted, mark, numerals, mode(widths))
    rows = [good and len(line.words) == table.count for line, good in zip(lines, are_numbers)]
    check_commas(path, lines[:rows.index(True)], mark, table.count)
    for are_rows, group in itertools.groupby(zip(rows, lines), key=lambda pair: pair[0]):
        table.add(are_rows, [line for _, line in group])
    return [functools.partial(table.numbers_of, test) for test in table.finished()]


def check_commas(path, above, mark, count):
    """Refuses commas that part columns and fractions alike: rows of twice as many numbers, their count, as the Lines above have names."""
    heads = next((line.words for line in reversed(above) if line.text.strip()), [])
    if mark == "," and len(heads) > 1 and count == 2 * len(heads):
        raise ResultError(path, f"has {count} numbers in rows under {len(heads)} names: commas part columns and fractions alike; write it with semicolons or "
                                "tabs between columns, or with dots in numbers")


def no_rows(path, lines):
    """Returns the error for Lines of which none is a row of numbers."""
    last = [line for line in lines if line.text.strip()][-1]
    return ResultError(path, f"has 0 rows of numbers; line {last.number} has {' '.join(last.words)[:60]!r}, and not two numbers")


class Table:
    """Parts the lines of a file into tests; count: columns of its rows."""

    def __init__(self, path, wanted, mark, numerals, count):
        self.path, self.wanted, self.mark, self.numerals, self.count = path, wanted, mark, numerals, count
        self.time = next((place for place, column in enumerate(wanted) if column.units is TIME_UNITS), None)
        self.tests, self.names, self.above = [], None, []
        self.unnamed = []  # (rows, lines of words above them) of what stands before the first names
        self.step, self.deepest, self.last = 0.0, 0.0, None  # of the depth in the present test; and the numbers of its last row

    def add(self, are_rows, lines):
        """Takes lines that are all rows or all others."""
        if not are_rows:
            self.above = lines
            return
        words = [heads_of(line, self.mark, self.count) for line in self.above if line.text.strip()]
        heads = Heads.of(words, self.wanted)
        by_name = not all(column.name.isdigit() for column in self.wanted)
        if by_name and not heads and not self.tests:
            self.unnamed.append((len(lines), words))
        elif not self.tests or self.is_another(lines, heads and (by_name or heads.names == self.names)):
            self.begin(heads or (Heads() if not self.tests else None), lines)
        else:
            self.tests[-1].lines.extend([*self.above, *lines])
            self.follow(lines)
        self.above = []

    def begin(self, heads, lines):
        """Begins a test under Heads, or where they are None with the columns of the last one."""
        places = [heads.place_of(self.path, column, self.count) for column in self.wanted] if heads else self.tests[-1].places
        self.names = heads.names if heads and not self.tests else self.names
        self.tests.append(Test(places, list(lines)))
        self.step, self.deepest, self.last = 0.0, 0.0, None
        self.follow(lines)

    def follow(self, lines):
        """Keeps the largest step of the depth, the largest depth and the last row."""
        rows = [values for values in map(self.values_of, lines) if None not in values]
        depths = [values[0] for values in ([self.last] if self.last else []) + rows]
        self.step = max([self.step, *np.abs(np.diff(depths))])
        self.deepest = max([self.deepest, *depths])
        self.last = rows[-1] if rows else self.last

    def is_another(self, lines, named):
        """Whether lines are of another test than the last row; named: whether the names of the columns stand above them again."""
        values = next((values for values in map(self.values_of, lines) if None not in values), None)
        if values is None or self.last is None:
            return bool(named)
        back, far = self.last[0] - values[0], JUMP * self.step
        jumps = len(self.tests[-1].lines) >= LEAST_ROWS and (back > far or self.time is not None and values[self.time] < self.last[self.time])
        goes_on = abs(back) <= far and values[0] > SURFACE * self.deepest
        return jumps or bool(named) and not goes_on

    def finished(self):
        """Returns all Tests, of which the last has the lines behind the last row."""
        if not self.tests:
            rows, words = max(self.unnamed, key=lambda pair: pair[0])
            heads = Heads.of(words, []) or Heads()
            for column in self.wanted:
                heads.place_of(self.path, column, self.count)
            raise ResultError(self.path, "the columns do not have their names in one line; choose them by their numbers")
        self.tests[-1].lines.extend(self.above)
        return self.tests

    def values_of(self, line, places=None):
        """Returns the numbers of a Line in some places, by default those of the present test; None for what is none, but NaN for a stiffness,
        which instruments have in some rows alone."""
        values = [self.numerals.read(line.words[place]) if place < len(line.words) else None for place in places or self.tests[-1].places]
        return [math.nan if value is None and column.units is STIFFNESS_UNITS and len(line.words) == self.count else value
                for value, column in zip(values, self.wanted)]

    def numbers_of(self, test):
        """Returns the numbers of a Test times the factors of the columns, [rows][columns], and notes on what is left out."""
        rows, others = [], []
        for line in test.lines:
            values = self.values_of(line, test.places)
            if None not in values and len(line.words) == self.count:
                rows.append(values)
            elif is_text(line, test.places):
                others += [line] if line.text.strip() else []
            else:
                raise self.refusal(line, values, test.places)
        if others and not rows:
            raise self.refusal(others[0], self.values_of(others[0], test.places), test.places)
        if len(rows) < LEAST_ROWS:
            raise ResultError(self.path, f"has {len(rows)} rows of numbers; a curve needs at least {LEAST_ROWS}")
        return np.array(rows) * [column.factor for column in self.wanted], notes_on(others)

    def refusal(self, line, values, places):
        """Returns the error for a Line that is neither a row nor text."""
        if None not in values:
            return ResultError(self.path, f"line {line.number} has {len(line.words)} columns instead of {self.count}")
        place = places[values.index(None)]
        there = repr(line.words[place]) if place < len(line.words) else "nothing"
        return ResultError(self.path, f"line {line.number} is no row of numbers: it has {there} in column {place + 1}")


def is_text(line, places):
    """Whether a Line is none that should have been a row: words stand in one of the places, or no digit stands in any."""
    there = [line.words[place] for place in places if place < len(line.words)]
    return any(map(is_word, there)) or not any(re.search(r"\d|nan|inf", word, re.I) for word in there)


def is_word(text):
    """Whether a text has letters and is no number, not even one that is not finite; the largest double stands for no value."""
    try:
        if float(text) == sys.float_info.max:
            return True
    except ValueError:
        return re.search(r"[^\W\d_]", usual(text)) is not None
    return False


def notes_on(others):
    """Returns a list with a note on Lines that are left out, if there are some."""
    count = f"{len(others)} line" + "s" * (len(others) > 1)
    return [f"left out between or below the rows: {count} without numbers (line {each.number}, {each.text.strip()[:40]!r})" for each in others[:1]]
