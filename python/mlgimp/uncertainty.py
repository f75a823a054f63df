"""How well hardness and modulus of an unloading are known: a Monte Carlo after the Guide to the Expression of Uncertainty, supplement 1
(JCGM 101:2008). Inputs are drawn from what is known of them, and each draw is analysed anew. Units: um, mN, GPa; inputs as they are named."""

import csv
import math
from collections import namedtuple

import numpy as np

from . import checks, cycles, oliver_pharr
from .checks import Rule
from .errors import Error, ResultError

Inputs = namedtuple("Inputs", "zero_nm compliance_nm_per_mN area_percent poisson depth_nm load_uN", defaults=(None,) * 6)
Inputs.__doc__ = """Standard uncertainties of what goes into an analysis: contact point, frame compliance, area of the tip, Poisson's ratio, and
noise of each row's depth and load; None: by default, see standard()."""

Share = namedtuple("Share", "source input deviation")
Share.__doc__ = "What one source does: its name, the input in words, and the standard deviations of the QUANTITIES."

Uncertainty = namedtuple("Uncertainty", "values shares deviation lower upper draws left_out", defaults=((),))
Uncertainty.__doc__ = """QUANTITIES of an unloading: values; a Share for each source; and of all together the standard deviations and the ends of the
intervals that hold 95 % of the draws, each a dict; how many draws; and sentences about what the intervals do not include."""

QUANTITIES = ("hardness_GPa", "reduced_modulus_GPa", "modulus_GPa")
FRAME, AREA, POISSON = 0.05, 2.0, 0.03  # nm/mN: a quarter of what frames of 5e6 N/m have; %: of an area function; of metals and ceramics
WINDOW = 0.1, 0.02  # half widths between which the window's lower and upper end may lie: 0.4 to 0.6, 0.95 to 0.99
GRID = 5  # windows along each of these that are fitted; draws are from them
SEEN = 3  # times the noise of the load, at which a contact is seen
ORDER = 1  # of the error with the cells: loads and areas of contacts whose rim lies within a cell
LEAST_RATIO = 1.2  # of the cells of two runs whose difference says something about either
ANOTHER = 0.05  # difference of depths above which two runs are two tests; cells change the depth under load control by less
RULES = {name: Rule(lambda value: 0 <= value < math.inf, "a number >= 0") for name in Inputs._fields}
DRAWS = Rule(lambda count: 100 <= count <= 100000, "a whole number in [100, 100000]")


def standard(curve, fit, given=Inputs()):
    """Returns all Inputs of a Curve: the given ones, others by default.

    Noise is that of the curve from row to row, or what the fit leaves where that is more. The contact point lies anywhere from where the
    tip touches to where the load is SEEN times its noise, or is as sure as the zero of depths that was found. Frame, area and Poisson's ratio
    have FRAME, AREA and POISSON; a run knows its own, and its contact point.
    """
    is_run = curve.cells is not None
    load, depth = cycles.noise(curve.load), cycles.noise(curve.depth)
    left = math.sqrt(max((fit.residual * fit.load) ** 2 - (fit.stiffness * depth) ** 2, 0))
    load = max(load, left) if given.load_uN is None else 1e-3 * given.load_uN
    depth = depth if given.depth_nm is None else 1e-3 * given.depth_nm
    seen = int(np.argmax(cycles.without_spikes(curve.load) > SEEN * load))
    zero = max(curve.depth[seen], 0) / math.sqrt(3) if curve.zero_error is None else curve.zero_error
    default = Inputs(0.0 if is_run else 1e3 * zero, 0.0 if is_run else FRAME, 0.0 if is_run else AREA,
                     0.0 if is_run else POISSON, 1e3 * depth, 1e3 * load)
    return Inputs(*(own if value is None else value for own, value in zip(default, given)))


def checked_inputs(**given):
    """Returns the Inputs that a caller gives by name."""
    for name in given:
        if name not in RULES:
            raise Error(f"{name}: must be one of {', '.join(RULES)}")
    return Inputs(**{name: checks.number(name, value, RULES[name]) for name, value in given.items() if value is not None})


# ---- draws ----

