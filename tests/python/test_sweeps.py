"""Sweeps: the table, resuming, failures as rows, the command; and runs that the user interrupts."""
import csv
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import harness
import mlgimp
from mlgimp import options, program, sweeps
from mlgimp.notebook_view import html_of
from test_outputs import Checker
from test_package import PRESS

pytestmark = pytest.mark.fast

CASE = {**PRESS, "frames": 1}


def ball(stiffness, radius):
    """Options of PRESS by other words."""
    return {**CASE, "rubber_youngs_modulus": stiffness, "indenter_radius": radius}


@pytest.fixture
def runs(monkeypatch):
    """The options of the runs that the program is asked for."""
    asked, execute = [], sweeps.execute

    def counted(values, **others):
        asked.append(values)
        return execute(values, **others)
    monkeypatch.setattr(sweeps, "execute", counted)
    return asked


def test_all_combinations_once(tmp_path, runs):
    """In the order of the grid; the load is proportional to the modulus; nothing is run twice, but what has other options is."""
    grid = {"rubber_youngs_modulus": [1e7, 2e7], "indenter_radius": [6.0, 8.0]}
    rows = sweeps.rows_of(CASE, grid, folder=tmp_path / "s", jobs=2, progress=False)
    assert [(row["rubber_youngs_modulus"], row["indenter_radius"]) for row in rows] == [(1e7, 6), (1e7, 8), (2e7, 6), (2e7, 8)]
    assert {row["status"] for row in rows} == {"completed"} and len(runs) == 4 and all(row["seconds"] > 0 for row in rows)
    loads = [row["largest_load_mN"] for row in rows]
    assert loads[2] > 1.5 * loads[0] and loads[1] > loads[0] and all(np.isnan(row["hardness_GPa"]) for row in rows)
    written = list(csv.DictReader(open(tmp_path / "s" / "sweep.csv", encoding="utf-8")))
    assert [float(row["largest_load_mN"]) for row in written] == pytest.approx(loads, rel=1e-11) and [row["folder"] for row in written] == [row["folder"] for row in rows]
    again = sweeps.rows_of(CASE, {**grid, "indenter_radius": [8.0]}, folder=tmp_path / "s", progress=False)
    assert len(runs) == 4 and [row["largest_load_mN"] for row in again] == loads[1::2]
    sweeps.rows_of({**CASE, "frames": 2}, {**grid, "indenter_radius": [8.0]}, folder=tmp_path / "s", jobs=1, progress=False)
    assert len(runs) == 6


def test_values_with_units_are_numbers_in_the_table(tmp_path):
    """In SI units, which the head names, so that the columns plot; other texts stay."""
    values = {"m_yield_stress": ["300MPa", "0.4 GPa"], "angle": ["60", "70.3"], "law": ["j2", "m"], "x": [1.5], "k": ["3N/um", "5"]}
    rows = [{"m_yield_stress": stress, "angle": "60", "law": "m", "x": 1.5, "k": "3N/um", "status": "completed"}
            for stress in values["m_yield_stress"]]
    sweeps.write(tmp_path / "sweep.csv", rows, values)
    first, second = csv.DictReader(open(tmp_path / "sweep.csv", encoding="utf-8"))
    assert [float(row["m_yield_stress_Pa"]) for row in (first, second)] == [300e6, 400e6]
    assert (first["angle"], first["law"], first["x"], float(first["k_N/m"])) == ("60", "m", "1.5", 3e6)


def test_a_failure_is_a_row(tmp_path, runs):
    """With the program's line, and it is tried again the next time."""
    for count in (2, 3):
        bad, good = sweeps.rows_of(CASE, {"rubber_poissons_ratio": [0.7, 0.3]}, folder=tmp_path, jobs=1, progress=False)
        assert bad["status"].startswith("failed: mlgimp: error: -rubber_poissons_ratio 0.7") and np.isnan(bad["largest_load_mN"])
        assert good["status"] == "completed" and len(runs) == count


