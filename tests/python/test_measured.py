"""Checks the reading of measured curves: texts of instruments, units, the approach to the surface, and what is refused."""
import csv
import json
import re

import numpy as np
import pytest

import harness
import mlgimp
from made_curves import CONE, GOOD, cycles_of, main, metal, refusal, text_of
from mlgimp import load_depth, oliver_pharr
from mlgimp.load_depth import Column

pytestmark = pytest.mark.fast

DEPTH, LOAD = Column("depth", 1.0), Column("load", 1.0)


@pytest.mark.parametrize("head, mark, comma, depth, load", [
    ("depth,load\n", ",", False, DEPTH, LOAD), ("", " ", False, Column("1", 1), Column("2", 1)),
    ("Instrument 7\n\nDepth\tLoad\num\tmN\n", "\t", False, DEPTH, LOAD), ('"depth";"load"\n', ";", True, DEPTH, LOAD),
    ("# depth load\n", "  ", False, DEPTH, LOAD)], ids=["commas", "spaces", "tabs and units", "decimal commas", "remark"])
def test_kinds_of_text(tmp_path, head, mark, comma, depth, load):
    text = text_of(*metal(), mark=mark, head="")
    (tmp_path / "m.txt").write_text(head + (text.replace(".", ",") if comma else text))
    read = load_depth.read_measured(tmp_path / "m.txt", depth, load)
    assert np.allclose(read.depth, metal()[0]) and np.allclose(read.load, metal()[1])


def with_clock(text, mark=","):
    """A text with a column of times of day before the others."""
    head, *rows = text.splitlines()
    return "\n".join([f"clock{mark}{head}", *(f"10:{k // 60:02d}:{k % 60:02d}{mark}{row}" for k, row in enumerate(rows))]) + "\n"


@pytest.mark.parametrize("content, depth", [
    (text_of(*metal(), head="Depth (\N{MICRO SIGN}m),load\n").encode("cp1252"), "Depth (\N{MICRO SIGN}m):um"),
    (text_of(*metal(), head="Depth (\N{MICRO SIGN}m),load\n").encode("utf-8-sig"), "Depth (\N{MICRO SIGN}m):um"),
    (text_of(*metal()).replace("\n", ",\n").encode(), "depth:um"), (with_clock(text_of(*metal())).encode(), "depth:um"),
    (with_clock(text_of(*metal()).replace(",", " "), " ").encode(), "depth:um"), (with_clock(text_of(*metal())).encode(), "2:um"),
    (text_of(*metal()).replace("\n", ",loading\n").encode(), "depth:um"),
    (b"# A ball of 2 um pressed 100 nm\n" + text_of(*metal(), mark=" ", head="depth load\n").encode(), "depth:um"),
    (text_of(*metal(), head="Depth (\N{MICRO SIGN}m),load\n").encode("utf-16"), "Depth (\N{MICRO SIGN}m):um"),
], ids=["Windows", "UTF-8", "a comma more", "times of day", "with spaces", "by its number", "words", "numbers in a remark", "UTF-16"])
def test_texts_of_instruments(tmp_path, content, depth):
    """Only the columns that are asked for need be numbers."""
    (tmp_path / "m.txt").write_bytes(content)
    read = load_depth.read_measured(tmp_path / "m.txt", depth)
    assert np.allclose(read.depth, metal()[0]) and np.allclose(read.load, metal()[1])


@pytest.mark.parametrize("head, load", [
    ("depth,Load (mN)\n", "Load (mN):uN"), ("depth,Load (mN)\n", "2:uN"), ("depth,Load [\N{MICRO SIGN}N]\n", "2:mN"),
    ("depth,load\num,mN\n", "load:uN"), ("depth,load\n(um),(mN)\n", "load:N")])
def test_another_unit_above_the_column_is_refused(tmp_path, head, load):
    """Hardness would be wrong by the factor between them, and no less likely."""
    (tmp_path / "m.csv").write_text(text_of(*metal(), head=head))
    name, _, unit = load.rpartition(":")
    with pytest.raises(mlgimp.Error, match=rf"the column {re.escape(name)} is in [um]N by what stands above it, not in {unit}$"):
        load_depth.read_measured(tmp_path / "m.csv", load=load)


