"""Perfectly plastic bodies whose end is known: shallow balls and cylinders in metal, and rings that fly apart."""
import math

import numpy

import harness
import metals
import studies_page as page
from bar import frames
from tips import block

YIELD = 1e-4  # of Young's modulus, of the metal under balls
LIMIT = (2 + math.pi) / math.sqrt(3)  # Prandtl's pressure over the yield stress, plane strain


def metal(stress):
    return {"m_model": "j2", "m_yield_stress": stress, "m_hardening_modulus": 0}


def pressed(geometry, tip, radius, depth, stress, radii=32):
    """History of the loading by a tip of a radius in a metal, in cells of the finest level."""
    case = {**block(radii), **metal(stress), "geometry": geometry, "indenter": tip, "indenter_radius": radius, "indenter_depths": depth,
            "boundary_x_lower": "symmetry"}
    history = harness.run(case).history
    return {name: values[:numpy.argmax(history["depth"]) + 1] for name, values in history.items()}


def verify_ball_in_metal(study):
    """A shallow ball in a metal that does not harden

    The field is that of a rigid body where E a/(sy R) is above 1000: contact area over depth, a^2 = 2 c^2 R h, and mean pressure, from 6 to 12 cells in
    the contact's radius, a/R = 0.15 at the end. With a tenth of that ratio the surface still sinks in by what is elastic.
    """
    radius, width, c2 = 80.0, 12.0, 1.43
    curves = []
    for name, stress in (("E/sy 10000", YIELD), ("E/sy 1000", 10 * YIELD)):
        history = pressed("axisymmetric", "sphere", radius, width**2 / (2 * c2 * radius), stress)
        depth, area, load = (history[column] for column in ("depth", "contact_area", "load_quasi_static"))
        rows = area > math.pi * (width / 2)**2
        growth = numpy.sum(area[rows] * depth[rows]) / numpy.sum(depth[rows]**2) / (2 * math.pi * radius)
        pressure = numpy.sum(load[rows]) / numpy.sum(area[rows]) / stress
        if stress == YIELD:
            study.compare(f"{name}: c^2 of a^2 = 2 c^2 R h", growth, c2, 0.05)
            study.compare(f"{name}: mean pressure", pressure, 3.0, 0.05, "sy")
        else:
            study.figure(f"{name}: c^2 of a^2 = 2 c^2 R h", growth)
            study.figure(f"{name}: mean pressure", pressure, "sy")
        reach = numpy.sqrt(area[rows] / math.pi) / radius
        curves.append(page.curve(name, reach, load[rows] / area[rows] / stress))
    study.plot("Mean pressure", "a / R", "load / (area sy)", *curves, page.curve("published, rigid body", (0.07, 0.15), (3.0, 3.0), "reference"))


def verify_cylinder_in_metal(study):
    """A shallow cylinder in a metal that does not harden

    In plane strain the mean pressure of a rigid body tends to Prandtl's, (2 + pi) k, as the contact becomes flat; at a/R = 0.05 slip lines have 1 to 2 %
    less, as the faces lean. E a/(sy R) is 500; 12 cells in half the contact's width.
    """
    radius, width, stress = 240.0, 12.0, 1e-4
    history = pressed("plane_strain", "cylinder", radius, width**2 / (2.4 * radius), stress)
    area, load = history["contact_area"], history["load_quasi_static"]
    rows = area > 0.75 * area[-1]
    study.compare("mean pressure", numpy.sum(load[rows]) / numpy.sum(area[rows]) / stress, LIMIT, 0.05, "sy")
    study.figure("half the contact's width at the end, cells", area[-1])
    near = area > 3
    study.plot("Mean pressure", "a / R", "load / (width sy)", page.curve("cylinder, E/sy 10000", area[near] / radius, load[near] / area[near] / stress),
               page.curve("Prandtl", area[near] / radius, numpy.full_like(area[near], LIMIT), "reference"))


# ---- rings ----

