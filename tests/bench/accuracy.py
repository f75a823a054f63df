#!/usr/bin/env python3
"""Time to a given accuracy on one core: mlgimp, and CalculiX where it is installed (ccx) and has the case.

usage: tests/bench/accuracy.py [CASE ...]        after `make bench` or `make run` has built bin/mlgimp; cases: cone ball berkovich wedge

A case is run on finer and finer meshes. A row says how far the load is from a reference of others, and what it cost: an
accuracy is reached for good by the coarsest run from which on all finer ones have it. Loads of a cone and a pyramid are
P/h^2 by least squares over the last two fifths of the depth, that of a ball and a wedge the one at the largest depth.
Times are of a process, user and system, with its start and output. Results go to a temporary folder.
"""
import argparse
import math
import resource
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests", "tests/cases", "tests/reference", "scripts")]

import numpy as np

import calculix
import cone
import generate
import harness
import hardness
from finite_elements import columns

CONE_C, BERKOVICH_C = 52.1e9, 81.3787e9  # P/h^2, Pa: the cone's in an infinite body, +- 0.2; berkovich.csv
METAL = {"materials": "m", "m_model": "j2", "m_youngs_modulus": 50e9, "m_poissons_ratio": 0.3, "m_density": 5000, "bodies": "b"}
ELASTIC_MODULUS, POISSON = 70e9, 0.3
BLOCK_COMPLIANCE = 0.37  # of a block as wide as high on rollers: it yields by so much P/(E* size) less than a half space


class Run:
    """What a run found and cost."""

    def __init__(self, what, error, seconds, steps, point_steps=None):
        self.what, self.error, self.seconds, self.steps, self.point_steps = what, error, seconds, steps, point_steps


def seconds_of_children():
    """User and system time of processes that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def ours(what, options, error, file=None):
    """A run of mlgimp; error(history): relative error of its load."""
    before = seconds_of_children()
    result = harness.run(options, file=file)
    seconds, summary = seconds_of_children() - before, result.summary
    work = sum(level["points"] * level["steps"] for level in summary["levels"])
    return Run(what, error(result.history), seconds, summary["levels"][-1]["steps"], work)


def theirs(what, compute):
    """A run of CalculiX; compute(folder): (relative error, increments)."""
    before = seconds_of_children()
    with tempfile.TemporaryDirectory() as folder:
        error, increments = compute(folder)
    return Run(what, error, seconds_of_children() - before, increments)


# ------------------------------------------------------------- cone in a metal

DEPTH, ANGLE = hardness.DEPTH, 70.3
RADIUS = DEPTH * math.tan(math.radians(ANGLE))  # of the contact without pile-up


def cone_options(coarse):
    """options/cone_metal.opts with as many cells of level 0 across its block, by a slow test."""
    size, cell = 25.6e-6, 25.6e-6 / coarse
    outer, inner = (math.ceil(reach / width) * width for reach, width in ((8e-6, cell), (2.4e-6, cell / 2)))
    top = size + 2 * cell
    return {"domain_upper": [size, top], "cell_size": cell, "level_1_lower": [0.0, size - outer], "level_1_upper": [outer, top],
            "level_2_lower": [0.0, size - inner], "level_2_upper": [inner, top], "quasi_static": "true", "indenter_depths": DEPTH,
            "damping": None, "frames": 0}


def curvature_error(C, share=1):
    """Error of P/h^2; share: of the pyramid that is modelled."""
    return lambda history: hardness.curvature(history) / share / C - 1


def cone_runs():
    options = [{name: value for name, value in cone_options(coarse).items() if value is not None} for coarse in (12, 16, 24, 32, 48)]
    return [ours(f"{RADIUS / each['cell_size'] * 16:.1f} cells in the contact's radius", {**each, "damping": 0.0}, curvature_error(CONE_C),
                 file="cone_metal.opts") for each in options]


def cone_by_elements(size, increments):
    case = cone.Case(ANGLE, 50.0, 1.0, (1.0, 0.7), 4.0, 1.12, 1.5, increments, 0)

    def compute(folder):
        rows = cone.press(folder, "cone", case, size)
        return hardness.curvature({"depth": rows[:, 0], "load": rows[:, 1]}) / CONE_C - 1, len(rows)
    return theirs(f"elements of a {RADIUS / size * 1e6:.0f}th of the contact's radius, {increments} increments", compute)


CASES = {"cone": ("cone of 70.3 degrees, E 50 GPa, sy 1 GPa: P/h^2", (2, 1), cone_runs)}
