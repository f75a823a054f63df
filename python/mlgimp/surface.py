"""The surface under the tip: pressure of contact over the radius, and in space the surface itself, coloured."""

import numpy as np
from matplotlib import tri
from matplotlib import pyplot as plt

from . import fields, load_depth, results
from .errors import ResultError
from .parallelograms import edges_of
from .pictures import LOOK, Unit, entitle, lab_unit, line_axes, shrink, si_unit, size_of, styled, title_of

PRESSED = 0.05  # of the largest pressure: what counts as contact when the part to show is chosen
SHOWN = 2.5  # times the reach of the contact
EXAGGERATED = 0.18  # height of the box that the surface is drawn in, of its width


def surface_of(points):
    """Returns a mask [n] of the points whose upper side is the body's surface, by the bit of that side in their faces."""
    return points["faces"] & 1 << 2 * points["position"].shape[1] - 1 != 0


def frame_of_largest_load(directory):
    """Returns the number of the frame nearest to the time of the largest load: at a turn, loads of rows are means over their steps."""
    history = results.read_history(directory)
    times = {number: results.read_time(path) for number, path in results.numbered_frames(directory).items()}
    if not times:
        raise ResultError(directory, "no results here (there is no points_*.h5)")
    largest = history["time"][np.argmax(history["load"])]
    return list(times)[int(np.argmin(np.abs(np.array(list(times.values())) - largest)))]


def read_surface(directory, number=None):
    """Returns (time, points of the surface, place of the tip [dim - 1] m, options), by default at the largest load."""
    number = frame_of_largest_load(directory) if number is None else number
    frame, history = results.read_frame(results.find_frame(directory, number)), results.read_history(directory)
    points = results.all_points(frame.levels)
    if "faces" not in points:
        raise ResultError(directory, "its points have no faces")
    points = {name: values[top] for top in [surface_of(points)] for name, values in points.items()}
    lateral = "xy"[:points["position"].shape[1] - 1]
    tip = np.array([np.interp(frame.time, history["time"], history.get(f"tip_{axis}", 0 * history["time"])) for axis in lateral])
    return frame.time, points, tip, results.read_summary(directory).get("options", {})


def reach_of(points, tip, values):
    """Returns how far (m) from the tip's axis to show, so that all that counts of the values [n] is seen."""
    away = np.abs(points["position"][:, :-1] - tip).max(axis=1)
    counts = values > PRESSED * values.max(initial=0)
    return min(SHOWN * away[counts].max(initial=0) or np.inf, away.max())


@styled
def contact_pressure(directory, number=None):
    """Returns the picture of the contact's pressure: over the radius, or x in plane strain, and in space on the surface."""
    number = frame_of_largest_load(directory) if number is None else number
    time, points, tip, options = read_surface(directory, number)
    title = f"{title_of(directory)}, {fields.state_at(results.read_history(directory), time)}"
    values = points["contact_pressure"]
    if len(tip) == 2:
        return draw_surface(points, tip, options, values, ("pressure of contact", "Pa"), title)
    order = np.argsort(points["position"][:, 0])
    place, pressure = points["position"][order, 0] - tip[0], values[order]
    reach = reach_of(points, tip, values)
    length, unit = lab_unit(reach, "m"), si_unit(pressure, "Pa")
    figure, axes = plt.subplots(figsize=size_of(6.8, 4.6), layout="constrained")
    axes.plot(place * length.factor, pressure * unit.factor, "o-", markersize=3, linewidth=1, label="on the surface's points")
    area, radius = results.read_contact_area(results.find_frame(directory, number)), "radius" if has_axis(options) else "x from the tip"
    if area > 0:
        axes.axhline(carried_load(points, options) / area * unit.factor, color="0.5", linestyle=":", linewidth=1.2,
                     label="load over contact area")
    line_axes(axes, f"{radius} ({length.name})", f"pressure of contact ({unit.name})")
    axes.set_xlim((0 if place.min() > 0 else max(place.min(), -reach)) * length.factor, reach * length.factor)
    entitle(axes, title)
    axes.legend()
    return figure


