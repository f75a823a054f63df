"""The series of frames. points.vtkhdf, read by the rules of VTKHDF (docs.vtk.org): every time step holds the points of its frame,
level by level. points.xdmf, read by ParaView. surface.vtkhdf: the surface, and what presses on it."""
import itertools
import json
import math
import shutil
import subprocess

import h5py
import numpy
import pytest

import harness
from ranks import BERKOVICH, CONE, FLIGHT, LEVELS

pytestmark = pytest.mark.mpi

# Where the components of the plane are among those that VTK takes of vectors, symmetric tensors and others.
COLUMNS = {**{(vector, 2): ([0, 1], 3) for vector in ("position", "velocity", "displacement", "half_size")},
           ("stress", 4): ([0, 1, 2, 3], 6), ("deformation_gradient", 4): ([0, 1, 3, 4], 9)}


def as_vtk(name, level):
    """A field of a level of a frame with the components that VTK takes; F_zz of the plane is the hoop's stretch or one."""
    values = level[name][:]
    places, width = COLUMNS.get((name, values.shape[-1] if values.ndim > 1 else 1), (None, 0))
    if places is None:
        return values
    wide = numpy.zeros((len(values), width))
    wide[:, places] = values
    if name == "deformation_gradient":
        wide[:, 8] = level.get("hoop_stretch", [1])[:]
    return wide


def filled_levels(frame):
    """The names of the levels that have points."""
    return [name for name in sorted(frame) if name.startswith("level_") and len(frame[name]["id"])]


def density(level):
    """Of each point, by mass, volume and the determinant of F as VTK shows it."""
    gradient = as_vtk("deformation_gradient", level).reshape(-1, 3, 3)
    return level["mass"][:] / level["volume"][:] * numpy.linalg.det(gradient)


def vertices(group, first, count, part):
    """The points that the vertices of one part show; `first`: vertices before the part, `part`: parts before it."""
    assert group["NumberOfCells"][part] == count == group["NumberOfConnectivityIds"][part]
    offsets = group["Offsets"][first + part : first + part + count + 1]
    assert numpy.array_equal(numpy.diff(offsets), numpy.ones(count))  # one point each
    return group["Connectivity"][first : first + count][offsets[:-1]]


def problems_of_step(root, step, frame):
    """What a reader of VTKHDF finds wrong in a time step, against the frame it is of."""
    steps, wrong = root["Steps"], []
    if steps["Values"][step] != frame.attrs["time"]:
        wrong.append("time")
    part, parts, first = (int(steps[name][step]) for name in ("PartOffsets", "NumberOfParts", "PointOffsets"))
    filled = filled_levels(frame)
    if parts != len(filled) or list(steps["CellOffsets"][step]) != [first, 0, 0, 0]:
        wrong.append("parts or cells")
    for name in filled:
        level, count = frame[name], int(root["NumberOfPoints"][part])
        if not numpy.array_equal(vertices(root["Vertices"], first, count, part), numpy.arange(count)):
            wrong.append(f"{name}: vertices")
        for field in set(level) - {"vertex"}:
            data, offset = root["Points"], first
            if field != "position":
                data = root["PointData"][field]
                offset += int(steps["PointDataOffsets"][field][step]) - int(steps["PointOffsets"][step])
            if not numpy.array_equal(data[offset : offset + count], as_vtk(field, level)):
                wrong.append(f"{name}: {field}")
        if set(root["PointData"]) != set(level) - {"position", "vertex"} | {"level"}:
            wrong.append(f"{name}: fields")
        if not numpy.array_equal(root["PointData/level"][first : first + count], numpy.full(count, int(name[-1]))):
            wrong.append(f"{name}: level")
        if numpy.ptp(density(level)) > 1e-12 * density(level)[0]:
            wrong.append(f"{name}: det F")
        part, first = part + 1, first + count
    return wrong


def problems_of_series(folder):
    """What is wrong with the series of all frames in a folder."""
    frames, wrong = sorted(folder.glob("points_*.h5")), []
    with h5py.File(folder / "points.vtkhdf") as file:
        root = file["VTKHDF"]
        header = [root.attrs["Type"], *root.attrs["Version"], root["Steps"].attrs["NSteps"]]
        if header != [b"PolyData", 2, 0, len(frames)]:
            wrong.append("header")
        counts = ("NumberOfCells", "NumberOfConnectivityIds", "Offsets")
        for group, name in itertools.product(("Lines", "Polygons", "Strips"), counts):
            if not numpy.array_equal(root[group][name][:], numpy.zeros(len(root["NumberOfPoints"]))):
                wrong.append(f"{group}: {name}")
        for step, path in enumerate(frames):
            with h5py.File(path) as frame:
                wrong += [f"{path.name}: {problem}" for problem in problems_of_step(root, step, frame)]
    return wrong


