"""The numbers of ISO 14577-1 for instrumented indentation, and hardness scales beside them, of runs and of measured curves alike.

The norm itself was not at hand: docs/indentation.md says where each definition was seen. Units: mN, um, GPa = mN/um^2.
"""

import math

import numpy as np
from scipy.special import gammaln

WINDOW = (0.4, 0.98)  # of the load: the part of the unloading that is fitted; instruments that follow the norm print such limits
COLUMNS = ("HM_GPa", "HMs_GPa", "H_IT_GPa", "E_IT_GPa", "E_IT_plane_strain_GPa", "eta_IT_percent", "HV", "HBW", "HRC", "HRB")
RISING = 0.5, 0.9  # of the largest load: the part of the loading whose slope gives HMs
VICKERS = 94.5  # HV per GPa of H_IT: projected over true area of the imprint, sin 68 degrees, over 9.80665e-3 kgf/mm^2
KGF = 0.102  # kgf per N
PRELOAD = 98.07e3  # mN, 10 kgf, of the Rockwell scales
ROCKWELL = {"HRC": (1471e3, 100.0), "HRB": (980.7e3, 130.0)}  # mN, 150 and 100 kgf; the number at depth zero
STEP = 2.0  # um of a point of these scales
NEAR = 0.05  # of a load: so near a sequence must come to those of a scale, whose machines keep them within 1 %
CONE, CONE_BALL, BALL = (60.0, 200.0, 1587.5 / 2)  # degrees from the axis and um of the tips of the scales C, and um of B
LIKE = 0.03  # of angles and radii of these tips


def epsilon(exponent):
    """Returns epsilon of the contact depth for the exponent m of the unloading, between 1 of a flat punch and 0.7 or so.

    m (1 - 2 (m - 1) Gamma(m/(2(m - 1)))/(sqrt(pi) Gamma(1/(2(m - 1))))), of the effective indenter of Pharr and Bolshakov, J. Mater. Res. 17
    (2002) 2660: 1 for m = 1, 0.75 for m = 1.5, 2 - 4/pi = 0.7268 for m = 2. exponent: a number or an array.
    """
    above = np.maximum(exponent - 1, 1e-6)
    ratio = np.exp(gammaln(exponent / (2 * above)) - gammaln(1 / (2 * above)))
    return np.where(exponent - 1 < 1e-6, 1.0, exponent * (1 - 2 * above * ratio / math.sqrt(math.pi)))[()]


def figures(curve, cycle, fit, row, plane_strain):
    """Returns the results COLUMNS of a cycle with its Unloading, of its dict of results and the modulus E/(1 - nu^2) (GPa) of the specimen;
    NaN for what the tip or the test does not have."""
    tip, found = curve.tip, dict.fromkeys(COLUMNS, math.nan)
    total = row["total_work_nJ"]
    found["eta_IT_percent"] = 100 * row["elastic_work_nJ"] / total if total > 0 else math.nan
    if tip is None:
        return found
    found |= {"H_IT_GPa": row["hardness_GPa"], "E_IT_GPa": row["modulus_GPa"], "E_IT_plane_strain_GPa": plane_strain}
    surface = tip.slant * float(tip.area(fit.depth))
    if surface > 0:
        found |= {"HM_GPa": fit.load / surface, "HMs_GPa": martens_of_slope(curve, cycle, fit.load, surface / fit.depth**2)}
    if tip.name in ("vickers", "berkovich", "area function"):
        found["HV"] = VICKERS * row["hardness_GPa"]
    if tip.name == "sphere":
        area = row["true_area_um2"] if math.isfinite(row["true_area_um2"]) else row["area_um2"]
        found["HBW"] = brinell(fit.load, tip.radius, area)
    return found | rockwell(curve, cycle, fit.load)


def martens_of_slope(curve, cycle, top, surface):
    """Returns HMs = 1/(m^2 A_s/h^2) of the line h = h0 + m sqrt(F) through the loading between the shares RISING of its load (mN), which no
    zero of the depth changes; surface: A_s/h^2. NaN where fewer than three rows are there."""
    rows = np.arange(cycle.begin, cycle.start + 1)
    rows = rows[(curve.load[rows] >= RISING[0] * top) & (curve.load[rows] <= RISING[1] * top)]
    if len(rows) < 3 or not np.ptp(curve.load[rows]) > 0:
        return math.nan
    slope = np.polyfit(np.sqrt(curve.load[rows]), curve.depth[rows], 1)[0]
    return float(1 / (slope**2 * surface)) if slope > 0 else math.nan


def brinell(load, radius, area):
    """Returns HBW = 0.102 2 F/(pi D (D - sqrt(D^2 - d^2))) with F in N and lengths in mm: of a load (mN) under a ball with a radius (um), with
    the diameter d of the contact's area (um^2) at this load, as the imprint of a metal keeps it."""
    if not 0 < area <= math.pi * radius**2:
        return math.nan
    diameter, across = 2e-3 * radius, 2e-3 * math.sqrt(area / math.pi)
    return KGF * 2e-3 * load / (math.pi * diameter * (diameter - math.sqrt(diameter**2 - across**2)))


def rockwell(curve, cycle, top):
    """Returns {"HRC": ..., "HRB": ...}, NaN but for the scale whose tip and loads a cycle has: HRC = 100 - h/(2 um), HRB = 130 - h/(2 um),
    with the depth h that is left under the preload after the whole load, over that under the preload before it."""
    found = dict.fromkeys(ROCKWELL, math.nan)
    scale = scale_of(curve.tip)
    if scale is None or abs(top / ROCKWELL[scale][0] - 1) > NEAR:
        return found
    up, down = slice(cycle.begin, cycle.start + 1), slice(cycle.start, cycle.end + 1)
    before = np.flatnonzero(curve.load[up] <= (1 + NEAR) * PRELOAD)
    after = np.flatnonzero(curve.load[down] >= (1 - NEAR) * PRELOAD)
    if not len(before) or curve.load[up][before[-1]] < (1 - NEAR) * PRELOAD or abs(curve.load[down][after[-1]] / PRELOAD - 1) > NEAR:
        return found
    rest = curve.depth[down][after[-1]] - curve.depth[up][before[-1]]
    return found | {scale: ROCKWELL[scale][1] - float(rest) / STEP}


def scale_of(tip):
    """Returns the Rockwell scale that has a Tip, or None."""
    if tip.name == "cone" and abs(math.degrees(math.asin(1 / tip.slant)) / CONE - 1) < LIKE and abs(tip.radius / CONE_BALL - 1) < LIKE:
        return "HRC"
    return "HRB" if tip.name == "sphere" and abs(tip.radius / BALL - 1) < LIKE else None
