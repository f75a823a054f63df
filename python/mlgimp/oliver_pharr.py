"""The analysis of an unloading by Oliver and Pharr, beside what the true contact area gives. Units: mN, um, GPa = mN/um^2, nJ."""

import math
import warnings
from collections import namedtuple

import numpy as np
from scipy.optimize import curve_fit

from . import checks, cycles, holds, iso14577, tips
from .checks import Rule
from .errors import Error, ResultError

WINDOW = (0.5, 0.97)  # of the load at the start of the unloading: the part that is fitted
LEAST_ROWS = 5  # in the window
HARDNESS = (1e-6, 200)  # GPa, of gels and of diamond
ROUNDING = 1e-4  # of the depth: what a fit's iteration leaves
EXPONENTS = (1.0, 3.0)  # that the fit may find; contacts of elastic bodies have 1 (flat punch) to 2 (cone)

Constants = namedtuple("Constants", "window epsilon beta poisson tip_modulus tip_poisson iso", defaults=(WINDOW, None, None, None, math.inf, 0.0, False))
Constants.__doc__ = """What the user chose; None: epsilon and beta of the tip, Poisson's ratio of the run. The tip is rigid by default. iso: None means
epsilon of the unloading's exponent and a beta of 1, and the numbers of iso14577.COLUMNS are found."""

TOUCH, LATE = 0.005, 0.2  # of the load of a cycle, from which on a tip touches, a cone at 0.07 of the depth; of the depth, which is too late
RELOADED = 0.02  # of the depth: so much less deep than before, a test in which the tip comes back to the same load does not stop
UNSEEN = 0.002  # of the work: what may lie before the first row; the first interval of a run of twenty rows has less
STIFFEST = 2000  # GPa, above which no solid is; diamond has 1141
POISSON = Rule(lambda nu: -1 < nu <= 0.5, "in (-1, 0.5]")
RULES = {  # for Constants
    "window": Rule(lambda window: len(window) == 2 and 0 <= window[0] < window[1] <= 1, "LOW,HIGH with 0 <= LOW < HIGH <= 1"),
    "epsilon": checks.POSITIVE, "beta": checks.POSITIVE, "poisson": POISSON,
    "tip_modulus": Rule(lambda modulus: 0 < modulus <= STIFFEST or modulus == math.inf,
                        f"in (0, {STIFFEST}] GPa; 1141 GPa are 1141, not 1141e9"),
    "tip_poisson": POISSON,
}

COLUMNS = ("curve", "cycle", "depth_um", "load_mN", "stiffness_mN_per_um", "stiffness_error_mN_per_um", "exponent", "final_depth_um",
           "fit_residual", "rows", "epsilon", "beta", "contact_depth_um", "area_um2", "hardness_GPa", "reduced_modulus_GPa", "modulus_GPa",
           "true_area_um2", "true_hardness_GPa", "true_modulus_GPa", "pile_up_um", "total_work_nJ", "elastic_work_nJ", "plastic_share",
           "warnings", "cells", "expected_error", "hold_start_s", "hold_end_s", "C_IT_percent", "R_IT_percent", "creep_rate_um_per_s",
           "unloading_rate_mN_per_s", "corrected_stiffness_mN_per_um", "corrected_hardness_GPa", "corrected_reduced_modulus_GPa",
           "corrected_modulus_GPa", *iso14577.COLUMNS)
HELD = COLUMNS[COLUMNS.index("hold_start_s"):COLUMNS.index("corrected_modulus_GPa") + 1]  # what a hold gives
EDGE, AREA = 0.3, 0.6  # of a cell: see expected_errors()
STIFFER = 1.09  # half widths of the contact: a block of the width L takes 0.545 P/(E* L) from the depth, that is of 1/S = 1/(2 E* a)

Unloading = namedtuple("Unloading", "depth load stiffness stiffness_error exponent final_depth residual rows raised")
Unloading.__doc__ = """Where an unloading begins (um, mN), its stiffness there with the standard error of the fit (mN/um), m and hf of
P = A (h - hf)^m, the fit's root mean square residual over the load, the rows that were fitted, and how far above the surface hf
came out (um) before it was held there."""