# ---- lines of words ----

def test_commas_that_part_columns_and_fractions(tmp_path):
    """Rows of 6 numbers under 3 names are refused; with semicolons between columns they are read."""
    rows = [("0,5", f"{k},25", f"{k * k},75") for k in range(40)]
    (tmp_path / "m.csv").write_text("\n".join(["Time (s),Depth (nm),Load (uN)", *(",".join(row) for row in rows)]) + "\n")
    with pytest.raises(mlgimp.Error, match="has 6 numbers in rows under 3 names: commas part columns and fractions alike"):
        load_depth.read_measured(tmp_path / "m.csv")
    (tmp_path / "m.csv").write_text("\n".join(["Time (s);Depth (nm);Load (uN)", *(";".join(row) for row in rows)]) + "\n")
    assert load_depth.read_measured(tmp_path / "m.csv").depth[-1] == pytest.approx(39.25e-3)


@pytest.mark.parametrize("line", ["END", "END,,", "Test finished OK", "end,of", ",,", "Hardness,3.2", "--- unload ---", "OVERLOAD,1.5"])
@pytest.mark.parametrize("place", [300, 401, 800])
def test_lines_of_words_between_and_below_the_rows(tmp_path, line, place):
    """They are left out, and a note says where; the curve is the same. Any other line must have its numbers, see test_measured_files."""
    lines = text_of(*metal()).splitlines()
    lines.insert(place, line)
    (tmp_path / "m.csv").write_text("\r\n".join(lines) + "\r\n")
    read = load_depth.read_measured(tmp_path / "m.csv")
    np.testing.assert_allclose(read.load, metal()[1], rtol=1e-8)
    assert read.notes[0] == f"left out between or below the rows: 1 line without numbers (line {place + 1}, {line!r})"


def test_words_of_segments_in_a_column_of_their_own(tmp_path):
    """As a program of instruments writes them, which ends its table with END."""
    rows = [f",{h},{p}" for h, p in zip(*metal())]
    rows[0], rows[400] = "Load Segment" + rows[0], "Unload Segment" + rows[400]
    (tmp_path / "m.csv").write_text("\r\n".join(["Segment,Displacement Into Surface,Load On Sample", ",um,mN", *rows, "END,,", "", ""]))
    read = load_depth.read_measured(tmp_path / "m.csv", "Displacement Into Surface:um", "load on sample:mN")
    np.testing.assert_array_equal(read.depth, metal()[0])


# ---- how numbers are written ----

def english(value):
    return f"{value:,.4f}"


def german(value):
    return english(value).translate(str.maketrans(",.", ".,"))


NUMBERS = {
    "decimal commas": lambda value: f"{value:.6f}".replace(".", ","), "English thousands": english, "German thousands": german,
    "Swiss thousands": lambda value: english(value).replace(",", "'"), "French thousands": lambda value: german(value).replace(".", "\N{NO-BREAK SPACE}"),
    "Fortran": lambda value: f"{value:.8E}".replace("E", "D"), "exponents": lambda value: f"{value:.8e}", "exponents with commas": lambda value: f"{value:.8e}".replace(".", ","),
    "minus sign": lambda value: f"{value:.6f}".replace("-", "\N{MINUS SIGN}"), "plus sign": lambda value: f"{value:+.6f}"}


@pytest.mark.parametrize("name, mark", [(name, mark) for name in NUMBERS for mark in (";", "\t", ",", "|", " ", "   ")
                                        if not (name == "French thousands" and mark.isspace() and mark != "\t")])
def test_numbers(tmp_path, name, mark):
    """In nm and uN, so that there are thousands; quoted where the mark may be part of a number."""
    depth, load = metal(lowest=0.01, first=-0.02)
    quote = '"' if mark == "," else ""
    rows = [mark.join(quote + NUMBERS[name](value) + quote for value in (k / 10, 1e3 * h, 1e3 * p)) for k, (h, p) in enumerate(zip(depth, load))]
    (tmp_path / "m.txt").write_text(f'"time"{mark}"Depth (nm)"{mark}"Load (uN)"\n' + "\n".join(rows) + "\n", "utf-8")
    read = load_depth.read_measured(tmp_path / "m.txt", "Depth:nm", "Load:uN", "time:s")
    np.testing.assert_allclose(read.load, load[-len(read.load):], atol=1e-6)
    np.testing.assert_allclose(read.depth, depth[-len(read.depth):], atol=1e-6)


