"""Tips by files, as the program reads them: profiles and maps of heights, whose lengths are in m."""

from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import zoom

from . import height_maps
from .errors import ResultError
from .tips import Tip, constant, of_shape

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
    return of_shape(Tip("profile", lambda h: np.pi * np.interp(h, shape, finer) ** 2, 0.75, constant(1.0), largest=heights[-1]))


def tip_of_map(path, size=None):
    """Returns the Tip of a map of heights, of rows of numbers with extents (m): its area at a height is that of the pixels below."""
    image = height_maps.read_map(path, size and [1e6 * length for length in size])
    heights = zoom(image.height, FINER, order=1, grid_mode=True, mode="nearest") - image.height.min()
    rim = np.concatenate([heights[0], heights[-1], heights[:, 0], heights[:, -1]]).min()
    ordered, pixel = np.sort(heights.ravel()), (image.x[1] - image.x[0]) * (image.y[0] - image.y[1]) / FINER**2
    return Tip("height map", lambda h: pixel * np.searchsorted(ordered, h, side="right").astype(float), 0.75, constant(1.0), largest=rim)
