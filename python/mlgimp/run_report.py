"""A page about a run, report.html: the case, the curve, the field over the frames with a slider, budgets, figures, options. It needs no
other file. What a run does not have is left out, and a line says why."""

import html
import io
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from . import budgets, case_picture, load_depth, oliver_pharr, page_parts, pictures, results, surface
from .errors import Error, ResultError
from .film import film
from .page_parts import bullets, document, drawing, folded, how_made, image, paragraphs, table
from .report_page import facts_of, figures_of

EACH = "cycle", "depth_um", "load_mN", "hardness_GPa", "true_hardness_GPa", "reduced_modulus_GPa"  # of all unloadings
SURFACE_DOTS = 90  # per inch, of the picture of a surface
VIEWER = """<div class="viewer">
<p class="state" id="state" aria-live="polite">The fields are being unpacked; without JavaScript they are not shown.</p>
<canvas id="field" role="img" tabindex="0" aria-label="field over the points"></canvas>
<div class="controls">
<button type="button" id="play">Play</button>
<input type="range" id="frame" min="0" max="0" value="0" step="1" aria-label="frame">
<label>field <select id="component">{choices}</select></label>
<label><input type="checkbox" id="logarithmic"> logarithmic scale</label>
<button type="button" id="near">Near</button>
<button type="button" id="all">All</button>
</div>
<p class="state" id="value">The arrow keys move over the frames, + and - zoom, after a click on the field the wheel too; the mouse drags, and the value
under it stands here.</p>
</div>"""


def report(directory, path=None, command=""):
    """Writes the page about the run in a folder to path, by default report.html in that folder, and returns its path.

    command: the command line that asked for it, for the end of the page. Raises a ResultError where the folder has no results.
    """
    directory = Path(directory)
    history, summary = results.read_history(directory), results.read_summary(directory)
    if not len(history["time"]):
        raise ResultError(directory, "history.csv has no rows yet: has the run begun?")
    sections = case, curves, fields_over_frames, surface_view, figures, balances, about
    parts = [part for section in sections for part in attempted(section, directory, history, summary)]
    path = directory / "report.html" if path is None else Path(path)
    title = results.case_name(directory)
    page_parts.write(path, document(title, parts + how_made(command), "viewer.js" if any('id="film"' in part for part in parts) else ""))
    return path


def attempted(section, directory, history, summary):
    """Returns the parts of a section, or of one that this run cannot have a line that says why."""
    try:
        return section(directory, history, summary)
    except Error as problem:
        return paragraphs([f"{section.__doc__.split(':')[0]}: {getattr(problem, 'problem', problem)}."])


# ---- sections: each returns parts of the page, and its docstring begins with what the reader knows it by ----

def case(directory, history, summary):
    """The case: facts about the run, its warnings, and the picture of its start."""
    parts = [table([], facts(directory, history, summary)), *paragraphs(summary.get("warnings", []), "warning")]
    if summary.get("status", results.NOT_ENDED) == results.NOT_ENDED:
        parts += paragraphs(["The run goes on, or was ended from outside: this is how far it came."], "warning")
    if not summary:
        return parts + paragraphs(["There is no summary.json, so that boxes of levels, the indenter's shape and the options are not known."], "warning")
    return parts + ["<h2>The case</h2>", drawing(case_picture.case(directory), f"the case {results.case_name(directory)} at its start")]


def curves(directory, history, summary):
    """Load and depth: the curve, and over the time of the test where it has one."""
    title, parts = pictures.title_of(directory), []
    if results.has_indenter(history):
        words = (f"load over depth, up to {pictures.in_si_unit(np.nanmax(history['load']), 'N')} and "
                 f"{pictures.in_si_unit(np.nanmax(history['depth']), 'm')}")
        parts += ["<h2>Load and depth</h2>", '<div class="marked">', drawing(pictures.load_depth(history, title), words),
                  '<span class="mark" id="mark"></span>', "</div>"]
    if "test_time" in history:
        parts.append(drawing(pictures.test(history, title), "depth and load over the time of the test"))
    return parts


def fields_over_frames(directory, history, summary):
    """Fields: those of the frames on a canvas with a slider, and what of them is not here."""
    shown = film(directory)
    shown.values["marks"] = marks(history, pictures.title_of(directory), [shot["time"] for shot in shown.values["frames"]])
    choices = "".join(f'<option value="{html.escape(each["name"])}">{html.escape(each["label"])}</option>' for each in shown.values["fields"])
    parts = ["<h2>Fields</h2>", VIEWER.format(choices=choices), page_parts.data("film", shown.values)]
    notes = ["In space it is the slice through the tip's axis."] * (shown.values["axes"][1] == "z")
    notes += ["The left half is the image of the right one at the axis."] * shown.values["mirror"]
    notes += [f"To keep this file small, it does not have {', '.join(shown.left_out)}; the result folder has them."] * bool(shown.left_out)
    return parts + bullets(notes)


