"""The zeros of a measured curve: the load of the free tip, and the depth at which the tip touches; given, or found in the curve.

The depth is found by one of three rules: where the load leaves its noise (ISO 14577-1 takes the first increase of the force), where the
power law of the first loading begins, or where the stiffness dP/dh leaves its noise.
"""

import math
from collections import namedtuple

import numpy as np
from scipy.optimize import curve_fit

from . import checks, cycles
from .checks import Rule
from .errors import ResultError

AUTO = "auto"
CLEAR = 5, 0.01  # times the noise of the load, and of its largest change: by both a tip is in contact, also where the noise is slow
FLAT = 0.25  # of that: what the load may rise before the contact; under load from the first row on it rises by half of it
LEAST_ROWS = 10  # of the approach, and of the part of the loading that is fitted
FITTED = 0.02, 0.5  # of the load at the end of the first loading: above what the surface's roughness and the tip's end do to it
SURE = 5  # standard deviations by which load or stiffness leave the noise: one row in a million does so by chance
EXACT = 1e-4  # of the largest load: what counts as a contact where there is no noise, as in ISO 14577-1
STILL = 0.35  # of SURE times the noise: the same of the rows before the depth's threshold, of which some are under a load below it
WINDOWS = 20  # parts of the rows before the largest load: in the first the tip is free
PARTS = 4  # of the rows before the contact: so wide are windows for the stiffness, which begin a quarter of that apart
EXPONENTS = 1.0, 2.5  # of a loading: a punch has 1, a ball 1.5, a cone 2

Zero = namedtuple("Zero", "depth error how")
Zero.__doc__ = "The depth of the surface (um), how far it may be off (um), and words for the rule."


def checked(name, value, factor):
    """Returns a zero that a caller gives as a number, times a factor, or the name of how it is found, as it is."""
    rules = (AUTO,) if name == "zero_load" else tuple(RULES)
    if isinstance(value, str) and value in rules:
        return value
    return checks.number(name, value, Rule(math.isfinite, "a number, or " + ", ".join(rules))) * factor


def without_zero_load(curve, load):
    """Returns a Curve whose loads count from a zero (mN), a number or AUTO, with a note on what was found."""
    if load != AUTO:
        return curve._replace(load=curve.load - load)
    load = load_of_free_tip(curve)
    return curve._replace(load=curve.load - load, notes=[*curve.notes, f"the zero of loads is {load:.4g} mN, the median of the rows before the tip touches"])


def without_zero_depth(curve, depth):
    """Returns a Curve whose depths count from a zero (um), a number or the name of a rule, with a note on what was found."""
    if not isinstance(depth, str):
        return curve._replace(depth=curve.depth - depth)
    found = RULES[depth](curve)
    note = f"the zero of depths is {found.depth:.4g} um +- {found.error:.2g} um, {found.how}"
    error = found.error if RULES[depth] is by_power else found.error / math.sqrt(3)  # a standard error, or even within limits
    return curve._replace(depth=curve.depth - found.depth, notes=[*curve.notes, note], zero_error=error)


def load_of_free_tip(curve):
    """Returns the median load (mN) of the rows before the load rises above it by CLEAR for the first time."""
    load, free = cycles.without_spikes(curve.load), 0
    first = LEAST_ROWS
    while first > free:  # the median is that of more and more rows
        free = first
        level = np.median(curve.load[:free])
        clear = max(CLEAR[0] * cycles.noise(curve.load), CLEAR[1] * (load.max() - level))
        first = int(np.argmax(load > level + clear))
    early, late = (np.median(half) for half in np.array_split(curve.load[:free], 2))
    if first < LEAST_ROWS or late - early > FLAT * clear:
        raise ResultError(curve.name, f"no zero of loads can be found: there are no {LEAST_ROWS} rows before the contact in which the load rests; give it")
    return float(level)


def by_power(curve):
    """Returns the Zero where the power law of the first loading begins."""
    depth, error, exponent = depth_of_contact(curve)
    return Zero(depth, error, f"where the power law of the first loading begins (exponent {exponent:.2f})")


def by_threshold(curve):
    """Returns the Zero where the load leaves that of the free tip for good, by SURE times its noise.

    The tip has touched before that, under a cone, P ~ h^2, by what it travels until the load is four times as far away, else by less: by
    that the depth is too large at most, and by the step of a row.
    """
    first, clear = first_row_under_load(curve, "threshold", 1)
    later, _ = first_row_under_load(curve, "threshold", 4)
    return Zero(float(curve.depth[first]), float(abs(curve.depth[later] - curve.depth[first]) + abs(curve.depth[first] - curve.depth[first - 1])),
                f"where the load leaves that of the free tip by {clear:.2g} mN")


