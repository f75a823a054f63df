"""Signals and the clock: a checkpoint on demand, an end with one, and a run that then goes on as if it had not been stopped."""
import contextlib
import os
import re
import signal
import subprocess
import time

import h5py
import numpy
import pytest

import harness
from faults import ranks_of, rows_of
from ranks import LEVELS
from safety import BLOCK, names, start, wait_for

pytestmark = [pytest.mark.fault, pytest.mark.mpi, pytest.mark.slow]
CASE = {**{name: value for name, value in LEVELS.items() if name != "end_time"}, "cell_size": "125e-9", "max_steps": 180, "frames": 5,
        "history_interval": 7, "indenter_velocities": "100", "monitor": "false"}  # two seconds
TARGETS = [(1, "program"), (2, "mpiexec"), (2, "rank 1"), (4, "mpiexec"), (4, "rank 3")]


def begin(folder, ranks, options):
    """A run that has made some steps."""
    words = harness.command(harness.to_arguments({**CASE, **options, "output_dir": folder}), ranks)
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=harness.ROOT,
                               env=harness.environment(ranks))
    wait_for(lambda: (folder / "history.csv").exists() and len(rows_of(folder)) > 3)
    return process


def target_of(process, name):
    return ranks_of(process)[int(name.split()[1])] if name.startswith("rank") else process.pid


def checkpoints(folder):
    return sorted(folder.glob("checkpoint_*.h5"))


