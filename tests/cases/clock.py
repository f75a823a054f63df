"""The test's clock: holds of seconds and hours, bodies that creep and relax in them, and what is refused."""
import functools
import math

import numpy
import pytest

import creep_laws
import harness
import metals
import refusals
from mlgimp import creep

RADIUS, DEPTH, CELLS = 10e-6, 200e-9, 5  # of the ball; the depth that it comes to about; the finest cells in the contact's radius then


def body(fine, blocks=16, **law):
    """A block of so many contact radii on three levels of ratio 2, axisymmetric."""
    coarse, size = 4 * fine, blocks * 4 * fine
    boxes = {"level_1_lower": [0.0, size - 8 * coarse], "level_1_upper": [8 * coarse, size + 2 * coarse],
             "level_2_lower": [0.0, size - 4 * coarse], "level_2_upper": [4 * coarse, size + 2 * coarse]}
    return {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": [size, size + 2 * coarse], "cell_size": coarse,
            "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "levels": 3, "refinement_ratio": 2, **boxes, "materials": "m",
            **{f"m_{name}": value for name, value in law.items()}, "bodies": "b", "b_lower": "0,0", "b_upper": [size, size],
            "indenter_tip": [0.0, size], "frames": 0, "history_interval": 5, "quasi_static": "true"}


POLYMER = {"model": "viscoelastic", "youngs_modulus": 3e9, "poissons_ratio": 0.3, "density": 1200, "relaxation_times": [0.5, 20],
           "relaxation_shares": [0.3, 0.3]}
SOLDER = {"model": "j2", "youngs_modulus": 50e9, "poissons_ratio": 0.3, "density": 7000, "rate_law": "norton", "creep_stress": 100e6,
          "creep_rate": 1e-3, "creep_exponent": 3}
BALL = {**body(math.sqrt(RADIUS * DEPTH) / CELLS, **POLYMER), "indenter": "sphere", "indenter_radius": RADIUS}
LOADS = {**BALL, "test_times": [0, 1, 101], "indenter_loads": [0, 0.4e-3, 0.4e-3]}
CONE = {**body(100e-9, **SOLDER), "indenter": "cone", "indenter_half_angle": 80, "test_times": [0, 1, 20, 21],
        "indenter_loads": [0, 1e-3, 1e-3, 0]}


@functools.cache
def elastic():
    """Depth and load of the ball on the body as it is at once."""
    case = {**BALL, "m_relaxation_shares": [0, 0], "test_times": [0, 1], "indenter_loads": [0, 1.2e-3]}
    history = harness.run(case).history
    return history.beside("load_quasi_static", "depth"), history["load_quasi_static"]


def elastic_load(depth):
    """The load of the body as it is at once at a depth, by P = C h^1.5 between rows."""
    depths, loads = elastic()
    rows = depths > 0.02 * depths[-1]
    return numpy.interp(depth, depths[rows], loads[rows] / depths[rows] ** 1.5) * numpy.maximum(depth, 0) ** 1.5


def relaxing(times, t):
    """E(t)/E(0) of the polymer."""
    return 1 - sum(POLYMER["relaxation_shares"]) + sum(
        share * numpy.exp(-t / time) for share, time in zip(POLYMER["relaxation_shares"], times))


def relaxed_load(history, at):
    """The load at a time of the test by Boltzmann's integral over the elastic loads of the depths that the tip has passed."""
    t, load = history["test_time"], elastic_load(history["depth"])
    rows = t <= at
    steps, middle = numpy.diff(load[rows]), 0.5 * (t[rows][1:] + t[rows][:-1])
    return numpy.sum(relaxing(POLYMER["relaxation_times"], at - middle) * steps)


def missing(history):
    """What the identity of energy (docs/history.md) leaves, the largest of all rows, of the indenter's work at the end."""
    gained = sum(history[name] - history[name][0] for name in ("kinetic_energy", "strain_energy")) + history["dissipated_energy"]
    given = sum(history[name] for name in ("external_work", "contact_work", "contact_strain_energy", "contact_plastic_work", "friction_work",
                                           "exchange_energy", "transfer_energy"))
    return numpy.max(numpy.abs(gained - given)) / history["indenter_work"][-1]


