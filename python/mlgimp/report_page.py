"""A page about tests, indentation.html: what was tested, pictures, figures with their uncertainties, notes. It needs no other file."""

import html
import math

from . import load_depth, pictures, results
from .page_parts import bullets, document, folded, how_made, image, paragraphs, table

UNITS = {"_youngs_modulus": "Pa", "_yield_stress": "Pa", "_hardening_modulus": "Pa", "_density": "kg/m3", "_half_angle": "degrees", "_radius": "m"}
MATERIAL = ("_model", "_youngs_modulus", "_poissons_ratio", "_yield_stress", "_hardening", "_hardening_modulus", "_hardening_exponent", "_density")
SHOWN = (("load", "load_mN", "mN"), ("depth", "depth_um", "um"), ("stiffness", "stiffness_mN_per_um", "mN/um"), ("exponent m", "exponent", ""),
         ("contact depth", "contact_depth_um", "um"), ("area", "area_um2", "um2"), ("true area", "true_area_um2", "um2"),
         ("hardness", "hardness_GPa", "GPa"), ("load over true area", "true_hardness_GPa", "GPa"), ("reduced modulus", "reduced_modulus_GPa", "GPa"),
         ("specimen's modulus", "modulus_GPa", "GPa"), ("the same with the true area", "true_modulus_GPa", "GPa"), ("epsilon", "epsilon", ""),
         ("beta", "beta", ""), ("pile-up (< 0: sink-in)", "pile_up_um", "um"), ("plastic over total work", "plastic_share", ""), ("cells in half the width", "cells", ""),
         ("hold from", "hold_start_s", "s"), ("hold to", "hold_end_s", "s"), ("creep C_IT", "C_IT_percent", "%"), ("relaxation R_IT", "R_IT_percent", "%"),
         ("rate of creep at its end", "creep_rate_um_per_s", "um/s"), ("rate of unloading", "unloading_rate_mN_per_s", "mN/s"),
         ("stiffness without creep", "corrected_stiffness_mN_per_um", "mN/um"), ("hardness with it", "corrected_hardness_GPa", "GPa"),
         ("reduced modulus with it", "corrected_reduced_modulus_GPa", "GPa"), ("specimen's modulus with it", "corrected_modulus_GPa", "GPa"),
         ("HM", "HM_GPa", "GPa"), ("HMs", "HMs_GPa", "GPa"), ("H_IT", "H_IT_GPa", "GPa"), ("E_IT", "E_IT_GPa", "GPa"),
         ("E_IT/(1 - nu^2)", "E_IT_plane_strain_GPa", "GPa"), ("eta_IT", "eta_IT_percent", "%"), ("HV", "HV", ""), ("HBW", "HBW", ""), ("HRC", "HRC", ""),
         ("HRB", "HRB", ""))


def page(title, tests, pictures, command=""):
    """Returns the text of the page.

    tests: a dict for each, {"name", "facts": [(what, text)], "options": {option: value}, "figures": rows of texts (label, value, unit,
    uncertainty, interval), "sources": rows of texts of a table whose first is its head, "notes", "warnings": texts}. pictures: paths of
    PNG files. All texts may have any letters.
    """
    parts = [f"<p>{image(path.read_bytes(), 'png', f'picture {number}: {path.name}')}</p>" for number, path in enumerate(pictures, start=1)]
    for test in tests:
        parts += section(test)
    return document(title, parts + how_made(command))


def section(test):
    """Returns the parts of the page about a test."""
    parts = [f"<h2>{html.escape(test['name'])}</h2>", table([], test["facts"])]
    parts += paragraphs(test["warnings"], "warning")
    if test["figures"]:
        parts.append(table(("", "value", "", "uncertainty", "95 % of the draws"), test["figures"], {1, 3, 4}))
    if test["sources"]:
        head, *rows = test["sources"]
        parts += ["<h3>Standard uncertainties by source</h3>", table(head, rows, set(range(2, len(head))))]
    parts += bullets(test["notes"])
    return parts + (folded("All options of the run", table([], sorted(test["options"].items()))) if test["options"] else [])


# ---- what the page says of a test ----

def facts_of(curve, folder=None, poisson=None):
    """Returns rows (what, text) about a Curve, and of the folder of a run its material and the program's version; and its options. poisson: a ratio
    that counts more than the Curve's."""
    summary = {} if folder is None else results.read_summary(folder)
    options = {name: str(value) for name, value in summary.get("options", {}).items()}
    poisson = curve.poisson if poisson is None else poisson
    tip = curve.tip.name if curve.tip else options.get("-indenter", "not known")
    found = [("tip", tip.replace("_", " ")), ("Poisson's ratio", "not known" if poisson is None else f"{poisson:g}"),
             ("rows", str(len(curve.load))), ("largest depth and load", largest(curve, load_depth.parts_of_tip(options)))]
    if folder is None:
        return found + [("measured curve", curve.name)], {}
    has_elastic_tip = options.get("-indenter_youngs_modulus", "none") != "none"
    found += [(name.lstrip("-").replace("_", " "), with_unit(name, value)) for name, value in options.items()
              if name.startswith("-indenter_") and value not in ("", "0", "none")
              and name.removeprefix("-indenter_") in ("half_angle", "radius", "tip_radius", "faces", "friction")]
    found += [(name.lstrip("-").replace("_", " "), with_unit(name, value)) for name, value in options.items()
              if name.endswith(MATERIAL) and value != "none" and (has_elastic_tip or not name.startswith("-indenter_"))]
    found += [("status of the run", str(summary.get("status", results.NOT_ENDED)))]
    found += [("version", ", ".join(f"{name} {value}" for name, value in summary["versions"].items()))] if isinstance(summary.get("versions"), dict) else []
    return found, options


def largest(curve, parts):
    """Returns the largest depth and load of a Curve as text, with those of the model where that is one of several parts."""
    load = curve.load.max()
    whole = f"{load:.4g} mN" if parts == 1 else f"{load / parts:.4g} mN of the model, {load:.4g} mN of the whole tip ({parts} x the model)"
    return f"{curve.depth.max():.4g} um, {whole}"


def with_unit(name, value):
    """Returns the value of an option as people read it: 70 GPa of 7e+10; as it is where its unit is not known here."""
    symbol = next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")
    try:
        return pictures.in_si_unit(float(value), symbol) if symbol in ("Pa", "m") else f"{float(value):.6g} {symbol}".rstrip()
    except ValueError:
        return value


def figures_of(row, uncertainty=None):
    """Returns rows of texts of a dict of results, those of SHOWN; what is not known is left out."""
    found = []
    for label, name, unit in SHOWN:
        if math.isnan(row[name]):
            continue
        error, interval = (row["expected_error"] or {}).get(name, math.nan), ""
        words = f"cells and block: {100 * error:.2g} %" if math.isfinite(error) else ""
        if uncertainty and math.isfinite(uncertainty.values.get(name, math.nan)):
            words = f"{uncertainty.deviation[name]:.3g}"
            interval = f"{uncertainty.lower[name]:.5g} to {uncertainty.upper[name]:.5g}"
        found.append((label, f"{row[name]:.5g}", unit, words, interval))
    return found
