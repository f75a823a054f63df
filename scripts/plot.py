#!/usr/bin/env python3
"""Draws the pictures of one result folder: load_depth.png, stress_xx.png, _yy, _xy, energy.png; of metals von_mises_stress.png,
pressure.png and equivalent_plastic_strain.png too. Axisymmetric fields are mirrored at the axis."""

import argparse
import logging
from collections import namedtuple
from pathlib import Path

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # without a home folder it would tell about its cache
import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

import results

Unit = namedtuple("Unit", "factor name")  # value in SI x factor = value in the unit of this name
Scale = namedtuple("Scale", "low high colormap")  # limits of a colour scale in SI, and its colours

STRESS_COLUMN = {"xx": 0, "yy": 1, "zz": 2, "xy": 3}
SCALARS = {"von_mises_stress": ("von Mises stress", "Pa"), "pressure": ("pressure", "Pa"),  # datasets, with label and unit
           "equivalent_plastic_strain": ("equivalent plastic strain", ""), "temperature": ("temperature", "K")}
DOTS_PER_INCH = 160
LARGEST_PANEL, SMALLEST_PANEL = (6.4, 6.4), (2.2, 0.5)  # width and height of a field's axes in inches
LARGEST_ROW = 12.0  # width of all the axes in a row, in inches
plt.rcParams.update({
    "figure.dpi": DOTS_PER_INCH, "savefig.bbox": "tight", "savefig.pad_inches": 0.12,
    "font.size": 12, "axes.titlesize": 13, "axes.titlepad": 10,
    "legend.frameon": False, "legend.fontsize": 11, "legend.handlelength": 2.6,
    "axes.grid": False, "grid.color": "0.9", "axes.axisbelow": True, "lines.linewidth": 1.8,
    "axes.prop_cycle": plt.cycler(color=["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"],
                                  linestyle=["-", "--", "-.", "-", "--", "-."]),  # curves may coincide
})


def si_unit(values, symbol):
    """Returns the Unit with the prefix (n, u, m, k, ...) that puts the largest of |values| into 1 .. 1000."""
    largest = np.max(np.abs(values), initial=0)
    exponent = 3 * int(np.floor(np.log10(largest * (1 + 1e-9)) / 3)) if largest > 0 else 0
    exponent = min(max(exponent, -15), 12)
    return Unit(10.0**-exponent, "fpnµm kMGT"[exponent // 3 + 5].strip() + symbol)


def in_si_unit(value, symbol):
    """Returns a value as text with a prefixed unit: 2.25e-8, 's' gives '22.5 ns'."""
    unit = si_unit(value, symbol)
    return f"{value * unit.factor:.4g} {unit.name}"


def case_name(directory):
    """Returns the name of the case in a result folder, or the folder's own name while the run goes on."""
    return results.read_summary(directory).get("case") or Path(directory).resolve().name


# ---- lines ----

def line_axes(axes, xlabel, ylabel):
    """Gives axes the look that all line plots share."""
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.grid(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.02)


def draw_load_depth(axes, curves, load_unit, depth_unit):
    """Draws load against depth; curves is a list of (label, depth [rows] m, load [rows] N, line style)."""
    for label, depth, load, style in curves:
        axes.plot(depth * depth_unit.factor, load * load_unit.factor, label=label, **style)
    line_axes(axes, f"depth ({depth_unit.name})", f"load ({load_unit.name})")
    if len(curves) > 1:
        axes.legend()


def plot_load_depth(history, title, path):
    """Writes the picture of load against depth of one run."""
    load, depth = history["load"], history["depth"]
    figure, axes = plt.subplots(figsize=(6.4, 4.6))
    draw_load_depth(axes, [(title, depth, load, {})], si_unit(load, "N"), si_unit(depth, "m"))
    axes.set_title(title)
    save(figure, path)


def plot_energy(history, title, path):
    """Writes the picture of the energies and works against time, with the residual of their balance below."""
    residual = results.energy_residual(history)
    styles = {"kinetic_energy": "-", "strain_energy": "-", "dissipated_energy": "-",
              "external_work": "--", "indenter_work": "--"}
    time_unit, residual_unit = si_unit(history["time"], "s"), si_unit(residual, "J")
    unit = si_unit([history[name] for name in styles], "J")
    time = history["time"] * time_unit.factor
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7.6, 6.2), height_ratios=[2.6, 1],
                                          layout="constrained")
    for name, style in styles.items():
        above.plot(time, history[name] * unit.factor, style, label=name.replace("_", " "))
    below.plot(time, residual * residual_unit.factor, "-", color="0.25")
    below.axhline(0, color="0.6", linewidth=0.8)
    line_axes(above, "", f"energy ({unit.name})")
    line_axes(below, f"time ({time_unit.name})", f"residual ({residual_unit.name})")
    above.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    above.set_title(title)
    figure.align_ylabels()
    save(figure, path)


# ---- fields ----

