"""Checks the package mlgimp from outside: runs, results, pictures and errors."""
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
from mlgimp import fields, movie, options, parallelograms, pictures, program, results, surface
from mlgimp.gallery import gallery
from mlgimp.program import show_bar

pytestmark = pytest.mark.fast

# A cylinder that comes down on a block and goes back, on two levels.
PRESS = {"domain_lower": (0, 0), "domain_upper": (12.0, 12.0), "cell_size": 1.0, "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry",
         "levels": 2, "level_1_lower": (0, 4), "level_1_upper": (8, 12), "materials": "rubber", "rubber_youngs_modulus": 1e7, "rubber_poissons_ratio": 0.3,
         "rubber_density": 1000, "bodies": "block", "block_lower": (0, 0), "block_upper": (10, 10), "indenter": "cylinder", "indenter_radius": 8.0,
         "indenter_tip": (0, 10), "indenter_times": 0, "indenter_velocities": 2.0, "indenter_max_depth": 0.5, "frames": 4}


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
    counted = np.count_nonzero(pressure)  # a cell farther than the columns that carry load
    assert np.count_nonzero(frame["contact_pressure"]) == counted and 0 <= counted - history["contact_points"][-1] <= 2
    assert np.all(result.frame(0)["contact_pressure"] == 0)


def mean_and_largest(folder, number):
    """The mean pressure of contact that a picture shows, and the largest, in its unit; None for the mean where there is no contact."""
    figure = surface.contact_pressure(folder, number)
    lines = figure.axes[0].lines
    pictures.plt.close(figure)
    return lines[1].get_ydata()[0] if len(lines) > 1 else None, lines[0].get_ydata().max()


@pytest.mark.parametrize("changed", [{}, {"thickness": 3, "indenter_unload_velocity": 2},
                                     {"geometry": "axisymmetric", "indenter": "sphere", "indenter_unload_velocity": 2}],
                         ids=["plane", "thick, back", "axis, back"])
def test_mean_pressure(tmp_path, changed):
    """It is that of the frame, whatever rows the history has."""
    case = {**PRESS, "cell_size": 0.5, "frames": 7, **changed}
    all_rows, few_rows = (mlgimp.run({**case, "history_interval": interval, "output_dir": tmp_path / str(interval)}, progress=False)
                          for interval in (1, 37))
    for number, time in list(all_rows.frames.items())[1:]:
        mean, largest = mean_and_largest(all_rows.folder, number)
        assert (mean, largest) == mean_and_largest(few_rows.folder, number) and 0.4 * largest < mean < largest
        points, options = surface.read_surface(all_rows.folder, number)[1::2]
        history = all_rows.history
        assert surface.carried_load(points, options) == pytest.approx(np.interp(time, history["time"], history["load"]), rel=0.02)
    assert mean_and_largest(all_rows.folder, 0) == (None, 0)


def test_mean_pressure_where_the_tip_turns(tmp_path):
    """The tutorial's case: the row of the step in which the tip turns has the mean load of that step, and the frame is at its end."""
    text = (harness.ROOT / "docs" / "tutorial.md").read_text()
    (tmp_path / "press.opts").write_text("".join(re.findall(r"```opts press.opts\n(.*?)```", text, re.DOTALL)))
    result = mlgimp.run(tmp_path / "press.opts", output_dir=tmp_path / "out", progress=False)
    turn = surface.frame_of_largest_load(result.folder)
    mean, largest = mean_and_largest(result.folder, turn)
    assert turn == 10 and 0.8 * largest < mean < largest


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


def test_movie_has_a_colour_bar_in_each_frame(pressed, tmp_path, monkeypatch):
    """With its label and numbers, and with more than one colour."""
    seen = []

    def grab(writer):
        axes, = (each for each in writer.fig.axes if each.images)
        bar, = axes.child_axes
        writer.fig.canvas.draw()
        image = np.asarray(writer.fig.canvas.buffer_rgba())
        x, y = (slice(*np.sort(ends).astype(int)) for ends in np.transpose(bar.get_window_extent().get_points()))
        colours = np.unique(image[::-1][y, x].reshape(-1, 4), axis=0)
        seen.append((bar.get_ylabel(), len(bar.get_yticklabels()) > 2, len(colours) > 50, len(axes.images), len(axes.patches)))
    monkeypatch.setattr(movie.GifWriter, "grab_frame", grab)
    monkeypatch.setattr(movie.GifWriter, "finish", lambda self: None)
    movie.movie(pressed[0].folder, tmp_path / "m.gif")
    assert len(seen) == len(pressed[0].frames) > 3 and set(seen) == {("von Mises stress (kPa)", True, True, 1, 3)}  # two boxes and the indenter


