"""Checks the exact depths and loads of creep.py against reference numbers and against integrals that are found in other ways."""
import numpy as np
import pytest

import harness  # noqa: F401 (finds the package)
from mlgimp import creep
from mlgimp.errors import Error

pytestmark = pytest.mark.fast

TERMS = [0.3, 0.4], [1.0, 20.0]


def marched(times, strain):
    """The stress over E_0 that a strain, [rows] at times, leaves, by small steps of the law's own rate equation: no closed form."""
    stress, left = np.zeros(len(times)), np.zeros(2)
    for row in range(1, len(times)):
        step = times[row] - times[row - 1]
        middle = (strain[row] + strain[row - 1]) / 2
        left = left + step * (middle - left) / (np.array(TERMS[1]) + step / 2)
        stress[row] = strain[row] - left @ TERMS[0]
    return stress


def volterra(times, load):
    """The strain under a load over E_0, [rows], from the Volterra equation of the second kind by the trapezoidal rule: no compliance."""
    def lost(x):
        return sum(share / time * np.exp(-x / time) for share, time in zip(*TERMS))
    strain, step = np.zeros(len(times)), times[1]
    for row in range(1, len(times)):
        past = step * (lost(times[row] - times[1:row]) @ strain[1:row])
        strain[row] = (load[row] + past) / (1 - step / 2 * lost(0.0))
    return strain


def test_ball_of_the_reference(expect):
    """E_0 3, E_inf 1 GPa, 5 s, a ramp of 1 s to 1 mN, R 10 um: numbers of an integration elsewhere."""
    times = [0.5, 1, 2, 5, 10, 30, 100]
    depth = 1e9 * creep.lee_radok(times, [0, 1], [0, 1e-3], 3e9, 0.3, [2 / 3], [5], radius=10e-6)
    for time, found, right in zip(times, depth, (111.35, 180.42, 194.25, 228.48, 268.89, 337.06, 359.60)):
        expect(f"depth at {time} s", found, near=right, tolerance=0.01)


@pytest.mark.parametrize("shape, power, factor", [({"radius": 2e-6}, 1.5, 4 / 3 * 2e-6**0.5), ({"half_angle": 70.3}, 2, 2 / np.pi * np.tan(np.radians(70.3)))])
def test_creep_is_the_volterra_equation(expect, shape, power, factor):
    """Two terms, a ramp of 2 s and a hold."""
    times = np.linspace(0, 40, 4001)
    load = 1e-3 * np.minimum(times / 2, 1)
    depth = creep.lee_radok(times, [0, 2], [0, 1e-3], 2e9, 0.3, *TERMS, **shape)
    strain = volterra(times, load / 2e9 * (1 - 0.3**2))
    expect("depth", np.max(np.abs(depth[1:] / (strain[1:] / factor) ** (1 / power) - 1)), at_most=2e-5)


def test_relaxation_is_the_rate_equation(expect):
    times = np.linspace(0, 40, 4001)
    depth = 1e-7 * np.minimum(times / 2, 1) ** (1 / 1.5)
    load = creep.lee_radok_load(times, times, depth, 2e9, 0.3, *TERMS, radius=2e-6)
    right = marched(times, 4 / 3 * np.sqrt(2e-6) * depth**1.5) * 2e9 / (1 - 0.3**2)
    expect("load", np.max(np.abs(load[1:] / right[1:] - 1)), at_most=1e-5)


def test_creep_and_relaxation_undo_each_other(expect):
    times = np.linspace(0, 30, 3001)
    depth = creep.lee_radok(times, [0, 1, 4], [0, 1e-3, 2e-3], 2e9, 0.3, *TERMS, half_angle=80)
    load = creep.lee_radok_load(times, times, depth, 2e9, 0.3, *TERMS, half_angle=80)
    expect("load", np.max(np.abs(load - np.interp(times, [0, 1, 4], [0, 1e-3, 2e-3]))) / 2e-3, at_most=1e-6)


def test_a_load_at_once(expect):
    """Two rows of the same time are a jump; after long E_0/(1 - sum g) remains."""
    depth = creep.lee_radok([0, 1e5], [0, 0], [0, 1e-3], 2e9, 0.3, *TERMS, half_angle=80)
    expect("depth squared grows by 1/(1 - sum g)", (depth[1] / depth[0]) ** 2, near=1 / 0.3, tolerance=1e-9)
    expect("part of the compliance", 1 + sum(creep.retardation(*TERMS)[0]), near=1 / 0.3, tolerance=1e-9)


def test_cone_of_norton(expect):
    """The reference: 80 degrees, 1 mN, s0 100 MPa, a0 1e-3/s, n 5."""
    depth = 1e9 * creep.norton_cone(np.array([1, 10, 100, 1000]), 1e-3, 80, 1e8, 1e-3, 5)
    for found, right in zip(depth, (125.7, 158.3, 199.3, 250.9)):
        expect("depth, nm", found, near=right, tolerance=0.07)


@pytest.mark.parametrize("shape", [{"radius": 1e-5}, {"half_angle": 80}])
def test_depth_grows_as_the_pressure_says(expect, shape):
    """The rate of the depth, by differences, gives the load back as the mean pressure times the area."""
    times = np.linspace(1, 50, 4901)
    depth = creep.norton_depth(times, 1e-3, 2e8, 1e-4, 3, 50e-9, **shape)
    rate, middle = np.diff(depth) / np.diff(times), (depth[1:] + depth[:-1]) / 2
    _, cone, ball = creep.norton_factors(3)
    radius = np.sqrt(2 * ball * 1e-5 * middle) if "radius" in shape else cone * middle * np.tan(np.radians(80))
    pressure = creep.norton_pressure(rate, radius, 2e8, 1e-4, 3)
    expect("load", np.max(np.abs(np.pi * radius**2 * pressure / 1e-3 - 1)), at_most=1e-5)
    if "radius" in shape:
        expect("the same function", np.max(np.abs(creep.norton_ball_pressure(rate, middle, 1e-5, 2e8, 1e-4, 3) / pressure - 1)), at_most=1e-12)


def test_table_of_norton(expect):
    for exponent, right in ((1, (0.857, 0.642, 0.504)), (2, (2.182, 0.923, 0.856)), (5, (2.969, 1.1, 1.139)), (10, (3.103, 1.176, 1.275))):
        assert creep.norton_factors(exponent) == pytest.approx(right, rel=1e-12)
    factors = np.array([creep.norton_factors(n) for n in np.linspace(1, 60, 600)])
    expect("factors rise with n", np.min(np.diff(factors, axis=0)), at_least=0)
    expect("largest step in 0.1 of n", np.max(np.diff(factors, axis=0)), at_most=0.3)


@pytest.mark.parametrize("call, line", [
    (lambda: creep.relaxation(1, [0.5, 0.5], [1, 2]), "shares=0.5,0.5: must be > 0, and their sum < 1"),
    (lambda: creep.relaxation(1, [-0.1], [1]), "shares=-0.1"), (lambda: creep.relaxation(1, [0.5], [0]), "times=0: must be numbers > 0"),
    (lambda: creep.relaxation(1, [0.5], [1, 2]), "as many of each"), (lambda: creep.norton_factors(0.5), "exponent=0.5: must be a number >= 1"),
    (lambda: creep.lee_radok(1, [0, 1], [0, 1], 1e9, 0.3, [0.5], [1]), "radius, half_angle: one of them"),
    (lambda: creep.norton_depth(1, 1, 1, 1, 2, radius=-1), "radius=-1: must be a number > 0")])
def test_refusals(call, line):
    with pytest.raises(Error, match=line):
        call()
