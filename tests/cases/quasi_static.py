"""Slow tests: the load does not depend on the speed by more than the tolerance, and what is chosen is in the summary; a choice of the user is kept, and refused where it cannot be."""
import numpy
import pytest

import harness
import metals
from mlgimp import load_depth, oliver_pharr
from ranks import largest_difference
from restart import rows_after

# Lengths in cells, E = 1: a cone on a block of 16 x 16, through which waves need 14 to 17.
CONE = {
    "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "16,18", "cell_size": 1, "boundary_x_upper": "symmetry",
    "boundary_y_lower": "symmetry", "materials": "m", "m_youngs_modulus": 1, "m_poissons_ratio": 0.3, "m_density": 1, "bodies": "block",
    "block_lower": "0,0", "block_upper": "16,16", "indenter": "cone", "indenter_half_angle": 80, "indenter_tip": "0,16", "frames": 0,
    "quasi_static": "true", "indenter_depths": "0.9,0"}
METAL = {"m_model": "j2", "m_yield_stress": 0.01, "m_hardening_modulus": 0.1, "indenter_depths": "0.6,0.5"}
CASES = {"elastic": CONE, "metal": {**CONE, **METAL}}


@pytest.mark.parametrize("poisson, levels, speed, xpic", [(0.3, 1, (1.3 * 0.4 / 0.7) ** -0.5, 0.02), (0.499, 1, (6 / 2.998) ** 0.5, 0.02),
                                                          (0.499, 2, (6 / 2.998) ** 0.5, 0.05), (0.39, 2, 1.4124, 0.02)])
def test_what_is_chosen_for_a_poissons_ratio(expect, poisson, levels, speed, xpic):
    """Times by waves of pressure, of 1.16 at 0.3; of nearly incompressible bodies by sqrt(6) times those of shear."""
    nested = {"levels": 2, "level_1_lower": "0,8", "level_1_upper": "8,18"} if levels == 2 else {}
    plan = harness.run({**CONE, **nested, "m_poissons_ratio": poisson, "max_steps": 1}).summary["quasi_static"]
    expect("speed of the waves of the plan", plan["distance"] / plan["transit"], near=speed, tolerance=1e-3)
    expect("share of XPIC", plan["xpic_fraction"], near=xpic, tolerance=1e-12)


def parts(history):
    """(last row of the loading, last row of the hold)."""
    resting = numpy.flatnonzero(history["depth"] > history["depth"].max() * (1 - 1e-9))
    return resting[0], resting[-1]


def loading(history, column, shares):
    """The load at shares of the largest depth, by parabolas over a tenth of it."""
    deepest, last = history["depth"].max(), parts(history)[0]
    depth, load = history.beside(column, "depth")[:last] / deepest, history[column][:last]
    near = [abs(depth - share) < 0.05 for share in shares]
    return numpy.array([numpy.polyfit(depth[rows] - share, load[rows], 2)[-1] for rows, share in zip(near, shares)])


