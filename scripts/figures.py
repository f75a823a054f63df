#!/usr/bin/env python3
"""Draws pictures that compare several result folders: load against depth, fields side by side, or cells saved by levels; and the
picture of a case before it runs."""

import argparse
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command, save
from plot import add_window_option

import numpy as np

from mlgimp import case_picture, fields, pictures, results
from mlgimp.errors import ResultError
from mlgimp.pictures import plt, styled

MILLINEWTON, NANOMETRE = pictures.Unit(1e3, "mN"), pictures.Unit(1e9, "nm")


def labelled(text):
    """Splits PATH:LABEL into the two."""
    path, colon, label = text.rpartition(":")
    if not (path and label):
        raise argparse.ArgumentTypeError(f"{text}: must be PATH:LABEL")
    return path, label


def labelled_frame(text):
    """Splits DIR[:FRAME]:LABEL into folder, number of the frame (None for the last one) and label."""
    path, label = labelled(text)
    with_frame = re.fullmatch(r"(.+):(\d+)", path)
    return (with_frame[1], int(with_frame[2]), label) if with_frame else (path, None, label)


def read_fem(path):
    """Returns depth (m) and load (N), arrays [rows], of a CSV with '#' comments and a header.

    The columns are the first whose name begins with depth and the last, of those without gaps, that begins with load.
    """
    try:
        lines = [line for line in Path(path).read_text().splitlines() if line and not line.startswith("#")]
        table = np.genfromtxt(lines, delimiter=",", names=True, ndmin=1)
        depth = [name for name in table.dtype.names if name.startswith("depth")]
        load = [name for name in table.dtype.names if name.startswith("load") and np.isfinite(table[name]).all()]
        return table[depth[0]], table[load[-1]]
    except (OSError, ValueError, IndexError, TypeError):
        raise ResultError(path, "cannot be read as a CSV file with the columns depth,load") from None


def run_curve(directory, label):
    """Returns the curve (label, depth, load, line style) of a result folder, for pictures.draw_load_depth."""
    history = results.read_history(directory)
    if not results.has_indenter(history):
        raise ResultError(directory, "this run has no indenter")
    return label, history.beside("load", "depth"), history["load"], {}


@styled
def load_depth(options):
    """Draws load (mN) against depth (nm) of several runs, and of finite elements in black, in one picture."""
    curves = [run_curve(*run) for run in options.runs]
    curves += [(label, *read_fem(path), {"color": "black", "linestyle": ":"}) for path, label in options.fem]
    figure, axes = plt.subplots(figsize=(7, 5))
    pictures.draw_load_depth(axes, curves, MILLINEWTON, NANOMETRE)
    save(figure, options.picture)


def side_by_side(options):
    """Draws one stress component, or a scalar, of several frames side by side, with one common colour scale."""
    panels = [fields.read_panel(directory, number, label) for directory, number, label in options.runs]
    for (directory, _, _), panel in zip(options.runs, panels):
        if options.component in fields.SCALARS and options.component not in panel.points:
            raise ResultError(directory, f"its points have no {options.component}")
    save(fields.fields(panels, options.component, options.window), options.picture)


def under_tip(history):
    """Returns where the surface is under the tip at first, [x, height] m: pictures in space are of planes across y."""
    upward = "tip_z" if "tip_z" in history else "tip_y"
    return np.array([history["tip_x"][0], history[upward][0] + history["depth"][0]])


def depths(options):
    """Draws a stress or a scalar of several frames of one run side by side, each in lengths of the depth it has: what is similar
    to itself looks the same."""
    history = results.read_history(options.directory)
    if not results.has_indenter(history):
        raise ResultError(options.directory, "this run has no indenter")
    surface = under_tip(history)
    panels = []
    for number in options.frames:
        time = results.read_frame(results.find_frame(options.directory, number)).time
        depth = float(np.interp(time, history["time"], history["depth"]))
        if depth <= 0:
            raise ResultError(options.directory, f"the indenter has no depth in frame {number}")
        panel = fields.read_panel(options.directory, number)
        panels.append(fields.in_lengths(panel, surface, depth)._replace(title=f"h = {pictures.in_si_unit(depth, 'm')}"))
    width = options.width
    save(fields.fields(panels, options.component, (-width, width, -1.2 * width, 0.4 * width), length=pictures.Unit(1, "h")),
         options.picture)


