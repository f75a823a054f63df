"""What drag and inertia add to loads and plastic work of metals is said with its size, within a factor of two."""
import functools
import re

import numpy
import pytest

import harness

METAL = {"materials": "m", "m_model": "j2", "m_youngs_modulus": 70e9, "m_poissons_ratio": 0.33, "m_density": 2700, "m_yield_stress": 4e8,
         "m_hardening_modulus": 1e9, "bodies": "b", "frames": 0}
CONE = {**METAL, "geometry": "axisymmetric", "domain_lower": "0,8e-6", "domain_upper": "9.6e-6,17.6e-6", "cell_size": 4e-7,
        "boundary_x_upper": "symmetry", "boundary_y_lower": "symmetry", "levels": 2, "refinement_ratio": 4, "level_1_lower": "0,1.36e-5",
        "level_1_upper": "2.4e-6,1.76e-5", "b_lower": "0,8e-6", "b_upper": "9.6e-6,1.6e-5", "indenter": "cone", "indenter_half_angle": 70.3,
        "indenter_tip": "0,1.6e-5", "indenter_times": "0,1e-8", "indenter_velocities": "0,16", "indenter_max_depth": 2.5e-7, "damping": 6e7}
BALL = {name: value for name, value in CONE.items() if name != "indenter_half_angle"} | {"indenter": "sphere", "indenter_radius": 3e-6}
CASES = {"cone": CONE, "ball": BALL}


def said(result, word):
    """Percent in the warning that has a word; 0 where there is none."""
    found = [re.search(r"some ([\d.e+]+) %", line) for line in result.summary["warnings"] if word in line]
    return sum(float(one[1]) for one in found if one)


@functools.lru_cache(None)
def reference(name):
    return harness.run({**CASES[name], "indenter_times": "0,2e-8", "indenter_velocities": "0,5"})


def late_work(result):
    """Work of the indenter over the last 40 % of the depth, which evens out the steps that columns make of the load, J."""
    history = result.history
    return numpy.diff(numpy.interp([1.5e-7, 2.45e-7], history["depth"], history["indenter_work"]))[0]


@pytest.mark.parametrize("name, change, word", [
    ("cone", {"damping": 6e9}, "drag"), ("cone", {"damping": 2e9}, "drag"), ("ball", {"damping": 2e9}, "drag"),
    ("cone", {"indenter_velocities": "0,100", "indenter_times": "0,1.6e-9"}, "inertia"),
    ("ball", {"indenter_velocities": "0,200", "indenter_times": "0,8e-10"}, "inertia")])
def test_motion_in_the_load(expect, name, change, word):
    """The factor of two is what the warning promises. Seen: 0.84, 0.84, 0.82, 1.16, 0.95."""
    result = harness.run({**CASES[name], **change})
    added = 100 * (late_work(result) / late_work(reference(name)) - 1)
    expect(f"{name}: {word} of {change}: percent said over percent added", said(result, word) / added, at_least=0.5, at_most=2)


def test_slow_metal_has_no_such_line():
    assert said(reference("cone"), "drag") == 0 and said(reference("cone"), "inertia") == 0


# A pillar under a pressure that it would bear with a plastic strain of 5 %; times in transits of its elastic wave.
TRANSIT = 8e-6 / 6000
PILLAR = {**METAL, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "4e-6,10e-6", "cell_size": 4e-7, "boundary_y_lower": "symmetry",
          "m_hardening_modulus": 5e9, "b_lower": "0,0", "b_upper": "2e-6,8e-6", "loads": "p", "p_side": "y_upper"}


def pressed(rise, hold=30, **others):
    return harness.run({**PILLAR, "p_times": [0, rise * TRANSIT, 1], "p_pressures": "0,5e8,5e8", "end_time": (rise + hold) * TRANSIT, **others})


@pytest.mark.parametrize("rise", (1, 8, 32))
def test_overshoot_of_a_pressure(expect, rise):
    """Plastic work at rest, with the true stress p = s + H a of the face that stays under p: (s a + H a^2/2) V. The factor of
    two is what the warning promises. Seen: 0.78, 0.63, 0.97."""
    result = pressed(rise)
    strain = (5e8 - 4e8) / 5e9
    static = (4e8 * strain + 0.5 * 5e9 * strain**2) * numpy.pi * 2e-6**2 * 8e-6
    added = 100 * (result.history["plastic_work"][-1] / static - 1)
    expect(f"rise within {rise} transits: percent said over percent added", said(result, "motion") / added, at_least=0.5, at_most=2)


def test_pressure_that_rises_slowly_overshoots_little(expect):
    """Waves of plastic strain take a quarter of the speed. Seen: 2.8 %."""
    expect("percent", said(pressed(400, damping=5e7), "motion"), at_most=5)
