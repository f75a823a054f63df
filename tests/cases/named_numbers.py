"""Every number that steers a result has a name and a row in docs/decisions.md with its value and a test; claims have tests, too."""
import re
from fractions import Fraction

import pytest

import harness

pytestmark = pytest.mark.fast

PAGE = harness.ROOT / "docs" / "decisions.md"
MOST_ROWS = 60
# A comment that begins with one of these says that a number steers no result: what is left is of the size of rounding or
# converges before a cap; a size of storage, messages or samples, or speed alone; a value that mathematics or an equation gives.
MARK = re.compile(r"//[/<]*\s*(rounding|size|exact)\b")
NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
LITERAL = re.compile(rf"(?<![\w.])({NUMBER})(?![\w.])")
# Layers in which a number with a point or an exponent must have a name, but for factors of plain formulas.
NAMED_LAYERS = ("physics", "grid", "points", "surface", "contact", "level", "hierarchy")
ROUNDING = 1e-6  # numbers from here down are of the size of rounding
FACTORS = {"0.0", "0.25", "0.5", "1.0", "1.5", "2.0", "4.0"}
DECLARATION = re.compile(r"\bconst(?:expr)?\s+(?!bool\b|auto\b)[\w:<>, ]+?\s\**(?=k[A-Z]\w*(?:\[\])?\s*(?:=|\{))([^;]*);")
COMMENT = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.S)


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def value_of(text):
    """The number that an expression of literals is, else None."""
    plain = " ".join(text.split())
    return float(eval(plain)) if re.fullmatch(r"[\d.eE+\-*/() ]+", plain) else None


class Source:
    """A file of the sources: its room, named constants and other literals."""

    def __init__(self, path):
        self.path = path
        self.room = "/".join(path.relative_to(harness.ROOT).parts[1:-1])
        self.lines = path.read_text().split("\n")
        self.text = COMMENT.sub(blank, path.read_text())

    def line(self, place):
        return self.text.count("\n", 0, place)

    def marked(self, first, last):
        """Whether the lines, or the comment before them, say that a number steers nothing."""
        before = self.lines[first - 1].strip() if first and self.lines[first - 1].strip().startswith("//") else ""
        return any(MARK.search(line) for line in (*self.lines[first:last + 1], before))

    def constants(self):
        """(name, value or None, line) of named numbers without a mark."""
        for found in DECLARATION.finditer(self.text):
            first, last = self.line(found.start()), self.line(found.end())
            if self.marked(first, last) or not LITERAL.search(found[1]):
                continue
            for name, value in re.findall(r"\b(k[A-Z]\w*)\s*(?:=|\{)((?:[^,(){}]|\([^()]*\)|\{[^{}]*\})*)", found[1]):
                if LITERAL.search(value):
                    yield name, value_of(value), first + 1

    def literals(self):
        """(text, line) of numbers with a point or an exponent that have neither name nor mark."""
        bare = DECLARATION.sub(blank, self.text)
        for found in LITERAL.finditer(bare):
            at = self.line(found.start())
            steers = found[1] not in FACTORS and float(found[1]) > ROUNDING
            if re.search(r"[.e]", found[1]) and steers and not self.marked(at, at):
                yield found[1], at + 1


def sources():
    return [Source(path) for folder in ("include", "src") for path in sorted((harness.ROOT / folder).rglob("*.[hc]pp"))]


def rows_of(text):
    """Rows of tables, each a list of cells."""
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in text.split("\n") if line.startswith("|")]
    return [row for row in rows if not set(row[0]) <= set("- ")]


def table(title):
    """Rows below a heading of the page."""
    part = re.search(rf"^## {title}\n(.*?)(?=^## |\Z)", PAGE.read_text(), re.M | re.S)[1]
    return [row for row in rows_of(part) if row[0] not in ("name", "choice")]


def steering():
    return table("Numbers that steer a result")


def advice():
    return table("Numbers of advice")


def names_of(row):
    """(name, room) of the constants in a row; options and functions have another form."""
    return [(name, room) for name in re.findall(r"`(k[A-Z]\w*)`", row[0]) for room in re.findall(r"`([\w/]+)`", row[1])]


def values_of(row):
    return [float(Fraction(a) / Fraction(b or "1")) for a, b in re.findall(rf"(?<![\w.])({NUMBER})(?:/(\d+))?", row[2])]


def test_named_numbers(expect):
    """Both ways, with their values."""
    page = steering() + advice()
    rows = {name: row for row in page for name in names_of(row)}
    expect("rows that steer a result", len(steering()), at_most=MOST_ROWS)
    missing, wrong, used = [], [], set()
    for source in sources():
        for name, value, line in source.constants():
            row = rows.get((name, source.room))
            used.add((name, source.room))
            if row is None:
                missing.append(f"{source.path.name}:{line} {name}")
            elif value is not None and not any(abs(value - seen) <= 1e-9 * abs(value) for seen in values_of(row)):
                wrong.append(f"{name} is {value}")
    expect.that("every named number has a row in docs/decisions.md or a mark", not missing, ", ".join(missing))
    expect.that("rows have the values of the sources", not wrong, ", ".join(wrong))
    left = [name for row in page for name in {name for name, _ in names_of(row)}
            if not any((name, room) in used for _, room in names_of(row))]
    expect.that("every name of a row is in the sources", not left, ", ".join(left))


def test_options_of_rows(expect):
    text = "".join(source.path.read_text() for source in sources())
    unknown = [name for row in steering() + advice() for name in re.findall(r"`(-\w+)`", row[0]) if f'"{name}"' not in text]
    expect.that("options of rows are in the sources", not unknown, ", ".join(unknown))


def unknown_tests(rows):
    """Names in the last cells of rows that are neither a function nor a file of tests."""
    text = "".join(path.read_text() for path in sorted((harness.ROOT / "tests").rglob("*")) if path.suffix in (".py", ".cpp"))
    known = {name for pair in re.findall(r"^def (\w+)|\bTEST(?:_[FP])?\(\w+,\s*(\w+)\)", text, re.M) for name in pair}
    return [name for row in rows for name in re.findall(r"`([^`]+)`", row[-1])
            if name not in known and not ("/" in name and (harness.ROOT / name).exists())]


def test_tests_of_rows(expect):
    """The last column names functions or files of tests that exist, or is "-" where none is known."""
    unknown = unknown_tests(steering() + table("Choices"))
    expect.that("tests of rows exist", not unknown, ", ".join(unknown))


def test_claims(expect):
    """Each row of docs/verification.md is a claim, its figure, and a test that exists; results that are published or exact are in the book."""
    page = (harness.ROOT / "docs" / "verification.md").read_text()
    rows = [row for row in rows_of(page) if row[0] != "claim"]
    expect("claims", len(rows), at_least=20)
    expect("lines of docs/verification.md", page.count("\n"), at_most=150)
    bare = [row[0] for row in rows if not re.search(r"\d", row[1]) or "`" not in row[-1]] + unknown_tests(rows)
    expect.that("claims have figures and tests", not bare, ", ".join(bare))


def test_no_number_without_a_name(expect):
    bare = [f"{source.path.name}:{line} {number}" for source in sources() if source.room.split("/")[0] in NAMED_LAYERS
            for number, line in source.literals()]
    expect.that("numbers have names or marks", not bare, ", ".join(bare))