@pytest.fixture(scope="module")
def indented(tmp_path_factory):
    """Rows of a sweep of mlgimp.indent, of which the first cannot be run."""
    return sweeps.rows_of(mlgimp.indent, {"yield_stress": [4e8], "depth": [-1, 200e-9]}, youngs_modulus=70e9, cells=4, block=8, tolerance=0.1, frames=2,
                          folder=tmp_path_factory.mktemp("metal"), progress=False)


def test_a_function(tmp_path, runs):
    rows = sweeps.rows_of(ball, {"stiffness": [1e7]}, radius=8.0, folder=tmp_path, progress=False)
    assert rows[0]["status"] == "completed" and runs[-1]["rubber_youngs_modulus"] == 1e7 and rows[0]["stiffness"] == 1e7


def test_indent(indented):
    bad, good = indented
    assert bad["status"].startswith("failed: depth=-1: must be")
    assert good["status"] == "completed" and 0.5 < good["hardness_GPa"] < 5 and 40 < good["modulus_GPa"] < 140 and good["largest_load_mN"] > 0


def test_table_of_pandas(tmp_path, monkeypatch):
    """A DataFrame where there is pandas, else a list."""
    calls = []
    monkeypatch.setattr(sweeps, "rows_of", lambda *arguments, **named: [{"a": 1}])
    monkeypatch.setitem(sys.modules, "pandas", type("pandas", (), {"DataFrame": calls.append}))
    sweeps.sweep({}, {"a": [1]})
    assert calls == [[{"a": 1}]]
    monkeypatch.setitem(sys.modules, "pandas", None)
    assert sweeps.sweep({}, {"a": [1]}) == [{"a": 1}]


def test_names_of_folders():
    names = sweeps.folder_names([{"a": 1e-9, "b": (1, 2)}, {"a": "x/y", "b": 0}, {"a": "x y", "b": 0}, {"a": "z" * 300, "b": 0}])
    assert names[0] == "a_1e-09_b_1_2_" + names[0][-8:] and len(set(names)) == 4 and all(re.fullmatch(r"[\w.+-]{1,110}", name) for name in names)
    assert sweeps.folder_names([{"a": 60}, {"a": 70.3}]) == ["a_60", "a_70.3"]


@pytest.mark.parametrize("grid, words", [({}, "grid: must have names"), ({"a": []}, "none of them empty"), ({"a": "12"}, "lists of values"), ([1], "must be a dict")])
def test_refusals(tmp_path, grid, words):
    with pytest.raises(mlgimp.Error, match=words):
        sweeps.sweep(CASE, grid, folder=tmp_path)
    with pytest.raises(mlgimp.Error, match="no such options file"):
        sweeps.sweep("absent.opts", {"a": [1]}, folder=tmp_path)


def test_the_command(tmp_path, capsys):
    import sweep
    options.write_options(tmp_path / "press.opts", CASE)
    words = [str(tmp_path / "press.opts"), "--vary", "rubber_youngs_modulus", "1e7", "-1", "--set", "frames", "0", "--out", str(tmp_path / "s"), "--jobs", "1"]
    with pytest.raises(SystemExit) as caught:
        sweep.main(words)
    said = capsys.readouterr().out.splitlines()
    assert caught.value.code == 2 and said[0] == "rubber_youngs_modulus 1e7: completed" and "failed: mlgimp: error: -rubber_youngs_modulus -1" in said[1]
    assert said[2] == str(tmp_path / "s" / "sweep.csv") and not list((tmp_path / "s").glob("*1e7*/points_*"))
    with pytest.raises(SystemExit, match="error: --vary a: must be given once"):
        sweep.main([str(tmp_path / "press.opts"), "--vary", "a"])


# ---- interrupts ----

LONG = {**CASE, "indenter_velocities": 0.01, "history_interval": 5}
STOPPED = """
import sys; sys.path.insert(0, {python!r})
import mlgimp
try:
    mlgimp.run({case!r}, {ranks}, output_dir={folder!r})
except KeyboardInterrupt as problem:
    print(type(problem).__name__, problem)
"""


