"""What speed hangs on, counted: messages, bytes and collective calls of a step, instructions, memory.

Times are too noisy for a test; `make bench` has them. Every limit is the count of today and a margin.
"""
import os
import pathlib
import platform
import re
import shutil
import subprocess
import tempfile

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

# Today's counts a step of level 0: messages and kilobytes that all ranks send, collective calls of a rank.
TODAY = {("one level", 2): (8, 71.2, 4.3), ("one level", 4): (24, 213.7, 4.3),
         ("three levels with contact", 2): (92.8, 410.2, 37.2), ("three levels with contact", 4): (413.3, 978.6, 37.4)}
COUNT_MARGIN = 1.02

# Today's instructions a point and step with vectors of four, whatever the machine has; contact and small levels are in the second.
INSTRUCTIONS = {"one level": 872, "three levels with contact": 1068}
COUNTED = harness.ROOT / "bin" / "counted"
INSTRUCTION_MARGIN = 1.1  # compilers differ


def with_steps(case, steps, **other):
    """The case for a number of steps, without frames."""
    return {**{name: value for name, value in case.items() if name != "end_time"}, "max_steps": steps, "frames": 0, **other}


def log_of(case, ranks, steps):
    path = tempfile.mktemp(dir=harness.scratch())
    harness.run(with_steps(case, steps, log_view=f":{path}:ascii_csv"), ranks=ranks)
    return LogView(path)


def test_messages(report):
    """Counts of the second half of a run, as the first has the set-up."""
    for (name, ranks), today in TODAY.items():
        first, both = (log_of(CASES[name], ranks, steps) for steps in (STEPS, 2 * STEPS))
        for figure, unit, count in zip(("messages", "bytes", "reductions"), (1, 1e3, ranks), today):
            value = (both.total(figure, stage="") - first.total(figure, stage="")) / STEPS / unit
            report.expect(f"{name}, {ranks} ranks: {figure} a step", value, at_most=COUNT_MARGIN * count)


def test_balance(report):
    """Straight cuts divide the five levels well on eight ranks, also after points have crossed at the start."""
    result = harness.run({"max_steps": 1, "frames": 0}, file="multiscale_5level.opts", ranks=8)
    for number, level in enumerate(result.summary["levels"]):
        report.expect(f"five levels, 8 ranks: largest over mean points of level {number}", level["imbalance"], at_most=1.05)


def memory_of(options):
    """Largest resident size in kB, and page faults, of a run on one rank."""
    arguments = harness.to_arguments({"output_dir": tempfile.mkdtemp(dir=harness.scratch()), "overwrite": None,
                                      "monitor": "false", **options})
    process = subprocess.Popen(harness.command(arguments, 1), env=harness.ENVIRONMENT, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise AssertionError(f"exit status {status}")
    return usage.ru_maxrss, usage.ru_minflt


def test_memory(report):
    """What is allocated anew in every step shows as page faults, where it is large, and what is never freed as growth."""
    for name, case in CASES.items():
        few, many = (memory_of(with_steps(case, steps)) for steps in (2 * STEPS, 5 * STEPS))
        growth, faults = ((b - a) / (3 * STEPS) for a, b in zip(few, many))
        report.expect(f"{name}: growth of memory a step [kB]", growth, at_most=20)
        report.expect(f"{name}: page faults a step", faults, at_most=10)


def build_counted():
    """Builds the program that is counted, for vectors of four on any machine: valgrind knows no longer ones. Why not, or empty."""
    if not shutil.which("valgrind"):
        return "valgrind is not installed"
    if platform.machine() != "x86_64":
        return "the limits are those of x86-64"
    environment = {name: value for name, value in os.environ.items() if name not in ("CXXFLAGS", "MAKEFLAGS", "SANITIZE")}
    folders = [f"BUILD={harness.ROOT / 'build' / COUNTED.name}", f"BIN={COUNTED}"]
    subprocess.run(["make", "-s", "-j2", "ARCH=-march=haswell", *folders, f"{COUNTED}/mlgimp"], cwd=harness.ROOT, env=environment,
                   stdout=subprocess.DEVNULL, check=True)
    return ""


def instructions_of(case, steps):
    """Instructions a point and step inside Hierarchy::Advance; None where valgrind cannot run the program."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
    options = with_steps(case, steps, output_dir=folder / "run", monitor="false", history_interval=1000)
    counted = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/counts",
               "--toggle-collect=mlgimp::Hierarchy::Advance(double, double)"]
    done = subprocess.run([*counted, str(COUNTED / "mlgimp"), *harness.to_arguments(options)], env=harness.ENVIRONMENT,
                          capture_output=True, text=True)
    if done.returncode != 0:
        return None
    total = int(re.search(r"^(?:summary|totals): (\d+)", (folder / "counts").read_text(), re.M)[1])
    levels = harness.Result(0, "", "", folder / "run").summary["levels"]
    return total / sum(level["points"] * level["steps"] for level in levels)


def test_instructions(report):
    reason = build_counted()
    for name, today in INSTRUCTIONS.items():
        count = None if reason else instructions_of(CASES[name], STEPS // 2)
        if count is None:
            report.note(f"{name}: instructions a point and step", True, f"left out: {reason or 'valgrind cannot run the program'}")
        else:
            report.expect(f"{name}: instructions a point and step", count, at_most=INSTRUCTION_MARGIN * today)
