"""Hardness and modulus over the depth: of a stiffness that is measured all the time (CSM), or of many unloadings. um, mN, GPa."""

import csv
import math
from collections import namedtuple

import numpy as np

from . import cycles, oliver_pharr, zeros
from .checks import Rule
from .errors import Error, ResultError
from .needs import need

OverDepth = namedtuple("OverDepth", "depth load stiffness contact_depth area hardness reduced_modulus modulus ratio")
OverDepth.__doc__ = """Figures of a test over its depth, each [rows]: depth (um), load (mN), stiffness of the contact (mN/um), contact depth (um),
area (um^2), hardness, reduced and specimen's modulus (GPa), and P/S^2 (um^2/mN), which no area and no tip is in:
P/S^2 = pi H/(4 beta^2 Er^2) is constant in a homogeneous half space (Joslin and Oliver, J. Mater. Res. 5 (1990) 123)."""

UNITS = ("um", "mN", "mN_per_um", "um", "um2", "GPa", "GPa", "GPa", "um2_per_mN")
COLUMNS = tuple(f"{name if name != 'ratio' else 'load_over_squared_stiffness'}_{unit}" for name, unit in zip(OverDepth._fields, UNITS))
DEEP = 0.5, 0.95  # of the largest depth, where means are taken by default: above, tip and contact point matter; below, a hold adds rows
UNLOADED = 0.5, 1.0  # the same of unloadings, of which the last is from the largest depth
RANGE = Rule(lambda ends: len(ends) == 2 and 0 <= ends[0] < ends[1] < math.inf, "LOW,HIGH in nm with 0 <= LOW < HIGH")
ONE = 1e-9  # of an exponent: limits between which it is that alone
LEAST = 3  # unloadings, from which on figures over the depth are more than single ones


def of_stiffness(curve, constants=oliver_pharr.Constants()):
    """Returns the OverDepth of the first loading of a Curve with a stiffness, by Oliver and Pharr at each row:
    h_c = h - epsilon P/S, H = P/A(h_c), Er = S sqrt(pi)/(2 beta sqrt(A))."""
    end = zeros.end_of_first_loading(curve) + 1
    depth, load, stiffness = (values[:end] for values in (curve.depth, curve.load, curve.stiffness))
    rows = (depth > 0) & (load > 0) & (np.nan_to_num(stiffness) > 0)
    if not rows.any():
        raise ResultError(curve.name, "no row of the loading has a stiffness above zero, beside a depth and a load above zero")
    if curve.tip is None:
        raise ResultError(curve.name, "figures over the depth need a tip")
    poisson = curve.poisson if constants.poisson is None else constants.poisson
    epsilon = curve.tip.epsilon if constants.epsilon is None else constants.epsilon
    depth, load, stiffness = depth[rows], load[rows], stiffness[rows]
    beta = curve.tip.beta(poisson, depth - epsilon * load / stiffness) if constants.beta is None else constants.beta
    found = oliver_pharr.contact(curve.tip, depth, load, stiffness, epsilon, beta)
    return OverDepth(depth, load, stiffness, *found, oliver_pharr.specimen_modulus(found[-1], poisson, constants), load / stiffness**2)


def with_common_exponent(curve, rows, constants):
    """Returns the dicts of a run's unloadings, all fitted with the median of their exponents.

    What lets go of the tip cell by cell makes waves of some tenths of a per cent of the load, which change exponent and stiffness together:
    under a cone in a metal on 4 to 10 cells moduli over the depth scatter by 2.0 % with exponents of their own, and by 1.3 % with one.
    """
    exponent = float(np.median([row["exponent"] for row in rows]))
    poisson = curve.poisson if constants.poisson is None else constants.poisson
    found = []
    for cycle, row in zip(cycles.find_cycles(curve), rows):
        if math.isfinite(row["stiffness_mN_per_um"]) and curve.tip is not None:
            fit = oliver_pharr.fit_unloading(curve, cycle, constants.window, (exponent * (1 - ONE), exponent * (1 + ONE)))
            figures = oliver_pharr.contact(curve.tip, fit.depth, fit.load, fit.stiffness, row["epsilon"], row["beta"])
            names = ("contact_depth_um", "area_um2", "hardness_GPa", "reduced_modulus_GPa", "modulus_GPa")
            row = row | {"stiffness_mN_per_um": fit.stiffness} | dict(zip(names, (*figures, oliver_pharr.specimen_modulus(figures[-1], poisson, constants))))
        found.append(row)
    return found


def of_unloadings(rows):
    """Returns the OverDepth of the dicts of oliver_pharr.analyse, in the order of the test."""
    names = ("depth_um", "load_mN", "stiffness_mN_per_um", "contact_depth_um", "area_um2", "hardness_GPa", "reduced_modulus_GPa", "modulus_GPa")
    found = [np.array([row[name] for row in rows], float) for name in names]
    return OverDepth(*found, found[1] / found[2] ** 2)


def over_depth(curve, rows, constants=oliver_pharr.Constants()):
    """Returns the OverDepth of a Curve with a stiffness, else of its unloadings, `rows` of oliver_pharr.analyse; None of a few of these."""
    if curve.stiffness is not None:
        return of_stiffness(curve, constants)
    constants = oliver_pharr.constants_of(curve, constants)
    rows = with_common_exponent(curve, rows, constants) if curve.cells is not None and len(rows) >= LEAST else rows
    found = [row for row in rows if math.isfinite(row["stiffness_mN_per_um"])]
    return of_unloadings(found) if len(found) >= LEAST else None


def summary(found, ends=None, deep=DEEP):
    """Returns a dict: means and standard deviations of hardness, moduli and P/S^2 between two depths (um), by default shares of the largest."""
    low, high = (share * found.depth.max() for share in deep) if ends is None else ends
    rows = (found.depth >= low) & (found.depth <= high)
    if not rows.any():
        raise Error(f"no row lies between the depths of {1e3 * low:g} and {1e3 * high:g} nm; the largest is {1e3 * found.depth.max():.4g} nm")
    result = {"from_depth_um": float(low), "to_depth_um": float(high), "rows": int(rows.sum())}
    for name, values in list(zip(COLUMNS, found))[5:]:
        result |= {name: float(np.mean(values[rows])), f"{name}_deviation": float(np.std(values[rows]))}
    return result


def write(path, tables):
    """Writes csm.csv from {name of a curve: OverDepth}: a row for each place."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["curve", *COLUMNS])
        writer.writerows([name, *("" if math.isnan(value) else f"{value:.9g}" for value in row)] for name, found in tables.items()
                         for row in zip(*found))


def draw(tables):
    """Returns the picture of {name of a curve: OverDepth}: hardness, modulus and P/S^2 over the depth, as a matplotlib Figure."""
    need("matplotlib")  # only where something is drawn
    from . import pictures
    modulus = "modulus" if all(np.isfinite(found.modulus).any() for found in tables.values()) else "reduced_modulus"
    panels = {"hardness (GPa)": "hardness", f"{modulus.replace('_', ' ')} (GPa)": modulus, "P/S² (µm²/mN)": "ratio"}
    return pictures.over_depth([(name, found.depth, {label: getattr(found, of) for label, of in panels.items()}) for name, found in tables.items()])
