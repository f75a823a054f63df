"""Signals, terminals, errors of libraries and options: what ends a run does so in one line, and what need not end it does not."""
import concurrent.futures
import contextlib
import fcntl
import json
import os
import pty
import resource
import select
import signal
import struct
import subprocess
import termios
import time

import pytest

import harness
from safety import BLOCK, start, ended, refused, succeeds, wait_for

# ---- Signals and terminals

ENDLESS = {**BLOCK, "max_steps": "100000000", "history_interval": "100", "overwrite": None}


def test_signals_end_a_run_in_one_line(tmp_path):
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM):
        folder = tmp_path / number.name
        process = start(ENDLESS, folder, preexec_fn=lambda number=number: signal.signal(number, signal.SIG_DFL))  # as nohup ignores one
        wait_for(lambda: (folder / "history.csv").exists() and len((folder / "history.csv").read_text()) > 2000)
        process.send_signal(number)
        errors = process.communicate(timeout=10)[1]
        assert process.returncode == -number and errors.startswith(f"mlgimp: error: ended by {number.name}") and errors.count("\n") == 1, errors
        rows = (folder / "history.csv").read_text()
        assert rows.endswith("\n") and len({line.count(",") for line in rows.splitlines()}) == 1
        assert not list(folder.glob("*.part"))


def test_signals_end_a_run_on_several_ranks(tmp_path):
    process = start(ENDLESS, tmp_path, ranks=3)
    wait_for(lambda: (tmp_path / "history.csv").exists())
    process.send_signal(signal.SIGTERM)
    errors = process.communicate(timeout=10)[1]
    assert process.returncode != 0 and "PETSC" not in errors, errors
    assert errors.count("mlgimp: error") == errors.count("mlgimp: error: ended by SIGTERM at step") == 1, errors


def test_output_that_nobody_reads(tmp_path):
    """As with `| head`."""
    process = start({**ENDLESS, "monitor": "true"}, tmp_path)
    process.stdout.read(20)
    process.stdout.close()
    process.wait(timeout=10)
    errors = process.stderr.read()
    assert process.returncode == -signal.SIGPIPE and errors.startswith("mlgimp: error: ended by SIGPIPE") and errors.count("\n") == 1, errors


@pytest.mark.parametrize("lines", [1, 40, 420])
def test_help_in_a_pipe(lines):
    """-help | head says nothing else."""
    done = subprocess.run(f"{harness.PROGRAM} -help | head -n {lines}", shell=True, capture_output=True, text=True, env=harness.environment(1),
                          timeout=30)
    assert done.stdout.count("\n") == lines and not done.stderr, done.stderr


def test_progress_only_on_a_terminal_without_mpiexec(tmp_path):
    case = {name: value for name, value in BLOCK.items() if name != "monitor"}
    words = harness.to_arguments({**case, "max_steps": "5", "overwrite": None, "output_dir": tmp_path})
    for ranks, shown in ((1, True), (2, False)):
        line = " ".join(harness.command(words, ranks))
        done = subprocess.run(["script", "-qec", line, "/dev/null"], capture_output=True, text=True, env=harness.environment(ranks),
                              stdin=subprocess.DEVNULL, cwd=harness.ROOT, timeout=30)
        assert done.returncode == 0 and ("step 5" in done.stdout) == shown, done.stdout
        done = subprocess.run(harness.command(words, ranks), capture_output=True, text=True, env=harness.environment(ranks),
                              cwd=harness.ROOT, timeout=30)
        assert done.returncode == 0 and done.stdout == ""


def shown_on_terminal(words, columns, environment, seconds=None):
    """What a program writes to a terminal so many columns wide; None for one that does not know its width. Interrupted after some seconds."""
    ours, theirs = pty.openpty()
    if columns:
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
    process = subprocess.Popen(words, stdout=theirs, stdin=subprocess.DEVNULL, cwd=harness.ROOT, env=environment)
    os.close(theirs)
    text, limit = b"", time.time() + (seconds or 30)
    while time.time() < limit and process.poll() is None:
        if select.select([ours], [], [], 0.1)[0]:
            with contextlib.suppress(OSError):
                text += os.read(ours, 65536)
    process.kill()
    process.wait()
    os.close(ours)
    return text.decode()


TERMINALS = [(80, None, 80), (40, "200", 40), (200, None, 200), (None, "60", 60), (None, None, 80)]  # columns, COLUMNS, room for a line


def progress_on(terminal, folder):
    """The lines of a run's progress on a terminal."""
    columns, variable, _ = terminal
    environment = {name: value for name, value in harness.environment(1).items() if name != "COLUMNS"} | ({"COLUMNS": variable} if variable else {})
    case = {**ENDLESS, **WEDGE, "indenter_velocities": "1e-9", "monitor": "true", "output_dir": folder}
    return shown_on_terminal(harness.command(harness.to_arguments(case), 1), columns, environment, seconds=5).split("\r")[1:]


def test_progress_fits_the_terminal(expect, tmp_path):
    """Each line goes over the one before, to its end, and none goes into a second line. All at a time, as each takes seconds."""
    with concurrent.futures.ThreadPoolExecutor(len(TERMINALS)) as pool:
        shown = list(pool.map(progress_on, TERMINALS, [tmp_path / str(number) for number in range(len(TERMINALS))]))
    for (columns, variable, room), lines in zip(TERMINALS, shown):
        name = f"{columns} columns, COLUMNS {variable}: "
        expect.that(name + "words", len(lines) >= 2 and all("s left" in line and "load" in line for line in lines), f"{lines}")
        expect.that(name + "within the terminal", all(len(line) < room and "\n" not in line for line in lines), f"{lines}")
        expect.that(name + "over the one before", all(len(after) >= len(before.rstrip()) for before, after in zip(lines, lines[1:])), f"{lines}")
        expect.that(name + "speed where there is room", all(("points/s" in line) == (room == 200) for line in lines), f"{lines}")