def by_stiffness(curve):
    """Returns the Zero where the stiffness dP/dh, of lines through windows of rows, leaves that of the free tip by SURE times its noise: the
    middle of the first window from which on it stays above. It may be off by half of what that window is wide, and by what the tip travels
    until the stiffness is twice as far away, as under a cone, whose stiffness grows with the depth."""
    first, _ = first_row_under_load(curve, "stiffness", 1)
    width = max(first // PARTS, LEAST_ROWS // 2)
    top = int(np.argmax(cycles.without_spikes(curve.load)))
    starts = np.arange(0, max(top - width, 1), max(width // PARTS, 1))
    slopes = np.array([slope_of(curve.depth[row:row + width], curve.load[row:row + width]) for row in starts])
    free = slopes[starts + width <= first]
    if len(free) < PARTS:
        raise too_few_rows(curve, "stiffness")
    level, clear = np.median(free), SURE * noise_of(free)
    at, later = (starts[min(under[-1] + 1 if len(under) else 0, len(starts) - 1)]
                 for under in (np.flatnonzero(~(slopes > level + times * clear)) for times in (1, 2)))
    depth = curve.depth[at:at + width]
    return Zero(float(np.median(depth)), float(max(np.ptp(depth) / 2, abs(curve.depth[later] - curve.depth[at]))),
                f"where the stiffness dP/dh leaves that of the free tip by {clear:.2g} mN/um")


RULES = {AUTO: by_power, "power": by_power, "threshold": by_threshold, "stiffness": by_stiffness}  # how a depth is found, by its name


def slope_of(depth, load):
    """Returns the slope of the line of a load over a depth, both [rows]; 0 where the depth does not change."""
    off = depth - depth.mean()
    spread = float(off @ off)
    return float(off @ load) / spread if spread > 0 else 0.0


def first_row_under_load(curve, rule, times):
    """Returns the first row from which on the load stays above that of the free tip by so many times SURE times its noise, up to the largest
    load; and how far that is above it (mN)."""
    load = cycles.without_spikes(curve.load)
    top = int(np.argmax(load))
    free = curve.load[:max(top // WINDOWS, LEAST_ROWS)]
    clear = times * max(SURE * noise_of(free), EXACT * (load[top] - np.median(free)))
    under = np.flatnonzero(load[:top + 1] <= np.median(free) + clear)
    first = int(under[-1]) + 1 if len(under) else 0
    early, late = (np.median(half) for half in np.array_split(curve.load[:max(first, 2)], 2))
    if not LEAST_ROWS <= first < len(load) or late - early > STILL * clear:
        raise too_few_rows(curve, rule)
    return first, float(clear)


def too_few_rows(curve, rule):
    return ResultError(curve.name, f"no zero of depths can be found by its {rule}: there are no {LEAST_ROWS} rows of a free tip before the contact; "
                                   "take power, or give it")


def noise_of(values):
    """Returns the standard deviation of values from the median of their distances to their median, which a few others do not change."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def depth_of_contact(curve):
    """Returns h0 (um), its standard error and m of P = C (h - h0)^m, by least squares over the rows of the first loading between the shares
    FITTED of the load at its end."""
    top = end_of_first_loading(curve)
    depth, load = curve.depth[:top + 1], curve.load[:top + 1]
    share = load / load[-1] if load[-1] > 0 else 0 * load
    low, high = (np.flatnonzero(share <= limit) for limit in FITTED)
    rows = slice(low[-1] + 1 if len(low) else 0, high[-1] + 1 if len(high) else 0)
    travel = depth[top] - depth[rows].min(initial=depth[top])
    if rows.stop - rows.start < LEAST_ROWS or not travel > 0:
        raise ResultError(curve.name, f"no zero of depths can be found: {LEAST_ROWS} rows of the first loading must lie between {FITTED[0]:g} "
                                      f"and {FITTED[1]:g} of its load, at rising depths; give it")
    first = depth[rows][0]

    def law(x, start, factor, exponent):
        return factor * np.maximum(x - start, 0) ** exponent
    limits = ((-1.0, 1e-3, EXPONENTS[0]), (1.0, 1e3, EXPONENTS[1]))
    try:
        (start, _, exponent), covariance = curve_fit(law, (depth[rows] - first) / travel, share[rows], (0.0, 1.0, 1.5), bounds=limits)
    except RuntimeError:
        raise ResultError(curve.name, "no zero of depths can be found: the first loading is no power law; give it") from None
    return float(first + start * travel), float(math.sqrt(covariance[0, 0]) * travel), float(exponent)


def end_of_first_loading(curve):
    """Returns the row at which the first unloading begins; without one that of the largest load."""
    try:
        return cycles.find_cycles(curve)[0].start
    except ResultError:
        return int(np.argmax(cycles.without_spikes(curve.load)))
