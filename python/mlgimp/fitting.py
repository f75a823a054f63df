"""Finds the constants of a material from measured load-depth curves: least squares over runs of their cases, several at once."""

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
from scipy.stats import t as student

from . import checks, fit_profiles, fit_search, hints, imprint, load_depth, oliver_pharr, presets, units
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
ALIKE = 0.98  # correlation of two constants that cannot be told apart
VAGUE = 0.5  # relative half width of a confidence interval that determines nothing
SEEN = 0.02  # of a misfit: by less, a run is as near to the curve as the values found
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
    forecast: np.ndarray  # [n][n] covariance of the logarithms that noise and the first slopes let expect
    misfit: float  # root mean square over the largest load
    finished: bool  # whether the search came to its end
    targets: list  # of fit_profiles.Target: what was measured
    folder: Path  # with the runs, fit.csv and fit.json
    rows: list  # of each set of constants: number, constants, misfit, seconds

    @property
    def constants(self):
        """The constants by the names of their options."""
        return {each.option: float(value) for each, value in zip(self.variables, self.values)}

    @property
    def best(self):
        """The folder of the run that misses least, of several tests that of the first."""
        return folder_of(self.folder, min(self.rows, key=lambda row: row[-2])[0], 0, len(self.targets))

    @property
    def warnings(self):
        """Lines that tell what keeps the constants from being determined."""
        return list(doubts(self))

    @property
    def notes(self):
        """Lines that tell what the intervals do not include."""
        return list(left_out(self))

    def plot(self):
        """Returns the picture of the measured curves, the first runs and the best ones, as a matplotlib Figure."""
        need("matplotlib")  # only where something is drawn
        from . import pictures
        count, best = len(self.targets), min(self.rows, key=lambda row: row[-2])[0]
        drawn = (("first guess", 1, "0.6"), ("fit", best, "C1"))
        return pictures.compared([(target.curve, [(label, load_depth.read_run(folder_of(self.folder, number, k, count)), colour)
                                                  for label, number, colour in drawn]) for k, target in enumerate(self.targets)])