@pytest.mark.parametrize("blank", ["  ", "\t"])
def test_decimal_commas_between_blanks(tmp_path, blank):
    rows = [f"{blank}{h:.5f}{blank}{p:.5f}".replace(".", ",") for h, p in zip(*metal())]
    (tmp_path / "m.txt").write_text("\r\n".join([f"{blank}Tiefe/um{blank}Kraft/mN", *rows]))
    read = load_depth.read_measured(tmp_path / "m.txt", "Tiefe:um", "Kraft:mN")
    np.testing.assert_allclose(read.load, metal()[1], atol=1e-5)


# ---- names and units ----

GREEK = "\N{GREEK SMALL LETTER MU}"


@pytest.mark.parametrize("encoding, letter", [(encoding, letter) for encoding in ("latin-1", "cp1252", "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be")
                                              for letter in ("\N{MICRO SIGN}", GREEK, "u") if letter != GREEK or encoding.startswith("utf")])
@pytest.mark.parametrize("asked", ["Load:uN", "Load (uN):uN", "Load (\N{MICRO SIGN}N):\N{MICRO SIGN}N", f"load:{GREEK}N"])
def test_micro(tmp_path, encoding, letter, asked):
    """However a file and a user write it."""
    depth, load = metal()
    (tmp_path / "m.txt").write_bytes(text_of(depth, 1e3 * load, head=f"Depth ({letter}m),Load ({letter}N)\n").encode(encoding))
    read = load_depth.read_measured(tmp_path / "m.txt", "Depth:um", asked)
    np.testing.assert_allclose(read.load, load, rtol=1e-8)
    with pytest.raises(mlgimp.Error, match="in uN by what stands above it, not in mN"):
        load_depth.read_measured(tmp_path / "m.txt", "Depth:um", "Load:mN")


HEADS = ["Depth (nm),Load (mN)", "Depth [nm],Load [mN]", "Depth/nm,Load/mN", "Depth / nm,Load / mN", "Depth in nm,Load in mN", "depth_nm,load_mN",
         "DEPTH nm,LOAD mN", "Depth,Load,state\nnm,mN,none", "Depth,Load\nnm,mN", "Depth,Load\n(nm),(mN)", "Depth,Load\n[nm],[mN]", "# Depth (nm),Load (mN)", "% Depth (nm),Load (mN)"]


@pytest.mark.parametrize("blanks", [False, True])
@pytest.mark.parametrize("head", HEADS)
def test_units_of_heads(tmp_path, head, blanks):
    """Each is found by its name alone, and another unit is refused."""
    depth, load = metal()
    text = text_of(1e3 * depth, load, head=head + "\n")
    if "state" in head:
        text = "\n".join(head.splitlines() + [row + ",1" for row in text.splitlines()[2:]])
    (tmp_path / "m.txt").write_text(text.replace(",", "  ") if blanks else text)
    np.testing.assert_allclose(load_depth.read_measured(tmp_path / "m.txt", "Depth:nm", "Load:mN").depth, depth, rtol=1e-8)
    for depth_column, load_column in (("Depth:um", "Load:mN"), ("Depth:nm", "Load:N"), ("1:um", "2:mN")):
        with pytest.raises(mlgimp.Error, match="by what stands above it, not in (um|N)$"):
            load_depth.read_measured(tmp_path / "m.txt", depth_column, load_column)


@pytest.mark.parametrize("names", ["Depth (nm),Load (mN),Depth (V),Load (V)", "Depth (V),Load (V),Depth (nm),Load (mN)",
                                   "Depth,Load,Depth,Load\nnm,mN,V,V", "Depth,Load,Depth,Load\n(V),(V),(nm),(mN)"])
