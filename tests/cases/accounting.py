"""The budgets of history.csv: energy, momentum and mass balance, and what contact and the coupling of levels add is seen."""
import numpy
import pytest

import harness
from ranks import COLLISION, FLIGHT, LEVELS, WEDGE

IMPULSES = ("contact", "support", "load", "gravity", "damping", "stagger")


def energy_left(history):
    """Energy that no column explains, and the largest work or kinetic energy to measure it by, J."""
    kept = sum(history[name] for name in ("kinetic_energy", "strain_energy", "dissipated_energy"))
    left = kept - history["external_work"] - history["indenter_work"]
    work = max(numpy.max(numpy.abs(history[name])) for name in ("external_work", "indenter_work", "kinetic_energy"))
    return left - left[0], work


def check(expect, name, result, energy):
    history = result.history
    left, work = energy_left(history)
    expect(f"{name}: energy less works, of the work", numpy.max(numpy.abs(left)) / work, at_most=energy)
    momentum = numpy.sqrt(2 * numpy.max(history["kinetic_energy"]) * history["mass"][0])
    for axis in "xy":
        off = history[f"momentum_{axis}"] - sum(history[f"{impulse}_impulse_{axis}"] for impulse in IMPULSES)
        expect(f"{name}: momentum less impulses along {axis}, of sqrt(2 E m)", numpy.max(numpy.abs(off - off[0])) / momentum,
               at_most=1e-9)
    expect(f"{name}: mass, to the round-off of its sum", abs(result.summary["mass_error"]), at_most=1e-13)


@pytest.mark.parametrize("name, case, energy", [
    ("wedge", WEDGE, 0.01), ("wedge on levels", LEVELS, 0.01), ("collision", {**COLLISION, "soft_volume_average": "false"}, 0.01),
    ("collision, volume averaged", COLLISION, 0.03)])
def test_budgets(expect, name, case, energy):
    """The works are those of the indenter, of gravity and loads, or the first kinetic energy. The average takes strain from the new
    velocities as USL does, which loses energy in shocks: 3.6 % in this one."""
    check(expect, name, harness.run({**case, "checkpoint_interval": 0}), energy)


def test_budgets_of_tension(expect):
    check(expect, "tension on levels", harness.run({"frames": 0}, file="tension_2level.opts"), energy=0.01)


@pytest.mark.parametrize("merging", ["false", "true"])
def test_injected(expect, merging):
    """A fast disk across two borders: what is missing in the end is what the columns of the coupling and of merging say."""
    history = harness.run({**FLIGHT, "merge_siblings": merging, "checkpoint_interval": 0}).history
    left, work = energy_left(history)
    injected = history["exchange_energy"] + history["transfer_energy"]
    expect("energy less works, of the work", numpy.max(numpy.abs(left)) / work, at_least=0.01)
    expect("the same less what coupling and transfer added", numpy.max(numpy.abs(left - injected)) / work, at_most=0.005)
    expect.that("merging takes energy", (history["transfer_energy"][-1] < -1e-3 * work) == (merging == "true"))


@pytest.mark.parametrize("method, tolerance", [("pressure", 0.01), ("point_pressure", 0.01), ("multimesh", 0.05)])
def test_contact(expect, method, tolerance):
    """The indenter's work but for what contact takes up reaches the body; multimesh stops each node that it meets."""
    history = harness.run({**WEDGE, "contact": method}).history
    expect("work on the body over that of the indenter", harness.given_by_contact(history)[-1] / history["indenter_work"][-1],
           near=1, tolerance=tolerance)


XPIC = {"domain_lower": "0,0", "domain_upper": "12,12", "materials": "al", "al_youngs_modulus": 1e9, "al_poissons_ratio": 0.3,
        "al_density": 1000, "bodies": "block", "gravity": "0,-10", "xpic_fraction": 0.05, "max_steps": 400, "frames": 0}
ON_A_SIDE = {"cell_size": 1, "block_lower": "0,0", "block_upper": "8,8", "boundary_y_lower": "symmetry", "boundary_x_lower": "fixed"}
ACROSS = {"cell_size": 0.5, "block_lower": "2,2", "block_upper": "8,8", "block_velocity": "5,3", "levels": 2, "level_1_lower": "3,3",
          "level_1_upper": "7,7"}
COPIES = {**ON_A_SIDE, "levels": 2, "level_1_lower": "0,4", "level_1_upper": "12,12", "level_coupling": "points"}


@pytest.mark.parametrize("place", [ON_A_SIDE, ACROSS, COPIES], ids=["at sides", "across levels", "copies of points"])
@pytest.mark.parametrize("update", ["musl", "usl"])
@pytest.mark.parametrize("order", [1, 2])
def test_momentum_with_xpic(place, update, order):
    """What sides and borders of levels do to the velocities that XPIC mixes in is added up."""
    history = harness.run({**XPIC, **place, "xpic_order": order, "stress_update": update}).history
    momentum = numpy.sqrt(2 * numpy.max(history["kinetic_energy"] + history["strain_energy"]) * history["mass"][0])
    for axis in "xy":
        off = history[f"momentum_{axis}"] - sum(history[f"{impulse}_impulse_{axis}"] for impulse in IMPULSES)
        assert numpy.max(numpy.abs(off - off[0])) <= 1e-11 * momentum


FREE_METALS = {**XPIC, "gravity": "0,0", "cell_size": 0.5, "al_model": "j2", "al_yield_stress": 2e6, "al_hardening_modulus": 0, "bodies": "block,disk",
               "block_lower": "6,2", "block_upper": "8,8", "disk_shape": "disk", "disk_center": "3,4", "disk_radius": 1.8,
               "disk_velocity": "150,30", "max_steps": 200}


