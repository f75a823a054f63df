"""Checks the files of instruments: each is read without options but those of the tip, and what is wrong with one ends in one line."""
import json
import os
import struct
import subprocess
import sys

import numpy as np
import pytest

import harness
import mlgimp
from made_curves import STIFFNESS, main, metal, refusal, text_of
from made_files import RESULTS, TEXTS, columns, fischer, hysitron_hld, nanosuite_rows, nanotest, optics11, table, triboscan, write_xlsx, write_zip
from mlgimp import load_depth, oliver_pharr, workbooks

pytestmark = pytest.mark.fast


def check(curve, scale=1.0, rtol=1e-5):
    """Whether a curve is that of columns(): every row, in um and mN, and its time."""
    time, depth, load = columns(scale=scale)
    rows = slice(-len(time), None)  # without a row of the approach, if there is one
    np.testing.assert_allclose(curve.depth[rows], depth, rtol=rtol, atol=1e-6)
    np.testing.assert_allclose(curve.load[rows], load, rtol=rtol, atol=1e-6)
    np.testing.assert_allclose(np.diff(curve.time[rows]), np.diff(time), atol=1e-6)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
@pytest.mark.parametrize("name", TEXTS)
def test_texts(tmp_path, name, encoding):
    (tmp_path / name).write_bytes(TEXTS[name]().encode(encoding))
    for curve in load_depth.read_tests(tmp_path / name):
        check(curve)
        assert oliver_pharr.analyse(curve)[0]["stiffness_mN_per_um"] == pytest.approx(STIFFNESS, rel=1e-3)  # 60 rows with nine digits


def test_tips_of_heads(tmp_path, capsys):
    """That of the file, unless the command line has one; a depth beyond the usable one of an area function is refused."""
    (tmp_path / "a.hld").write_bytes(hysitron_hld().encode("latin-1"))
    (tmp_path / "b.txt").write_text(optics11())
    of_function, ball = (load_depth.read_measured(tmp_path / name).tip for name in ("a.hld", "b.txt"))
    assert float(of_function.area(0.2)) == pytest.approx(1e-6 * (24.5 * 200**2 + 500 * 200)) and of_function.largest == pytest.approx(1)
    assert ball.name == "sphere" and ball.radius == 23
    main([str(tmp_path / "a.hld"), "--tip", "vickers"])
    assert "a.hld: unloading 1 of 1, vickers" in capsys.readouterr().out
    (tmp_path / "a.hld").write_bytes(hysitron_hld().replace("Usable Depth: 1000", "Usable Depth: 300").encode("latin-1"))
    assert "is beyond 300 nm, the largest to which the tip was calibrated" in refusal(tmp_path / "a.hld")


def test_what_is_off_a_hysitron_file_already(tmp_path):
    """Its displacements are without the frame and the drift of its head: neither may be taken off twice."""
    (tmp_path / "a.hld").write_bytes(hysitron_hld().encode("latin-1"))
    read = load_depth.read_measured(tmp_path / "a.hld")
    check(read)
    assert any("a frame of 0.33 nm/mN and a drift of 0.05 nm/s, which are off its displacements already" in note for note in read.notes)


# ---- workbooks ----

def test_workbook(tmp_path, capsys):
    """All sheets of tests in the order of their numbers, no table of results; an empty and an aborted test say why."""
    file = tmp_path / "m.xlsx"
    write_xlsx(file, {"Results": RESULTS, "Test 10": nanosuite_rows(0.8), "Test 2": nanosuite_rows(), "Test 3": nanosuite_rows()[:30],
                      "Test 4": [["Segment", "Hardness"]]})
    tests = load_depth.measured_tests(file)
    assert [test.name for test in tests] == ["m.xlsx Test 2", "m.xlsx Test 3", "m.xlsx Test 4", "m.xlsx Test 10"]
    check(tests[0].read())
    check(tests[3].read(), 0.8)
    with pytest.raises(SystemExit) as caught:
        main([str(file), "--tip", "berkovich"])
    assert caught.value.code == 2
    printed = capsys.readouterr().out
    assert "m.xlsx Test 3: no figures: there is no unloading" in printed and "m.xlsx Test 4: no figures: has 0 rows of numbers" in printed
    described = {each["name"]: each for each in json.loads((tmp_path / "indentation.json").read_text())["curves"]}
    assert described["m.xlsx Test 2"]["cycles"][0]["stiffness_mN_per_um"] == pytest.approx(STIFFNESS, rel=1e-3)


