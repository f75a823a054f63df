"""Elastic bodies under an indenter for long: contact gives what the indenter does, and points make no noise of it."""
import numpy
import pytest

import harness
from analytic import lame_constants

E, NU, RHO = 70e9, 0.33, 2700
SOLID = {"materials": "m", "m_youngs_modulus": E, "m_poissons_ratio": NU, "m_density": RHO, "bodies": "b", "boundary_y_lower": "symmetry",
         "frames": 0}
# A bar pressed by a wide plate at a hundredth of the speed at which waves cross it, to 3 %: 150 crossings.
BAR = {**SOLID, "domain_lower": "0,0", "domain_upper": "16e-6,12e-6", "cell_size": 1e-6, "b_lower": "0,0", "b_upper": "8e-6,8e-6",
       "indenter": "flat_punch", "indenter_tip": "0,8e-6", "indenter_times": "0,20e-9", "indenter_velocities": "0,1", "end_time": 250e-9}
BARS = {
    "axisymmetric": {"geometry": "axisymmetric", "indenter_radius": 16e-6},
    "nine points a cell": {"geometry": "axisymmetric", "indenter_radius": 16e-6, "b_points_per_cell": 3},
    "hypoelastic, plane strain": {"boundary_x_lower": "symmetry", "indenter_width": 32e-6, "m_model": "hypoelastic"},
}


def given(history):
    """Work of contact and friction over that of the indenter."""
    return (harness.given_by_contact(history)[-1] + history["friction_work"][-1]) / history["indenter_work"][-1]


def uniaxial_stress(strain):
    """Nominal stress of a neo-Hookean bar, sigma = (mu (b - I) + lambda ln J I)/J, that may widen freely, Pa."""
    lam, mu = lame_constants(E, NU)
    wide = 1 + NU * strain  # lateral stretch without lateral stress, by Newton's method
    for _ in range(20):
        force = mu * (wide**2 - 1) + lam * numpy.log(wide**2 * (1 - strain))
        wide -= force / (2 * mu * wide + 2 * lam / wide)
    return (mu * ((1 - strain)**2 - 1) + lam * numpy.log(wide**2 * (1 - strain))) / (1 - strain)


@pytest.mark.parametrize("name", BARS)
def test_bar_under_a_plate(expect, name):
    """Noise once doubled every ten crossings, until contact gave two to five times what the indenter did. Seen: work 5e-6, noise 2e-7, load 3e-4."""
    history = harness.run({**BAR, **BARS[name]}).history
    expect(f"{name}: work of contact over that of the indenter", given(history), near=1, tolerance=5e-3)
    expect(f"{name}: noise over that work", history["noise_energy"][-1] / history["indenter_work"][-1], at_most=1e-3)
    if name == "axisymmetric":
        last = history["time"] > 0.8 * history["time"][-1]
        exact = -uniaxial_stress(history["depth"] / 8e-6) * numpy.pi * 8e-6**2
        expect(f"{name}: load over that of the law, mean of the last fifth", numpy.mean(history["load"][last] / exact[last]), near=1, tolerance=2e-3)


def test_punch_deeper_than_half_a_cell(expect):
    """The surface beside the punch, with its gap to the punch's side, once held the column of the edge open and let it go in blows. Seen: work 7e-3,
    load at rest 2e-3, load over depth 5e-3."""
    history = harness.run({
        **SOLID, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "32e-6,36e-6", "cell_size": 1e-6, "b_lower": "0,0",
        "b_upper": "32e-6,32e-6", "boundary_x_upper": "symmetry", "indenter": "flat_punch", "indenter_radius": 4e-6, "indenter_tip": "0,32e-6",
        "indenter_times": "0,10e-9,110e-9,120e-9", "indenter_velocities": "0,4.54545,4.54545,0", "damping": 1e8, "end_time": 160e-9}).history
    held = history["load"][history["time"] > 130e-9]
    per_depth = history["load"][1:] / history["depth"][1:]
    early = per_depth[numpy.argmin(numpy.abs(history["depth"][1:] - 200e-9))]
    expect("work of contact over that of the indenter", given(history), near=1, tolerance=0.01)
    expect("load while the punch rests, largest change", numpy.ptp(held) / numpy.mean(held), at_most=0.02)
    expect("load over depth at rest, of that at a fifth of a cell", per_depth[-1] / early, near=1, tolerance=0.05)


