#!/usr/bin/env python3
"""Time to a given accuracy on one core: mlgimp, and CalculiX where it is installed (ccx) and has the case.

usage: tests/bench/accuracy.py [CASE ...]        after `make bench` or `make run` has built bin/mlgimp; cases: cone ball wedge, and by its
                                                 name alone berkovich, which takes half an hour

A case is run on finer and finer meshes. A row has the error of the load against a reference and what it cost: steps or increments
of the finest level, point-steps, and seconds of user and system with start and output. An accuracy is reached for good by the
coarsest run from which on all finer ones have it. Loads of the cone and the pyramid are P/h^2 over the last two fifths of the
depth, that of the ball is the one at its depth, that of the wedge at nine depths from 250 nm on. References for infinite bodies are
those for the block of the run, which yields less. Results go to temporary folders.
"""
import math
import resource
import shutil
import sys
import tempfile
from collections import namedtuple
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("tests", "tests/cases", "tests/reference", "scripts")]

from command import Parser

import numpy as np

import cone
import generate
import harness
import hardness
from calculix import NEO_HOOKE, Grid, graded
from finite_elements import columns

Run = namedtuple("Run", "what error seconds steps point_steps")
Case = namedtuple("Case", "title goals ours theirs")  # goals: errors in percent


BLOCK_COMPLIANCE = 0.495  # a block as wide as high on rollers yields by so much P/(E* size) less than a half space: tests/reference/README.md


def seconds_of_children():
    """User and system time of all processes that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def ours(what, options, error, file=None):
    """A run of mlgimp; error(history): relative one of its load."""
    before = seconds_of_children()
    result = harness.run(options, file=file)
    seconds, levels = seconds_of_children() - before, result.summary["levels"]
    return Run(what, error(result.history), seconds, levels[-1]["steps"], sum(level["points"] * level["steps"] for level in levels))


def theirs(what, compute):
    """A run of CalculiX; compute(folder): (relative error of its load, increments)."""
    before = seconds_of_children()
    with tempfile.TemporaryDirectory() as folder:
        error, increments = compute(folder)
    return Run(what, error, seconds_of_children() - before, increments, None)


def curvature_in_block(infinite, size):
    """P/h^2 in a block of a size, m, of that in an infinite body, Pa; of metals with E = 50 GPa."""
    return infinite * (1 + 2 * BLOCK_COMPLIANCE * infinite * hardness.DEPTH / (50e9 / (1 - hardness.POISSON**2) * size))


def curvature_error(C, parts=1):
    """Error of P/h^2 of a history; parts: models like it that make the whole tip."""
    def error(history):
        return parts * hardness.curvature({"depth": history.beside("load_quasi_static", "depth"), "load": history["load_quasi_static"]}) / C - 1
    return error


# ---- a cone in a metal: E 50 GPa, sy 1 GPa, no hardening ----

CONE_ANGLE, CONE_BLOCK, CONE_CURVATURE = 70.3, 25.6e-6, 52.1e9  # P/h^2 in an infinite body, +- 0.2e9 Pa
CONE_RADIUS = hardness.DEPTH * math.tan(math.radians(CONE_ANGLE))  # of the contact without pile-up


def press_cone(coarse):
    """The block of options/cone_metal.opts with as many cells of level 0 across it."""
    cell = CONE_BLOCK / coarse
    inner = math.ceil(2.4e-6 / cell * 2 - 1e-9) * cell / 2
    outer = math.ceil(max(8e-6, inner + 3 * cell) / cell - 1e-9) * cell
    top = CONE_BLOCK + 2 * cell
    material, _ = hardness.metal(50e9, 1e9, 0, CONE_BLOCK)
    material.pop("damping")
    options = {**material, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": [CONE_BLOCK, top], "cell_size": cell,
               "boundary_x_upper": "symmetry", "boundary_y_lower": "symmetry", "levels": 3, "refinement_ratio": 4,
               "level_1_lower": [0.0, CONE_BLOCK - outer], "level_1_upper": [outer, top], "level_2_lower": [0.0, CONE_BLOCK - inner],
               "level_2_upper": [inner, top], "b_lower": "0,0", "b_upper": [CONE_BLOCK, CONE_BLOCK], "indenter": "cone",
               "indenter_half_angle": CONE_ANGLE, "indenter_tip": [0.0, CONE_BLOCK], "quasi_static": "true",
               "indenter_depths": hardness.DEPTH, "frames": 0}
    return ours(f"{CONE_RADIUS / cell * 16:.1f} cells in the contact's radius", options, curvature_error(curvature_in_block(CONE_CURVATURE, CONE_BLOCK)))


def cone_by_elements(size, increments):
    """The cone by finest elements of a size, um."""
    def compute(folder):
        case = cone.Case(CONE_ANGLE, 50.0, 1.0, (1.0, 0.7), 4.0, 1.12, 1.5, increments, 0)
        rows = cone.press(folder, "cone", case, size)
        return hardness.curvature({"depth": rows[:, 0], "load": rows[:, 1]}) / curvature_in_block(CONE_CURVATURE, 1e-6 * cone.size_of(case)) - 1, len(rows)
    return theirs(f"{1e6 * CONE_RADIUS / size:.1f} elements in the contact's radius", compute)


# ---- a ball on an elastic block ----

BALL_RADIUS, BALL_CONTACT, BALL_BLOCK = 100.0, 1.0, 32.0  # um
BALL_DEPTH = BALL_CONTACT**2 / BALL_RADIUS
MODULUS, POISSON = 70.0, 0.3  # GPa


def ball_load():
    """Load of Hertz's ball at its depth, in a block of the size, mN."""
    modulus, load = MODULUS / (1 - POISSON**2), 0.0
    for _ in range(20):
        load = 4 / 3 * modulus * math.sqrt(BALL_RADIUS) * (BALL_DEPTH + BLOCK_COMPLIANCE * load / (modulus * BALL_BLOCK)) ** 1.5
    return load


