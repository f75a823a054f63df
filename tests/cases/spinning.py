"""A disk that spins freely: its velocity is put into a checkpoint, as no option gives a body a turning motion."""
import math
import shutil

import h5py
import numpy
from scipy.optimize import brentq
from scipy.special import j0, j1

import harness
import studies_page as page
from mlgimp import results

NU, RADIUS, MIDDLE = 0.3, 16.0, 20.0
MODULUS = (1 - NU) / ((1 + NU) * (1 - 2 * NU))  # of waves, E = 1
SPEED = math.sqrt(MODULUS)  # density 1
SPIN = 0.03 * SPEED / RADIUS  # rad per time: the rim goes at 0.03 of the speed of waves
WAVE = brentq(lambda k: k * j0(k) - (1 - 2 * NU) / (1 - NU) * j1(k), 1.5, 2.4)  # of the first mode along the radius, over it: its rim is free
SWING = 2 * math.pi / WAVE * RADIUS / SPEED


def case(points, cells):
    return {"domain_lower": "0,0", "domain_upper": (2 * MIDDLE, 2 * MIDDLE), "cell_size": RADIUS / cells, "materials": "m", "m_youngs_modulus": 1,
            "m_poissons_ratio": NU, "m_density": 1, "bodies": "disk", "disk_shape": "disk", "disk_center": (MIDDLE, MIDDLE), "disk_radius": RADIUS,
            "disk_points_per_cell": points}


def spun(cells, points=2, swings=4):
    """Result of a disk that spins for some of its swings, with 20 frames in each."""
    options = case(points, cells)
    still = harness.run({**options, "max_steps": 1, "checkpoint_interval": 1, "frames": 0})
    start = still.folder / "spun.h5"
    shutil.copy(still.folder / "checkpoint_000001.h5", start)
    with h5py.File(start, "r+") as file:
        level = file["level_0"]
        offset = level["position"][:] - MIDDLE
        level["velocity"][:] = SPIN * numpy.stack((-offset[:, 1], offset[:, 0]), axis=1)
    return harness.run({**options, "restart": start, "max_steps": 0, "end_time": swings * SWING, "frames": 20 * swings})


def mean_stresses(result):
    """(radius at the start, radial and hoop stress, mean over the frames) of each point, and the spin of each frame."""
    total, spins = 0, []
    for number, path in results.numbered_frames(result.folder).items():
        if number == 0:
            continue  # as the last of a whole number of swings
        points = results.all_points(results.read_frame(path).levels)
        order = numpy.argsort(points["id"])
        points = {name: values[order] for name, values in points.items()}
        offset = points["position"] - MIDDLE
        radius = numpy.linalg.norm(offset, axis=1)
        n, (xx, yy, xy) = offset / radius[:, None], points["stress"].T[[0, 1, 3]]
        radial = n[:, 0]**2 * xx + n[:, 1]**2 * yy + 2 * n[:, 0] * n[:, 1] * xy
        total = total + numpy.stack((radial, xx + yy - radial))
        moment = offset[:, 0] * points["velocity"][:, 1] - offset[:, 1] * points["velocity"][:, 0]
        spins.append(numpy.sum(points["mass"] * moment) / numpy.sum(points["mass"] * radius**2))
    return radius, *(total / len(spins)), numpy.array(spins)


def cell_means(result, cells, *values):
    """Each of the values as mean over the points that began in one cell, of cells that began full."""
    points = result.frame()
    first = numpy.floor((points["position"] - points["displacement"]) / (RADIUS / cells)).astype(int)
    _, cell, count = numpy.unique(first, axis=0, return_inverse=True, return_counts=True)
    return [(numpy.bincount(cell.ravel(), each) / count)[count == count.max()] for each in values]


def exact(radius, spin):
    """Radial and hoop stress in plane strain, density 1: rho w^2 (3 - 2 nu)/(8 (1 - nu)) (R^2 - r^2), and (1 + 2 nu)/(3 - 2 nu) less r^2."""
    factor = spin**2 * (3 - 2 * NU) / (8 * (1 - NU))
    return factor * (RADIUS**2 - radius**2), factor * (RADIUS**2 - (1 + 2 * NU) / (3 - 2 * NU) * radius**2)


def verify_spinning_disk(study):
    """A disk that spins

    In plane strain, 16 and 32 cells in its radius: it starts without stress and swings along its radius, so that stresses are the mean over four swings.
    Points of a round body are parts of rectangles, whose stress is of the first order in the cells near the rim. What scatters in the plot alternates from
    point to point within a cell: a stress that nodes do not feel, and that the rim leaves in points that change their cell. Means over cells have little of it.
    """
    errors, of_means = {"radial": [], "hoop": []}, {"radial": [], "hoop": []}
    for cells in (16, 32):
        result = spun(cells)
        radius, radial, hoop, spins = mean_stresses(result)
        of_radial, of_hoop = exact(radius, numpy.sqrt(numpy.mean(spins**2)))
        inside, largest = radius < 0.9 * RADIUS, exact(0.0, numpy.mean(spins))[0]
        for name, ours, theirs in (("radial", radial, of_radial), ("hoop", hoop, of_hoop)):
            errors[name].append(numpy.sqrt(numpy.mean((ours - theirs)[inside]**2)) / largest)
            study.figure(f"{cells} cells: {name} stress within 0.9 R, rms error, of the largest", errors[name][-1])
            middle, of_cells = cell_means(result, cells, radius, (ours - theirs) / largest)
            of_means[name].append(numpy.sqrt(numpy.mean(of_cells[middle < 0.9 * RADIUS]**2)))
            study.figure(f"{cells} cells: {name} stress within 0.9 R, mean over the points of a cell, rms error, of the largest", of_means[name][-1])
            core = radius < 0.3 * RADIUS
            ours, theirs = (numpy.mean(each[core]) / largest for each in (ours, theirs))
            study.compare(f"{cells} cells: {name} stress within 0.3 R", ours, theirs, 0.03, "of the largest")
        study.compare(f"{cells} cells: spin at the end", spins[-1] / SPIN, 1.0, 0.02, "of that at the start")
    for text, least, found in (("", 0.8, errors), (", means over cells", 1.5, of_means)):
        for name, (coarse, fine) in found.items():
            study.expect(f"order of the rms error of the {name} stress{text}", math.log2(coarse / fine), at_least=least)
    order = numpy.argsort(radius)
    shown = order[::len(order) // 250]
    middle, *means = cell_means(result, cells, radius, radial, hoop)
    few = numpy.argsort(middle)[::len(middle) // 60]
    study.plot("Stresses of a disk that spins, 32 cells", "r / R", "stress / largest",
               page.curve("radial", radius[shown] / RADIUS, radial[shown] / largest, "dots"),
               page.curve("hoop", radius[shown] / RADIUS, hoop[shown] / largest, "dots"),
               *(page.curve(f"{name}, mean of a cell", middle[few] / RADIUS, each[few] / largest, "dots") for name, each in zip(("radial", "hoop"), means)),
               *(page.curve("_exact", radius[order] / RADIUS, each[order] / largest, "reference") for each in (of_radial, of_hoop)))
