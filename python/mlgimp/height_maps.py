"""Maps of heights, as programs that show images of atomic force microscopes read and write them. Lengths in um, in files in m."""

import struct
from collections import namedtuple
from pathlib import Path

import numpy as np

from .errors import ResultError

HeightMap = namedtuple("HeightMap", "x y height")
HeightMap.__doc__ = """Heights (um) [rows][columns] at places x [columns] from left to right and y [rows] from above to below, y falls, in um; NaN where
there is no surface. Of an imprint heights are over the undeformed surface and places from the tip's axis."""

FIELD = b"Gwyddion Simple Field 1.0\n"


# ---- reading ----

def read_map(path, size=None):
    """Returns the HeightMap of a Gwyddion Simple Field, or of rows of numbers in m over extents (along x, along y) in um, the first row at the
    largest y; places count from the middle."""
    try:
        content = Path(path).read_bytes()
        if content.startswith(FIELD):
            return field_of(path, content)
        rows = np.loadtxt(path, delimiter="," if b"," in content else None, ndmin=2)
    except (OSError, ValueError) as problem:
        raise ResultError(path, f"is no map of heights ({problem})") from None
    if size is None:
        raise ResultError(path, "rows of numbers do not say their extents: they must be given")
    return map_over(1e6 * rows, size)


def field_of(path, content):
    """Returns the HeightMap of the bytes of a Gwyddion Simple Field."""
    end = content.index(b"\0")
    head = {name.strip(): value.strip() for name, _, value in (line.partition("=") for line in content[:end].decode().splitlines())}
    if head.get("XYUnits") != "m" or head.get("ZUnits") != "m":
        raise ResultError(path, f"is in '{head.get('XYUnits')}' and '{head.get('ZUnits')}'; lengths and heights must be in m")
    try:
        columns, rows, size = int(head["XRes"]), int(head["YRes"]), [1e6 * float(head[name]) for name in ("XReal", "YReal")]
    except KeyError as missing:
        raise ResultError(path, f"its head has no {missing.args[0]}") from None
    numbers = np.frombuffer(content[end + 4 - end % 4:], "<f4")
    if len(numbers) != rows * columns:
        raise ResultError(path, f"has {len(numbers)} heights in place of {rows} x {columns}")
    return map_over(1e6 * numbers.reshape(rows, columns).astype(float), size)


def map_over(heights, size):
    """Returns the HeightMap of heights [rows][columns] from above over extents, each in the middle of its pixel."""
    x, y = (length / count * (np.arange(count) - (count - 1) / 2) for length, count in zip(size, heights.shape[::-1]))
    return HeightMap(x, y[::-1], heights)


# ---- surfaces ----

def highest(triangles, x, y):
    """Returns the heights [len(y)][len(x)] of the highest of some triangles [n][3 corners][x, y, z] at places x, which rise, and y, which
    fall; NaN where there is none."""
    heights = np.full((len(y), len(x)), -np.inf)
    edge = 1e-9  # of a triangle: pixels on the line between two belong to both
    for triangle in triangles:
        (left, low, _), (right, high, _) = triangle.min(axis=0), triangle.max(axis=0)
        columns = slice(np.searchsorted(x, left - edge), np.searchsorted(x, right + edge, "right"))
        rows = slice(np.searchsorted(-y, -high - edge), np.searchsorted(-y, -low + edge, "right"))
        (x0, y0, z0), one, two = triangle[0], triangle[1] - triangle[0], triangle[2] - triangle[0]
        area = one[0] * two[1] - one[1] * two[0]
        if area == 0 or columns.start == columns.stop or rows.start == rows.stop:
            continue
        across, along = np.meshgrid(x[columns] - x0, y[rows] - y0)
        first, second = (across * two[1] - along * two[0]) / area, (one[0] * along - one[1] * across) / area
        inside = (first >= -edge) & (second >= -edge) & (first + second <= 1 + edge)
        height = np.where(inside, z0 + first * one[2] + second * two[2], -np.inf)
        heights[rows, columns] = np.maximum(heights[rows, columns], height)
    return np.where(np.isfinite(heights), heights, np.nan)


# ---- writing ----

def write_gsf(path, image, title):
    """Writes a HeightMap as a Gwyddion Simple Field 1.0: a header of text, then 32-bit floats, little endian, row by row from above.

    Lengths and heights are in m; zeros fill the header to a multiple of four bytes, at least one. A place without a surface has the least
    height, since the format's readers differ about NaN.
    """
    pixel = image.x[1] - image.x[0]
    size = {"X": 1e-6 * pixel * len(image.x), "Y": 1e-6 * pixel * len(image.y)}
    lines = ["Gwyddion Simple Field 1.0", f"XRes = {len(image.x)}", f"YRes = {len(image.y)}"]
    lines += [f"{axis}Real = {length:.9g}" for axis, length in size.items()] + [f"{axis}Offset = {-length / 2:.9g}" for axis, length in size.items()]
    lines += ["XYUnits = m", "ZUnits = m", f"Title = {' '.join(title.split())}"]
    header = ("\n".join(lines) + "\n").encode()
    heights = 1e-6 * np.nan_to_num(image.height, nan=np.nanmin(image.height))
    Path(path).write_bytes(header + bytes(4 - len(header) % 4) + struct.pack(f"<{heights.size}f", *heights.ravel()))


def write_csv(path, image):
    """Writes a HeightMap as a matrix of heights in m with commas, row by row from above, below lines with # that tell its size."""
    pixel = image.x[1] - image.x[0]
    head = f"Channel: Height\nWidth: {1e-6 * pixel * len(image.x):.9g} m\nHeight: {1e-6 * pixel * len(image.y):.9g} m\nValue units: m"
    np.savetxt(path, 1e-6 * image.height, fmt="%.9g", delimiter=",", header=head, comments="# ")