def press_ball(cells):
    """As many of the finest cells of four levels in the contact's radius."""
    fine = 1e-6 * BALL_CONTACT / cells
    coarse = 8 * fine
    size = round(1e-6 * BALL_BLOCK / coarse) * coarse
    top, boxes, reach = size + 2 * coarse, {}, 0.0
    for level, least, outer in ((3, 2e-6, coarse / 4), (2, 5e-6, coarse / 2), (1, 12e-6, coarse)):  # outer: cells of the level around it
        reach = math.ceil(max(least, reach + 4 * outer) / outer - 1e-9) * outer
        boxes |= {f"level_{level}_lower": [0.0, size - reach], f"level_{level}_upper": [reach, top]}
    options = {"materials": "m", "m_youngs_modulus": MODULUS * 1e9, "m_poissons_ratio": POISSON, "m_density": 2700, "bodies": "b",
               "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": [size, top], "cell_size": coarse, "levels": 4,
               "refinement_ratio": 2, **boxes, "boundary_x_upper": "symmetry", "boundary_y_lower": "symmetry", "b_lower": "0,0",
               "b_upper": [size, size], "indenter": "sphere", "indenter_radius": 1e-6 * BALL_RADIUS, "indenter_tip": [0.0, size],
               "quasi_static": "true", "indenter_depths": 1e-6 * BALL_DEPTH, "frames": 0}

    def error(history):
        depth, load = history.beside("load_quasi_static", "depth"), history["load_quasi_static"]
        rows = (depth > 0.8e-6 * BALL_DEPTH) & (np.arange(len(depth)) <= np.argmax(depth))
        return 1e3 * np.exp(np.mean(np.log(load[rows]) - 1.5 * np.log(depth[rows] * 1e6 / BALL_DEPTH))) / ball_load() - 1
    return ours(f"{cells} cells in the contact's radius", options, error)