def test_paint():
    """Rectangles cover the dots that they touch, the stretched ones beneath; what lies outside is cut off."""
    points = {"position": np.array([[1.5, 0.5], [3.0, 1.0], [9.0, 9.0]]), "half_size": np.array([[0.5, 0.5], [2.0, 1.0], [1.0, 1.0]])}
    image = parallelograms.paint(points, np.array([1.0, 2.0, 3.0]), np.array([0.0, 4.0, 0.0, 3.0]), (3, 4))
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

@pytest.mark.parametrize("changes, line", [({"cell_size": -1}, "mlgimp: error: -cell_size -1: must be"), ({"cell_sise": 1}, "mlgimp: error: -cell_sise: unknown or unused"),
                                           ({"options_file": "none.opts"}, "mlgimp: error: .*none.opts")])
@pytest.mark.parametrize("ranks", [1, 2])
def test_the_programs_line(tmp_path, changes, line, ranks):
    with pytest.raises(mlgimp.RunError, match=f"^{line}[^\n]*$"):
        mlgimp.run({**PRESS, "output_dir": tmp_path / "bad"}, ranks, **changes)


def test_names_that_may_have_meant_another(tmp_path):
    """Of arguments before the run, of options where the program does not read them."""
    for name in ("rank", "np"):
        with pytest.raises(mlgimp.Error, match=f"^{name}: there is no such argument; it may be ranks$"):
            mlgimp.run(PRESS, **{name: 2})
    with pytest.raises(mlgimp.RunError, match="-friction: unknown or unused option in this case; it may be indenter_friction$"):
        mlgimp.run({**PRESS, "output_dir": tmp_path / "bad"}, friction=0.2)
    with pytest.raises(mlgimp.Error, match="^evaluation: there is no such argument; it may be evaluations$"):
        mlgimp.fit(None, None, "E", evaluation=3)


def test_warnings_are_warnings(tmp_path):
    """They name the caller's line, come while the program runs (made errors they end it), and are in the summary."""
    case = {**PRESS, "output_dir": tmp_path / "w", "contact": "point_pressure", "frames": 0, "overwrite": True}
    with pytest.warns(UserWarning, match="mlgimp: warning: -contact point_pressure") as caught:
        results = mlgimp.run({**case, "max_steps": 2})
    assert caught[0].filename == __file__ and any("point_pressure" in line for line in results.summary["warnings"])
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


@pytest.mark.parametrize("columns", [20, 40, 60, 72, 80, 83, 120, None])
def test_bar_stays_in_its_line(capsys, monkeypatch, columns):
    """A line of the terminal's width would begin a new one each time; where the width is not known it is 80."""
    monkeypatch.setenv("COLUMNS", str(columns or 0))
    monkeypatch.setattr(sys, "__stdout__", None)  # no terminal
    for depth, load, percent, left in (("1.234e-07", "1.234e-3", "7", "1234"), ("9.99e-05", "1.234e-7", "100", "0")):
        program.show_progress(f"\rstep 12  depth {depth} m  load {load} N  ... {percent} %  {left} s left")
        begin, line = capsys.readouterr().out.split("\r")
        assert begin == "" and len(line) < (columns or 80) and f"{percent} %"[:10] in line
        assert ("]" in line) == ((columns or 80) >= 60) and ("s left" in line) == ((columns or 80) >= 60)


# ---- options ----

def test_options_file_round_trip(tmp_path):
    written = {"a": 7e10, "b": (0.1, 1 / 3), "c": True, "d": "a,text", "e": None, "f": np.float64(2.5e-7), "g": np.arange(2)}
    options.write_options(tmp_path / "o.opts", [written, {"h": 1}], "Two lines\nabove")
    read = options.read_options(tmp_path / "o.opts")
    assert read == {"a": "7e+10", "b": "0.1,0.3333333333333333", "c": "true", "d": "a,text", "e": None, "f": "2.5e-07", "g": "0,1", "h": "1"}
    assert options.of_words(options.to_words(written)) == {name: read[name] for name in written}


def test_version():
    """The package has the program's version."""
    version = re.search(r'kVersion = "(.*)"', (harness.ROOT / "src/program/system/versions.cpp").read_text())[1]
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
    assert all((tmp_path / "there" / "mlgimp" / name).is_file() for name in ("page.css", "viewer.js"))
    look = "import mlgimp.program; print(mlgimp.__file__, mlgimp.program.find_program())"
    done = subprocess.run([sys.executable, "-c", look], cwd="/", check=True, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(tmp_path / "there"), "MLGIMP_BIN": str(harness.BIN)})
    assert done.stdout.split() == [str(tmp_path / "there" / "mlgimp" / "__init__.py"), str(harness.PROGRAM)]
