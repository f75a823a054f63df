"""Fields of points in a plane: the plane itself in two dimensions, mirrored at the axis in axisymmetry, in space the slice
through the tip's axis."""

from collections import namedtuple

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from matplotlib.patches import Polygon, Rectangle
from matplotlib.ticker import MaxNLocator

from . import checks, outlines, parallelograms, results
from .checks import Rule
from .errors import Error, ResultError
from .pictures import LOOK, Unit, entitle, in_lines, in_si_unit, lab_unit, shrink, si_unit, styled, title_of

Scale = namedtuple("Scale", "low high colormap")  # limits of a colour scale in SI, and its colours
Panel = namedtuple("Panel", "title points boxes axes indenter", defaults=(None,))
Panel.__doc__ = """What is drawn of a frame: title; points, a dict with position [n][2] m, half_size [n][2] m (current half
extents), stress [n][4] Pa (of the plane: xx, yy, across it, xy) and scalars [n]; boxes of levels [levels][lower, upper][2] m; and the
names of the axes along, up and across, "xyz" in two dimensions and "xzy" of a slice in space; and the corners [n][2] m of the
indenter at that time, None where there is none."""

STRESS_COLUMN = {"xx": 0, "yy": 1, "zz": 2, "xy": 3}
SCALARS = {"von_mises_stress": ("von Mises stress", "Pa"), "pressure": ("pressure", "Pa"),  # datasets, with label and unit
           "equivalent_plastic_strain": ("equivalent plastic strain", ""), "temperature": ("temperature", "K"),
           "speed": ("speed", "m/s")}
INDENTER_COLOUR = "0.55"
NO_LOAD = 1e-6  # of the largest load: less is what rounding leaves, and bodies that come to rest
HEADROOM = 0.1  # of the height of what is drawn, above it, for the indenter
LARGEST_PANEL, SMALLEST_PANEL = (6.4, 6.4), (2.2, 0.5)  # width and height of a field's axes in inches
LARGEST_ROW = 12.0  # width of all the axes in a row, in inches
UPRIGHT = 1.8  # inches: the colour bar of lower panels lies below them
MARGIN = 0.8, 0.6, 1.4, 0.5  # inches beside the first panel, below, beside the last with its colour bar, above
LEAST_SPARE = 0.04  # inches that stay free at the right
LINE = 0.22  # inches of a line of a title
TOP = 0.12  # inches above panels without a title
BELOW = 1.5  # inches below panels with a colour bar there
GAP = 1.1  # inches for ticks and label, between two panels
DECADES = 3  # of a logarithmic scale
SPREAD = 10  # times the median size: a field whose largest values are less spans no decades
NEAR = "near"  # window that shows the finest level
WINDOW = Rule(lambda ends: len(ends) == 4 and bool(np.isfinite(ends).all()) and ends[0] < ends[1] and ends[2] < ends[3],
              f"xmin,xmax,ymin,ymax with min < max, or {NEAR}")


# ---- what is drawn ----

def read_panel(directory, number=None, title=None, is_half=False):
    """Returns the Panel of a frame, by default of the last one; is_half: an axisymmetric one is not mirrored at the axis."""
    path = results.find_frame(directory, number)
    frame, history, summary = results.read_frame(path), results.read_history(directory), results.read_summary(directory)
    points, boxes = results.all_points(frame.levels), results.level_boxes(summary, frame.time)
    if "velocity" in points:
        points["speed"] = np.linalg.norm(points["velocity"], axis=1)
    is_space = points["position"].shape[1] == 3
    if is_space:
        points, boxes = slice_of(points, boxes, tip_across(history, frame.time))
    if not len(points["position"]):
        raise ResultError(path, "holds no points")
    indenter = indenter_at(history, frame.time, summary.get("options", {}), points)
    if has_axis(history) and not is_half:
        points, boxes = mirrored(points, boxes)
    title = f"{title or title_of(directory)}, {state_at(history, frame.time)}"
    return Panel(title, points, boxes, "xzy" if is_space else "xyz", indenter)


