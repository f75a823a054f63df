"""Indenters of laboratories: area functions, profiles, maps of heights, rounded punches and tilted tips, against exact ones."""
import math

import numpy
import pytest

import harness

# An elastic body of small strain under a tip of revolution whose contact is eight cells wide in the end; cells are 1.
CELLS = 8
MODULUS = 1 / (1 - 0.3**2)  # E*
BODY = {"materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "b", "boundary_y_lower": "symmetry",
        "boundary_x_upper": "symmetry", "geometry": "axisymmetric", "quasi_static": "true", "quasi_static_tolerance": 0.05, "frames": 0}


def block(radii):
    """A block of so many radii of the contact, a power of two, on levels that grow with the distance from the tip."""
    half, levels = CELLS * radii, int(math.log2(radii)) - 1
    case = {**BODY, "domain_lower": "0,0", "domain_upper": (half, half + 2**levels), "cell_size": 2**(levels - 1), "levels": levels,
            "b_lower": "0,0", "b_upper": (half, half), "indenter_tip": (0, half)}
    for k in range(1, levels):
        case[f"level_{k}_lower"], case[f"level_{k}_upper"] = (0, half - half / 2**k), (half / 2**k, half + 2**levels)
    return case


def sneddon(slope, radius):
    """h and P/E* of a frictionless tip whose profile has slope(r), where the contact has a radius: Sneddon, Int. J. Eng. Sci. 3 (1965) 47.

    With r = a sin(t): h = int a f' dt, P = 2 E* int a^2 sin^2(t) f' dt, t from 0 to pi/2, by the midpoint rule.
    """
    t = (numpy.arange(20000) + 0.5) * math.pi / 2 / 20000
    f = slope(radius * numpy.sin(t))
    return numpy.mean(radius * f) * math.pi / 2, 2 * numpy.mean((radius * numpy.sin(t))**2 * f) * math.pi / 2


def deepest(result, depth):
    """Load and radius of the contact at rest at the largest depth."""
    history = result.history
    rest = history["depth"] > depth * (1 - 1e-6)
    return [float(numpy.mean(history[name][rest])) for name in ("load_quasi_static", "contact_half_width")]


# ---- tips of revolution ----

R, FLAT, EDGE, ANGLE = 80.0, 7.0, 8.0, 84.0
CONE = math.tan(math.radians(ANGLE))


def of_area(r):
    """Slope of the tip with A = pi tan^2 h^2 + 2 pi R h: z with tan^2 z^2 + 2 R z = r^2."""
    return r / numpy.sqrt(R**2 + (CONE * r)**2)


def of_edge(r):
    """Of a level disk of the radius FLAT with a round edge around it."""
    across = numpy.clip(r - FLAT, 0, EDGE)
    return across / numpy.sqrt(numpy.maximum(EDGE**2 - across**2, 1e-12))


def of_fourth_power(r):
    return 0.1 * (r / CELLS)**3


def profile_file(folder, height, reach):
    """A file with a profile from its heights."""
    r = numpy.linspace(0, reach, 400)
    path = folder / "profile.txt"
    numpy.savetxt(path, numpy.column_stack([r, height(r)]), header="r z")
    return path


def tip_cases(folder):
    power = profile_file(folder, lambda r: 0.025 * CELLS * (r / CELLS)**4, 3 * CELLS)
    return {
        "area function": ({"indenter": "area_function", "indenter_area_coefficients": (math.pi * CONE**2, 2 * math.pi * R)}, of_area, CELLS),
        "rounded punch": ({"indenter": "flat_punch", "indenter_radius": FLAT + EDGE, "indenter_edge_radius": EDGE}, of_edge, CELLS),
        "fourth power": ({"indenter": "profile", "indenter_profile": power}, of_fourth_power, CELLS),
    }


def pressed(tip, slope, radius, radii):
    """Ratios of load and radius to Sneddon's at his depth."""
    depth, load = sneddon(slope, radius)
    found, width = deepest(harness.run({**block(radii), **tip, "indenter_depths": depth}), depth)
    return found / (MODULUS * load), width / radius


@pytest.mark.parametrize("name", ["area function", "rounded punch", "fourth power"])
def test_sneddon(expect, name, tmp_path):
    tip, slope, radius = tip_cases(tmp_path)[name]
    ratios = [pressed(tip, slope, radius, radii) for radii in (8, 16)]
    for k, (what, limit) in enumerate((("load", 0.01), ("radius", 0.015))):
        expect(f"{name}: {what} over Sneddon's in a half space", 2 * ratios[1][k] - ratios[0][k], near=1, tolerance=limit)
