"""Tips by files: profiles, and maps of heights of an atomic force microscope, as the program reads them. Lengths in the files are in m."""

from collections import namedtuple
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import zoom

from .errors import ResultError
from .tips import Tip

HeightMap = namedtuple("HeightMap", "heights width depth")
HeightMap.__doc__ = "Heights [rows][columns] (m) over a rectangle of width along x and depth along y (m); the first row is at the smallest y."

FIELD = b"Gwyddion Simple Field 1.0\n"
FINER = 4  # pixels between two of a map, of which areas are counted: the section of a pyramid of ten pixels is right within .1 %


def read_profile(path):
    """Returns distances from the axis and heights [rows] (m) of a profile's file."""
    try:
        table = np.loadtxt(path, delimiter="," if "," in Path(path).read_text() else None, ndmin=2)
    except (OSError, ValueError) as problem:
        raise ResultError(path, f"is no profile of two columns of numbers ({problem})") from None
    if table.shape[1] != 2 or len(table) < 3 or np.any(table[0] != 0) or np.any(np.diff(table, axis=0) <= 0):
        raise ResultError(path, "must have two columns that begin at 0 0 and grow")
    return table.T


def tip_of_profile(path):
    """Returns the Tip of revolution of a profile's file; between its rows the monotone cubic that the program takes."""
    distances, heights = 1e6 * read_profile(path)
    finer = np.linspace(0, distances[-1], 4001)
    shape = PchipInterpolator(distances, heights)(finer)
    return Tip("profile", lambda h: np.pi * np.interp(h, shape, finer) ** 2, 0.75, lambda nu: 1.0, largest=heights[-1])


def read_map(path, size=None):
    """Returns the HeightMap of a Gwyddion Simple Field, or of rows of numbers over extents (width, depth) in m, the first row at the largest y."""
    try:
        content = Path(path).read_bytes()
        if content.startswith(FIELD):
            return field_of(path, content)
        rows = np.loadtxt(path, delimiter="," if b"," in content else None, ndmin=2)
    except (OSError, ValueError) as problem:
        raise ResultError(path, f"is no map of heights ({problem})") from None
    if size is None:
        raise ResultError(path, "rows of numbers do not say their extents: they must be given")
    return HeightMap(rows[::-1], *size)


def field_of(path, content):
    """Returns the HeightMap of the bytes of a Gwyddion Simple Field."""
    end = content.index(b"\0")
    head = dict(map(str.strip, line.split("=", 1)) for line in content[:end].decode().splitlines() if "=" in line)
    if head.get("XYUnits") != "m" or head.get("ZUnits") != "m":
        raise ResultError(path, f"is in '{head.get('XYUnits')}' and '{head.get('ZUnits')}'; lengths and heights must be in m")
    columns, rows = int(head["XRes"]), int(head["YRes"])
    numbers = np.frombuffer(content, "<f4", offset=end + 4 - end % 4)
    if len(numbers) != rows * columns:
        raise ResultError(path, f"has {len(numbers)} heights in place of {rows} x {columns}")
    return HeightMap(numbers.reshape(rows, columns)[::-1].astype(float), float(head["XReal"]), float(head["YReal"]))


def tip_of_map(path, size=None):
    """Returns the Tip of a map of heights: its area at a height is that of the pixels below."""
    image = read_map(path, size)
    heights = zoom(image.heights, FINER, order=1, grid_mode=True, mode="nearest") - image.heights.min()
    rim = np.concatenate([heights[0], heights[-1], heights[:, 0], heights[:, -1]]).min()
    ordered = 1e6 * np.sort(heights.ravel())
    pixel = 1e12 * image.width * image.depth / heights.size
    return Tip("height map", lambda h: pixel * np.searchsorted(ordered, h, side="right").astype(float), 0.75, lambda nu: 1.0, largest=1e6 * rim)
