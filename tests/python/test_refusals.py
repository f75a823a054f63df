"""Checks that the scripts end in one line 'error: ...' where files or arguments are not what they should be."""
import json
import os
import re
import subprocess
import sys

import h5py
import pytest

import converge
import figures
import harness
import plot
import scaling
from mlgimp import results
from made_curves import GOOD
from test_scripts import HISTORY, write_results

pytestmark = pytest.mark.fast


@pytest.fixture
def made(tmp_path):
    """A folder with the results of a run."""
    return write_results(tmp_path / "made", levels=2, cells=8)


def refusal(main, *words):
    """The one line with which a script ends."""
    with pytest.raises(SystemExit) as caught:
        main([str(word) for word in words])
    assert re.fullmatch(r"error: [^\n]+", str(caught.value.code)), caught.value.code
    return caught.value.code


# ---- plot.py ----

@pytest.mark.parametrize("out", ["/proc", "/proc/pictures", "/dev/null", "/dev/null/pictures"])
def test_pictures_into_a_folder_that_cannot_be(made, out):
    assert out in refusal(plot.main, made, "--out", out)
    assert "must be a folder for 6 pictures, or stand beside --picture" in refusal(plot.main, made, "--out", "figure.pdf")
    assert "gold.jpg: must end in .png, .pdf, .svg" in refusal(plot.main, made, "--picture", "energy", "--out", "gold.jpg")


@pytest.mark.parametrize("window", ["nan,1,0,1", "0,inf,0,1", "-inf,0,0,1", "1,0,0,1", "0,1", "a,b,c,d"])
def test_window(made, window):
    assert f"{window}: must be xmin,xmax,ymin,ymax" in refusal(plot.main, made, f"--window={window}")


def test_window_that_holds_no_point(made):
    """The refusal comes before any picture is written."""
    before = set(made.iterdir())
    assert "window=1,2,1,2: must hold a point; they lie in -1.6" in refusal(plot.main, made, "--window=1,2,1,2")
    assert "must hold a point" in refusal(plot.main, made, "--window=1,2,1,2", "--movie", made / "m.gif")
    assert set(made.iterdir()) == before