def test_of_columns_with_one_name_that_with_the_unit(tmp_path, names):
    depth, load = metal()
    nm_first = names.index("nm") < names.index("V")
    volts = np.column_stack([depth / 7, load / 3])
    table = np.column_stack([1e3 * depth, load, volts] if nm_first else [volts, 1e3 * depth, load])
    np.savetxt(tmp_path / "m.csv", table, delimiter=",", header=names, comments="")
    read = load_depth.read_measured(tmp_path / "m.csv", "Depth:nm", "Load:mN")
    np.testing.assert_allclose(read.depth, depth)
    np.testing.assert_allclose(read.load, load)
    with pytest.raises(mlgimp.Error, match="the column Depth is in nm by what stands above it, not in um"):
        load_depth.read_measured(tmp_path / "m.csv", "Depth:um", "Load:mN")
    with pytest.raises(mlgimp.Error, match="is in V by what stands above it, not in nm"):
        load_depth.read_measured(tmp_path / "m.csv", "3:nm" if nm_first else "1:nm", "Load:mN")


@pytest.mark.parametrize("names, found", [("Depth (nm),Load (mN),Depth (nm)", r"Depth \(nm\) in column 1, Depth \(nm\) in column 3"),
                                         ("Depth raw,Load (mN),Depth raw", "Depth raw in column 1, Depth raw in column 3")])
def test_columns_that_are_alike(tmp_path, names, found):
    depth, load = metal()
    np.savetxt(tmp_path / "m.csv", np.column_stack([1e3 * depth, load, depth]), delimiter=",", header=names, comments="")
    asked = names.split(",")[0].split(" (")[0]
    with pytest.raises(mlgimp.Error, match=rf"there are 2 columns {asked}: {found}; choose one by its number"):
        load_depth.read_measured(tmp_path / "m.csv", f"{asked}:nm", "Load:mN")
    np.testing.assert_allclose(load_depth.read_measured(tmp_path / "m.csv", "1:nm", "Load:mN").depth, depth)


def test_marks_within_quotes(tmp_path):
    """Names as instruments give them, with the unit behind a comma."""
    depth, load = metal()
    rows = [f'"{d}","{p}"\n' for d, p in zip(depth, load)]
    (tmp_path / "m.csv").write_text('"Depth, um","Load, mN"\n' + "".join(rows))
    read = load_depth.read_measured(tmp_path / "m.csv", "Depth, um:um", "Load, mN:mN")
    assert np.allclose(read.load, load[-len(read.load):])
    (tmp_path / "m.csv").write_text('Depth of 2" disk,Load\n' + "".join(f'"{d},{p}\n' for d, p in zip(depth, load)))  # quotes that do not close
    assert np.array_equal(load_depth.read_measured(tmp_path / "m.csv", "1:um", "2:mN").load, read.load)


def test_names_with_units(tmp_path):
    """A column is found by its name without the unit behind it, and named with it where there is none of a name."""
    file = tmp_path / "curve.csv"
    file.write_text(text_of(*metal(), head="Depth (um),Load (mN)\n"))
    named = load_depth.read_measured(file, "Depth:um", "load:mN")
    np.testing.assert_allclose(named.depth, metal()[0], rtol=1e-8)
    with pytest.raises(mlgimp.Error, match=r"there are Depth \(um\), Load \(mN\)$"):
        load_depth.read_measured(file, "h:um", "Load:mN")
    with pytest.raises(mlgimp.Error, match="in um"):
        load_depth.read_measured(file, "Depth:nm", "Load:mN")