def test_plate_that_slides_on_a_bar(expect):
    """All of the plate slips, so that friction is mu times the load: a third of it was once missing, as columns let go in turns. Seen: friction
    3e-13, work 8e-5."""
    history = harness.run({
        **SOLID, "domain_lower": "0,0", "domain_upper": "56e-6,8e-6", "cell_size": 1e-6, "boundary_y_lower": "fixed", "b_lower": "8e-6,0",
        "b_upper": "40e-6,4e-6", "indenter": "flat_punch", "indenter_width": 100e-6, "indenter_tip": "24e-6,4e-6", "indenter_friction": 0.3,
        "indenter_control": "load", "indenter_times": "0,20e-9,40e-9,250e-9", "indenter_loads": "0,6400,6400,6400",
        "indenter_velocities_x": "0,0,10,10", "end_time": 250e-9}).history
    last = history["time"] > 0.5 * history["time"][-1]
    expect("friction over mu times the load, largest difference", numpy.max(numpy.abs(history["friction_force"][last] / (0.3 * history["load"][last]) - 1)),
           at_most=1e-3)
    expect("work of contact and friction over that of the indenter", given(history), near=1, tolerance=0.01)


# ---- surfaces on a line of nodes, and nodes of little mass ----

# Held at its sides and pressed by a plate; in um.
CONFINED = {**SOLID, "cell_size": 1e-6, "b_lower": "0,0", "boundary_x_upper": "symmetry", "indenter": "flat_punch", "damping": 3e8,
            "indenter_times": "0,5e-9,50e-9,55e-9", "indenter_velocities": "0,20,20,0", "end_time": 115e-9}
PLANE = {"boundary_x_lower": "symmetry", "indenter_width": 80e-6}
ROUND = {"geometry": "axisymmetric", "indenter_radius": 80e-6}


def confined_stress(stretch):
    """Cauchy stress of a neo-Hookean solid that may not widen, Pa."""
    lam, mu = lame_constants(E, NU)
    return (mu * (stretch**2 - 1) + lam * numpy.log(stretch)) / stretch


@pytest.mark.parametrize("more", [PLANE, {**PLANE, "cfl": 0.2}, {**PLANE, "stress_update": "usl"}, ROUND, {**PLANE, "m_volume_average": "true"},
                                  {**PLANE, "xpic_fraction": 0.05}],
                         ids=("plane", "short steps", "usl", "round", "volume average", "xpic"))
@pytest.mark.parametrize("top, speed", [(12, 20), (11.5, 10)])
def test_surface_that_comes_to_rest_on_a_line(expect, more, top, speed):
    """Its last two layers of points once split: loads of 0.4 to 1.5 of the right one, and a third more energy than work. Seen: load 2e-5, stress of
    points 4e-3, work and energy 1.7e-3."""
    case = {**CONFINED, **more, "domain_lower": "0,0", "domain_upper": "12e-6,15e-6", "b_upper": f"12e-6,{top}e-6", "indenter_tip": f"0,{top}e-6",
            "indenter_velocities": f"0,{speed},{speed},0", "frames": 1}
    result = harness.run(case)
    history, stress = result.history, result.frame()["stress"][:, 1]
    exact = confined_stress(1 - history["depth"][-1] / (1e-6 * top))
    area = 12e-6 if "indenter_width" in more else numpy.pi * 12e-6**2
    rest = history["load"][history["time"] > 90e-9] / (-exact * area)
    expect("load at rest over that of the law, least", rest.min(), near=1, tolerance=3e-3)
    expect("load at rest over that of the law, largest", rest.max(), near=1, tolerance=3e-3)
    expect("stress of points, largest error", numpy.max(numpy.abs(stress / exact - 1)), at_most=0.01)
    expect("work of contact over that of the indenter", given(history), near=1, tolerance=5e-3)
    energy = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    expect("energy over work", energy[-1] / history["indenter_work"][-1], near=1, tolerance=5e-3)


@pytest.mark.parametrize("more", [{"indenter_width": 12e-6}, {"geometry": "axisymmetric", "indenter_radius": 6e-6}], ids=("plane", "round"))
def test_slow_pillar_that_comes_to_rest_on_a_line(expect, more):
    """XPIC, which slow tests have, once strained its points by what light nodes hold back: a sixth of the load came and went at rest. Seen: load
    3e-4, energy 1.2e-3."""
    history = harness.run({**SOLID, **more, "boundary_x_lower": "symmetry", "domain_lower": "0,0", "domain_upper": "10e-6,14e-6", "cell_size": 1e-6, "b_lower": "0,0",
                           "b_upper": "4e-6,10e-6", "indenter": "flat_punch", "indenter_tip": "0,10e-6", "quasi_static": "true",
                           "indenter_depths": 1e-6, "frames": 0}).history
    rest = history["load"][history["depth"] > 1e-6 * (1 - 1e-9)]
    expect("load at rest, largest change", numpy.max(numpy.abs(rest / rest[0] - 1)), at_most=5e-3)
    energy = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    expect("energy over work", energy[-1] / history["indenter_work"][-1], near=1, tolerance=5e-3)


