"""Checks the package mlgimp from outside: runs, results, errors, and the case of indent."""
import ast
import importlib.util
import inspect
import os
import re
import shutil
import subprocess
import sys
import time
import types
import warnings

import numpy as np
import pytest
from matplotlib import animation

import harness
import mlgimp
from mlgimp import fields, indentation, movie, options, pictures, results, surface
from mlgimp.gallery import gallery
from mlgimp.program import show_bar

pytestmark = pytest.mark.fast

# A cylinder that comes down on a block and goes back, on two levels.
PRESS = {"domain_lower": (0, 0), "domain_upper": (12.0, 12.0), "cell_size": 1.0, "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry",
         "levels": 2, "level_1_lower": (0, 4), "level_1_upper": (8, 12), "materials": "rubber", "rubber_youngs_modulus": 1e7, "rubber_poissons_ratio": 0.3,
         "rubber_density": 1000, "bodies": "block", "block_lower": (0, 0), "block_upper": (10, 10), "indenter": "cylinder", "indenter_radius": 8.0,
         "indenter_tip": (0, 10), "indenter_times": 0, "indenter_velocities": 2.0, "indenter_max_depth": 0.5, "frames": 4}
METAL = {"youngs_modulus": 70e9, "yield_stress": 400e6}
COPPER = {"youngs_modulus": 124e9, "yield_stress": 90e6, "hardening": "johnson_cook", "hardening_modulus": 292e6,
          "hardening_exponent": 0.31, "rate_sensitivity": 0.0, "reference_rate": 1.0, "thermal_exponent": 1.09, "melting_temperature": 1356.0}


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """Results of PRESS on one rank, and on two from an options file with changes by name."""
    folder = tmp_path_factory.mktemp("press")
    options.write_options(folder / "press.opts", {**PRESS, "cell_size": 7.0})
    return (mlgimp.run({**PRESS, "output_dir": folder / "one"}),
            mlgimp.run(folder / "press.opts", 2, cell_size=1.0, output_dir=folder / "two", progress=False))


def test_ranks_agree(pressed):
    one, two = pressed
    assert (one.summary["ranks"], two.summary["ranks"]) == (1, 2) and one.summary["status"] == "completed"
    np.testing.assert_allclose(two.history["load"], one.history["load"], atol=1e-9 * one.history["load"].max())
    assert list(one.frames) == list(two.frames) and list(one.frames)[-1] == 4 and abs(one.frames[4] - 0.25) < 1e-3


def test_frames_hold_each_point_once(pressed):
    for each in pressed:
        last = each.frame()
        assert {"position", "stress", "velocity", "mass", "level"} <= set(last) and set(last["level"]) == {0, 1}
        assert len(last["id"]) == len(last["position"]) == each.history["points"][-1] == len(set(last["id"]))
        assert last["mass"].sum() == pytest.approx(1e5, rel=1e-12)
        assert np.array_equal(each.frame(4)["position"], last["position"]) and each.frame(1)["position"][:, 1].min() < last["position"][:, 1].max()
    with pytest.raises(mlgimp.Error, match="no frame 9; there are [01] to 4"):
        pressed[0].frame(9)
    with pytest.raises(mlgimp.Error, match="no frame -9"):
        pressed[0].frame(-9)


def test_history_is_a_table(pressed, monkeypatch):
    history = pressed[0].history
    monkeypatch.setitem(sys.modules, "pandas", None)
    table = history.table()
    assert len(table) == len(history["load"]) and np.array_equal(table["load"], history["load"]) and table.dtype.names == tuple(history)
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=dict))
    assert history.table() == dict(history)


@pytest.mark.parametrize("ranks", [1, 2])
def test_pressure_of_contact(pressed, ranks):
    """The surface is the upper row of points: its pressure adds up to the load, ends at the contact's edge, and no other has any."""
    result = pressed[ranks - 1]
    history, frame = result.history, result.frame(4)
    _, points, tip, _ = surface.read_surface(result.folder, 4)
    x, width, pressure = points["position"][:, 0], 2 * points["half_size"][:, 0], points["contact_pressure"]
    assert abs(width.sum() - 10) < 0.1 and set(points["level"]) == {0, 1} and tip[0] == 0
    assert harness.load_on_points(frame) == pytest.approx(history["load"][-1], rel=0.006)  # a row is the mean over a step
    assert np.all(pressure[x > history["contact_half_width"][-1] + 1] == 0) and pressure.max() == frame["contact_pressure"].max()
    assert np.count_nonzero(frame["contact_pressure"]) == np.count_nonzero(pressure) == history["contact_points"][-1]
    assert np.all(result.frame(0)["contact_pressure"] == 0)


