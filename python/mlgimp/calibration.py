"""Area function and frame compliance from a series of indentations of a specimen whose modulus is known, as of fused silica.

After Oliver and Pharr, J. Mater. Res. 7 (1992) 1564 and 19 (2004) 3. Units: um, mN, GPa; coefficients in nm, compliances in nm/mN.
"""

import json
import math
import os
from collections import namedtuple
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from . import checks, corrections, csm, cycles, load_depth, oliver_pharr, tips
from .checks import Rule
from .errors import Error, ResultError

EPSILON, BETA = 0.75, 1.0  # of tips by area functions in the analysis, so that it gives the modulus back
LEAST_TESTS = 3  # depths beside which a line still has a misfit
SAME_HARDNESS = 0.005  # of the median: depths whose hardness differs by more, as rounded tips make less pressure, say nothing about the frame,
SPREAD = 4  # or by more than so many times the median deviation of the deeper half, 2.7 standard deviations of what scatters
SURE = 1e-3  # of a stiffness: better none is known, as curves are no exact power laws
TURNS = 50  # of the loops at most; they stand after a few
ROUGH = 1e-8  # of the largest singular value: combinations of powers that the depths do not tell apart to this are left out
STANDS = 1e-6  # change of the compliance over itself
RULES = {
    "modulus": Rule(lambda modulus: 0 < modulus <= oliver_pharr.STIFFEST, f"in (0, {oliver_pharr.STIFFEST}] GPa; 72 GPa are 72, not 72e9"),
    "coefficients": Rule(lambda count: 1 <= count <= 9, "a whole number in [1, 9]"),
}

Calibration = namedtuple("Calibration", "coefficients area_error frame frame_error hardness modulus depths shown rows tests beta", defaults=(BETA,))
Calibration.__doc__ = """What a series gives: the coefficients C0, C1, ... of the area (nm^2) over the contact depth (nm) and the root mean square of
what it misses, as a share; the frame's compliance and its standard error (nm/mN); the hardness by which it was found and the reduced
modulus that was given (GPa); the least and largest contact depth (nm); for each depth whether it counted for the frame; rows
[depths][load mN, contact depth nm, stiffness of the contact mN/um, area nm^2, hardness GPa]; their names; and beta."""


def calibrate(curves, *, modulus=72.0, poisson=0.17, tip_modulus=1141.0, tip_poisson=0.07, reduced_modulus=None, coefficients=6, window=None,
              beta=BETA, frame_compliance=None):
    """Returns the Calibration of a series of Curves of a specimen with a known modulus.

    curves: load_depth.Curves, or paths of files; each unloading is a depth, from which frame and drift are not taken off.
    modulus, poisson (GPa) of the specimen, fused silica by default, and of the tip, diamond; or reduced_modulus in their place.
    coefficients: how many C. window: part of the unloadings that is fitted. beta: of S = 2 beta Er sqrt(A/pi), with which the area is used. frame_compliance (nm/mN): one that is known.

    The compliance of frame and contact is 1/S = C_f + sqrt(pi)/(2 beta E_r) A^(-1/2). With a hardness H that does not depend on the depth,
    A = P/H, and 1/S over P^(-1/2) is a line that begins at C_f, whatever the tip is like. Then A = pi/4 (S_c/(beta E_r))^2 of each
    contact alone, at the depth h - C_f P - epsilon P/S_c. Depths whose P/A differ from the median by more than SAME_HARDNESS and
    what the deeper ones scatter are left out of the line, and all is done again until it stands; and again with the unloadings fitted without
    the compliance that was found, since a power law and a spring in a row are no power law, until nothing of it is left. The coefficients
    are those of least squares of A relative to itself.
    """
    beta = checks.number("beta", beta, oliver_pharr.RULES["beta"])
    reduced = beta * checked_modulus(modulus, poisson, tip_modulus, tip_poisson, reduced_modulus)

    def result(found, **changed):
        return found._replace(modulus=reduced / beta, beta=beta, **changed)
    count = checks.whole("coefficients", coefficients, 1)
    if not RULES["coefficients"].good(count):
        raise checks.refusal("coefficients", coefficients, RULES["coefficients"].allowed)
    window = oliver_pharr.WINDOW if window is None else checks.several("window", window, oliver_pharr.RULES["window"])
    curves = curves_of(curves)
    if frame_compliance is not None:
        frame = 1e-3 * checks.number("frame_compliance", frame_compliance, corrections.FRAME)
        contacts(unloadings(curves, 0.0, window)[3], frame, reduced)  # refuses a compliance that is more than the whole
        return result(of_unloadings(*unloadings(curves, frame, window), reduced, count, 0.0), frame=1e3 * frame)
    total = 0.0
    for _ in range(TURNS):
        found = of_unloadings(*unloadings(curves, total, window), reduced, count)
        total += 1e-3 * found.frame
        if abs(found.frame) <= max(STANDS * 1e3 * abs(total), 1e-2 * found.frame_error):
            break
    if total < 0:  # of depths that are free of the frame: no frame pushes
        return result(of_unloadings(*unloadings(curves, 0.0, window), reduced, count, 0.0), frame_error=found.frame_error)
    return result(found, frame=1e3 * total)