@pytest.mark.parametrize("control", ["load", "depth"])
def test_ball_on_a_polymer(control, expect):
    """Lee and Radok's integral (1960) of the elastic curve of the same body on the same grid, in a ramp and a hold of 100 s. Seen: 8e-3 of
    the load; energy 3.4e-3."""
    case = LOADS if control == "load" else {**BALL, "test_times": [0, 1, 101], "indenter_depths": [0, 150e-9, 150e-9]}
    history = harness.run(case).history
    for at in (1, 2, 5, 10, 30, 100):
        load = numpy.interp(at, history.beside("load_quasi_static", "test_time"), history["load_quasi_static"])
        expect(f"{control}: load of the integral at {at} s, of the load", relaxed_load(history, at) / load, near=1, tolerance=0.01)
    expect("time of the test at its end", history["test_time"][-1], near=101, tolerance=1e-9)
    expect("energy less work, of the work", metals.energy_left(history), near=0, tolerance=0.004)  # terms are quadratic in their stress
    expect("energy that no column of the book has, of the work", missing(history), at_most=1e-12)


def test_rates_and_times_scale_exactly(expect):
    """Twice the rate of creep in half the time of the test is the same run."""
    slow = harness.run({**CONE, "max_steps": 2000}).history
    fast = harness.run({**CONE, "max_steps": 2000, "m_creep_rate": 2 * SOLDER["creep_rate"],
                        "test_times": [0.5 * time for time in CONE["test_times"]]}).history
    expect.that("the test has come into its hold", slow["test_time"][-1] > 1.5)
    for column in slow:
        factor = 2 if column == "test_time" else 1
        expect.that(f"{column}: the same digits", numpy.array_equal(slow[column], factor * fast[column]))


def test_restart_in_a_hold(expect, tmp_path):
    """A run that stops in a hold goes on as if it had not, on other numbers of ranks too."""
    whole = harness.run({**CONE, "max_steps": 1600}).history
    harness.run({**CONE, "max_steps": 1403, "checkpoint_interval": 1400}, folder=tmp_path / "first")
    for ranks, tolerance in ((1, 0), (3, 1e-9)):
        rest = harness.run({**CONE, "max_steps": 1600, "restart": tmp_path / "first" / "checkpoint_001400.h5"}, ranks=ranks).history
        same = numpy.isin(whole["step"], rest["step"])
        expect.that("the test was in its hold", 1 < rest["test_time"][0] < 20)
        for column in ("test_time", "depth", "load", "plastic_work"):
            expect(f"{column} on {ranks} ranks", numpy.max(numpy.abs(rest[column] / whole[column][same] - 1)), at_most=tolerance)


def test_cone_that_creeps(expect):
    """Exact depth, and radius of the contact, of a load that is held on a blunt cone in a body of Norton's law, on six cells; and the load
    that the body has without drag. Seen: depth 3e-3, radius 3e-3, load 5e-4 (4e-3 where drag is not added, radius .43 where the surface does
    not flow between the nodes)."""
    history, end, exact = creep_laws.hold(5, 6, blocks=16, levels=3)
    _, factor, _ = creep.norton_factors(5)
    depth = creep_laws.at(history, end, "depth")
    expect("depth, of the exact one", depth / exact(end), near=1, tolerance=0.02)
    expect("radius of the contact, of the exact one", creep_laws.radius_near(history, end) / (factor * depth * math.tan(math.radians(80))),
           near=1, tolerance=0.03)
    held = history["test_time"] > 0.1 * end
    expect("load without drag, of that held", numpy.mean(history["load_quasi_static"][held]) / 1e-3, near=1, tolerance=0.002)


def test_hold_above_the_surface(expect):
    """A hold of the depth where the tip has left the polymer, which comes back to it without a load."""
    history = harness.run({**BALL, "test_times": [0, 1, 2, 102], "indenter_depths": [0, 150e-9, 10e-9, 10e-9]}).history
    expect("time of the test at its end", history["test_time"][-1], near=102, tolerance=1e-9)
    expect("largest load of the hold, of the largest", numpy.max(history["load"][history["test_time"] > 3]) / numpy.max(history["load"]), at_most=0.02)


