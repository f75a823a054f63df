"""PETSc's viewers see the grid, the nodes and the points of each level, on any number of ranks."""
import re
import subprocess

import h5py
import numpy
import pytest

import harness
from ranks import LEVELS

pytestmark = pytest.mark.mpi
STEPS = {**{name: value for name, value in LEVELS.items() if name != "end_time"}, "max_steps": 12, "frames": 1}


def viewers(folder):
    """Options that show each level: the nodes and the points in HDF5, the grid and the number of points as text."""
    options = {}
    for level in range(STEPS["levels"]):
        for kind in ("nodes", "points"):
            options[f"level_{level}_{kind}_view"] = f"hdf5:{folder}/{kind}_{level}.h5"
        options[f"level_{level}_dm_view"] = f"ascii:{folder}/grid_{level}.txt"
    return options


@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_levels(expect, tmp_path, ranks):
    result = harness.run({**STEPS, **viewers(tmp_path), "options_left": None}, ranks=ranks)
    expect.that("-options_left: all are used", "no unused" in result.stdout, result.stdout[-300:])
    with h5py.File(result.folder / "points_000001.h5") as frame:
        masses = [compare_level(expect, tmp_path, frame[f"level_{level}"], level) for level in range(STEPS["levels"])]
    expect("mass on the nodes of all levels over that of the history", sum(masses) / result.history["mass"][-1] - 1, near=0,
           tolerance=1e-12)


def compare_level(expect, folder, level, number):
    """What the viewers wrote of a level against the last frame; the mass on its nodes."""
    with h5py.File(folder / f"nodes_{number}.h5") as file:
        nodes = file[f"level_{number}_nodes"][:].reshape(-1, 7)
    mass, momentum, velocity, force = nodes[:, 0], nodes[:, 1:3], nodes[:, 3:5], nodes[:, 5:7]
    of_points = level["mass"][:] @ level["velocity"][:]
    errors = {"momentum on the nodes": (momentum.sum(axis=0) - of_points, momentum),
              "velocity is momentum over mass": (velocity * mass[:, None] - momentum, momentum),
              "internal forces balance": (force.sum(axis=0), force)}
    for name, (error, of) in errors.items():
        expect(f"level {number}: {name}", numpy.max(numpy.abs(error)) / numpy.abs(of).sum(), at_most=1e-12)
    expect.that(f"level {number}: there are forces", numpy.abs(force).max() > 0)
    with h5py.File(folder / f"points_{number}.h5") as file:  # in the order of the level's ranks, which is not that of all
        orders = [numpy.lexsort(position[:].T) for position in (file[f"level_{number}_position"], level["position"])]
        for field in ("position", "stress", "mass"):
            ours, theirs = file[f"level_{number}_{field}"][:][orders[0]], level[field][:][orders[1]]
            expect.that(f"level {number}: {field} of the points", numpy.array_equal(ours, theirs), f"{ours.shape} {theirs.shape}")
    expect.that(f"level {number}: grid", "type: da" in (folder / f"grid_{number}.txt").read_text())
    return mass.sum()


@pytest.mark.parametrize("points_per_rank", [1, 250])
def test_count_of_points(expect, tmp_path, points_per_rank):
    """As text the viewer shows the number of points on each rank that shares the level, without the room that is kept for more."""
    files = [tmp_path / f"points_{level}.txt" for level in range(STEPS["levels"])]
    viewers = {f"level_{level}_points_view": f"ascii:{file}" for level, file in enumerate(files)}
    levels = harness.run({**STEPS, **viewers, "points_per_rank": points_per_rank}, ranks=3).summary["levels"]
    counts = [[int(count) for count in re.search(r"particles per rank: ([\d ]+)", file.read_text())[1].split()] for file in files]
    expect.that("points of each level", [sum(count) for count in counts] == [level["points"] for level in levels], f"{counts}")
    expect.that("ranks of each level", [len(count) for count in counts] == [level["ranks"] for level in levels], f"{counts}")
    expect.that("all levels on all ranks, or some on fewer", (min(map(len, counts)) < 3) == (points_per_rank > 1))


@pytest.mark.parametrize("option, value, words", [
    ("level_3_dm_view", None, ["unknown or unused"]), ("level_4321_nodes_view", "hdf5:nodes.h5", ["unknown or unused"]),
    ("level_0_nodes_view", "nonsense", ["nonsense"]), ("level_1_points_view", "hdf5:/no/such/folder/points.h5", ["hdf5"]),
    ("log_view", ":/no/such/folder/log.txt", ["-log_view", "cannot write /no/such/folder/log.txt"]),
    ("log_view", "log.txt", ["-log_view log.txt: must be [ascii][:FILE][:FORMAT], as :log.txt for a file"])])
def test_wrong_viewers(tmp_path, option, value, words):
    """Before the first step, in one line."""
    for ranks in (1, 2):
        result = harness.run({**STEPS, option: value}, ranks=ranks, folder=tmp_path / "results", must_succeed=False)
        lines = [line for line in result.stderr.splitlines() if "mlgimp" in line or "ERROR" in line]
        assert result.status != 0 and len(lines) == 1 and all(word.lower() in lines[0].lower() for word in words), result.stderr
        assert not (tmp_path / "results").exists()


def test_help_begins_with_our_options():
    text = subprocess.run(harness.command(["-help"], 1), capture_output=True, text=True, env=harness.environment(1)).stdout
    ours, of_petsc = text.index("-domain_lower"), text.index("Options for all PETSc programs")
    assert text.startswith("mlgimp") and ours < 1500 and ours < of_petsc and text.count("-domain_lower") == 1
