"""The zeros of a measured curve: the load of the free tip, and the depth at which the tip touches; given, or found in the curve."""

import math

import numpy as np
from scipy.optimize import curve_fit

from . import checks, cycles
from .checks import Rule
from .errors import ResultError

AUTO = "auto"
NUMBER = Rule(math.isfinite, f"a number, or {AUTO}")
CLEAR = 5, 0.01  # times the noise of the load, and of its largest change: by both a tip is in contact, also where the noise is slow
FLAT = 0.25  # of that: what the load may rise before the contact; under load from the first row on it rises by half of it
LEAST_ROWS = 10  # of the approach, and of the part of the loading that is fitted
FITTED = 0.02, 0.5  # of the load at the end of the first loading: above what the surface's roughness and the tip's end do to it
EXPONENTS = 1.0, 2.5  # of a loading: a punch has 1, a ball 1.5, a cone 2


def checked(name, value, factor):
    """Returns a zero that a caller gives as a number, times a factor, or AUTO as it is."""
    return AUTO if isinstance(value, str) and value == AUTO else checks.number(name, value, NUMBER) * factor


def without_zeros(curve, depth, load):
    """Returns a Curve whose depths (um) and loads (mN) count from these zeros, each a number or AUTO, with notes on what was found."""
    notes = list(curve.notes)
    if load == AUTO:
        load = load_of_free_tip(curve)
        notes.append(f"the zero of loads is {load:.4g} mN, the median of the rows before the tip touches")
    curve = curve._replace(load=curve.load - load)
    if depth == AUTO:
        depth, exponent = depth_of_contact(curve)
        notes.append(f"the zero of depths is {depth:.4g} um, where the power law of the first loading begins (exponent {exponent:.2f})")
    return curve._replace(depth=curve.depth - depth, notes=notes)


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


def depth_of_contact(curve):
    """Returns h0 (um) and m of P = C (h - h0)^m, by least squares over the rows of the first loading between the shares FITTED of the
    load at its end."""
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
        (start, _, exponent), _ = curve_fit(law, (depth[rows] - first) / travel, share[rows], (0.0, 1.0, 1.5), bounds=limits)
    except RuntimeError:
        raise ResultError(curve.name, "no zero of depths can be found: the first loading is no power law; give it") from None
    return float(first + start * travel), float(exponent)


def end_of_first_loading(curve):
    """Returns the row at which the first unloading begins; without one that of the largest load."""
    try:
        return cycles.find_cycles(curve)[0].start
    except ResultError:
        return int(np.argmax(cycles.without_spikes(curve.load)))