def test_pictures(pressed, tmp_path, monkeypatch):
    figures = pressed[0].plot("load_depth", "contact_pressure")
    assert list(figures) == ["load_depth", "contact_pressure"] and figures["load_depth"].axes[0].get_xlabel() == "depth (mm)"
    pressed[0].plot("von_mises_stress", window="near", out=tmp_path / "drawn")
    assert [path.name for path in (tmp_path / "drawn").iterdir()] == ["von_mises_stress.png"]
    assert list(gallery(pressed[0].folder)) == ["load_depth", "contact_pressure", "stress_xx", "stress_yy", "stress_xy", "von_mises_stress", "energy"]
    pressed[0].movie(tmp_path / "m.gif", "yy")
    from PIL import Image
    assert Image.open(tmp_path / "m.gif").n_frames == len(pressed[0].frames)
    with pytest.raises(mlgimp.Error, match="no picture stress_zx; there are load_depth"):
        pressed[0].plot("stress_zx")
    with pytest.raises(mlgimp.Error, match="m.avi: the name of a movie must end in .gif or .mp4"):
        pressed[0].movie(tmp_path / "m.avi")
    monkeypatch.setattr(animation.FFMpegWriter, "isAvailable", lambda: False)
    with pytest.raises(mlgimp.Error, match="m.mp4: ffmpeg is not installed; a movie in a .gif needs none"):
        pressed[0].movie(tmp_path / "m.mp4")


@pytest.mark.parametrize("window", ["far", (0, 1, 1, 0), (0, 1), "0,1", 3, (100, 101, 100, 101), np.zeros((2, 2))])
def test_windows_that_pictures_refuse(pressed, tmp_path, window):
    for draw in (lambda: pressed[0].plot("energy", window=window), lambda: pressed[0].movie(tmp_path / "m.gif", window=window)):
        with pytest.raises(mlgimp.Error, match="^window=[^\n]*: must (be xmin,xmax,ymin,ymax with min < max|hold a point)"):
            draw()


def test_windows_as_the_command_has_them(pressed):
    axes = [pressed[0].plot("stress_yy", window=window)["stress_yy"].axes[0] for window in ("0,5,2,8", (0, 5, 2, 8))]
    assert axes[0].get_xlim() == axes[1].get_xlim() and axes[0].get_ylim() == axes[1].get_ylim()


def test_words_that_results_refuse(pressed, tmp_path):
    """All errors of the package are its own."""
    one = pressed[0]
    calls = {"number=1: must be a whole number": lambda: one.frame("1"),
             "frame=1.5: must be a whole": lambda: one.plot("energy", frame=1.5),
             "component=foo: must be one of xx": lambda: one.movie(tmp_path / "m.gif", component="foo"),
             "folder=None": lambda: mlgimp.read(None), "path=1": lambda: one.movie(1),
             "out=1": lambda: one.plot("energy", out=1)}
    for line, call in calls.items():
        with pytest.raises(mlgimp.Error, match=f"^{line}"):
            call()
    np.testing.assert_array_equal(one.frame(np.int64(1))["id"], one.frame(1)["id"])


def test_movie_shows_the_boxes_of_each_frame(pressed, tmp_path, monkeypatch):
    read, seen = fields.read_panel, []

    def with_boxes_that_follow(directory, number=None, title=None):
        panel = read(directory, number, title)
        return panel._replace(boxes=panel.boxes + (number or 0))

    monkeypatch.setattr(fields, "read_panel", with_boxes_that_follow)
    monkeypatch.setattr(movie.GifWriter, "grab_frame", lambda self: seen.append(self.fig.axes[0].patches[0].get_x()))
    monkeypatch.setattr(movie.GifWriter, "finish", lambda self: None)
    movie.movie(pressed[0].folder, tmp_path / "m.gif")
    assert np.diff(seen) == pytest.approx([seen[1] - seen[0]] * (len(seen) - 1)) and seen[1] > seen[0]


