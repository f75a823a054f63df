"""The law anisotropic: with isotropic constants it is another law's, and flat punches meet the indentation modulus of crystals."""
import math

import numpy
import pytest

import analytic
import harness
from ranks import SAME, largest_difference
from refusals import Table, expect_refused

GPA = 1e9  # Pa, and density in kg/m3, so that waves have speeds of about 10 m/s and cells a size of 1
SILICON, COPPER, ZINC = (165.7, 63.9, 79.6), (168.4, 121.4, 75.4), (163.7, 36.4, 53, 63.5, 38.8)
QUARTZ = (86.8, 7.0, 11.9, 105.8, 58.2, -18.0)
SURFACES = {"001": ((0, 0, 1), (1, 0, 0)), "011": ((0, 1, 1), (1, 0, 0)), "111": ((1, 1, 1), (1, -1, 0))}
RADIUS = 8  # of punches, finest cells


def isotropic(modulus, ratio):
    """C11, C12, C44 in the unit of the modulus."""
    lam, mu = analytic.lame_constants(modulus, ratio)
    return lam + 2 * mu, lam, mu


def material(constants, **more):
    return {"materials": "m", "m_model": "anisotropic", "m_density": GPA, "m_elastic_constants": [GPA * float(c) for c in constants],
            **{f"m_{name}": list(value) for name, value in more.items()}}


def slow(constants, size, depth, transits):
    """Options of an indenter that goes down within so many transits of waves, of damping and of a hold."""
    speed = math.sqrt(max(constants))
    ramp = transits * size / speed
    down = depth / (0.9 * ramp)
    return {"indenter_times": [0.0, 0.1 * ramp, 0.9 * ramp, ramp], "indenter_velocities": [0.0, down, down, 0.0],
            "end_time": ramp + 5 * size / speed, "damping": 0.5 * math.pi * speed / size, "frames": 0, "history_interval": 2}


def modulus(history, parts=1):
    """P/(2 a h) in GPa from the last rows; parts: of the punch in the model."""
    late = slice(int(0.93 * len(history["load"])), None)
    return parts * numpy.mean(history["load"][late]) / (2 * RADIUS * numpy.mean(history["depth"][late])) / GPA


def round_punch(constants, radii):
    """Modulus by a flat punch in axisymmetry on three levels; radii: of the punch in the block's size."""
    size, outer, inner = RADIUS * radii, 160, math.ceil(2.5 * RADIUS / 4) * 4
    return modulus(harness.run({
        **material(constants), **slow(constants, size, 0.01 * RADIUS, 8), "geometry": "axisymmetric", "domain_lower": "0,0",
        "domain_upper": [size, size + 32], "cell_size": 16, "levels": 3, "refinement_ratio": 4, "level_1_lower": [0, size - outer],
        "level_1_upper": [outer, size + 32], "level_2_lower": [0, size - inner], "level_2_upper": [inner, size + 32],
        "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "bodies": "b", "b_lower": "0,0", "b_upper": [size, size],
        "indenter": "flat_punch", "indenter_radius": RADIUS, "indenter_tip": [0, size]}).history)


def punch_in_space(constants, levels, half=False, **lattice):
    """Modulus by a quarter, or a half, of a flat punch on levels, on a block of 16, with 5 levels of 32 radii."""
    cell = 2 ** (levels - 1)
    size, top = 16.0 * cell, 18.0 * cell
    wide = [16.0 * 2**k for k in range(levels - 2, -1, -1)]
    boxes = {f"level_{k}_{end}": corner for k, w in enumerate(wide, 1)
             for end, corner in (("lower", [0.0, -w if half else 0.0, size - w]), ("upper", [w, w, top]))}
    sides = {f"boundary_{side}": "symmetry" for side in ("x_lower", "x_upper", "y_lower", "y_upper", "z_lower")}
    lower = [0.0, -size if half else 0.0, 0.0]
    return modulus(harness.run({
        **material(constants, **lattice), **slow(constants, size, 0.02 * RADIUS, 5), **sides, **boxes, "geometry": "3d", "levels": levels,
        "domain_lower": lower, "domain_upper": [size, size, top], "cell_size": cell, "bodies": "b", "b_lower": lower,
        "b_upper": [size, size, size], "indenter": "flat_punch", "indenter_radius": RADIUS, "indenter_tip": [0.0, 0.0, size]}).history, 2 if half else 4)


def on_half_space(*found, **options):
    """(that of a block of 16, of 32 radii, of a half space) over the modulus; what the block's size adds to the compliance is as its inverse."""
    small, large = (punch_in_space(*found, levels, **options) for levels in (4, 5))
    return small, large, 1 / (2 / large - 1 / small)


SPHERES = {"plane_strain": "cylinder", "axisymmetric": "sphere", "3d": "sphere"}


