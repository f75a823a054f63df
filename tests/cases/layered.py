"""Pressures on parts of a surface against exact solutions: Flamant's and Boussinesq's half space, and a film on a substrate."""
import math

import numpy
import pytest
from scipy.integrate import quad
from scipy.linalg import expm, schur
from scipy.special import j1

import analytic
import harness
import studies_page as page

E, NU, RATIO = 1.0, 0.3, 4  # RATIO: of the substrate's modulus to the film's
E_STAR = E / (1 - NU**2)
RADIUS = 8  # of the loaded circle, half of the loaded strip; finest cells, which are 1
PRESSURE = 1e-4  # small strain
SPEED = math.sqrt((1 - NU) / ((1 + NU) * (1 - 2 * NU)))  # of waves, density 1


def block(radii, thickness=None):
    """A block of so many RADIUS, a power of two, on levels that grow with the distance from the load, which rises and is held; the
    upper part, of a thickness, is a film where that is given."""
    half, levels = RADIUS * radii, int(math.log2(radii)) - 1
    top = half + 2**levels
    transit = half / SPEED * (1 if thickness is None else 1 / math.sqrt(RATIO))
    parts = {"b": (0, half)} if thickness is None else {"film": (half - thickness, half), "rest": (0, half - thickness)}
    moduli = {"b": E, "film": E, "rest": RATIO * E}
    case = {"domain_lower": "0,0", "domain_upper": (half, top), "cell_size": 2**(levels - 1), "levels": levels, "boundary_x_lower": "symmetry",
            "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "materials": ",".join(f"m{name}" for name in parts),
            "bodies": ",".join(parts), "loads": "q", "q_body": next(iter(parts)), "q_side": "y_upper", "q_span": (0, RADIUS),
            "q_times": (0.0, 2 * transit), "q_pressures": (0.0, PRESSURE), "damping": math.pi / (2 * transit), "end_time": 10 * transit, "frames": 1,
            "history_interval": 100}
    for name, (lower, upper) in parts.items():
        case |= {f"m{name}_model": "linear", f"m{name}_youngs_modulus": moduli[name], f"m{name}_poissons_ratio": NU, f"m{name}_density": 1,
                 f"{name}_material": f"m{name}", f"{name}_lower": (0.0, lower), f"{name}_upper": (half, upper)}
    for k in range(1, levels):
        case[f"level_{k}_lower"], case[f"level_{k}_upper"] = (0.0, half - half / 2**k), (half / 2**k, top)
    return case, half


def axis_of(frame, half):
    """(depths, stress along y) of the points next to the axis, from the surface down."""
    start = frame["position"] - frame["displacement"]
    rows = numpy.flatnonzero(start[:, 0] < 1.2 * frame["half_size"][:, 0])  # on any level
    rows = rows[numpy.argsort(-start[rows, 1])]
    return half - start[rows, 1], frame["stress"][rows, 1]


def sunk(frame, half):
    """How far the middle of the loaded part has sunk: two rows of points, continued to the surface."""
    start = frame["position"] - frame["displacement"]
    depth, down = [], []
    for row in (0.25, 0.75):
        points = (numpy.abs(half - start[:, 1] - row) < 0.1) & (start[:, 0] < 0.3)
        depth.append(numpy.mean(half - start[points, 1]))
        down.append(-numpy.mean(frame["displacement"][points, 1]))
    return down[0] + (down[0] - down[1]) * depth[0] / (depth[1] - depth[0])


# ---- plane strain ----

def strip_stress(x, y):
    """Stress tensors [points][2][2] below a strip |x| < a under a pressure, over it; y < 0. Flamant's line load, integrated by Gauss's rule."""
    places, weights = numpy.polynomial.legendre.leggauss(60)
    offset = numpy.stack(numpy.broadcast_arrays(x[:, None] - RADIUS * places, y[:, None]), axis=-1)
    square = (offset**2).sum(axis=-1)
    lines = 2 / math.pi * offset[..., 1] / square**2 * RADIUS * weights  # toward the line: -(2 p/pi) cos/r
    return numpy.einsum("pq,pqi,pqj->pij", lines, offset, offset)


def verify_flamant(study):
    """A line load on a half plane

    A pressure on a strip of a large block in plane strain, small strain: stress on the axis, and that toward the load in three directions at 8 half widths
    from it, against the integral of Flamant's solution over the strip. Blocks of 64 and 128 half widths, whose sides take as much from the stress far
    from the load as they are near. Borders of levels lie 4 and 8 half widths below the load.
    """
    curves, toward = [], []
    for radii in (64, 128):
        case, half = block(radii)
        frame = harness.run({**case, "geometry": "plane_strain"}).frame()
        depth, stress = axis_of(frame, half)
        toward.append(toward_load(frame, half))
        for reach in (0.5, 1, 2, 3, 4, 6, 8):
            exact = strip_stress(numpy.zeros(1), numpy.array([-reach * RADIUS]))[0, 1, 1]
            study.compare(f"block of {radii} a: stress on the axis at {reach:g} a", numpy.interp(reach * RADIUS, depth, stress) / PRESSURE, exact, 0.02, "p")
        near = depth < 10 * RADIUS
        curves.append(page.curve(f"block of {radii} a", depth[near] / RADIUS, stress[near] / PRESSURE, "dots" if radii == 64 else "line"))
    for degrees, (small, strip), (large, _) in zip(DIRECTIONS, *toward):
        study.compare(f"stress toward the load at 8 a on a half plane, {degrees} degrees from the axis", 2 * large - small, strip, 0.03, "p")
    shown = numpy.linspace(0.3, 10, 100)
    study.plot("Stress on the axis under a strip", "depth / a", "stress_yy / p", *curves,
               page.curve("strip", shown, strip_stress(0 * shown, -RADIUS * shown)[:, 1, 1], "reference"),
               page.curve("line load", shown[shown > 1], -4 / math.pi / shown[shown > 1], "guide"))