@pytest.mark.parametrize("order", [1, 2])
def test_momentum_of_free_metals(order):
    """Nodes of little mass strain metals less than their forces say, but points get the whole momentum, with XPIC too."""
    history = harness.run({**FREE_METALS, "xpic_order": order}).history
    assert history["plastic_work"][-1] > 0.1 * history["kinetic_energy"][0]
    for axis in "xy":
        momentum = history[f"momentum_{axis}"]
        assert numpy.max(numpy.abs(momentum - momentum[0])) <= 1e-13 * history["momentum_x"][0]


COLLISION_AT_A_BORDER = {
    "domain_lower": "0,0", "domain_upper": "40e-6,24e-6", "cell_size": 1e-6, "bodies": "l,r", "l_lower": "8e-6,8e-6",
    "l_upper": "20e-6,16e-6", "r_lower": "20e-6,8e-6", "r_upper": "32e-6,16e-6", "l_velocity": "30,0", "r_velocity": "-30,0",
    "materials": "al", "al_youngs_modulus": 70e9, "al_poissons_ratio": 0.33, "al_density": 2700, "end_time": 160e-9, "frames": 0,
    "short_wave_viscosity": "0,0"}
AT_A_BORDER = {"levels": 2, "level_1_lower": "20e-6,6e-6", "level_1_upper": "30e-6,18e-6"}


@pytest.mark.parametrize("more", [{}, {"stress_update": "usl"}, {"al_model": "j2", "al_yield_stress": 1e8, "al_hardening_modulus": 0}, {"xpic_fraction": 0.05}],
                         ids=["elastic", "usl", "plastic", "xpic"])
def test_exchange_of_short_waves(expect, more):
    """Two halves of a block meet across a border without a filter. Short waves, a sixth of the energy, are absorbed in the band, and
    nodes of next to no mass come and go: the column, from the nodes' forces and the points' momenta, says what the points lost."""
    history = harness.run({**COLLISION_AT_A_BORDER, **AT_A_BORDER, **more}).history
    energy, _ = energy_left(history)
    left = energy - history["exchange_energy"] - history["transfer_energy"]
    expect("energy taken, of the first", numpy.max(numpy.abs(history["exchange_energy"])) / history["kinetic_energy"][0], at_least=0.02)
    expect("energy less works and exchange, of the first", numpy.max(numpy.abs(left)) / history["kinetic_energy"][0], at_most=1e-9)


def test_exchange_of_averaged_growth(expect):
    """Points that average their growth of volume follow the new velocities of nodes, of which their own take less: a fifth of
    the energy of a collision on eight cells goes, which no other book knows."""
    history = harness.run({**COLLISION_AT_A_BORDER, "al_volume_average": "true", "end_time": 80e-9}).history
    energy, _ = energy_left(history)
    expect("energy taken, of the first", -history["exchange_energy"][-1] / history["kinetic_energy"][0], at_least=0.02)
    expect("energy less works and exchange, of the first", numpy.max(numpy.abs(energy - history["exchange_energy"])) / history["kinetic_energy"][0], at_most=1e-9)


@pytest.mark.parametrize("file, steps", [("punch_plastic.opts", 300), ("wedge_3level.opts", 60), ("scratch.opts", 120), ("cone_load.opts", 150)])
def test_energy_closes(expect, file, steps):
    """With contact, friction, sides, levels, splitting, viscosity, XPIC and damping: nothing is left that no column has."""
    history = harness.run({"max_steps": steps, "frames": 0}, file=file).history
    energy = sum(history[part] for part in ("kinetic_energy", "strain_energy", "dissipated_energy"))
    got = sum(history[part] for part in ("external_work", "contact_work", "contact_strain_energy", "contact_plastic_work", "friction_work", "exchange_energy", "transfer_energy"))
    expect("energies less works, of the indenter's", numpy.max(numpy.abs(energy - energy[0] - got)) / history["indenter_work"][-1], at_most=1e-11)


# Strips of half a cell, one column of points each, that go up and down in turn: inside them the grid stands still.
STRIPS = 8
SHEARED = {"domain_lower": "-1,-1", "domain_upper": "5,5", "cell_size": 1, "materials": "m", "m_model": "linear", "m_youngs_modulus": 1,
           "m_poissons_ratio": 0, "m_density": 2, "bodies": ",".join(f"s{k}" for k in range(STRIPS)), "frames": 0}
for k in range(STRIPS):
    SHEARED |= {f"s{k}_lower": [k / 2, 0.0], f"s{k}_upper": [(k + 1) / 2, 3.0], f"s{k}_velocity": [0.0, (-1.0) ** k]}


def test_noise_of_velocities(expect):
    """Only the nodes of the two edges, with weights 3/4 and 1/4, move: each at half the speed and with the mass of a column."""
    history = harness.run({**SHEARED, "max_steps": 1, "end_time": 1, "history_interval": 1}).history
    expect("energy of the points less that of the nodes, of it", history["noise_energy"][-1] / history["kinetic_energy"][0],
           near=1 - 2 * 0.5**2 / STRIPS, tolerance=1e-12)


def test_noise_does_not_depend_on_the_rows(expect):
    """It is measured where a row is due."""
    fine, coarse = (harness.run({**SHEARED, "max_steps": 21, "end_time": 100, "history_interval": rows}).history for rows in (1, 7))
    same = numpy.isin(fine["step"], coarse["step"])
    assert same.sum() == len(coarse["step"]) == 4
    expect("noise in the same steps, of the energy", numpy.max(numpy.abs(fine["noise_energy"][same] - coarse["noise_energy"])) /
           fine["kinetic_energy"][0], at_most=1e-15)
    assert numpy.all(coarse["noise_energy"][1:] > 0)