def ball(grid, size):
    """The rigid ball, a chain of wedges over the narrow sector, and its contact."""
    first, element = grid.node_count() + 1, grid.element_count() + 1
    xs = np.concatenate([[-0.1], np.arange(0, 2 * BALL_CONTACT, size / 2)])
    lines = ["*NODE, NSET=CONE"]
    for i, x in enumerate(xs):
        low = BALL_BLOCK + max(x, 0) ** 2 / (2 * BALL_RADIUS)
        lines += [f"{first + 4 * i + 2 * k + up},{x:.10g},{low + up:.10g},{z}" for k, z in ((0, -0.2), (1, 0.2)) for up in (0, 1)]
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=CONE")
    for i in range(len(xs) - 1):
        here, there = first + 4 * i, first + 4 * (i + 1)
        lines.append(f"{element + i},{here},{there},{there + 1},{here + 1},{here + 2},{there + 2},{there + 3},{here + 3}")
    lines += ["*MATERIAL, NAME=RIGID", "*ELASTIC", f"{MODULUS},{POISSON}", "*SOLID SECTION, ELSET=CONE, MATERIAL=RIGID", "*SURFACE, NAME=FACE"]
    lines += [f"{element + i},S3" for i in range(len(xs) - 1)] + ["*SURFACE, NAME=SKIN"]
    lines += [f"{grid.element(i, grid.ny - 1)},S5" for i in range(grid.nx) if grid.xs[i] < 1.8 * BALL_CONTACT]
    return lines + ["*SURFACE INTERACTION, NAME=SLIP", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{20 * MODULUS / size:g}",
                    "*CONTACT PAIR, INTERACTION=SLIP, TYPE=SURFACE TO SURFACE", "SKIN,FACE"]


def ball_by_elements(size, increments):
    """The ball by finest elements of a size, um, in the same block."""
    def compute(folder):
        across, down = (graded(size, 1.5 * BALL_CONTACT, BALL_BLOCK, 1.12, 4.0) for _ in range(2))
        across[0] = 0.02 * size  # a pin in place of the axis
        grid = Grid(across, BALL_BLOCK - down[::-1])
        elastic = cone.Case(0, MODULUS, 1e6, None, None, None, None, increments, 0)
        deck = cone.body(grid, elastic) + ball(grid, size) + cone.step(-BALL_DEPTH, increments)
        times, loads = np.array([(time, -np.pi / cone.SECTOR * rows[0, 1]) for time, rows in cone.run(folder, "ball", deck)["total", "CONE"]]).T
        return loads[-1] / ball_load() - 1, len(times)
    return theirs(f"{BALL_CONTACT / size:.0f} elements in the contact's radius", compute)


# ---- a Berkovich pyramid in a metal: E 50 GPa, sy 2 GPa, n 0.3; tests/reference/berkovich.csv ----

BERKOVICH_BLOCK, BERKOVICH_CURVATURE = 64 * hardness.DEPTH, 81.3787e9


def press_pyramid(cells):
    """Half a model with as many of the finest cells of three levels in the depth."""
    fine, size = hardness.DEPTH / cells, BERKOVICH_BLOCK
    top, boxes, margin = size + 32 * fine, {}, 48 * fine
    for level, width, more in ((2, fine, 0), (1, 4 * fine, margin)):
        back, front = (math.ceil((max(reach * hardness.DEPTH, hardness.DEPTH + 12 * fine) + more) / (4 * width) - 1e-9) * 4 * width for reach in (4, 6))
        boxes |= {f"level_{level}_lower": [-back, 0.0, size - back], f"level_{level}_upper": [front, front, top]}
    material, _ = hardness.metal(50e9, 2e9, 0.3, size)
    material.pop("damping")
    options = {**material, **boxes, "geometry": "3d", "domain_lower": [-size, 0.0, 0.0], "domain_upper": [size, size, top], "cell_size": 16 * fine,
               **{f"boundary_{side}": "symmetry" for side in ("x_lower", "x_upper", "y_lower", "y_upper", "z_lower")}, "levels": 3,
               "refinement_ratio": 4, "b_lower": [-size, 0.0, 0.0], "b_upper": [size, size, size], "indenter": "berkovich",
               "indenter_tip": [0.0, 0.0, size], "quasi_static": "true", "indenter_depths": hardness.DEPTH, "frames": 0}
    return ours(f"{cells} cells in the depth, half a model", options, curvature_error(curvature_in_block(BERKOVICH_CURVATURE, BERKOVICH_BLOCK), 2))