def curves_of(given):
    """Returns a list of the Curves that are given, one or several, or those of all tests in files."""
    several = [given] if isinstance(given, (str, os.PathLike, load_depth.Curve)) else given
    if not isinstance(several, Iterable):
        raise checks.refusal("curves", given, "load_depth.Curves or paths of files")
    return [curve for each in several for curve in ([each] if isinstance(each, load_depth.Curve) else load_depth.read_tests(each))]


def checked_modulus(modulus, poisson, tip_modulus, tip_poisson, reduced):
    """Returns the reduced modulus (GPa) that is given, or that of specimen and tip."""
    if reduced is not None:
        return checks.number("reduced_modulus", reduced, RULES["modulus"])
    modulus, poisson = checks.number("modulus", modulus, RULES["modulus"]), checks.number("poisson", poisson, oliver_pharr.POISSON)
    tip_modulus = checks.number("tip_modulus", tip_modulus, oliver_pharr.RULES["tip_modulus"])
    tip_poisson = checks.number("tip_poisson", tip_poisson, oliver_pharr.POISSON)
    return 1 / ((1 - poisson**2) / modulus + (1 - tip_poisson**2) / tip_modulus)


def unloadings(curves, frame, window):
    """Returns the names of all unloadings of Curves without the compliance of a frame (um/mN), and their depths (um), loads (mN), stiffnesses
    and the standard errors of these (mN/um), all [depths]. Those of runs, whose waves of cells change exponent and stiffness together, are
    fitted with the median of their exponents (see csm.with_common_exponent)."""
    found = fits(curves, frame, window, oliver_pharr.EXPONENTS)
    if len({round(fit.depth, 9) for _, fit in found}) < LEAST_TESTS:
        raise Error(f"a calibration needs unloadings from at least {LEAST_TESTS} different depths; there are {len(found)}")
    if all(curve.cells is not None for curve in curves):
        common = float(np.median([fit.exponent for _, fit in found]))
        found = fits(curves, frame, window, (common * (1 - csm.ONE), common * (1 + csm.ONE)))
    figures = [[fit.depth, fit.load, fit.stiffness, fit.stiffness_error] for _, fit in found]
    return [name for name, _ in found], *np.array(figures).T


def fits(curves, frame, window, exponents):
    """Returns [(name, oliver_pharr.Unloading)] of all unloadings of Curves."""
    return [each for curve in curves for each in fits_of(curve, frame, window, exponents)]


def fits_of(curve, frame, window, exponents):
    """Returns [(name, oliver_pharr.Unloading)] of the unloadings of a Curve that can be fitted; raises a ResultError where none can."""
    free, found, problem = curve._replace(depth=curve.depth - frame * curve.load), [], None
    for number, cycle in enumerate(cycles.find_cycles(free), start=1):
        try:
            found.append((f"{curve.name} unloading {number}", oliver_pharr.fit_unloading(free, cycle, window, exponents)))
        except ResultError as why:
            problem = why
    if not found:
        raise problem
    return found


def of_unloadings(tests, depth, load, stiffness, stiffness_error, reduced, count, known_frame=None):
    """Returns the Calibration of unloadings [depths] (um, mN, mN/um); the compliance of a frame that is known in um/mN, or None."""
    unsure = np.maximum(stiffness_error / stiffness, SURE)
    shown = load >= np.median(load)  # the deeper half, whose hardness the rounding of the tip changes least
    frame, error = (known_frame, 0.0) if known_frame is not None else (math.inf, 0.0)
    for _ in range(TURNS):
        before = frame
        if known_frame is None:
            frame, error = line_at_zero(load[shown] ** -0.5, 1 / stiffness[shown], unsure[shown] / stiffness[shown])
        contact, area = contacts(stiffness, frame, reduced)
        hardness = load / area
        deep = hardness[load >= np.median(load)]
        middle = float(np.median(deep))
        same = np.abs(hardness / middle - 1) <= max(SAME_HARDNESS, SPREAD * float(np.median(np.abs(deep / middle - 1))))
        shown = same if same.sum() >= LEAST_TESTS else shown
        if abs(frame - before) <= STANDS * abs(frame):
            break
    contact_depth = depth - frame * load - EPSILON * load / contact
    coefficients, missed = fitted_area(1e3 * contact_depth, 1e6 * area, unsure, count)
    rows = np.column_stack([load, 1e3 * contact_depth, contact, 1e6 * area, hardness])
    depths = 1e3 * contact_depth.min(), 1e3 * contact_depth.max()
    return Calibration(coefficients, missed, 1e3 * frame, 1e3 * error, middle, reduced, depths, shown, rows, tests)


