#!/usr/bin/env python3
"""Draws the sketches of the verification book, docs/images/sketches/NAME.png: a tip over a body, a load, or a body by itself.

    scripts/sketches.py            all of them: seconds
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import ROOT, command  # first, as it says in one line where there is no numpy

import numpy as np
from gallery import save_small
from matplotlib.patches import Annulus, Circle, Polygon, Rectangle

from mlgimp import pictures
from mlgimp.case_picture import BODY_COLOURS, INDENTER_COLOUR, LOAD_COLOUR

SKETCHES = ROOT / "docs" / "images" / "sketches"
X = np.linspace(-0.75, 0.75, 61)  # places across a tip, of half a body's width

TIPS = {"ball": 1.1 - np.sqrt(1.1**2 - X**2), "cone": 0.55 * np.abs(X), "wedge": 0.4 * np.abs(X), "fourth_power": 1.6 * X**4, "paraboloid": 0.9 * X**2,
        "round_edge": np.where(np.abs(X) < 0.4, 0, 0.5 - np.sqrt(np.maximum(0.5**2 - (np.abs(X) - 0.4)**2, 0))), "pyramid": 0.7 * np.abs(X)}


def body(axes, lower=-1.0, upper=0.0, colour=0, half=1.0):
    """Draws a box from one height to another."""
    axes.add_patch(Rectangle((-half, lower), 2 * half, upper - lower, facecolor=BODY_COLOURS[colour], edgecolor="0.4", linewidth=1))


def arrow(axes, start, end, colour="black"):
    """Draws an arrow from a place to another."""
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0})


def tip(axes, heights, depth=0.0):
    """Draws an indenter from the heights of its face above its lowest point, and which way it goes."""
    outline = [*zip(X, heights - depth), (X[-1], 0.75), (X[0], 0.75)]
    axes.add_patch(Polygon(outline, facecolor=INDENTER_COLOUR, edgecolor="0.3", linewidth=1))
    arrow(axes, (0, 1.15), (0, 0.8))


def pressed(name):
    """Returns a function that draws a tip on a body."""
    def draw(axes):
        body(axes)
        tip(axes, TIPS[name])
    return draw


def punch(axes):
    """Draws a flat punch on a body."""
    body(axes)
    axes.add_patch(Rectangle((-0.45, 0), 0.9, 0.6, facecolor=INDENTER_COLOUR, edgecolor="0.3"))
    arrow(axes, (0, 1.05), (0, 0.65))


def sideways(axes):
    """Draws a cylinder that is pressed down and pushed sideways."""
    pressed("ball")(axes)
    arrow(axes, (0.8, 0.5), (1.2, 0.5))


def load(axes, film=False):
    """Draws a pressure on a part of a body, or of a film on it."""
    body(axes)
    if film:
        body(axes, -0.25, 0, colour=1)
    for x in np.linspace(-0.35, 0.35, 5):
        arrow(axes, (x, 0.5), (x, 0.02), LOAD_COLOUR)


def film(axes):
    """Draws a ball on a film."""
    pressed("ball")(axes)
    body(axes, -0.25, 0, colour=1)


def bar(axes):
    """Draws a bar that is held at one end and pulled at the other."""
    axes.add_patch(Rectangle((-1, -0.25), 1.8, 0.5, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
    axes.plot([-1, -1], [-0.45, 0.45], color="#CC0000", linewidth=3)
    arrow(axes, (0.82, 0), (1.2, 0), LOAD_COLOUR)


def beam(axes):
    """Draws a beam that bends under its weight."""
    s = np.linspace(0, 1, 40)
    middle = np.stack((-1 + 1.8 * s - 0.15 * s**3, 0.5 - 0.9 * (2 * s**2 - 4 * s**3 / 3 + s**4 / 3)), axis=1)
    axes.plot(*middle.T, color="#9fb6cc", linewidth=7, solid_capstyle="butt")
    axes.plot([-1, -1], [0.25, 0.75], color="#CC0000", linewidth=3, linestyle="-")
    arrow(axes, (0, 0.9), (0, 0.5))


def ring(axes, pressure=False):
    """Draws a ring with arrows along its radius, of its speed or of a pressure within."""
    axes.add_patch(Annulus((0, 0), 0.75, 0.12 if not pressure else 0.3, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
    start, end = (0.1, 0.43) if pressure else (0.8, 1.1)
    for angle in np.radians(range(0, 360, 45)):
        direction = np.array([np.cos(angle), np.sin(angle)])
        arrow(axes, start * direction, end * direction, LOAD_COLOUR if pressure else "black")


def squeezed_ring(axes):
    """Draws a ring between two plates."""
    axes.add_patch(Annulus((0, 0), 0.7, 0.12, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
    for side in (-1, 1):
        axes.add_patch(Rectangle((-0.9, 0.7 * side - (0.12 if side < 0 else 0)), 1.8, 0.12, facecolor=INDENTER_COLOUR, edgecolor="0.3"))
        arrow(axes, (0, 1.08 * side), (0, 0.83 * side))


def disk(axes):
    """Draws a disk that spins."""
    axes.add_patch(Circle((0, 0), 0.75, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
    for angle in np.radians(range(0, 360, 90)):
        direction, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        arrow(axes, 0.85 * direction - 0.25 * along, 0.85 * direction + 0.25 * along)


def square(axes, levels=False):
    """Draws a square that moves, with a finer level in its middle."""
    axes.add_patch(Rectangle((-0.8, -0.8), 1.6, 1.6, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
    if levels:
        axes.add_patch(Rectangle((-0.4, -0.4), 0.8, 0.8, fill=False, edgecolor="0.1", linewidth=1.5))
    for x in (-0.55, 0.15):
        arrow(axes, (x, 0), (x + 0.4, 0))


def border(axes):
    """Draws a wave before the border of a level."""
    x = np.linspace(-1.1, -0.2, 80)
    axes.add_patch(Rectangle((-1.2, -0.5), 2.4, 1.0, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
    axes.plot(x, 0.35 * np.sin(20 * x) * np.sin(np.pi * (x + 1.1) / 0.9), color="#0072B2")
    axes.plot([0.3, 0.3], [-0.5, 0.5], color="0.1", linewidth=1.5, linestyle="-")
    arrow(axes, (-0.15, 0), (0.2, 0))


def collision(axes):
    """Draws two disks that fly toward each other."""
    for side in (-1, 1):
        axes.add_patch(Circle((0.6 * side, 0), 0.4, facecolor=BODY_COLOURS[0], edgecolor="0.4"))
        arrow(axes, (0.75 * side, 0), (0.35 * side, 0))


DRAWN = {**{name: pressed(name) for name in TIPS}, "punch": punch, "sideways": sideways, "load": load, "film_load": lambda axes: load(axes, film=True),
         "film": film, "bar": bar, "beam": beam, "ring": ring, "ring_pressure": lambda axes: ring(axes, pressure=True), "squeezed_ring": squeezed_ring,
         "disk": disk, "square": square,
         "levels": lambda axes: square(axes, levels=True), "border": border, "collision": collision}


@pictures.styled
def sketch(name):
    """Returns the figure of a sketch."""
    figure, axes = pictures.plt.subplots(figsize=(3.2, 2.8))
    DRAWN[name](axes)
    axes.set(xlim=(-1.25, 1.25), ylim=(-1.05, 1.2), aspect="equal")
    axes.axis("off")
    return figure


@command
def main():
    """Draws all sketches."""
    pictures.make_folder(SKETCHES)
    for name in DRAWN:
        figure = sketch(name)
        save_small(figure, SKETCHES / f"{name}.png")
        pictures.plt.close(figure)


if __name__ == "__main__":
    main()
