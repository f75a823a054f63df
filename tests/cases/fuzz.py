"""Mutated options: whatever the words, a run ends by itself, with one line that names an option or with its results."""
import collections
import contextlib
import json
import pathlib
import random
import re
import resource
import shutil
import subprocess
import tempfile
import time

import pytest

import harness
from ranks import COLLISION, FLIGHT, LEVELS, WEDGE

LONGEST = 10         # seconds that a run of two steps may take
MEMORY = 3 << 30     # bytes of address space, so that a run that asks for more is found and not the machine's end
FOLDER = b"out"

NUMBERS = ("0", "-0", "-1", "1", "2", "3", "1.5", "16", "17", "1000", "100000", "1e9", "1e-300", "1e-320", "1e300", "-1e300", "1.7e308", "1e309",
           "nan", "-nan", "inf", "-inf", "2147483647", "2147483648", "4294967297", "-2147483649", "9223372036854775808", "0x10", "1e", ".", "-",
           "+", "1,", ",1", ",", "1,,2", "1;2", "1 2", "abc", "true", "0.1", "1e-3", "0.5", "nan,nan", "inf,-inf", "1,2,3", "0,0", "1e300,1e300")
WORDS = ("none", "pressure", "point_pressure", "multimesh", "wedge", "cylinder", "flat_punch", "polygon", "box", "disk", "nodes", "points",
         "flags", "place", "linear", "ugimp", "usl", "usf", "musl", "fixed", "symmetry", "free", "j2", "hypoelastic", "st_venant_kirchhoff",
         "neo_hookean", "x_lower", "y_upper", "true", "false", "a" * 300, "A", "..", "/", "-", "--", "%s%n%d", "$HOME", "'", '"', "\\")
BYTES = (b"\xff\xfe", b"\xc3\x28", b"\xf0\x9f\x92\xa9", b"\x07", b"\x1b[31m", b"\x7f", b"1\xff", b"a\x00b", b"\xef\xbb\xbf1")
LONG = ("1" * 5000, "a" * 70000, "1," * 20000 + "1", "0." + "0" * 9000 + "1", "x," * 3000 + "x")
# Names that begin or equal options of PETSc, of the program and of each other.
NAMES = ("contact", "indenter", "level", "level_1", "log", "log_view", "mat", "ksp", "help", "malloc", "options", "max", "end", "NAME", "block", "a" * 200)
# Options that few cases give, with a value that is allowed somewhere.
MORE = {"xpic_fraction": "0.1", "xpic_order": "1", "damping": "1e6", "short_wave_viscosity": "0,0", "gravity": "0,-1e9", "stress_update": "usl",
        "shape_function": "linear", "contact": "multimesh", "level_coupling": "points", "ghost_cells": "5", "ghost_ownership": "place",
        "blend_width": "2", "merge_siblings": "true", "refinement_ratio": "4", "levels": "2", "history_interval": "7", "checkpoint_interval": "1",
        "sort_interval": "1", "points_per_rank": "1", "rebalance_threshold": "1", "indenter_tip_radius": "1e-6", "cfl": "1", "geometry": "3d",
        "indenter_unload_velocity": "20", "contact_monitor": "true", "thickness": "1", "loads": "press", "restart": "nothing.h5",
        "contact_ksp_type": "gmres", "contact_pc_type": "lu", "contact_ksp_rtol": "1e-6", "contact_ksp_atol": "1e-9", "contact_ksp_max_it": "1", "frames": "1000000", "level_1_lower": "0,0"}


def shipped_cases():
    """{name: [(option, value)]} of the options files; the two with most points on fewer."""
    cases = {}
    for path in sorted((harness.ROOT / "options").glob("*.opts")):
        lines = [line.split("#")[0].split() for line in path.read_text().splitlines()]
        cases[path.name] = [(words[0][1:], words[1] if len(words) > 1 else "true") for words in lines if words]
    for name, cell in (("wedge_62nm.opts", "500e-9"), ("wedge_125nm.opts", "1e-6")):
        cases[name] = [(option, cell if option == "cell_size" else value) for option, value in cases[name]]
    for name, case in (("wedge", WEDGE), ("levels", LEVELS), ("flight", FLIGHT), ("collision", COLLISION)):
        cases[name] = [(option, str(value)) for option, value in case.items()]
    return cases