def has_axis(history):
    """Whether a History is that of an axisymmetric run."""
    return "hoop_impulse_x" in history


def state_at(history, time):
    """Returns the time, and of a run with an indenter depth and load then, as text in readable units."""
    words = [f"t = {in_si_unit(time, 's')}"]
    if results.has_indenter(history):
        depth, load = (np.interp(time, history.beside(name, "time"), history[name]) for name in ("depth", "load"))
        if abs(load) < NO_LOAD * np.abs(history["load"]).max():
            load = 0.0
        words += [f"depth {in_si_unit(depth, 'm')}", f"load {in_si_unit(load, 'N')}"]
    return ", ".join(words)


def indenter_at(history, time, options, points):
    """Returns the corners [n][2] (m) of the indenter at a time (s), higher than all points; None where there is none, or its shape is not
    known. Where the picture shows half of the body, it is the half of the indenter there."""
    if options.get("-indenter", "none") == "none":
        return None
    tip = outlines.place_of_tip(history, time, options)[[0, -1]]
    corners = outlines.outline(options, 2 * np.max(np.ptp(points["position"], axis=0)))
    if outlines.has_half(options):
        corners[:, 0] = (np.maximum if points["position"][:, 0].mean() > tip[0] else np.minimum)(corners[:, 0], 0)
    return corners + tip if len(corners) else None


def tip_across(history, time):
    """Returns the tip's y (m) at a time, through which a run in space is cut; None where it is not known."""
    return float(np.interp(time, history["time"], history["tip_y"])) if "tip_y" in history else None


def slice_of(points, boxes, y=None):
    """Returns points and boxes in the plane across y (m), by default that through the middle of the finest level.

    Of a plane through a side or a cell line these are the points next to it, on its greater side, at the body's end on the other.
    Vectors keep their components x and z, stresses are xx, zz, yy, xz.
    """
    position, half = points["position"][:, 1], points["half_size"][:, 1]
    if y is None:
        y = boxes[-1, :, 1].mean() if len(boxes) else np.median(position)
    beside = 0.5 if y < position.max() else -0.5
    inside = np.abs(position - (y + beside * half)) <= half
    cut = {name: values[inside] for name, values in points.items()}
    cut["stress"] = cut["stress"][:, [0, 2, 1, 5]]
    if "deformation_gradient" in cut:
        cut["deformation_gradient"] = cut["deformation_gradient"][:, [0, 2, 6, 8]]
    for name, values in cut.items():
        if values.ndim == 2 and values.shape[1] == 3:
            cut[name] = values[:, [0, 2]]
    met = (boxes[:, 0, 1] <= y) & (y <= boxes[:, 1, 1])
    return cut, boxes[met][:, :, [0, 2]]


def mirrored(points, boxes):
    """Returns the points of an axisymmetric run and their mirror images at the axis, and the boxes that hold both."""
    image = {name: values.copy() for name, values in points.items()}
    for name in ("position", "velocity", "displacement"):
        if name in image:
            image[name][:, 0] *= -1
    image["stress"][:, 3] *= -1
    if "deformation_gradient" in image:
        image["deformation_gradient"][:, 1:3] *= -1
    both = {name: np.concatenate([image[name], values]) for name, values in points.items()}
    if len(boxes):
        boxes = np.stack([boxes[:, 0] * [0, 1] - boxes[:, 1] * [1, 0], boxes[:, 1]], axis=1)
    return both, boxes


def check_component(component):
    """Refuses what is no component of the stress and no scalar."""
    if component not in (*STRESS_COLUMN, *SCALARS):
        raise checks.refusal("component", component, f"one of {', '.join((*STRESS_COLUMN, *SCALARS))}")


def values_of(points, component):
    """Returns one component of the stress, array [n] in Pa, by its name xx, yy, zz or xy in the plane, or one of the scalars."""
    return points[component] if component in SCALARS else points["stress"][:, STRESS_COLUMN[component]]