DIRECTIONS = (0, 30, 60)  # degrees from the axis


def toward_load(frame, half):
    """(stress of points at 8 half widths from the load along the line to its middle, exact one), over the pressure, for each of the directions."""
    x, y = (frame["position"] - frame["displacement"] - numpy.array([0, half])).T
    radius, angle = numpy.hypot(x, y), numpy.degrees(numpy.arctan2(x, -y))
    found = []
    for degrees in DIRECTIONS:
        there = (numpy.abs(radius - 8 * RADIUS) < 4) & (numpy.abs(angle - degrees) < 4)
        n = numpy.stack((x, y), axis=1)[there] / radius[there, None]
        xx, yy, xy = (frame["stress"][there, k] for k in (0, 1, 3))
        ours = numpy.mean(n[:, 0]**2 * xx + n[:, 1]**2 * yy + 2 * n[:, 0] * n[:, 1] * xy) / PRESSURE
        found.append((ours, numpy.mean(numpy.einsum("pi,pij,pj->p", n, strip_stress(x[there], y[there]), n))))
    return found


# ---- axisymmetry ----

def circle_stress(depth):
    """Stress along the axis of a circle under a pressure, over it: Boussinesq's point load, integrated."""
    return -(1 - (1 + (RADIUS / depth)**2)**-1.5)


def on_half_space(thickness=None):
    """(frame on a block of 32 radii, its height, how far the middle has sunk on a half space): what the block's size takes goes as its inverse."""
    depths = []
    for radii in (16, 32):
        case, half = block(radii, thickness)
        frame = harness.run({**case, "geometry": "axisymmetric"}).frame()
        depths.append(sunk(frame, half))
    return frame, half, 2 * depths[1] - depths[0]


def verify_boussinesq(study):
    """A pressure on a circle of a half space

    In axisymmetry, small strain, eight cells in the radius: stress on the axis, and how far the middle sinks on a half space, extrapolated from
    blocks of 16 and 32 radii. A border of levels lies 4 radii below the load.
    """
    frame, half, middle = on_half_space()
    depth, stress = axis_of(frame, half)
    for reach in (0.5, 1, 2, 3, 4):
        study.compare(f"stress on the axis at {reach:g} a", numpy.interp(reach * RADIUS, depth, stress) / PRESSURE, circle_stress(reach * RADIUS), 0.02, "p")
    study.compare("middle, sunk by", middle / (PRESSURE * RADIUS / E_STAR), 2, 0.01, "p a/E*")
    near = depth < 8 * RADIUS
    study.plot("Stress on the axis under a circle", "depth / a", "stress_yy / p",
               page.curve("block of 32 a", depth[near] / RADIUS, stress[near] / PRESSURE, "dots"),
               page.curve("exact", depth[near] / RADIUS, circle_stress(depth[near]), "reference"))


def layered_compliance(wave, thickness, ratio=RATIO):
    """How far a pressure J0(k r), or cos(k x), moves the surface of a film that is bonded to a substrate, over 2/(E* k), that of the film alone.

    Equilibrium and Hooke's law are four equations over the depth for the amplitudes of displacement along the surface and down, of shear and of
    the stress across; their exponential leads through the film, below which only what dies away with depth is left.
    """
    def system(modulus):
        lam, mu = analytic.lame_constants(modulus, NU)
        stiff = lam + 2 * mu
        return numpy.array([[0, 1, 1 / mu, 0], [-lam / stiff, 0, 0, 1 / stiff], [stiff - lam**2 / stiff, 0, 0, lam / stiff], [0, 0, -1, 0]])
    dying = schur(system(ratio * E), sort="lhp")[1][:, :2]
    at_surface = expm(-system(E) * wave * thickness) @ dying
    return at_surface[1] @ numpy.linalg.solve(at_surface[2:], [0, -1]) / (2 / E_STAR)


@pytest.mark.fast
def test_compliance_of_a_film(expect):
    """As the film alone where both are alike, or waves are short; as the substrate where they are long. Seen: 2e-15, 1e-8, 1.4e-3."""
    expect("film on its like", layered_compliance(1, 1.0, 1), near=1, tolerance=1e-12)
    expect("short waves", layered_compliance(12, 1.0), near=1, tolerance=1e-6)
    expect("long waves, of the substrate", RATIO * layered_compliance(1e-3, 1.0), near=1, tolerance=5e-3)


def middle_of_film(thickness):
    """How far the middle of a circle under a pressure sinks on the film, over p a/E*: Hankel's integral of J1(k a) 2 C(k)/k."""
    far = 15 / thickness  # from where the film is as thick as can be
    less = quad(lambda k: (layered_compliance(k, thickness) - 1) * j1(k * RADIUS) / k, 1e-6, far, limit=400)[0]
    return 2 * (1 + less)  # the integral of J1(k a)/k over all k is 1


def verify_film_under_pressure(study):
    """A pressure on a film on a substrate

    The same circle on a film of half its radius, of its radius and of four radii, bonded to a substrate four times as stiff.
    """
    for part in (0.5, 1, 4):
        middle = on_half_space(part * RADIUS)[2]
        study.compare(f"film of {part:g} radii: middle, sunk by", middle / (PRESSURE * RADIUS / E_STAR), middle_of_film(part * RADIUS), 0.02, "p a/E*")