@pytest.mark.parametrize("damping", [3e8, 3e7])
def test_work_of_tractions_on_a_surface_near_a_line(expect, damping):
    """Of nodes that hardly any point feels: it once went on at rest, to half of all work. Seen: 5e-4."""
    history = harness.run({
        **{name: value for name, value in CONFINED.items() if not name.startswith("indenter")}, "boundary_x_lower": "symmetry", "domain_lower": "0,0",
        "domain_upper": "12e-6,15e-6", "b_upper": "12e-6,12.25e-6", "loads": "q", "q_side": "y_upper", "q_times": "0,15e-9",
        "q_pressures": "0,2160553683.93", "end_time": 100e-9, "damping": damping}).history
    energy = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    expect("energy over work", energy[-1] / history["external_work"][-1], near=1, tolerance=2e-3)


def test_ball_on_a_nearly_incompressible_body(expect):
    """Single rows once had 0.3 to 8 times the load; the volume average, which damps what a cell's points do alone, has none of that. Seen: loads
    within 2 %, peaks within 1 %."""
    ball = {**SOLID, "m_poissons_ratio": 0.49, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "12e-6,13e-6", "cell_size": 0.5e-6,
            "boundary_x_upper": "symmetry", "b_lower": "0,0", "b_upper": "12e-6,10e-6", "indenter": "sphere", "indenter_radius": 20e-6,
            "indenter_tip": "0,10e-6", "indenter_times": "0,5e-9", "indenter_velocities": "0,30", "indenter_max_depth": 1.5e-6, "damping": 1e8, "cfl": 0.2}
    own, mean = (harness.run({**ball, "m_volume_average": average}).history for average in ("false", "true"))
    deep = own["depth"] > 0.3e-6
    ratio = own["load"][deep] / numpy.interp(own["depth"][deep], mean["depth"], mean["load"])
    peak = own["peak_pressure"][deep] / numpy.interp(own["depth"][deep], mean["depth"], mean["peak_pressure"])
    expect("load over that with the volume average, least", ratio.min(), at_least=0.9)
    expect("load over that with the volume average, largest", ratio.max(), at_most=1.1)
    expect("peak pressure likewise", peak.max(), at_most=1.1)


@pytest.mark.parametrize("ranks", [1, pytest.param(3, marks=pytest.mark.mpi)])
@pytest.mark.parametrize("ratio", [2, 3])
def test_metal_whose_surface_meets_a_line_across_a_border(expect, ranks, ratio):
    """Nodes of little mass there once made the work twice in the rest that follows. Seen: load 3e-5,
    energy 2.4e-3."""
    metal = {"m_model": "j2", "m_yield_stress": 400e6, "m_hardening_modulus": 2e9}
    case = {**CONFINED, **PLANE, **metal, "domain_lower": "0,0", "domain_upper": "12e-6,15e-6", "b_upper": "12e-6,12.25e-6",
            "indenter_tip": "0,12.25e-6", "indenter_times": "0,5e-9,12.25e-9,17.25e-9", "end_time": 72e-9, "levels": 2, "refinement_ratio": ratio,
            "level_1_lower": "6e-6,6e-6", "level_1_upper": "12e-6,15e-6"}
    history = harness.run(case, ranks=ranks).history
    one = harness.run_once({name: value for name, value in case.items() if not name.startswith(("level", "refinement"))}).history
    rest = history["time"] > 60e-9
    expect("load at rest over that on one level", numpy.mean(history["load"][rest]) / one["load"][-1], near=1, tolerance=0.005)
    energy = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    expect("energy over work", energy[-1] / history["indenter_work"][-1], near=1, tolerance=0.005)


# A ridge two cells high on a block, and in space a pillar, under a punch that is wider.
RIDGE = {"cell_size": 1, "domain_lower": "-12,0", "domain_upper": "12,18", "boundary_x_lower": "symmetry", "boundary_x_upper": "symmetry",
         "boundary_y_lower": "symmetry", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block,ridge",
         "block_lower": "-12,0", "block_upper": "12,12", "indenter": "flat_punch", "indenter_width": 12, "indenter_times": 0,
         "indenter_velocities": 2e-3, "indenter_max_depth": 0.2, "damping": 0.1, "frames": 0, "history_interval": 10}
