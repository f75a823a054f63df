"""Finds constants of creep and relaxation from the hold of a load-depth curve: Norton's law, or the terms of a Prony series."""

import csv
import json
import math
from collections import namedtuple
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from . import checks, creep, holds, load_depth
from .checks import Rule
from .errors import Error, ResultError
from .needs import need

LAWS = ("norton", "prony")
PARTS = 100  # of a hold, of equal widths in the logarithm of its time, whose means are fitted
RAMP = 50  # parts of equal times of the ramp before it, whose means stand for it
FIRST = 1e-4  # of the hold's time: the first of these parts
LEAST_PARTS = 8  # that have rows, beside the constants
ALIKE = 0.98  # correlation of two constants from which on their intervals are those of resampled curves
SAMPLES = 200, 15  # curves, the ends of 95 % have five of them beyond, and steps of the search of each from the fit on
TOLERANCE = 1e-10, 1e-12  # change of what is sought and of the sum of squares
VAGUE = 0.5  # relative half width of a confidence interval that determines nothing
SHAPE = 1e-3, 0.5  # misfit over the largest value, and correlation of neighbours, of residuals that are no noise
LARGEST_EXPONENT = 100.0  # of Norton's law; metals have 1 to 50
SLOW = 100.0  # times the hold: longer times do not count in it
WHOLE_TERMS = 5  # terms that one hold may be asked for: a decade of time for each

Problem = namedtuple("Problem", "model starts lower upper reported")
Problem.__doc__ = """What is sought: model(x), the values at the parts of the hold, at a place x of the search; several first guesses of x and
its limits; reported(x), the constants by their names."""

CREEP_STRESS = Rule(lambda stress: 0 < stress < math.inf, "a number > 0 in Pa")


@dataclass(frozen=True)
class CreepFit:
    """Constants of a law from a hold, {name with its unit: value}, with the ends of their 95 % confidence intervals."""

    law: str
    constants: dict
    lower: dict
    upper: dict
    correlation: np.ndarray  # [n][n] of the errors of what was sought
    misfit: float  # root mean square over the largest value
    resampled: bool  # whether the intervals are those of resampled curves
    curve: load_depth.Curve
    hold: holds.Hold
    table: np.ndarray  # [parts][time of the test s, measured, fitted], um in a hold of the load, mN in one of the depth
    warnings: list

    def plot(self):
        """Returns the picture of the hold and the fit over the time of the test, as a matplotlib Figure."""
        need("matplotlib")  # only where something is drawn
        from . import pictures
        rows = slice(self.hold.begin, self.hold.end + 1)
        name, values = ("depth (µm)", self.curve.depth) if self.hold.kind == "load" else ("load (mN)", self.curve.load)
        return pictures.hold(holds.clock(self.curve)[rows], values[rows], self.table[:, 0], self.table[:, 2], name, self.curve.name)

    def write(self, folder):
        """Writes fit.json and fit.csv into a folder, which is made."""
        folder = Path(checks.path("output_dir", folder))
        time = holds.clock(self.curve)
        report = {"law": self.law, "constants": {name: {"value": value, "lower": self.lower[name], "upper": self.upper[name]}
                                                 for name, value in self.constants.items()},
                  "correlation": self.correlation.tolist(), "intervals": "resampled" if self.resampled else "covariance", "misfit": self.misfit,
                  "hold": {"constant": self.hold.kind, "start_s": float(time[self.hold.begin]), "end_s": float(time[self.hold.end])},
                  "warnings": self.warnings}
        heads = ("time_s", "depth_um", "fitted_depth_um") if self.hold.kind == "load" else ("time_s", "load_mN", "fitted_load_mN")
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / "fit.json").write_text(json.dumps(report, indent=2) + "\n")
            with open(folder / "fit.csv", "w", newline="") as file:
                csv.writer(file).writerows([heads, *self.table.tolist()])
        except OSError as problem:
            raise Error(f"-output_dir {folder}: must be a folder ({problem.strerror})") from None


