"""Slow tests: the load does not depend on the speed by more than the tolerance, and what is chosen is told, kept and refused where it cannot be."""
import functools
import json

import numpy
import pytest

import bad_input
import harness
import load_depth
import oliver_pharr
from ranks import largest_difference
from restart import rows_after

# Lengths in cells, E = 1: a cone on a block of 16 x 16, through which waves need 14 to 17.
CONE = {
    "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "16,18", "cell_size": 1, "boundary_x_upper": "symmetry",
    "boundary_y_lower": "symmetry", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block",
    "block_lower": "0,0", "block_upper": "16,16", "indenter": "cone", "indenter_half_angle": 80, "indenter_tip": "0,16", "frames": 0,
    "quasi_static": "true", "indenter_depths": "0.9,0"}
METAL = {"m_model": "j2", "m_yield_stress": 0.01, "m_hardening_modulus": 0.1, "indenter_depths": "0.6,0.5"}
CASES = {"elastic": CONE, "metal": {**CONE, **METAL}}


def parts(history):
    """(last row of the loading, last row of the hold)."""
    resting = numpy.flatnonzero(history["depth"] > history["depth"].max() * (1 - 1e-9))
    return resting[0], resting[-1]


def loading(history, column, shares):
    """The load at shares of the largest depth, by parabolas over a tenth of it."""
    deepest, last = history["depth"].max(), parts(history)[0]
    depth, load = history["depth"][:last] / deepest, history[column][:last]
    near = [abs(depth - share) < 0.05 for share in shares]
    return numpy.array([numpy.polyfit(depth[rows] - share, load[rows], 2)[-1] for rows, share in zip(near, shares)])


def unloading(history, column):
    """(load at the end of the hold, slope there): a parabola through it, over the rows from 97 to 50 % of it."""
    first, last = parts(history)
    held = numpy.mean(history[column][last - (last - first) // 3:last])
    depth, load = history["depth"][last:] - history["depth"][last], history[column][last:]
    rows = numpy.arange(numpy.argmax(load < 0.97 * held), numpy.argmax(load < 0.5 * held))
    x = depth[rows]
    return held, numpy.linalg.lstsq(numpy.stack([x, x**2], axis=1), load[rows] - held, rcond=None)[0][0]


def compare(expect, case, tolerance, factor, limits):
    """A run against one that is slower by a factor; limits of load, load less what inertia and damping add, load in the hold, and slope."""
    fast, slow = (harness.run({**case, "quasi_static_tolerance": each}) for each in (tolerance, tolerance / factor))
    shares = numpy.linspace(0.25, 0.95, 8)
    exact = loading(slow.history, "load_quasi_static", shares)
    for column, limit in zip(("load", "load_quasi_static"), limits):
        error = loading(fast.history, column, shares) / exact - 1
        expect(f"{column}, largest difference from a run {factor} times slower", numpy.max(numpy.abs(error)), at_most=limit)
    (held, slope), (held_slow, slope_slow) = (unloading(run.history, "load_quasi_static") for run in (fast, slow))
    expect("load at the end of the hold, of that", held / held_slow, near=1, tolerance=limits[2])
    expect("slope of the unloading, of that", slope / slope_slow, near=1, tolerance=limits[3])
    return fast