@pytest.mark.parametrize("geometry", SPHERES)
def test_isotropic(expect, geometry):
    """The same history as st_venant_kirchhoff, at the same steps. Seen: 3e-13."""
    flat = geometry != "3d"
    size, top = ("12,12", "12,14") if flat else ("8,8,8", "8,8,10")
    zero = "0,0" if flat else "0,0,0"
    sides = {f"boundary_{side}": "symmetry" for side in ("x_lower", "x_upper", "y_lower") + (() if flat else ("y_upper", "z_lower"))}
    case = {"geometry": geometry, "domain_lower": zero, "domain_upper": top, "cell_size": 1, **sides, "materials": "m", "m_density": GPA,
            "bodies": "b", "b_lower": zero, "b_upper": size, "indenter": SPHERES[geometry], "indenter_radius": 10,
            "indenter_tip": "0,12" if flat else "0,0,8", "indenter_times": 0, "indenter_velocities": 0.5, "time_step": 0.02, "max_steps": 60,
            "frames": 0, "damping": 0.3}
    one = harness.run({**case, "m_model": "st_venant_kirchhoff", "m_youngs_modulus": 110 * GPA, "m_poissons_ratio": 0.25})
    other = harness.run({**case, **material(isotropic(110, 0.25))})
    difference, column = largest_difference(other.history, one.history)
    expect(f"history (worst column {column})", difference, at_most=1e-12)
    expect("load", one.history["load"][-1], at_least=GPA)


def test_zinc(expect):
    """A flat punch on the basal plane, block of 64 radii, 8 cells in one. Seen: 1.011 of the modulus, as an isotropic block has 1.012."""
    block = round_punch(isotropic(110, 0.25), 64) / analytic.plane_strain_modulus(110, 0.25)
    zinc = round_punch(ZINC, 64) / analytic.hexagonal_indentation_modulus(*ZINC)
    expect("isotropic, of E/(1 - nu^2)", block, near=1, tolerance=0.015)
    expect("zinc, of its modulus", zinc, near=1, tolerance=0.015)
    expect("zinc over isotropic", zinc / block, near=1, tolerance=0.003)


SPACE = {"geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "8,8,10", "cell_size": 1, "boundary_x_lower": "symmetry",
         "boundary_y_lower": "symmetry", "boundary_z_lower": "symmetry", "bodies": "b", "b_lower": "0,0,0", "b_upper": "8,8,8", "max_steps": 20,
         "frames": 0}
BALL = {"indenter": "sphere", "indenter_radius": 10, "indenter_tip": "0,0,8", "indenter_times": 0, "indenter_velocities": 0.5}


def test_ranks(expect):
    """Quartz, as it comes, on two levels: the same history on any number of ranks, and from a checkpoint."""
    case = {**SPACE, **material(QUARTZ, euler_angles=(20, 40, 10)), **BALL, "levels": 2, "level_1_lower": "0,0,4", "level_1_upper": "4,4,10",
            "checkpoint_interval": 10}
    whole = harness.run(case)
    begun = {"restart": whole.folder / "checkpoint_000010.h5"}
    for name, ranks, more in (("2 ranks", 2, {}), ("3 ranks", 3, {}), ("a restart", 1, begun), ("a restart on 2 ranks", 2, begun)):
        difference, column = largest_difference(harness.run({**case, **more}, ranks=ranks).history, whole.history)
        expect(f"{name}: history (worst column {column})", difference, at_most=SAME)


def test_euler_angles(expect):
    """Bunge's angles are the plane and the direction that their matrix has as columns. Seen: history 4e-14, energy 1.6e-2."""
    def turn(degrees, axis):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        return numpy.array([[c, s, 0], [-s, c, 0], [0, 0, 1]] if axis == "z" else [[1, 0, 0], [0, c, s], [0, -s, c]])
    angles = (20, 40, 10)
    to_crystal = turn(angles[2], "z") @ turn(angles[1], "x") @ turn(angles[0], "z")
    one = harness.run({**SPACE, **material(QUARTZ, euler_angles=angles), **BALL})
    other = harness.run({**SPACE, **material(QUARTZ, surface=to_crystal[:, 2], along=to_crystal[:, 0]), **BALL})
    difference, column = largest_difference(other.history, one.history)
    expect(f"history (worst column {column})", difference, at_most=SAME)
    history = one.history
    kept = sum(history[name][-1] for name in ("kinetic_energy", "strain_energy", "dissipated_energy"))
    expect("energy, of the work", kept / history["indenter_work"][-1], near=1, tolerance=0.03)