def spelt(component, axes):
    """Returns a component of the stress by the names of the axes: yy of a slice in space is zz."""
    return "".join(axes["xyz".index(letter)] for letter in component)


# ---- colours ----

def colour_scale(values, centred):
    """Returns the Scale of a field from its values [n], with the outer 0.5 % at each end left out, see scale_between."""
    return scale_between(*ends_of(values), centred)


def ends_of(values):
    """Returns the least and the largest of values [n] without the outer 0.5 % at each end; zeros where there are none."""
    return tuple(np.percentile(values, [0.5, 99.5])) if len(values) else (0.0, 0.0)


def common_scale(ends, component):
    """Returns the Scale that holds a component in several frames, from the ends of its values in each, [(least, largest)]."""
    lows, highs = zip(*ends)
    return scale_between(min(lows), max(highs), component == "xy")


def scale_between(low, high, centred):
    """Returns the Scale of a field whose values lie between two ends.

    A field of both signs, or any `centred` one, gets limits that are symmetric about a white 0; one of a
    single sign gets colours that darken away from 0.
    """
    largest = max(abs(low), abs(high))
    if centred or (low < 0 < high and min(-low, high) > 0.05 * largest) or largest == 0:
        return Scale(-largest or -1, largest or 1, "RdBu_r")
    margin = max(0, 1e-3 * largest - (high - low)) / 2
    return Scale(low - margin, high + margin, "magma" if low + high < 0 else "magma_r")


def norm_of(scale, factor=1, is_log=False):
    """Returns matplotlib's norm of a Scale times a factor; is_log: by logarithms of the sizes over DECADES, and less than those is 0."""
    low, high = scale.low * factor, scale.high * factor
    least = max(abs(low), abs(high)) / 10**DECADES
    if not is_log:
        return Normalize(low, high)
    return LogNorm(least, high, clip=True) if low >= 0 else SymLogNorm(least, vmin=low, vmax=max(high, least))


def spans_decades(values):
    """Whether a field [n] has values that are much larger than most."""
    sizes = np.abs(values[values != 0])
    return len(sizes) > 0 and max(map(abs, ends_of(values))) > SPREAD * np.median(sizes)


def unit_of(values, component):
    """Returns the Unit that a component's values are drawn in."""
    symbol = SCALARS.get(component, ("", "Pa"))[1]
    return si_unit(values, symbol) if symbol in ("Pa", "m/s") else Unit(1, symbol)


def label_of(component, unit, axes="xyz"):
    """Returns the text beside a colour bar."""
    name = SCALARS[component][0] if component in SCALARS else rf"$\sigma_{{{spelt(component, axes)}}}$"
    return f"{name} ({unit.name})" if unit.name else name


def label_in_words(component, axes="xyz"):
    """Returns the name of a component without formulas."""
    return SCALARS[component][0] if component in SCALARS else f"stress {spelt(component, axes)}"


def add_colourbar(axes, mappable, label, scale, values):
    """Adds a colour bar at the right of axes, or below them where they are low.

    Its ends are pointed where some of the values [n] that are drawn lie outside the scale, in the same unit.
    """
    width, height = axes.get_window_extent().size / axes.figure.dpi / shrink()
    upright = height > UPRIGHT
    place = [1 + 0.2 / width, 0, 0.18 / width, 1] if upright else [0, -0.85 / height, 1, 0.18 / height]
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    beyond = ends[bool(np.any(values < scale.low)), bool(np.any(values > scale.high))]
    bar = axes.figure.colorbar(mappable, cax=axes.inset_axes(place), extend=beyond, extendfrac=0.03,
                               orientation="vertical" if upright else "horizontal")
    bar.set_label(label)
    bar.outline.set_linewidth(0.6)


# ---- windows ----

