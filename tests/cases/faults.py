"""Faults from outside: kills, damaged checkpoints, full disks and folders that cannot be written."""
import contextlib
import ctypes
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import xml.etree.ElementTree

import h5py
import numpy
import pytest

import harness
from limits import FAST
from ranks import LEVELS, SAME, WEDGE, largest_difference

pytestmark = [pytest.mark.fault, pytest.mark.mpi]
KILLS = 20
CUTS, FLIPS = 20, 40

# Most of the time goes into checkpoints, so that many kills meet one that is being written.
SMALL = {**WEDGE, "checkpoint_interval": 2, "frames": 3, "end_time": 5e-10}
NESTED = {**LEVELS, "checkpoint_interval": 2, "frames": 3, "end_time": 6e-10}


def rows_of(folder):
    """The lines of history.csv after its header."""
    return (folder / "history.csv").read_text().splitlines()[1:]


def words_of(case, folder):
    return harness.to_arguments({"output_dir": folder, "monitor": "false", **case})


# ---- Kills


def ranks_of(process):
    """The processes that mpiexec, or the program alone, has started."""
    return [int(word) for word in pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]


def kill_at(case, ranks, folder, rows, delay):
    """Runs until it is killed with all its ranks, so many seconds after a row of the history; false where it ended before."""
    process = subprocess.Popen(harness.command(words_of(case, folder), ranks), env=harness.environment(ranks), cwd=harness.ROOT,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    history = folder / "history.csv"
    while process.poll() is None and not (history.exists() and len(rows_of(folder)) > rows):
        time.sleep(0.001)
    try:
        process.wait(timeout=delay)
        return False
    except subprocess.TimeoutExpired:
        children = ranks_of(process)
        for one in [process.pid, *children]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(one, signal.SIGKILL)
        process.wait()
        for child in children:  # gone only when their new parent has seen it
            limit = time.time() + 10
            while pathlib.Path(f"/proc/{child}").exists() and time.time() < limit:
                time.sleep(0.005)
        return True


def problem_elsewhere(case, checkpoint, ranks, whole):
    """What is wrong with a run that goes on with another number of ranks; empty where nothing is."""
    result = harness.run({**case, "restart": checkpoint, "checkpoint_interval": 0, "frames": 0}, ranks=ranks)
    difference, column = largest_difference(result.history, whole.history)
    return "" if difference <= SAME else f"{column} on {ranks} ranks differs by {difference:.1e} from {checkpoint.name} on"


def problem_of_kill(case, ranks, other_ranks, whole, rows, delay):
    """(what is wrong with a run that was killed and went on; whether it was killed; whether a file was being written).
    other_ranks: on which it goes on as well; None for none."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch())) / "killed"
    killed = kill_at(case, ranks, folder, rows, delay)
    writing = folder.exists() and any(folder.glob("*.part"))
    last_step = int(rows_of(whole.folder)[-1].split(",")[0])
    checkpoints = sorted(path for path in folder.glob("checkpoint_*.h5") if int(path.stem.split("_")[1]) < last_step)
    if not killed or not checkpoints:
        return "", killed, writing
    problems = []
    if other_ranks:
        problems += [problem for problem in [problem_elsewhere(case, checkpoints[-1], other_ranks, whole)] if problem]
    again = harness.run({**case, "restart": checkpoints[-1]}, ranks=ranks, folder=folder)
    if rows_of(folder) != rows_of(whole.folder):
        problems.append(f"history differs after {checkpoints[-1].name}")
    ours, theirs = again.frame(), whole.frame()
    problems += [f"{name} of the last frame" for name in theirs if not numpy.array_equal(ours[name], theirs[name])]
    if (folder / "points.xdmf").read_text() != (whole.folder / "points.xdmf").read_text():
        problems.append("points.xdmf differs")
    if any(folder.glob("*.part")):
        problems.append("temporary files are left")
    shutil.rmtree(folder)
    return "; ".join(problems), killed, writing


def expect_kills(expect, name, case, ranks, other_ranks, count, seed):
    whole = harness.run(case, ranks=ranks)
    last = len(rows_of(whole.folder)) - 2
    moments = random.Random(seed)
    results = [problem_of_kill(case, ranks, other_ranks if number % 4 == 0 else None, whole, moments.randrange(last),
                               moments.uniform(0, 0.02))
               for number in range(count)]
    problems = [problem for problem, _, _ in results if problem]
    killed = sum(killed for _, killed, _ in results)
    expect.that(f"{count} runs with a kill, {name}, {ranks} ranks: go on to the last bit; on {other_ranks} to {SAME}", not problems, " | ".join(problems))
    return killed, sum(writing for _, _, writing in results)


def kill_all(expect, count):
    """About as many kills of each kind of run; runs on several ranks take longer."""
    totals = [0, 0]
    for seed, (name, case, ranks, other_ranks) in enumerate((("one level", SMALL, 1, 2), ("one level", SMALL, 2, 1),
                                                             ("three levels", NESTED, 1, 3), ("three levels", NESTED, 3, 1))):
        killed, writing = expect_kills(expect, name, case, ranks, other_ranks, count + (1 if ranks == 1 else -1), seed)
        totals[0] += killed
        totals[1] += writing
    expect("kills in the middle of a run", totals[0], at_least=2 * count)
    return totals[1]


@pytest.mark.slow
def test_kill(expect):
    kill_all(expect, KILLS // 10)


@pytest.mark.alone
def verify_kill(study):
    """Kills at any moment.

    Runs that write a checkpoint every other step are killed with all their ranks (SIGKILL) at a random moment, and go on in the same folder from the last
    checkpoint there: history, last frame and the list of frames must be those of a run that was not killed, and no temporary file may be left. Every fourth
    goes on from the same checkpoint on another number of ranks as well.
    """
    study.expect("kills while a file was being written", kill_all(study.expect, 5 * KILLS), at_least=1)


def test_kill_while_writing(expect):
    """A run that dies with half a checkpoint, half a frame and half a row goes on as if they had never been."""
    whole = harness.run(SMALL)
    folder = whole.folder.with_name(whole.folder.name + "_killed")
    shutil.copytree(whole.folder, folder)
    checkpoints = sorted(folder.glob("checkpoint_*.h5"))
    middle = len(checkpoints) // 2
    half = checkpoints[middle + 1].read_bytes()
    for path in checkpoints[middle + 1:]:
        path.unlink()
    checkpoints[middle + 1].with_suffix(".h5.part").write_bytes(half[: len(half) // 2])
    for name in ("points_000003.h5.part", "points.vtkhdf.part", "points.xdmf.part", "history.csv.part", "summary.json.part"):
        (folder / name).write_bytes(b"half a file")
    rows = (folder / "history.csv").read_text()
    (folder / "history.csv").write_text(rows[: rows.rindex("\n", 0, len(rows) - 1) + 2])  # one digit of the last row
    harness.run({**SMALL, "restart": checkpoints[middle]}, folder=folder)
    expect.that("killed while writing: history", rows_of(folder) == rows_of(whole.folder))
    names = [sorted(path.name for path in place.iterdir()) for place in (folder, whole.folder)]
    expect.that("killed while writing: the same files", names[0] == names[1], str(set(names[0]) ^ set(names[1])))


@contextlib.contextmanager
def locked_semaphore(name):
    """A semaphore of that name on which every process waits, as one is left by a program that is killed while it holds it."""
    library = ctypes.CDLL(None, use_errno=True)
    library.sem_open.restype = ctypes.c_void_p
    if library.sem_open(name, os.O_CREAT, 0o600, 0) is None:
        raise OSError(ctypes.get_errno(), "sem_open")
    try:
        yield
    finally:
        library.sem_unlink(name)


@pytest.mark.parametrize("ranks", [1, 2])
def test_lock_of_killed_run(ranks):
    """A run killed while MPI opens a file must not keep later ones, anywhere, from a file of that name."""
    with locked_semaphore(b"/OMPIO_points_000001.h5.part"):
        result = harness.run({**SMALL, "checkpoint_interval": 0}, ranks=ranks, timeout=60)
    assert result.summary["status"] == "completed"


# ---- Damaged checkpoints


def contents(folder):
    return sorted((str(path.relative_to(folder)), path.stat().st_size, path.stat().st_mtime_ns) for path in folder.rglob("*"))


def problem_of_refusal(case, damaged, ranks, folder):
    """What is wrong with the way a damaged checkpoint is refused; empty where nothing is."""
    before = contents(folder)
    done = subprocess.run(harness.command(words_of({**case, "restart": damaged}, folder), ranks), capture_output=True, text=True,
                          env=harness.environment(ranks), cwd=harness.ROOT, timeout=60)
    lines = harness.lines_of(done.stderr)
    if done.returncode <= 0 or len(lines) != 1 or not lines[0].startswith(f"mlgimp: error: -restart {damaged}: must be a whole checkpoint"):
        return f"exit status {done.returncode}: " + " | ".join(lines)[:300]
    return "the folder was touched" if contents(folder) != before else ""


def flipped(data, place, bit):
    return data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1:]


def test_damaged_checkpoint(expect):
    case = {**NESTED, "max_steps": 8, "end_time": 1.6e-9, "checkpoint_interval": 6}
    made = harness.run({**case, "frames": 0})
    data = (made.folder / "checkpoint_000006.h5").read_bytes()
    choice = random.Random(7)
    header = [choice.randrange(600) for _ in range(FLIPS // 4)]
    anywhere = [choice.randrange(len(data)) for _ in range(FLIPS // 2)]
    foot = [len(data) - 1 - choice.randrange(40) for _ in range(FLIPS // 4)]
    damages = [(f"bit of byte {place} flipped", flipped(data, place, choice.randrange(8))) for place in header + anywhere + foot]
    damages += [(f"cut to {size} bytes", data[:size]) for size in [0, len(data) - 1] + [choice.randrange(len(data)) for _ in range(CUTS - 2)]]
    folder = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
    (folder / "history.csv").write_text("step\n")
    damaged = folder / "checkpoint_000006.h5"
    wrong = []
    for number, (name, bytes_now) in enumerate(damages):
        damaged.write_bytes(bytes_now)
        problem = problem_of_refusal(case, damaged, 3 if number % 16 == 0 else 1, folder)
        if problem:
            wrong.append(f"{name}: {problem}")
    expect.that(f"damaged checkpoints: {len(damages)} refused", not wrong, " || ".join(wrong)[:1000])
    damaged.write_bytes(data)
    (folder / "history.csv").unlink()
    result = harness.run({**case, "restart": damaged, "frames": 0}, folder=folder)
    expect.that("the same checkpoint undamaged is read", result.status == 0)


# ---- Disks


@contextlib.contextmanager
def small_disk(size):
    """A folder on a disk of so many bytes."""
    place = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
    if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", place], capture_output=True).returncode != 0:
        pytest.skip("this user may not mount a disk")
    try:
        yield place
    finally:
        subprocess.run(["umount", place], check=True)


def limit_files(process, ranks, size, history):
    """Lets no file of a run grow beyond a size once the MPI library has made its own and the history has begun."""
    while process.poll() is None and not history.exists():
        time.sleep(0.001)
    for one in ranks_of(process) if ranks > 1 else [process.pid]:
        resource.prlimit(one, resource.RLIMIT_FSIZE, (size, size))


def problems_of_full(case, folder, ranks, file_limit=None):
    """(what is wrong with the way a run ends that cannot write, its line)."""
    process = subprocess.Popen(harness.command(words_of(case, folder), ranks), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                               text=True, env=harness.environment(ranks), cwd=harness.ROOT)
    if file_limit:
        limit_files(process, ranks, file_limit, folder / "history.csv")
    try:
        error = process.communicate(timeout=60)[1]
    except subprocess.TimeoutExpired:
        process.kill()
        return ["still running after 60 s"], ""
    lines = [line for line in harness.lines_of(error) if FAST not in line] or [""]
    problems = []
    if process.returncode <= 0 or len(lines) != 1 or not lines[0].startswith("mlgimp: error: cannot write "):
        problems.append(f"exit status {process.returncode}: " + " | ".join(lines)[:300])
    if ("File too large" if file_limit else "No space left on device") not in lines[0]:
        problems.append(f"no reason in: {lines[0]}")
    if kept_in(folder) != kept_by_message(lines[0]):
        problems.append(f"{kept_in(folder)} are kept, but it says: {lines[0]}")
    if any(folder.glob("*.part")):
        problems.append("temporary files are left")
    return problems, lines[0]


def kept_by_message(line):
    """(last row, last frame, last checkpoint) that the line names; -1 for none."""
    words = line.rpartition(";")[2].replace(",", "").split()
    after = {"history": "step", "frames": "to", "checkpoint": "checkpoint"}
    return tuple(int(words[words.index(word, words.index(kind)) + 1]) if kind in words else -1 for kind, word in after.items())


def kept_in(folder):
    """The same, read from the files, all of which must be whole."""
    rows = [line.split(",") for line in rows_of(folder)] if (folder / "history.csv").exists() else []
    for row in rows:
        numpy.array(row, dtype=float)
    last = [int(rows[-1][0]) if rows else -1]
    for kind, field in (("points_", "mass"), ("checkpoint_", "mass")):
        numbers = [-1]
        for path in folder.glob(kind + "*.h5"):
            with h5py.File(path, "r") as file:
                if numpy.sum(file["level_0"][field][:]) > 0:
                    numbers.append(int(path.stem.split("_")[1]))
        last.append(max(numbers))
    if (folder / "points.vtkhdf").exists():
        with h5py.File(folder / "points.vtkhdf", "r") as file:
            assert len(file["VTKHDF/Points"][:]) == sum(file["VTKHDF/NumberOfPoints"][:])
    if (folder / "points.xdmf").exists():
        for item in xml.etree.ElementTree.parse(folder / "points.xdmf").iter("DataItem"):
            place, _, dataset = item.text.strip().partition(":")
            with h5py.File(folder / place, "r") as file:
                file[dataset][:]
    return tuple(last)


KINDS = ("history.csv", "points_", "points.vtkhdf", "points.xdmf", "checkpoint_", "summary.json")

# Few points and many frames, so that the list of frames becomes large.
LIGHT = {**WEDGE, "cell_size": "1e-6", "end_time": 6e-9, "history_interval": 1000, "frames": 60}
LONG = {**LIGHT, "history_interval": 1, "frames": 0}


def full_disks():
    """(case, bytes): sizes of the disk in whole pages, by which each kind of file is the first that does not fit."""
    page, reserved = 4096, 16  # bytes; pages that a frame asks for beside its own
    pages = {path.name: -(-path.stat().st_size // page) for case in (LONG, LIGHT) for path in harness.run(case).folder.iterdir()}
    rows, summary = (-(-(harness.run(LONG).folder / name).stat().st_size // page) for name in ("history.csv", "summary.json"))
    frames = sum(count for name, count in pages.items() if name.startswith("points_"))
    yield LONG, 2 * page
    yield LONG, (rows + summary) * page  # all but the summary of the end, which replaces that of the start
    vtkhdf, xdmf = pages["points.vtkhdf"], pages["points.xdmf"]  # which are replaced in this order
    assert reserved < vtkhdf < xdmf
    for room in (vtkhdf - 16, vtkhdf - 2, (vtkhdf + xdmf) // 2):  # one of the last frames, but not its place in one of the lists
        yield LIGHT, (1 + frames + vtkhdf + xdmf + room) * page
    for size in (30, 60, 120):
        yield {**LIGHT, "frames": 4, "checkpoint_interval": 5}, size * page
    for size in (10, 100, 250, 500):
        yield {**WEDGE, "frames": 8, "checkpoint_interval": 25}, size * page


@pytest.mark.parametrize("ranks", [1, 3])
def test_full_disk(expect, ranks):
    wrong, hit, tried = [], set(), 0
    for case, size in full_disks():
        with small_disk(size) as place:
            problems, line = problems_of_full(case, place / "results", ranks)
        tried += 1
        wrong += [f"{size} bytes: {problem}" for problem in problems]
        hit |= {kind for kind in KINDS if "/" + kind in line}
    expect.that(f"full disk, {ranks} ranks: {tried} sizes", not wrong, " || ".join(wrong)[:1000])
    expect.that(f"full disk, {ranks} ranks: each kind of file", hit == set(KINDS), "" if hit == set(KINDS) else f"not {set(KINDS) - hit}")


@pytest.mark.parametrize("ranks", [1, 3])
@pytest.mark.parametrize("size", [20000, 350000, 380000])
def test_file_size_limit(tmp_path, size, ranks):
    """The same where files may not grow; also for users who may not mount a disk."""
    problems, _ = problems_of_full({**WEDGE, "frames": 8, "checkpoint_interval": 25}, tmp_path / "results", ranks, size)
    assert not problems


def test_frame_too_large(tmp_path):
    """HDF5 cannot close a file that may not become as long as it has laid it out, and once tried again at exit, with a crash."""
    size = 300 << 10
    words = words_of({"options_file": harness.ROOT / "options" / "wedge_500nm.opts", "cell_size": 1e-6, "max_steps": 2, "frames": 1}, tmp_path)
    done = subprocess.run(harness.command(words, 1), capture_output=True, text=True, env=harness.environment(1), cwd=harness.ROOT, timeout=60,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "points_000000.h5: File too large" in done.stderr, done


def test_folder_read_only(expect):
    """A folder that may not be written: one line, and nothing of what it holds is lost."""
    with small_disk(1 << 20) as place:
        (place / "results").mkdir()
        (place / "results" / "history.csv").write_text("step\n")
        subprocess.run(["mount", "-o", "remount,ro", place], check=True)
        for name, folder, more, word in (("new", place / "new", {}, f"-output_dir {place / 'new'}: must be a folder that can be created"),
                                         ("old", place / "results", {"overwrite": None}, f"cannot write {place / 'results'}/history.csv")):
            done = subprocess.run(harness.command(words_of({**LIGHT, **more}, folder), 1), capture_output=True, text=True,
                                  env=harness.environment(1), cwd=harness.ROOT, timeout=60)
            line = done.stderr.strip("\n")
            expect.that(f"read-only disk, {name} folder", done.returncode == 1 and line.startswith("mlgimp: error: " + word)
                        and "Read-only file system" in line and "\n" not in line, done.stderr)