# ---- Errors of PETSc and of the machine

WEDGE = {"indenter": "wedge", "indenter_half_angle": "70", "indenter_tip": "4,8", "indenter_times": "0", "indenter_velocities": "20",
         "boundary_y_lower": "symmetry"}


def test_errors_of_petsc_are_one_line(tmp_path):
    refused({**BLOCK, "log_view": ":/nowhere/at/all"}, tmp_path / "c", ranks=3)
    status, lines = ended({**BLOCK, "fp_trap": None}, tmp_path / "d")
    assert status == 0 or status == 1 and lines[0].startswith("mlgimp: error: floating-point"), lines
    assert not any("PETSC ERROR" in line for line in lines)


def test_no_memory(tmp_path):
    """Where the system gives less than the estimate at the start expects."""
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (400_000_000, 400_000_000))
    refused({**BLOCK, "cell_size": "0.02", "max_steps": "2"}, tmp_path / "o", "memory", preexec_fn=limit)


def test_options_of_petsc_that_are_read_late(tmp_path):
    for option in ("mat_view", "ksp_view", "contact_mat_view", "malloc_dump", "log_view_memory"):
        status, lines = ended({**BLOCK, "max_steps": "2", "overwrite": None, option: None}, tmp_path)
        assert status == 0 and all(line.startswith("mlgimp: warning: ") for line in lines), lines


# ---- Options


def test_options_from_a_pipe(tmp_path):
    text = "".join(f"-{name} {value}\n" for name, value in {**BLOCK, "max_steps": "3"}.items())
    for ranks in (1, 3):
        done = subprocess.run(harness.command(["-options_file", "/dev/stdin", "-output_dir", tmp_path, "-overwrite"], ranks), input=text,
                              capture_output=True, text=True, env=harness.environment(ranks), cwd=harness.ROOT, timeout=30)
        assert done.returncode == 0, done.stderr
        assert json.loads((tmp_path / "summary.json").read_text())["case"] == "stdin"
    os.mkfifo(tmp_path / "pipe")
    refused({"options_file": tmp_path / "pipe"}, tmp_path / "no", "-options_file", "readable")


def test_an_option_twice(tmp_path):
    words = harness.to_arguments({**BLOCK, "max_steps": "3", "overwrite": None, "output_dir": tmp_path / "o"})
    done = subprocess.run(harness.command([*words, "-max_steps", "5"], 1), capture_output=True, text=True, env=harness.environment(1),
                          cwd=harness.ROOT, timeout=30)
    assert done.returncode == 0 and json.loads((tmp_path / "o/summary.json").read_text())["steps"] == 5


def test_usage(tmp_path):
    for ranks in (1, 2):
        done = subprocess.run(harness.command([], ranks), capture_output=True, text=True, env=harness.environment(ranks), timeout=30)
        text = "\n".join(harness.lines_of(done.stderr))
        assert done.returncode == 1 and "-options_file" in text and "-help" in text and len(text) < 500


@pytest.mark.parametrize("word", ["-version", "--version"])
def test_version(word):
    done = subprocess.run(harness.command([word], 2), capture_output=True, text=True, env=harness.environment(2), timeout=30)
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and not harness.lines_of(done.stderr)
    assert [line.split()[0] for line in lines] == ["mlgimp", "PETSc", "MPI", "HDF5"]


def test_summary_is_json(tmp_path):
    for number, case in enumerate(({"thickness": "1e-200", "al_density": "1e-200"}, {"thickness": "1e200", "al_density": "1e200"})):
        status, lines = ended({**BLOCK, "max_steps": "1", **case}, tmp_path / f"{number}")
        summary = (tmp_path / f"{number}" / "summary.json").read_text()

        def refuse(constant):
            raise ValueError(constant)
        json.loads(summary, parse_constant=refuse)
    (tmp_path / "a\udcffb.opts").write_text("-damping 0\n")
    succeeds({"options_file": tmp_path / "a\udcffb.opts", **BLOCK, "max_steps": "1"}, tmp_path / "bytes")
    assert json.loads((tmp_path / "bytes/summary.json").read_text(encoding="utf-8"))["case"] == "a\ufffdb"


def test_polygons_in_any_unit(tmp_path):
    case = {name: value for name, value in BLOCK.items() if name not in ("block_lower", "block_upper")}
    for scale in ("", "e-9", "e9"):
        right = ",".join(f"{x}{scale}" for vertex in [(1, 1), (3, 1), (5, 1), (5, 5), (3, 2), (1, 5), (1, 3)] for x in vertex)
        units = {"domain_upper": f"12{scale},12{scale}", "cell_size": f"1{scale}"}
        succeeds({**case, **units, "block_shape": "polygon", "block_vertices": right, "max_steps": "1"}, tmp_path / f"yes{scale}")


def test_a_box_on_the_cell_lines_but_for_rounding(tmp_path):
    far = {"domain_lower": "-10000,0", "levels": "2", "level_1_lower": "2.000001,2", "level_1_upper": "10,10"}
    succeeds({**BLOCK, **far, "max_steps": "1"}, tmp_path)