def fit_creep(measured, law, *, tip=None, terms=1, creep_stress=None, poisson=None):
    """Returns the CreepFit of a law to the hold at the largest load or depth of a curve.

    measured: a load_depth.Curve with times, as of load_depth.read_measured(..., time="t:s"), or the folder of a run with -test_times.
    law: "norton", for a hold of the load: n and a0 of the stress s0 (rate/a0)^(1/n), and the prefactor a0/s0^n;
    "prony", for a hold of the load or the depth: E_0, and shares g_k and times tau_k of E(t) = E_0 (1 - sum g_k (1 - exp(-t/tau_k))).
    tip: a tips.Tip, a ball, a cone or a pyramid, in place of that of the curve. A pyramid counts as the cone with its area.
    terms: of the Prony series. creep_stress: s0 (Pa), by default the stress in the hold, p_m/F. poisson: Poisson's ratio of the specimen,
    in place of that of the run; without one E_0/(1 - nu^2) alone is known.
    """
    if law not in LAWS:
        raise Error(f"creep={law}: must be one of {', '.join(LAWS)}")
    terms = checks.whole("terms", terms, 1)
    if terms > WHOLE_TERMS:
        raise Error(f"terms={terms}: must be at most {WHOLE_TERMS}")
    curve = measured if isinstance(measured, load_depth.Curve) else load_depth.read_run(checks.path("measured", measured))
    shape = shape_of(tip or curve.tip)
    hold, begin = holds.largest_hold(curve)
    poisson = curve.poisson if poisson is None else checks.number("poisson", poisson, creep.POISSON)
    parts = parts_of_hold(curve, hold)
    if law == "norton":
        stress = None if creep_stress is None else checks.number("creep_stress", creep_stress, CREEP_STRESS)
        problem = norton_problem(curve, hold, parts, shape, stress)
    else:
        problem = prony_problem(curve, hold, begin, parts, shape, terms, poisson)
    return solved(law, curve, hold, parts, problem)


# ---- what is fitted ----

def shape_of(tip):
    """Returns {"radius": m} of a ball and {"half_angle": degrees} of a cone, or of a pyramid's cone of the same area, from a Tip."""
    if tip is None:
        raise Error("tip: must be given, a ball, a cone or a pyramid")
    if tip.name == "sphere":
        height = holds.TIGHT
        return {"radius": 1e-6 * (float(tip.area(height)) / math.pi + height**2) / (2 * height)}
    if tip.name in ("flat_punch", "area function"):
        raise Error(f"tip={tip.name}: must be a ball, a cone or a pyramid")
    far = np.sqrt([float(tip.area(height)) / math.pi for height in (1e3, 2e3)])  # um: beyond a ball at the end
    return {"half_angle": math.degrees(math.atan((far[1] - far[0]) / 1e3))}


def means(values, edges, place):
    """Returns the mean of values [rows] in each of the parts between edges that has rows, by their place, and how many these are."""
    part = np.clip(np.searchsorted(edges, place, "right") - 1, 0, len(edges) - 2)
    count = np.bincount(part, minlength=len(edges) - 1)
    return np.bincount(part, values, len(edges) - 1)[count > 0] / count[count > 0], count[count > 0]


def parts_of_hold(curve, hold):
    """Returns {"time", "load", "depth", "count"} of the parts of a Hold, means of their rows [parts] in s, mN and um."""
    rows = slice(hold.begin, hold.end + 1)
    time = holds.clock(curve)[rows]
    span = time[-1] - time[0]
    edges = np.append(0, np.geomspace(FIRST, 1, PARTS)) * span
    found = {name: means(values[rows], edges, time - time[0]) for name, values in
             (("time", holds.clock(curve)), ("load", curve.load), ("depth", curve.depth))}
    return {name: value for name, (value, _) in found.items()} | {"count": found["time"][1]}


