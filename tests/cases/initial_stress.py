"""Bodies with a stress at the start: they rest, and indentation of elastic bodies hardly knows of it; nor does the hardness of metals."""
import math

import numpy
import pytest

import hardness
import harness
from refusals import Table, expect_refused
from ranks import SAME, largest_difference

PLANE = {"domain_lower": "0,0", "domain_upper": "16,12", "cell_size": 1, "boundary_x_lower": "symmetry", "boundary_x_upper": "symmetry",
         "boundary_y_lower": "symmetry", "bodies": "b", "b_lower": "0,0", "b_upper": "16,10.3", "materials": "m", "m_density": 1,
         "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "max_steps": 200, "frames": 1, "history_interval": 10}
ROUND = {**PLANE, "geometry": "axisymmetric"}
SPACE = {**PLANE, "geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "8,8,10", "boundary_y_upper": "symmetry",
         "boundary_z_lower": "symmetry", "b_lower": "0,0,0", "b_upper": "8,8,7.7"}
METAL = {"m_model": "j2", "m_yield_stress": 0.2, "m_hardening_modulus": 0}
ZINC = {"m_model": "anisotropic", "m_elastic_constants": [1.637, 0.364, 0.53, 0.635, 0.388], "m_youngs_modulus": None, "m_poissons_ratio": None}
LEVELS = {"levels": 2, "level_1_lower": "0,4", "level_1_upper": "8,12", "b_upper": "16,10"}
FILM = {"bodies": "b,s", "b_lower": "0,7.3", "s_lower": "0,0", "s_upper": "16,7.3"}


def only(options):
    return {name: value for name, value in options.items() if value is not None}


def expect_rest(expect, name, case, wanted, ranks=1):
    """Stress as asked, which stays; energy of a point as its law has it."""
    result = harness.run(only(case), ranks=ranks)
    history, first, last = result.history, result.frame(0), result.frame()
    body = first["body"] == 0
    scale = numpy.nanmax(numpy.abs(wanted))
    asked = [component for component, value in enumerate(wanted) if math.isfinite(value)]
    expect(f"{name}: stress at the start", numpy.max(numpy.abs(first["stress"][body][:, asked] - numpy.array(wanted)[asked])) / scale, at_most=1e-13)
    expect(f"{name}: change of the stress", numpy.max(numpy.abs(last["stress"][body] - first["stress"][body])) / scale, at_most=1e-12)
    expect(f"{name}: kinetic energy, of the strain energy", numpy.max(history["kinetic_energy"]) / history["strain_energy"][0], at_most=1e-24)
    expect(f"{name}: change of the strain energy", numpy.ptp(history["strain_energy"]) / history["strain_energy"][0], at_most=1e-13)
    expect.that(f"{name}: no warning", not result.stderr.strip(), result.stderr.strip()[:200])
    return history["strain_energy"][0]


@pytest.mark.parametrize("law", ["neo_hookean", "st_venant_kirchhoff", "hypoelastic", "linear", "j2"])
def test_rest(expect, law):
    """Seen: stress 8e-14, kinetic energy 2e-28, strain energy 8e-15."""
    material = METAL if law == "j2" else {"m_model": law}
    stress = {"b_initial_stress": "-0.01,0"}
    energy = expect_rest(expect, f"{law} in the plane", {**PLANE, **material, **stress}, [-0.01, 0, numpy.nan, 0])
    strain = 0.01**2 * (1 - 0.3**2) / 2 * 16 * 10.3  # of Hooke's law, less than the law's by a part of the strain
    expect(f"{law}: strain energy, of Hooke's law", energy / strain, near=1, tolerance=0.04)
    expect_rest(expect, f"{law} about an axis", {**ROUND, **material, **stress}, [-0.01, 0, -0.01, 0])
    expect_rest(expect, f"{law} in space", {**SPACE, **material, "b_initial_stress": "-0.05,0.03,0"}, [-0.05, 0.03, 0, 0, 0, 0])


def test_rest_of_others(expect):
    """A metal with any stress along z in plane strain, a crystal, a film on a body without stress, and levels on three ranks."""
    expect_rest(expect, "metal with zz", {**PLANE, **METAL, "b_initial_stress": "-0.05,0,0.06"}, [-0.05, 0, 0.06, 0])
    expect_rest(expect, "zinc", {**SPACE, **ZINC, "m_density": 1e9, "m_elastic_constants": [1e9 * c for c in ZINC["m_elastic_constants"]],
                                 "b_initial_stress": "-0.5e8,0.3e8,0"}, [-0.5e8, 0.3e8, 0, 0, 0, 0])
    expect_rest(expect, "film", {**ROUND, **FILM, "b_initial_stress": "0.05,0"}, [0.05, 0, 0.05, 0])
    expect_rest(expect, "levels", {**ROUND, **LEVELS, "b_initial_stress": "-0.05,0"}, [-0.05, 0, -0.05, 0], ranks=harness.up_to(2))


def test_warning(expect):
    """The stress across a side that nothing holds."""
    for name, case in {"free top": {"b_initial_stress": "-0.05,0.01"}, "free side": {"b_initial_stress": "-0.05,0", "b_upper": "12,10"}}.items():
        result = harness.run({**PLANE, **case, "max_steps": 1})
        expect.that(f"{name}: a warning", "b_initial_stress: nothing holds the side" in result.stderr, result.stderr)


def test_refusals(expect):
    given = {**PLANE, "m_youngs_modulus": 1e9, "b_initial_stress": "-1e6,0"}
    expect_refused(expect, Table(given, [
        ("one value", {"b_initial_stress": "1e6"}, ["-b_initial_stress"]),
        ("two in space", {**SPACE, "m_youngs_modulus": 1e9}, ["-b_initial_stress 2 values", "3 values in -geometry 3d"]),
        ("another hoop stress", {"geometry": "axisymmetric", "b_initial_stress": "1e6,0,0"}, ["with zz = xx"]),
        ("another zz in plane strain", {"b_initial_stress": "1e6,0,0"}, ["must be with zz = 299773.8", "plane strain"]),
        ("beyond yield", {**METAL, "m_yield_stress": 0.5e6}, ["must be within yield", "Mises", "5e+05"]),
        ("more than the law has", {"m_model": "st_venant_kirchhoff", "b_initial_stress": "-1e10,0"}, ["a stress that the law"]),
        ("a crystal that would shear", {**SPACE, **ZINC, "m_elastic_constants": "165e9,64e9,80e9", "m_surface": "1,1,1", "m_along": "1,-1,0",
                                        "b_initial_stress": "1e6,2e6,0"}, ["without shear", "crystal"]),
    ]))


def test_elastic_load(expect):
    """A sphere on an elastic block with a stress of a thousandth of Young's modulus, which is a tenth of a metal's yield stress. Seen: 4e-5,
    energy 1e-3 as without a stress."""
    loads = []
    for stress in (0, -70e6):
        history = harness.run({"frames": 0, **({"block_initial_stress": [float(stress), 0.0]} if stress else {})}, file="sphere_axisymmetric.opts").history
        late = history["time"] > 100e-9
        loads.append(numpy.mean(history["load"][late]))
        stored = history["strain_energy"] - history["strain_energy"][0]
        expect(f"{stress:g} Pa: energy, of the work", (history["kinetic_energy"] + stored + history["dissipated_energy"])[-1] / history["indenter_work"][-1],
               near=1, tolerance=0.003)
    expect("load, of that without", loads[1] / loads[0], near=1, tolerance=0.0005)


def test_restart(expect):
    """A run goes on from its checkpoint, on other ranks too."""
    case = {**only({**ROUND, **METAL}), "b_initial_stress": "-0.1,0", "indenter": "sphere", "indenter_radius": 20, "indenter_tip": "0,10.3",
            "indenter_times": 0, "indenter_velocities": 0.02, "max_steps": 60, "checkpoint_interval": 30}
    whole = harness.run(case)
    for ranks in (1, 2):
        result = harness.run({**case, "restart": whole.folder / "checkpoint_000030.h5"}, ranks=ranks)
        difference, column = largest_difference(result.history, whole.history)
        expect(f"on {ranks} ranks: history (worst column {column})", difference, at_most=SAME)


E, YIELD = 82.1e9, 425.5e6  # aluminium alloy 8009 of Tsui, Oliver and Pharr (1996)


def true_hardness(share, cells, speed):
    """Mean of load over contact area in the last third, and of the area over that of the cone at the surface; share: stress, of the yield stress."""
    case, wave_speed, _ = hardness.block(E, YIELD, 0, 70.3, cells)
    down = speed * wave_speed
    times = [part * hardness.DEPTH / down for part in (0, 0.15, 1, 1.15)]
    stress = {"b_initial_stress": [share * YIELD, 0.0]} if share else {}
    history = harness.run({**case, **stress, "indenter_times": times, "indenter_velocities": [0, down, down, 0], "end_time": times[-1]}).history
    depth, load, area = history["depth"], history["load"], history["contact_area"]
    rows = (depth > 0.7 * hardness.DEPTH) & (depth < 0.99 * hardness.DEPTH)
    return (numpy.mean(load[rows] / area[rows]),
            numpy.mean(area[rows] / (numpy.pi * (depth[rows] * math.tan(math.radians(70.3)))**2)))


def test_hardness(expect):
    """On six cells. Seen: 4e-3; area 1.09."""
    plain, area = true_hardness(0, 6, 8e-4)
    pressed, pile = true_hardness(-0.6, 6, 8e-4)
    expect("true hardness, of that without", pressed / plain, near=1, tolerance=0.02)
    expect("area, of that without: more pile-up", pile / area, near=1.09, tolerance=0.04)


def verify_initial_stress(study):
    """Hardness of a metal with a stress

    A cone of 70.3 degrees in a metal with E/sy = 193 and a uniform stress up to 0.6 sy along the surface, 12 of the finest cells in the contact's
    radius. Load over true contact area does not depend on the stress, by experiments and finite elements of an aluminium alloy (Tsui, Oliver and
    Pharr 1996; Bolshakov, Oliver and Pharr 1996); piles up more under compression, which an area from the depth does not see.
    """
    plain, area = true_hardness(0, 12, 4e-4)
    study.figure("true hardness without a stress, of the yield stress", plain / YIELD)
    for share in (-0.6, -0.3, 0.3, 0.6):
        pressed, pile = true_hardness(share, 12, 4e-4)
        study.expect(f"stress {share:g} sy: true hardness, of that without", pressed / plain, near=1, tolerance=0.02)
        study.figure(f"stress {share:g} sy: contact area, of that without", pile / area)