def test_paint():
    """Rectangles cover the dots that they touch, the stretched ones beneath; what lies outside is cut off."""
    points = {"position": np.array([[1.5, 0.5], [3.0, 1.0], [9.0, 9.0]]), "half_size": np.array([[0.5, 0.5], [2.0, 1.0], [1.0, 1.0]])}
    image = fields.paint(points, np.array([1.0, 2.0, 3.0]), np.array([0.0, 4.0, 0.0, 3.0]), (3, 4))
    np.testing.assert_array_equal(image, [[np.nan, 1, 2, 2], [np.nan, 2, 2, 2], [np.nan] * 4])


def test_slice_through_the_tip():
    """In space the points beside the plane, once each, with the stresses of the plane; at the domain's end those before it."""
    middles = np.arange(8) + 0.5
    position = np.stack(np.meshgrid(middles, middles, middles, indexing="ij"), axis=-1).reshape(-1, 3)
    points = {"position": position, "half_size": np.full(position.shape, 0.5), "stress": np.arange(6) + 10 * position[:, 1:2]}
    boxes = np.array([[[0, 0, 0], [8, 8, 8]], [[0, 0, 4], [4, 4, 8]]], float)
    for y, row, levels in ((0, 0.5, 2), (4, 4.5, 2), (3.1, 3.5, 2), (8, 7.5, 1)):
        cut, met = fields.slice_of(points, boxes, y)
        assert cut["position"].shape == (64, 2) and len(met) == levels
        np.testing.assert_array_equal(cut["stress"], np.tile(np.array([0, 2, 1, 5]) + 10 * row, (64, 1)))


def test_boxes_that_follow():
    """A box is that of the last move before the frame, which is written before boxes move; a level that rests has none."""
    levels = [{"lower": [0, 0], "upper": [8, 8]}, {"lower": [0, 4], "upper": [4, 8]}, {"lower": [0, 6], "upper": [2, 8]}]
    moves = [{"level": 1, "time": 0.0, "active": True, "lower": [0, 6], "upper": [2, 8]},
             {"level": 1, "time": 1.0, "active": True, "lower": [0, 4], "upper": [4, 8]},
             {"level": 2, "time": 1.0, "active": False, "lower": [0, 7], "upper": [1, 8]}]
    summary = {"levels": levels, "regrids": moves}
    assert results.level_boxes(summary, 0.5)[:, 1, 0].tolist() == [8, 2]
    assert results.level_boxes(summary, 1.0)[:, 1, 0].tolist() == [8, 2]
    assert results.level_boxes(summary, 1.5)[:, 1, 0].tolist() == [8, 4]
    assert results.level_boxes({"levels": levels}, 1.0)[:, 1, 0].tolist() == results.level_boxes(summary)[:, 1, 0].tolist() == [8, 4, 2]


# ---- errors ----

@pytest.mark.parametrize("changes, line", [({"cell_size": -1}, "mlgimp: error: -cell_size -1: must be"), ({"cell_sise": 1}, "mlgimp: error: -cell_sise: nothing reads"),
                                           ({"options_file": "none.opts"}, "mlgimp: error: .*none.opts")])
@pytest.mark.parametrize("ranks", [1, 2])
def test_the_programs_line(tmp_path, changes, line, ranks):
    with pytest.raises(mlgimp.RunError, match=f"^{line}[^\n]*$"):
        mlgimp.run({**PRESS, "output_dir": tmp_path / "bad"}, ranks, **changes)


def test_warnings_are_warnings(tmp_path):
    """They name the caller's line, come while the program runs (made errors they end it), and are in the summary."""
    case = {**PRESS, "output_dir": tmp_path / "w", "contact": "point_pressure", "frames": 0, "overwrite": True}
    with pytest.warns(UserWarning, match="mlgimp: warning: -contact point_pressure") as told:
        results = mlgimp.run({**case, "max_steps": 2})
    assert told[0].filename == __file__ and any("point_pressure" in line for line in results.summary["warnings"])
    with warnings.catch_warnings(), pytest.raises(UserWarning, match="point_pressure"):
        warnings.simplefilter("error")
        begun = time.monotonic()
        mlgimp.run({**case, "end_time": 1e3})
    assert time.monotonic() - begun < 20