def ramp_of(curve, begin, hold, values):
    """Returns times (s) and values [2][rows] from a row to the begin of a Hold: the first row, and means of RAMP parts of equal times."""
    time, ramp = holds.clock(curve), slice(begin, hold.begin + 1)
    first = np.array([[time[begin]], [values[begin]]])
    if not time[hold.begin] > time[begin]:
        return first
    edges = np.linspace(time[begin], time[hold.begin], RAMP + 1)
    return np.column_stack([first, [means(each[ramp], edges, time[ramp])[0] for each in (time, values)]])


# ---- Norton's law ----

def norton_problem(curve, hold, parts, shape, creep_stress):
    """Returns the Problem of Norton's law: h = h0 (1 + (t - t0)/T)^(1/q), in the logarithms of h0, T and n, q = 2 n or n + 1/2."""
    if hold.kind != "load":
        raise ResultError(curve.name, "has a hold of the depth: Norton's law is fitted to one of the load")
    time = holds.clock(curve)
    start, span = time[hold.begin], time[hold.end] - time[hold.begin]
    load, top = 1e-3 * float(np.mean(parts["load"])), float(np.max(parts["depth"]))
    if creep_stress is None:
        constraint, cone, ball = creep.norton_factors(5)
        deep = 1e-6 * top
        area = 2 * ball * shape["radius"] * deep if "radius" in shape else (cone * math.tan(math.radians(shape["half_angle"])) * deep) ** 2
        creep_stress = float(f"{load / (math.pi * area * constraint):.2g}")

    def model(x):
        power = creep.norton_power(math.exp(x[2]), **shape)
        return top * np.exp(x[0] + np.log1p((parts["time"] - start) * math.exp(-x[1])) / power)

    def reported(x):
        exponent = math.exp(min(max(x[2], 0), math.log(LARGEST_EXPONENT)))
        power = creep.norton_power(exponent, **shape)
        rate = power * (x[0] + math.log(1e-6 * top)) - x[1] - creep.log_growth(load, creep_stress, 1.0, exponent, **shape)
        return {"creep_exponent": exponent, "creep_rate_per_s": math.exp(min(rate, 700)), "creep_stress_Pa": creep_stress,
                "log10_prefactor": (rate - exponent * math.log(creep_stress)) / math.log(10)}

    first = math.log(parts["depth"][0] / top)
    starts = [np.array([first, math.log(age * span), math.log(exponent)]) for age in (0.01, 0.3) for exponent in (2, 8)]
    lower, upper = np.array([first - 1, math.log(1e-6 * span), 0.0]), np.array([first + 1, math.log(1e4 * span), math.log(LARGEST_EXPONENT)])
    return Problem(model, starts, lower, upper, reported)


# ---- Prony series ----