def test_columns_of_a_workbook_by_name(tmp_path):
    write_xlsx(tmp_path / "m.xlsx", {"Test 1": nanosuite_rows()})
    check(load_depth.read_measured(tmp_path / "m.xlsx", "Displacement Into Surface:nm", "Load On Sample:mN", "Time On Sample:s"))
    with pytest.raises(mlgimp.Error, match="is in nm by what stands above it, not in um"):
        load_depth.read_measured(tmp_path / "m.xlsx", "Displacement Into Surface:um", "Load On Sample:mN")


def test_archive_of_texts(tmp_path):
    write_zip(tmp_path / "m.zip", {"depth 2.txt": nanotest(), "depth 10.txt": nanotest()})
    curves = load_depth.read_tests(tmp_path / "m.zip")
    assert [curve.name for curve in curves] == ["m.zip depth 2.txt", "m.zip depth 10.txt"]
    check(curves[1])


def test_hdf5(tmp_path):
    """Groups of columns at any depth, with the unit as an attribute; a group with other things is none."""
    import h5py
    time, depth, load = columns()
    with h5py.File(tmp_path / "m.hdf5", "w") as file:
        file.create_group("instrument").create_dataset("serial", data=[1, 2, 3])
        for number in (10, 2):
            for name, values, unit in (("time", time, "s"), ("displacement", depth, b"um"), ("force", load, "mN")):
                file.create_dataset(f"test_{number}/data/{name}", data=values).attrs["unit"] = unit
    curves = load_depth.read_tests(tmp_path / "m.hdf5")
    assert [curve.name for curve in curves] == ["m.hdf5 test_2", "m.hdf5 test_10"]
    check(curves[0])


def test_old_workbook(tmp_path, monkeypatch):
    """No module here writes .xls: its reader gets one from a stand-in with the same calls."""
    class Sheet:
        def __init__(self, rows):
            self.rows, self.nrows = rows, len(rows)

        def row_values(self, row):
            return self.rows[row]

    class Book:
        sheets = {"Results": RESULTS, "Test 001": [["" if cell is None else cell for cell in row] for row in nanosuite_rows()]}

        def sheet_names(self):
            return list(self.sheets)

        def sheet_by_name(self, name):
            return Sheet(self.sheets[name])

        def unload_sheet(self, name):
            pass

    xlrd = pytest.importorskip("xlrd")
    monkeypatch.setattr(xlrd, "open_workbook", lambda **_: Book())
    (tmp_path / "m.xls").write_bytes(workbooks.OLD + bytes(600))
    check(load_depth.read_measured(tmp_path / "m.xls"))


@pytest.mark.parametrize("name, package", [("m.xlsx", "python3-openpyxl"), ("m.xls", "python3-xlrd")])
def test_a_module_that_is_missing(tmp_path, monkeypatch, name, package):
    write_xlsx(tmp_path / "m.xlsx", {"Test 1": nanosuite_rows()})
    (tmp_path / "m.xls").write_bytes(workbooks.OLD + bytes(600))
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    monkeypatch.setitem(sys.modules, "xlrd", None)
    assert f"install {package}" in refusal(tmp_path / name, "--tip", "vickers")