PILLAR = {**RIDGE, "geometry": "3d", "domain_lower": "-6,-6,0", "domain_upper": "6,6,12", "boundary_z_lower": "symmetry", "block_lower": "-6,-6,0",
          "block_upper": "6,6,6", "indenter_width": None, "indenter_radius": 5, "block_points_per_cell": 1, "ridge_points_per_cell": 1}


def test_ridge(expect):
    """The foot of a step is in the columns of its edge, and must not let go of them: half a cell beside the lines there was no load at all. Seen:
    load 1.3 %, area 1.7 %."""
    def pressed(half, middle, **more):
        return harness.run({**RIDGE, "ridge_lower": (middle - half, 12), "ridge_upper": (middle + half, 14), "indenter_tip": (middle, 14), **more}).history
    for half in (1, 2):
        fine = pressed(half, 0.0, cell_size=0.5)
        for middle in (0.0, 0.25, 0.5):
            history = pressed(half, middle)
            expect(f"ridge of {2 * half} cells at {middle}: load over that on cells half as large", history["load"][-1] / fine["load"][-1], near=1, tolerance=0.05)
            expect(f"ridge of {2 * half} cells at {middle}: area of contact, of its width", history["contact_area"][-1] / (2 * half), near=1, tolerance=0.03)


def test_pillar(expect):
    """Seen: area 2.7 %, load 3e-4."""
    loads = []
    for middle in (0.0, 0.5):
        ends = {"ridge_lower": (middle - 2, middle - 2, 6), "ridge_upper": (middle + 2, middle + 2, 8), "indenter_tip": (middle, middle, 8)}
        history = harness.run({name: value for name, value in {**PILLAR, **ends}.items() if value is not None}).history
        loads.append(history["load"][-1])
        expect(f"pillar at {middle}: area of contact, of that of 16 cells", history["contact_area"][-1] / 16, near=1, tolerance=0.06)
    expect("load half a cell beside, of that on the lines", loads[1] / loads[0], near=1, tolerance=0.03)


HOLE = {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "12,14", "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry",
        "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block", "block_lower": "3,0", "block_upper": "12,10",
        "indenter": "sphere", "indenter_radius": 20, "indenter_tip": "0,9.8", "quasi_static": "true", "quasi_static_tolerance": 0.03, "frames": 0}


def test_rim_of_a_hole(expect):
    """A ball on the edge of a hole: the hole's wall, with its gaps, must not hold the column of the edge open. With it the load at 0.1 was less than
    half on cells of 0.5. Seen: 1.7 % and 1.1 %, within the quasi-static tolerance of 3 %."""
    touch = 20 - (20**2 - 3**2)**0.5  # depth of the tip below the surface when the ball is on the rim
    runs = [harness.run({**HOLE, "indenter_depths": touch + 0.2, "cell_size": cell}) for cell in (0.5, 0.25)]
    for deep, limit in ((0.1, 0.08), (0.19, 0.05)):
        coarse, fine = (numpy.interp(touch + deep, *(run.history[name][:numpy.argmax(run.history["depth"])] for name in ("depth", "load_quasi_static")))
                        for run in runs)
        expect(f"load {deep} below the touch over that on cells half as large", coarse / fine, near=1, tolerance=limit)
    expect("penetration, cells", runs[0].history["penetration"].max(), at_most=0.05)


PUNCH = {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "24,26", "cell_size": 1, "boundary_y_lower": "symmetry",
         "boundary_x_upper": "symmetry", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block",
         "block_lower": "0,0", "block_upper": "24,24", "indenter": "flat_punch", "indenter_tip": "0,24", "quasi_static": "true", "indenter_depths": 1,
         "quasi_static_tolerance": 0.1, "frames": 0}
YIELDS = {"m_model": "j2", "m_yield_stress": 0.006, "m_hardening_modulus": 0.014}


@pytest.mark.parametrize("radius", [8, 8.4, 8.6])
@pytest.mark.parametrize("law, limit", [("elastic", 0.02), ("metal", 0.06)])
def test_area_under_a_flat_punch(expect, radius, law, limit):
    """The column beside that of the edge carries nothing, with a gap that grows with depth: without it a fifth of the area was missing. Seen: 0.7 % elastic, 2.3 % of the metal."""
    history = harness.run({**PUNCH, "indenter_radius": radius, **(YIELDS if law == "metal" else {})}).history
    area = history["contact_area"][history["depth"] > 0.1] / (numpy.pi * radius**2)
    error = numpy.quantile(numpy.abs(area - 1), 0.99)  # in single rows the load passes from column to column
    expect(f"{law}, radius {radius} cells: area of contact, error of all but a hundredth of the rows", error, at_most=limit)
