"""Holds of a load-depth curve at its largest load or depth: where they are, creep, relaxation, and what creep does to the stiffness."""

from collections import namedtuple

import numpy as np

from . import cycles
from .errors import ResultError

Hold = namedtuple("Hold", "kind begin end")
Hold.__doc__ = """Rows of a hold, the first and the last, and what is constant: "load" or "depth"."""

LEAST_ROWS = 5  # of what a line is fitted to
LEAST_HELD = cycles.SPIKE + 1  # rows of a hold: running medians make up to SPIKE rows of a sharp turn flat
NEAR = 0.9  # of the largest load or depth, from which on a plateau is that of the test: tips overshoot, and rest at a tenth for drift
BANDS = 1e-3, 0.01  # of the largest value, or CLEAR times the noise: within the first of them that does a plateau is constant
TIGHT = 1e-3  # the same for where the plateau begins and ends
CLEAR = 3  # times the noise
STEEP = 1.4  # times the stay within the band a turn without a hold stays within four: 1.7 a smooth one, 2.5 a sharp one, 1 a long hold
LINE = 0.97  # of the level: from NEAR to it the ramp is a line, which meets the plateau where the hold begins
FOLLOWS = 4  # times its creep a load that is held may drift
ONSET = 0.7, 0.97  # of the load that is held: where an unloading has the slope and the rate of its start. From 0.5 on a flow as the
# cube of the load, which makes it 30 % too steep, leaves 3 %, from 0.7 on 1.5 %, from 0.8 on 0.9 % and twice the noise


def clock(curve):
    """Returns the time of the test (s) of a Curve's rows; None where it has none that rises. Of a run it is not that of the program."""
    time = curve.time if curve.cells is None else curve.test_time
    return time if time is not None and np.all(np.diff(time) >= 0) and time[-1] > time[0] else None


def find_hold(curve, cycle):
    """Returns the Hold of a cycle before its unloading, or None.

    A plateau of the load, or of the depth, is where the curve stays longest within a band, at the level of the largest values at
    least; four times the band must not add much to that time, or it is a turn. Where both stay, as in a load hold in which a metal
    creeps little, the depth is held if the load changes more than creep could need, since P ~ h^2 and less.
    """
    time = clock(curve)
    if time is None:
        return None
    unloaded = slice(cycle.begin, cycle.end + 1)
    pressed = slice(cycle.begin, cycle.start + 1)
    plateaus = {"load": plateau(time[unloaded], curve.load[unloaded]), "depth": plateau(time[pressed], curve.depth[pressed])}
    found = {kind: Hold(kind, *(cycle.begin + row for row in rows)) for kind, rows in plateaus.items() if rows}
    if len(found) == 2:
        creep, drift = (trend(values, found["load"]) for values in (curve.depth, curve.load))
        return found["depth" if drift > FOLLOWS * creep else "load"]
    return next(iter(found.values()), None)


def largest_hold(curve):
    """Returns the Hold at the largest load of a Curve, which may end in it, and the row where its loading begins; raises a ResultError
    where there is none."""
    if clock(curve) is None:
        raise ResultError(curve.name, "has no time of the test: a measured curve needs a column of times, a run -test_times")
    try:
        found = cycles.find_cycles(curve)
    except ResultError:
        found = []
    first, last = found[-1].end if found else 0, len(curve.load) - 1
    if curve.load[first:].max() >= NEAR * curve.load.max():  # the test ends in a hold
        found = [*found, cycles.Cycle(first, last, last, slice(last, last + 1))]
    held = [(hold, cycle.begin) for cycle in found if (hold := find_hold(curve, cycle))]
    if not held:
        raise ResultError(curve.name, "has no hold: neither load nor depth stays within 1 % of its largest value for a twentieth of the ramps")
    return max(held, key=lambda each: curve.load[each[0].begin])


