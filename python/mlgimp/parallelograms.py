"""Domains of material points in a picture: each point is a square that deformed with the body, a parallelogram, in its own colour. Nothing
is smoothed."""

import numpy as np

SMALL = 1e-6  # of a dot: what rounding leaves where a domain ends at the line between two
UNEQUAL = 1e-8  # weight of the difference of the edges where the sizes do not tell one from the other, as after a turn by 45 degrees


def edges_of(points):
    """Returns the vectors from the middle of each domain to the middle of its sides, [n][side][2] in m: the columns of the deformation gradient
    F times the half sizes r of the square before it deformed.

    points: a dict with half_size h [n][2] (m), h_i^2 = sum_j F_ij^2 r_j^2, and deformation_gradient [n][4] (xx, xy, yx, yy); without the latter
    domains are rectangles of these half sizes.
    """
    half = points["half_size"]
    if "deformation_gradient" not in points:
        return half[:, :, None] * np.eye(2)
    gradient = points["deformation_gradient"].reshape(-1, 2, 2)
    squares, difference = gradient**2, np.array([[1.0, -1.0], [-1.0, 1.0]])
    normal = np.einsum("nki,nkj->nij", squares, squares)
    normal += UNEQUAL * np.trace(normal, axis1=1, axis2=2)[:, None, None] * difference
    first = np.einsum("nki,nk->ni", squares, half**2)
    size = np.sqrt(np.maximum(np.linalg.solve(normal, first[..., None])[..., 0], 0))  # before the deformation
    edges = np.swapaxes(gradient * size[:, None, :], 1, 2)
    length = np.linalg.norm(edges, axis=1)  # along each axis
    return edges * (half / np.where(length > 0, length, 1))[:, None, :]  # a slice has lost what turned out of it


def paint(points, values, window, shape):
    """Returns an image [rows from below][columns] of a window (xmin, xmax, ymin, ymax in m): the value at each of its dots, NaN where no point lies.

    A domain covers all dots that it touches, so that neighbours leave no seams; large ones lie beneath the others. Where a metal has flowed far,
    domains leave gaps: beneath all lie the rectangles of the points inside of bodies (faces [n] == 0), which the method itself takes for domains.
    """
    image = np.full(shape, np.nan)
    inner = {name: each[points["faces"] == 0] for name, each in points.items()} if "faces" in points else None
    if inner is not None and len(inner["position"]):
        paint_domains(image, inner["position"], inner["half_size"][:, :, None] * np.eye(2), values[points["faces"] == 0], window)
    paint_domains(image, points["position"], edges_of(points), values, window)
    return image


def paint_domains(image, position, edges, values, window):
    """Paints domains with their middles [n][2] (m), edges [n][side][2] (m) and values [n] over what an image of the window has."""
    shape = image.shape
    dot = np.array([window[1] - window[0], window[3] - window[2]]) / shape[::-1]
    reach, place = np.abs(edges).sum(axis=1), position - window[0::2]
    seen = np.flatnonzero(np.all((place + reach >= 0) & (place - reach <= dot * shape[::-1]), axis=1))
    seen = seen[np.argsort(-np.abs(np.linalg.det(edges[seen])), kind="stable")]
    middle, reach = place[seen] / dot, reach[seen] / dot
    first = np.clip(np.floor(middle - reach + SMALL), 0, None).astype(int)
    last = np.minimum(np.ceil(middle + reach - SMALL).astype(int), shape[::-1])
    size = np.maximum(last - first, 0)
    counts = size.prod(axis=1)
    owner = np.repeat(np.arange(len(seen)), counts)
    row, column = np.divmod(np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts), size[owner, 0])
    dots = first[owner] + np.column_stack([column, row])
    inside = touched(edges[seen] / dot, owner, dots + 0.5 - middle[owner])
    image[dots[inside, 1], dots[inside, 0]] = values[seen][owner[inside]]  # of several the last stays


def touched(edges, owner, offset):
    """Whether parallelograms of these edges [n][side][2] (dots) meet dots whose middles lie at an offset [m][2] from that of number owner [m]."""
    area = np.abs(np.linalg.det(edges))
    room = area[:, None] + (0.5 - SMALL) * np.abs(edges).sum(axis=2)  # |offset x side| < that
    sides = edges[owner]
    return np.all(np.abs(offset[:, None, 0] * sides[..., 1] - offset[:, None, 1] * sides[..., 0]) < room[owner], axis=1)
