"""A page about tests, indentation.html: what was tested, pictures, figures with their uncertainties, notes. It needs no other file."""

import base64
import html
import math
import platform
from datetime import datetime

import numpy as np
import scipy

from . import results

STYLE = """body { font: 15px/1.45 sans-serif; color: #111; max-width: 60em; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.2em; margin-top: 2em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: 0.8em 0; } td, th { padding: 0.2em 0.9em 0.2em 0; text-align: left; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; } tr { border-bottom: 1px solid #eee; }
img { max-width: 100%; } .warning { color: #a00; } code { overflow-wrap: anywhere; }
@media print { body { margin: 0; max-width: none; } details > * { display: block; } h2, table, img { break-inside: avoid; } }"""
MATERIAL = ("_model", "_youngs_modulus", "_poissons_ratio", "_yield_stress", "_hardening", "_hardening_modulus", "_hardening_exponent", "_density")


def page(title, tests, pictures, command=""):
    """Returns the text of the page.

    tests: a dict for each, {"name", "facts": [(what, text)], "options": {option: value}, "figures": rows of texts (label, value, unit,
    uncertainty, interval), "sources": rows of texts of a table whose first is its head, "notes", "warnings": texts}. pictures: paths of
    PNG files. All texts may have any letters.
    """
    parts = ["<!DOCTYPE html>", '<html lang="en">', "<head>", '<meta charset="utf-8">', f"<title>{html.escape(title)}</title>",
             f"<style>{STYLE}</style>", "</head>", "<body>", f"<h1>{html.escape(title)}</h1>"]
    for number, path in enumerate(pictures, start=1):
        data = base64.b64encode(path.read_bytes()).decode()
        parts.append(f'<p><img alt="picture {number}: {html.escape(path.name)}" src="data:image/png;base64,{data}"></p>')
    for test in tests:
        parts += section(test)
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    parts += ["<h2>How it was made</h2>", f"<p>{datetime.now():%Y-%m-%d %H:%M}, {html.escape(versions)}.</p>"]
    parts += [f"<p><code>{html.escape(command)}</code></p>"] * bool(command)
    return "\n".join([*parts, "</body>", "</html>", ""])


def section(test):
    """Returns the parts of the page about a test."""
    parts = [f"<h2>{html.escape(test['name'])}</h2>", table([], test["facts"])]
    parts += [f'<p class="warning">{html.escape(line)}</p>' for line in test["warnings"]]
    if test["figures"]:
        parts.append(table(("", "value", "", "uncertainty", "95 % of the draws"), test["figures"], {1, 3, 4}))
    if test["sources"]:
        head, *rows = test["sources"]
        parts += ["<h3>Standard uncertainties by source</h3>", table(head, rows, set(range(2, len(head))))]
    if test["notes"]:
        parts += ["<ul>", *(f"<li>{html.escape(line)}</li>" for line in test["notes"]), "</ul>"]
    if test["options"]:
        parts += ["<details>", "<summary>All options of the run</summary>", table([], sorted(test["options"].items())), "</details>"]
    return parts


def table(head, rows, numbers=()):
    """Returns a table of texts; numbers: places of the columns that are aligned at their right ends."""
    def cells(kind, row):
        return "".join(f'<{kind} class="number">{html.escape(str(text))}</{kind}>' if place in numbers else f"<{kind}>{html.escape(str(text))}</{kind}>"
                       for place, text in enumerate(row))
    lines = ["<table>"] + [f"<tr>{cells('th', head)}</tr>"] * bool(head)
    return "\n".join([*lines, *(f"<tr>{cells('td', row)}</tr>" for row in rows), "</table>"])


# ---- what the page says of a test ----

def facts_of(curve, folder=None):
    """Returns rows (what, text) about a Curve, and of the folder of a run its material and the program's version; and its options."""
    found = [("tip", curve.tip.name.replace("_", " ") if curve.tip else "not known"),
             ("Poisson's ratio", "not known" if curve.poisson is None else f"{curve.poisson:g}"),
             ("rows", str(len(curve.load))), ("largest depth and load", f"{curve.depth.max():.4g} um, {curve.load.max():.4g} mN")]
    if folder is None:
        return found + [("measured curve", curve.name)], {}
    summary = results.read_summary(folder)
    options = {name: str(value) for name, value in summary.get("options", {}).items()}
    found += [(name.lstrip("-").replace("_", " "), value) for name, value in options.items() if name.startswith("-indenter_") and value and value != "0"
              and name.removeprefix("-indenter_") in ("half_angle", "radius", "tip_radius", "faces", "friction")]
    found += [(name.lstrip("-").replace("_", " "), value) for name, value in options.items() if name.endswith(MATERIAL)]
    found += [("status of the run", str(summary.get("status", "not ended")))]
    found += [("version", ", ".join(f"{name} {value}" for name, value in summary["versions"].items()))] if isinstance(summary.get("versions"), dict) else []
    return found, options


def figures_of(row, shown, uncertainty=None):
    """Returns rows of texts of a dict of results: shown is (label, name, unit) of each figure; what is not known is left out."""
    found = []
    for label, name, unit in shown:
        if math.isnan(row[name]):
            continue
        error, interval = (row["expected_error"] or {}).get(name, math.nan), ""
        words = f"cells: {100 * error:.2g} %" if math.isfinite(error) else ""
        if uncertainty and math.isfinite(uncertainty.values.get(name, math.nan)):
            words = f"{uncertainty.deviation[name]:.3g}"
            interval = f"{uncertainty.lower[name]:.5g} to {uncertainty.upper[name]:.5g}"
        found.append((label, f"{row[name]:.5g}", unit, words, interval))
    return found