def in_window(points, window):
    """Returns a mask [n] of the points whose rectangle meets window (xmin, xmax, ymin, ymax) in m."""
    lower, upper = points["position"] - points["half_size"], points["position"] + points["half_size"]
    return np.all((upper >= window[0::2]) & (lower <= window[1::2]), axis=1)


def extent(panel):
    """Returns the window (xmin, xmax, ymin, ymax) in m that the points of a Panel fill, with a small margin, and room for the indenter."""
    lower = np.min(panel.points["position"] - panel.points["half_size"], axis=0)
    upper = np.max(panel.points["position"] + panel.points["half_size"], axis=0)
    margin = 0.02 * np.max(upper - lower)
    above = 0 if panel.indenter is None else HEADROOM * (upper[1] - lower[1])
    return np.column_stack([lower - margin, upper + margin + [0, above]]).ravel()


def given_window(window):
    """Returns a given window: None, NEAR, or (xmin, xmax, ymin, ymax) in m, from a sequence or a text with commas."""
    is_word = window is None or isinstance(window, str) and window == NEAR
    return window if is_word else np.array(checks.several("window", window, WINDOW))


def window_of(panels, window=None):
    """Returns the window (xmin, xmax, ymin, ymax) in m for panels: the one given, all that there is, or near the finest level."""
    window = given_window(window)
    extents = np.array([extent(each) for each in panels])
    everything = np.where([True, False] * 2, extents.min(axis=0), extents.max(axis=0))
    if isinstance(window, np.ndarray):
        if not any(in_window(each.points, window).any() for each in panels):
            given, there = (",".join(f"{end:.4g}" for end in each) for each in (window, everything))
            raise Error(f"window={given}: must hold a point; they lie in {there} m")
        return window
    if window is None or not len(panels[0].boxes):
        return everything
    lower, upper = panels[0].boxes[-1]
    margin = 0.1 * np.max(upper - lower)
    near = np.column_stack([lower - margin, upper + margin]).ravel()
    return np.where([True, False] * 2, np.maximum(near, everything), np.minimum(near, everything))


def room_for(count, spare=0.0):
    """Returns the largest (width, height) in inches of each of `count` panels side by side; spare: of the margin at the right that nothing needs."""
    whole = LOOK.get().width
    if whole is None:
        return np.array([min(LARGEST_PANEL[0], LARGEST_ROW / count), LARGEST_PANEL[1]])
    left, _, right, _ = np.array(MARGIN) * shrink()
    width = (whole - left - right + spare - (count - 1) * GAP * shrink()) / count
    return np.array([width, width * LARGEST_PANEL[1] / LARGEST_PANEL[0]])


def fitted(window, count, spare=0.0):
    """Returns the window, widened where it is too slender to draw, and its (width, height) in inches.

    count: how many panels of this window stand side by side; spare: see room_for().
    """
    middle = np.array([window[0] + window[1], window[2] + window[3]]) / 2
    size = np.array([window[1] - window[0], window[3] - window[2]])
    inches_per_metre = np.min(room_for(count, spare) / size)
    size = np.maximum(size, np.array(SMALLEST_PANEL) * shrink() / inches_per_metre)
    return np.column_stack([middle - size / 2, middle + size / 2]).ravel(), size * inches_per_metre


# ---- drawing ----

def dots_of(axes):
    """Returns how many (rows, columns) of dots axes have on paper."""
    return tuple(np.maximum(np.rint(axes.get_window_extent().size[::-1]), 1).astype(int))