def surface_view(directory, history, summary):
    """The surface: in space that under the tip, coloured."""
    options = summary.get("options", {})
    if options.get("-geometry") != "3d" or not results.has_indenter(history):
        return []
    points = results.all_points(results.read_frame(results.find_frame(directory)).levels)
    is_metal = np.any(points.get("equivalent_plastic_strain", 0) > 0)
    figure = surface.plastic_surface(directory) if is_metal else surface.contact_pressure(directory)
    dots = io.BytesIO()
    figure.savefig(dots, dpi=SURFACE_DOTS, bbox_inches="tight")
    plt.close(figure)
    words = "the surface at the end, coloured by equivalent plastic strain" if is_metal else "the pressure of contact on the surface at the largest load"
    return ["<h2>The surface</h2>", image(dots.getvalue(), "png", words)]


def figures(directory, history, summary):
    """Hardness and modulus: by Oliver and Pharr from the unloadings."""
    if not results.has_indenter(history):
        return []
    curve = load_depth.read_run(directory)
    rows = oliver_pharr.analyse(curve)
    largest = max(rows, key=lambda row: row["load_mN"])
    parts = ["<h2>Figures of the unloading</h2>"]
    parts += paragraphs([f"Of {len(rows)} unloadings that from the largest load, number {largest['cycle']}."] * (len(rows) > 1))
    parts += [table(("", "value", "", "uncertainty"), [row[:4] for row in figures_of(largest)], {1, 3})]
    if len(rows) > 1:
        parts += ["<h3>All unloadings</h3>", table([name.replace("_", " ") for name in EACH], [[shortly(row[name]) for name in EACH] for row in rows],
                                                   set(range(len(EACH))))]
    parts += paragraphs([line for line in (largest["warnings"],) if line], "warning")
    return parts + bullets([*curve.notes, *oliver_pharr.notes_on(rows)])


def shortly(value):
    """Returns a number as text with four digits; - where it is not known."""
    return f"{value:.4g}" if value == value else "-"


def balances(directory, history, summary):
    """Balances: energy, momentum and mass, and what the run cannot account for."""
    found = budgets.budgets(history)
    if not found:
        return []
    words = "energies and works over time, and the residual of their balance"
    lost = [f"{summary['points_lost']} points were lost."] if summary.get("points_lost") else []
    return ["<h2>Balances</h2>", drawing(pictures.energy(history, pictures.title_of(directory)), words),
            table(("", "largest", "not accounted for", "share"), budgets.rows_of(found), {1, 2, 3}), *paragraphs(lost, "warning")]


def about(directory, history, summary):
    """Options: those of the case, and the versions of the programs."""
    options = sorted((name, str(value)) for name, value in summary.get("options", {}).items())
    versions = sorted((name, str(value)) for name, value in summary.get("versions", {}).items())
    parts = ["<h2>Options and versions</h2>"] * bool(options or versions)
    parts += folded(f"{len(options)} options of the case", table([], options)) if options else []
    return parts + ([table([], versions)] if versions else [])


# ---- facts ----

def facts(directory, history, summary):
    """Returns rows (what, text) about a run."""
    levels, found = summary.get("levels", []), [("folder", directory.resolve().name), ("status", str(summary.get("status", results.NOT_ENDED)))]
    if results.has_indenter(history):
        try:
            found += [row for row in facts_of(load_depth.read_run(directory), directory)[0] if row[0] not in ("rows", "status of the run", "version")]
        except ResultError:  # a curve of one row
            pass
    cells = ", ".join(pictures.in_si_unit(level["cell_size"], "m") for level in levels if "cell_size" in level)
    found += [("cells", f"{cells} on {len(levels)} level{'s' * (len(levels) > 1)}")] * bool(cells)
    found += [("points", f"{history['points'][-1]:.0f}")] * ("points" in history)
    found += [("simulated", f"{pictures.in_si_unit(history['time'][-1], 's')}, {history['step'][-1]:.0f} steps of the coarsest level" if "step" in history
               else pictures.in_si_unit(history["time"][-1], "s"))]
    if "wall_seconds" in summary:
        found.append(("took", f"{summary['wall_seconds']:.3g} s; ranks: {summary.get('ranks', 1)}"))
    return found


def marks(history, title, times):
    """Returns where the times (s) of frames lie in the picture of load over depth with this title, [frames][2], as shares of its width from the left and of
    its height from above; None of a run without an indenter."""
    if not results.has_indenter(history):
        return None
    figure = pictures.load_depth(history, title)
    axes, size = figure.axes[0], figure.bbox.size
    figure.draw_without_rendering()  # which lays it out
    load, depth = pictures.lab_unit(history["load"], "N"), pictures.lab_unit(history["depth"], "m")
    at = [np.interp(times, history.beside("load", "time"), history[name]) * unit.factor for name, unit in (("depth", depth), ("load", load))]
    places = axes.transData.transform(np.transpose(at)) / size
    plt.close(figure)
    return [[round(float(x), 4), round(float(1 - y), 4)] for x, y in places]