PowerLaw = namedtuple("PowerLaw", "load slope exponent error residual raised")
PowerLaw.__doc__ = "What fit_power_law() finds: P1, S with its standard error, m, root mean square residual, and how far hf was below zero."


def checked_constants(iso=False, **given):
    """Returns the Constants that a caller gives by name; None stands for what is taken by default, with iso by the norm."""
    for name in given:
        if name not in RULES:
            raise Error(f"{name}: must be one of {', '.join(RULES)}")
    read = {name: checks.several if name == "window" else checks.number for name in RULES}
    given = {name: read[name](name, value, RULES[name]) for name, value in given.items() if value is not None}
    return Constants(**{"window": iso14577.WINDOW if checks.flag("iso", iso) else WINDOW, **given}, iso=iso)


def fit_unloading(curve, cycle, window=WINDOW, exponents=EXPONENTS):
    """Returns the Unloading of a cycle: least squares of P = A (h - hf)^m over the rows from the upper to the lower load of the window.

    The unknowns are load and slope at the largest depth h1, and m: P = P1 (1 + S (h - h1)/(m P1))^m, hf = h1 - m P1/S. A tip
    touches nothing above the surface that it first met: where hf came out below zero, it is zero, and S = m P1/h1. exponents: the least and
    the largest m.
    """
    top_depth, top_load = np.mean(curve.depth[cycle.hold]), np.mean(curve.load[cycle.hold])
    if not top_depth > 0:
        raise ResultError(curve.name, f"an unloading begins at a depth of {top_depth:.3g} um: depths count from the surface below the tip as it "
                                      "was at the start of the run, and the contact is above that, as on the rim of a hole")
    rows = slice(cycle.start, cycle.end + 1)
    depth, share = curve.depth[rows] - top_depth, curve.load[rows] / top_load
    below, above = np.flatnonzero(share <= window[1]), np.flatnonzero(share >= window[0])
    fitted = slice(below[0] if len(below) else 0, above[-1] + 1 if len(above) else 0)
    depth, share = depth[fitted], share[fitted]
    if len(share) < LEAST_ROWS:
        raise ResultError(curve.name, f"{max(len(share), 0)} rows of the unloading lie between {window[0]:g} and {window[1]:g} of its load; "
                                  f"the fit needs {LEAST_ROWS}: take more rows, a slower unloading or a wider window")
    travel = -depth.min()
    if not travel > 0:
        raise ResultError(curve.name, "the tip does not go back in the fitted part of the unloading")

    law = fit_power_law(depth / travel, share, top_depth / travel, exponents)
    stiffness, error = (slope / travel * top_load for slope in (law.slope, law.error))
    first = cycle.start + fitted.start
    return Unloading(top_depth, top_load, stiffness, error, law.exponent, top_depth - law.exponent * law.load / law.slope * travel,
                     law.residual, slice(first, first + len(share)), law.raised * travel)


