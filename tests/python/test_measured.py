"""Checks the reading of measured curves: texts of instruments, units, the approach to the surface, and what is refused."""
import json
import re

import numpy as np
import pytest

import harness
import mlgimp
from mlgimp import load_depth, oliver_pharr
from mlgimp.load_depth import Column
from test_indentation import CONE, CONE_OPTIONS, GOOD, main, metal, refusal, text_of, write_run

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


def test_a_line_below_the_rows_is_told(tmp_path):
    """What parts the columns is what parts them in a row, not there."""
    (tmp_path / "m.csv").write_text(text_of(*metal()) + "Test finished OK\n")
    with pytest.raises(mlgimp.Error, match="line 801 is no row of numbers: it has 'Test finished OK' in column 1"):
        load_depth.read_measured(tmp_path / "m.csv")


def test_marks_within_quotes(tmp_path):
    """Names as instruments give them, with the unit behind a comma."""
    depth, load = metal()
    rows = [f'"{d}","{p}"\n' for d, p in zip(depth, load)]
    (tmp_path / "m.csv").write_text('"Depth, um","Load, mN"\n' + "".join(rows))
    read = load_depth.read_measured(tmp_path / "m.csv", "Depth, um:um", "Load, mN:mN")
    assert np.allclose(read.load, load[-len(read.load):])
    (tmp_path / "m.csv").write_text('Depth of 2" disk,Load\n' + "".join(f'"{d},{p}\n' for d, p in zip(depth, load)))  # quotes that do not close
    assert np.array_equal(load_depth.read_measured(tmp_path / "m.csv", "1:um", "2:mN").load, read.load)


def test_one_column_for_both_is_refused(tmp_path):
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    with pytest.raises(mlgimp.Error, match="depth and load are the same column, depth"):
        load_depth.read_measured(tmp_path / "m.csv", "depth:um", "depth:mN")


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


def test_names_with_units(tmp_path):
    """A column is found by its name without the unit behind it, and told with it where there is none of a name."""
    file = tmp_path / "curve.csv"
    file.write_text(text_of(*metal(), head="Depth (um),Load (mN)\n"))
    named = load_depth.read_measured(file, "Depth:um", "load:mN")
    np.testing.assert_allclose(named.depth, metal()[0], rtol=1e-8)
    with pytest.raises(mlgimp.Error, match=r"there are Depth \(um\), Load \(mN\)$"):
        load_depth.read_measured(file, "h:um", "Load:mN")
    with pytest.raises(mlgimp.Error, match="in um"):
        load_depth.read_measured(file, "Depth:nm", "Load:mN")


def test_a_wrong_name_is_told_the_right_ones():
    with pytest.raises(mlgimp.Error, match="there is no column depth; there are Displacement, Force$"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv")
    with pytest.raises(mlgimp.Error, match="depth=2: must be a text COLUMN:UNIT"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv", depth=2)
    with pytest.raises(mlgimp.Error, match="load=None: must be a text COLUMN:UNIT"):
        mlgimp.read_measured(harness.ROOT / "examples" / "measured.csv", "1:nm", None)


def test_measured_beside_a_run(tmp_path, capsys, expect):
    """In nm and uN, with drift and rows written twice; the tip is that of the run."""
    folder = write_run(tmp_path / "run", CONE_OPTIONS)
    depth, load = (np.repeat(each, 2) for each in metal())
    times = np.repeat(np.arange(len(depth) // 2), 2) * 0.1
    np.savetxt(tmp_path / "m.csv", np.column_stack([times, 1e3 * depth + 0.05 * times, 1e3 * load]), delimiter=",", header="t,h,F", comments="")
    main([str(folder), str(tmp_path / "m.csv"), "--depth", "h:nm", "--load", "F:uN", "--time", "t:s", "--drift", "0.05"])
    assert capsys.readouterr().out.count("  hardness") == 2
    run, measured = (each["cycles"][0] for each in json.loads((folder / "indentation.json").read_text())["curves"])
    for name in ("load_mN", "stiffness_mN_per_um", "hardness_GPa", "reduced_modulus_GPa"):
        expect(name, measured[name] / run[name] - 1, near=0, tolerance=5e-3)
    assert measured["modulus_GPa"] is None


def test_units_of_no_solid_are_told(tmp_path, capsys):
    """Depths in nm read as um make a hardness of 1e-6 of it, loads in mN read as N one of 1000 times it."""
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    for unit, told in (("N", True), ("mN", False)):
        main([str(tmp_path / "m.csv"), "--tip", "berkovich", "--depth", "depth:um", "--load", f"load:{unit}"])
        assert ("is that of no solid" in capsys.readouterr().out) == told


# ---- refusals ----

ROWS = GOOD.splitlines(True)[1:]
MEASURED = {
    "empty": ("", "is empty"), "no numbers": ("depth,load\n", "0 rows"),
    "one column": ("depth\n" + "".join(row.split(",")[0] + "\n" for row in ROWS), "line 800 has '0.42', and not two numbers"),
    "a clock": (with_clock(GOOD).replace("clock,depth", "depth,h"), "line 2 is no row of numbers: it has '10:00:00' in column 1"),
    "few rows": ("depth,load\n" + "".join(ROWS[::100]), "8 rows"),
    "no such column": (GOOD.replace("load", "force", 1), "no column load"), "words": (GOOD + "end,of\n", "no row of numbers"),
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
