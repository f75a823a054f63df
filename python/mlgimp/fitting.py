"""Finds the constants of a material from a measured load-depth curve: least squares over runs of a case, several at once."""

import csv
import json
import math
import os
import sys
import time
from collections import namedtuple
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from . import checks, cycles, hints, load_depth
from .errors import Error, RunError
from .needs import need
from .options import named, read_options
from .program import execute, show_bar
from .results import read_summary

Variable = namedtuple("Variable", "name option start lower upper")
Variable.__doc__ = "What is sought: the name as given, the option of the case, its first guess and its limits."

SHORT = {"E": "youngs_modulus", "nu": "poissons_ratio"}
LIMITS = {"poissons_ratio": (0.01, 0.49), "hardening_exponent": (1e-3, 1.0)}  # of constants
FAR = 30.0  # others may be a factor of this from the first guess
STEP = 0.05  # of a constant's logarithm, for slopes: above what the curve's waves with the cells make of a small step
PARTS = 30  # of the loading and of the unloading whose mean loads are compared
LEAST_DEPTH, LEAST_LOAD = 0.1, 0.2  # of the largest: where the loading begins to count, and where the unloading ends to
LEAST_ROWS = 5  # of the measured unloading
CONVERGED = 1e-3, 1e-3  # change of the constants, and of the sum of squares, which a standard error changes by 1/(2 PARTS)
ALIKE = 0.98  # correlation of two constants that cannot be told apart
VAGUE = 0.5  # relative half width of a confidence interval that determines nothing
POOR = 0.02  # misfit of another test's curve; that of the same test on other cells is up to 0.018 with 8 under the contact
DEEPER = 0.03  # difference of largest depths above which they are two tests


@dataclass(frozen=True)
class Fit:
    """What a search has found, for each of the variables [n] in their order, in the units of their options."""

    variables: list  # of Variable
    values: np.ndarray
    lower: np.ndarray  # ends of the 95 % confidence intervals
    upper: np.ndarray
    correlation: np.ndarray  # [n][n] of the errors
    misfit: float  # root mean square over the largest load
    finished: bool  # whether the search came to its end
    measured: load_depth.Curve
    folder: Path  # with the runs, fit.csv and fit.json
    rows: list  # of each run: number, constants, misfit, seconds

    @property
    def constants(self):
        """The constants by the names of their options."""
        return {each.option: float(value) for each, value in zip(self.variables, self.values)}

    @property
    def best(self):
        """The folder of the run that misses least."""
        return self.folder / f"run_{min(self.rows, key=lambda row: row[-2])[0]:03d}"

    @property
    def warnings(self):
        """Lines that tell what keeps the constants from being determined."""
        return list(doubts(self))

    def plot(self):
        """Returns the picture of the measured curve, the first run and the best one, as a matplotlib Figure."""
        need("matplotlib")  # only where something is drawn
        from . import pictures
        drawn = (("first guess", self.folder / "run_001", "0.6"), ("fit", self.best, "C1"))
        runs = [(label, load_depth.read_run(run), colour) for label, run, colour in drawn]
        return pictures.compared(self.measured, runs)