def fit_power_law(depth, share, deepest, exponents=EXPONENTS):
    """Returns the PowerLaw of shares of the load at depths from the largest, `deepest`, which is above zero."""
    def law(depth, load, slope, exponent):
        return load * np.maximum(1 + slope * depth / (exponent * load), 0) ** exponent

    def held_law(depth, load, exponent):
        return law(depth, load, exponent * load / deepest, exponent)

    (least, most), raised = exponents, 0.0
    start = min(max(1.5, least), most)
    line = max(np.polyfit(depth, share, 1)[0], 1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a covariance that is not known where m is at its limit
        (load, slope, exponent), covariance = curve_fit(law, depth, share, (1.0, line, start), bounds=((0.1, 1e-6, least), (10, np.inf, most)))
        by = np.array([0, 1, 0])  # derivatives of the slope
        if 0 < deepest * (1 + ROUNDING) < exponent * load / slope:
            raised = exponent * load / slope - deepest
            (load, exponent), covariance = curve_fit(held_law, depth, share, (1.0, start), bounds=((0.1, least), (10, most)))
            slope, by = exponent * load / deepest, np.array([exponent, load]) / deepest
    residual = np.sqrt(np.mean((law(depth, load, slope, exponent) - share) ** 2))
    return PowerLaw(load, slope, exponent, math.sqrt(by @ covariance @ by), residual, raised)


def fitted_load(fit, depth):
    """Returns the load (mN) of an Unloading's power law at depths (um)."""
    reach = np.maximum((depth - fit.final_depth) / (fit.depth - fit.final_depth), 0)
    return fit.stiffness * (fit.depth - fit.final_depth) / fit.exponent * reach**fit.exponent


def contact(tip, depth, load, stiffness, epsilon, beta):
    """Returns contact depth (um), area (um^2), hardness and reduced modulus (GPa) of Oliver and Pharr, J. Mater. Res. 7 (1992) 1564.

    Here and below each number may be an array, of which all have one shape; what has no meaning is NaN.
    """
    contact_depth = depth - epsilon * load / stiffness
    area = np.asarray(tip.area(contact_depth), float)[()]
    return contact_depth, area, hardness(load, area), reduced_modulus(stiffness, area, beta)


def hardness(load, area):
    return load / above_zero(area)


def reduced_modulus(stiffness, area, beta):
    """Returns Er (GPa) of S = 2 beta Er sqrt(A/pi)."""
    return np.sqrt(np.pi / above_zero(area)) * stiffness / (2 * beta)


def specimen_modulus(reduced, poisson, constants):
    """Returns E (GPa) of 1/Er = (1 - nu^2)/E + (1 - nu_tip^2)/E_tip; NaN without a Poisson's ratio, or where the tip gives way more than both."""
    poisson = math.nan if poisson is None else poisson
    return (1 - poisson**2) / above_zero(1 / reduced - (1 - constants.tip_poisson**2) / constants.tip_modulus)


def above_zero(values):
    """Returns numbers with NaN for those that are not above zero."""
    return np.where(np.asarray(values) > 0, values, math.nan)[()]


def work(curve, cycle, fit):
    """Returns the work put in up to the unloading less what earlier unloadings gave back, and what this one gives back, in nJ.

    What an unloading that stops above zero load would still give back is that of the fitted curve.
    """
    power = np.append(0, np.cumsum(np.diff(curve.depth) * (curve.load[1:] + curve.load[:-1]) / 2))
    rest = max(curve.load[cycle.end], 0) * max(curve.depth[cycle.end] - fit.final_depth, 0) / (fit.exponent + 1)
    return power[cycle.start], power[cycle.start] - power[cycle.end] + rest


def analyse(curve, constants=Constants()):
    """Returns a list with a dict of results for each unloading of a Curve; what has no meaning or is not known is NaN."""
    return [row for row, _ in analysed(curve, constants)]


def analysed(curve, constants=Constants()):
    """Returns a list of pairs for the unloadings of a Curve: the dict of results and the Unloading. One that cannot be fitted has NaN
    and None, and a warning that says why; where that are all, the error is that of the largest load."""
    constants, pairs, problems = constants_of(curve, constants), [], []
    for number, cycle in enumerate(cycles.find_cycles(curve), start=1):
        try:
            fit = fit_unloading(curve, cycle, constants.window)
            pairs.append((analyse_cycle(curve, number, cycle, fit, constants), fit))
        except ResultError as problem:
            pairs.append((left_out(curve, number, cycle, problem), None))
            problems.append((curve.load[cycle.start], number, problem))
    if len(problems) == len(pairs):
        raise max(problems)[-1]
    return pairs


def constants_of(curve, constants):
    """Returns Constants with the tip of a run, where that is elastic and no other is given."""
    if curve.tip_elastic is None or constants.tip_modulus < math.inf:
        return constants
    return constants._replace(tip_modulus=curve.tip_elastic[0], tip_poisson=curve.tip_elastic[1])


def left_out(curve, number, cycle, problem):
    """Returns the dict of a cycle that cannot be fitted because of a ResultError."""
    depth, load = (float(np.mean(values[cycle.hold])) for values in (curve.depth, curve.load))
    why = f"left out: the load falls from {load:.4g} to {curve.load[cycle.end]:.4g} mN, and {problem.problem}"
    return dict.fromkeys(COLUMNS, math.nan) | {"curve": curve.name, "cycle": number, "depth_um": depth, "load_mN": load, "rows": 0, "warnings": why,
                                             "expected_error": None}


def analyse_cycle(curve, number, cycle, fit, constants):
    """Returns the results of one cycle with its Unloading by name and unit, by the names COLUMNS."""
    poisson = curve.poisson if constants.poisson is None else constants.poisson
    true_area = float(np.mean(curve.area[cycle.hold])) if curve.area is not None else math.nan
    total, elastic = work(curve, cycle, fit)
    row = {"curve": curve.name, "cycle": number, "depth_um": fit.depth, "load_mN": fit.load, "stiffness_mN_per_um": fit.stiffness,
           "stiffness_error_mN_per_um": fit.stiffness_error, "exponent": fit.exponent, "final_depth_um": fit.final_depth,
           "fit_residual": fit.residual, "rows": int(fit.rows.stop - fit.rows.start)}
    names = ("epsilon", "beta", "contact_depth_um", "area_um2", "hardness_GPa", "reduced_modulus_GPa", "modulus_GPa")
    row |= dict.fromkeys(names, math.nan)
    true_modulus, pile_up = math.nan, math.nan
    if curve.tip is not None:
        epsilon, beta = epsilon_and_beta(curve.tip, fit.exponent, fit.depth, fit.load / fit.stiffness, poisson, constants)
        figures = contact(curve.tip, fit.depth, fit.load, fit.stiffness, epsilon, beta)
        check_depth(curve, figures[0])
        row |= dict(zip(names, (epsilon, beta, *figures, specimen_modulus(figures[-1], poisson, constants))))
        true_modulus = specimen_modulus(reduced_modulus(fit.stiffness, true_area, beta), poisson, constants)
        pile_up = tips.depth_of(curve.tip, true_area, 3 * fit.depth) - fit.depth
    row |= {"true_area_um2": true_area, "true_hardness_GPa": hardness(fit.load, true_area), "true_modulus_GPa": true_modulus,
            "pile_up_um": pile_up, "total_work_nJ": total, "elastic_work_nJ": elastic, "plastic_share": 1 - elastic / total if total > 0 else math.nan}
    row |= {"warnings": "; ".join(doubts(curve, cycle, fit, row)), **expected_errors(curve, cycle)}
    plane_strain = specimen_modulus(row["reduced_modulus_GPa"], 0.0, constants)
    norm = iso14577.figures(curve, cycle, fit, row, plane_strain) if constants.iso else dict.fromkeys(iso14577.COLUMNS, math.nan)
    return row | held_figures(curve, cycle, fit, row, constants) | norm


def epsilon_and_beta(tip, exponent, depth, elastic, poisson, constants):
    """Returns epsilon and beta of unloadings: those that the user chose, else those of the norm or of the Tip.

    exponent: m of the unloading; depth, elastic: at its start, and P/S there (um).
    """
    epsilon = constants.epsilon if constants.epsilon is not None else iso14577.epsilon(exponent) if constants.iso else tip.epsilon
    if constants.beta is not None or constants.iso:
        return epsilon, 1.0 if constants.beta is None else constants.beta
    return epsilon, tip.beta(poisson, depth - epsilon * elastic)


def check_depth(curve, depth):
    """Refuses a contact depth (um) beyond the largest to which the tip was calibrated."""
    if depth > curve.tip.largest:
        raise ResultError(curve.name, f"the contact depth of {1e3 * depth:.4g} nm is beyond {1e3 * curve.tip.largest:.4g} nm, the largest to which the tip "
                                      "was calibrated: its area there is not known")


def held_figures(curve, cycle, fit, row, constants):
    """Returns the results HELD of the hold before an unloading; NaN without a hold or a time of the test, and what creeps or relaxes in it where no
    material of the run does.

    C_IT_percent is C_IT = (h2 - h1)/h1 at constant load and R_IT_percent R_IT = (P1 - P2)/P1 at constant depth, of ISO 14577-1,
    from hold_start_s to hold_end_s. corrected_... are figures of the stiffness without creep, see holds.corrected_stiffness().
    """
    found, hold = dict.fromkeys(HELD, math.nan), holds.find_hold(curve, cycle)
    if hold is None:
        return found
    time = holds.clock(curve)
    found |= {"hold_start_s": float(time[hold.begin]), "hold_end_s": float(time[hold.end])}
    if curve.creeps is False:  # what moves are waves that settle
        return found
    if hold.kind == "depth":
        return found | {"R_IT_percent": -100 * holds.change(curve, hold)}
    onset = holds.rows_of_onset(curve, cycle, hold)
    creep, unloading = holds.creep_rate(curve, hold), holds.unloading_rate(curve, onset)
    stiffness = holds.corrected_stiffness(holds.onset_compliance(curve, hold, onset), creep, unloading)
    found |= {"C_IT_percent": 100 * holds.change(curve, hold), "creep_rate_um_per_s": creep, "unloading_rate_mN_per_s": unloading,
              "corrected_stiffness_mN_per_um": stiffness}
    if curve.tip is None or not math.isfinite(stiffness):
        return found
    poisson = curve.poisson if constants.poisson is None else constants.poisson
    *_, pressure, modulus = contact(curve.tip, fit.depth, fit.load, stiffness, row["epsilon"], row["beta"])
    return found | {"corrected_hardness_GPa": pressure, "corrected_reduced_modulus_GPa": modulus,
                    "corrected_modulus_GPa": specimen_modulus(modulus, poisson, constants)}


def expected_errors(curve, cycle):
    """Returns {"cells": finest cells in half the width of the contact at the start of a cycle, "expected_error": {name: share of the
    result}}; NaN and None of measured curves, and of runs where they are not known.

    Against the same runs on 20 cells, load, stiffness and what follows from them were off by at most EDGE/cells, and the contact's
    area by AREA/cells, in 24 runs of four metals (E over yield stress 100 to 1400) under a cone of 70.3 degrees with 4 to 13 cells;
    at the root of the mean square by a third of that. Moduli are too large by STIFFER over the model's width in half widths of the
    contact as well.
    """
    cells = math.nan if curve.cells is None else float(np.mean(curve.cells[cycle.hold]))
    if not cells > 0:
        return {"cells": math.nan, "expected_error": None}
    edge, area = EDGE / cells, AREA / cells
    block = STIFFER / float(np.mean(curve.block[cycle.hold]))
    return {"cells": cells, "expected_error": {
        "load_mN": edge, "stiffness_mN_per_um": edge, "hardness_GPa": edge, "reduced_modulus_GPa": edge + block, "modulus_GPa": edge + block,
        "true_area_um2": area, "true_hardness_GPa": area, "true_modulus_GPa": area + block}}


def notes_on(rows):
    """Yields notes on dicts of results: where reduced moduli are known and no specimen's modulus is, and where nothing creeps in a hold."""
    if any(math.isfinite(row["hold_start_s"]) and math.isnan(row["C_IT_percent"]) and math.isnan(row["R_IT_percent"]) for row in rows):
        yield "no material of the run creeps or relaxes: what moves in its holds are waves that settle, and there is no C_IT or R_IT"
    if any(math.isfinite(row["reduced_modulus_GPa"]) for row in rows) and not any(math.isfinite(row["modulus_GPa"]) for row in rows):
        yield ("there is no modulus of the specimen: its Poisson's ratio is not known, or that of a run's materials is not the same; give it "
               "(--poisson, poisson=)")


def doubts(curve, cycle, fit, row):
    """Yields what makes the figures of a cycle doubtful."""
    yield from doubts_of_fit(curve, fit, row)
    yield from doubts_of_test(curve, cycle, fit, row)
    yield from doubts_of_area(curve, row)


def doubts_of_fit(curve, fit, row):
    """Yields what is wrong with the fitted unloading."""
    is_run = curve.cells is not None
    at_limit = min(abs(fit.exponent - limit) for limit in EXPONENTS) < 1e-6
    if at_limit and not (curve.tip and curve.tip.name == "flat_punch"):
        cause, cure = (", as where few cells of contact let go one by one", ", or smaller cells") if is_run else ("", "")
        yield (f"the exponent is at its limit {fit.exponent:.3g}: the unloading is no power law{cause}; try a wider window (--window){cure}")
    if not curve.plane and math.isfinite(row["hardness_GPa"]) and not HARDNESS[0] <= row["hardness_GPa"] <= HARDNESS[1]:
        yield f"a hardness of {row['hardness_GPa']:.3g} GPa is that of no solid: are the units of depth and load right?"
    if fit.residual > 0.02:
        yield f"the unloading differs from its fit by {100 * fit.residual:.1f} % of the load"
    if fit.raised > 0.05 * fit.depth:
        yield (f"the unloading by itself points at {fit.raised:.3g} um above the surface, and is fitted with a final depth of 0: "
               f"is the zero of depths right, and are {'cells' if is_run else 'rows'} enough?")
    if abs(fitted_load(fit, fit.depth) / fit.load - 1) > 0.05:
        yield f"the fitted curve has {100 * fitted_load(fit, fit.depth) / fit.load:.0f} % of the load at its start: hold before the unloading, and begin it slowly"
    if fit.stiffness_error > 0.05 * fit.stiffness:
        yield f"the stiffness is known to {100 * fit.stiffness_error / fit.stiffness:.0f} % only"


def doubts_of_test(curve, cycle, fit, row):
    """Yields what is wrong with the loading, and with the order of things."""
    loading = cycles.without_spikes(curve.load)[cycle.begin:cycle.start + 1]
    last_peak = np.flatnonzero(loading >= loading.max() - 0.01 * abs(loading.max()))[-1]
    rest = 3 * cycles.noise(curve.depth) + 1e-6 * fit.depth
    if loading[-1] < 0.97 * loading[last_peak] and curve.depth[(cycle.begin + last_peak + cycle.start) // 2] < curve.depth[cycle.start] - rest:
        yield "the depth goes on growing while the load falls (nose): hold the load longer"
    before = curve.load[0] * max(curve.depth[0], 0) / 2  # nJ, from a loading between P ~ h and P ~ h^2
    if before > UNSEEN * abs(row["total_work_nJ"]):
        yield (f"the curve begins at {curve.depth[0]:.3g} um and {curve.load[0]:.3g} mN: up to "
               f"{100 * before / (before + row['total_work_nJ']):.2g} % of the work was done before, which no figure of work has")
    deepest = curve.depth[:cycle.begin + 1].max()
    if cycle.begin > 0 and deepest > (1 + RELOADED) * fit.depth:
        yield (f"the tip was {deepest:.3g} um deep before, deeper than at the start of this unloading: here the contact is elastic, and the "
               "load over its area is no hardness")
    touch = int(np.argmax(loading > TOUCH * fit.load))
    if cycle.begin == 0 and touch > 0 and curve.depth[touch] > LATE * fit.depth:
        yield (f"there is no load up to {curve.depth[touch]:.3g} um, {100 * curve.depth[touch] / fit.depth:.0f} % of the depth: "
               f"is the zero of depths where the tip touches{' (--zero-depth)' * (curve.cells is None)}?")
    if row["plastic_share"] < -0.05:
        yield (f"the unloading gives back {row['elastic_work_nJ'] / row['total_work_nJ']:.2g} times the work put in before: are the rows in order, "
               "and is the loading whole?")


def doubts_of_area(curve, row):
    """Yields what is wrong with the area of the contact."""
    if curve.tip and 0 < row["contact_depth_um"] < curve.tip.ball and row["beta"] != 1:
        yield (f"the contact depth is on the ball at the tip's end, which is {curve.tip.ball:.3g} um high: for a ball beta is 1 and epsilon 0.75, "
               f"here they are {row['beta']:.3g} and {row['epsilon']:.3g}; choose them by --beta and --epsilon")
    if curve.tip:
        yield from tips.doubts(curve.tip, row["contact_depth_um"])
    if row["area_um2"] <= 0:
        yield (f"the contact depth is below zero ({row['contact_depth_um']:.3g} um)" if row["contact_depth_um"] <= 0 else
               f"the area of the tip at the contact depth is not above 0 ({row['area_um2']:.3g} um2): is its function right?")
    elif abs(row["true_area_um2"] / row["area_um2"] - 1) > 0.1:
        yield f"the true contact area is {row['true_area_um2'] / row['area_um2']:.2f} of that by Oliver and Pharr"