def line_at_zero(x, y, error):
    """Returns where the line of least squares through (x, y) [depths] with these standard errors of y is at x = 0, and the standard error
    of that, by what the line misses."""
    table = np.column_stack([np.ones(len(x)), x / x.max()]) / error[:, None]
    found, *_ = np.linalg.lstsq(table, y / error, rcond=None)
    rest = y / error - table @ found
    variance = float(rest @ rest) / max(len(x) - 2, 1)
    return float(found[0]), math.sqrt(variance * np.linalg.inv(table.T @ table)[0, 0])


def contacts(stiffness, frame, reduced):
    """Returns the stiffnesses of the contacts alone (mN/um) and their areas (um^2) from those with the frame's compliance (um/mN) and beta Er."""
    compliance = 1 / stiffness - frame
    if not np.all(compliance > 0):
        raise Error(f"a frame with {1e3 * frame:.4g} nm/mN gives way more than frame and contact together ({1e3 / stiffness.max():.4g} nm/mN at least): "
                    "are the depths free of it already, or is the hardness of the specimen not the same at all depths?")
    return 1 / compliance, math.pi / 4 * (1 / (compliance * reduced)) ** 2


def fitted_area(depth, area, unsure, count):
    """Returns the coefficients C of the area sum C_k h^(2^(1 - k)) (nm^2) at contact depths h (nm), and the root mean square of what it
    misses as a share of the area. Fewer are taken where there are fewer depths. unsure: the standard errors of the stiffnesses as shares of
    them, of which the areas have twice as much.

    The unknowns are C_k h_max^(2^(1 - k)), and each equation is divided by its area and its error, so that all are of one size. Nothing
    holds the coefficients above zero: those of sharp tips are below, and tips.tip_of_function looks after small depths.
    """
    if not np.all(depth > 0):
        raise Error(f"a contact depth is not above zero ({depth.min():.3g} nm): do the depths count from the surface?")
    count = min(count, len(np.unique(np.round(depth, 3))))
    scales = [depth.max() ** 2.0 ** (1 - k) for k in range(count)]
    table = np.column_stack([depth ** 2.0 ** (1 - k) / scale for k, scale in enumerate(scales)]) / area[:, None]
    found, *_ = np.linalg.lstsq(table / unsure[:, None], 1 / unsure, rcond=ROUGH)
    return [float(value / scale) for value, scale in zip(found, scales)], float(np.sqrt(np.mean((table @ found - 1) ** 2)))


# ---- files ----

def write(calibration, path):
    """Writes a Calibration as JSON."""
    found = {"area_function_nm": calibration.coefficients, "area_error_percent": 100 * calibration.area_error,
             "frame_compliance_nm_per_mN": calibration.frame, "frame_compliance_error_nm_per_mN": calibration.frame_error,
             "contact_depths_nm": list(calibration.depths), "hardness_GPa": calibration.hardness, "reduced_modulus_GPa": calibration.modulus,
             "epsilon": EPSILON, "beta": calibration.beta,
             "tests": [{"name": name, "load_mN": row[0], "contact_depth_nm": row[1], "stiffness_mN_per_um": row[2], "area_nm2": row[3], "hardness_GPa": row[4],
                        "counts_for_the_frame": bool(counts)} for name, row, counts in zip(calibration.tests, calibration.rows.tolist(), calibration.shown)]}
    try:
        Path(path).write_text(json.dumps(found, indent=2) + "\n")
    except OSError as problem:
        raise ResultError(path, f"cannot be written to ({problem.strerror})") from None


def read(path):
    """Returns the Tip and the frame's compliance (nm/mN) of a file that write() has written."""
    try:
        found = json.loads(Path(path).read_text())
        coefficients, frame = [float(value) for value in found["area_function_nm"]], float(found["frame_compliance_nm_per_mN"])
        beta = float(found.get("beta", BETA))
        least, largest = map(float, found["contact_depths_nm"])
    except OSError as problem:
        raise ResultError(path, f"cannot be read ({problem.strerror})") from None
    except (KeyError, IndexError, TypeError, ValueError):
        raise ResultError(path, "is no calibration: scripts/calibrate.py writes one") from None
    if not coefficients or not all(map(math.isfinite, [*coefficients, frame])) or not 0 < least <= largest < math.inf:
        raise ResultError(path, "is no calibration: its coefficients, compliance and depths must be numbers")
    tip = tips.tip_of_function(coefficients, least=least * (1 - tips.ROUNDING), largest=largest * (1 + tips.ROUNDING))
    return tip._replace(beta=tips.constant(beta)), frame
