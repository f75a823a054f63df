"""The unloadings of a load-depth curve: where they begin and end, and what is noise, a blow, a wave of a run or a hold."""

import math
from collections import namedtuple

import numpy as np

from .errors import ResultError

Cycle = namedtuple("Cycle", "begin start end hold")
Cycle.__doc__ = """Rows of a loading and an unloading: the first of all, the first of the unloading, at the largest depth, the last, at the
lowest load, and the slice before the unloading in which the tip is at rest."""

CLEAR = 5  # times the noise from row to row: by more, load and depth fall in an unloading; it is 12 times what running medians leave of it
LEAST_FALL = 0.03  # of the load at its peak: what falls by less has no row in the fitted part, which begins at 0.97
WAVE = 0.2  # of the load at its peak: by less it also falls in a run that rings, as inertia and damping may add a tenth to it
LAGGED = 300  # rows that third differences of a curve need to be less than its noise
SPIKE = 9  # rows: blows, where columns of a run come into contact, are shorter than half of it
UNLOADED = ("a run has one with -indenter_unload_velocity beside -indenter_max_depth, with a last depth of 0 in -indenter_depths, or with a "
            "smaller load at the end of -indenter_loads")


def noise(values):
    """Returns the standard deviation of what changes from row to row, from third differences, which smooth curves do not have.

    Of numbers that follow exactly, as rounded ones in a long hold, it is that of rounding.
    """
    if len(values) < 4:
        return 0.0
    deviation = 1.4826 * np.median(np.abs(np.diff(values, 3))) / math.sqrt(20)
    steps = np.abs(np.diff(values))
    return float(deviation) if deviation > 0 or not steps.any() else float(steps[steps > 0].min() / math.sqrt(12))


def slow_noise(values):
    """Returns the largest noise of all rows, of every second, fourth, ..., while enough of them are left: noise may be slow."""
    lags = [2**k for k in range(max(len(values) // LAGGED, 1).bit_length())]
    return max(noise(values[::lag]) for lag in lags)


def without_spikes(values):
    """Returns running medians over SPIKE rows, fewer in a curve of few."""
    half = min(SPIKE, len(values) // 20) // 2
    return np.median(np.lib.stride_tricks.sliding_window_view(np.pad(values, half, mode="edge"), 2 * half + 1), axis=1)


def find_cycles(curve):
    """Returns the Cycles of a Curve: load and depth both fall by more than their noise, to a lowest load; in a run by more than waves."""
    found = falls(curve, LEAST_FALL if curve.cells is None else WAVE)
    if not found:
        least = "more than its noise" if curve.cells is None else f"{100 * WAVE:.0f} %"
        cure = "" if curve.cells is None else f"; {UNLOADED}"
        raise ResultError(curve.name, f"there is no unloading: the load never falls by {least} while the tip goes back{cure}")
    if curve.load[:found[0].start + 1].min() > 0.5 * curve.load[found[0].start]:
        raise ResultError(curve.name, "there is an unloading without a loading: the curve begins at more than half its load")
    return found


def waves(curve):
    """Returns pairs of loads (mN) between which the load of a run falls while the tip goes back, but by less than in an unloading."""
    if curve.cells is None:
        return []
    load = without_spikes(curve.load)
    pairs = [(float(load[fall.start]), float(load[fall.end])) for fall in falls(curve, LEAST_FALL)]
    return [(above, below) for above, below in pairs if below > (1 - WAVE) * above]


def falls(curve, share):
    """Returns as Cycles all places where load and depth both fall by more than their noise, the load by a share of its peak at least."""
    depth, load = curve.depth, without_spikes(curve.load)
    smooth, quiet, clear = without_spikes(depth), 3 * noise(depth), CLEAR * slow_noise(depth)
    begin, found = 0, []
    for _, valley in peaks_and_valleys(load, CLEAR * slow_noise(curve.load), share):
        highest = depth[begin:valley + 1].max()
        rest = quiet + 1e-6 * abs(highest)
        start = begin + np.flatnonzero(depth[begin:valley + 1] >= highest - rest)[-1]
        far = max(clear, rest)
        if start >= valley or smooth[start] - smooth[valley] <= far:
            continue
        if found and smooth[begin:start + 1].max() - smooth[begin] <= far:  # the tip did not go on: the same unloading
            found[-1] = found[-1]._replace(end=valley if load[valley] < load[begin] else begin)
        else:
            found.append(Cycle(begin, start, valley, rows_at_rest(depth, begin, start, rest)))
        begin = found[-1].end
    return found


def rows_at_rest(depth, begin, start, rest):
    """Returns the last third of the rows up to start, at least one, in which the depth does not change but for noise."""
    moving = np.flatnonzero(np.abs(depth[begin:start + 1] - depth[start]) > 2 * rest)
    first = begin + (moving[-1] + 1 if len(moving) else 0)
    return slice(start - (start - first) // 3, start + 1)


def peaks_and_valleys(load, clear, share):
    """Yields (row of a peak, row of the lowest load after it), where the load (mN) falls by more than `clear` and by a share of the
    peak, and rises again by a third of that, or ends."""
    top = bottom = 0
    falling = False
    for row, value in enumerate(load):
        least = max(clear, share * abs(load[top]))
        if falling and value > load[bottom] + max(clear, least / 3):
            yield top, bottom
            top, falling = row, False
        elif falling:
            bottom = row if value < load[bottom] else bottom
        elif value >= load[top]:
            top = row
        elif value < load[top] - least:
            bottom, falling = row, True
    if falling:
        yield top, bottom