def problems_of_surface(folder):
    """What a reader of VTKHDF finds wrong in the series of the surface, against the frames."""
    wrong = []
    with h5py.File(folder / "surface.vtkhdf") as file:
        root = file["VTKHDF"]
        steps, first, cell = root["Steps"], 0, 0
        for step, path in enumerate(sorted(folder.glob("points_*.h5"))):
            with h5py.File(path) as frame:
                surface = frame["surface"]
                positions, pressures = surface["position"][:], surface["contact_pressure"][:]
            kind, column, corners = ("Lines", 1, 2) if positions.shape[1] == 2 else ("Polygons", 2, 4)
            count = len(pressures)
            if steps["Values"][step] != h5py.File(path).attrs["time"] or steps["NumberOfParts"][step] != 1:
                wrong.append(f"{path.name}: time or parts")
            if steps["PointOffsets"][step] != first or steps["CellOffsets"][step][column] != cell or steps["ConnectivityIdOffsets"][step][column] != first:
                wrong.append(f"{path.name}: offsets")
            offsets = root[kind]["Offsets"][cell + step : cell + step + count + 1]
            if not numpy.array_equal(offsets, corners * numpy.arange(count + 1)) or root[kind]["NumberOfCells"][step] != count:
                wrong.append(f"{path.name}: cells")
            if not numpy.array_equal(root[kind]["Connectivity"][first : first + corners * count], numpy.arange(corners * count)):
                wrong.append(f"{path.name}: corners")
            if not numpy.array_equal(root["Points"][first : first + corners * count, : positions.shape[1]], positions):
                wrong.append(f"{path.name}: positions")
            if not numpy.array_equal(root["CellData/contact_pressure"][cell : cell + count], pressures):
                wrong.append(f"{path.name}: pressures")
            first, cell = first + corners * count, cell + count
    return wrong


def pressing(frame):
    """Sum of the pressures on patches over their areas seen along the last axis."""
    surface = frame["surface"]
    positions, pressures = surface["position"][:], surface["contact_pressure"][:]
    if positions.shape[1] == 2:
        line = positions.reshape(-1, 2, 2)
        return numpy.sum(pressures * 2 * math.pi * line[:, :, 0].mean(axis=1) * (line[:, 0, 0] - line[:, 1, 0]))
    quad = positions.reshape(-1, 4, 3)
    return numpy.sum(pressures * 0.5 * numpy.cross(quad[:, 2] - quad[:, 0], quad[:, 3] - quad[:, 1])[:, 2])


@pytest.mark.parametrize("case, ranks", [(CONE, 2), (BERKOVICH, 2)], ids=["axisymmetric", "space"])
def test_surface(expect, case, ranks):
    """The pressures of the surface add up to the load, in a series that readers of VTKHDF take. The load of a step is the mean over
    the finest level's; a frame shows the last of these."""
    result = harness.run({**case, "frames": 2}, ranks=ranks)
    wrong = problems_of_surface(result.folder)
    expect.that("surface.vtkhdf", not wrong, "; ".join(wrong[:5]))
    with h5py.File(sorted(result.folder.glob("points_*.h5"))[-1]) as frame:
        load, before = result.history["load"][-1], result.history["load"][-2]
        expect("load by the patches less the indenter's, over what it grows by in the step", (pressing(frame) - load) / (load - before), near=0.3, tolerance=0.1)


@pytest.mark.parametrize("case, ranks", [(LEVELS, 2), (CONE, 1), (BERKOVICH, 1)], ids=["plane", "axisymmetric", "space"])
def test_series(expect, case, ranks):
    case = {name: value for name, value in case.items() if name != "end_time"}
    result = harness.run({**case, "frames": 2, "max_steps": 4, "checkpoint_interval": 0}, ranks=ranks)
    wrong = problems_of_series(result.folder)
    expect.that("points.vtkhdf", not wrong, "; ".join(wrong[:5]))
    expect("frames", len(list(result.folder.glob("points_*.h5"))), near=3, tolerance=0)
    points, series = ((result.folder / name).stat().st_size for name in ("points_000002.h5", "points.vtkhdf"))
    expect("points.vtkhdf over a frame: it repeats no numbers", series / points, at_most=0.5)