def heed_interrupts():
    """What a shell starts in the background ignores them, and all that it starts does."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("ranks", [1, 2])
def test_an_interrupt_keeps_what_is_done(tmp_path, ranks):
    """Also where it reaches the whole group of processes, as from a terminal or a notebook: a checkpoint, results, and how to go on."""
    folder = tmp_path / "run"
    script = STOPPED.format(python=str(harness.ROOT / "python"), case=LONG, ranks=ranks, folder=str(folder))
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heed_interrupts,
                               env={**harness.environment(ranks), "MLGIMP_BIN": str(harness.BIN)})
    end = time.monotonic() + 30
    while time.monotonic() < end and not ((folder / "history.csv").exists() and (folder / "history.csv").read_text().count("\n") > 3):
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    said, errors = process.communicate(timeout=60)
    found = re.fullmatch(rf"Interrupted stopped at step (\d+): mlgimp\.read\('{folder}'\) has what is done; the same call with restart='(.*)' goes on\n", said)
    assert found, said + errors
    run = mlgimp.read(folder)
    assert run.summary["status"].startswith("stopped: SIGTERM") and run.summary["steps"] == int(found[1]) and len(run.history["time"]) > 3
    if ranks == 1:
        more = mlgimp.run(LONG, output_dir=folder, restart=found[2], max_steps=int(found[1]) + 10, progress=False)
        assert more.summary["status"] == "completed" and more.history["step"][-1] == int(found[1]) + 10


def test_a_sweep_that_is_interrupted_goes_on(tmp_path):
    """One line and the status of shells; what was done is in the table, and is not done again."""
    options.write_options(tmp_path / "press.opts", CASE)
    words = [sys.executable, str(harness.ROOT / "scripts" / "sweep.py"), str(tmp_path / "press.opts"), "--vary", "indenter_velocities", "2", "0.01", "1",
             "--out", str(tmp_path / "s"), "--jobs", "1"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heed_interrupts,
                               env={**harness.environment(1), "MLGIMP_BIN": str(harness.BIN)})
    end = time.monotonic() + 30
    while time.monotonic() < end and not (tmp_path / "s" / "indenter_velocities_0.01" / "history.csv").exists():
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    said, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and errors == f"stopped when 1 of 3 runs were done, as {tmp_path}/s/sweep.csv says; the same call goes on\n", said + errors
    assert [row["status"] for row in csv.DictReader(open(tmp_path / "s" / "sweep.csv", encoding="utf-8"))] == ["completed"]
    rows = sweeps.rows_of(tmp_path / "press.opts", {"indenter_velocities": ["2"]}, folder=tmp_path / "s", progress=False)
    assert rows[0]["status"] == "completed"


def test_words_of_an_interrupt(tmp_path):
    (tmp_path / "press.opts").write_text("-output_dir out\n")
    options, line = {"options_file": tmp_path / "press.opts", "overwrite": True}, "mlgimp: error: ended by SIGTERM"
    assert program.how_to_go_on([line], options) == "stopped, without a checkpoint; mlgimp.read('out') has what had been written"
    said = program.how_to_go_on([f"{line} at step 7; go on with -restart out/c 7.h5"], options)
    assert said == f"stopped at step 7: mlgimp.read('out') has what is done; mlgimp.run('{tmp_path}/press.opts', restart='out/c 7.h5') goes on"


# ---- what a notebook shows ----

def test_what_a_notebook_shows(indented):
    """Two pictures, figures, the folder and warnings, small; of a run without frames the curve."""
    run = mlgimp.read(indented[1]["folder"])
    text = html_of(run)
    checker = Checker(text)
    words = " ".join(checker.words)
    lines = str(run).splitlines()
    assert lines[0].endswith(str(run.folder)) and lines[1].startswith("largest load ")
    assert any(re.match(r"hardness [\d.]+ GPa \+- ", line) for line in lines)
    assert len(text) < 300e3 and [tag for tag, _ in checker.seen].count("img") == 2 and run._repr_html_() == text
    for needed in ("completed, 3 frames in", str(run.folder), "hardness", "± ", "largest load", "mN"):
        assert needed in words, needed
    for path in run.folder.glob("points_*"):
        path.unlink()
    assert [tag for tag, _ in Checker(html_of(mlgimp.read(run.folder))).seen].count("img") == 1
