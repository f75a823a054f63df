"""What a notebook shows of the results of a run: small pictures, figures and warnings, as a piece of HTML."""

import html
import io

from matplotlib import pyplot as plt

from . import pictures, results
from .errors import Error
from .folder import FIGURES
from .page_parts import image, paragraphs, table

DOTS = 60  # per inch: the pictures stay small


def html_of(run):
    """Returns the piece of HTML about Results; what the run does not have, as a curve or frames, is left out."""
    status = run.summary.get("status", results.NOT_ENDED)
    parts = [f"<div><p><b>{html.escape(run.folder.name)}</b>: {html.escape(str(status))}, {len(run.frames)} frames in <code>{html.escape(str(run.folder))}</code></p>"]
    parts += [attempted(part, run) for part in (drawn, figures)]
    return "\n".join([*parts, *paragraphs(run.summary.get("warnings", [])), "</div>"])


def attempted(part, run):
    """Returns a part, or nothing where the run does not have what it shows."""
    try:
        return part(run)
    except Error:
        return ""


def drawn(run):
    """Returns load over depth and the last von Mises stress, near the contact where there is one, beside each other."""
    found = []
    for name, words, window in (("load_depth", "load over depth", None), ("von_mises_stress", "von Mises stress at the end", "near")):
        try:
            figure = run.plot(name, window=window)[name]
        except Error:  # a run without an indenter, or without frames
            continue
        dots = io.BytesIO()
        figure.savefig(dots, dpi=DOTS, bbox_inches="tight")
        plt.close(figure)
        found.append(image(dots.getvalue(), "png", words))
    return "".join(found)


def figures(run):
    """Returns the table of hardness and modulus, of the unloading from the largest load, and of the largest load and depth."""
    curve = run.curve()
    rows = [("largest load", pictures.in_si_unit(1e-3 * curve.load.max(), "N"), ""), ("largest depth", pictures.in_si_unit(1e-6 * curve.depth.max(), "m"), "")]
    try:
        largest = max(run.oliver_pharr(), key=lambda row: row["load_mN"])
    except Error:  # no unloading
        return table([], rows)
    errors = largest["expected_error"] or {}
    rows += [(label, pictures.in_si_unit(1e9 * largest[name], "Pa"), f"± {100 * errors[name]:.2g} %" if name in errors else "")
             for label, name in FIGURES if largest[name] == largest[name]]
    return table([], rows)
