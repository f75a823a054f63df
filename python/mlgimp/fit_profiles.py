"""What a run is compared with a test by, in a fit: mean loads of parts of the loading and the unloading, and heights of the imprint."""

from collections import namedtuple

import numpy as np

from . import cycles
from .errors import Error

PARTS = 30  # of the loading, and of the unloading
LEAST_DEPTH, LEAST_LOAD = 0.1, 0.2  # of the largest: where the loading begins to count, and where the unloading ends to
LEAST_ROWS = 5  # of the measured loading, and of the unloading
CLEAR = 3  # times the noise: so far from the turn, rows of the loading and of the unloading do not mix
END = 1 / 3  # of a run's unloading: the straight line through it goes on where the run ends before the measurement
FINEST = 1e-3  # of the largest load: how well a mean is known at best, as loads of runs waver by that with the cells

Imprint = namedtuple("Imprint", "radius height")
Imprint.__doc__ = "A profile of an imprint after unloading: radii from the tip's axis and heights over the undeformed surface (um), [rows]."

Parts = namedtuple("Parts", "rows places count")
Parts.__doc__ = "Rows of a curve in parts: their numbers, the part of each of them [rows], and how many rows each part has [parts]; none is empty."

Target = namedtuple("Target", "curve up down imprint values error groups scale per_height")
Target.__doc__ = """A test that runs are compared with: its Curve, the Parts of loading and unloading, its Imprint or None; values [parts], mean
loads (mN) and of an imprint heights as loads; their standard errors by the test's noise; the slices of values that are alike, loading,
unloading and imprint; the largest load (mN), and that over the largest depth (mN/um), by which heights count as loads."""


def largest_cycle(curve):
    """The cycle of a curve that reaches the largest load."""
    return max(cycles.find_cycles(curve), key=lambda cycle: curve.load[cycle.start])


def depth_and_load(curve):
    """Returns the depth (um) and the load (mN) [2] of a Curve at the start of its largest unloading."""
    hold = largest_cycle(curve).hold
    return np.array([np.mean(curve.depth[hold]), np.mean(curve.load[hold])])


# ---- the test ----

def parts_of(rows, along, low, high):
    """Returns the Parts of rows, equally wide in a monotonous quantity `along` [rows], between two values of it."""
    inside = (along >= low) & (along <= high)
    label = np.minimum((PARTS * (along[inside] - low) / (high - low)).astype(int), PARTS - 1)
    _, places, count = np.unique(label, return_inverse=True, return_counts=True)
    return Parts(rows[inside], places, count)


def means(parts, values):
    """Mean values [parts] of those of the rows [rows] of Parts."""
    return np.bincount(parts.places, values) / parts.count


def slopes(depths, loads):
    """Slopes (mN/um) [parts] of a parabola through mean loads (mN) over mean depths (um): those from part to part would be noise."""
    return np.polyval(np.polyder(np.polyfit(depths - depths[0], loads, min(2, len(loads) - 1))), depths - depths[0])


def target_of(curve, imprint=None):
    """Returns the Target of a measured Curve, and of the Imprint of the same test.

    Parts follow the order of the rows, with noise smoothed: rows sorted by a noisy depth would have biased loads.
    """
    cycle = largest_cycle(curve)
    top, load = np.mean(curve.depth[cycle.hold]), np.mean(curve.load[cycle.hold])
    if top <= 0:
        raise Error(f"{curve.name}: must have a largest depth > 0, not {top:.3g} um")
    if curve.depth[:cycle.start + 1].min() > LEAST_DEPTH * top:
        raise Error(f"{curve.name}: must begin at less than {LEAST_DEPTH:g} of its largest depth {top:.3g} um, "
                    f"not at {curve.depth[0]:.3g} um")
    of_load, of_depth = cycles.noise(curve.load), cycles.noise(curve.depth)
    up, down = np.arange(cycle.begin, cycle.start + 1), np.arange(cycle.start, cycle.end + 1)
    deeper = np.maximum.accumulate(cycles.without_spikes(curve.depth)[up])
    weaker = np.minimum.accumulate(cycles.without_spikes(curve.load)[down])
    up = parts_of(up, deeper, LEAST_DEPTH * top, top - min(CLEAR * of_depth, top / PARTS))
    down = parts_of(down, weaker, LEAST_LOAD * load, load - min(CLEAR * of_load, load / PARTS))
    if min(len(up.rows), len(down.rows)) < LEAST_ROWS:
        raise Error(f"{curve.name}: must have {LEAST_ROWS} rows of its loading above {LEAST_DEPTH:g} of the depth, and {LEAST_ROWS} rows of its unloading "
                    f"above {LEAST_LOAD:g} of the load; there are {len(up.rows)} and {len(down.rows)}")
    values, error = [], []
    for parts in (up, down):
        values.append(means(parts, curve.load[parts.rows]))
        error.append(np.hypot(of_load, slopes(means(parts, curve.depth[parts.rows]), values[-1]) * of_depth) / np.sqrt(parts.count))
    if imprint is not None:
        values.append(load / top * imprint.height)
        error.append(np.full(len(imprint.height), cycles.noise(imprint.height) * load / top))
    ends = np.cumsum([0, *map(len, values)])
    return Target(curve, up, down, imprint, np.concatenate(values), np.maximum(np.concatenate(error), FINEST * load),
                  [slice(*pair) for pair in zip(ends, ends[1:])], load, load / top)


# ---- the run ----

def loads_up(curve, cycle, depths):
    """Loads (mN) of a run's loading at depths (um); beyond its largest depth it goes on like h^2."""
    rows = slice(cycle.begin, cycle.start + 1)
    depth = np.maximum.accumulate(curve.depth[rows])
    top, highest = depth[-1], np.mean(curve.load[cycle.hold])
    return np.where(depths > top, highest * (depths / top) ** 2, np.interp(depths, depth, curve.load[rows]))


def loads_down(curve, cycle, depths):
    """Loads (mN) of a run's unloading at depths (um); beyond its ends, and below half of LEAST_LOAD, it goes on like the line through the
    END beside them."""
    load = curve.load[cycle.start:cycle.end + 1]
    counted = slice(0, np.flatnonzero(load >= LEAST_LOAD / 2 * load.max())[-1] + 1)
    depth, load = np.minimum.accumulate(curve.depth[cycle.start:cycle.end + 1])[counted][::-1], load[counted][::-1]
    found = np.interp(depths, depth, load)
    span = END * (depth[-1] - depth[0])
    for end, near, beyond in ((0, depth <= depth[0] + span, depths < depth[0]), (-1, depth >= depth[-1] - span, depths > depth[-1])):
        if beyond.any():
            found[beyond] = load[end] + np.polyfit(depth[near], load[near], 1)[0] * (depths[beyond] - depth[end])
    return found


def compared(curve, imprint, target):
    """The values of a run, [parts] like those of a Target: its Curve, and its Imprint or None where none is compared."""
    cycle, measured = largest_cycle(curve), target.curve.depth
    values = [means(target.up, loads_up(curve, cycle, measured[target.up.rows])), means(target.down, loads_down(curve, cycle, measured[target.down.rows]))]
    if target.imprint is not None:
        values.append(target.per_height * np.interp(target.imprint.radius, imprint.radius, imprint.height))
    return np.concatenate(values)
