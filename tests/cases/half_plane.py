"""Quasi-static contact on a large damped block against the exact half-plane solutions (docs/verification.md)."""
import math

import analytic
import numpy
import pytest
import studies_page as page
from harness import run, up_to

E, NU, RHO = 70e9, 0.33, 2700.0
E_STAR = E / (1 - NU**2)
SPEED = math.sqrt(E * (1 - NU) / ((1 + NU) * (1 - 2 * NU)) / RHO)
H = 1e-6


def press(indenter, depth, cells, transits=6, **more):
    """A half model of cells x cells, pressed to a depth within one transit and held while the damping acts."""
    size = cells * H
    transit = size / SPEED
    push = 2 * transit
    options = {
        "domain_lower": [0, 0], "domain_upper": [size + 4 * H, size + 4 * H], "cell_size": H,
        "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry",
        "materials": "al", "al_youngs_modulus": E, "al_poissons_ratio": NU, "al_density": RHO,
        "bodies": "block", "block_lower": [0, 0], "block_upper": [size, size],
        "indenter": indenter, "indenter_tip": [0, size], "indenter_times": [0, push, 1.1 * push],
        "indenter_velocities": [depth / (1.05 * push), depth / (1.05 * push), 0],
        "damping": 2 * math.pi / (4 * transit) * 2, "end_time": transits * transit, "frames": 1, "history_interval": 10, **more,
    }
    return run(options, ranks=up_to(2)), size


def measure(expect, name, result, size, contact, limit):
    """Stress on the axis against a HalfPlaneContact of the same load; returns places, stress and exact stress over a and P/a."""
    frame = result.frame()
    axis = frame["position"][:, 0] < 0.3 * H
    depth = size - result.history["depth"][-1] - frame["position"][axis, 1]
    stress = frame["stress"][axis, 1]
    for reach in (0.5, 1.0, 2.0):
        y = reach * contact.half_width
        found = numpy.interp(y, depth[::-1], stress[::-1]) if depth[0] > depth[-1] else numpy.interp(y, depth, stress)
        exact = contact.axis_stress(numpy.array([-y]))[1][0]
        expect(f"{name}: stress_yy on the axis at {reach:g} a, relative error", abs(found / exact - 1), at_most=limit)
    seen, scale = (depth > 0.1 * contact.half_width) & (depth < 4 * contact.half_width), contact.load / contact.half_width
    return depth[seen] / contact.half_width, stress[seen] / scale, contact.axis_stress(-depth[seen])[1] / scale


def cylinder(expect, cells, limit, width=7):
    a = width * H
    radius = 60 * a
    depth = a * a / (2 * radius) * (math.log(4 * cells * H / a) - 0.2)
    result, size = press("cylinder", depth, cells, indenter_radius=radius)
    history = result.history
    load, found = 2 * history["load"][-1], history["contact_half_width"][-1]
    contact = analytic.cylinder_contact(math.sqrt(4 * radius * load / (math.pi * E_STAR)), E_STAR, radius)
    print(f"      cylinder: a/h {found / H:.2f}, from the load {contact.half_width / H:.2f}")
    expect(f"cylinder, {cells} cells: load for the contact's width, relative error", abs(load / (math.pi * E_STAR * found**2 / (4 * radius)) - 1),
           at_most=limit)
    peak = contact.pressure(numpy.array([0.0]))[0]
    expect(f"cylinder, {cells} cells: peak pressure, relative error", abs(history["peak_pressure"][-1] / peak - 1), at_most=limit)
    return measure(expect, f"cylinder, {cells} cells", result, size, contact, limit)


def wedge(expect, cells, limit, width=7):
    a, half_angle = width * H, 89.0
    slope = math.tan(math.radians(90 - half_angle))
    depth = a * slope * 2 / math.pi * (math.log(4 * cells * H / a) + 0.3)
    result, size = press("wedge", depth, cells, indenter_half_angle=half_angle)
    history = result.history
    load, found = 2 * history["load"][-1], history["contact_half_width"][-1]
    contact = analytic.wedge_contact(load / (E_STAR * slope), E_STAR, slope)
    print(f"      wedge: a/h {found / H:.2f}, from the load {contact.half_width / H:.2f}")
    expect(f"wedge, {cells} cells: load for the contact's width, relative error", abs(load / (E_STAR * found * slope) - 1), at_most=limit)
    return measure(expect, f"wedge, {cells} cells", result, size, contact, limit)


def flat_punch(expect, cells, limit, width=7):
    a = width * H
    result, size = press("flat_punch", 0.01 * a, cells, indenter_width=2 * a)
    history = result.history
    load, found = 2 * history["load"][-1], history["contact_half_width"][-1]
    contact = analytic.flat_punch_contact(a, load)
    expect(f"flat punch, {cells} cells: half width, relative error", abs(found / a - 1), at_most=limit)
    expect(f"flat punch, {cells} cells: area of contact, of the punch's", history["contact_area"][-1] / a, near=1, tolerance=0.01)
    return measure(expect, f"flat punch, {cells} cells", result, size, contact, limit)


@pytest.mark.mpi
@pytest.mark.parametrize("shape", [cylinder, wedge, flat_punch])
def test_half_plane(expect, shape):
    """The limit is that of the study, for blocks whose sides are not far away. Seen: load for the width 1.5 %, peak 1e-3, stress 6.5e-3, width of the
    punch 8e-5."""
    shape(expect, 100, 0.04)


def verify_half_plane(study):
    """Contact with a half-plane

    Indenters pressed into a large damped block and held, against the exact solutions for the measured load. Blocks of
    100 cells (contact half width a/h about 7.5), 200 cells, and 300 cells with a/h about 12. A flat punch acts as if a
    quarter of a cell wider.
    """
    for shape, title in ((cylinder, "Cylinder"), (wedge, "Wedge of 1 degree"), (flat_punch, "Flat punch")):
        curves = []
        for cells, width in ((100, 7), (200, 7), (300, 12)):
            depth, stress, exact = shape(study.expect, cells, 0.04, width=width)
            along = numpy.argsort(depth)
            curves.append(page.curve(f"{cells} cells", depth[along], stress[along]))
        study.plot(f"{title}: stress on the axis", "depth / a", "stress_yy / (P/a)", *curves,
                    page.curve("exact", depth[along], exact[along], "reference"))