def noisy_starts(curve, fit, inputs, random, count):
    """Returns depths (um), loads (mN) and stiffnesses (mN/um) at the start of the unloading [count], drawn from the noise of each row."""
    depth, load = 1e-3 * inputs.depth_nm, 1e-3 * inputs.load_uN
    hold = cycle_of(curve, fit).hold
    rows = hold.stop - hold.start
    tops, loads = (value + noise / math.sqrt(rows) * random.normal(size=count) for value, noise in ((fit.depth, depth), (fit.load, load)))
    slope, deviation = noise_of_stiffness(curve.depth[fit.rows] - fit.depth, fit, depth, load)
    return tops, loads, fit.stiffness + slope * (tops - fit.depth) + deviation * random.normal(size=count)


def noise_of_stiffness(depth, fit, of_depth, of_load):
    """Returns dS/dh (mN/um^2) of an Unloading's law at its start, and the standard deviation of S (mN/um) by the noise of the fitted rows.

    depth [rows]: of these rows from the start (um, below zero); of_depth (um), of_load (mN): noise of each. The fit of
    P = P1 u^m, u = 1 + S d/(m P1), is linear in the noise as far as this is small: its normal equations give dS = g (dP - P'(h) dh). m counts as free where it is at its
    limit, as another noise would free it.
    """
    exponent, stiffness = fit.exponent, fit.stiffness
    load = stiffness * (fit.depth - fit.final_depth) / exponent  # P1
    u = np.maximum(1 + stiffness * depth / (exponent * load), 1e-9)
    by = np.column_stack([u**exponent - stiffness * depth / load * u ** (exponent - 1), depth * u ** (exponent - 1),
                          load * u**exponent * np.log(u) - stiffness * depth / exponent * u ** (exponent - 1)])  # of P1, S and m
    free = np.eye(3)
    if fit.raised > 0:  # hf is held at zero, S = m P1/h
        free = np.array([[1, exponent / fit.depth, 0], [0, 0, 0], [0, load / fit.depth, 1]]).T
    weights = (free @ np.linalg.pinv(by @ free))[1]
    deviation = np.linalg.norm(weights * np.hypot(of_load, stiffness * u ** (exponent - 1) * of_depth))
    return stiffness**2 * (exponent - 1) / (exponent * load), float(deviation)


def cycle_of(curve, fit):
    """Returns the Cycle of an Unloading."""
    return next(cycle for cycle in cycles.find_cycles(curve) if cycle.start <= fit.rows.start <= cycle.end)


def windows_fits(curve, fit, window):
    """Returns the stiffnesses (mN/um) and exponents [fits][2] of fits in windows around the one that was chosen, those that have enough rows."""
    found, cycle = [], cycle_of(curve, fit)
    for low in np.clip(np.linspace(-WINDOW[0], WINDOW[0], GRID) + window[0], 0, 1):
        for high in np.clip(np.linspace(-WINDOW[1], WINDOW[1], GRID) + window[1], 0, 1):
            try:
                own = oliver_pharr.fit_unloading(curve, cycle, (low, high))
                found.append((own.stiffness, own.exponent))
            except ResultError:
                pass
    return np.array(found or [(fit.stiffness, fit.exponent)])


def figures(curve, constants, depth, load, stiffness, exponent, zero, compliance, area, poisson):
    """Returns the QUANTITIES [draws] by Oliver and Pharr: a contact point zero (um) deeper, a compliance (um/mN) more in series, an area
    by a share larger."""
    stiffness = 1 / oliver_pharr.above_zero(1 / stiffness - compliance)
    depth = depth - zero - compliance * load
    epsilon, beta = oliver_pharr.epsilon_and_beta(curve.tip, exponent, depth, load / stiffness, poisson, constants)
    tip = curve.tip._replace(area=lambda h: curve.tip.area(h) * (1 + area))
    *_, hardness, modulus = oliver_pharr.contact(tip, depth, load, stiffness, epsilon, beta)
    return np.array(np.broadcast_arrays(hardness, modulus, oliver_pharr.specimen_modulus(modulus, poisson, constants)))


# ---- cells ----

