#!/usr/bin/env python3
"""Finds the constants of a material from a measured load-depth curve: least squares over runs of a case, several at once.

usage: scripts/fit.py MEASURED options/CASE.opts -vary NAME,... [-depth COLUMN:UNIT] [-load COLUMN:UNIT] [-runs N] [-ranks N]
                      [-evaluations N] [options of mlgimp, on all runs]

    scripts/fit.py measured.csv options/cone_metal.opts -vary E,yield_stress -depth Displacement:nm -load Force:mN

MEASURED is a text with columns (scripts/indentation.py says which) or the folder of a run. NAME is an option of the case, with or
without the name of the material or body before it; E and nu stand for youngs_modulus and poissons_ratio. The case's values are the
first guess, and constants stay within a factor of 30 of it. -runs are made at the same time, on -ranks ranks each; the search takes
at most -evaluations steps (30), each of a run and one more for each constant.

The folder output/fit_CASE/ (or -output_dir) gets the runs, fit.csv with every evaluation, fit.json with the constants, and fit.png.
"""
import csv
import json
import math
import os
import sys
import time
from collections import namedtuple
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

import load_depth
import plot
from program import fail, options_of, read_options, run, take, whole_number_from

Study = namedtuple("Study", "measured file vary depth load runs ranks evaluations folder")
Fit = namedtuple("Fit", "values lower upper correlation misfit finished")
Fit.__doc__ = """The constants, the ends of their 95 % confidence intervals, how their errors correlate [][], the rms misfit over the largest load,
and whether the search came to its end."""

SHORT = {"E": "youngs_modulus", "nu": "poissons_ratio"}
LIMITS = {"poissons_ratio": (0.01, 0.49), "hardening_exponent": (1e-3, 1.0)}  # of constants; others: a factor of FAR from the first guess
FAR = 30.0
STEP = 0.05  # of the logarithm of a constant, for slopes: above what corners of the curve, from columns of cells, make of a small step
PARTS = 30  # of the loading and of the unloading whose mean loads are compared
LEAST_DEPTH, LEAST_LOAD = 0.1, 0.2  # of the largest: where the loading begins to count, and where the unloading ends to
LEAST_ROWS = 5  # of the measured unloading
CONVERGED = 1e-3, 1e-3  # relative change of the constants, and of the sum of squares, which one standard error changes by 1/(2 PARTS)
ALIKE = 0.98  # correlation of two constants that cannot be told apart
VAGUE = 0.5  # relative half width of a confidence interval that determines nothing


# ---- command line ----

