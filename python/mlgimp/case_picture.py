"""The picture of a case before it runs: bodies, the indenter, loads, sides of the domain, and boxes of levels."""

from collections import namedtuple

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon, Rectangle

from . import fields, load_depth, outlines, parallelograms, results
from .errors import ResultError
from .fields import INDENTER_COLOUR
from .pictures import in_si_unit, lab_unit, styled, title_of

Case = namedtuple("Case", "options points boxes cell_sizes axes domain")
Case.__doc__ = """What is drawn of a case: its options; the points at the start, a dict with position and half_size [n][2] m and body
[n]; the boxes of levels that have points then, [levels][lower, upper][2] m, and their cell sizes (m); the names of the axes along and
up; and the domain, [lower, upper][2] m."""

BODY_COLOURS = "#cfdbe8", "#efdcc3", "#d5e5cf", "#e6d3e3", "#dddddd"
LOAD_COLOUR, LEVEL_COLOUR = "#D55E00", "0.1"
SIDES = {"free": ("0.35", ":", 1.2), "symmetry": ("#0072B2", "-.", 1.8), "axis": ("#009E73", "-.", 1.8), "fixed": ("#CC0000", "-", 2.4)}
ABOVE, BESIDE = 0.14, 0.06  # room around the domain, of its longer edge
SCALE = 0.72  # of the size that a picture of a field has
WINDOW, ENLARGED = 1.8, 3.0  # half widths of the contact that its enlarged surroundings reach; their width in inches
MOST_LINES, MOST_SIZES = 200, 5  # of cells, more would be grey; of cells that are listed, more would not fit
TALLEST = 5.6  # inches that the domain may be high
SLICE_OF_3D = 2  # the axis that is up in space, and the second one here


def read_case(directory):
    """Returns the Case of a result folder, from its first frame and its summary."""
    summary, frame = results.read_summary(directory), results.read_frame(results.find_frame(directory, 0))
    options = summary.get("options")
    if not options:
        raise ResultError(directory, "there is no summary.json with the options of the case")
    points, (boxes, sizes) = results.all_points(frame.levels), first_boxes(summary, frame.levels)
    domain = np.array([load_depth.numbers(options["-domain_lower"]), load_depth.numbers(options["-domain_upper"])])
    if domain.shape[1] == 2:
        return Case(options, points, boxes, sizes, "xy", domain)
    tip = load_depth.numbers(options["-indenter_tip"])[1] if options["-indenter"] != "none" else None
    return Case(options, *fields.slice_of(points, boxes, tip), sizes, "xz", domain[:, [0, SLICE_OF_3D]])


def first_boxes(summary, levels):
    """Returns the boxes [levels][lower, upper][axis] (m) and cell sizes (m) of the levels that have points at the start.

    levels: those of the first frame. Of a box that has moved since, the summary does not have the first place: it is the part of it
    that holds points.
    """
    boxes = results.level_boxes(summary)
    for level in {move["level"] for move in summary.get("regrids", [])}:
        position, half = levels[level]["position"], levels[level]["half_size"]
        if len(position):
            boxes[level] = (position - half).min(axis=0), (position + half).max(axis=0)
    kept = [level for level, points in enumerate(levels) if len(points["position"])]
    return boxes[kept], [summary["levels"][level]["cell_size"] for level in kept]


def in_plane(case, text):
    """Returns a vector of the options, as text, in the plane of the picture."""
    values = np.array(load_depth.numbers(text))
    return values if len(values) == 2 else values[[0, SLICE_OF_3D]]


# ---- the indenter ----

def outline(case, top):
    """Returns the corners [n][2] (m) of the part of the indenter below a height, on its side of a side of symmetry."""
    tip = in_plane(case, case.options["-indenter_tip"])
    corners = outlines.outline(case.options, top - tip[1]) + tip
    if abs(tip[0] - case.domain[0, 0]) < 1e-6 * np.ptp(case.domain):
        corners[:, 0] = np.maximum(corners[:, 0], case.domain[0, 0])
    return corners


# ---- drawing: each function returns its entries of the legend ----

def draw_bodies(axes, case, window, factor):
    """Draws the points of each body in its colour."""
    names = case.options["-bodies"].split(",")
    colours = [BODY_COLOURS[k % len(BODY_COLOURS)] for k in range(len(names))]
    image = parallelograms.paint(case.points, case.points["body"].astype(float), window, fields.dots_of(axes))
    axes.imshow(image, cmap=ListedColormap(colours), vmin=-0.5, vmax=len(names) - 0.5, origin="lower", extent=window * factor,
                interpolation="nearest", aspect="auto")
    entries = []
    for name, colour in zip(names, colours):
        speed = np.hypot(*in_plane(case, case.options[f"-{name}_velocity"]))
        material = case.options[f"-{name}_material"]
        moves = f", at {in_si_unit(speed, 'm/s')}" if speed else ""
        entries.append(Patch(facecolor=colour, edgecolor="0.6", label=f"{name}: {material}{moves}"))
    return entries


