"""What speed hangs on and users rely on: the balance of ranks, and that memory does not grow.

Times are too noisy for a test; `make bench` has them, and counts of messages and instructions.
"""
import os
import subprocess
import tempfile

import pytest

import harness
from log_view import LogView
from ranks import LEVELS

STEPS = 20  # of level 0 in the shorter of two runs; a multiple of the ten steps between looks at balance and speeds

# A block that flies and strains, four points a cell, without contact.
BLOCK = {
    "domain_lower": "0,0", "domain_upper": "50,50", "cell_size": 1, "gravity": "0,-5", "points_per_rank": 1,
    "materials": "soft", "soft_youngs_modulus": "1e7", "soft_poissons_ratio": "0.3", "soft_density": 1000,
    "bodies": "block", "block_lower": "5,5", "block_upper": "45,45", "block_velocity": "0.3,0.2",
}
CASES = {"one level": BLOCK, "three levels with contact": LEVELS}


def reductions_log(steps):
    """What PETSc counts of so many steps of the wedge on three levels, on 2 ranks."""
    path = tempfile.mktemp(dir=harness.scratch())
    harness.run({"max_steps": steps, "frames": 0, "log_view": f":{path}:ascii_csv"}, file="wedge_3level.opts", ranks=2)
    return path


def with_steps(case, steps, **other):
    """The case for a number of steps, without frames."""
    return {**{name: value for name, value in case.items() if name != "end_time"}, "max_steps": steps, "frames": 0, **other}


@pytest.mark.mpi
def test_collective_calls(expect):
    """On three levels with contact and a history row in each step few steps of many ask all ranks for anything; counted in the
    second half of a run, as the first has the set-up."""
    half, whole = (LogView(path) for path in (reductions_log(STEPS), reductions_log(2 * STEPS)))
    calls = (whole.total("reductions", stage="") - half.total("reductions", stage="")) / STEPS / whole.ranks
    expect("three levels, 2 ranks: collective calls a step", calls, at_most=1.5)


@pytest.mark.mpi
def test_balance(expect):
    """Straight cuts divide the five levels well on eight ranks, also after points have crossed at the start."""
    result = harness.run({"max_steps": 1, "frames": 0}, file="multiscale_5level.opts", ranks=8)
    for number, level in enumerate(result.summary["levels"]):
        expect(f"five levels, 8 ranks: largest over mean points of level {number}", level["imbalance"], at_most=1.05)


def memory_of(options):
    """Largest resident size in kB, and page faults, of a run on one rank."""
    arguments = harness.to_arguments({"output_dir": tempfile.mkdtemp(dir=harness.scratch()), "overwrite": None,
                                      "monitor": "false", **options})
    process = subprocess.Popen(harness.command(arguments, 1), env=harness.ENVIRONMENT, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise AssertionError(f"exit status {status}")
    return usage.ru_maxrss, usage.ru_minflt


@pytest.mark.parametrize("name", CASES)
def test_memory(expect, name):
    """What is allocated anew in every step shows as page faults, where it is large, and what is never freed as growth."""
    few, many = (memory_of(with_steps(CASES[name], steps)) for steps in (2 * STEPS, 5 * STEPS))
    growth, faults = ((b - a) / (3 * STEPS) for a, b in zip(few, many))
    expect(f"{name}: growth of memory a step [kB]", growth, at_most=20)
    expect(f"{name}: page faults a step", faults, at_most=10)
