"""The outline of the indenter in a plane through its axis, from the options of a run."""

import math

import numpy as np

from . import load_depth, tips

ROWS = 200  # heights at which the outline has corners, denser towards the tip


def half_widths(options, heights):
    """Returns how far (m) the indenter reaches to the left and to the right of its axis at heights (m) above its tip."""
    kind = options["-indenter"]

    def size(name):
        return float(options[f"-indenter_{name}"])
    if kind in ("sphere", "cylinder"):
        width = np.sqrt(np.maximum(heights * (2 * size("radius") - heights), 0))
        width[heights > size("radius")] = size("radius")  # the shaft
        return width, width
    if kind == "flat_punch":
        edge = float(options.get("-indenter_edge_radius", 0))
        whole = size("width") / 2 if options["-geometry"] == "plane_strain" else size("radius")
        width = whole - edge + np.sqrt(tips.bulge(heights, edge))
        return width, width
    if kind in ("area_function", "profile", "height_map", "knoop"):
        tip = load_depth.tip_of_run(options)
        width = 1e-6 * np.sqrt(tip.area(1e6 * heights) / np.pi) if tip else 0 * heights
        return width, width
    faces, angle = tips.PYRAMIDS.get(kind) or (int(size("faces")) if kind == "pyramid" else 0, size("half_angle"))
    width = tips.section_radius(heights, angle, float(options.get("-indenter_tip_radius", 0)))
    if not faces:
        return width, width
    normals = np.cos(math.radians(float(options.get("-indenter_turn", 0))) + 2 * math.pi * np.arange(faces) / faces)
    return width / np.max(-normals), width / np.max(normals)


def outline(options, height):
    """Returns the corners [n][2] (m) of the indenter from its tip at (0, 0) up to a height (m) above it; none where its shape is in a
    file that is no longer there."""
    if options["-indenter"] == "polygon":
        corners = np.array(load_depth.numbers(options["-indenter_vertices"])).reshape(-1, 2)
        return corners - corners[np.argmin(corners[:, 1])]
    heights = height * np.linspace(0, 1, ROWS) ** 2
    left, right = half_widths(options, heights)
    if not np.any(left + right > 0):
        return np.zeros((0, 2))
    return np.concatenate([np.column_stack([-left, heights])[::-1], np.column_stack([right, heights])])


def place_of_tip(history, time, options):
    """Returns the place [dim] (m) of the tip at a time (s), from the History of a run; that of its start where the history has none."""
    start = load_depth.numbers(options["-indenter_tip"])
    return np.array([np.interp(time, history["time"], history[f"tip_{axis}"]) if f"tip_{axis}" in history else first
                     for axis, first in zip("xyz", start)])


def has_half(options):
    """Whether a picture along x and the axis of the indenter shows only half of it: the tip lies on a side of symmetry there."""
    return 0 in load_depth.mirror_axes(options)