def test_what_is_not_there(tmp_path, monkeypatch):
    with pytest.raises(mlgimp.ResultError, match="no results here"):
        mlgimp.read(tmp_path)
    for ranks in (0, 1.5, "2", True):
        with pytest.raises(mlgimp.Error, match=f"ranks={ranks}: must be a whole number >= 1"):
            mlgimp.run(PRESS, ranks=ranks)
    for case in (None, [PRESS]):
        with pytest.raises(mlgimp.Error, match="options=.*: must be the path of an options file, or a dict"):
            mlgimp.run(case)
    monkeypatch.setenv("MLGIMP_BIN", str(tmp_path))
    with pytest.raises(mlgimp.Error, match=f"not at {tmp_path}/mlgimp: `make` builds it"):
        mlgimp.run(PRESS, np.int64(1))


def test_where_results_go(tmp_path, monkeypatch):
    """The folder that the call names, or else the options file, or else one of the file's name in output/."""
    monkeypatch.chdir(tmp_path)
    case = {**PRESS, "frames": 0, "max_steps": 1}
    options.write_options("said.opts", {**case, "output_dir": "there"})
    options.write_options("plain.opts", case)
    found = [mlgimp.run("said.opts"), mlgimp.run("said.opts", output_dir="here"), mlgimp.run("plain.opts"), mlgimp.run(case)]
    assert [str(results.folder) for results in found] == ["there", "here", "output/plain", "output/run"]
    for more in ({"output_dir": 3}, {"options_file": 3}):
        with pytest.raises(mlgimp.Error, match="=3: must be the path of a file or folder"):
            mlgimp.run({**case, **more})


def test_capitals_of_options(tmp_path, monkeypatch):
    """The program does not see them: results are read from where it has written them, and one option is not given twice."""
    monkeypatch.chdir(tmp_path)
    case = {**PRESS, "frames": 0, "max_steps": 2}
    options.write_options("small.opts", {**case, "Output_Dir": "it's"})
    found = [mlgimp.run({**case, "Output_dir": "other"}), mlgimp.run("small.opts"), mlgimp.run("small.opts", OUTPUT_DIR="third")]
    assert [run.folder.name for run in found] == ["other", "it's", "third"]
    for wrong, line in (({**case, "Frames": 1}, "Frames: must be given once"), ({"-options_file": "small.opts"}, "-options_file: must be an option's name")):
        with pytest.raises(mlgimp.Error, match=line):
            mlgimp.run(wrong)
    with pytest.raises(mlgimp.Error, match="-output_dir my out: must have neither blanks"):
        options.write_options("blank.opts", {"output_dir": "my out"})


def test_bar(capsys):
    show_bar(1, 3, "1 of 3")
    assert capsys.readouterr().out == "\r[##########....................] 1 of 3   "


# ---- options ----

def test_options_file_round_trip(tmp_path):
    written = {"a": 7e10, "b": (0.1, 1 / 3), "c": True, "d": "a,text", "e": None, "f": np.float64(2.5e-7), "g": np.arange(2)}
    options.write_options(tmp_path / "o.opts", [written, {"h": 1}], "Two lines\nabove")
    read = options.read_options(tmp_path / "o.opts")
    assert read == {"a": "7e+10", "b": "0.1,0.3333333333333333", "c": "true", "d": "a,text", "e": None, "f": "2.5e-07", "g": "0,1", "h": "1"}
    assert options.of_words(options.to_words(written)) == {name: read[name] for name in written}


# ---- indent ----