@styled
def moves(options):
    """Draws the load over a power of the depth against the depth, with the moves of boxes and the ends of levels."""
    history, summary = results.read_history(options.directory), results.read_summary(options.directory)
    if not results.has_indenter(history) or not summary.get("regrids"):
        raise ResultError(options.directory, "this run has no boxes that follow an indenter")
    depth = history.beside("load", "depth")
    seen = (depth > 0) & (history["contact_half_width"] >= 8 * min(level["cell_size"] for level in summary["levels"]))
    if not seen.any():
        raise ResultError(options.directory, "the contact stays narrower than 16 of the finest cells")
    ratio = history["load"][seen] / depth[seen] ** options.exponent
    figure, axes = plt.subplots(figsize=(7.5, 4.2))
    axes.semilogx(1e9 * depth[seen], ratio / np.mean(ratio), linewidth=0.8)
    active, drawn = {}, set()
    for move in summary["regrids"]:
        ends = active.get(move["level"], True) and not move["active"]
        active[move["level"]] = move["active"]
        place = 1e9 * np.interp(move["step"], history["step"], history["depth"])
        label = "a level ends" if ends else "a box moves"
        if place >= 1e9 * depth[seen][0]:
            axes.axvline(place, color="black" if ends else "0.8", linestyle="--" if ends else "-", linewidth=0.8, zorder=0,
                         label=None if label in drawn else label)
            drawn.add(label)
    width = max(0.05, 1.1 * np.max(np.abs(ratio / np.mean(ratio) - 1)))
    axes.set_ylim(1 - width, 1 + width)
    pictures.line_axes(axes, "depth (nm)", f"load / depth$^{{{options.exponent:g}}}$, of the mean")
    axes.grid(False, axis="x")
    axes.legend(loc="lower right", frameon=True)
    save(figure, options.picture)


def cell_percentage(levels):
    """Returns, for the first 1, 2, ... of the levels of summary.json, the cells they have in percent of those that the
    whole domain would have at the finest of them; cells under a finer level do not count. (The paper's Fig. 6b.)"""
    areas = [np.prod(np.subtract(level["upper"], level["lower"])) for level in levels]
    sizes = [level["cell_size"] for level in levels]
    percentage = []
    for last in range(1, len(levels) + 1):
        covered = areas[1:last] + [0]
        cells = sum((area - hole) / size**2 for area, hole, size in zip(areas, covered, sizes))
        percentage.append(100 * cells / (areas[0] / sizes[last - 1] ** 2))
    return percentage


@styled
def cells(options):
    """Draws the number of cells in percent of those of one fine level against the number of levels."""
    figure, axes = plt.subplots(figsize=(6.4, 4.6))
    for directory, label in options.runs:
        levels = results.read_summary(directory).get("levels")
        if not levels:
            raise ResultError(directory, "there is no summary.json with levels")
        try:
            percentage = cell_percentage(levels)
        except (KeyError, TypeError, ZeroDivisionError):
            raise ResultError(directory, "the levels of summary.json must have a cell_size") from None
        axes.plot(range(1, len(percentage) + 1), percentage, marker="o", label=label)
    count = np.arange(1, 8)
    quarter = (3 * count + 1) / 4**count  # each level covers a quarter of the next coarser one
    axes.plot(count, 100 * quarter, ":", color="black", label="each level a quarter of the coarser one")
    pictures.line_axes(axes, "number of levels", "cells, % of one fine level")
    axes.legend()
    save(figure, options.picture)


def case(options):
    """Draws the case of a run as it begins: bodies, indenter, loads, sides of the domain, boxes of levels."""
    save(case_picture.case(options.directory), options.picture)


@command
def main(arguments=None):
    """Draws the picture that the command line asks for."""
    parser = Parser(description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    curves = commands.add_parser("load-depth", help=load_depth.__doc__)
    curves.add_argument("picture", metavar="OUT.png")
    curves.add_argument("runs", nargs="+", type=labelled, metavar="DIR:LABEL")
    curves.add_argument("--fem", action="append", default=[], type=labelled, metavar="CSV:LABEL",
                        help="finite-element curve: '#' comments, a header with depth and load, then SI values")
    curves.set_defaults(draw=load_depth)
    stresses = commands.add_parser("fields", help=side_by_side.__doc__)
    stresses.add_argument("picture", metavar="OUT.png")
    stresses.add_argument("runs", nargs="+", type=labelled_frame, metavar="DIR[:FRAME]:LABEL")
    stresses.add_argument("--component", choices=[*fields.STRESS_COLUMN, *fields.SCALARS], default="yy")
    add_window_option(stresses)
    stresses.set_defaults(draw=side_by_side)
    similar = commands.add_parser("depths", help=depths.__doc__)
    similar.add_argument("picture", metavar="OUT.png")
    similar.add_argument("directory", metavar="DIR")
    similar.add_argument("frames", nargs="+", type=int, metavar="FRAME")
    similar.add_argument("--component", choices=[*fields.STRESS_COLUMN, *fields.SCALARS], default="von_mises_stress")
    similar.add_argument("--width", type=float, default=6, help="what is seen to each side of the tip, depths (default: 6)")
    similar.set_defaults(draw=depths)
    following = commands.add_parser("moves", help=moves.__doc__)
    following.add_argument("picture", metavar="OUT.png")
    following.add_argument("directory", metavar="DIR")
    following.add_argument("--exponent", type=float, default=2, help="of the depth: 2 under a cone (default), 1 under a wedge")
    following.set_defaults(draw=moves)
    savings = commands.add_parser("cells", help=cells.__doc__)
    savings.add_argument("picture", metavar="OUT.png")
    savings.add_argument("runs", nargs="+", type=labelled, metavar="DIR:LABEL")
    savings.set_defaults(draw=cells)
    before = commands.add_parser("case", help=case.__doc__)
    before.add_argument("picture", metavar="OUT.png")
    before.add_argument("directory", metavar="DIR")
    before.set_defaults(draw=case)
    options = parser.parse_args(arguments)
    options.draw(options)


if __name__ == "__main__":
    main()