def draw_velocities(axes, case, window, factor):
    """Draws an arrow on each body that moves at the start."""
    for number, name in enumerate(case.options["-bodies"].split(",")):
        velocity, own = in_plane(case, case.options[f"-{name}_velocity"]), case.points["body"] == number
        if velocity.any() and own.any():
            draw_arrow(axes, case.points["position"][own].mean(axis=0), velocity / np.hypot(*velocity) * 0.25 * (window[3] - window[2]), factor, "0.25")
    return []


def draw_arrow(axes, start, way, factor, colour):
    """Draws an arrow from a place (m) along a way (m)."""
    axes.annotate("", (start + way) * factor, start * factor, annotation_clip=False,
                  arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0})


def draw_boxes(axes, case, window, factor):
    """Draws the boxes of the finer levels."""
    for lower, upper in case.boxes[1:] * factor:
        axes.add_patch(Rectangle(lower, *(upper - lower), fill=False, edgecolor=LEVEL_COLOUR, linewidth=1.0))
    unit = lab_unit(min(case.cell_sizes), "m")
    sizes = [f"{size * unit.factor:.4g}" for size in case.cell_sizes]
    sizes = ", ".join(sizes) if len(sizes) <= MOST_SIZES else f"{sizes[0]} to {sizes[-1]}"
    if len(case.boxes) < 2:
        return [Line2D([], [], linestyle="", label=f"one level, cells of {sizes} {unit.name}")]
    numbers_of_levels = {2: "box of level 1", 3: "boxes of levels 1 and 2"}
    label = numbers_of_levels.get(len(case.boxes), f"boxes of levels 1 to {len(case.boxes) - 1}")
    return [Line2D([], [], color=LEVEL_COLOUR, linewidth=1.0, label=label),
            Line2D([], [], linestyle="", label=f"cells of {sizes} {unit.name}")]


def draw_indenter(axes, case, window, factor):
    """Draws the indenter above the body, up to the window's top."""
    kind = case.options["-indenter"]
    if kind == "none":
        return []
    axes.add_patch(Polygon(outline(case, window[3]) * factor, facecolor=INDENTER_COLOUR, edgecolor="0.2", linewidth=0.8))
    return [Patch(facecolor=INDENTER_COLOUR, edgecolor="0.2", label=f"indenter: {kind.replace('_', ' ')}")]


def draw_contact(figure, corner, case, contact):
    """Draws the contact's surroundings, enlarged, with the lower left corner at a place of the figure (inches): the cells of the finest level,
    the tip at the start and, dashed, at its largest depth, and how many cells half the width of the contact has there.

    contact: of case_check.check: depth, surface and half_width (m), and cells.
    """
    half, surface, tip = contact["half_width"], contact["surface"], in_plane(case, case.options["-indenter_tip"])
    left = max(tip[0] - WINDOW * half, case.domain[0, 0])
    window = np.array([left, tip[0] + WINDOW * half, surface - 0.4 * WINDOW * half, surface + 0.5 * WINDOW * half])
    width, height = fields.fitted(window, 1)[1] * (ENLARGED / fields.fitted(window, 1)[1][0])
    size = figure.get_size_inches()
    axes = figure.add_axes([corner[0] / size[0], corner[1] / size[1], width / size[0], height / size[1]])
    unit = lab_unit(window - surface, "m")
    axes.set(xlim=window[:2] * unit.factor, ylim=window[2:] * unit.factor, xticks=[], yticks=[])
    draw_bodies(axes, case, window, unit.factor)
    draw_cells(axes, window, half / contact["cells"], surface, unit.factor)
    draw_indenter(axes, case, window, unit.factor)
    down = np.array([0, surface - contact["depth"] - tip[1]])
    axes.add_patch(Polygon((outline(case, window[3] - down[1]) + down) * unit.factor, fill=False, edgecolor="0.1", linewidth=1.2, linestyle="--"))
    axes.plot(np.array([tip[0], tip[0] + half]) * unit.factor, [surface * unit.factor] * 2, color=LOAD_COLOUR, linewidth=3.0, solid_capstyle="butt")
    axes.set_title(f"{contact['cells']:.3g} cells in half the contact\nat {in_si_unit(contact['depth'], 'm')} (dashed)", fontsize="medium", color=LOAD_COLOUR)


def draw_cells(axes, window, cell, surface, factor):
    """Draws the lines of cells in a window (m), of which one lies in the surface."""
    for across, draw in ((0, axes.axvline), (1, axes.axhline)):
        start = surface if across else 0.0
        first, last = np.ceil((window[2 * across] - start) / cell), np.floor((window[2 * across + 1] - start) / cell)
        if last - first < MOST_LINES:
            for k in np.arange(first, last + 1):
                draw((start + k * cell) * factor, color="0.55", linewidth=0.4, zorder=1.5)


