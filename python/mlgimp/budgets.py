"""What a run cannot account for of energy, momentum and mass: the identities of docs/history.md, each beside what it is small against."""

from collections import namedtuple

import numpy as np

from . import results
from .pictures import in_si_unit

Budget = namedtuple("Budget", "name error scale unit")
Budget.__doc__ = "An identity: its name, its largest error in the run and the largest of the sums that it is small against, in the unit."

IMPULSES = "support", "contact", "load", "gravity", "damping", "stagger", "hoop"  # that change the momentum, as far as a history has them


def budgets(history):
    """Returns the Budgets of a History of a run; of one with less than two rows there are none."""
    if len(history["time"]) < 2:
        return []
    energies = [np.abs(history[name] - history[name][0]) for name in ("kinetic_energy", "strain_energy", "dissipated_energy", "external_work", "indenter_work")]
    found = [Budget("energy", largest(results.energy_residual(history)), max(map(largest, energies)), "J")]
    for axis in "xyz":
        if f"momentum_{axis}" in history:
            impulses = [history[f"{kind}_impulse_{axis}"] for kind in IMPULSES if f"{kind}_impulse_{axis}" in history]
            changes = [values - values[0] for values in (history[f"momentum_{axis}"], *impulses)]
            found.append(Budget(f"momentum along {axis}", largest(changes[0] - sum(changes[1:])), max(map(largest, changes)), "N s"))
    if "mass" in history:
        found.append(Budget("mass", largest(history["mass"] - history["mass"][0]), largest(history["mass"]), "g"))
        found[-1] = found[-1]._replace(error=1e3 * found[-1].error, scale=1e3 * found[-1].scale)  # kg have a prefix of their own
    return found


def largest(values):
    """Returns the largest size of values [n], 0 of none that is a number."""
    return float(np.nanmax(np.abs(values), initial=0))


def rows_of(found):
    """Returns rows of texts about Budgets: name, largest sum, largest error, and its share of that sum."""
    return [(each.name, in_si_unit(each.scale, each.unit), in_si_unit(each.error, each.unit), f"{100 * each.error / each.scale:.2g} %" if each.scale else "-")
            for each in found]
