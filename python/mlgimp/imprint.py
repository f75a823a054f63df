"""The imprint that a test leaves: its map of heights, for programs that show images of atomic force microscopes, and its profile."""

import math
from pathlib import Path

import h5py
import numpy as np

from . import checks, instruments, load_depth, results, tables
from .errors import Error, ResultError
from .fit_profiles import Imprint
from .heads import DEPTH_UNITS, column_of
from .height_maps import HeightMap, highest, write_csv, write_gsf

LEFT = 0.02  # of the largest height or depth: what counts as imprint where its extent is looked for
ROOM = 1.3  # times the extent: what is shown
PATCHES = 2  # of the surface in a cell along each axis: a pixel is as wide as one
MOST_PIXELS = 1024  # along a side: a map of so many is a file of 4 MiB
CORNERS = {2: 2, 3: 4}  # of a patch, by dimension


# ---- the surface of a run ----

def read_patches(directory, number=None):
    """Returns the patches of the surface in a frame, by default the last one, [patches][corners][dim] in m, and the area of contact (m2)."""
    path = results.find_frame(directory, number)
    try:
        with h5py.File(path, "r") as file:
            if "surface" not in file:
                raise ResultError(path, "has no surface: it needs a run with -contact pressure")
            corners, area = results.numbers_of(file["surface"]["position"]), float(file.attrs.get("contact_area", 0))
    except OSError as problem:
        raise ResultError(path, f"not a frame of points ({problem})") from None
    dim = corners.shape[1]
    return corners.reshape(-1, CORNERS[dim], dim), area


def surface_of(directory, number=None):
    """Returns the patches of the surface [patches][corners][dim] in um from the tip's axis, heights from the highest place of the
    undeformed surface, with their images at sides of symmetry that the tip is on; the options of the run; and whether the tip touches."""
    options, history = results.read_summary(directory).get("options", {}), results.read_history(directory)
    if "-indenter_tip" not in options:
        raise ResultError(directory, "there is no summary.json with the options of a tip")
    if options.get("-geometry") == "plane_strain":
        raise ResultError(directory, "a run in plane strain leaves a groove without an end, no imprint")
    number = results.number_in(results.find_frame(directory, number))
    (patches, area), (before, _) = read_patches(directory, number), read_patches(directory, min(results.numbered_frames(directory)))
    time = results.read_time(results.find_frame(directory, number))
    start = load_depth.numbers(options["-indenter_tip"])[:-1]
    moved = [np.interp(time, history["time"], history.get(f"tip_{axis}", place + 0 * history["time"])) for axis, place in zip("xy", start)]
    axes = load_depth.mirror_axes(options)
    middle = [start[axis] if axis in axes else moved[axis] for axis in range(len(start))]
    patches = 1e6 * (patches - [*middle, before[..., -1].max()])
    for axis in axes:
        patches = np.concatenate([patches, patches * np.where(np.arange(patches.shape[2]) == axis, -1, 1)])
    return patches, options, area > 0


def profile_of(directory, number=None):
    """Returns the Imprint of an axisymmetric run, radii and heights (um), in a frame, by default the last one."""
    patches, options, _ = surface_of(directory, number)
    if options.get("-geometry") != "axisymmetric":
        raise ResultError(directory, "only an axisymmetric run has a profile over the radius")
    corners = np.unique(patches.reshape(-1, 2), axis=0)
    return Imprint(*corners.T)


def read_profile(path, radius="radius:um", height="height:um"):
    """Returns the Imprint that a text with columns has: radii from the tip's axis, and heights over the undeformed surface, below zero in the
    imprint; COLUMN:UNIT as in load_depth.read_measured."""
    columns = [column_of("radius", radius, DEPTH_UNITS), column_of("height", height, DEPTH_UNITS)]
    source = instruments.sources(checks.path("path", path))[0]
    table, _ = tables.tests_of(path, source.lines, source.mark, source.numerals, columns)[0]()
    table = table[np.argsort(table[:, 0], kind="stable")]
    if table[0, 0] < 0:
        raise ResultError(path, "has radii below zero: they count from the tip's axis")
    return Imprint(*table.T)


# ---- the map ----

def height_map(directory, number=None, pixel=None):
    """Returns the HeightMap of a run's frame, by default the last one; pixel (um): by default that of a patch of the finest cells."""
    patches, options, _ = surface_of(directory, number)
    extent = extent_of(patches)
    if pixel is None:
        cells = results.finest_cells(results.read_summary(directory), [math.inf])[0]
        pixel = max(1e6 * cells / PATCHES, 2 * max(extent) / MOST_PIXELS)
    pixel = checks.number("pixel", pixel, checks.POSITIVE)
    if 2 * max(extent) / pixel > 4 * MOST_PIXELS:
        raise Error(f"pixel={pixel:g}: must be at least {max(extent) / MOST_PIXELS / 2:.3g} um, for a map of {4 * MOST_PIXELS} pixels at most")
    x, y = (pixel * np.arange(-math.ceil(reach / pixel), math.ceil(reach / pixel) + 1) for reach in extent)
    y = y[::-1]  # images begin above
    if patches.shape[2] == 2:
        corners = np.unique(patches.reshape(-1, 2), axis=0)
        radius = np.hypot(*np.meshgrid(x, y))
        return HeightMap(x, y, np.where(radius <= corners[-1, 0], np.interp(radius, *corners.T), np.nan))
    return HeightMap(x, y, highest(patches[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3), x, y))


def extent_of(patches):
    """Returns how far (um) the imprint reaches from the tip's axis along x and along y, with some room, within the surface."""
    places = np.abs(patches[..., :-1])
    heights = np.abs(patches[..., -1])
    left = heights > LEFT * heights.max()
    reach = np.minimum(ROOM * places[left].max(axis=0, initial=0), places.max(axis=(0, 1)))
    return tuple(np.broadcast_to(reach, 2)) if reach.min() > 0 else tuple(np.broadcast_to(places.max(axis=(0, 1)), 2))


# ---- files ----

def write(folder, image, title):
    """Writes surface.gsf and surface.csv into a folder, and returns their paths."""
    paths = Path(folder) / "surface.gsf", Path(folder) / "surface.csv"
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        write_gsf(paths[0], image, title)
        write_csv(paths[1], image)
    except OSError as problem:
        raise ResultError(folder, f"cannot be written to ({problem.strerror})") from None
    return paths