def span_along(case, name, side, axis):
    """Returns the start and the end (m) of a load along an axis of its side; None where it acts on the whole side."""
    span = case.options[f"-{name}_span"].split(",")
    if "none" in span:
        return None
    place = [each for each in "xyz" if each != side[0]].index(axis)  # in space the span has two numbers for each axis of the side
    return np.array(span[2 * place:2 * place + 2] if len(span) > 2 else span, float)


def draw_loads(axes, case, window, factor):
    """Draws arrows on the part of a body's side that a pressure acts on."""
    entries, length = [], 0.09 * max(window[1] - window[0], window[3] - window[2])
    for name in filter(None, case.options["-loads"].split(",")):
        body, side = case.options[f"-{name}_body"], case.options[f"-{name}_side"]
        largest = max(load_depth.numbers(case.options[f"-{name}_pressures"]), key=abs)
        kind = "pressure" if largest > 0 else "tension"
        entries.append(Line2D([], [], color=LOAD_COLOUR, linewidth=1.6, label=f"{kind}, up to {in_si_unit(abs(largest), 'Pa')}"))
        own = case.points["body"] == case.options["-bodies"].split(",").index(body)
        if side[0] not in case.axes or not own.any():  # of a slice
            continue
        across, end = case.axes.index(side[0]), side[2:]
        ends = np.array([(case.points["position"] - case.points["half_size"])[own].min(axis=0),
                         (case.points["position"] + case.points["half_size"])[own].max(axis=0)])
        span = span_along(case, name, side, case.axes[1 - across])
        first, last = ends[:, 1 - across] if span is None else np.clip(span, *ends[:, 1 - across])
        outward = 1 if end == "upper" else -1
        for place in np.linspace(first, last, 7 if span is None else 3):
            foot, away = np.zeros(2), np.zeros(2)
            foot[across], foot[1 - across] = ends[1 if end == "upper" else 0, across], place
            away[across] = outward * length
            draw_arrow(axes, *((foot + away, -away) if largest > 0 else (foot, away)), factor, LOAD_COLOUR)
    return entries


def draw_sides(axes, case, window, factor):
    """Draws the four sides of the domain, each in the style of its kind."""
    lower, upper = case.domain * factor
    ends = {f"{case.axes[0]}_lower": ([lower[0]] * 2, [lower[1], upper[1]]), f"{case.axes[0]}_upper": ([upper[0]] * 2, [lower[1], upper[1]]),
            f"{case.axes[1]}_lower": ([lower[0], upper[0]], [lower[1]] * 2), f"{case.axes[1]}_upper": ([lower[0], upper[0]], [upper[1]] * 2)}
    seen = []
    for side, line in ends.items():
        kind = case.options[f"-boundary_{side}"]
        if side == "x_lower" and case.options["-geometry"] == "axisymmetric" and lower[0] == 0:
            kind = "axis"
        colour, style, width = SIDES[kind]
        axes.plot(*line, color=colour, linestyle=style, linewidth=width, clip_on=False, zorder=3)
        seen.append(kind)
    names = {"axis": "axis", "symmetry": "side: symmetry", "fixed": "side: fixed", "free": "side: free"}
    return [Line2D([], [], color=SIDES[kind][0], linestyle=SIDES[kind][1], linewidth=SIDES[kind][2], label=names[kind])
            for kind in names if kind in seen]


@styled
def case(directory, contact=None):
    """Returns the picture of the case of a result folder; in space it is the slice through the tip's axis.

    contact: what is known of the contact at its largest depth, of case_check.check: its surroundings are drawn as well, enlarged.
    """
    drawn = read_case(directory)
    edge = np.max(np.ptp(drawn.domain, axis=0))
    (left, low), (right, high) = drawn.domain
    window, size = fields.fitted(np.array([left - BESIDE * edge, right + BESIDE * edge, low - BESIDE * edge, high + ABOVE * edge]), 1)
    width, height = size * min(SCALE, TALLEST / size[1])
    wide, high = width + 4.2 + (0 if contact is None else ENLARGED + 0.2), max(height + 1.2, 3.6)
    figure = plt.figure(figsize=(wide, high))
    axes = figure.add_axes([0.8 / wide, 0.7 / high, width / wide, height / high])
    unit = lab_unit(window, "m")
    axes.set(xlim=window[:2] * unit.factor, ylim=window[2:] * unit.factor,
             xlabel=f"{drawn.axes[0]} ({unit.name})", ylabel=f"{drawn.axes[1]} ({unit.name})", title=title_of(directory))
    fields.set_ticks(axes)
    axes.spines[["top", "right", "bottom", "left"]].set_visible(False)
    parts = draw_bodies, draw_indenter, draw_loads, draw_boxes, draw_velocities, draw_sides
    entries = [entry for draw in parts for entry in draw(axes, drawn, window, unit.factor)]
    axes.legend(handles=entries, loc="center left", bbox_to_anchor=(1.03, 0.5), borderaxespad=0)
    if contact is not None:
        draw_contact(figure, (width + 4.2, 0.7), drawn, contact)
    return figure
