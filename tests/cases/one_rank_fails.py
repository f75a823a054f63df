"""Failures of one rank of three, at every place where ranks agree before they go on together: each run ends soon, with one line."""
import subprocess
import time

import pytest

import harness
from checkpoints import NESTED

PROGRAM = harness.BIN / "faults" / "mlgimp"  # takes orders to fail; see include/program/system/agree.hpp
RANKS, FAILING = 3, 1
LONGEST = 10  # seconds
CASE = {**NESTED, "points_per_rank": "1", "frames": "2", "checkpoint_interval": "3", "max_steps": "8"}
COPIES = {**CASE, "level_coupling": "points", "ghost_cells": "2"}


def run_with(order, case, folder):
    """(seconds, exit status, lines on standard error)."""
    words = [str(PROGRAM) if word == str(harness.PROGRAM) else word
             for word in harness.command(harness.to_arguments({**case, "output_dir": folder, "overwrite": None}), RANKS)]
    begin = time.time()
    done = subprocess.run(words, capture_output=True, text=True, env={**harness.environment(RANKS), "MLGIMP_FAULT": order},
                          cwd=harness.ROOT, timeout=60)
    return time.time() - begin, done.returncode, harness.lines_of(done.stderr)


def places_of(case, folder):
    _, status, lines = run_with("list", case, folder)
    assert status == 0, lines
    return [line.split(": ")[1] for line in lines]


def wrong_of(case, folder, places, kind):
    wrong = []
    for place in places:
        seconds, status, lines = run_with(f"{place} {FAILING} {kind}", case, folder)
        if status <= 0 or len(lines) != 1 or not lines[0].startswith("mlgimp: error: ") or seconds > LONGEST:
            wrong.append(f"{place}, {kind}: {seconds:.1f} s, status {status}, {lines[:3]}")
    return wrong


def wrong_of_problems(tmp_path, every):
    """What went wrong with a problem at every so many places of a run, of a restart in its folder, and with copies of points."""
    places = places_of(CASE, tmp_path / "run")
    assert {"folder_claim", "history_row", "file_room", "file_dataset", "file_close", "series", "state", "summary"} <= set(places)
    wrong = wrong_of(CASE, tmp_path / "fails", places[::every], "problem")
    for name, case in (("nodes", CASE), ("points", COPIES)):
        places_of(case, tmp_path / name)
        again = {**case, "restart": tmp_path / name / "checkpoint_000003.h5"}
        reading = [place for place in places_of(again, tmp_path / f"{name}_again") if place.startswith("checkpoint_")]
        assert len(reading) >= 15
        wrong += wrong_of(again, tmp_path / f"{name}_fails", reading[:: every if name == "nodes" else 3 * every], "problem")
    return wrong


def test_a_problem_of_one_rank(tmp_path):
    assert not wrong_of_problems(tmp_path, 3)


@pytest.mark.alone
def verify_problems(study, tmp_path):
    """A problem of one rank of three, at each place where they agree.

    Each run ends within ten seconds, with one line and without a trace.
    """
    study.expect("places where a problem of one rank of three ends in anything but one line", len(wrong_of_problems(tmp_path, 1)), at_most=0)


def test_errors_that_the_other_ranks_do_not_know(tmp_path):
    """An error of PETSc, an exception or no memory on one rank, while the others wait for it."""
    places = places_of(CASE, tmp_path / "run")
    wrong = []
    for kind, some in (("error", places[::24]), ("exception", places[6:10:2]), ("memory", places[7:8])):
        wrong += wrong_of(CASE, tmp_path / "fails", some, kind)
    assert not wrong