def test_indent(tmp_path, monkeypatch, expect):
    """An options file that gives the same run again, and the hardness of the metal."""
    monkeypatch.chdir(tmp_path)
    test = mlgimp.indent("j2", **METAL, hardening_modulus=1e9, tip="sphere", radius=2e-6, depth=100e-9, cells=4, block=8, tolerance=0.1, file="ball.opts",
                         progress=False, frames=0, options={"block_points_per_cell": 1, "history_interval": 10})
    row, = test.oliver_pharr()
    expect("depth, um", row["depth_um"], near=0.1, tolerance=1e-6)
    expect("hardness over the flow stress at 8 % of strain", row["true_hardness_GPa"] / 0.48, at_least=2.2, at_most=3.2)  # Tabor: 2.8; here on 4 cells
    text = (tmp_path / "ball.opts").read_text()
    assert "-block_points_per_cell 1\n" in text and text.startswith("# Indentation of j2 by sphere, 1e-07 m deep")
    assert test.folder.resolve() == tmp_path / "output" / "ball"
    given = options.read_options("ball.opts")
    assert given["specimen_yield_stress"] == "4e+08" and given["indenter_radius"] == "2e-06" and test.summary["options"]["-indenter_radius"] == "2e-06"
    with pytest.raises(mlgimp.Error, match="ball.opts: is there already"):
        mlgimp.indent("j2", **METAL, depth=100e-9, file="ball.opts")
    again = harness.run({"options_file": tmp_path / "ball.opts", "max_steps": 40})
    np.testing.assert_array_equal(again.history["load"], test.history["load"][:len(again.history["load"])])


def test_flow_stress_of_a_metal():
    """That of johnson_cook is Ludwik's, less what the metal softens up to its temperature; a law that is not known is hard."""
    rise = indentation.TABOR * (90e6 + 292e6 * indentation.STRAIN ** 0.31)
    assert indentation.hardness(COPPER) == pytest.approx(rise, rel=1e-12)
    assert indentation.hardness({**COPPER, "initial_temperature": 700}) == pytest.approx(rise, rel=1e-12)
    hot = {**COPPER, "reference_temperature": 300, "melting_temperature": 1300, "thermal_exponent": 0.5, "initial_temperature": 550}
    assert indentation.hardness(hot) == pytest.approx(rise / 2, rel=1e-12)
    assert indentation.hardness({**hot, "initial_temperature": 200}) == pytest.approx(rise, rel=1e-12)
    for law in ("table", "of a later version"):
        assert indentation.hardness({**COPPER, "hardening": law}) == np.inf


def test_tip_goes_back_until_it_is_free(tmp_path):
    """Also from a metal of johnson_cook, which was taken for one that does not harden: 0.28 of the load were left."""
    groups = indentation.indentation_options("j2", **COPPER, depth=200e-9, cells=4, block=8, tolerance=0.1, options={"frames": 0})
    options.write_options(tmp_path / "case.opts", groups)
    load = harness.run({"options_file": tmp_path / "case.opts"}).history["load"]
    assert load[-1] < 0.02 * load.max()


@pytest.mark.parametrize("law, case", [
    ("j2", dict(METAL, depth=200e-9)), ("j2", dict(METAL, load=10e-3)), ("neo_hookean", dict(youngs_modulus=70e9, tip="flat_punch", radius=1e-6, depth=20e-9)),
    ("j2", dict(METAL, tip="sphere", radius=5e-6, load=5e-3, unload=False)), ("j2", dict(METAL, tip="vickers", depth=1e-6, geometry="3d", cells=5, block=10)),
    ("j2", dict(METAL, tip="berkovich", load=1e-3, geometry="3d", cells=4, block=9)), ("j2", dict(METAL, depth=200e-9, hardening="power", hardening_exponent=0.1)), ("j2", dict(COPPER, depth=200e-9)), ("j2", dict(COPPER, load=1e-3)),
    ("neo_hookean", dict(youngs_modulus=1e6, tip="cone", half_angle=60, tip_radius=1e-7, depth=1e-5, cells=40, block=8))])