def nasty_value(choice, value):
    """Another value, of the same kind or not."""
    kind = choice.randrange(10)
    parts = value.split(",")
    k = choice.randrange(len(parts))
    if kind < 3:
        with contextlib.suppress(ValueError):
            parts[k] = f"{float(parts[k]) * choice.choice((-1, 1)) * 10.0 ** choice.choice((-12, -6, -3, -1, 0, 1, 2, 3, 6, 12, 200)):g}"
        return ",".join(parts)
    if kind < 5:
        parts[k] = choice.choice(NUMBERS)
        return ",".join(parts)
    if kind == 5:
        return ",".join(parts + parts[:1]) if choice.random() < 0.5 else ",".join(parts[:-1])
    if kind == 6:
        return choice.choice(NUMBERS)
    if kind == 7:
        return choice.choice(WORDS)
    if kind == 8:
        return choice.choice(LONG)
    return choice.choice(BYTES)


def mutate(choice, options):
    """One mutation of a list of (option, value)."""
    options = list(options)
    k = choice.randrange(len(options))
    name, value = options[k]
    text = value if isinstance(value, str) else "1"
    kind = choice.randrange(16)
    if kind == 0:
        del options[k]
    elif kind == 1:
        options.append((name, text))
    elif kind == 2:
        j = choice.randrange(len(options))
        options[k], options[j] = (name, options[j][1]), (options[j][0], value)
    elif kind == 3:
        options[k] = (name, "")
    elif kind == 4:
        cut = choice.randrange(len(name))
        options[k] = (choice.choice((name[:cut] + name[cut + 1:], name.upper(), name + "x", "-" + name, name.replace("_", "-"), "contact_" + name)), text)
    elif kind == 5:  # another name for a body, a material or a load
        lists = [place for place, (option, _) in enumerate(options) if option in ("bodies", "materials", "loads")]
        if lists:
            place = choice.choice(lists)
            old, new = str(options[place][1]).split(",")[0], choice.choice(NAMES)
            options = [(option.replace(old + "_", new + "_", 1) if option.startswith(old + "_") else option,
                        new if isinstance(at, str) and at == old else at) for option, at in options]
    elif kind < 9:
        option = choice.choice(sorted(MORE))
        options = [pair for pair in options if pair[0] != option]
        options.append((option, MORE[option] if choice.random() < 0.6 else nasty_value(choice, MORE[option])))
    else:
        options[k] = (name, nasty_value(choice, text))
    return options or [(name, text)]


def write_file(path, options):
    """The options as a file; what is no text goes in as bytes."""
    lines = [b"-" + name.encode() + b" " + (value if isinstance(value, bytes) else value.encode()) for name, value in options]
    path.write_bytes(b"\n".join(lines) + b"\n")


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run_mutant(folder, options, ranks, last_words):
    """(exit status, standard output, standard error, seconds) of two steps in a folder; a status of None: still running."""
    write_file(folder / "case.opts", options)
    words = ["-options_file", "case.opts", "-output_dir", FOLDER.decode(), "-monitor", "false"] + last_words
    begin = time.time()
    process = subprocess.Popen(harness.command(words, ranks), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               env=harness.environment(ranks), cwd=folder, preexec_fn=limit_memory)
    try:
        out, error = process.communicate(timeout=LONGEST * (1 if ranks == 1 else 2))
        return process.returncode, out, error, time.time() - begin
    except subprocess.TimeoutExpired:
        process.terminate()
        process.communicate()
        return None, b"", b"", time.time() - begin