def parse(words):
    """The study that the command line asks for, and the options that are passed on to the program."""
    if len(words) < 2:
        fail("MEASURED and options/CASE.opts must be given; -help tells more")
    measured, file, passed = Path(words[0]), Path(words[1]), options_of(words[2:])
    for path in (measured, file):
        if not path.exists():
            fail(f"{path}: there is no such file")
    at_once, count = "a whole number >= 1", whole_number_from(1)
    ranks = take(passed, "ranks", count, 1, at_once)
    own = Study(measured, file, take(passed, "vary", lambda text: text.split(","), None, "names of options"),
                take_column(passed, "depth", load_depth.DEPTH_UNITS, "um"), take_column(passed, "load", load_depth.LOAD_UNITS, "mN"),
                take(passed, "runs", count, max(1, (os.cpu_count() or 1) // ranks), at_once), ranks,
                take(passed, "evaluations", count, 30, at_once), Path(passed.pop("output_dir", None) or f"output/fit_{file.stem}"))
    if not own.vary:
        fail("-vary: must be given")
    return own, passed


def take_column(passed, name, units, unit):
    """Takes the column of the measured curve with a name, by default one of that name."""
    return take(passed, name, load_depth.column_argument(units), load_depth.Column(name, units[unit]), f"COLUMN:UNIT with a unit of {', '.join(units)}")


Variable = namedtuple("Variable", "name option start lower upper")


def variable(name, case):
    """The Variable of a name given with -vary, in a case's options."""
    wanted = SHORT.get(name, name)
    options = [option for option in case if option == wanted or option.endswith("_" + wanted)]
    if not options:
        fail(f"-vary {name}: must be an option that the case gives")
    if len(options) > 1:
        fail(f"-vary {name}: must be one of {', '.join(options)}")
    try:
        start = float(case[options[0]])
    except (TypeError, ValueError):
        start = math.nan
    if not 0 < start < math.inf:
        fail(f"-vary {name}: must be an option whose value in the case is a number > 0; -{options[0]} is {case[options[0]]}")
    lower, upper = next((limits for ending, limits in LIMITS.items() if options[0].endswith(ending)), (start / FAR, start * FAR))
    if not lower < start < upper:
        fail(f"-vary {name}: must begin in ({lower:g}, {upper:g}), not at {start:g}")
    return Variable(name, options[0], start, lower, upper)


def variables(own, case):
    """The Variables of a study, each once."""
    found = [variable(name, case) for name in own.vary]
    for k, each in enumerate(found):
        if each.option in [other.option for other in found[:k]]:
            fail(f"-vary {each.name}: must not be given twice")
    return found


# ---- comparison of curves ----

def largest_cycle(curve):
    """The cycle of a curve that reaches the largest load."""
    return max(load_depth.find_cycles(curve), key=lambda cycle: curve.load[cycle.start])


def part_means(distance, load, edges):
    """Mean loads between edges of the distance, whatever rows there are and in whatever order: the work's differences over it."""
    order = np.argsort(distance, kind="stable")
    distance, load = distance[order], load[order]
    work = np.append(0, np.cumsum(np.diff(distance) * (load[1:] + load[:-1]) / 2))
    return np.diff(np.interp(edges, distance, work)) / np.diff(edges)


def edges_of(curve):
    """The edges of the parts of a loading, as depths, and of an unloading, as ways back from the largest depth."""
    cycle = largest_cycle(curve)
    top, load = curve.depth[cycle.start], np.mean(curve.load[cycle.hold])
    down = slice(cycle.start, cycle.end + 1)
    counted = np.flatnonzero(curve.load[down] >= LEAST_LOAD * load)[-1]
    if counted < LEAST_ROWS or top <= 0:
        fail(f"{curve.name}: must have a largest depth > 0, and {LEAST_ROWS} rows of its unloading above {LEAST_LOAD:g} of the load")
    return np.linspace(LEAST_DEPTH * top, top, PARTS + 1), np.linspace(0, top - curve.depth[down][counted], PARTS + 1)


def profile(curve, edges):
    """Mean loads (mN) of the parts of a loading and an unloading.

    Beyond its largest depth a loading goes on like h^2, and beyond its end an unloading keeps its last load. Largest depths that differ
    by less than a row are the same: rows need not lie at the turn.
    """
    cycle = largest_cycle(curve)
    up, down = slice(cycle.begin, cycle.start + 1), slice(cycle.start, cycle.end + 1)
    depth, load = curve.depth[up], curve.load[up]
    top, highest = depth[-1], np.mean(curve.load[cycle.hold])
    near = curve.depth[max(cycle.start - 1, 0):cycle.start + 2]
    turn = edges[0][-1] if abs(top - edges[0][-1]) <= np.abs(np.diff(near)).max() else top
    back, left = turn - curve.depth[down], curve.load[down]
    beyond = np.linspace(top, max(edges[0][-1], top), 20)[1:]
    depth, load = np.append(depth, beyond), np.append(load, highest * (beyond / top) ** 2)
    back, left = np.concatenate([[0], back, [max(edges[1][-1], back[-1])]]), np.concatenate([[highest], left, left[-1:]])
    return np.append(part_means(depth, load, edges[0]), part_means(back, left, edges[1]))


# ---- evaluations ----

class Runs:
    """Runs of a case with other constants: makes those that it does not know yet, several at once, and keeps a table of them."""

    def __init__(self, own, passed, found, measured):
        self.own, self.passed, self.variables = own, passed, found
        self.edges = edges_of(measured)
        self.target = profile(measured, self.edges)
        self.scale = self.target.max()
        self.rows, self.known = [], {}

    def values(self, x):
        """The constants at a place x of the search: logarithms of their ratios to the first guess."""
        return np.array([each.start for each in self.variables]) * np.exp(x)

    def residuals(self, places):
        """Differences from the measured profile, over its largest load, at each of several places."""
        missing = [x for x in places if tuple(x) not in self.known]
        last = len(self.rows)
        folders = [self.own.folder / f"run_{last + k:03d}" for k in range(1, len(missing) + 1)]
        with ThreadPoolExecutor(self.own.runs) as pool:
            jobs = [pool.submit(self.evaluate, x, folder) for x, folder in zip(missing, folders)]
            try:
                for k, (x, job) in enumerate(zip(missing, jobs)):
                    show_progress(k, len(jobs))
                    self.known[tuple(x)], seconds = job.result()
                    self.note(x, seconds)
            finally:
                for job in jobs:
                    job.cancel()
        return [self.known[tuple(x)] for x in places]

    def evaluate(self, x, folder):
        """The residuals of one run, and its seconds."""
        begun = time.monotonic()
        constants = {each.option: repr(float(value)) for each, value in zip(self.variables, self.values(x))}
        where = ", ".join(f"{name} {float(value):.6g}" for name, value in constants.items())
        options = {"frames": 0, "monitor": "false", **self.passed, **constants, "output_dir": folder, "overwrite": None}
        run(self.own.file, options, self.own.ranks, f"at {where}")
        return (profile(load_depth.read_run(folder), self.edges) - self.target) / self.scale, time.monotonic() - begun

    def note(self, x, seconds):
        """Adds a row to the table, shows it and writes the file anew."""
        self.rows.append((len(self.rows) + 1, *self.values(x), misfit_of(self.known[tuple(x)]), seconds))
        print_row([f"{self.rows[-1][0]:d}", *(f"{value:.6g}" for value in self.rows[-1][1:-2]), f"{100 * self.rows[-1][-2]:.4g}", f"{seconds:.1f}"])
        with open(self.own.folder / "fit.csv", "w", newline="") as file:
            csv.writer(file).writerows([("run", *(each.option for each in self.variables), "misfit", "seconds"), *self.rows])

    def slopes(self, x):
        """Derivatives of the residuals [parts][variables] at x, from runs beside it."""
        upper = np.log([each.upper / each.start for each in self.variables])
        steps = np.where(x + STEP > upper, -STEP, STEP)
        here, *beside = self.residuals([x, *(x + np.diag(steps))])
        return np.column_stack([(other - here) / step for other, step in zip(beside, steps)])


def misfit_of(residuals):
    """The root of the mean square."""
    return float(np.sqrt(np.mean(residuals**2)))


def print_row(words):
    print("\r" * sys.stdout.isatty() + f"{words[0]:>4s} " + " ".join(f"{word:>16s}" for word in words[1:]), flush=True)


def shortened(option):
    """An option's name as a column's head."""
    return option if len(option) <= 16 else "..." + option[-13:]


def show_progress(done, count):
    """A bar on a terminal while runs go on."""
    if sys.stdout.isatty():
        full = 30 * done // count
        print(f"\r[{'#' * full}{'.' * (30 - full)}] {done} of {count} runs", end="", flush=True)


# ---- the fit ----

def search(runs):
    """The Fit of all variables: least squares in the logarithms of the constants."""
    lower, upper = (np.log([getattr(each, end) / each.start for each in runs.variables]) for end in ("lower", "upper"))
    found = least_squares(lambda x: runs.residuals([x])[0], np.zeros(len(lower)), lambda x: runs.slopes(x), (lower, upper), "trf", xtol=CONVERGED[0],
                          ftol=CONVERGED[1], gtol=1e-10, max_nfev=runs.own.evaluations)
    return judged(found.x, found.fun, runs.slopes(found.x), runs.values, found.status > 0)


def judged(x, residuals, slopes, values, finished):
    """The Fit at x with its confidence intervals, of Student's distribution, from residuals and slopes there."""
    freedom = len(residuals) - len(x)
    covariance = np.linalg.pinv(slopes.T @ slopes, rcond=1e-14, hermitian=True) * (residuals @ residuals) / freedom
    deviation = np.sqrt(np.diag(covariance))
    reach = np.minimum(student.ppf(0.975, freedom) * deviation, 50)
    scale = np.where(deviation > 0, deviation, 1)
    return Fit(values(x), values(x - reach), values(x + reach), covariance / np.outer(scale, scale), misfit_of(residuals), finished)


def doubts(fit, found):
    """Yields what keeps the constants from being determined."""
    if not fit.finished:
        yield "the search stopped before its end: give more -evaluations, or a better first guess"
    for k, one in enumerate(found):
        if fit.upper[k] - fit.lower[k] > 2 * VAGUE * fit.values[k]:
            yield f"{one.name} is hardly determined: the curve fits with {fit.lower[k]:.3g} to {fit.upper[k]:.3g}"
        if min(abs(math.log(fit.values[k] / limit)) for limit in (one.lower, one.upper)) < 0.01:
            yield f"{one.name} went to its limit {fit.values[k]:.4g}"
        for other in range(k):
            if abs(fit.correlation[k, other]) > ALIKE:
                yield (f"{found[other].name} and {one.name} cannot be told apart by this curve: their errors correlate by {fit.correlation[k, other]:.3f}; "
                       "hold one, or add a test with another tip")


def write_results(own, found, fit, runs, warnings):
    """Prints the constants and writes fit.json."""
    for each, value, lower, upper in zip(found, fit.values, fit.lower, fit.upper):
        print(f"{each.option} {value:.6g}, 95 % confidence {lower:.6g} to {upper:.6g}")
    for line in warnings:
        print(f"warning: {line}")
    constants = {each.option: {"value": float(value), "lower": float(lower), "upper": float(upper)}
                 for each, value, lower, upper in zip(found, fit.values, fit.lower, fit.upper)}
    report = {"constants": constants, "correlation": fit.correlation.tolist(), "misfit": fit.misfit, "runs": len(runs.rows), "warnings": warnings}
    (own.folder / "fit.json").write_text(json.dumps(report, indent=2) + "\n")
    print(own.folder / "fit.csv", own.folder / "fit.json", sep="\n")


def draw(own, measured, runs):
    """Draws the measured curve, the first run and the best one."""
    best = min(runs.rows, key=lambda row: row[-2])[0]
    curves = [("first guess", "0.6", 1), ("fit", "C1", best)]
    figure, axes = plot.plt.subplots(figsize=(6.8, 4.8), layout="constrained")
    axes.plot(measured.depth, measured.load, ".", color="C0", markersize=2, linestyle="none", label=measured.name)
    for label, colour, number in curves:
        curve = load_depth.read_run(own.folder / f"run_{number:03d}")
        axes.plot(curve.depth, curve.load, color=colour, linestyle="-", linewidth=1.3, label=label)
    plot.line_axes(axes, "depth (µm)", "load (mN)")
    axes.legend()
    plot.save(figure, own.folder / "fit.png")


def main(words):
    if words and words[0] in ("-help", "--help", "-h"):
        print(__doc__)
        return
    own, passed = parse(words)
    found = variables(own, {**read_options(own.file), **passed})
    measured = load_depth.read_run(own.measured) if own.measured.is_dir() else load_depth.read_measured(own.measured, own.depth, own.load)
    try:
        own.folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        fail(f"-output_dir {own.folder}: must be a folder ({problem.strerror})")
    runs = Runs(own, passed, found, measured)
    print_row(["run", *(shortened(each.option) for each in found), "misfit, %", "seconds"])
    fit = search(runs)
    warnings = list(doubts(fit, found))
    write_results(own, found, fit, runs, warnings)
    draw(own, measured, runs)


if __name__ == "__main__":
    main(sys.argv[1:])