def test_cases_are_accepted(tmp_path, law, case):
    """The program takes each, and the contact stays inside the finest level."""
    groups = indentation.indentation_options(law, **case, options={"max_steps": 1, "frames": 0, "block_points_per_cell": 1})
    options.write_options(tmp_path / "case.opts", groups)
    result = harness.run({"options_file": tmp_path / "case.opts"})
    finest = result.summary["levels"][-1]
    shape = indentation.shape_of(case.get("tip", "berkovich"), case.get("geometry", "axisymmetric"), case.get("half_angle"), case.get("radius"), 0)
    radius = indentation.size_of_contact(shape, {"poissons_ratio": 0.3, **case}, case.get("depth"), case.get("load"))
    assert radius == pytest.approx(case.get("cells", 8) * finest["cell_size"], rel=0.05)
    assert finest["upper"][0] > 2.2 * radius


@pytest.mark.parametrize("case, line", [
    (dict(METAL), "depth, load: one of them must be given"), (dict(METAL, depth=1e-7, load=1e-3), "depth, load"), (dict(METAL, depth=200), "depth=200: must be in .* m; 200 nm"),
    (dict(METAL, depth="deep"), "depth=deep"), (dict(METAL, depth=float("nan")), "depth=nan"), (dict(METAL, load=-1), "load=-1: must be a number > 0 in N"),
    (dict(youngs_modulus=70, depth=1e-7), "youngs_modulus=70: must be .* in Pa; 70 GPa are 70e9"), (dict(depth=1e-7), "youngs_modulus=None"),
    (dict(METAL, depth=1e-7, poissons_ratio=0.5), "poissons_ratio=0.5"), (dict(METAL, depth=1e-7, tip="knoop"), "tip=knoop: must be one of cone, sphere"),
    (dict(METAL, depth=1e-7, tip="cone"), "half_angle: must be given for tip=cone"), (dict(METAL, depth=1e-7, radius=1e-6), "radius: must be left out"),
    (dict(METAL, depth=1e-7, tip="sphere", radius=5), "radius=5"), (dict(METAL, depth=2e-6, tip="sphere", radius=1e-6), "depth=2e-06: must be less than the radius"),
    (dict(METAL, depth=1e-7, geometry="plane_strain"), "geometry=plane_strain"), (dict(METAL, depth=1e-7, cells=1), "cells=1"),
    (dict(METAL, depth="2e-7"), "depth=2e-7: must be .* not as a text"),
    (dict(METAL, depth=1e-7, poissons_ratio="0.33"), "poissons_ratio=0.33: .* not as a text"),
    (dict(METAL, depth=1e-7, unload="no"), "unload=no: must be True or False"),
    (dict(METAL, depth=1e-7, overwrite="no"), "overwrite=no"),
    (dict(METAL, depth=1e-7, options=[1]), "options=.*: must be a dict"),
    (dict(METAL, depth=1e-7, options={"geometry": "3d"}), "options: geometry must be given as the argument"),
    (dict(METAL, depth=1e-7, tip=["cone"]), "tip=.*: must be one of cone"),
    (dict(METAL, depth=1e-7, tip="sphere", radius=1e-6, tip_radius=1e-8), "tip_radius: must be left out for tip=sphere"),
    (dict(METAL, depth=1e-7, block=2), "block=2"), (dict(METAL, depth=1e-7, hardening="power"), "hardening_exponent: must be given"),
    (dict(COPPER, depth=1e-7, reference_temperature=293, options={"initial_temperature": 1400}), "melting_temperature=1356: must be above"),
    (dict(COPPER, depth=1e-7, options={"initial_temperature": "warm"}), "initial_temperature=warm: must be a number")])
def test_what_indent_refuses(tmp_path, case, line):
    with pytest.raises(mlgimp.Error, match=f"^{line}[^\n]*$"):
        mlgimp.indent("j2", **case, file=tmp_path / "case.opts")
    assert not (tmp_path / "case.opts").exists()


def test_numbers_of_any_type():
    """Those of numpy, also as arrays without dimensions, give the same case as those of Python."""
    plain = indentation.indentation_options("j2", youngs_modulus=2.0**36, yield_stress=4e8, depth=0.125e-2, cells=5, unload=False)
    of_numpy = indentation.indentation_options("j2", youngs_modulus=np.float32(2.0**36), yield_stress=np.int64(400000000),
                                               depth=np.array(0.125e-2), cells=np.int64(5), unload=np.bool_(False))
    assert plain == of_numpy