def fit(measured, case, vary, *, profile=None, ranks=1, runs=None, evaluations=30, output_dir=None, **more):
    """Returns the Fit of constants to a measured curve, or to several at once, by least squares over runs.

    measured: a load_depth.Curve, as of load_depth.read_measured, or the folder of a run; or a list of these.
    case: path of an options file of the same test, whose values are the first guess; of several curves a list, in their order.
    vary: names of options of each case, with or without the name of the material; E and nu are short. Those of the first case count.
    profile: an Imprint of the test, as of imprint.read_profile, or of several tests a list with None where there is none.
    ranks: of each run; runs: how many at once, by default as many as there are processors for.
    evaluations: most steps of the search after the first runs; a step is a run of each case.
    more: options of the program for all runs.
    The folder output_dir (output/fit_CASE) gets the runs, fit.csv with a row for each step, and fit.json with the constants.
    """
    hints.check_names(more, hints.arguments(fit))
    more = named(more)
    ranks, evaluations = checks.whole("ranks", ranks, 1), checks.whole("evaluations", evaluations, 1)
    at_once = max(1, (os.cpu_count() or 1) // ranks) if runs is None else checks.whole("runs", runs, 1)
    measured, cases, profiles = tests_of(measured, case, profile)
    curves = [each if isinstance(each, load_depth.Curve) else load_depth.read_run(checks.path("measured", each)) for each in measured]
    options = [presets.written_out({**read_options(checks.path("case", each)), **more}) for each in cases]
    found = variables(vary, options[0])
    names = [[variable(each.name, others).option for each in found] for others in options]
    targets = [fit_profiles.target_of(*pair) for pair in zip(curves, profiles)]
    folder = Path(output_dir or f"output/fit_{Path(cases[0]).stem}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise Error(f"-output_dir {folder}: must be a folder ({problem.strerror})") from None
    given = [{"options_file": each, "frames": int(target.imprint is not None), **more} for each, target in zip(cases, targets)]
    table = Runs(given, names, found, targets, folder, ranks, at_once)
    print_row(["run", *(shortened(each.option) for each in found), "misfit, %", "seconds"])
    result = search(table, evaluations)
    write(result)
    return result


def tests_of(measured, case, profile):
    """Returns the curves, the cases and the profiles of one test or of several as lists of one length."""
    several = isinstance(measured, (list, tuple)) and not isinstance(measured, load_depth.Curve)
    if several != isinstance(case, (list, tuple)):
        raise checks.refusal("case", case, "a list with a case for each curve" if several else "the path of an options file")
    if not several:
        return [measured], [case], [profile]
    if not measured or len(case) != len(measured):
        raise checks.refusal("case", case, f"a list with a case for each of the {len(measured)} curves, at least one")
    profiles = [None] * len(measured) if profile is None else profile
    if not isinstance(profiles, (list, tuple)) or isinstance(profiles, fit_profiles.Imprint) or len(profiles) != len(measured):
        raise checks.refusal("profile", "...", f"a list with an imprint or None for each of the {len(measured)} curves")
    return list(measured), list(case), list(profiles)


# ---- what is sought ----

def variable(name, case):
    """Returns the Variable of a name in a case's options."""
    wanted = SHORT.get(name, name)
    options = [option for option in case if option == wanted or option.endswith("_" + wanted)]
    if not options:
        own = [option.partition("_")[2] or option for option in case]  # without the name of the material
        near = hints.meant(name, [*case, *own, *SHORT])
        raise Error(f"-vary {name}: must be an option that the case gives" + f"; the nearest is {near}" * bool(near))
    if len(options) > 1:
        raise Error(f"-vary {name}: must be one of {', '.join(options)}")
    try:
        [start] = units.numbers_of(case[options[0]])
    except (Error, TypeError, ValueError):
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


# ---- evaluations ----

def folder_of(folder, number, k, count):
    """The folder of a run: its number, and of several tests that of the test."""
    return folder / (f"run_{number:03d}" + f"_{k + 1}" * (count > 1))


class Runs:
    """Runs of the cases with other constants, several at once, and a table of them."""

    def __init__(self, options, names, found, targets, folder, ranks, at_once):
        """options and names, of the program's options that are varied: a dict and a list for each of the Targets."""
        self.options, self.names, self.variables, self.targets = options, names, found, targets
        self.folder, self.ranks, self.at_once = folder, ranks, at_once
        self.scales = [target.scale for target in targets]
        self.rows = []

    def values(self, x):
        """The constants at a place x of the search: logarithms of their ratios to the first guess."""
        return np.array([each.start for each in self.variables]) * np.exp(x)

    def groups(self):
        """The slices of the residuals that are alike: loading, unloading and imprint of each test."""
        begins = np.cumsum([0, *(len(target.values) for target in self.targets)])
        return [slice(begin + part.start, begin + part.stop) for begin, target in zip(begins, self.targets) for part in target.groups]

    def errors(self):
        """The standard errors of the residuals by the noise of the tests, [rows]."""
        return np.concatenate([target.error / scale for target, scale in zip(self.targets, self.scales)])

    def residuals(self, places):
        """Differences from the measured values, over the largest load of each test, at each of several places: [places][rows]."""
        tests, number = range(len(self.targets)), len(self.rows)
        found = []
        with ThreadPoolExecutor(self.at_once) as pool:
            jobs = [[pool.submit(self.evaluate, x, number + row, k) for k in tests] for row, x in enumerate(places, start=1)]
            try:
                for row, (x, own) in enumerate(zip(places, jobs)):
                    if sys.stdout.isatty():
                        show_bar(row, len(jobs), f"{row} of {len(jobs)} runs")
                    residuals, seconds = zip(*(job.result() for job in own))
                    found.append(np.concatenate(residuals))
                    self.note(x, found[-1], sum(seconds))
            finally:
                for job in [job for own in jobs for job in own]:
                    job.cancel()
        return found

    def evaluate(self, x, number, k):
        """The residuals of one run for the test k, and its seconds."""
        begun, target = time.monotonic(), self.targets[k]
        constants = {option: repr(float(value)) for option, value in zip(self.names[k], self.values(x))}
        where = ", ".join(f"{name} {float(value):.6g}" for name, value in constants.items())
        folder = folder_of(self.folder, number, k, len(self.targets))
        try:
            execute({**self.options[k], **constants, "output_dir": folder, "overwrite": True}, self.ranks)
        except RunError as problem:
            raise RunError(f"at {where}: {problem}") from None
        left = imprint.profile_of(folder) if target.imprint is not None else None
        values = fit_profiles.compared(load_depth.read_run(folder), left, target)
        return (values - target.values) / self.scales[k], time.monotonic() - begun

    def note(self, x, residuals, seconds):
        """Adds a row to the table, shows it and writes the file anew."""
        self.rows.append((len(self.rows) + 1, *self.values(x), misfit_of(residuals), seconds))
        number, *values, misfit, _ = self.rows[-1]
        print_row([f"{number:d}", *(f"{value:.6g}" for value in values), f"{100 * misfit:.4g}", f"{seconds:.1f}"])
        with open(self.folder / "fit.csv", "w", newline="") as file:
            csv.writer(file).writerows([("run", *(each.option for each in self.variables), "misfit", "seconds"), *self.rows])


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
    """Returns the Fit of all variables: least squares in the logarithms of the constants, after a forecast by the first slopes."""
    lower, upper = (np.log([getattr(each, end) / each.start for each in runs.variables]) for end in ("lower", "upper"))
    going = fit_search.Search(runs.residuals, lower, upper, runs.groups(), runs.errors())
    forecast = going.begin()
    for line in [*of_other_tests(runs), *forecast_lines(runs.variables, forecast)]:
        print(line)
    found, finished = going.go(evaluations)
    freedom = len(found.residuals) - len(found.x)
    deviation, correlation = parts_of(found.covariance)
    reach = np.minimum(student.ppf(0.975, freedom) * deviation, 50)
    misfit, best = misfit_of(found.residuals), np.array(min(runs.rows, key=lambda row: row[-2])[1:-2], float)
    ends = [runs.values(found.x - reach), runs.values(found.x + reach)]
    if min(row[-2] for row in runs.rows) < misfit:  # intervals hold the constants of a run that is nearer to the curve
        ends = [np.minimum(ends[0], best), np.maximum(ends[1], best)]
    return Fit(runs.variables, runs.values(found.x), *ends, correlation, forecast, misfit, finished, runs.targets, runs.folder, runs.rows)


def parts_of(covariance):
    """Returns the standard errors [n] and the correlation [n][n] of a covariance."""
    deviation = np.sqrt(np.diag(covariance))
    scale = np.where(deviation > 0, deviation, 1)
    return deviation, covariance / np.outer(scale, scale)


def forecast_lines(found, covariance):
    """Yields what the tests can tell by their noise and the slopes at the first guess: standard errors, and what they cannot distinguish."""
    deviation, correlation = parts_of(covariance)
    yield "by noise and first slopes, standard errors: " + ", ".join(f"{each.name} {100 * error:.2g} %" for each, error in zip(found, deviation))
    for k, other in zip(*np.tril_indices(len(found), -1)):
        if abs(correlation[k, other]) > ALIKE:
            yield f"this test cannot tell {found[other].name} from {found[k].name}: correlation {correlation[k, other]:.3f}"


def of_other_tests(runs):
    """Yields which first runs are those of another test, pressed to another depth and by another load than the measured curve."""
    for k, target in enumerate(runs.targets):
        first, measured = (fit_profiles.depth_and_load(curve) for curve in (load_depth.read_run(folder_of(runs.folder, 1, k, len(runs.targets))), target.curve))
        if np.all(np.abs(first / measured - 1) > DEEPER):
            yield (f"warning: the first run of {target.curve.name} is pressed {first[0]:.3g} um deep by {first[1]:.3g} mN, the measured curve {measured[0]:.3g} um by "
                   f"{measured[1]:.3g} mN: is the case that of the test? An interrupt ends the search")


def left_out(fit):
    """Yields what cells and block of the best runs may do to them, see oliver_pharr.expected_errors()."""
    number, count = min(fit.rows, key=lambda row: row[-2])[0], len(fit.targets)
    for k in range(count):
        curve = load_depth.read_run(folder_of(fit.folder, number, k, count))
        found = oliver_pharr.expected_errors(curve, fit_profiles.largest_cycle(curve))
        if found["expected_error"]:
            load, modulus = (100 * found["expected_error"][name] for name in ("load_mN", "modulus_GPa"))
            yield (f"the intervals are those of the noise alone: {found['cells']:.2g} cells in half the contact and this block may change the run's loads by "
                   f"{load:.2g} %, a modulus by {modulus:.2g} %" + f" (test {k + 1})" * (count > 1))


def doubts(fit):
    """Yields what keeps the constants from being determined."""
    found = fit.variables
    if not fit.finished:
        yield "the search stopped before its end: give more -evaluations, or a better first guess"
    yield from doubts_of_runs(fit)
    yield from doubts_of_best(fit)
    if fit.misfit > POOR:
        yield (f"the best curve misses the measured one by {100 * fit.misfit:.2g} % of its largest load: "
               "compare tip, law, layers and the machine's compliance, try finer cells, and look at fit.png")
    for k, one in enumerate(found):
        if fit.upper[k] - fit.lower[k] > 2 * VAGUE * fit.values[k]:
            yield f"{one.name} is hardly determined: the curve fits with {fit.lower[k]:.3g} to {fit.upper[k]:.3g}"
        if min(abs(math.log(fit.values[k] / limit)) for limit in (one.lower, one.upper)) < 0.01:
            yield f"{one.name} went to its limit {fit.values[k]:.4g}"
        for other in range(k):
            if abs(fit.correlation[k, other]) > ALIKE:
                curves = "this curve" if len(fit.targets) == 1 else "these curves"
                yield (f"{found[other].name} and {one.name} cannot be told apart by {curves} but for what their intervals say: "
                       f"their errors correlate by {fit.correlation[k, other]:.3f}; hold one, or add a test with another tip")


def doubts_of_best(fit):
    """Yields which run of the table misses less than the values that were found, where that is seen in what is printed of both."""
    number, *values, misfit, _ = min(fit.rows, key=lambda row: row[-2])
    if misfit < (1 - SEEN) * fit.misfit:
        constants = ", ".join(f"{each.name} {value:.4g}" for each, value in zip(fit.variables, values))
        yield (f"run {number} of fit.csv misses {100 * misfit:.3g} % with {constants}, the values found {100 * fit.misfit:.3g} %: these are "
               "the best of a smooth surface through all runs, in which loading and unloading count by what is left of each; the intervals hold both")


def doubts_of_runs(fit):
    """Yields what the best runs have that their tests have not, and what the program warns of in them."""
    number, count = min(fit.rows, key=lambda row: row[-2])[0], len(fit.targets)
    for k, target in enumerate(fit.targets):
        folder, of = folder_of(fit.folder, number, k, count), f" of {target.curve.name}" * (count > 1)
        best, measured = (fit_profiles.depth_and_load(curve)[0] for curve in (load_depth.read_run(folder), target.curve))
        if abs(best / measured - 1) > DEEPER:
            yield (f"the best run{of} is pressed {best:.3g} um deep, the measured curve {measured:.3g} um: what lies beyond is a guess; "
                   "give the case the test's largest depth or load")
        yield from (f"of the best run{of}: {line}" for line in read_summary(folder).get("warnings", []))


def write(fit):
    """Writes fit.json; fit.csv is there already."""
    constants = {each.option: {"value": float(value), "lower": float(lower), "upper": float(upper)}
                 for each, value, lower, upper in zip(fit.variables, fit.values, fit.lower, fit.upper)}
    deviation, correlation = parts_of(fit.forecast)
    report = {"constants": constants, "correlation": fit.correlation.tolist(), "misfit": fit.misfit, "runs": len(fit.rows) * len(fit.targets),
              "forecast": {"standard_errors": deviation.tolist(), "correlation": correlation.tolist()}, "warnings": fit.warnings, "notes": fit.notes}
    (fit.folder / "fit.json").write_text(json.dumps(report, indent=2) + "\n")