def unloading(history, column):
    """(load at the end of the hold, slope there): a parabola through it, over the rows from 97 to 50 % of it."""
    first, last = parts(history)
    held = numpy.mean(history[column][last - (last - first) // 3:last])
    depth, load = history.beside(column, "depth")[last:] - history["depth"][last], history[column][last:]
    rows = numpy.arange(numpy.argmax(load < 0.97 * held), numpy.argmax(load < 0.5 * held))
    x = depth[rows]
    return held, numpy.linalg.lstsq(numpy.stack([x, x**2], axis=1), load[rows] - held, rcond=None)[0][0]


def compare(expect, case, tolerance, factor, limits):
    """A run against one that is slower by a factor; limits of load, load less what inertia and damping add, load in the hold, and slope."""
    fast = harness.run({**case, "quasi_static_tolerance": tolerance})
    slow = harness.run({**case, "quasi_static_tolerance": tolerance / factor, "history_interval": 4})
    shares = numpy.linspace(0.25, 0.95, 8)
    exact = loading(slow.history, "load", shares)
    for column, limit in zip(("load", "load_quasi_static"), limits):
        error = loading(fast.history, column, shares) / exact - 1
        expect(f"{column}, largest difference from a run {factor} times slower", numpy.max(numpy.abs(error)), at_most=limit)
    (held, slope), (held_slow, slope_slow) = (unloading(run.history, "load_quasi_static") for run in (fast, slow))
    expect("load at the end of the hold, of that", held / held_slow, near=1, tolerance=limits[2])
    expect("slope of the unloading, of that", slope / slope_slow, near=1, tolerance=limits[3])
    return fast


def expect_half_speed(expect, case, tolerance):
    """Half the speed changes the load by less than the tolerance in the mean, and less than half of it in the hold; history of the slower run."""
    fast, slow = (harness.run({**case, "quasi_static_tolerance": each}).history for each in (tolerance, tolerance / 2))
    shares = numpy.linspace(0.25, 0.95, 15)
    for column in ("load", "load_quasi_static"):
        change = loading(fast, column, shares) / loading(slow, column, shares) - 1
        expect(f"{column}, mean change by half the speed", numpy.mean(numpy.abs(change)), at_most=tolerance)
    held = [numpy.mean(history["load"][slice(*parts(history))]) for history in (fast, slow)]
    expect("load in the hold, change", held[0] / held[1] - 1, near=0, tolerance=tolerance / 2)
    return slow


def press_of_tutorial():
    """The first case of the tutorial: an elastic block under a cylinder."""
    text = (harness.ROOT / "docs" / "tutorial.md").read_text()
    blocks = [part.partition("```")[0] for part in text.split("```opts press.opts\n")[1:3]]
    lines = [line.split() for block in blocks for line in block.splitlines() if line.startswith("-")]
    return {name[1:]: value for name, value in lines}


@pytest.mark.parametrize("name, limits", [("elastic", (0.02, 0.02, 0.005, 0.02)), ("metal", (0.02, 0.01, 0.01, 0.02))])
def test_ten_times_slower(expect, name, limits):
    """With a tolerance of 2 %. Limits of the load are that; the others what is seen, with room: elastic 8e-3, 6e-3, 1e-5, 4e-3; metal 2e-3, 2e-3,
    3e-3, 1.2 %; share 1.2 %, drift 1.3e-3."""
    fast = compare(expect, CASES[name], 0.02, 10, limits)
    chosen = fast.summary["quasi_static"]
    history = fast.history
    expect("speed in the summary, over that of the history", chosen["speed"] / numpy.max(numpy.gradient(history["depth"], history["time"])), near=1, tolerance=0.01)
    expect("largest share of inertia and damping in the load", chosen["added_load"], at_most=0.04)
    expect("drift in the hold", chosen["hold_drift"], at_most=0.01)


def test_tutorial(expect):
    """The tutorial's cylinder at half the speed. Limits are the tolerance of 2 %; seen 2e-3."""
    case = {**press_of_tutorial(), "quasi_static": "true", "frames": 0}
    expect_half_speed(expect, case, 0.02)


def test_turns_count(expect):
    """Three ways to the same turns, whatever the speeds, make the same run; depths go before a history."""
    ways = [{"indenter_depths": "0.4,0.3,0.6,0"}, {"indenter_depths": "0.4,0.3,0.6,0", "indenter_times": "0", "indenter_velocities": 3, "indenter_max_depth": 1},
            {"indenter_depths": None, "indenter_times": "0,1,1.5,2,3", "indenter_velocities": "0.8,0,-0.2,0,0.6", "indenter_max_depth": 0.6,
             "indenter_unload_velocity": 77}]
    plans = []
    for way in ways:
        case = {name: value for name, value in {**CONE, **way, "max_steps": 30}.items() if value is not None}
        plans.append(harness.run(case).summary["quasi_static"])
    for plan in plans[1:]:
        expect("end of the schedule", plan["end_time"] / plans[0]["end_time"], near=1, tolerance=1e-12)
    width = 0.6 * numpy.tan(numpy.radians(80))  # half of the contact's
    expect("transits", plans[0]["transits"], near=numpy.ceil(40 * numpy.sqrt(2 * width / 16)), tolerance=0)


def test_pace_follows_the_contact(expect):
    """Transits are as the square root of the contact's size over the body's, down to 8, where the body stands on a support. Where it bends, or the
    punch covers it, and in plane strain they are those of a body that moves as a whole; under a load the contact is no narrower than it gets."""
    def transits(**more):
        case = {name: value for name, value in {**CONE, "max_steps": 1, **more}.items() if value is not None}
        return harness.run(case).summary["quasi_static"]["transits"]

    tan = numpy.tan(numpy.radians(80))
    for depth, tolerance in ((0.9, 0.01), (0.3, 0.01), (0.3, 0.02), (0.03, 0.01)):
        wanted = max(8, numpy.ceil(0.4 / tolerance * numpy.sqrt(2 * depth * tan / 16)))
        expect(f"depth {depth}, tolerance {tolerance}", transits(indenter_depths=f"{depth},0", quasi_static_tolerance=tolerance), near=wanted, tolerance=0)
    blunt = {"indenter": "flat_punch", "indenter_half_angle": None, "indenter_radius": 12, "indenter_depths": "0.1,0"}
    ball = {"block_shape": "disk", "block_lower": None, "block_upper": None, "block_center": "0,8", "block_radius": 8, "indenter_depths": "0.1,0"}
    for name, more, wanted in (("free below", {"boundary_y_lower": "free"}, 40), ("above its support", {"block_lower": "0,1"}, 40), ("under a punch", blunt, 40),
                               ("a ball", ball, 40),
                               ("plane strain", OTHERS["plane strain"], 80)):
        expect(name, transits(**more), near=wanted, tolerance=0)
    expect("under a load", transits(**LOADS), at_least=numpy.ceil(40 * numpy.sqrt(2 * 0.6 * tan / 16)), at_most=40)


def test_schedule_in_the_history(expect):
    """A partial unloading: the tip turns at the depths that are given, its speed has no jump, and what acts on it is smooth. Seen: 6e-8, 2 %, 4e-4."""
    history = harness.run({**CONE, "indenter_depths": "0.4,0.3,0.6,0.5", "quasi_static_tolerance": 0.05}).history
    depth, time = history["depth"], history["time"]
    speed = numpy.diff(depth) / numpy.diff(time)
    for turn in (0.4, 0.3, 0.6, 0.5):
        expect(f"nearest the tip comes to rest to {turn}", numpy.min(abs(depth - turn)), at_most=1e-6)
    expect("largest change of speed in a step, of the largest speed", numpy.max(numpy.abs(numpy.diff(speed))) / speed.max(), at_most=0.06)
    expect("speed at the end, of the largest", abs(speed[-1]) / speed.max(), at_most=0.01)


LOADS = {"indenter_control": "load", "indenter_times": "0,1,2,3", "indenter_loads": "0,2.5,2.5,0.1", "indenter_depths": None}


def test_load_control(expect):
    """The same curve as under displacement control, and the same figures by Oliver and Pharr. Limits: a quarter of the tolerance of 2 % for the load,
    all of it for slopes. Seen: 1.1e-3, 2e-4, 5e-4."""
    case = {name: value for name, value in {**CONE, **LOADS, "quasi_static_tolerance": 0.02}.items() if value is not None}
    result = harness.run(case)
    held = result.history["depth"][parts(result.history)[1]]
    other = harness.run({**CONE, "indenter_depths": [float(held), 0.0], "quasi_static_tolerance": 0.02})
    by_load, by_depth = (oliver_pharr.analyse(load_depth.read_run(run.folder))[0] for run in (result, other))
    expect("load of the hold", by_load["load_mN"] / by_depth["load_mN"], near=1, tolerance=0.005)
    expect("stiffness", by_load["stiffness_mN_per_um"] / by_depth["stiffness_mN_per_um"], near=1, tolerance=0.02)
    expect("reduced modulus", by_load["reduced_modulus_GPa"] / by_depth["reduced_modulus_GPa"], near=1, tolerance=0.02)
    expect("load that is set, N", result.history["load"].max(), near=2.5, tolerance=1e-6)


LEVELS = {"cell_size": 2, "levels": 2, "level_1_lower": "0,8", "level_1_upper": "8,18", "points_per_rank": 1, "quasi_static_tolerance": 0.08,
          "checkpoint_interval": 50}


@pytest.mark.mpi
@pytest.mark.parametrize("control", ("displacement", "load"))
def test_levels_ranks_and_restart(expect, control):
    case = {**CASES["metal"], **LEVELS, **({} if control == "displacement" else {**LOADS, "indenter_loads": "0,0.5,0.5,0.1"}), "max_steps": 300}
    case = {name: value for name, value in case.items() if value is not None}
    runs = {ranks: harness.run(case, ranks=ranks) for ranks in (1, 3)}
    difference, column = largest_difference(runs[3].history, runs[1].history)
    expect(f"history on 3 ranks (worst column {column})", difference, at_most=1e-9)
    for wrote, ranks in ((1, 1), (3, 3), (3, 2)):
        again = harness.run({**case, "restart": runs[wrote].folder / "checkpoint_000150.h5"}, ranks=ranks)
        difference, column = largest_difference(again.history, runs[1].history)
        expect(f"from {wrote} on {ranks} ranks (worst column {column})", difference, at_most=1e-9)
        if ranks == wrote:
            expect.that(f"from {wrote} on {ranks} ranks: to the last bit", rows_after(again.folder, 0) == rows_after(runs[wrote].folder, 150))
            expect.that("summary of the test is the same", again.summary["quasi_static"] == runs[wrote].summary["quasi_static"])


SQUEEZED = {**CONE, **METAL, "boundary_x_upper": "free", "domain_upper": "18,18", "loads": "p", "p_side": "x_upper", "p_times": 0,
            "p_pressures": 0.008, "indenter_half_angle": 85, "indenter_depths": 0.4, "quasi_static_tolerance": 0.05, "frames": 1}


def far_strain(run):
    """Equivalent plastic strain away from the tip."""
    points = run.frame(1)
    return points["equivalent_plastic_strain"][(points["position"][:, 0] > 12) & (points["position"][:, 1] < 4)]


def test_constant_loads_rise_before_the_tip_starts(expect):
    """A metal bears a pressure of 0.8 of its yield stress, and the load of the tip is that of a run whose pressure rises by hand; at once it strikes,
    the whole body flows and the load is higher. Seen: 1.7 % between two ways to rise; 1.66 and 6e-3 with a blow."""
    slow = harness.run(SQUEEZED)
    plan = slow.summary["quasi_static"]
    start, speed = plan["start"], plan["speed"]
    by_hand = {name: value for name, value in SQUEEZED.items() if not name.startswith(("quasi_static", "indenter_depths"))} | {
        "damping": plan["damping"], "xpic_fraction": plan["xpic_fraction"], "indenter_velocities": f"0,0,{speed},{speed}",
        "indenter_max_depth": 0.4, "end_time": 1.5 * start + 0.4 / speed}
    times = {"indenter_times": f"0,{start},{1.2 * start},{9 * start}"}
    risen = harness.run({**by_hand, **times, "p_times": f"0,{0.5 * start}", "p_pressures": "0,0.008"})
    struck = harness.run({**by_hand, **times})
    loads = [numpy.interp(0.38, *(run.history[name][:numpy.argmax(run.history["depth"])] for name in ("depth", "load")))
             for run in (slow, risen, struck)]
    expect("plastic strain away from the tip", far_strain(slow).max(), at_most=0)
    expect("load over that with a pressure that rises by hand", loads[0] / loads[1], near=1, tolerance=0.03)
    expect("with one that strikes: load", loads[2] / loads[1], at_least=1.05)
    expect("with one that strikes: plastic strain away from the tip", far_strain(struck).min(), at_least=1e-3)
    said = [any("that the stress of the wave makes a metal" in line for line in run.summary["warnings"]) for run in (slow, risen, struck)]
    assert said == [False, False, True], said


def test_gravity_rises_before_the_tip_starts(expect):
    """It has done the work of a column that it fills slowly, half of what it would do at once; the load of the tip is not its own energy. Seen: work
    5e-3, kinetic energy 2e-8, load 3e-3, added load 6e-3."""
    gravity, M = 1e-4, 0.7 / (1.3 * 0.4)
    run = harness.run({**CONE, "gravity": f"0,{-gravity}"})
    history, start = run.history, run.summary["quasi_static"]["start"]
    rests = history["time"] < start
    work = 0.5 * gravity**2 * 16**3 / (3 * M) * numpy.pi * 16**2
    expect("work of gravity on a confined column", history["external_work"][rests][-1] / work, near=1, tolerance=0.01)
    expect("kinetic energy then, of it", history["kinetic_energy"][rests][-1] / work, at_most=1e-3)
    expect("depth then", numpy.max(numpy.abs(history["depth"][rests])), at_most=0)
    expect("load_quasi_static, largest difference from the load, of the largest", numpy.max(
        numpy.abs(history["load_quasi_static"] - history["load"])) / history["load"].max(), at_most=0.03)
    expect("added load", run.summary["quasi_static"]["added_load"], at_least=1e-3)


OTHERS = {
    "plane strain": {"geometry": "plane_strain", "indenter": "wedge", "boundary_x_lower": "symmetry", "boundary_x_upper": "free"},
    "space": {"geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "6,6,8", "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry",
              "boundary_z_lower": "symmetry", "boundary_x_upper": "free", "block_lower": "0,0,0", "block_upper": "6,6,6", "indenter": "sphere",
              "indenter_half_angle": None, "indenter_radius": 20, "indenter_tip": "0,0,6", "indenter_depths": "0.2,0"}}


@pytest.mark.parametrize("name", OTHERS)
def test_other_geometries(expect, name):
    """Half the speed changes the load by less than the tolerance. Seen: 3 % of the 5 % that were asked for, in the hold 3e-3."""
    case = {name: value for name, value in {**CONE, **OTHERS[name]}.items() if value is not None}
    slow = expect_half_speed(expect, case, 0.05)
    expect("depth reached, of that wanted", slow["depth"].max() / float(case["indenter_depths"].split(",")[0]), near=1, tolerance=1e-9)
    expect("depth at the end", slow["depth"][-1], near=0, tolerance=1e-9)


def test_what_gives_a_warning():
    """The user's damping, end and rate are kept, and named in the output."""
    own = harness.run({**CONE, "damping": 0.05, "xpic_fraction": 0, "end_time": 5, "quasi_static_tolerance": 0.1})
    assert "damping 0.05 1/s as given" in own.stdout and "-end_time 5 ends the run before its schedule" in own.stdout
    assert own.summary["quasi_static"]["cfl"] == 0.6
    for more, cfl in (({"time_step": 0.1}, 0.4), ({"cfl": 0.3}, 0.3), ({"time_step": 0}, 0.6)):
        plan = harness.run({**CONE, **more, "max_steps": 3}).summary
        assert plan["quasi_static"]["cfl"] == cfl, plan
    assert own.summary["quasi_static"]["damping"] == 0.05 and own.summary["quasi_static"]["xpic_fraction"] == 0 and own.summary["simulated_time"] == 5
    law = {"m_model": "j2", "m_hardening": "johnson_cook", "m_yield_stress": 0.01, "m_hardening_modulus": 0.1, "m_hardening_exponent": 0.5,
           "m_rate_sensitivity": 0.1, "m_reference_rate": 1, "m_thermal_exponent": 1, "m_melting_temperature": 1000}
    for more, warned in (({}, True), ({"rate_scale": 1e9}, False), ({"m_rate_sensitivity": 0}, False)):
        assert ("knows a rate" in " ".join(harness.run({**CONE, **law, **more, "max_steps": 2}).summary["warnings"])) == warned
    fast = harness.run({**{name: value for name, value in CONE.items() if name not in ("quasi_static", "indenter_depths")}, "indenter_times": "0",
                        "indenter_velocities": 0.01, "end_time": 5})
    assert "load_quasi_static" not in fast.history and "quasi_static" not in fast.summary and fast.stdout == ""


def test_side_off_a_cell_line(expect):
    """Thin points in a metal bear steps up to a CFL of 0.55; with 0.6 the run breaks at a third of its way."""
    off = {"block_upper": "15.3,16", "boundary_x_upper": "free", "domain_upper": "18,18"}
    run = harness.run({**CONE, **METAL, **off, "indenter_depths": "0.6", "quasi_static_tolerance": 0.02})
    expect("share of the largest step", run.summary["quasi_static"]["cfl"], near=0.4, tolerance=0)
    expect("energy less work, of the work", metals.energy_left(run.history), near=0, tolerance=0.02)


def test_without_a_support():
    """Between the tip and the only side that is held, the axis, is nothing that a wave could cross: the times are by the body's size."""
    flies = harness.run({**CONE, "boundary_x_upper": "free", "boundary_y_lower": "free", "domain_lower": "0,-4"})
    plan, said = flies.summary["quasi_static"], " ".join(flies.summary["warnings"])
    assert plan["distance"] == 16 and 0 < plan["damping"] < 1 and "no body lies at a side of the domain that holds it" in said, (plan, said)


# Two levels, lengths in cells of the finer one: a contact of 4 of them on a block of 40 x 32. A blunt cone where the body is elastic, as its short
# waves grow in long runs at large strains.
LARGE = {**CONE, "domain_upper": "40,36", "cell_size": 2, "levels": 2, "level_1_lower": "0,16", "level_1_upper": "16,36", "block_upper": "40,32",
         "m_youngs_modulus": 0.91, "indenter_tip": "0,32"}
BLUNT = {"indenter_half_angle": 85, "indenter_depths": "0.55,0"}
SHARP = {"m_model": "j2", "m_yield_stress": 0.0091, "m_hardening_modulus": 0.0455, "indenter_half_angle": 70.3, "indenter_depths": "1.43,1.2"}


def verify_cones(study):
    """Slow tests of cones against some ten times slower

    With the default tolerance of 1 %: an elastic and a plastic body on two levels.
    """
    for name, case in (("elastic, 85 degrees", BLUNT), ("metal, 70.3 degrees", SHARP)):
        compare(lambda what, *words, **limits: study.expect(f"{name}: {what}", *words, **limits), {**LARGE, **case}, 0.01, 10, (0.01, 0.01, 0.005, 0.02))


def verify_tutorial(study):
    """The tutorial's case slowly, and at half the speed

    With the default tolerance of 1 %.
    """
    expect_half_speed(study.expect, {**press_of_tutorial(), "quasi_static": "true", "frames": 0}, 0.01)