def has_axis(options):
    """True for the options of a case in axisymmetry."""
    return options.get("-geometry") == "axisymmetric"


def carried_load(points, options):
    """Returns the load (N) that the pressures on the upper faces of points of the surface are, in two dimensions.

    A row of the history has its mean over the steps since the last row, which is another load where the tip turns.
    """
    along, up = np.swapaxes(edges_of(points), 0, 1)
    width, middle = 2 * along[:, 0], points["position"][:, 0] + up[:, 0]  # of the face
    depth = 2 * np.pi * middle if has_axis(options) else float(options.get("-thickness", 1))
    return float(np.sum(points["contact_pressure"] * width * depth))


@styled
def plastic_surface(directory, number=None):
    """Returns the picture of a metal's surface in space, by default at the end, coloured by its equivalent plastic strain."""
    number = results.number_in(results.find_frame(directory, number))
    time, points, tip, options = read_surface(directory, number)
    title = f"{title_of(directory)}, {fields.state_at(results.read_history(directory), time)}"
    values = points["equivalent_plastic_strain"]
    return draw_surface(points, tip, options, values, fields.SCALARS["equivalent_plastic_strain"], title)


def draw_surface(points, tip, options, values, quantity, title):
    """Returns the picture of a surface in space, coloured by values [n]; sides of symmetry through the tip are completed.

    quantity: (label, symbol of the unit). Heights are exaggerated: the box is EXAGGERATED times as high as it is wide.
    """
    top = points["position"] + points["half_size"] * [0, 0, 1]
    place, values = completed(top, values, tip, options)
    reach = reach_of({"position": place}, tip, values)
    shown = np.all(np.abs(place[:, :2] - tip) <= reach, axis=1)
    place, values = place[shown], values[shown]
    length, unit = lab_unit(place, "m"), si_unit(values, "Pa") if quantity[1] == "Pa" else Unit(1, "")
    triangles = tri.Triangulation(*place[:, :2].T).triangles
    colours = values[triangles].mean(axis=1) * unit.factor
    is_wide = LOOK.get().width is None
    figure = plt.figure(figsize=size_of(8.6, 4.2 if is_wide else 6.4))
    axes = figure.add_axes([0.0, -0.12, 0.82, 1.24] if is_wide else [0.0, 0.16, 0.88, 0.84], projection="3d")
    surface = axes.plot_trisurf(*(place * length.factor).T, triangles=triangles, cmap="magma_r", linewidth=0.1, antialiased=False,
                                shade=False)
    surface.set_array(colours)
    surface.set_clim(min(0, np.percentile(colours, 1)), colours.max() or 1)
    surface.set_edgecolor("face")
    width, depth = np.ptp(place[:, :2], axis=0)
    axes.set_box_aspect((1, depth / width, EXAGGERATED))
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y"), (axes.zaxis, "z")):
        axis.set_label_text(f"{name} ({length.name})")
        axis.set_major_locator(plt.MaxNLocator(2 if name == "z" else 5, steps=[1, 2, 5, 10]))
        axis.labelpad = 10 * shrink()
    axes.view_init(elev=50, azim=-58)
    place, way = ([0.88, 0.22, 0.02, 0.6], "vertical") if is_wide else ([0.2, 0.17, 0.6, 0.025], "horizontal")
    bar = figure.colorbar(surface, cax=figure.add_axes(place), orientation=way)
    bar.set_label(f"{quantity[0]} ({unit.name})" if unit.name else quantity[0])
    if LOOK.get().has_titles:
        figure.suptitle(title, y=1.02, size=13)
    return figure


def completed(place, values, tip, options):
    """Returns places [n][3] m and values [n] with their images at the sides of symmetry that the tip is on."""
    for axis in load_depth.mirror_axes(options):
        image = place.copy()
        image[:, axis] = 2 * tip[axis] - image[:, axis]
        place, values = np.concatenate([place, image]), np.concatenate([values, values])
    return place, values
