"""Pressures under indenters, from checkpoints: levels against one level, Hertz and Sneddon in all geometries."""
import itertools
import math

import h5py
import numpy

import harness
import report as page
from levels import smooth_load

SEGMENTS = numpy.array((-0.75, -0.25, 0.25, 0.75))  # midpoints of a face, of its half edge


def segments(level, axisymmetric):
    """(horizontal places, projected areas) of the segments of all faces that look up along the last axis."""
    dim = level["position"].shape[1]
    top = level["faces"][:].ravel() & (2 << 2 * (dim - 1)) > 0
    centre = level["position"][top]
    edges = level["deformation_gradient"][top].reshape(-1, dim, dim) * level["initial_half_size"][top][:, None, :]
    face = centre + edges[:, :, -1]
    offsets = numpy.array(list(itertools.product(SEGMENTS, repeat=dim - 1)))
    places = face[:, None, :-1] + numpy.einsum("pab,sb->psa", edges[:, :-1, :-1], offsets)
    area = numpy.abs(numpy.linalg.det(2 * edges[:, :-1, :-1])) * (2 * math.pi * face[:, 0] if axisymmetric else 1)
    return places.reshape(-1, dim - 1), numpy.repeat(area / len(offsets), len(offsets))


def nodal_pressure(result, lower, spacing, nodes, width=1, axisymmetric=False):
    """(places, pressures, areas) of the columns of the finest level in the last checkpoint, by their load over their area.

    lower, spacing, nodes: of that level's grid along the first axis and its lower corner.
    """
    with h5py.File(sorted(result.folder.glob("checkpoint_*.h5"))[-1], "r") as file:
        level = file[max(name for name in file if name.startswith("level_"))]
        places, weights = segments(level, axisymmetric)
        keys, solved = (level[name][:].ravel() for name in ("pressure_keys", "pressures"))
    axes = places.shape[1]
    cell = numpy.floor((places - numpy.array(lower)[:axes]) / spacing).astype(int)
    part = (places - numpy.array(lower)[:axes]) / spacing - cell
    key = lambda at: at[:, 0] + (nodes * at[:, 1] if axes > 1 else 0)
    hat = lambda corner, half: numpy.prod(numpy.maximum(0, 1 - numpy.abs(part - corner) / half), axis=1)
    unknowns = dict(zip(keys.astype(int), solved))
    pressure = numpy.zeros(len(places))
    corners = [numpy.array(corner) for corner in itertools.product((0, 1), repeat=axes)]
    for corner in corners:
        pressure += hat(corner, width) * numpy.array([unknowns.get(k, 0) for k in key(cell + corner)])
    area, load, column = {}, {}, {}
    for corner in corners:
        for k, at, share, total in zip(key(cell + corner), cell + corner, hat(corner, 1) * weights * pressure, hat(corner, 1) * weights):
            area[k], load[k], column[k] = area.get(k, 0) + total, load.get(k, 0) + share, at
    under = sorted(k for k in area if load[k] > 0)
    return (numpy.array([numpy.array(lower)[:axes] + spacing * column[k] for k in under]),
            numpy.array([load[k] / area[k] for k in under]), numpy.array([area[k] for k in under]))


def deviation(values, others):
    return numpy.max(numpy.abs(numpy.array(values) / numpy.array(others) - 1))


# ---- the cone on levels ----

# Cells of 250 nm under a cone of 70.3 degrees; the indenter holds at the end.
CONE = {
    "geometry": "axisymmetric", "domain_lower": "0,0", "boundary_y_lower": "symmetry", "boundary_x_upper": "symmetry", "materials": "al",
    "al_youngs_modulus": 70e9, "al_poissons_ratio": 0.33, "al_density": 2700, "bodies": "block", "block_lower": "0,0", "indenter": "cone",
    "indenter_half_angle": 70.3, "damping": 1.5e8, "frames": 0}
FINE = 250e-9


def compare_cone(expect, width, height, depth, level_1, level_2, hold):
    """Three levels against one: load from a contact radius of four cells on, and pressures at the end. Lengths in um; boxes: reach along
    both axes from the tip."""
    ramp = depth * 1e-6 / 40
    case = {**CONE, "domain_upper": f"{width}e-6,{height + 2}e-6", "block_upper": f"{width}e-6,{height}e-6",
            "indenter_tip": f"0,{height}e-6", "indenter_times": f"0,{ramp},{ramp + 1e-9}", "indenter_velocities": "40,40,0",
            "end_time": ramp + hold}
    boxes = {"cell_size": 4 * FINE, "levels": 3, "checkpoint_interval": 50}
    for number, (radius, below) in enumerate((level_1, level_2), 1):
        boxes[f"level_{number}_lower"] = f"0,{height - below}e-6"
        boxes[f"level_{number}_upper"] = f"{radius}e-6,{height + 2}e-6"
    levels = harness.run({**case, **boxes})
    uniform = harness.run({**case, "cell_size": FINE, "checkpoint_interval": 200})
    slope = 1 / math.tan(math.radians(70.3))
    depths = numpy.arange(2 * math.pi * slope * FINE, depth * 1e-6 - 20e-9, 20e-9)
    expect("cone on three levels: load against one level, from a contact radius of 4 cells on",
           deviation(*(smooth_load(result.history, depths) for result in (levels, uniform))), at_most=0.01)
    lower = (0, (height - level_2[1]) * 1e-6)
    pressures = [nodal_pressure(result, low, FINE, 0, axisymmetric=True)[1] for result, low in ((levels, lower), (uniform, (0, 0)))]
    expect("cone on three levels: loaded columns", len(pressures[0]), at_least=5)
    expect("cone on three levels: pressures p_i against one level", deviation(*pressures), at_most=0.02)
    expect("cone: largest of them against peak_pressure", deviation(pressures[1].max(), uniform.history["peak_pressure"][-1]), at_most=0.01)
    return levels, uniform


def test_cone_on_levels(expect):
    compare_cone(expect, 16, 20, 0.9, (11, 10), (6, 5), 10e-9)


def verify_cone_on_levels(study):
    """Cone on three levels against one level

    70.3 degrees, cells of 1 um, 500 and 250 nm against 250 nm throughout, in axisymmetry.
    """
    levels, uniform = compare_cone(study.expect, 30, 40, 1.2, (16, 16), (8, 8), 20e-9)
    study.plot("Load against depth", "depth (nm)", "load (mN)",
               *(page.curve(name, 1e9 * result.history["depth"], 1e3 * result.history["load"])
                 for name, result in (("three levels", levels), ("one level", uniform))))