def colour_scale(values, centred):
    """Returns the Scale of a field from its values [n], with the outer 0.5 % at each end left out.

    A field of both signs, or any `centred` one, gets limits that are symmetric about a white 0; one of a
    single sign gets colours that darken away from 0.
    """
    low, high = np.percentile(values, [0.5, 99.5]) if len(values) else (0, 0)
    largest = max(abs(low), abs(high))
    if centred or (low < 0 < high and min(-low, high) > 0.05 * largest) or largest == 0:
        return Scale(-largest or -1, largest or 1, "RdBu_r")
    margin = max(0, 1e-3 * largest - (high - low)) / 2
    return Scale(low - margin, high + margin, "magma" if low + high < 0 else "magma_r")


def in_window(points, window):
    """Returns a mask [n] of the points whose rectangle meets window (xmin, xmax, ymin, ymax) in m."""
    lower, upper = points["position"] - points["half_size"], points["position"] + points["half_size"]
    return np.all((upper >= window[0::2]) & (lower <= window[1::2]), axis=1)


def extent(points):
    """Returns the window (xmin, xmax, ymin, ymax) in m that the points fill, with a small margin."""
    lower = np.min(points["position"] - points["half_size"], axis=0)
    upper = np.max(points["position"] + points["half_size"], axis=0)
    margin = 0.02 * np.max(upper - lower)
    return np.column_stack([lower - margin, upper + margin]).ravel()


def panel(window, count):
    """Returns the window, widened where it is too slender to draw, and its (width, height) in inches.

    count: how many panels of this window stand side by side.
    """
    middle = np.array([window[0] + window[1], window[2] + window[3]]) / 2
    size = np.array([window[1] - window[0], window[3] - window[2]])
    inches_per_metre = min(np.min(LARGEST_PANEL / size), LARGEST_ROW / count / size[0])
    size = np.maximum(size, SMALLEST_PANEL / inches_per_metre)
    return np.column_stack([middle - size / 2, middle + size / 2]).ravel(), size * inches_per_metre


def draw_field(axes, points, component, boxes, window, scale, units):
    """Draws one component of the stress, or a scalar, of points over axes that show the window, and returns what colours it.

    points: dict with position [n][2] m, half_size [n][2] m (current half extents), stress [n][4] Pa;
    boxes [levels][lower, upper][2] m; window (xmin, xmax, ymin, ymax) m; units: Units of (length, stress).
    Each rectangle grows by half a dot, so that neighbours leave no white seams between them.
    """
    length, stress = units
    seen = np.flatnonzero(in_window(points, window))
    seen = seen[np.argsort(-points["half_size"][seen].prod(axis=1), kind="stable")]  # stretched points lie beneath the others
    dots = axes.get_window_extent().width
    half = points["half_size"][seen] + 0.5 * (window[1] - window[0]) / dots
    corners = points["position"][seen, None] + half[:, None] * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    colours = stress_of(points, component)[seen] * stress.factor
    squares = PolyCollection(corners * length.factor, array=colours, cmap=scale.colormap, closed=False,
                             edgecolors="none", antialiased=False, rasterized=True)
    squares.set_clim(scale.low * stress.factor, scale.high * stress.factor)
    axes.add_collection(squares, autolim=False)
    for lower, upper in boxes * length.factor:
        axes.add_patch(Rectangle(lower, *(upper - lower), fill=False, edgecolor="0.15", linewidth=0.7))
    axes.set(xlim=window[:2] * length.factor, ylim=window[2:] * length.factor, aspect="equal")
    axes.set(xlabel=f"x ({length.name})", ylabel=f"y ({length.name})")
    set_ticks(axes)
    return squares