def errors_of_cells(row, other=None):
    """Returns the largest shares by which the cells may change the QUANTITIES of a run's dict of results, and words; with the dict of the
    same run on other cells by their difference, whose part falls off with the cells' size to the power ORDER."""
    if other is None:
        known = row["expected_error"]
        return (None, "") if not known else (np.full(len(QUANTITIES), known["hardness_GPa"]), f"{row['cells']:.3g} cells: the expected errors")
    own, others = row["cells"], other["cells"]
    if not (own > 0 and others > 0):
        raise Error("the run on other cells: both must be runs whose cells in the contact are known")
    if not max(own, others) >= LEAST_RATIO * min(own, others):
        raise Error(f"the run on other cells: must have {LEAST_RATIO} times as many cells in the contact, or as few; there are {others:.3g} and {own:.3g}")
    if abs(other["depth_um"] / row["depth_um"] - 1) > ANOTHER:
        raise Error(f"the run on other cells: must be of the same test; it is {other['depth_um']:.4g} um deep, not {row['depth_um']:.4g} um")
    part = own**-ORDER / abs(own**-ORDER - others**-ORDER)
    return np.array([abs(other[name] / row[name] - 1) * part for name in QUANTITIES]), f"{own:.3g} cells, against {others:.3g}"


def share_of_block(row):
    """Returns by which shares the size of a run's block makes the QUANTITIES too large, at most; None where that is not known."""
    known = row.get("expected_error")
    return None if not known else np.array([known[name] - known["hardness_GPa"] for name in QUANTITIES])


def left_out(curve, row):
    """Yields sentences about what the intervals of an unloading do not include."""
    if curve.cells is None:
        yield "pile-up or sink-in of the specimen, which change the area; an unloading does not show them"
        return
    if not row.get("expected_error"):
        yield "the cells and the size of the block, since it is not known how many cells the contact has"
    ratio = row["true_area_um2"] / row["area_um2"]
    if math.isfinite(ratio):
        figures = [f"{name} {row[f'true_{name}_GPa']:.4g} GPa" for name in ("hardness", "modulus") if math.isfinite(row[f"true_{name}_GPa"])]
        yield (f"{'pile-up' if ratio > 1 else 'sink-in'}: the true contact area of this run is {ratio:.3g} of that by Oliver and Pharr; with it "
               f"{' and '.join(figures)}" + ", which still has the block's share" * (len(figures) > 1))


# ---- all together ----

def uncertainty(curve, row, fit, constants=oliver_pharr.Constants(), inputs=Inputs(), draws=1000, seed=1, other=None):
    """Returns the Uncertainty of an unloading of a Curve, its dict of results and its Unloading of oliver_pharr.analysed().

    inputs: standard uncertainties. other: of a run, the dict of results of the same run on other cells. Draws are normal, but for the
    window, the cells and the block, which are even between limits. The same seed gives the same numbers.
    """
    constants = oliver_pharr.constants_of(curve, constants)
    if curve.tip is None or not math.isfinite(row["hardness_GPa"]):
        raise Error(f"{curve.name}: there is no hardness by Oliver and Pharr of which an uncertainty is known")
    count = checks.whole("draws", draws)
    if not DRAWS.good(count):
        raise checks.refusal("draws", draws, DRAWS.allowed)
    given_zero = inputs.zero_nm
    inputs, random = standard(curve, fit, inputs), np.random.default_rng(seed)
    poisson = curve.poisson if constants.poisson is None else constants.poisson
    nominal = {"depth": fit.depth, "load": fit.load, "stiffness": fit.stiffness, "exponent": fit.exponent, "zero": 0.0, "compliance": 0.0, "area": 0.0, "poisson": poisson}
    in_windows = windows_fits(curve, fit, constants.window)
    depth, load, noisy = noisy_starts(curve, fit, inputs, random, count)
    stiffnesses, exponents = random.choice(in_windows, count).T
    given_by = ", of the zero that was found" if curve.zero_error is not None and given_zero is None else ""
    sources = [
        ("noise", f"{inputs.depth_nm:.3g} nm, {inputs.load_uN:.3g} uN of each row", {"depth": depth, "load": load, "stiffness": noisy}),
        ("window", f"{WINDOW[0]:g} and {WINDOW[1]:g} about {constants.window[0]:g},{constants.window[1]:g}", {"stiffness": stiffnesses, "exponent": exponents}),
        ("contact point", f"{inputs.zero_nm:.3g} nm{given_by} (--u-zero)", {"zero": 1e-3 * inputs.zero_nm * random.normal(size=count)}),
        ("compliance", f"{inputs.compliance_nm_per_mN:.3g} nm/mN", {"compliance": 1e-3 * inputs.compliance_nm_per_mN * random.normal(size=count)}),
        ("area", f"{inputs.area_percent:.3g} %", {"area": 0.01 * inputs.area_percent * random.normal(size=count)})]
    if poisson is not None:
        sources.append(("Poisson's ratio", f"{inputs.poisson:.3g}", {"poisson": np.clip(poisson + inputs.poisson * random.normal(size=count), -0.99, 0.5)}))
    found = [(source, words, figures(curve, constants, **{**nominal, **drawn})) for source, words, drawn in sources]
    drawn = {name: values for *_, own in sources for name, values in own.items()} | {"stiffness": noisy * stiffnesses / fit.stiffness}
    total = figures(curve, constants, **{**nominal, **drawn})
    values = np.array([row[name] for name in QUANTITIES])
    error, words = errors_of_cells(row, other)
    if error is not None:
        factors = 1 + error[:, None] * random.uniform(-1, 1, (len(QUANTITIES), count))
        found.append(("cells", words, values[:, None] * factors))
        total = total * factors
    block = share_of_block(row)
    if block is not None:
        factors = 1 - block[:, None] * random.uniform(0, 1, count)
        found.append(("block", f"its size makes moduli too large by up to {100 * block[-1]:.2g} %", values[:, None] * factors))
        total = total * factors
    return collected(values, found, total, count)._replace(left_out=list(left_out(curve, row)))