# ---- the wedge of the paper, in motion: neo-Hookean aluminium, tests/reference/wedge_neohooke.csv ----

WEDGE_DEPTHS = np.linspace(250e-9, 450e-9, 9)


def wedge_error(depth, load):
    """The largest relative error of a wedge's load at the depths."""
    table = columns("wedge_neohooke.csv")
    exact = np.interp(WEDGE_DEPTHS, table["depth_m"], table["load_h62nm_N"])
    return np.max(np.abs(np.interp(WEDGE_DEPTHS, depth, load) / exact - 1))


def press_wedge(name):
    """A shipped case; its load is that of half a wedge."""
    def error(history):
        return wedge_error(history.beside("load", "depth"), history["load"])
    return ours(f"options/{name}.opts", {"frames": 0}, error, file=f"{name}.opts")


def wedge_by_elements(size, increment):
    """The wedge by finest elements of a size, um, and increments, ns."""
    def compute(folder):
        _, data = generate.shallow_wedge(folder, size, increment, law=NEO_HOOKE)
        rows = generate.wedge_load(data)
        return wedge_error(20 * rows[:, 0], rows[:, 1]), round(22.5 / increment)
    return theirs(f"elements of {1e3 * size:.0f} nm, steps of {1e3 * increment:.0f} ps", compute)


CASES = {
    "cone": Case("cone of 70.3 degrees in a metal, P/h^2", (2, 1), [lambda n=n: press_cone(n) for n in (12, 16, 24, 32, 48)],
                 [lambda size=size, n=n: cone_by_elements(size, n) for size, n in ((0.14, 20), (0.1, 20), (0.07, 30), (0.05, 40), (0.035, 50))]),
    "ball": Case("ball on an elastic body, load", (0.5,), [lambda n=n: press_ball(n) for n in (4, 6, 8, 12, 16)],
                 [lambda n=n: ball_by_elements(BALL_CONTACT / n, 10) for n in (4, 6, 8, 12, 16)]),
    "berkovich": Case("Berkovich pyramid in a metal, P/h^2", (2,), [lambda n=n: press_pyramid(n) for n in (2, 3)], []),
    "wedge": Case("wedge of the paper, load", (2,), [lambda name=name: press_wedge(name) for name in ("wedge_500nm", "wedge_250nm", "wedge_125nm")],
                  [lambda size=size, step=step: wedge_by_elements(size, step) for size, step in ((0.5, 0.25), (0.25, 0.25), (0.125, 0.125))]),
}


def for_good(runs, goal):
    """The coarsest run from which on all errors are within a goal, in percent; None where there is none."""
    kept = None
    for run in reversed(runs):
        if abs(run.error) > goal / 100:
            break
        kept = run
    return kept


def report(program, compute, goals):
    """Prints the rows of a program's runs as they end, and what it needs for the goals."""
    runs = []
    for one in compute:
        run = one()
        runs.append(run)
        work = "" if run.point_steps is None else f"{run.point_steps:.3g}"
        print(f"  {program:10s} {run.what:44s} {100 * run.error:+8.2f} {run.steps:9d} {work:>10s} {run.seconds:8.1f}", flush=True)
    for goal in goals:
        found = for_good(runs, goal)
        print(f"  {program:10s} within {goal:g} % for good: " + (f"{found.seconds:.1f} s, {found.what}" if found else "not by these runs"))


def main():
    parser = Parser(description=__doc__.split("\n")[0])
    parser.add_argument("cases", nargs="*", choices=[[], *CASES], metavar="CASE", help=", ".join(CASES))
    for name in parser.parse_args().cases or [name for name in CASES if name != "berkovich"]:
        case = CASES[name]
        print(f"{case.title}\n  {'':10s} {'':44s} {'error, %':>8s} {'steps':>9s} {'pt-steps':>10s} {'s':>8s}")
        report("mlgimp", case.ours, case.goals)
        if case.theirs and shutil.which("ccx"):
            report("CalculiX", case.theirs, case.goals)
        else:
            print("  CalculiX   " + ("not installed (calculix-ccx)" if case.theirs else "no deck in space"))


if __name__ == "__main__":
    main()
