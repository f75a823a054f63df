"""Pressures under indenters, from checkpoints: levels against one level, Hertz and Sneddon in all geometries."""
import itertools
import math
from collections import namedtuple

import h5py
import numpy

import harness
import studies_page as page
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


Pressed = namedtuple("Pressed", "places pressures areas moment")  # moment: root of the mean of r^2 under the pressure


PADDING, NUMBERS = 3, 8  # layers of nodes beyond a grid; numbers that contact keeps of a column, the first its mean pressure


def nodal_pressure(result, lower, spacing, axisymmetric=False):
    """Mean pressures of the loaded columns of the finest level in the last checkpoint, and the moment of what they show between them.

    lower, spacing: of that level's grid.
    """
    with h5py.File(sorted(result.folder.glob("checkpoint_*.h5"))[-1], "r") as file:
        level = file[max(name for name in file if name.startswith("level_"))]
        places, weights = segments(level, axisymmetric)
        keys, solved, nodes = (level[name][:].ravel() for name in ("pressure_keys", "pressures", "columns"))
    axes = places.shape[1]
    lower, of_means = numpy.array(lower)[:axes], (keys.astype(int) % NUMBERS == 0) & (keys >= 0)
    keys, solved = keys[of_means].astype(int) // NUMBERS, solved[of_means]
    columns = numpy.stack((keys % int(nodes.sum()), keys // int(nodes.sum())), axis=1)[:, :axes] - PADDING
    means = dict(zip(map(tuple, columns), solved))
    cell = numpy.floor((places - lower) / spacing).astype(int)
    pressure, area = numpy.zeros(len(places)), {}
    for corner in itertools.product((0, 1), repeat=axes):
        hat = numpy.prod(1 - numpy.abs(places - lower - spacing * (cell + corner)) / spacing, axis=1)
        pressure += hat * numpy.array([means.get(tuple(at), 0) for at in cell + corner])
        for at, share in zip(map(tuple, cell + corner), hat * weights):
            area[at] = area.get(at, 0) + share
    return Pressed(lower + spacing * columns, solved, numpy.array([area.get(at, 0) for at in means]),
                   math.sqrt(numpy.average((places**2).sum(axis=1), weights=pressure * weights)))


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
    pressures = [nodal_pressure(result, low, FINE, axisymmetric=True).pressures for result, low in ((levels, lower), (uniform, (0, 0)))]
    expect("cone on three levels: loaded columns", len(pressures[0]), at_least=5)
    expect("cone on three levels: pressures p_i against one level", deviation(*pressures), at_most=0.02)
    expect("cone: largest of them against peak_pressure", deviation(pressures[1].max(), uniform.history["peak_pressure"][-1]), at_most=0.01)
    return levels, uniform


def test_cone_on_levels(expect):
    """Seen: 0.005, 8, 0.002, 0.0009: half a per cent, as in the larger block of verify_cone_on_levels (0.004, 0.0006, 0.001)."""
    compare_cone(expect, 16, 20, 0.9, (11, 10), (6, 5), 10e-9)


def verify_cone_on_levels(study):
    """Cone on three levels against one level

    70.3 degrees, cells of 1 um, 500 and 250 nm against 250 nm throughout, in axisymmetry.
    """
    levels, uniform = compare_cone(study.expect, 30, 40, 1.2, (16, 16), (8, 8), 20e-9)
    study.plot("Load against depth", "depth (nm)", "load (mN)",
               *(page.curve(name, 1e9 * result.history["depth"], 1e3 * result.history["load"])
                 for name, result in (("three levels", levels), ("one level", uniform))))


# ---- Hertz ----

# Lengths in cells of the finest level, E* = 1; the indenter comes down within three and a half transits of a wave and holds.
BLOCK = {"cell_size": 1, "boundary_x_upper": "symmetry", "materials": "m", "m_youngs_modulus": 0.91, "m_poissons_ratio": 0.3, "m_density": 1,
         "bodies": "block", "damping": 0.06, "frames": 0, "checkpoint_interval": 20}


def pressed(depth, height):
    """Motion to a depth, slow to start and to end, on a block of a height; no shorter than a few steps."""
    ramp = 3.5 * height / 1.16
    return {"indenter_times": f"0,{0.15 * ramp},{0.85 * ramp},{ramp}", "indenter_velocities": [0, depth / (0.85 * ramp), depth / (0.85 * ramp), 0],
            "end_time": 1.7 * ramp}


def hertz(expect, name, at, radius, load, tolerances, plane=False):
    """Width from the second moment and pressures at r < 0.8 a, for the half width that Hertz has at this load; returns it and the errors."""
    a = math.sqrt(4 * load * radius / math.pi) if plane else (0.75 * load * radius) ** (1 / 3)
    largest = a / (2 * radius) if plane else 2 * a / (math.pi * radius)
    r = numpy.sqrt((at.places**2).sum(axis=1))
    inside = r < 0.8 * a
    error = at.pressures[inside] / largest - numpy.sqrt(1 - (r[inside] / a) ** 2)
    rms, moment = math.sqrt(numpy.mean(error**2)), math.sqrt(4 if plane else 2.5) * at.moment / a - 1
    expect(f"{name}: half width {a:.3g} cells, that from the second moment", 1 + moment, near=1, tolerance=tolerances[0])
    expect(f"{name}: rms error of p_i, r < 0.8 a", rms, at_most=tolerances[1])
    expect(f"{name}: largest p_i", at.pressures.max() / largest, near=1, tolerance=tolerances[2])
    return a, rms, moment


# A sphere on three levels of which the finest has the contact, in both geometries; the blocks have the same section.
SPHERE = {**BLOCK, **pressed(0.5, 56), "cell_size": 4, "levels": 3, "blend_width": 2, "indenter": "sphere", "indenter_radius": 120}
ROUND = {**SPHERE, "geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "72,64", "boundary_y_lower": "symmetry",
         "block_lower": "0,0", "block_upper": "72,56", "indenter_tip": "0,56", "level_1_lower": "0,28", "level_1_upper": "32,64",
         "level_2_lower": "0,44", "level_2_upper": "16,64"}
SPACE = {**SPHERE, "geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "64,64,64", "boundary_x_lower": "symmetry",
         "boundary_y_lower": "symmetry", "boundary_y_upper": "symmetry", "boundary_z_lower": "symmetry", "block_lower": "0,0,0",
         "block_upper": "64,64,56", "indenter_tip": "0,0,56", "level_1_lower": "0,0,28", "level_1_upper": "32,32,64",
         "level_2_lower": "0,0,44", "level_2_upper": "16,16,64"}


def round_sphere(expect):
    result = harness.run(ROUND)
    pressures = nodal_pressure(result, (0, 44), 1, axisymmetric=True)
    hertz(expect, "axisymmetric sphere", pressures, 120, result.history["load"][-1], (0.02, 0.02, 0.04))
    return result, pressures


def test_sphere_on_levels(expect):
    """Seen: 1.008, 0.005, 0.991, on eight cells of half width."""
    round_sphere(expect)


def verify_sphere_on_levels(study):
    """Hertz's sphere on three levels, in axisymmetry and in space

    Radius of 120 of the finest cells, contact radius of 8, on blocks of equal section; a quarter of the block in space.
    """
    (flat, of_flat), space = round_sphere(study.expect), harness.run(SPACE)
    load, of_space = 4 * space.history["load"], nodal_pressure(space, (0, 0, 44), 1)
    hertz(study.expect, "sphere in space", of_space, 120, load[-1], (0.015, 0.02, 0.04))
    depths = numpy.linspace(0.25, 0.49, 9)
    loads = [numpy.interp(depths, history["depth"], scale * history["load"]) for history, scale in ((flat.history, 1), (space.history, 4))]
    study.expect("sphere: load in axisymmetry against space at equal depth", deviation(*loads), at_most=0.015)
    plot_pressures(study, {"axisymmetric": (of_flat, flat.history["load"][-1]), "space": (of_space, load[-1])})
    study.plot("Load against depth", "depth (cells)", "load (E* h2)", page.curve("axisymmetric", flat.history["depth"], flat.history["load"]),
               page.curve("space", space.history["depth"], load))


def plot_pressures(study, found):
    """Pressures of columns over the radius, and Hertz's; found: {name: (pressures, load)}, E* = 1."""
    curves = []
    for name, (at, load) in found.items():
        a = (0.75 * load * 120) ** (1 / 3)
        curves.append(page.curve(name, numpy.sqrt((at.places**2).sum(axis=1)) / a, at.pressures / (2 * a / (math.pi * 120)), "dots"))
    r = numpy.sin(numpy.linspace(0, math.pi / 2, 60))
    study.plot("Pressures of columns", "r / a", "pressure / Hertz's largest", *curves, page.curve("Hertz", r, numpy.sqrt(1 - r**2), "reference"))


# ---- cone and pyramids ----

WIDE = {**SPACE, "domain_lower": "-64,0,0", "boundary_x_lower": "symmetry", "block_lower": "-64,0,0", "level_1_lower": "-32,0,28",
        "level_2_lower": "-16,0,44"}
BLOCK_STIFFNESS = -0.5  # of depth = half space's + this P/(E* L), L the block's half width: from the sphere's load and depth


def load_over_depth(case, tip, depth, parts):
    """P/(E* d^2) of a sharp tip held at a depth, which is put right for what the block is stiffer than the half space."""
    options = {name: value for name, value in {**case, **pressed(depth, 56), "checkpoint_interval": 0, "indenter_radius": None, **tip}.items() if value is not None}
    load = parts * numpy.mean(harness.run(options).history["load"][-10:])
    return load / (depth - BLOCK_STIFFNESS * load / 64) ** 2


def verify_pyramids(study):
    """Cone, Vickers and Berkovich pyramids in elastic blocks

    P/(E* d^2), with the depth put right for the finite block, on three levels: faces at 0.1 to the surface against boundary
    elements of the linear half space, the real angles (3.5 of the finest cells deep) against published finite elements.
    """
    flat = {"indenter_half_angle": math.degrees(math.atan(10))}
    for name, case, faces, parts, expected in (("four", SPACE, 4, 4, 0.7375), ("three", WIDE, 3, 2, 0.8824)):
        seen = 0.1 * load_over_depth(case, {"indenter": "pyramid", "indenter_faces": faces, **flat}, 0.8, parts)
        study.expect(f"pyramid with {name} faces at 0.1: P tan b/(E* d^2) over that of the half space", seen / expected, near=1, tolerance=0.03)
    cone = load_over_depth(ROUND, {"indenter": "cone", "indenter_half_angle": 70.3}, 3.5, 1)
    study.figure("cone of 70.3 degrees: P/(E* d^2)", cone)
    for name, case, parts, expected, of_cone in (("vickers", SPACE, 4, 1.929, 1.027), ("berkovich", WIDE, 2, 2.025, 1.078)):
        seen = load_over_depth(case, {"indenter": name}, 3.5, parts)
        study.expect(f"{name}: P/(E* d^2)", seen, near=expected, tolerance=0.05 * expected)
        study.expect(f"{name}: over that of the cone", seen / cone, near=of_cone, tolerance=0.03 * of_cone)