def prony_problem(curve, hold, begin, parts, shape, terms, poisson):
    """Returns the Problem of a Prony series: depths by Lee and Radok under the load as measured, or loads at the depth as measured.

    Sought are the logarithms of E*, of g_k/g_inf with g_inf = 1 - sum g_k, so that shares are above 0 and their sum below 1, and of tau_k.
    """
    if begin > 0:
        raise ResultError(curve.name, "has unloadings before its hold: Lee and Radok's law is for a contact that has only grown")
    factor, power = creep.shape_factor(**shape)
    time = holds.clock(curve)
    span = time[hold.end] - time[hold.begin]
    is_load = hold.kind == "load"
    held = "load" if is_load else "depth"
    ramps = ramp_of(curve, begin, hold, getattr(curve, held))
    at, values = np.concatenate([ramps[0], parts["time"]]), np.concatenate([ramps[1], parts[held]])
    driven = 1e-3 * values if is_load else factor * np.maximum(1e-6 * values, 0) ** power  # N; N for each Pa
    measured = parts["depth" if is_load else "load"]

    def unpacked(x):
        shares = np.exp(x[1:terms + 1])
        return math.exp(x[0]), shares / (1 + shares.sum()), np.exp(x[terms + 1:])

    def model(x):
        modulus, shares, times = unpacked(x)
        if is_load:
            strain = creep.history_integral(parts["time"], at, driven, 1.0, *creep.retardation(shares, times)) / (modulus * factor)
            return 1e6 * np.maximum(strain, 0) ** (1 / power)
        return 1e3 * modulus * creep.history_integral(parts["time"], at, driven, 1.0, -shares, times)

    def reported(x):
        modulus, shares, times = unpacked(x)
        order = np.argsort(times)
        found = {"contact_modulus_Pa": modulus} | ({} if poisson is None else {"youngs_modulus_Pa": modulus * (1 - poisson**2)})
        for number, k in enumerate(order, start=1):
            found |= {f"share_{number}": float(shares[k]), f"time_{number}_s": float(times[k])}
        return found | {"long_term_share": float(1 - shares.sum())}

    last = (1e-3 * values[-1] / factor / (1e-6 * measured[-1]) ** power) if is_load else 1e-3 * measured[-1] / driven[-1]
    starts = [np.concatenate([[math.log(last * 1.5)], np.full(terms, -math.log(terms)), np.log(span * spread)])
              for spread in (np.geomspace(0.02, 0.5, terms) if terms > 1 else np.array([0.2]), np.geomspace(0.1, 1, terms),
                             np.geomspace(0.003, 0.3, terms))]
    reach = np.concatenate([[math.log(last) + 7], np.full(terms, 9.0), np.full(terms, math.log(SLOW * span))])
    least = np.concatenate([[math.log(last) - 2], np.full(terms, -9.0), np.full(terms, math.log(FIRST * span))])
    return Problem(model, starts, least, reach, reported)


# ---- the search ----

def solved(law, curve, hold, parts, problem):
    """Returns the CreepFit of a Problem, with intervals from the covariance, or where errors correlate from resampled curves."""
    measured = parts["depth" if hold.kind == "load" else "load"]
    scale, weights = float(np.abs(measured).max()), np.sqrt(parts["count"] / parts["count"].sum() * len(measured))
    freedom = len(measured) - len(problem.starts[0])
    if freedom < LEAST_PARTS:
        raise ResultError(curve.name, f"has rows in {len(measured)} parts of its hold; {len(problem.starts[0]) + LEAST_PARTS} are needed")

    def best(values, starts, steps=None):
        found = [least_squares(lambda x: (problem.model(x) - values) / scale * weights, start, bounds=(problem.lower, problem.upper), x_scale="jac",
                               xtol=TOLERANCE[0], ftol=TOLERANCE[1], gtol=None, max_nfev=steps) for start in starts]
        return min(found, key=lambda each: each.cost)

    found = best(measured, problem.starts)
    covariance = np.linalg.pinv(found.jac.T @ found.jac, rcond=1e-14, hermitian=True) * 2 * found.cost / freedom
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(np.where(deviation > 0, deviation, 1), np.where(deviation > 0, deviation, 1))
    resampled = bool(np.abs(correlation - np.diag(np.diag(correlation))).max() > ALIKE)
    ends = ends_of_samples(problem, found, weights, scale, best) if resampled else ends_of_covariance(problem, found.x, covariance, freedom)
    residuals = found.fun / weights
    misfit = float(np.sqrt(np.mean(residuals**2)))
    constants = problem.reported(found.x)
    lower, upper = ({name: float(each) for name, each in zip(constants, side)} for side in ends)
    fit = CreepFit(law, constants, lower, upper, correlation, misfit, resampled, curve, hold,
                   np.column_stack([parts["time"], measured, problem.model(found.x)]), [])
    fit.warnings.extend(doubts(fit, found, problem, residuals))
    return fit