def test_warnings(expect):
    cases = {"constants in GPa": ({"m_elastic_constants": "165.7,63.9,79.6"}, "are they in Pa?"),
             "no mirror": ({**BALL, "m_surface": "1,1,1", "m_along": "1,-1,0"}, "-boundary_y_lower: a side of symmetry under the tip"),
             "mirrors": ({**BALL, "m_surface": "0,1,1"}, None)}
    for name, (changes, words) in cases.items():
        error = harness.run({**SPACE, **material(SILICON), **changes}).stderr
        expect.that(name, words in error if words else "no mirror of the crystal" not in error, error)


def test_refusals(expect):
    plane = {"domain_lower": "0,0", "domain_upper": "8,10", "b_lower": "0,0", "b_upper": "8,8", "boundary_z_lower": None, "geometry": "plane_strain"}
    expect_refused(expect, Table({**SPACE, **material(SILICON)}, [
        ("no constants", {"m_elastic_constants": None}, ["-m_elastic_constants", "given"]),
        ("four constants", {"m_elastic_constants": "1e9,1e9,1e9,1e9"}, ["-m_elastic_constants 4 values", "5 (hexagonal)"]),
        ("not stable", {"m_elastic_constants": "100e9,110e9,50e9"}, ["positive definite", "smallest eigenvalue is -1e+10"]),
        ("Young's modulus too", {"m_youngs_modulus": "1e9"}, ["-m_youngs_modulus"]),
        ("constants of an isotropic law", {"m_model": "neo_hookean", "m_youngs_modulus": "1e9", "m_poissons_ratio": 0.3}, ["-m_elastic_constants"]),
        ("plane without a normal", {"m_surface": "0,0,0"}, ["-m_surface 0,0,0", "indices are 0"]),
        ("direction out of the plane", {"m_surface": "1,1,1"}, ["-m_along 1,0,0", "-m_surface 1,1,1", "54.74"]),
        ("two indices", {"m_surface": "1,1"}, ["-m_surface"]),
        ("angles and a plane", {"m_euler_angles": "0,0,0", "m_surface": "0,0,1"}, ["-m_euler_angles", "left out with -m_surface"]),
        ("plane strain without a mirror", {**plane, "m_surface": "1,1,1", "m_along": "1,-1,0"}, ["-m_surface", "C14 is", "mirror", "3d"]),
        ("cubic about an axis", {**plane, "geometry": "axisymmetric"}, ["-m_surface", "C11 - C13 - 2 C55", "c axis"]),
        ("zinc on its side about an axis", {**plane, "geometry": "axisymmetric", **material(ZINC, surface=(1, 0, 0), along=(0, 1, 0))},
         ["-m_surface 1,0,0", "c axis"]),
    ]))


def verify_zinc(study):
    """Indentation modulus of zinc

    A flat punch on the basal plane in axisymmetry, 8 of the finest cells in its radius, block of 128 radii: P/(2 a h) against the formula of
    Delafargue and Ulm, and against the same of an isotropic block.
    """
    block = round_punch(isotropic(110, 0.25), 128) / analytic.plane_strain_modulus(110, 0.25)
    zinc = round_punch(ZINC, 128) / analytic.hexagonal_indentation_modulus(*ZINC)
    study.expect("isotropic, of E/(1 - nu^2)", block, near=1, tolerance=0.01)
    study.expect("zinc, of its modulus", zinc, near=1, tolerance=0.01)
    study.expect("zinc over isotropic", zinc / block, near=1, tolerance=0.003)


def verify_silicon(study):
    """Indentation modulus of silicon and copper

    A quarter of a flat punch, on (111) a half, in space, 8 of the finest cells in its radius, on blocks of 16 and 32 radii on rollers, whose
    compliances P/(2 a h) give that of a half space; against the integral of Barnett and Lothe, and against the same of an isotropic block.
    """
    *_, block = on_half_space(isotropic(160, 0.22))
    block /= analytic.plane_strain_modulus(160, 0.22)
    study.expect("isotropic, of E/(1 - nu^2)", block, near=1, tolerance=0.015)
    for name, constants, planes in (("silicon", SILICON, ("001", "011", "111")), ("copper", COPPER, ("001", "111"))):
        tensor, found = analytic.stiffness_tensor(constants), {}
        for plane in planes:
            surface, along = SURFACES[plane]
            exact = analytic.indentation_modulus(tensor, surface)
            small, large, whole = on_half_space(constants, half=plane == "111", surface=surface, along=along)
            found[plane] = whole / exact
            study.figure(f"{name} ({plane}): {exact:.2f} GPa; on 16 radii", small / exact)
            study.figure(f"{name} ({plane}): on 32 radii", large / exact)
            study.expect(f"{name} ({plane}): half space", found[plane], near=1, tolerance=0.015)
            study.expect(f"{name} ({plane}): over isotropic", found[plane] / block, near=1, tolerance=0.005)
        study.expect(f"{name}: (111) over (001), of that of the moduli", found["111"] / found["001"], near=1, tolerance=0.005)