def problem_of(folder, status, error):
    """What is wrong with an end; empty where nothing is."""
    text = error.decode(errors="replace")
    lines = [line for line in harness.lines_of(text) if line and not line.startswith("mlgimp: warning: ")]
    if status is None:
        return "it hangs"
    if status < 0 or status > 125:
        return f"signal, status {status}: {text[-300:]}"
    left = {path.name for path in folder.iterdir()} - {"case.opts"}
    if left - {"out"} or list(folder.glob("out/*.part")):
        return f"leaves {sorted(left)}"
    if status == 0:
        if lines:
            return f"status 0, but: {text[:300]}"
        return "" if json.loads((folder / "out" / "summary.json").read_bytes().decode(errors="replace"))["status"] == "completed" else "summary"
    if len(lines) != 1 or not lines[0].startswith("mlgimp: error: "):
        return f"{len(lines)} lines: {text[:400]}"
    if re.search(r"[\x00-\x1f\x7f]", lines[0]) or len(lines[0]) > 2000:
        return f"unprintable or long: {lines[0][:100]!r}"
    message = lines[0].removeprefix("mlgimp: error: ")
    if re.match(r"time \S+, level \d+: ", message):  # in the run: the rows so far are kept
        return "" if (folder / "out" / "history.csv").exists() else "no history"
    if not re.search(r"-[A-Za-z]|^'", message):
        return "no option is named: " + message[:300]
    if left and "by now" not in message:
        return f"refused, but leaves {sorted(left)}: {message[:200]}"
    return ""


def fuzz(expect, count, seed):
    choice = random.Random(seed)
    cases = shipped_cases()
    ends, slowest, found = collections.Counter(), 0, 0
    for number in range(count):
        name = choice.choice(sorted(cases))
        options = cases[name]
        for _ in range(choice.choice((1, 1, 1, 2, 3))):
            options = mutate(choice, options)
        options = [pair for pair in options if pair[0] not in ("output_dir", "monitor", "max_steps")]
        frames = [] if any(option == "frames" for option, _ in options) else ["-frames", "1"]
        steps = choice.choice(("0", "-1", "1e12", "two", "1.5", "")) if choice.random() < 0.02 else "2"
        if steps == "0":
            options = [pair for pair in options if pair[0] not in ("end_time", "indenter_max_depth")]
        ranks = 2 if number % 10 == 9 else 1
        folder = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
        status, _, error, seconds = run_mutant(folder, options, ranks, ["-max_steps", steps] + frames)
        problem = problem_of(folder, status, error)
        if problem:
            found += 1
            changed = [pair for pair in options if pair not in cases[name]] + [("without", option) for option, _ in cases[name] if option not in dict(options)]
            expect.that(f"mutant {number} of {name} on {ranks} ranks", False, f"{problem} <- {str(changed)[:400]}")
        ends["hangs" if status is None else "runs" if status == 0 else "refused" if status == 1 else "other"] += 1
        slowest = max(slowest, seconds)
        shutil.rmtree(folder)
    expect(f"mutants with a wrong end, of {count}", found, at_most=0)
    expect("mutants that are refused, of all", ends["refused"] / count, at_least=0.3)
    expect("mutants that run, of all", ends["runs"] / count, at_least=0.1)
    expect("seconds of the slowest mutant", slowest, at_most=2 * LONGEST)


@pytest.mark.parametrize("ranks", [1, 2])
def test_memory(tmp_path, ranks):
    """A grid that the memory does not hold is refused before it is made."""
    options = [(name, "1e-9" if name == "cell_size" else str(value)) for name, value in WEDGE.items()]
    status, _, error, seconds = run_mutant(tmp_path, options, ranks, ["-max_steps", "2"])
    assert not problem_of(tmp_path, status, error)
    assert "memory" in error.decode()
    assert seconds < LONGEST


@pytest.mark.slow
def test_fuzz(expect):
    fuzz(expect, 40, 1)


def verify_fuzz(study):
    """Mutated options.

    Each shipped case and those of the tests with one to three mutations: options taken away, doubled, exchanged, misspelt or added, values out of range, of
    another kind, very long or no text. Each mutant runs two steps, every tenth on two ranks, with 3 GB of memory. It has a wrong end where it dies by a
    signal, takes too long, says anything but one line that names an option, or leaves files though it was refused.
    """
    fuzz(study.expect, 2000, 2)
