"""A cylinder that is pressed on a half plane and then pushed sideways: it slips from the rim inwards, and the heat of that is known."""
import math

import numpy
import pytest
from scipy.integrate import quad

import harness
import studies_page as page

NU, FRICTION, WIDTH = 0.49, 0.3, 8.0  # WIDTH: half of the contact's, finest cells, which are 1
E_STAR = 1 / (1 - NU**2)
RADIUS = 40 * WIDTH
LOAD = math.pi * E_STAR * WIDTH**2 / (4 * RADIUS)  # Hertz
SHEAR_SPEED = math.sqrt(1 / (2 * (1 + NU)))
SHARES = (0.5, 0.7, 0.9)  # of the force at which all slips


def slipping(levels=3, way=1.3):
    """History: load control, then the tip moves sideways by so much of the way at which all slips on a half plane of the block's size."""
    half = 32.0 * 2 ** (levels - 1)
    transit, top = half / SHEAR_SPEED, half + 2**levels
    pressed, side = 4 * transit, 10 * transit
    reach = way * FRICTION * LOAD / (math.pi * E_STAR) * (2 * math.log(half / WIDTH) + 1)
    case = {"domain_lower": (-half, 0.0), "domain_upper": (half, top), "cell_size": 2 ** (levels - 1), "levels": levels, "boundary_x_lower": "fixed",
            "boundary_x_upper": "fixed", "boundary_y_lower": "fixed", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": NU, "m_density": 1,
            "m_volume_average": "true", "bodies": "b", "b_lower": (-half, 0.0), "b_upper": (half, half), "indenter": "cylinder", "indenter_radius": RADIUS,
            "indenter_tip": (0.0, half), "indenter_friction": FRICTION, "indenter_control": "load",
            "indenter_times": (0.0, pressed, pressed + transit, pressed + 2 * transit, pressed + side), "indenter_loads": (0.0, LOAD, LOAD, LOAD, LOAD),
            "indenter_velocities_x": (0.0, 0.0, 0.0, reach / (side - 1.5 * transit), reach / (side - 1.5 * transit)), "damping": math.pi / transit, "frames": 0,
            "history_interval": 5}
    for k in range(1, levels):
        size = half / 2**k
        case[f"level_{k}_lower"], case[f"level_{k}_upper"] = (-size, half - size), (size, top)
    history = harness.run(case).history
    return {name: values[history["time"] > pressed + transit] for name, values in history.items()}


def heat(share):
    """Of a contact whose tangential force is a share q of that at which all slips, over (mu P)^2/(pi E*): (1 - q) ln(1 - q) + q - q^2/2.

    A force dQ moves the middle |x| < c = a sqrt(1 - q), which sticks, as a rigid punch, past which the surface slips by 2 dQ arccosh(|x|/c)/(pi E*), against
    mu times Hertz's pressure; this is the integral over the slipping rim and over Q. Exact where pressures do not move the surface sideways, as in bodies
    that keep their volume.
    """
    return (1 - share) * numpy.log(1 - share) + share - share**2 / 2


@pytest.mark.fast
@pytest.mark.parametrize("share", SHARES)
def test_heat(expect, share):
    """The integral, by numbers. Seen: 1e-9."""
    def rate(q):
        stick = math.sqrt(1 - q)  # of the half width, which is 1, as are mu P and pi E*
        return 2 * quad(lambda x: 2 / math.pi * math.sqrt(1 - x**2) * 2 * math.acosh(x / stick), stick, 1)[0]
    expect("heat, of the integral", heat(share) / quad(rate, 0, share)[0], near=1, tolerance=1e-6)


def verify_cattaneo_mindlin(study):
    """A cylinder that is pushed sideways until it slips

    Load control, then a way sideways, on a nearly incompressible body, eight cells in half the contact's width: heat of friction over the
    tangential force.
    """
    history = slipping()
    share = numpy.abs(history["friction_force"]) / (FRICTION * LOAD)
    warmth = (history["friction_work"] - history["friction_work"][0]) / ((FRICTION * LOAD)**2 / (math.pi * E_STAR))
    for q in SHARES:
        there = numpy.flatnonzero((share[:-1] < q) & (share[1:] >= q))[0]
        ours = numpy.interp(q, share[there:there + 2], warmth[there:there + 2])
        study.compare(f"heat at {q:g} of the force at which all slips", ours, heat(q), 0.05, "(mu P)^2/(pi E*)")
    study.compare("half the contact's width", numpy.mean(history["contact_area"]) / 2, WIDTH, 0.02, "cells")
    study.figure("heat of the pressing before, of that at 0.9", history["friction_work"][0] / ((FRICTION * LOAD)**2 / (math.pi * E_STAR)) / heat(0.9))
    shown = numpy.linspace(0, 0.99, 100)
    rows = share < 0.99
    study.plot("Heat of partial slip", "tangential force / (mu P)", "heat / ((mu P)^2/(pi E*))", page.curve("cylinder", share[rows], warmth[rows], "dots"),
               page.curve("Cattaneo and Mindlin", shown, heat(shown), "reference"))