def test_the_program_refuses_the_rest(tmp_path, monkeypatch):
    """The options file of a case that it refuses does not stay in the way of the next call; one that was there before stays."""
    monkeypatch.chdir(tmp_path)
    for before in (False, True):
        if before:
            (tmp_path / "indentation.opts").touch()
        with pytest.raises(mlgimp.RunError, match="-specimen_yield_stres: nothing reads this option"):
            mlgimp.indent("j2", **METAL, yield_stres=1, depth=1e-7, overwrite=before)
        assert (tmp_path / "indentation.opts").exists() == before


def test_the_file_of_a_run_that_failed_stays(tmp_path, monkeypatch):
    """It is the record of results that are there, also in a folder that its options name."""
    def fails(file, *others, **more):
        (tmp_path / "there").mkdir()
        (tmp_path / "there" / "history.csv").touch()
        raise mlgimp.RunError("mlgimp: error: step 7")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(indentation, "run", fails)
    with pytest.raises(mlgimp.RunError):
        mlgimp.indent("j2", **METAL, depth=1e-7, file="case.opts", options={"output_dir": "there"})
    assert (tmp_path / "case.opts").exists()



def test_version():
    """The package has the program's version."""
    version = re.search(r'kVersion = "(.*)"', (harness.ROOT / "src/program/versions.cpp").read_text())[1]
    assert f'version = "{version}"' in (harness.ROOT / "pyproject.toml").read_text()


@pytest.mark.parametrize("page", ["README.md", "docs/python.md"])
def test_documents_call_what_there_is(page):
    """Functions of the package and members of results, with their arguments, in the blocks of Python."""
    blocks = re.findall(r"^```python\n(.*?)^```", (harness.ROOT / page).read_text(), re.M | re.S)
    assert blocks
    for call in (node for block in blocks for node in ast.walk(ast.parse(block)) if isinstance(node, (ast.Call, ast.Attribute))):
        name = call if isinstance(call, ast.Attribute) else call.func
        owner = {"mlgimp": mlgimp, "test": mlgimp.Results, "run": mlgimp.Results}.get(getattr(getattr(name, "value", None), "id", ""))
        if owner is None:
            continue
        member = getattr(owner, name.attr)
        if isinstance(call, ast.Call):
            given = [None] * (len(call.args) + (owner is mlgimp.Results))
            inspect.signature(member).bind(*given, **{each.arg: None for each in call.keywords})


def test_style_forgets_nothing_else():
    """What is set while something is drawn, as by a notebook's backend with its first figure, stays; the style does not."""
    before = pictures.plt.rcParams["font.size"], pictures.plt.rcParams["interactive"]

    @pictures.styled
    def draw():
        pictures.plt.rcParams["interactive"] = not before[1]
        return pictures.plt.rcParams["font.size"]
    try:
        assert draw() == 12 and pictures.plt.rcParams["font.size"] == before[0] != 12 and pictures.plt.rcParams["interactive"] != before[1]
    finally:
        pictures.plt.rcParams["interactive"] = before[1]


def test_installs_without_a_network(tmp_path):
    """pip needs nothing but setuptools; the installed package finds the program by MLGIMP_BIN."""
    if not all(map(importlib.util.find_spec, ("pip", "setuptools", "wheel"))):
        pytest.skip("needs pip, setuptools and wheel")
    for name in ("pyproject.toml", "LICENSE"):
        shutil.copy(harness.ROOT / name, tmp_path)
    shutil.copytree(harness.ROOT / "python", tmp_path / "python", ignore=shutil.ignore_patterns("*.egg-info", "__pycache__"))
    install = [sys.executable, "-m", "pip", "install", "-q", "--no-index", "--no-build-isolation", "--no-deps", "--target", "there", "."]
    subprocess.run(install, cwd=tmp_path, check=True, capture_output=True)
    look = "import mlgimp.program; print(mlgimp.__file__, mlgimp.program.find_program())"
    done = subprocess.run([sys.executable, "-c", look], cwd="/", check=True, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(tmp_path / "there"), "MLGIMP_BIN": str(harness.BIN)})
    assert done.stdout.split() == [str(tmp_path / "there" / "mlgimp" / "__init__.py"), str(harness.PROGRAM)]