def problems_by_vtk(folder):
    """What VTK's own reader finds in a series that the frames in the folder have not."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader
    frames, reader, wrong = sorted(folder.glob("points_*.h5")), vtkHDFReader(), []
    reader.SetFileName(str(folder / "points.vtkhdf"))
    for step, path in enumerate(frames):
        reader.SetStep(step)
        reader.Update()
        shown = reader.GetOutputDataObject(0)
        arrays = {shown.GetPointData().GetArrayName(k): vtk_to_numpy(shown.GetPointData().GetArray(k))
                  for k in range(shown.GetPointData().GetNumberOfArrays())}
        arrays["position"] = vtk_to_numpy(shown.GetPoints().GetData())
        with h5py.File(path) as frame:
            levels = [frame[name] for name in filled_levels(frame)]
            expected = {field: numpy.concatenate([as_vtk(field, level) for level in levels]) for field in levels[0] if field != "vertex"}
            expected["level"] = numpy.concatenate([numpy.full(len(level["id"]), int(level.name[-1])) for level in levels])
        wrong += [f"{path.name}: {field}" for field in expected.keys() | arrays.keys()
                  if not numpy.array_equal(arrays.get(field), expected.get(field))]
        if shown.GetNumberOfVerts() != len(expected["id"]):
            wrong.append(f"{path.name}: vertices")
    return wrong if reader.GetNumberOfSteps() == len(frames) else wrong + ["time steps"]


def test_vtk_reads_the_series(expect):
    vtk = pytest.importorskip("vtkmodules.vtkCommonCore", reason="VTK is not installed (python3-vtk9)")
    if vtk.vtkVersion.GetVTKMajorVersion() * 100 + vtk.vtkVersion.GetVTKMinorVersion() < 903:
        pytest.skip(f"VTK {vtk.vtkVersion.GetVTKVersion()} knows no PolyData over time in VTKHDF; 9.3 does")
    for case in (LEVELS, CONE, BERKOVICH):
        case = {name: value for name, value in case.items() if name != "end_time"}
        wrong = problems_by_vtk(harness.run({**case, "frames": 2, "max_steps": 4, "checkpoint_interval": 0}, ranks=1).folder)
        expect.that(f"points.vtkhdf by VTK, {case['indenter']}", not wrong, "; ".join(wrong[:5]))


@pytest.fixture(scope="module")
def paraview():
    """A Python that has ParaView, which needs no display here."""
    for python in ("/usr/bin/python3", "pvpython"):
        found = shutil.which(python)
        if found and subprocess.run([found, "-c", "import paraview.simple"], capture_output=True).returncode == 0:
            return found
    return pytest.skip("ParaView is not installed (python3-paraview)")


def of_frame(path):
    """(time, points, sum of the stress) of a frame."""
    with h5py.File(path) as frame:
        levels = [frame[name] for name in filled_levels(frame)]
        return frame.attrs["time"], sum(len(level["id"]) for level in levels), sum(level["stress"][:].sum() for level in levels)


def test_paraview_reads_the_series(expect, paraview):
    """By the reader that it takes by itself and by its older one: a cell for every point, in every frame, at its time."""
    cases = [{**case, "frames": 2, "max_steps": 4, "checkpoint_interval": 0} for case in (LEVELS, FLIGHT, CONE, BERKOVICH)]
    folders = [harness.run({name: value for name, value in case.items() if name != "end_time"}, ranks=2).folder for case in cases]
    script = [paraview, harness.ROOT / "tests" / "paraview_counts.py", *(folder / "points.xdmf" for folder in folders)]
    done = subprocess.run(script, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    for folder, readers in zip(folders, json.loads(done.stdout.splitlines()[-1])):
        frames = [of_frame(path) for path in sorted(folder.glob("points_*.h5"))]
        for name, steps in readers:
            good = [(time, points) for time, points, _ in frames] == [(time, points) for time, points, _, _ in steps]
            expect.that(f"{name}: times and points", good and len(frames) == 3, f"{steps}")
            expect.that(f"{name}: cells", all(cells == points > 0 for _, points, cells, _ in steps), f"{steps}")
            for frame, step in zip(frames, steps):
                expect(f"{name}: sum of the stress over that of the frame", step[3] / frame[2] if frame[2] else 1 + step[3], near=1, tolerance=1e-9)