def draw_field(axes, panel, component, window, scale, units, is_log=False):
    """Draws a component over axes that show the window (m), with the boxes of levels and the indenter, and returns the image.

    units: Units of (length, stress); is_log: colours by logarithms.
    """
    length, stress = units
    dots = parallelograms.paint(panel.points, values_of(panel.points, component) * stress.factor, window, dots_of(axes))
    image = axes.imshow(dots, cmap=scale.colormap, norm=norm_of(scale, stress.factor, is_log), origin="lower", extent=window * length.factor,
                        interpolation="nearest", aspect="auto")
    for lower, upper in panel.boxes * length.factor:
        axes.add_patch(Rectangle(lower, *(upper - lower), fill=False, edgecolor="0.15", linewidth=0.7 * shrink()))
    if panel.indenter is not None:
        axes.add_patch(Polygon(panel.indenter * length.factor, facecolor=INDENTER_COLOUR, edgecolor="0.2", linewidth=0.8 * shrink()))
    axes.set(xlim=window[:2] * length.factor, ylim=window[2:] * length.factor)
    axes.set(xlabel=f"{panel.axes[0]} ({length.name})", ylabel=f"{panel.axes[1]} ({length.name})")
    set_ticks(axes)
    return image


def set_ticks(axes):
    """Gives both directions as many ticks, at round numbers, as their length on paper has room for."""
    width, height = axes.get_window_extent().size / axes.figure.dpi / shrink()
    axes.xaxis.set_major_locator(MaxNLocator(int(np.clip(1.4 * width, 2, 8)), steps=[1, 2, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(int(np.clip(2 * height, 1, 8)), steps=[1, 2, 5, 10]))


def in_lengths(panel, origin, length):
    """Returns the Panel with places as distances from origin [2] (m) in multiples of a length (m)."""
    points = dict(panel.points, position=(panel.points["position"] - origin) / length, half_size=panel.points["half_size"] / length)
    indenter = None if panel.indenter is None else (panel.indenter - origin) / length
    return panel._replace(points=points, boxes=(panel.boxes - origin) / length, indenter=indenter)


@styled
def fields(panels, component, window=None, scale=None, length=None, is_log=False):
    """Returns the picture of fields_with(); where its width is given, once more without what its margin at the right has to spare."""
    figure = fields_with(panels, component, window, scale, length, is_log)
    spare = figure.get_figwidth() - figure.get_tightbbox(figure.canvas.get_renderer()).x1 - LEAST_SPARE if LOOK.get().width else 0
    if spare <= LEAST_SPARE:
        return figure
    plt.close(figure)
    return fields_with(panels, component, window, scale, length, is_log, spare)


def fields_with(panels, component, window=None, scale=None, length=None, is_log=False, spare=0.0):
    """Returns the picture of one component, with a Panel for each of panels side by side.

    All share one window (xmin, xmax, ymin, ymax in m; None: all points; "near": the finest level), colour scale and units; length is
    the Unit of places, by default one of the laboratory. is_log: colours by logarithms, where the field spans decades.
    """
    window, size = fitted(window_of(panels, window), len(panels), spare)
    values = np.concatenate([values_of(each.points, component)[in_window(each.points, window)] for each in panels])
    scale = scale or colour_scale(values, centred=component == "xy")
    units = length or lab_unit(window, "m"), unit_of([scale.low, scale.high], component)
    (left, bottom, right, top), gap, (width, height) = np.array(MARGIN) * shrink(), GAP * shrink(), size
    bottom = bottom if height > UPRIGHT * shrink() else BELOW * shrink()
    titles = [in_lines(panel.title, width + (gap if len(panels) > 1 else right)) for panel in panels]
    top = top + LINE * max(title.count("\n") for title in titles) if LOOK.get().has_titles else TOP * shrink()
    full = max(left + len(panels) * (width + gap) - gap + right - spare, LOOK.get().width or 0), bottom + height + top
    figure = plt.figure(figsize=full)
    for place, panel in enumerate(panels):
        axes = figure.add_axes([(left + place * (width + gap)) / full[0], bottom / full[1], width / full[0], height / full[1]])
        image = draw_field(axes, panel, component, window, scale, units, is_log and spans_decades(values))
        entitle(axes, titles[place])
        if place > 0:
            axes.set_ylabel("")
    add_colourbar(axes, image, label_of(component, units[1], panels[0].axes), scale, values)
    return figure