def test_a_refused_name_comes_with_the_right_ones():
    with pytest.raises(mlgimp.Error, match="no unit stands above the column Displacement: .* there are Displacement, Force$"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv")
    with pytest.raises(mlgimp.Error, match="there is no column depth; there are Displacement, Force$"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv", "depth:um", "load:mN")
    with pytest.raises(mlgimp.Error, match="depth=2: must be a text COLUMN:UNIT"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv", depth=2)
    with pytest.raises(mlgimp.Error, match="load=7: must be a text COLUMN:UNIT"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv", "1:nm", 7)


# ---- several tests in a file ----

def block(number, depth, load, head="F\th\tt"):
    """A test as an instrument writes it into a file with others, with decimal commas and figures of its own above."""
    lines = [f"my.app   01.02.2030  10:0{number}:00", f"Block : 1   Value : {number}", "x=    10.10  y=     6.00", "HIT\t[N/mm\N{SUPERSCRIPT TWO}]\t   8500.0", " ", "", head]
    return lines + [f"{p:.6g}\t{h:.6g}\t{0.1 * k:.1f}".replace(".", ",") for k, (h, p) in enumerate(zip(depth, load))] + [""]


@pytest.mark.parametrize("columns", [("h:um", "F:mN", "t:s"), ("2:um", "1:mN", None)], ids=["names", "numbers"])
def test_several_tests_in_a_file(tmp_path, capsys, columns):
    """All by the command and by read_tests, one by its number; a choice is asked for where one curve is wanted."""
    tops = (0.3, 0.5, 0.4)
    lines = ["Test series\twith\tthree tests", "3900,1\t10,1\t6,0\tHM\tx\ty", "3800,2\t10,2\t6,0\tHM\tx\ty"]
    for number, top in enumerate(tops, start=1):
        lines += block(number, *metal(top=top, final=0.84 * top, rows=60))
    (tmp_path / "m.txt").write_bytes("\r\n".join(lines).encode("latin-1"))
    curves = load_depth.read_tests(tmp_path / "m.txt", *columns)
    assert [curve.depth.max() for curve in curves] == pytest.approx(tops) and [curve.name for curve in curves] == [f"m.txt test {k}" for k in (1, 2, 3)]
    second = load_depth.read_measured(tmp_path / "m.txt", *columns, test=2)
    np.testing.assert_array_equal(second.load, curves[1].load)
    with pytest.raises(mlgimp.Error, match="holds 3 tests: choose one by its number, test 1 to 3"):
        load_depth.read_measured(tmp_path / "m.txt", *columns)
    with pytest.raises(mlgimp.Error, match="there is no test 4; there are 3"):
        load_depth.read_measured(tmp_path / "m.txt", *columns, test=4)
    words = [str(tmp_path / "m.txt"), "--tip", "vickers", "--depth", columns[0], "--load", columns[1]]
    main(words)
    assert len(re.findall(r"^m.txt test \d: unloading 1 of 1", capsys.readouterr().out, re.M)) == 3
    main([*words, "--test", "3"])
    [test] = json.loads((tmp_path / "indentation.json").read_text())["curves"]
    assert test["name"] == "m.txt test 3" and test["cycles"][0]["depth_um"] == pytest.approx(0.4)
    assert "no test 4; there are 3" in refusal(*words, "--test", "4")


@pytest.mark.parametrize("between, count", [("\n", 2), ("Test 2\n", 2), ("depth,load\n", 2), ("", 1)])
def test_tests_that_are_parted_by_a_line_alone(tmp_path, between, count):
    """The depth jumps back to zero behind it; without one the rows are those of one test."""
    rows = text_of(*metal(), head="")
    (tmp_path / "m.csv").write_text("depth,load\n" + rows + between + rows)
    assert len(load_depth.read_tests(tmp_path / "m.csv")) == count


@pytest.mark.parametrize("line", ["", "Segment", "Hold 2 s", "depth,load", "Unloading\ndepth,load\num,mN"])
def test_lines_between_the_cycles_of_one_test(tmp_path, line):
    """The tip goes on from where it was, also where the load has gone to zero."""
    depth, load = cycles_of((2, 5, 10), lowest=0)
    lines = text_of(depth, load, head="").splitlines()
    for place in np.flatnonzero(np.diff(np.sign(np.diff(depth))))[::-1] + 1:
        lines.insert(place, line)
    (tmp_path / "m.csv").write_text("depth,load\n" + "\n".join(lines))
    [curve] = load_depth.read_tests(tmp_path / "m.csv")
    assert len(load_depth.find_cycles(curve)) == 3


def test_a_batch_with_tests_that_failed(tmp_path, capsys):
    """They are rows with a note; the others are written as always, and the exit status is 2."""
    depth, load = metal()
    (tmp_path / "a.csv").write_text(text_of(depth, load))
    (tmp_path / "b.csv").write_text(text_of(depth[:300], load[:300]))
    (tmp_path / "c.csv").write_text(text_of(depth, load, head="h,F\n"))
    (tmp_path / "d.csv").write_text(text_of(depth, load))
    words = [str(tmp_path / name) for name in ("a.csv", "b.csv", "c.csv", "none.csv", "d.csv")]
    with pytest.raises(SystemExit) as caught:
        main([*words, "--tip", "vickers"])
    assert caught.value.code == 2
    printed = capsys.readouterr().out
    tests = {each["name"]: each for each in json.loads((tmp_path / "indentation.json").read_text())["curves"]}
    rows = {row["curve"]: row for row in csv.DictReader(open(tmp_path / "indentation.csv"))}
    for name, problem in (("b.csv", "there is no unloading"), ("c.csv", "no unit stands above the column h"), ("none.csv", "cannot be read as text")):
        assert problem in tests[name]["problem"] and tests[name]["cycles"] == [] and rows[name]["hardness_GPa"] == ""
        assert rows[name]["warnings"].startswith(f"no figures: {problem}") and f"{name}: no figures: {problem}" in printed
    assert list(rows) == list(tests) == ["a.csv", "b.csv", "c.csv", "none.csv", "d.csv"]
    assert rows["a.csv"]["hardness_GPa"] == rows["d.csv"]["hardness_GPa"] != "" and tests["a.csv"]["problem"] is None
    (tmp_path / "indentation.csv").unlink()
    assert "b.csv" in refusal(*words[1:4], "--tip", "vickers") and not (tmp_path / "indentation.csv").exists()


# ---- zeros and the approach ----

def with_approach(exponent, zero_depth=0.25, zero_load=-0.8, noise=0.01, seed=1, rows=600):
    """Depth (um) and load (mN) of a free tip over `zero_depth`, a loading with an exponent to 0.5 um and 10 mN, and an unloading."""
    random = np.random.default_rng(seed)
    depth = np.concatenate([np.linspace(-zero_depth, 0, rows // 3, endpoint=False), np.linspace(0, 0.5, rows), np.linspace(0.5, 0.42, rows)[1:]])
    load = 10 * np.where(np.arange(len(depth)) < rows // 3 + rows, (np.maximum(depth, 0) / 0.5) ** exponent, np.maximum((depth - 0.42) / 0.08, 0) ** 1.4)
    return depth + zero_depth, load + zero_load + noise * random.normal(size=len(load))


def test_zeros_that_are_given(tmp_path, expect):
    """In the units of the file's columns."""
    depth, load = with_approach(2, noise=0)
    (tmp_path / "m.csv").write_text(text_of(1e3 * depth, 1e3 * load))
    read = load_depth.read_measured(tmp_path / "m.csv", "depth:nm", "load:uN", zero_depth=250, zero_load=-800)
    [row] = oliver_pharr.analyse(read._replace(tip=CONE))
    for name, exact in (("depth_um", 0.5), ("load_mN", 10), ("stiffness_mN_per_um", 175)):
        expect(name, row[name] / exact - 1, near=0, tolerance=1e-6)
    assert row["warnings"] == ""


@pytest.mark.parametrize("exponent, tolerance", [(1, 0.01), (1.5, 0.01), (2, 0.02)])
def test_zeros_that_are_found(tmp_path, expect, exponent, tolerance):
    """With noise of 0.3 % of the load, of a punch, a ball and a cone: within one or two per cent of the depth, with any noise."""
    for seed in range(5):
        (tmp_path / "m.csv").write_text(text_of(*with_approach(exponent, noise=0.03, seed=seed)))
        read = load_depth.read_measured(tmp_path / "m.csv", zero_depth="auto", zero_load="auto")
        top = 10 + np.argmax(read.load)
        expect("largest depth", read.depth.max(), near=0.5, tolerance=0.5 * tolerance)
        expect("largest load", read.load[top - 20:top].max(), near=10, tolerance=0.15)
    assert re.match("the zero of loads is -0.(79|80)", read.notes[0]) and "the zero of depths is 0.2" in read.notes[1] and "exponent" in read.notes[1]


def test_zeros_that_cannot_be_found(tmp_path):
    for first in (0, 0.1, 0.3):  # under load from the first row on
        (tmp_path / "m.csv").write_text(text_of(*metal(first=first)))
        with pytest.raises(mlgimp.Error, match="no zero of loads can be found"):
            load_depth.read_measured(tmp_path / "m.csv", zero_load="auto")
    depth, load = metal(rows=12)
    (tmp_path / "m.csv").write_text(text_of(depth, load))
    with pytest.raises(mlgimp.Error, match="no zero of depths can be found: 10 rows of the first loading"):
        load_depth.read_measured(tmp_path / "m.csv", zero_depth="auto")
    with pytest.raises(mlgimp.Error, match="zero_depth=surface: must be a number, or auto"):
        load_depth.read_measured(tmp_path / "m.csv", zero_depth="surface")
    assert "--zero-load: surface: must be a number, or auto" in refusal(tmp_path / "m.csv", "--zero-load", "surface").replace("argument ", "")


def test_rows_of_the_approach(tmp_path, expect):
    """A tip that comes from farther over the surface than it goes into it; a load that is not zeroed does no work there."""
    depth, load = metal()
    before = np.linspace(-1, 0, 200, endpoint=False)
    (tmp_path / "m.csv").write_text(text_of(np.append(before, depth), np.append(np.full(200, 0.1), load)))
    read = load_depth.read_measured(tmp_path / "m.csv")
    [row] = oliver_pharr.analyse(read._replace(tip=CONE))
    assert len(read.depth) == 800 and read.depth[0] == pytest.approx(-0.005) and "199 rows of the approach" in read.notes[0]
    assert row["warnings"] == ""
    expect("total work", row["total_work_nJ"] / (10 * 0.5 / 3), near=1, tolerance=1e-3)


# ---- refusals ----

ROWS = GOOD.splitlines(True)[1:]
MEASURED = {
    "empty": ("", "is empty"), "no numbers": ("depth,load\n", "0 rows"),
    "one column": ("depth\n" + "".join(row.split(",")[0] + "\n" for row in ROWS), "line 800 has '0.42', and not two numbers"),
    "a clock": (with_clock(GOOD).replace("clock,depth", "depth,h"), "2 columns may be the depth: depth in column 1, h in column 2"),
    "few rows": ("depth,load\n" + "".join(ROWS[::100]), "8 rows"),
    "no unit": (GOOD.replace("load", "force", 1), "no unit stands above the column force"),
    "no such column": (GOOD.replace("load", "torque", 1), "no columns of depth and load are known by their names; there are depth, torque"), "a row that was cut": (GOOD + "0.5\n", "line 801 is no row of numbers: it has nothing in column 2"),
    "not a number": (GOOD + "nan,1\n", "no row of numbers"), "a longer row": (GOOD + "1,2,3\n", "3 columns instead of 2"),
    "only loading": ("depth,load\n" + "".join(ROWS[:400]), "no unloading"), "only unloading": ("depth,load\n" + "".join(ROWS[400:]), "without a loading"),
    "shuffled": ("depth,load\n" + "".join(np.random.default_rng(1).permutation(ROWS)), "order of the test"),
    "sorted by depth": ("depth,load\n" + "".join(sorted(ROWS, key=lambda row: float(row.split(",")[0]))), ""),
    "depths up": (text_of(-metal()[0], metal()[1]), "the depth goes below zero"), "pull": (text_of(metal()[0], -metal()[1]), "the load goes below zero"),
    "one value": ("depth,load\n" + 20 * "1,1\n", "no unloading"), "a jump back": ("depth,load\n" + "".join(ROWS[:400] + ROWS[-2:]), "rows of the unloading"),
}


@pytest.mark.parametrize("name", MEASURED)
def test_measured_files(tmp_path, name):
    content, expected = MEASURED[name]
    (tmp_path / "m.csv").write_text(content)
    line = refusal(tmp_path / "m.csv", "--tip", "berkovich")
    assert "m.csv" in line and expected in line


def test_times_that_fall(tmp_path):
    np.savetxt(tmp_path / "m.csv", np.column_stack([np.arange(799)[::-1], *metal()]), delimiter=",", header="time,depth,load", comments="")
    assert "time falls in data row 2" in refusal(tmp_path / "m.csv", "--tip", "berkovich", "--time", "time:s")


def test_one_column_for_both_is_refused(tmp_path):
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    with pytest.raises(mlgimp.Error, match="depth and load are the same column, depth"):
        load_depth.read_measured(tmp_path / "m.csv", "depth:um", "depth:mN")