def damaged(tmp_path):
    """Workbooks and archives that are none, by name, with the words about them."""
    write_xlsx(tmp_path / "whole.xlsx", {"Test 1": nanosuite_rows()})
    whole = (tmp_path / "whole.xlsx").read_bytes()
    (tmp_path / "cut.xlsx").write_bytes(whole[:len(whole) // 2])
    (tmp_path / "cut.xls").write_bytes(workbooks.OLD + struct.pack("<300h", *range(300)))
    write_xlsx(tmp_path / "empty.xlsx", {"Test 1": []})
    write_zip(tmp_path / "pictures.zip", {"a.png": "none"})
    (tmp_path / "cut.hdf5").write_bytes(workbooks.HDF5 + bytes(500))
    (tmp_path / "binary.hap").write_bytes(bytes(range(128, 256)) * 8)
    return {"cut.hdf5": "cannot be read as a workbook", "binary.hap": "export the test as text or as a workbook",
            "cut.xlsx": "cannot be read as a workbook", "cut.xls": "cannot be read as a workbook", "empty.xlsx": "has no sheet with numbers",
            "pictures.zip": "is an archive without a workbook or texts"}


def test_damaged_workbooks(tmp_path):
    for name, words in damaged(tmp_path).items():
        assert words in refusal(tmp_path / name, "--tip", "vickers")


# ---- heads that leave something open ----

OPEN = {
    "two depths": (["Depth (nm)", "Penetration (nm)", "Depth (nm)", "Load (mN)"], None),  # the penetration counts
    "the same twice": (["Depth (nm)", "Depth (nm)", "Load (mN)"], r"2 columns may be the depth: Depth \(nm\) in column 1, Depth \(nm\) in column 2"),
    "no unit": (["Weg", "Kraft (mN)"], "no unit stands above the column Weg"),
    "volts alone": (["Depth (V)", "Load (mN)"], r"no columns of depth and load are known by their names; there are Depth \(V\), Load \(mN\)"),
    "other things": (["Torque (mN)", "Angle (rad)"], "no columns of depth and load are known"),
}


@pytest.mark.parametrize("name", OPEN)
def test_heads_that_leave_something_open(tmp_path, name):
    names, words = OPEN[name]
    _, depth, load = columns()
    values = {"L": load, "K": load, "T": load}
    (tmp_path / "m.txt").write_text(table(names, [values.get(each[0], 1e3 * depth) + (0 if each[0] != "D" or words else 7) for each in names]))
    if words is None:
        assert load_depth.read_measured(tmp_path / "m.txt").depth.max() == pytest.approx(0.5)
        return
    with pytest.raises(mlgimp.Error, match=words):
        load_depth.read_measured(tmp_path / "m.txt")


@pytest.mark.parametrize("names", [("Depth (corrected) (nm)", "Normal Force Fn [mN]", "Test time [sec.]"), ("h (nm)", "P (mN)", "t (s)"),
                                   ("Disp. (nm)", "Force appliqu\N{LATIN SMALL LETTER E WITH ACUTE}e (mN)", "Dur\N{LATIN SMALL LETTER E WITH ACUTE}e (s)"),
                                   ("Eindringtiefe/nm", "Pr\N{LATIN SMALL LETTER U WITH DIAERESIS}fkraft/mN", "Zeit/s")])
def test_other_names(tmp_path, names):
    """Beside columns that sound alike."""
    time, depth, load = columns()
    others = ["Raw Displacement (nm)", "Harmonic Load (mN)", "Contact Depth (nm)", "X Position (mm)", "Temperature (C)"]
    (tmp_path / "m.txt").write_text(table([*others, *names], [*(np.zeros(len(time)) for _ in others), 1e3 * depth, load, time]))
    check(load_depth.read_measured(tmp_path / "m.txt"))


def test_one_column_that_is_named(tmp_path):
    """The others are found beside it."""
    _, depth, load = columns()
    (tmp_path / "m.txt").write_text(table(["Way (nm)", "Load (mN)", "Time (s)"], [1e3 * depth, load, columns()[0]]))
    check(load_depth.read_measured(tmp_path / "m.txt", "Way:nm"))


def test_units_without_a_name_stand_in_a_note(tmp_path):
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    assert "no unit stands above the column depth: it is taken in um" in load_depth.read_measured(tmp_path / "m.csv").notes


@pytest.mark.parametrize("make", [triboscan, fischer, nanotest, hysitron_hld])
def test_a_file_that_was_cut(tmp_path, make):
    """At any place: a curve, or one line; never a traceback."""
    content = make().encode("latin-1")
    for share in (0.02, 0.1, 0.3, 0.6, 0.83, 0.97):
        (tmp_path / "m.txt").write_bytes(content[:int(share * len(content))])
        try:
            load_depth.read_tests(tmp_path / "m.txt")
        except mlgimp.Error as problem:
            assert "\n" not in str(problem)


def test_another_locale(tmp_path):
    """A German locale changes no number."""
    (tmp_path / "m.txt").write_bytes(triboscan().encode("latin-1"))
    code = ("import locale, mlgimp, sys\nfor name in ('de_DE.UTF-8', 'C'):\n    try: locale.setlocale(locale.LC_ALL, name)\n    except locale.Error: pass\n"
            "print(repr(float(mlgimp.read_measured(sys.argv[1]).load.max())))")
    run = subprocess.run([sys.executable, "-c", code, str(tmp_path / "m.txt")], capture_output=True, text=True, check=True,
                         env={**os.environ, "PYTHONPATH": str(harness.ROOT / "python"), "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"})
    assert float(run.stdout) == pytest.approx(10)


def test_tests_beside_each_other(tmp_path):
    """Columns of depth and load that take turns, the second test with fewer rows."""
    first, second = columns(), columns(rows=40, scale=0.8)
    rows = [[f"{value:.6f}" for value in row] for row in np.column_stack([1e3 * first[1], first[2]])]
    for row, (depth, load) in zip(rows, zip(1e3 * second[1], second[2])):
        row += [f"{depth:.6f}", f"{load:.6f}"]
    rows = [row + [""] * (4 - len(row)) for row in rows]
    heads = [["Specimen: 1", "Specimen: 1", "Specimen: 2", "Specimen: 2"], 2 * ["Displacement Into Surface", "Load On Sample"], 2 * ["nm", "mN"]]
    (tmp_path / "m.txt").write_text("\n".join("\t".join(row) for row in heads + rows) + "\n")
    one, two = load_depth.read_tests(tmp_path / "m.txt")
    np.testing.assert_allclose(one.depth, first[1], atol=1e-6)
    np.testing.assert_allclose(two.load, second[2], atol=1e-6)
    assert "2 tests stand beside each other" in one.notes


def test_a_clock_for_each_segment(tmp_path):
    """A time that is found and falls goes on, with a note; one that is named is refused."""
    time, depth, load = columns()
    (tmp_path / "m.txt").write_text(table(["Time (s)", "Depth (nm)", "Load (mN)"], [np.where(time > 6, time - 6, time), 1e3 * depth, load]))
    read = load_depth.read_measured(tmp_path / "m.txt")
    check(read)
    assert "the time begins anew 1 times, first in data row 62, and is taken to go on there" in read.notes
    with pytest.raises(mlgimp.Error, match="the time falls in data row 62"):
        load_depth.read_measured(tmp_path / "m.txt", time="Time:s")


@pytest.mark.parametrize("letter", ["?", "\N{REPLACEMENT CHARACTER}", "\N{LATIN CAPITAL LETTER A WITH CIRCUMFLEX}\N{MICRO SIGN}"])
def test_a_mu_that_was_lost(tmp_path, letter):
    """In programs that write it in one encoding and read it in another."""
    (tmp_path / "m.txt").write_text(triboscan().replace("\N{MICRO SIGN}", letter))
    check(load_depth.read_measured(tmp_path / "m.txt"))


def test_rows_with_the_largest_double_are_no_rows(tmp_path):
    rows = nanosuite_rows(end=False)
    rows.insert(70, [None, 1.7976931348623157e308, 1.7976931348623157e308, 1.0, 0, 0])
    write_xlsx(tmp_path / "m.xlsx", {"Test 1": rows})
    assert len(load_depth.read_measured(tmp_path / "m.xlsx").depth) == len(columns()[0])


def test_own_figures_of_the_instrument_stand_in_a_note(tmp_path):
    (tmp_path / "m.txt").write_text(TEXTS["anton_paar.TXT"]())
    assert "the instrument's own figures: Fm 10 mN, hm 500 nm, Hit 2413.5 MPa, Eit 71.2 GPa" in load_depth.read_measured(tmp_path / "m.txt").notes


def test_many_curves(tmp_path, capsys):
    """A table, a picture and a note for what failed, of a batch."""
    for number in range(30):
        (tmp_path / f"t{number:02d}.txt").write_text(triboscan() if number != 7 else triboscan()[:1500])
    with pytest.raises(SystemExit) as caught:
        main([*map(str, sorted(tmp_path.glob("t*.txt"))), "--tip", "berkovich"])
    assert caught.value.code == 2 and capsys.readouterr().out.count("no figures") == 1
    assert len((tmp_path / "indentation.csv").read_text().splitlines()) == 31 and (tmp_path / "indentation.png").stat().st_size > 10000