def transformed(constants):
    """Returns constants as numbers whose errors are about normal: logarithms, of shares those of g/(1 - g), of logarithms themselves."""
    return np.array([value if name.startswith("log10") else math.log(value / (1 - value)) if "share" in name else math.log(value)
                     for name, value in constants.items()])


def back(constants, numbers):
    """Returns the constants of numbers of transformed()."""
    numbers = np.clip(numbers, -700, 700)
    return np.array([value if name.startswith("log10") else 1 / (1 + math.exp(-value)) if "share" in name else math.exp(value)
                     for name, value in zip(constants, numbers)])


def ends_of_covariance(problem, x, covariance, freedom):
    """Returns the lower and the upper ends of 95 % intervals, of Student's distribution."""
    constants = problem.reported(x)
    here, step = transformed(constants), 1e-5
    slopes = np.column_stack([(transformed(problem.reported(x + each)) - here) / step for each in step * np.eye(len(x))])
    reach = student.ppf(0.975, freedom) * np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    return back(constants, here - reach), back(constants, here + reach)


def ends_of_samples(problem, found, weights, scale, best):
    """Returns the ends of 95 % intervals of the constants of SAMPLES curves: the fitted one with residuals drawn anew."""
    random, fitted = np.random.default_rng(1), problem.model(found.x)
    freedom = len(weights) - len(found.x)
    residuals = (found.fun - found.fun.mean()) * math.sqrt(len(weights) / freedom)
    samples = [best(fitted + random.choice(residuals, len(residuals)) * scale / weights, [found.x], SAMPLES[1]).x for _ in range(SAMPLES[0])]
    numbers = np.array([transformed(problem.reported(x)) for x in samples])
    here = transformed(problem.reported(found.x))
    constants = problem.reported(found.x)
    sides = np.percentile(numbers, [2.5, 97.5], axis=0)
    return back(constants, np.minimum(sides[0], here)), back(constants, np.maximum(sides[1], here))


def doubts(fit, found, problem, residuals):
    """Yields what keeps the constants from being determined."""
    names = {"norton": ("depth at its start", "time up to its start", "exponent")}.get(fit.law) or (
        "modulus", *(f"share {k}" for k in range(1, len(found.x) // 2 + 1)), *(f"time {k}" for k in range(1, len(found.x) // 2 + 1)))
    for name, value in fit.constants.items():
        if not name.startswith("log10") and fit.upper[name] - fit.lower[name] > 2 * VAGUE * abs(value):
            yield f"{name} is hardly determined: the hold fits with {fit.lower[name]:.3g} to {fit.upper[name]:.3g}"
    pairs = [(abs(fit.correlation[k, j]), j, k) for k in range(len(names)) for j in range(k)]
    for _, j, k in sorted(pairs, reverse=True):
        if abs(fit.correlation[k, j]) > ALIKE:
            yield (f"{names[j]} and {names[k]} cannot be distinguished by this hold: their errors correlate by {fit.correlation[k, j]:.4f}; "
                   "a longer hold or a faster ramp may part them")
    for name, value, lower, upper in zip(names, found.x, problem.lower, problem.upper):
        if min(value - lower, upper - value) < 0.01:
            yield f"{name} went to its limit"
    span = np.ptp(holds.clock(fit.curve)[[fit.hold.begin, fit.hold.end]])
    for name, value in fit.constants.items():
        if name.startswith("time_") and value > span:
            yield f"{name} is {value:.3g}, longer than the hold of {span:.3g} s"
    follow = float(residuals[1:] @ residuals[:-1] / max(residuals @ residuals, 1e-300))
    if fit.misfit > SHAPE[0] and follow > SHAPE[1]:
        yield (f"the curve is not of the law's shape: residuals of {100 * fit.misfit:.2g} % of the largest value go with their neighbours by "
               f"{follow:.2f}, and the intervals are those of noise alone")
