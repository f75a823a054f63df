"""Three dimensions: Hertz's sphere on one level, budgets of a Berkovich tip on three levels."""
import functools
import math

import numpy

import harness
from ranks import BERKOVICH

# A quarter of a sphere of 40 cells on a block of 16 x 16 x 14; lengths in cells, E* = 1.
SPHERE = {
    "geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "16,16,17", "cell_size": 1, "boundary_x_lower": "symmetry",
    "boundary_y_lower": "symmetry", "boundary_z_lower": "symmetry", "boundary_x_upper": "symmetry", "boundary_y_upper": "symmetry",
    "bodies": "block", "block_lower": "0,0,0", "block_upper": "16,16,14", "materials": "m", "m_youngs_modulus": 0.91,
    "m_poissons_ratio": 0.3, "m_density": 1, "indenter": "sphere", "indenter_radius": 40, "indenter_tip": "0,0,14",
    "indenter_times": "0,10,50,60", "indenter_velocities": "0,0.007,0.007,0", "damping": 0.15, "end_time": 90, "frames": 1}


def expect_budgets(expect, result, energy):
    history = result.history
    largest = max(numpy.max(numpy.abs(values)) for name, values in history.items() if "impulse" in name)
    for axis in "xyz":
        parts = [history[f"{name}_impulse_{axis}"] for name in ("support", "contact", "load", "gravity", "damping", "stagger")]
        left = history[f"momentum_{axis}"] - sum(parts)
        expect(f"momentum along {axis} less impulses, of the largest", numpy.max(numpy.abs(left - left[0])) / largest, at_most=1e-11)
    kept = sum(history[name][-1] for name in ("kinetic_energy", "strain_energy", "dissipated_energy"))
    expect("energy, of the work", kept / history["indenter_work"][-1], near=1, tolerance=energy)
    expect("mass", abs(result.summary["mass_error"]), at_most=1e-13)
    expect("points lost", result.summary["points_lost"], at_most=0)


def test_sphere(expect):
    """Hertz from the load: contact radius and largest pressure. On four cells. Seen: radius 6e-3 (2.5e-2 with twice the compliance between nodes),
    pressure 8e-3, sum of the points' pressures 3e-4, momentum 5e-15, energy 7e-3."""
    result = harness.run(SPHERE)
    history = result.history
    load = 4 * history["load"][-1]
    radius = (3 * load * 40 / 4) ** (1 / 3)
    expect("contact radius, cells", radius, at_least=3)
    expect("contact radius from the area", math.sqrt(4 * history["contact_area"][-1] / math.pi) / radius, near=1, tolerance=0.02)
    expect("half width, of the whole tip", history["contact_half_width"][-1] / math.sqrt(4 * history["contact_area"][-1] / math.pi), near=1, tolerance=1e-9)
    expect("largest pressure", history["peak_pressure"][-1] / (2 * radius / math.pi / 40), near=1, tolerance=0.05)
    expect("load of the pressures on the points", harness.load_on_points(result.frame()) / history["load"][-1], near=1,
           tolerance=1e-3)
    expect_budgets(expect, result, 0.02)


@functools.lru_cache(None)
def berkovich():
    return harness.run(BERKOVICH)


def test_budgets_on_levels(expect):
    """Seen: momentum 9e-16, energy 1.5 %."""
    expect("load at the end", berkovich().history["load"][-1], at_least=0.1)
    expect_budgets(expect, berkovich(), 0.05)
