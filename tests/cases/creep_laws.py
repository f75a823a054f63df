"""Creep and relaxation under tips against exact solutions: Lee and Radok's ball, cones and balls in bodies of Norton's law."""
import math

import numpy

from mlgimp import creep

import harness
import studies_page as page

SHARES = (0.5, 0.75, 1.0)  # of the depth at the end of a hold, where depths are compared: on five cells and more in the contact's radius


def block(width, cells, law, blocks, levels):
    """An axisymmetric block of so many contact radii, `width`, on levels of ratio 2 with so many of the finest cells in one."""
    fine = width / cells
    coarse = fine * 2 ** (levels - 1)
    size = math.ceil(blocks * width / coarse) * coarse
    case = {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": [size, size + 2 * coarse], "cell_size": coarse,
            "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "levels": levels, "refinement_ratio": 2, "materials": "m",
            **{f"m_{name}": value for name, value in law.items()}, "bodies": "b", "b_lower": "0,0", "b_upper": [size, size],
            "indenter_tip": [0.0, size], "frames": 0, "history_interval": 10, "quasi_static": "true"}
    for level in range(1, levels):
        cell = coarse / 2 ** (level - 1)
        side = math.ceil(2.3 * width * 2.2 ** (levels - 1 - level) / cell) * cell
        case |= {f"level_{level}_lower": [0.0, size - side], f"level_{level}_upper": [side, size + 2 * coarse]}
    return case


def creeping(exponent, modulus):
    return {"model": "j2", "youngs_modulus": modulus, "poissons_ratio": 0.3, "density": 7000, "rate_law": "norton", "creep_stress": 100e6,
            "creep_rate": 1e-3, "creep_exponent": exponent}


def at(history, time, name):
    return numpy.interp(time, history["test_time"], history[name])


def tip_of(angle, radius):
    return {"indenter": "cone", "indenter_half_angle": angle} if radius is None else {"indenter": "sphere", "indenter_radius": radius}


def hold(exponent, cells, blocks=24, levels=4, angle=80, radius=None, depth=250e-9, load=1e-3, modulus=1e12, **more):
    """(history, time of its end, exact depth [m] of a time) of a load that is put on a cone, or a ball, at once and held until that has
    come to a depth."""
    tip = {"half_angle": angle} if radius is None else {"radius": radius}
    _, factor, of_ball = creep.norton_factors(exponent)
    width = factor * depth * math.tan(math.radians(angle)) if radius is None else math.sqrt(2 * of_ball * radius * depth)
    exact = lambda time: creep.norton_depth(time, load, 100e6, 1e-3, exponent, **tip)
    end = math.exp(creep.norton_power(exponent, **({"radius": radius} if radius else {"half_angle": angle})) * math.log(depth)
                   - creep.log_growth(load, 100e6, 1e-3, exponent, **tip))
    case = {**block(width, cells, creeping(exponent, modulus), blocks, levels), **tip_of(angle, radius), "test_times": [0, end],
            "indenter_loads": [load, load], **more}
    return harness.run(case).history, end, exact


def compare(study, name, exponent, found, power, radius_of):
    """Depth over time, contact radius and mean pressure of a hold. power: of the depth that grows evenly; radius_of: exact, of a depth."""
    history, end, exact = found
    F = creep.norton_factors(exponent)[0]
    for share in SHARES:
        time = share**power * end
        study.expect(f"{name}: depth at {time:.3g} s, of the exact one", at(history, time, "depth") / exact(time), near=1, tolerance=0.02)
    depth = at(history, end, "depth")
    radius = radius_near(history, end)
    study.expect(f"{name}: contact radius of a depth, of the exact one", radius / radius_of(depth), near=1, tolerance=0.03)
    pressure = at(history, end, "load_quasi_static") / (math.pi * radius**2)
    study.expect(f"{name}: mean pressure, of F s0 (dh/dt/(a a0))^(1/n)",
                 pressure / (F * 100e6 * (depth / (power * end) / (radius * 1e-3)) ** (1 / exponent)), near=1, tolerance=0.03)