RING = {"geometry": "axisymmetric", "cell_size": 1, "boundary_y_lower": "symmetry", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3,
        "m_density": 1, "bodies": "ring", "frames": 0}
INNER, THICK = 60.0, 4.0  # a ring of 60 to 64 cells, 2 of them high above its middle plane
MIDDLE = INNER + THICK / 2


def ring(speed, end, reach, **law):
    """History of a ring that starts with a radial speed; reach: of the domain beyond it."""
    return harness.run({**RING, **{f"m_{name}": value for name, value in law.items()}, "domain_lower": (INNER - 30, 0.0),
                        "domain_upper": (INNER + THICK + reach, 6.0), "ring_lower": (INNER, 0.0), "ring_upper": (INNER + THICK, 2.0),
                        "ring_velocity": (speed, 0.0), "end_time": end, "frames": 20})


def radii(result):
    """(times, mean radius of the points) of the frames, the first at the start."""
    return numpy.array([(time, numpy.average(points["position"][:, 0], weights=points["mass"])) for time, points in frames(result)]).T


def verify_elastic_ring(study):
    """A ring that vibrates along its radius

    A thin ring starts with a radial speed: its mean radius swings by v/w sin w t with w = sqrt(E/rho)/R.
    """
    speed, period = 1e-3, 2 * math.pi * MIDDLE
    result = ring(speed, period, 20)
    time, radius = radii(result)
    swing = (radius - radius[0]) / (speed * MIDDLE)
    exact = numpy.sin(time / MIDDLE)
    study.expect("radius, largest difference, of the swing", numpy.max(numpy.abs(swing - exact)), at_most=0.02)
    study.compare("largest radius less that at the start", numpy.max(swing), numpy.max(exact), 0.02, "v R/c")
    shown = numpy.linspace(0, time[-1], 200)
    study.plot("Swing of the ring", "time / (R/c)", "change of the radius / (v R/c)", page.curve("points", time / MIDDLE, swing, "dots"),
               page.curve("thin ring", shown / MIDDLE, numpy.sin(shown / MIDDLE), "reference"))


def verify_expanding_ring(study):
    """A ring of metal that flies apart

    The kinetic energy of a thin ring that does not harden goes into plastic work, so that it comes to rest at R exp(rho v^2/(2 sy)), less what was
    elastic. Here v is such that this is a fifth more than R.
    """
    stress, growth = 1e-3, 1.2
    speed = math.sqrt(2 * stress * math.log(growth))
    end = 3 * MIDDLE * (growth - 1) / speed
    result = ring(speed, end, 30, model="j2", yield_stress=stress, hardening_modulus=0)
    time, radius = radii(result)
    study.compare("largest radius", numpy.max(radius) / radius[0], growth, 0.01, "R")
    k = int(numpy.argmax(radius > radius[0] * (1 + growth) / 2))
    between = (radius[k] + radius[k - 1]) / 2 / radius[0]
    study.compare("speed when half of the way is done", (radius[k] - radius[k - 1]) / (time[k] - time[k - 1]), speed_of(growth, between) * speed, 0.03, "c")
    study.expect("energies less those at the start, of them", abs(metals.energy_left(result.history, result.history["kinetic_energy"][:1])), at_most=0.02)
    r = numpy.linspace(1, growth, 200)
    clock = numpy.concatenate(([0], numpy.cumsum(numpy.diff(r) / speed_of(growth, 0.5 * (r[1:] + r[:-1]))))) * MIDDLE / speed
    study.plot("Radius of the ring", "time / (R/v)", "radius / R", page.curve("points", time * speed / MIDDLE, radius / radius[0], "dots"),
               page.curve("rigid, plastic ring", clock * speed / MIDDLE, r, "reference"))


def speed_of(growth, place):
    """Speed at a radius over that at the start, of a ring that comes to rest at `growth`."""
    return numpy.sqrt(1 - numpy.log(place) / math.log(growth))