def set_ticks(axes):
    """Gives both directions as many ticks, at round numbers, as their length on paper has room for."""
    width, height = axes.get_window_extent().size / axes.figure.dpi
    axes.xaxis.set_major_locator(MaxNLocator(int(np.clip(1.4 * width, 2, 8)), steps=[1, 2, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(int(np.clip(2 * height, 1, 8)), steps=[1, 2, 5, 10]))


def stress_of(points, component):
    """Returns one component of the stress, array [n] in Pa, by its name xx, yy, zz or xy, or one of the scalars."""
    return points[component] if component in SCALARS else points["stress"][:, STRESS_COLUMN[component]]


def unit_of(values, component):
    """Returns the Unit that a component's values are drawn in."""
    symbol = SCALARS.get(component, ("", "Pa"))[1]
    return si_unit(values, symbol) if symbol == "Pa" else Unit(1, symbol)


def label_of(component, unit):
    """Returns the text beside a colour bar."""
    name = SCALARS[component][0] if component in SCALARS else rf"$\sigma_{{{component}}}$"
    return f"{name} ({unit.name})" if unit.name else name


def add_colourbar(axes, squares, component, unit, scale, values):
    """Adds the colour bar of squares at the right of axes, or below them where they are low.

    Its ends are pointed where some of the values [n] Pa that are drawn lie outside the scale.
    """
    width, height = axes.get_window_extent().size / axes.figure.dpi
    upright = height > 1.8
    place = [1 + 0.2 / width, 0, 0.18 / width, 1] if upright else [0, -0.85 / height, 1, 0.18 / height]
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    beyond = ends[bool(np.any(values < scale.low)), bool(np.any(values > scale.high))]
    bar = axes.figure.colorbar(squares, cax=axes.inset_axes(place), extend=beyond, extendfrac=0.03,
                               orientation="vertical" if upright else "horizontal")
    bar.set_label(label_of(component, unit))
    bar.outline.set_linewidth(0.6)


def plot_fields(panels, component, path, window=None):
    """Writes a picture of one stress component with a panel for each of panels, side by side.

    panels is a list of (title, points, boxes); all share one window (m), colour scale, and units. Without a
    window the panels show all points.
    """
    points = [each for _, each, _ in panels]
    if window is None:
        extents = np.array([extent(each) for each in points])
        window = np.where([True, False] * 2, extents.min(axis=0), extents.max(axis=0))
    window, (width, height) = panel(np.asarray(window, float), len(panels))
    values = np.concatenate([stress_of(each, component)[in_window(each, window)] for each in points])
    scale = colour_scale(values, centred=component == "xy")
    units = si_unit(window, "m"), unit_of([scale.low, scale.high], component)
    figure = plt.figure(figsize=(len(panels) * (width + 1.1), height + 1.0))
    for place, (title, each, boxes) in enumerate(panels):
        axes = figure.add_axes([(place + 0.5) / len(panels), 0.5 / (height + 1.0),
                                width / figure.get_figwidth(), height / figure.get_figheight()])
        squares = draw_field(axes, each, component, boxes, window, scale, units)
        axes.set_title(title)
        if place > 0:
            axes.set_ylabel("")
    add_colourbar(axes, squares, component, units[1], scale, values)
    save(figure, path)


def read_panel(directory, number=None, title=None):
    """Returns (title, points, boxes) of a frame, by default of the last one, for plot_fields."""
    path = results.find_frame(directory, number)
    frame = results.read_frame(path)
    levels, boxes = results.slice_of(frame.levels, results.level_boxes(results.read_summary(directory)))
    points = results.all_points(levels)
    if "hoop_impulse_x" in results.read_history(directory):
        points, boxes = results.mirrored(points, boxes)
    if not len(points["position"]):
        raise results.ResultError(path, "holds no points")
    title = f"{title or case_name(directory)}, t = {in_si_unit(frame.time, 's')}"
    if frame.levels[0]["position"].shape[1] == 3:
        title += ", slice; y stands for z"
    return title, points, boxes


def save(figure, path):
    """Writes a figure, closes it and says so."""
    try:
        figure.savefig(path)
    except (OSError, ValueError) as problem:  # no such folder, no such kind of picture, a label that is no formula
        raise results.ResultError(path, f"cannot be drawn ({' '.join(str(problem).split())})") from None
    plt.close(figure)
    print(path)


# ---- command line ----

def window_argument(text):
    """Returns xmin,xmax,ymin,ymax (m) as an array of four numbers."""
    try:
        left, right, bottom, top = (float(number) for number in text.split(","))
    except ValueError:
        left, right, bottom, top = 0, 0, 0, 0
    window = np.array([left, right, bottom, top])
    if not (np.all(np.isfinite(window)) and left < right and bottom < top):
        raise argparse.ArgumentTypeError(f"{text}: must be xmin,xmax,ymin,ymax with min < max")
    return window


def add_window_option(parser):
    """Adds --window to a command line."""
    parser.add_argument("--window", type=window_argument, metavar="XMIN,XMAX,YMIN,YMAX",
                        help="part of the fields to show, in m (--window=... where it begins with a minus)")


def main(arguments=None):
    """Draws all pictures of the result folder that the command line names."""
    parser = results.Parser(description=__doc__)
    parser.add_argument("directory", metavar="DIR", help="result folder of a run")
    parser.add_argument("--frame", type=int, metavar="N", help="frame to draw (default: the last)")
    parser.add_argument("--out", metavar="DIR", help="folder for the pictures (default: the result folder)")
    add_window_option(parser)
    options = parser.parse_args(arguments)
    history = results.read_history(options.directory)
    field = read_panel(options.directory, options.frame)
    out = Path(options.out or options.directory)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise results.ResultError(out, f"must be a folder for pictures ({problem.strerror})") from None
    title = case_name(options.directory)
    if results.has_indenter(history):
        plot_load_depth(history, title, out / "load_depth.png")
    else:
        print("no load_depth.png: this run has no indenter")
    for component in ("xx", "yy", "xy"):
        plot_fields([field], component, out / f"stress_{component}.png", options.window)
    for component in SCALARS:
        if np.any(field[1].get("equivalent_plastic_strain", 0) > 0) and component in field[1]:
            plot_fields([field], component, out / f"{component}.png", options.window)
    plot_energy(history, title, out / "energy.png")


if __name__ == "__main__":
    main()
