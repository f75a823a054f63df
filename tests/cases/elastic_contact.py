"""Elastic bodies under an indenter for long: contact gives what the indenter does, and points make no noise of it."""
import numpy
import pytest

import harness
from analytic import lame_constants

E, NU, RHO = 70e9, 0.33, 2700
SOLID = {"materials": "m", "m_youngs_modulus": E, "m_poissons_ratio": NU, "m_density": RHO, "bodies": "b", "boundary_y_lower": "symmetry",
         "frames": 0}
# A bar pressed by a wide plate at a hundredth of the speed at which waves cross it, to 3 %: 150 crossings.
BAR = {**SOLID, "domain_lower": "0,0", "domain_upper": "16e-6,12e-6", "cell_size": 1e-6, "b_lower": "0,0", "b_upper": "8e-6,8e-6",
       "indenter": "flat_punch", "indenter_tip": "0,8e-6", "indenter_times": "0,20e-9", "indenter_velocities": "0,1", "end_time": 250e-9}
BARS = {
    "axisymmetric": {"geometry": "axisymmetric", "indenter_radius": 16e-6},
    "nine points a cell": {"geometry": "axisymmetric", "indenter_radius": 16e-6, "b_points_per_cell": 3},
    "hypoelastic, plane strain": {"boundary_x_lower": "symmetry", "indenter_width": 32e-6, "m_model": "hypoelastic"},
}


def given(history):
    """Work of contact and friction over that of the indenter."""
    return (history["contact_work"][-1] + history["friction_work"][-1]) / history["indenter_work"][-1]


def uniaxial_stress(strain):
    """Nominal stress of a neo-Hookean bar, sigma = (mu (b - I) + lambda ln J I)/J, that may widen freely, Pa."""
    lam, mu = lame_constants(E, NU)
    wide = 1 + NU * strain  # lateral stretch without lateral stress, by Newton's method
    for _ in range(20):
        force = mu * (wide**2 - 1) + lam * numpy.log(wide**2 * (1 - strain))
        wide -= force / (2 * mu * wide + 2 * lam / wide)
    return (mu * ((1 - strain)**2 - 1) + lam * numpy.log(wide**2 * (1 - strain))) / (1 - strain)


@pytest.mark.parametrize("name", BARS)
def test_bar_under_a_plate(expect, name):
    """Noise once doubled every ten crossings, until contact gave two to five times what the indenter did."""
    history = harness.run({**BAR, **BARS[name]}).history
    expect(f"{name}: work of contact over that of the indenter", given(history), near=1, tolerance=5e-3)
    expect(f"{name}: noise over that work", history["noise_energy"][-1] / history["indenter_work"][-1], at_most=1e-3)
    if name == "axisymmetric":
        last = history["time"] > 0.8 * history["time"][-1]
        exact = -uniaxial_stress(history["depth"] / 8e-6) * numpy.pi * 8e-6**2
        expect(f"{name}: load over that of the law, mean of the last fifth", numpy.mean(history["load"][last] / exact[last]), near=1, tolerance=2e-3)


def test_punch_deeper_than_half_a_cell(expect):
    """The surface beside the punch, with its gap to the punch's side, once held the column of the edge open and let it go in blows."""
    history = harness.run({
        **SOLID, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "32e-6,36e-6", "cell_size": 1e-6, "b_lower": "0,0",
        "b_upper": "32e-6,32e-6", "boundary_x_upper": "symmetry", "indenter": "flat_punch", "indenter_radius": 4e-6, "indenter_tip": "0,32e-6",
        "indenter_times": "0,10e-9,110e-9,120e-9", "indenter_velocities": "0,4.54545,4.54545,0", "damping": 1e8, "end_time": 160e-9}).history
    held = history["load"][history["time"] > 130e-9]
    per_depth = history["load"][1:] / history["depth"][1:]
    early = per_depth[numpy.argmin(numpy.abs(history["depth"][1:] - 200e-9))]
    expect("work of contact over that of the indenter", given(history), near=1, tolerance=0.01)
    expect("load while the punch rests, largest change", numpy.ptp(held) / numpy.mean(held), at_most=0.02)
    expect("load over depth at rest, of that at a fifth of a cell", per_depth[-1] / early, near=1, tolerance=0.05)


def test_plate_that_slides_on_a_bar(expect):
    """All of the plate slips, so that friction is mu times the load: a third of it was once missing, as columns let go in turns."""
    history = harness.run({
        **SOLID, "domain_lower": "0,0", "domain_upper": "56e-6,8e-6", "cell_size": 1e-6, "boundary_y_lower": "fixed", "b_lower": "8e-6,0",
        "b_upper": "40e-6,4e-6", "indenter": "flat_punch", "indenter_width": 100e-6, "indenter_tip": "24e-6,4e-6", "indenter_friction": 0.3,
        "indenter_control": "load", "indenter_times": "0,20e-9,40e-9,250e-9", "indenter_loads": "0,6400,6400,6400",
        "indenter_velocities_x": "0,0,10,10", "end_time": 250e-9}).history
    last = history["time"] > 0.5 * history["time"][-1]
    expect("friction over mu times the load, largest difference", numpy.max(numpy.abs(history["friction_force"][last] / (0.3 * history["load"][last]) - 1)),
           at_most=1e-3)
    expect("work of contact and friction over that of the indenter", given(history), near=1, tolerance=0.01)