HISTORIES = {
    "empty": (b"", "no column time"), "binary": (bytes(range(128, 256)), "no text"),
    "another table": (b"depth_m,load_N\n0,0\n1,2\n", "no column time"), "text": (b"hello\nworld\n", "no column"),
    "a row that is too short": (",".join(HISTORY).encode() + b"\n1\n", f"{len(HISTORY)} columns"),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_history(made, name):
    content, expected = HISTORIES[name]
    (made / "history.csv").write_bytes(content)
    line = refusal(plot.main, made)
    assert "history.csv" in line and expected in line


SUMMARIES = {
    "a list": [1, 2], "a number": 3, "levels without boxes": {"levels": [{"cell_size": 1}]},
    "levels of numbers": {"levels": [1, 2]},
    "half a box": {"levels": [{"lower": [0], "upper": [1, 1]}]}, "a box of text": {"levels": [{"lower": "ab", "upper": "cd"}]},
    "levels that are no list": {"levels": 3},
}


@pytest.mark.parametrize("name", SUMMARIES)
def test_summary(made, name):
    (made / "summary.json").write_text(json.dumps(SUMMARIES[name]))
    assert "summary.json" in refusal(plot.main, made)
    assert "summary.json" in refusal(figures.main, "cells", made / "cells.png", f"{made}:run")


def test_binary_summary(made):
    (made / "summary.json").write_bytes(bytes(range(128, 256)))
    assert "summary.json" in refusal(plot.main, made)


@pytest.mark.parametrize("name", ["position", "half_size", "stress"])
def test_frame(made, name):
    with h5py.File(made / "points_000001.h5", "a") as file:
        del file["level_1"][name]
    assert name in refusal(plot.main, made)
    with h5py.File(made / "points_000001.h5", "a") as file:
        file["level_1"][name] = [1.0, 2.0]
    assert "points_000001.h5" in refusal(plot.main, made)


def test_other_files_beside_frames(made):
    """They are left alone, as the program leaves them."""
    (made / "points_old.h5").write_bytes(b"")
    (made / "points_2_copy.h5").write_bytes(b"")
    assert set(results.numbered_frames(made)) == {results.number_in(path) for path in made.glob("points_00*.h5")}


def test_frame_that_holds_no_groups(made):
    with h5py.File(made / "points_000001.h5", "a") as file:
        del file["level_1"]
        file["level_1"] = [1.0]
    assert "points_000001.h5" in refusal(plot.main, made)


# ---- figures.py ----

@pytest.mark.parametrize("picture", ["none/curves.png", "curves.abc"])
def test_picture_that_cannot_be_written(made, picture):
    assert picture in refusal(figures.main, "load-depth", made / picture, f"{made}:run")
    assert picture in refusal(figures.main, "fields", made / picture, f"{made}:run")


def test_field_that_points_do_not_have(made):
    assert "no temperature" in refusal(figures.main, "fields", made / "fields.png", f"{made}:run", "--component", "temperature")


def test_label_that_is_no_formula(made):
    line = refusal(figures.main, "load-depth", made / "curves.png", f"{made}:$\\frac{{$", f"{made}:other")
    assert "cannot be drawn" in line


def test_levels_without_cells(made):
    assert "cell_size" in refusal(figures.main, "cells", made / "cells.png", f"{made}:run")


def test_run_without_moves_of_boxes(made):
    assert "no boxes that follow" in refusal(figures.main, "moves", made / "moves.png", made)


@pytest.mark.parametrize("words", [[], ["curves"], ["load-depth"], ["load-depth", "curves.png", "no label"],
                                   ["fields", "fields.png", "made:run", "--component", "zz9"]])
def test_command_line(words):
    refusal(figures.main, *words)


# ---- converge.py ----

@pytest.mark.parametrize("content", [bytes(range(256)), b"-cell_size 1 2\n"], ids=["binary", "two values"])
def test_options_file(tmp_path, content):
    file = tmp_path / "case.opts"
    file.write_bytes(content)
    assert str(file) in refusal(converge.main, file)


# ---- all ----

def test_scaling_of_no_ranks():
    for word in ("nosuch.opts", "0"):
        assert f"{word}: must be a whole number >= 1" in refusal(scaling.main, word)


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("words", [["plot.py", "made"], ["indentation.py", "m.csv", "--tip=vickers"]], ids=["plot", "analysis"])
def test_a_reader_that_has_gone(made, words, unbuffered):
    """As `| head`: the command ends without a word."""
    (made.parent / "m.csv").write_text(GOOD)
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([sys.executable, harness.ROOT / "scripts" / words[0], *words[1:]], cwd=made.parent, stdout=writer,
                          stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": unbuffered})
    os.close(writer)
    assert (done.returncode, done.stderr) == (1, "")


def test_no_home(made):
    """A user without a folder of his own hears nothing of matplotlib's cache."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "MPL"))}
    for script in ("plot.py", "figures.py"):
        words = [made] if script == "plot.py" else ["load-depth", made / "curves.png", f"{made}:run"]
        done = subprocess.run([sys.executable, harness.ROOT / "scripts" / script, *words], capture_output=True, text=True,
                              env={**environment, "HOME": "/dev/null/none"})
        assert (done.returncode, done.stderr) == (0, "")


# ---- Pythons without the modules ----

SCRIPTS = sorted(path.name for path in (harness.ROOT / "scripts").glob("*.py") if "numpy" in path.read_text() or "command" in path.read_text())
IMPORT = f"import sys; sys.path.insert(0, {str(harness.ROOT / 'python')!r}); import mlgimp"


def without(words, hidden, folder):
    """What Python prints to standard error where modules cannot be imported, in the way that a text says, or without any packages."""
    if hidden is None:
        return subprocess.run([sys.executable, "-I", "-S", *words], capture_output=True, text=True, cwd=folder)
    for name, problem in hidden.items():
        (folder / f"{name}.py").write_text(f"raise {problem}")
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, cwd=folder, env={**os.environ, "PYTHONPATH": str(folder)})


@pytest.mark.parametrize("hidden, problem", [
    (None, "has no module numpy: take"), ({"numpy": "ModuleNotFoundError(\"No module named 'numpy'\", name='numpy')"}, "has no module numpy: take"),
    ({"h5py": "ImportError('\\n\\nlibhdf5.so: not found\\nREAD THIS')"}, r"has no module h5py that works \(libhdf5.so: not found\): take"),
    ({"matplotlib": "ImportError('no')"}, r"has no module matplotlib that works \(no\): take")], ids=["no packages", "no numpy", "a broken h5py", "a broken matplotlib"])
@pytest.mark.parametrize("script", ["plot.py", "indentation.py", "bench.py"])
def test_a_python_without_modules(tmp_path, hidden, problem, script):
    done = without([harness.ROOT / "scripts" / script, "made"], hidden, tmp_path)
    assert done.returncode == 1 and done.stdout == ""
    assert re.fullmatch(rf"error: {re.escape(sys.executable)} {problem} /usr/bin/python3 [^\n]* -m pip install numpy scipy h5py matplotlib\n", done.stderr), done.stderr


def test_all_scripts_of_a_python_without_modules(tmp_path):
    assert len(SCRIPTS) > 8
    for script in SCRIPTS:
        done = without([harness.ROOT / "scripts" / script], None, tmp_path)
        assert re.fullmatch(r"error: [^\n]* has no module numpy: [^\n]*\n", done.stderr), (script, done.stderr)


def test_the_package_in_a_python_without_modules(tmp_path):
    """One line where nothing catches it, an ImportError to catch, and other errors with their traceback."""
    done = without(["-c", IMPORT], None, tmp_path)
    assert done.returncode == 1 and re.fullmatch(r"error: [^\n]* has no module numpy: [^\n]*\n", done.stderr)
    done = without(["-c", f"try:\n  {IMPORT}\nexcept ImportError as problem: print(problem)\n1/0"], None, tmp_path)
    assert "has no module numpy" in done.stdout and "Traceback" in done.stderr and "ZeroDivisionError" in done.stderr
    drawn = f"{IMPORT}; mlgimp.Results('.').plot('energy')"
    done = without(["-c", drawn], {"matplotlib": "ImportError('no')"}, tmp_path)
    assert re.fullmatch(r"error: [^\n]* has no module matplotlib that works [^\n]*\n", done.stderr), done.stderr