def radius_near(history, time):
    """Of the contact, from the mean area over depth in the last tenth of the time."""
    rows = (history["test_time"] > 0.9 * time) & (history["test_time"] <= time * (1 + 1e-9))
    return math.sqrt(numpy.mean(history["contact_area"][rows] / history["depth"][rows]) * at(history, time, "depth") / math.pi)


def verify_norton(study):
    """Blunt tips in bodies that creep

    A load is put on a cone of 80 degrees, or a ball, at once and held, in a nearly rigid body of Norton's law: depth over time, contact
    radius and mean pressure, with ten of the finest cells in the contact's radius at the end, against the similarity solutions by
    finite elements (`python/mlgimp/creep.py`).
    """
    slope = math.tan(math.radians(80))
    for exponent in (1, 2, 5, 10):
        _, c, of_ball = creep.norton_factors(exponent)
        far = {"blocks": 96, "levels": 6} if exponent == 1 else {}  # as far as the field of an elastic body
        compare(study, f"cone, n {exponent}", exponent, hold(exponent, 10, **far), 2 * exponent, lambda depth: c * depth * slope)
        ball = hold(exponent, 10, radius=40e-6, depth=100e-9, **far)
        compare(study, f"ball, n {exponent}", exponent, ball, exponent + 0.5, lambda depth: math.sqrt(2 * of_ball * 40e-6 * depth))


def verify_creep_of_the_clock(study):
    """The clock's error

    The same cone with n = 5 by three values of -test_creep: the depth at three tenths of the time, less that of the slowest.
    """
    depths = {}
    for way in (0.1, 0.05, 0.025, 0.0125):
        history, end, _ = hold(5, 6, levels=3, blocks=16, test_creep=way)
        depths[way] = at(history, 0.3 * end, "depth")
    for way in (0.1, 0.05, 0.025):
        study.figure(f"depth with {way}, less that with 0.0125, of it", depths[way] / depths[0.0125] - 1)
    study.expect("depth with 0.025, less that with 0.0125, of it", depths[0.025] / depths[0.0125] - 1, near=0, tolerance=0.005)


def verify_lee_radok(study):
    """A ball on a body that relaxes

    Lee and Radok's solution (1960) for a ball of 100 um on a generalized Maxwell solid, 8 of the finest cells in the contact's
    radius at the end, in a block of 64 of these radii: a load within 1 s and a hold, one term and two; and a depth.
    """
    radius, curves = 100e-6, []
    for name, times, shares in (("one term", [5.0], [2 / 3]), ("two terms", [0.5, 20.0], [0.3, 0.3])):
        law = {"model": "viscoelastic", "youngs_modulus": 3e9, "poissons_ratio": 0.3, "density": 1200, "relaxation_times": times,
               "relaxation_shares": shares}
        ball = {**block(math.sqrt(radius * 167e-9), 8, law, 64, 5), "indenter": "sphere", "indenter_radius": radius, "boundary_x_upper": "free"}
        history = harness.run({**ball, "test_times": [0, 1, 101], "indenter_loads": [0, 1e-3, 1e-3]}, ranks=harness.up_to(2)).history
        seconds = numpy.array([0.5, 1, 2, 5, 10, 30, 100])
        exact = creep.lee_radok(seconds, [0, 1], [0, 1e-3], 3e9, 0.3, shares, times, radius=radius)
        for second, depth in zip(seconds, exact):
            study.expect(f"{name}: depth at {second:g} s, of the exact one", at(history, second, "depth") / depth, near=1, tolerance=0.015)
        rows, moments = history["test_time"] <= 101, numpy.concatenate([numpy.linspace(0.02, 2, 50), numpy.linspace(3, 101, 99)])
        exact = creep.lee_radok(moments, [0, 1], [0, 1e-3], 3e9, 0.3, shares, times, radius=radius)
        curves += [page.curve(name, history["test_time"][rows], 1e9 * history["depth"][rows]),
                   page.curve("_exact" if curves else "Lee and Radok", moments, 1e9 * exact, "reference")]
    study.plot("Depth over time", "time (s)", "depth (nm)", *curves)