def test_hold_without_a_load(expect):
    """A polymer that is let go comes back in a hold without a load, and the hold ends."""
    result = harness.run({**BALL, "test_times": [0, 1, 2, 102], "indenter_loads": [0, 0.4e-3, 0, 0]})
    history, legs = result.history, result.summary["test"]["legs"]
    expect("time of the test at its end", history["test_time"][-1], near=102, tolerance=1e-9)
    expect("transits of the hold", legs[-1]["transits"], near=46, tolerance=4)  # ln(101)/.1
    stored, spent = history["strain_energy"][-1], history["indenter_work"][-1]
    expect("energy that is left in the body, of the work", stored / spent, at_most=0.02)


POLYMERS = refusals.Table(LOADS, [
    ("times that do not rise", {"test_times": [0, 1, 1]}, ["-test_times 1:", "above the time before it"]),
    ("a time for each load", {"test_times": [0, 1]}, ["-test_times 2 values:", "as many as -indenter_loads has: 3"]),
    ("a fast test", {"quasi_static": "false"}, ["-test_times", "given with -quasi_static"]),
    ("two scales", {"rate_scale": 1e-8}, ["-rate_scale", "left out with -test_times"]),
    ("an end of another clock", {"end_time": 1e-6}, ["-end_time", "left out with -test_times"]),
    ("nothing first", {"indenter_loads": [0, 0, 1e-3]}, ["-indenter_loads 0:", "above 0 at the second"]),
    ("no control", {"indenter_control": "displacement"}, ["-indenter_control displacement:", "load with -test_times"]),
    ("creep at no speed", {"test_creep": 0}, ["-test_creep 0:"]),
    ("all relaxes", {"m_relaxation_shares": [0.5, 0.5]}, ["-m_relaxation_shares 1:", "less than 1 in sum"]),
    ("a share too few", {"m_relaxation_shares": 0.5}, ["-m_relaxation_shares 1 values:", "as many as there are relaxation times: 2"]),
    ("relaxation times that fall", {"m_relaxation_times": [20, 0.5]}, ["-m_relaxation_times 0.5:", "rising"]),
    ("more than all of the bulk", {"m_relaxation_bulk_shares": [1, 0.5]}, ["-m_relaxation_bulk_shares 1.5:", "less than 1 in sum"]),
])
METALS = refusals.Table(CONE, [
    ("a rate that falls with stress", {"m_creep_exponent": 0.5}, ["-m_creep_exponent 0.5:"]),
    ("two rates", {"m_rate_law": "perzyna", "m_hardening": "johnson_cook", "m_yield_stress": 1e8, "m_hardening_modulus": 0,
                   "m_hardening_exponent": 0, "m_rate_sensitivity": 0, "m_reference_rate": 1, "m_thermal_exponent": 1,
                   "m_melting_temperature": 900}, ["-m_rate_law perzyna:", "johnson_cook, which has a rate of its own"]),
    ("a yield stress that nothing reads", {"m_yield_stress": 1e8}, ["m_yield_stress"]),
])


@pytest.mark.mpi
@pytest.mark.parametrize("table", [POLYMERS, METALS])
def test_refused(expect, table):
    refusals.expect_refused(expect, table)


def test_creep_without_a_clock_gives_a_warning():
    case = {name: value for name, value in CONE.items() if name not in ("test_times", "indenter_loads", "quasi_static")}
    case.update({"indenter_times": 0, "indenter_velocities": 1, "end_time": 1e-9, "max_steps": 2})
    assert any("theta = t" in line for line in harness.run(case).summary["warnings"])
    assert not any("theta = t" in line for line in harness.run({**case, "rate_scale": 1e-9}).summary["warnings"])


def test_units_of_creep_give_warnings():
    """Stresses in MPa and energies in kJ/mol; a temperature that creep reads is no useless one."""
    warm = {**CONE, "m_rate_law": "garofalo", "m_activation_energy": 78e3, "initial_temperature": 400, "max_steps": 2}
    said = lambda case: " ".join(harness.run(case).summary["warnings"])
    assert "initial_temperature" not in said(warm) and "J/mol" not in said(warm)
    assert "-m_activation_energy 78: is less" in said({**warm, "m_activation_energy": 78})
    assert "-m_creep_stress 100: is less than a millionth" in said({**warm, "m_creep_stress": 100})
