#!/usr/bin/env python3
"""Makes a map of heights of a tip, for -indenter height_map, of an image of the tip or of a triangulated surface (STL).

    scripts/tip_map.py image.gsf tip.gsf
    scripts/tip_map.py image.txt tip.gsf --size 4,4 --smooth 2
    scripts/tip_map.py tip.stl tip.gsf --unit um --pixel 5 --down

An image, as of an atomic force microscope, is a Gwyddion Simple Field or rows of numbers in m, the first row at the largest y. The tip points
up in it, so it is turned over, about the x axis: x stays, y and heights change sign; with --down it points down already and stays.
Of an STL the outermost surface is taken. The apex may lie anywhere inside; what is written is in m and has its lowest place at 0.
"""

import argparse
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command

import numpy as np
from scipy.ndimage import gaussian_filter

from mlgimp import height_maps, load_depth
from mlgimp.errors import Error, ResultError

PIXELS = 256  # of an STL along its longer side, by default


def size_of(text):
    """Reads W,H in um for a command line."""
    values = load_depth.numbers(text)
    if len(values) != 2 or not all(0 < value < math.inf for value in values):
        raise ValueError
    return values


def parse(arguments):
    """Returns the options of the command line."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", metavar="FILE", help="image (.gsf or rows of numbers) or surface (.stl)")
    parser.add_argument("map", metavar="MAP.gsf", help="what is written")
    parser.add_argument("--down", action="store_true", help="the tip points down already")
    parser.add_argument("--size", type=size_of, metavar="W,H", help="extents of rows of numbers along x and y, um")
    parser.add_argument("--smooth", type=float, default=0.0, metavar="PIXELS", help="standard deviation of a Gaussian that noise is smoothed with (0)")
    parser.add_argument("--unit", choices=load_depth.DEPTH_UNITS, default="um", help="of an STL (um)")
    parser.add_argument("--pixel", type=float, metavar="NM", help=f"of the map of an STL (its longer side over {PIXELS})")
    options = parser.parse_args(arguments)
    if not 0 <= options.smooth < math.inf:
        raise Error(f"--smooth {options.smooth:g}: must be a number >= 0")
    return options


def triangles_of(path):
    """Returns the triangles [n][3 corners][x, y, z] of an STL, text or binary, in its own unit."""
    try:
        content = Path(path).read_bytes()
    except OSError as problem:
        raise ResultError(path, f"cannot be read ({problem.strerror})") from None
    count = int.from_bytes(content[80:84], "little")
    if len(content) == 84 + 50 * count and count > 0:  # a normal, three corners and two bytes each
        facets = np.frombuffer(content, np.dtype([("numbers", "<f4", 12), ("more", "<u2")]), offset=84)
        return facets["numbers"].reshape(-1, 4, 3)[:, 1:].astype(float)
    corners = [line.split()[1:4] for line in content.decode("latin-1").splitlines() if line.split()[:1] == ["vertex"]]
    try:
        return np.array(corners, float).reshape(-1, 3, 3) if corners else refuse(path)
    except ValueError:
        return refuse(path)


def refuse(path):
    raise ResultError(path, "is no STL: it is neither binary with as many triangles as it says, nor text with three vertices for each")


def map_of_triangles(triangles, pixel, down):
    """Returns the height_maps.HeightMap (um) of the outermost surface of a tip of triangles (um) that points up, or down."""
    lower, upper = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    step = pixel or max(upper[:2] - lower[:2]) / PIXELS
    x, y = (np.arange(low + step / 2, high, step) for low, high in zip(lower[:2], upper[:2]))
    sign = np.array([1, 1, -1 if down else 1])
    heights = sign[2] * height_maps.highest(sign * triangles, x, y[::-1])
    return height_maps.HeightMap(x, y[::-1], np.where(np.isnan(heights), lower[2] if not down else upper[2], heights))


def turned_over(image):
    """Returns the map of a tip that points down of one that points up, turned about the x axis."""
    return height_maps.HeightMap(image.x, -image.y[::-1], -image.height[::-1])


@command
def main(arguments=None):
    """Writes the map that the command line asks for."""
    options = parse(arguments)
    if Path(options.source).suffix.lower() == ".stl":
        triangles = load_depth.DEPTH_UNITS[options.unit] * triangles_of(options.source)
        image = map_of_triangles(triangles, options.pixel and 1e-3 * options.pixel, options.down)
    else:
        image = height_maps.read_map(options.source, options.size)
    image = image if options.down else turned_over(image)
    height = gaussian_filter(image.height, options.smooth) if options.smooth else image.height
    lowest = np.unravel_index(np.argmin(height), height.shape)
    if 0 in lowest or lowest[0] == height.shape[0] - 1 or lowest[1] == height.shape[1] - 1:
        raise Error(f"{options.source}: its lowest place is on its rim: {'leave --down out' if options.down else 'give --down'} where the tip points the other way")
    image = image._replace(height=height - height.min())
    try:
        height_maps.write_gsf(options.map, image, f"tip of {Path(options.source).name}")
    except OSError as problem:
        raise ResultError(options.map, f"cannot be written ({problem.strerror})") from None
    print(f"{options.map}: {len(image.x)} x {len(image.y)} pixels of {1e3 * (image.x[1] - image.x[0]):.4g} nm; the tip is known up to "
          f"{1e3 * rim_of(image.height):.4g} nm above its end")


def rim_of(height):
    """Returns the lowest height on the rim of a map."""
    return np.concatenate([height[0], height[-1], height[:, 0], height[:, -1]]).min()


if __name__ == "__main__":
    main()