def fit(measured, case, vary, *, ranks=1, runs=None, evaluations=30, output_dir=None, **more):
    """Returns the Fit of a case's constants to a measured curve, by least squares over runs.

    measured: a load_depth.Curve, as of load_depth.read_measured, or the folder of a run.
    case: path of an options file of the same test, whose values are the first guess.
    vary: names of its options, with or without the name of the material; E and nu are short.
    ranks: of each run; runs: how many at once, by default as many as there are processors for.
    evaluations: most steps of the search, each of a run and one more for each constant.
    more: options of the program for all runs.
    The folder output_dir (output/fit_CASE) gets the runs, fit.csv with a row for each, and fit.json with the constants.
    """
    hints.check_names(more, hints.arguments(fit))
    more = named(more)
    ranks, evaluations = checks.whole("ranks", ranks, 1), checks.whole("evaluations", evaluations, 1)
    at_once = max(1, (os.cpu_count() or 1) // ranks) if runs is None else checks.whole("runs", runs, 1)
    curve = measured if isinstance(measured, load_depth.Curve) else load_depth.read_run(checks.path("measured", measured))
    found = variables(vary, {**read_options(checks.path("case", case)), **more})
    folder = Path(output_dir or f"output/fit_{Path(case).stem}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise Error(f"-output_dir {folder}: must be a folder ({problem.strerror})") from None
    table = Runs({"options_file": case, "frames": 0, **more}, found, curve, folder, ranks, at_once)
    print_row(["run", *(shortened(each.option) for each in found), "misfit, %", "seconds"])
    result = search(table, evaluations)
    write(result)
    return result


# ---- what is sought ----

def variable(name, case):
    """Returns the Variable of a name in a case's options."""
    wanted = SHORT.get(name, name)
    options = [option for option in case if option == wanted or option.endswith("_" + wanted)]
    if not options:
        raise Error(f"-vary {name}: must be an option that the case gives")
    if len(options) > 1:
        raise Error(f"-vary {name}: must be one of {', '.join(options)}")
    try:
        start = float(case[options[0]])
    except (TypeError, ValueError):
        start = math.nan
    if not 0 < start < math.inf:
        raise Error(f"-vary {name}: must be an option whose value in the case is a number > 0; "
                    f"-{options[0]} is {case[options[0]]}")
    lower, upper = next((limits for ending, limits in LIMITS.items() if options[0].endswith(ending)), (start / FAR, start * FAR))
    if not lower < start < upper:
        raise Error(f"-vary {name}: must begin in ({lower:g}, {upper:g}), not at {start:g}")
    return Variable(name, options[0], start, lower, upper)


def variables(names, case):
    """Returns the Variables of one name or several in a case's options, each once."""
    names = [names] if isinstance(names, str) else list(names) if isinstance(names, Iterable) else []
    if not names or not all(isinstance(name, str) for name in names):
        raise checks.refusal("vary", names, "a list of names of options, at least one")
    found = [variable(name, case) for name in names]
    for k, each in enumerate(found):
        if each.option in [other.option for other in found[:k]]:
            raise Error(f"-vary {each.name}: must not be given twice")
    return found


# ---- comparison of curves ----

def largest_cycle(curve):
    """The cycle of a curve that reaches the largest load."""
    return max(cycles.find_cycles(curve), key=lambda cycle: curve.load[cycle.start])


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
        raise Error(f"{curve.name}: must have a largest depth > 0, and {LEAST_ROWS} rows of its unloading "
                    f"above {LEAST_LOAD:g} of the load")
    if curve.depth[:cycle.start + 1].min() > LEAST_DEPTH * top:
        raise Error(f"{curve.name}: must begin at less than {LEAST_DEPTH:g} of its largest depth {top:.3g} um, "
                    f"not at {curve.depth[0]:.3g} um")
    return np.linspace(LEAST_DEPTH * top, top, PARTS + 1), np.linspace(0, top - curve.depth[down][counted], PARTS + 1)


def profile(curve, edges):
    """Mean loads (mN) of the parts of a loading and an unloading.

    Beyond its largest depth a loading goes on like h^2, and beyond its end an unloading keeps its last load. Largest depths that
    differ by less than a row are the same: rows need not lie at the turn.
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

    def __init__(self, options, found, measured, folder, ranks, at_once):
        self.options, self.variables, self.measured = options, found, measured
        self.folder, self.ranks, self.at_once = folder, ranks, at_once
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
        folders = [self.folder / f"run_{last + k:03d}" for k in range(1, len(missing) + 1)]
        with ThreadPoolExecutor(self.at_once) as pool:
            jobs = [pool.submit(self.evaluate, x, folder) for x, folder in zip(missing, folders)]
            try:
                for k, (x, job) in enumerate(zip(missing, jobs)):
                    if sys.stdout.isatty():
                        show_bar(k, len(jobs), f"{k} of {len(jobs)} runs")
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
        try:
            execute({**self.options, **constants, "output_dir": folder, "overwrite": True}, self.ranks)
        except RunError as problem:
            raise RunError(f"at {where}: {problem}") from None
        return (profile(load_depth.read_run(folder), self.edges) - self.target) / self.scale, time.monotonic() - begun

    def note(self, x, seconds):
        """Adds a row to the table, shows it and writes the file anew."""
        self.rows.append((len(self.rows) + 1, *self.values(x), misfit_of(self.known[tuple(x)]), seconds))
        number, *values, misfit, _ = self.rows[-1]
        print_row([f"{number:d}", *(f"{value:.6g}" for value in values), f"{100 * misfit:.4g}", f"{seconds:.1f}"])
        with open(self.folder / "fit.csv", "w", newline="") as file:
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


# ---- the search ----

def search(runs, evaluations):
    """Returns the Fit of all variables: least squares in the logarithms of the constants."""
    lower, upper = (np.log([getattr(each, end) / each.start for each in runs.variables]) for end in ("lower", "upper"))
    found = least_squares(lambda x: runs.residuals([x])[0], np.zeros(len(lower)), lambda x: runs.slopes(x), (lower, upper), "trf",
                          xtol=CONVERGED[0], ftol=CONVERGED[1], gtol=1e-10, max_nfev=evaluations)
    return judged(found.x, found.fun, runs.slopes(found.x), runs, found.status > 0)


def judged(x, residuals, slopes, runs, finished):
    """Returns the Fit at x with its confidence intervals, of Student's distribution, from residuals and slopes there."""
    freedom = len(residuals) - len(x)
    covariance = np.linalg.pinv(slopes.T @ slopes, rcond=1e-14, hermitian=True) * (residuals @ residuals) / freedom
    deviation = np.sqrt(np.diag(covariance))
    reach = np.minimum(student.ppf(0.975, freedom) * deviation, 50)
    scale = np.where(deviation > 0, deviation, 1)
    return Fit(runs.variables, runs.values(x), runs.values(x - reach), runs.values(x + reach),
               covariance / np.outer(scale, scale), misfit_of(residuals), finished, runs.measured, runs.folder, runs.rows)


def doubts(fit):
    """Yields what keeps the constants from being determined."""
    found = fit.variables
    if not fit.finished:
        yield "the search stopped before its end: give more -evaluations, or a better first guess"
    best, measured = (curve.depth[largest_cycle(curve).start] for curve in (load_depth.read_run(fit.best), fit.measured))
    if abs(best / measured - 1) > DEEPER:
        yield (f"the best run is pressed {best:.3g} um deep, the measured curve {measured:.3g} um: what lies beyond is a guess; "
               "give the case the test's largest depth or load")
    if fit.misfit > POOR:
        yield (f"the best curve misses the measured one by {100 * fit.misfit:.2g} % of its largest load: "
               "compare tip, law, layers and the machine's compliance, try finer cells, and look at fit.png")
    yield from (f"of the best run: {line}" for line in read_summary(fit.best).get("warnings", []))
    for k, one in enumerate(found):
        if fit.upper[k] - fit.lower[k] > 2 * VAGUE * fit.values[k]:
            yield f"{one.name} is hardly determined: the curve fits with {fit.lower[k]:.3g} to {fit.upper[k]:.3g}"
        if min(abs(math.log(fit.values[k] / limit)) for limit in (one.lower, one.upper)) < 0.01:
            yield f"{one.name} went to its limit {fit.values[k]:.4g}"
        for other in range(k):
            if abs(fit.correlation[k, other]) > ALIKE:
                yield (f"{found[other].name} and {one.name} cannot be told apart by this curve: "
                       f"their errors correlate by {fit.correlation[k, other]:.3f}; hold one, or add a test with another tip")


def write(fit):
    """Writes fit.json; fit.csv is there already."""
    constants = {each.option: {"value": float(value), "lower": float(lower), "upper": float(upper)}
                 for each, value, lower, upper in zip(fit.variables, fit.values, fit.lower, fit.upper)}
    report = {"constants": constants, "correlation": fit.correlation.tolist(), "misfit": fit.misfit, "runs": len(fit.rows),
              "warnings": fit.warnings}
    (fit.folder / "fit.json").write_text(json.dumps(report, indent=2) + "\n")