def plateau(time, values):
    """Returns the first and the last row of the plateau at the largest values [rows], or None; time in s, not falling."""
    smooth = cycles.without_spikes(values)
    top = smooth.max()
    if not top > 0 or len(values) < LEAST_HELD:
        return None
    least = CLEAR * cycles.noise(values)
    if np.median(np.abs(np.diff(values, 3))) == 0:  # exact: the noise is the least step, of rounding, or of a ramp with few rows
        least = min(least, TIGHT * top)
    bands = dict.fromkeys(max(share * top, least) for share in BANDS)
    return next(filter(None, (plateau_within(time, smooth, top, band, max(TIGHT * top, least)) for band in bands)), None)


def plateau_within(time, values, top, band, tight):
    """Returns the rows of plateau() with a band, half its width, and the same for its ends."""
    stay = stays(time)
    level = busiest(values, stay, top, band)
    inside, near = np.flatnonzero(np.abs(values - level) <= band), np.flatnonzero(values >= level - 4 * band)
    if len(inside) < LEAST_HELD or values[inside[-1]:].max() > level + 2 * band:
        return None
    if stay[near].sum() > STEEP * stay[inside].sum():
        return None
    begin, end = trimmed(time, values, inside, near, tight)
    return (begin, end) if end - begin + 1 >= LEAST_HELD and time[end] > time[begin] else None


def stays(time):
    """Returns how long (s) the curve is nearest to each of its rows, [rows]."""
    middles = np.concatenate([time[:1], (time[1:] + time[:-1]) / 2, time[-1:]])
    return np.diff(middles)


def busiest(values, stay, top, band):
    """Returns the level from NEAR of the top on from which the values differ by at most a band for the longest time."""
    order = np.argsort(values, kind="stable")
    order = order[values[order] >= NEAR * top]
    ranked, total = values[order], np.append(0, np.cumsum(stay[order]))
    lower, upper = np.searchsorted(ranked, ranked - band), np.searchsorted(ranked, ranked + band, "right")
    best = int(np.argmax(total[upper] - total[lower]))
    inside = order[lower[best]:upper[best]]
    return middle_of(values[inside], stay[inside])