def same_results(folder, whole):
    """What differs from a run that was not disturbed, of rows, frames and series."""
    wrong = [] if rows_of(folder) == rows_of(whole) else ["history.csv"]
    frames = sorted(path.name for path in whole.glob("points_*.h5"))
    if sorted(path.name for path in folder.glob("points_*.h5")) != frames:
        return [*wrong, "frames"]
    for name in frames:
        with h5py.File(folder / name) as ours, h5py.File(whole / name) as theirs:
            for level in (key for key in theirs if key.startswith("level_")):
                wrong += [f"{name}: {field}" for field in theirs[level] if not numpy.array_equal(ours[level][field], theirs[level][field])]
    if (folder / "points.xdmf").read_text() != (whole / "points.xdmf").read_text():
        wrong.append("points.xdmf")
    return wrong


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The folder of the whole run on a number of ranks."""
    made = {}

    def run(ranks):
        if ranks not in made:
            made[ranks] = harness.run(CASE, ranks=ranks, folder=tmp_path_factory.mktemp("whole") / str(ranks)).folder
        return made[ranks]
    return run


def goes_on(folder, ranks, whole, checkpoint):
    """Restarts in the same folder; what is then otherwise than in the whole run."""
    result = harness.run({**CASE, "restart": checkpoint}, ranks=ranks, folder=folder)
    assert result.summary["status"] == "completed"
    return same_results(folder, whole)


@pytest.mark.parametrize("ranks, target", TARGETS)
def test_checkpoint_on_demand(tmp_path, undisturbed, ranks, target):
    folder = tmp_path / "run"
    process = begin(folder, ranks, {"no_signal_handler": None})
    os.kill(target_of(process, target), signal.SIGUSR1)
    wait_for(lambda: checkpoints(folder))
    out, errors = process.communicate(timeout=60)
    assert process.returncode == 0 and not out, errors
    assert len(checkpoints(folder)) == 1 and not same_results(folder, undisturbed(ranks))
    if ranks == 1:
        assert not goes_on(folder, ranks, undisturbed(ranks), checkpoints(folder)[0])


@pytest.mark.parametrize("ranks, target", TARGETS)
def test_end_with_a_checkpoint(tmp_path, undisturbed, ranks, target):
    folder = tmp_path / "run"
    process = begin(folder, ranks, {})
    os.kill(target_of(process, target), signal.SIGTERM)
    errors = process.communicate(timeout=60)[1]
    written = checkpoints(folder)[0]
    said = f"SIGTERM at step {int(written.stem.split('_')[1])}; go on with -restart {written}"
    assert process.returncode == -signal.SIGTERM if ranks == 1 else process.returncode == 128 + signal.SIGTERM or target == "mpiexec"
    assert process.returncode != 0 and f"mlgimp: error: ended by {said}\n" in errors, errors
    assert [line for line in harness.lines_of(errors) if "mlgimp: error" in line] == [f"mlgimp: error: ended by {said}"], errors
    result = harness.Result(0, "", "", folder)
    assert result.summary["status"] == "stopped: " + said and result.summary["steps"] < CASE["max_steps"]
    assert names(folder) >= {"points.vtkhdf", "points.xdmf"} and not {".mlgimp_lock"} & names(folder) and not list(folder.glob("*.part"))
    assert not goes_on(folder, ranks, undisturbed(ranks), written)


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_end_in_time(tmp_path, undisturbed, ranks):
    """Before the limit, with exit status 0; the run goes on in pieces until its end."""
    folder, limit, restart, pieces = tmp_path / "run", 1, {}, 0
    begin = time.time()
    harness.run({**CASE, "max_steps": 1}, ranks=ranks)
    start_and_end = time.time() - begin  # MPI's own, of this machine now
    while True:
        begin = time.time()
        result = harness.run({**CASE, **restart, "max_wall_time": limit, "malloc_dump": None}, ranks=ranks, folder=folder)
        assert time.time() - begin < limit + 1 + 2 * start_and_end
        pieces += 1
        if result.summary["status"] == "completed":
            break
        written = checkpoints(folder)[-1]
        said = f"-max_wall_time {limit} at step {result.summary['steps']}; go on with -restart {written}"
        assert result.stdout == f"mlgimp: ended by {said}\n" and result.summary["status"] == "stopped: " + said
        assert result.summary["wall_seconds"] < limit + start_and_end  # beside other tests the system may let the ranks wait
        restart = {"restart": written}
    assert pieces > 1 and not same_results(folder, undisturbed(ranks))


def test_limit_that_is_never_met(tmp_path):
    result = harness.run({**BLOCK, "max_steps": 20, "max_wall_time": 1e5}, folder=tmp_path)
    assert result.summary["status"] == "completed" and not result.stdout and not checkpoints(tmp_path)


def test_second_signal_ends_at_once(tmp_path):
    """Where steps are so long that the checkpoint would have to wait."""
    process = start({**BLOCK, "cell_size": "0.02", "max_steps": "100000"}, tmp_path)
    wait_for(lambda: (tmp_path / "history.csv").exists() and len((tmp_path / "history.csv").read_text()) > 500)
    begin = time.time()
    process.send_signal(signal.SIGTERM)
    time.sleep(0.3)
    process.send_signal(signal.SIGTERM)
    errors = process.communicate(timeout=20)[1]
    assert process.returncode == -signal.SIGTERM and errors == "mlgimp: error: ended by SIGTERM\n", errors
    assert time.time() - begin < 1.5 and not checkpoints(tmp_path)


def test_signal_that_is_ignored_stays_ignored(tmp_path):
    process = start({**BLOCK, "max_steps": "2000"}, tmp_path, preexec_fn=lambda: signal.signal(signal.SIGUSR1, signal.SIG_IGN))
    wait_for(lambda: (tmp_path / "history.csv").exists())
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGUSR1)
    errors = process.communicate(timeout=60)[1]
    assert process.returncode == 0 and not checkpoints(tmp_path), errors


@pytest.mark.parametrize("value", ["0", "-1", "soon"])
def test_wrong_limits(tmp_path, value):
    result = harness.run({**BLOCK, "max_wall_time": value}, folder=tmp_path, must_succeed=False)
    assert result.status == 1 and re.fullmatch(rf"mlgimp: error: -max_wall_time {value}: must be > 0.*\n", result.stderr), result.stderr
