"""What speed hangs on, counted: messages, bytes and collective calls of a step, instructions of a point. Run by `make bench`.

Every limit is the count of today and a margin: an honest improvement, another compiler, MPI or PETSc moves them.
"""
import os
import pathlib
import platform
import re
import shutil
import subprocess
import tempfile

import pytest

import harness
from log_view import LogView
from speed import CASES, STEPS, with_steps

# Today's counts a step of level 0: messages and kilobytes that all ranks send, collective calls of a rank.
# Light nodes are two thirds of the messages, four small ones to each neighbour in a step.
TODAY = {("one level", 2): (12, 49.2, 0.9), ("one level", 4): (36, 147.6, 0.9),
         ("three levels with contact", 2): (230.5, 371.4, 3.2), ("three levels with contact", 4): (1124, 1065, 4)}
COUNT_MARGIN = 1.02

# Instructions a point and step with vectors of four, whatever the machine has; the second, of which 1038 were counted last, has contact
# and small levels.
INSTRUCTIONS = {"one level": 589, "three levels with contact": 958}
COUNTED = harness.ROOT / "bin" / "counted"
INSTRUCTION_MARGIN = 1.1  # compilers differ


def log_of(case, ranks, steps):
    path = tempfile.mktemp(dir=harness.scratch())
    harness.run(with_steps(case, steps, log_view=f":{path}:ascii_csv"), ranks=ranks)
    return LogView(path)


@pytest.mark.parametrize("name, ranks", TODAY)
def test_messages(expect, name, ranks):
    """Counts of the second half of a run, as the first has the set-up."""
    first, both = (log_of(CASES[name], ranks, steps) for steps in (STEPS, 2 * STEPS))
    for figure, unit, count in zip(("messages", "bytes", "reductions"), (1, 1e3, ranks), TODAY[name, ranks]):
        value = (both.total(figure, stage="") - first.total(figure, stage="")) / STEPS / unit
        expect(f"{name}, {ranks} ranks: {figure} a step", value, at_most=COUNT_MARGIN * count)


@pytest.fixture(scope="module")
def counted():
    """The program that is counted, built for vectors of four on any machine: valgrind knows no longer ones."""
    if not shutil.which("valgrind"):
        pytest.skip("valgrind is not installed")
    if platform.machine() != "x86_64":
        pytest.skip("the limits are those of x86-64")
    environment = {name: value for name, value in os.environ.items() if name not in ("CXXFLAGS", "MAKEFLAGS", "SANITIZE")}
    folders = [f"BUILD={harness.ROOT / 'build' / COUNTED.name}", f"BIN={COUNTED}"]
    subprocess.run(["make", "-s", "-j2", "ARCH=-march=haswell", *folders, f"{COUNTED}/mlgimp"], cwd=harness.ROOT, env=environment,
                   stdout=subprocess.DEVNULL, check=True)
    return COUNTED / "mlgimp"


@pytest.mark.parametrize("name", INSTRUCTIONS)
def test_instructions(expect, counted, name):
    """Instructions a point and step inside Hierarchy::Advance."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
    options = with_steps(CASES[name], STEPS // 2, output_dir=folder / "run", monitor="false", history_interval=1000)
    watch = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/counts",
             "--toggle-collect=mlgimp::Hierarchy::Advance(mlgimp::TimeStep)"]
    done = subprocess.run([*watch, str(counted), *harness.to_arguments(options)], env=harness.ENVIRONMENT, capture_output=True,
                          text=True)
    if done.returncode != 0:
        pytest.skip("valgrind cannot run the program")
    total = int(re.search(r"^(?:summary|totals): (\d+)", (folder / "counts").read_text(), re.M)[1])
    levels = harness.Result(0, "", "", folder / "run").summary["levels"]
    count = total / sum(level["points"] * level["steps"] for level in levels)
    expect(f"{name}: instructions a point and step", count, at_least=1, at_most=INSTRUCTION_MARGIN * INSTRUCTIONS[name])
