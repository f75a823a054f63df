"""The books of history.csv: energy, momentum and mass balance, and what contact and the coupling of levels add is seen."""
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


@pytest.mark.parametrize("name, case", [("wedge", WEDGE), ("wedge on levels", LEVELS), ("collision", COLLISION)])
def test_budgets(expect, name, case):
    """Default settings; the works are those of the indenter, of gravity and loads, or the first kinetic energy."""
    check(expect, name, harness.run({**case, "checkpoint_interval": 0}), energy=0.01)


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
    expect("work on the body over that of the indenter", history["contact_work"][-1] / history["indenter_work"][-1],
           near=1, tolerance=tolerance)