def middle_of(values, stay):
    """Returns the median of values [rows] in which the curve stays for times [rows]."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(stay[order])
    return float(values[order][min(int(np.searchsorted(total, total[-1] / 2)), len(values) - 1)])


def trimmed(time, values, inside, near, tight):
    """Returns the rows where a plateau begins and ends: ramps meet its level there. inside and near: rows within once and four times
    its band."""
    rows, stay, quarter = np.arange(near[0], near[-1] + 1), stays(time), (time[inside[-1]] - time[inside[0]]) / 4
    early, late = inside[time[inside] <= time[inside[0]] + quarter], inside[time[inside] >= time[inside[-1]] - quarter]
    level, level_at_end = (middle_of(values[part], stay[part]) for part in (early, late))
    begin = rows[np.argmax(values[rows] >= level - tight)]
    end = rows[len(rows) - 1 - np.argmax(values[rows[::-1]] >= level_at_end - tight)]
    met = meeting(time, values, slice(0, inside[0] + 1), level)
    left = meeting(time, values, slice(inside[-1], None), level_at_end)
    return max(begin, nearest(time, met, begin, end)), min(end, nearest(time, left, end, begin))


def meeting(time, values, rows, level):
    """Returns the time (s) at which a line through values from NEAR to LINE of a level meets it, of a slice of rows; None without a line."""
    ramp = np.arange(len(values))[rows]
    ramp = ramp[(values[ramp] >= NEAR * level) & (values[ramp] <= LINE * level)]
    if len(ramp) < LEAST_ROWS or not np.ptp(time[ramp]) > 0:
        return None
    slope, value = np.polyfit(time[ramp] - time[ramp[0]], values[ramp], 1)
    return time[ramp[0]] + (level - value) / slope if slope else None


def nearest(time, wanted, row, other):
    """Returns the row nearest to a time (s) between two rows, the first of which is for no time."""
    if wanted is None:
        return int(row)
    between = np.arange(min(row, other), max(row, other) + 1)
    return int(between[np.argmin(np.abs(time[between] - wanted))])


# ---- figures ----

def change(curve, hold):
    """Returns by what share of itself the depth changes in a Hold of the load, or the load in one of the depth, from begin to end.

    At the end it is that of parabola_at_end(). At the begin a depth that goes on growing is a running median, but a load
    has its peak there, of which that would take some off: it is that of the row.
    """
    is_load = hold.kind == "load"
    values = curve.depth if is_load else curve.load
    first = cycles.without_spikes(values)[hold.begin] if is_load else values[hold.begin]
    return float(parabola_at_end(clock(curve), values, hold)[2] / first - 1)


def trend(values, hold):
    """Returns the size of the change, as a share, from the first third of a Hold's rows to the last, by means."""
    third = max((hold.end - hold.begin + 1) // 3, 1)
    first, last = np.mean(values[hold.begin:hold.begin + third]), np.mean(values[hold.end + 1 - third:hold.end + 1])
    return float(abs(last / first - 1))


def creep_rate(curve, hold):
    """Returns dh/dt (um/s) at the end of a Hold: that of the parabola of the second half of its time."""
    return float(parabola_at_end(clock(curve), curve.depth, hold)[1])


def parabola_at_end(time, values, hold):
    """Returns the coefficients of the parabola of a column [rows] through the second half of a Hold's time: half the second derivative
    (1/s^2), the rate (1/s) and the value at its end."""
    half = (time[hold.begin] + time[hold.end]) / 2
    rows = np.arange(hold.begin, hold.end + 1)
    later = rows[time[rows] >= half] if np.sum(time[rows] >= half) >= LEAST_ROWS else rows
    scale = time[hold.end] - time[later[0]]
    return np.polyfit((time[later] - time[hold.end]) / scale, values[later], 2) / scale ** np.array([2, 1, 0])


def rows_of_onset(curve, cycle, hold):
    """Returns the rows [rows] of the unloading after a Hold whose loads are within ONSET of it."""
    load = cycles.without_spikes(curve.load)
    rows = np.arange(hold.end, cycle.end + 1)
    share = load[rows] / np.mean(curve.load[hold.begin:hold.end + 1])
    below = np.flatnonzero(share < ONSET[0])
    upper = slice(0, below[0] if len(below) else len(rows))
    return rows[upper][share[upper] <= ONSET[1]]


def unloading_rate(curve, rows):
    """Returns dP/dt (mN/s, below zero) of a line through the rows of the onset; NaN where they are too few."""
    time = clock(curve)[rows]
    if len(rows) < LEAST_ROWS or time[-1] <= time[0]:
        return float("nan")
    return float(np.polyfit(time - time[0], curve.load[rows], 1)[0])


def onset_compliance(curve, hold, rows):
    """Returns dh/dP (um/mN) where the unloading after a Hold begins, of a parabola of the depth over the load through the rows of the
    onset: below zero where there is a nose, which no power law has. NaN where the rows are too few."""
    top = np.mean(curve.load[hold.begin:hold.end + 1])
    return float(np.polyfit(curve.load[rows] / top - 1, curve.depth[rows], 2)[1] / top) if len(rows) >= LEAST_ROWS else float("nan")


def corrected_stiffness(compliance, creep, unloading):
    """Returns S_e (mN/um) of 1/S_e = 1/S + (dh/dt)/|dP/dt|: the stiffness without the creep that goes on while the load falls.

    compliance 1/S (um/mN) and unloading (mN/s) at the start of the unloading, creep (um/s) at the end of the hold. Feng and Ngan,
    J. Mater. Res. 17 (2002) 660; Tang and Ngan, J. Mater. Res. 18 (2003) 1141. Creep makes an unloading too steep, or a nose of it.
    """
    elastic = compliance + creep / abs(unloading)
    return 1 / elastic if elastic > 0 else float("nan")
