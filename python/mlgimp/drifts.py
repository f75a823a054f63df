"""Thermal drift of a measured curve, from a hold of the load at about a tenth of the largest in the last unloading, or before the loading."""

import math
from collections import namedtuple

import numpy as np

from . import cycles
from .errors import ResultError

LEVELS = 0.02, 0.5  # of the largest load: where the hold for drift is, at a tenth by custom; above the tip creeps, below it lets go
EARLY = 0.002, 0.3  # the same of a hold before the loading, which carries a preload
BAND = 0.005, 4  # of the largest load, and times the noise of the load: half the width of what a controller leaves of a hold
LEAST_ROWS = 10
STAYS = 10  # times as long as a ramp takes through the band: a hold, and no turn
STEADY = 0.5  # of the band: more the load must not change in a hold; a ramp that is slow there changes it by twice the band
SETTLED = 0.8  # of the hold's rows, the last: before that the controller and the specimen, which both follow the change of load, settle

Drift = namedtuple("Drift", "rate error rows level where")
Drift.__doc__ = """The drift of the depth (nm/s) with its standard error, the slice of rows of the hold that the line goes through, the load
there (mN), and whether that is "in the unloading" or "before the loading"."""


def described(drift):
    """Returns words for a Drift."""
    count = drift.rows.stop - drift.rows.start
    return f"drift of {drift.rate:.3g} +- {drift.error:.2g} nm/s, of a hold at {drift.level:.3g} mN {drift.where} ({count} rows),"


def no_time(curve):
    return ResultError(curve.name, "a drift needs a column of times (--time COLUMN:UNIT)")


def drift_of(curve):
    """Returns the Drift of a Curve; raises a ResultError where it has no time or no hold for it."""
    if curve.time is None:
        raise no_time(curve)
    found = find(curve)
    if found is None:
        raise ResultError(curve.name, f"no drift can be found: there is no hold of the load between {LEVELS[0]:g} and {LEVELS[1]:g} of the largest in the "
                                      "last unloading, and none before the loading; give the drift in nm/s")
    return found


def find(curve):
    """Returns the Drift of the hold in the last unloading of a Curve, else of that before the loading; None without a time or such a hold."""
    if curve.time is None or len(curve.load) < 2 * LEAST_ROWS or not curve.load.max() > 0:
        return None
    try:
        found = cycles.find_cycles(curve)
    except ResultError:
        return None
    top = curve.load.max()
    loading = int(np.argmax(cycles.without_spikes(curve.load) > EARLY[1] * top))
    parts = ((slice(found[-1].start, len(curve.load)), LEVELS, "in the unloading"), (slice(0, loading), EARLY, "before the loading"))
    return next(filter(None, (of_hold(curve, hold_in(curve, rows, levels, top), where) for rows, levels, where in parts)), None)


def hold_in(curve, rows, levels, top):
    """Returns the slice of the longest hold of the load in a slice of rows, at a level between shares of the largest load; None without one."""
    time, load = curve.time[rows], cycles.without_spikes(curve.load)[rows]
    band = max(BAND[0] * top, BAND[1] * cycles.noise(curve.load))
    inside = (load > levels[0] * top) & (load < levels[1] * top)
    if inside.sum() < LEAST_ROWS:
        return None
    stay = np.gradient(time)
    order = np.flatnonzero(inside)[np.argsort(load[inside], kind="stable")]
    total = np.append(0, np.cumsum(stay[order]))
    last = np.searchsorted(load[order], load[order] + 2 * band, "right")
    first = int(np.argmax(total[last] - total[:-1]))  # from this load on the band holds the curve for the longest time
    near = np.flatnonzero(np.abs(load - np.median(load[order[first:last[first]]])) <= band)
    run = max(np.split(near, np.flatnonzero(np.diff(near) > 1) + 1), key=len)  # of rows that follow each other
    return slice(rows.start + int(run[0]), rows.start + int(run[-1]) + 1) if is_hold(time, load, run, band) else None


def is_hold(time, load, run, band):
    """Whether a load (mN) [rows] rests in a run of rows: it has no trend there, and stays in the band for STAYS times as long as it would take
    through it at the mean rate of the other rows, which a turn does not."""
    if len(run) < LEAST_ROWS:
        return False
    duration = time[run[-1]] - time[run[0]]
    trend = np.polyfit(time[run] - time[run[0]], load[run], 1)[0] * duration if duration > 0 else math.inf
    passing = 2 * band * (time[-1] - time[0] - duration) / np.ptp(load)
    return abs(trend) < STEADY * band and duration > STAYS * passing


def of_hold(curve, hold, where):
    """Returns the Drift of the line through the last rows of a hold; None without one.

    The standard error is that of least squares, times the root of (1 + r)/(1 - r) with the correlation r of neighbouring residuals:
    of n rows that follow each other like that only n (1 - r)/(1 + r) are independent.
    """
    if hold is None:
        return None
    rows = slice(hold.stop - max(int(SETTLED * (hold.stop - hold.start)), LEAST_ROWS // 2), hold.stop)
    time, depth = curve.time[rows] - curve.time[rows].mean(), 1e3 * curve.depth[rows]
    spread = float(time @ time)
    if not spread > 0:
        return None
    rate = float(time @ (depth - depth.mean()) / spread)
    rest = depth - depth.mean() - rate * time
    squares = float(rest @ rest)
    alike = min(max(float(rest[1:] @ rest[:-1]) / squares, 0.0), 0.99) if squares > 0 else 0.0
    error = math.sqrt(squares / max(len(time) - 2, 1) / spread * (1 + alike) / (1 - alike))
    return Drift(rate, error, rows, float(np.mean(curve.load[rows])), where)