def collected(values, found, total, count):
    """Returns the Uncertainty of values [3], by sources (name, input, draws [3][count] or [3]), and of all together [3][count]."""
    def named(numbers):
        return dict(zip(QUANTITIES, map(float, numbers)))

    def deviations(draws):
        return named(np.std(draws, axis=1) if np.ndim(draws) == 2 else np.zeros(len(values)))
    good = total[:, np.isfinite(total[0])]
    if good.shape[1] < 0.95 * count:
        raise Error("the uncertainties are so large that in some draws there is no contact: make them smaller")
    lower, upper = np.percentile(good, (2.5, 97.5), axis=1)
    return Uncertainty(named(values), [Share(source, words, deviations(draws)) for source, words, draws in found], deviations(good),
                       named(lower), named(upper), count)


# ---- what is printed and written ----

def lines_of(found):
    """Yields the lines of a table of an Uncertainty: standard deviations by source in per cent, and the intervals."""
    known = [name for name in QUANTITIES if math.isfinite(found.values[name])]
    labels = [f"u({dict(zip(QUANTITIES, ('H', 'Er', 'E')))[name]})" for name in known]
    yield f"  {'source':18s}" + "".join(f"{label:>10s}" for label in labels) + "   input"
    for share in [*found.shares, Share("total", f"{found.draws} draws", found.deviation)]:
        yield f"  {share.source:18s}" + "".join(f"{100 * share.deviation[name] / found.values[name]:8.2f} %" for name in known) + f"   {share.input}"
    yield from (f"  not included: {sentence}" for sentence in found.left_out)
    for name in known:
        yield f"  {name.rpartition('_')[0].replace('_', ' ')}: {found.values[name]:.5g} GPa, 95 % of the draws {found.lower[name]:.5g} to {found.upper[name]:.5g}"


def write(path, tables):
    """Writes uncertainty.csv from {name of a curve: Uncertainty}: a row for each source and one for all together, in GPa."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        heads = [f"{part}_{name}" for name in QUANTITIES for part in ("value", "u", "lower", "upper")]
        writer.writerow(["curve", "source", "input", *heads])
        for curve, found in tables.items():
            for share in [*found.shares, Share("total", f"{found.draws} draws", found.deviation)]:
                numbers = [[found.values[name], share.deviation[name]] + ([found.lower[name], found.upper[name]] if share.source == "total" else [math.nan] * 2)
                           for name in QUANTITIES]
                writer.writerow([curve, share.source, share.input, *("" if math.isnan(value) else f"{value:.6g}" for part in numbers for value in part)])
