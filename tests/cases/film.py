"""A film on a substrate: bonded bodies of two materials, with the interface on a cell line or not."""
import numpy
import pytest

import harness
import load_depth
import oliver_pharr

# Lengths in cells, E = 1: a sphere on a block of 16 x 16, of which the upper part is a film; slow beside waves, which need 14 to 17.
CASE = {
    "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "16,18", "cell_size": 1, "boundary_x_upper": "symmetry",
    "boundary_y_lower": "symmetry", "indenter": "sphere", "indenter_radius": 20, "indenter_tip": "0,16", "indenter_times": "0,60,240,300",
    "indenter_velocities": [0.0, 0.5 / 240, 0.5 / 240, 0.0], "damping": 0.03, "end_time": 400, "frames": 0, "history_interval": 5}
SOFT = {"youngs_modulus": 1, "poissons_ratio": 0.3, "density": 1}
LEVELS = {"cell_size": 2, "levels": 2, "level_1_lower": "0,8", "level_1_upper": "8,18"}
METAL = {"model": "j2", "yield_stress": 0.02, "hardening_modulus": 0.1}


def named(name, constants):
    return {f"{name}_{constant}": value for constant, value in constants.items()}


def film(thickness, upper, lower):
    """A film on the rest of the block; constants of both."""
    return {**CASE, "materials": "u,l", **named("u", upper), **named("l", lower), "bodies": "film,rest", "film_material": "u", "rest_material": "l",
            "film_lower": [0.0, 16.0 - thickness], "film_upper": "16,16", "rest_lower": "0,0", "rest_upper": [16.0, 16.0 - thickness]}


def held_load(case, **options):
    history = harness.run({**case, **options}).history
    return numpy.mean(history["load"][history["time"] > 320])


@pytest.mark.parametrize("constants, options", [(SOFT, {}), (SOFT | METAL, {}), (SOFT, LEVELS)], ids=["elastic", "metal", "levels"])
def test_film_of_the_same_material(expect, constants, options):
    """With the interface on a cell line it has the points of one body, whose sums differ by rounding only."""
    block = {**CASE, "materials": "m", **named("m", constants), "bodies": "b", "b_lower": "0,0", "b_upper": "16,16", **options}
    one, two = (harness.run(case).history for case in (block, {**film(4, constants, constants), **options}))
    expect("load, largest difference", numpy.max(numpy.abs(one["load"] - two["load"])) / one["load"].max(), at_most=1e-9)
    expect("energy, largest difference", numpy.max(numpy.abs(one["strain_energy"] - two["strain_energy"])) / one["strain_energy"].max(), at_most=1e-9)


def interpolation_error(cell, beside):
    """Load with a film of 4 and a part of a cell, against the cubic through those of whole cells around it; beside: parts of a cell."""
    stiff = SOFT | {"youngs_modulus": 4}
    case = {"cell_size": cell, "history_interval": int(5 / cell)}
    whole = 4 + cell * numpy.arange(-1, 3)
    cubic = numpy.polynomial.Polynomial.fit(whole, [held_load(film(t, SOFT, stiff), **case) for t in whole], 3)
    return max(abs(held_load(film(4 + cell * part, SOFT, stiff), **case) / cubic(4 + cell * part) - 1) for part in beside)
