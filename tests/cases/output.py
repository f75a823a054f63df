"""What a run leaves behind: its files are complete, agree with each other and with the budgets of the run."""
import re
import subprocess
import xml.etree.ElementTree

import h5py
import numpy
import pytest

import harness
import mlgimp
from ranks import COLLISION, WEDGE

pytestmark = pytest.mark.mpi

COLUMNS = ("step,time,depth,load,contact_points,contact_half_width,kinetic_energy,strain_energy,dissipated_energy,"
           "external_work,indenter_work,momentum_x,momentum_y,support_impulse_x,support_impulse_y,mass,points").split(",")

# Dataset: numbers a point has, type. The names of the components are in the manual.
DATASETS = {"id": (1, "int64"), "position": (2, "float64"), "velocity": (2, "float64"), "stress": (4, "float64"),
            "deformation_gradient": (4, "float64"), "volume": (1, "float64"), "mass": (1, "float64"),
            "displacement": (2, "float64"), "half_size": (2, "float64"), "body": (1, "int32"), "faces": (1, "int32"),
            "contact_pressure": (1, "float64"), "pressure": (1, "float64"), "von_mises_stress": (1, "float64")}

SUMMARY = {"status", "case", "ranks", "levels", "steps", "simulated_time", "wall_seconds", "seconds_per_point_step",
           "contact_share", "transfer_share", "halo_share", "mass_error", "points_created", "points_lost", "options", "versions"}
SUMMARY_LEVEL = {"points", "cells", "steps", "time_step"}
SUMMARY_VERSIONS = {"mlgimp", "PETSc", "MPI", "HDF5"}

EVENTS = ("P2G", "Halo", "GridUpdate", "Contact", "G2PStress", "Migrate", "Sort", "Output")

# Option: words of its line in -help: unit and default.
OPTIONS = {
    "geometry": ["plane_strain"], "thickness": ["[m]", "1"], "domain_lower": ["[m]", "required"],
    "domain_upper": ["[m]", "required"], "cell_size": ["[m]", "required"], "levels": ["1"], "refinement_ratio": ["2"],
    "boundary_x_lower": ["free"], "boundary_x_upper": ["free"], "boundary_y_lower": ["free"], "boundary_y_upper": ["free"],
    "bodies": ["required"], "NAME_shape": ["box"], "NAME_lower": ["[m]", "required"], "NAME_upper": ["[m]", "required"],
    "NAME_center": ["[m]", "required"], "NAME_radius": ["[m]", "required"], "NAME_vertices": ["[m]", "required"],
    "NAME_material": [], "NAME_velocity": ["[m/s]", "0,0"], "NAME_points_per_cell": ["2"], "materials": ["required"],
    "NAME_model": ["neo_hookean"], "NAME_youngs_modulus": ["[Pa]", "required"], "NAME_poissons_ratio": ["required"],
    "NAME_density": ["[kg/m3]", "required"], "NAME_yield_stress": ["[Pa]", "required"],
    "NAME_hardening_modulus": ["[Pa]", "required"], "loads": [], "NAME_body": [], "NAME_side": ["x_lower"],
    "NAME_span": ["[m]"], "NAME_times": ["[s]", "required"], "NAME_pressures": ["[Pa]", "required"],
    "gravity": ["[m/s2]", "0,0"], "indenter": ["none"], "indenter_tip": ["[m]", "required"],
    "indenter_half_angle": ["[degrees]", "required"], "indenter_radius": ["[m]", "required"],
    "indenter_width": ["[m]", "required"], "indenter_vertices": ["[m]", "required"], "indenter_tip_radius": ["[m]", "0"],
    "indenter_times": ["[s]", "required"], "indenter_velocities": ["[m/s]", "required"],
    "indenter_max_depth": ["[m]", "none"], "indenter_unload_velocity": ["[m/s]"], "contact": ["pressure"],
    "contact_ksp_type": ["cg"], "contact_pc_type": ["jacobi"], "contact_ksp_rtol": ["1e-10"], "contact_monitor": ["false"],
    "shape_function": ["cpgimp"], "stress_update": ["musl"], "short_wave_viscosity": [], "xpic_fraction": ["0"],
    "xpic_order": ["2"], "damping": ["[1/s]", "0"], "sort_interval": ["50"], "rebalance_threshold": ["1.1"],
    "end_time": ["[s]", "none"], "max_steps": ["0"], "time_step": ["[s]", "0"], "cfl": ["0.4"], "output_dir": ["output/"],
    "overwrite": ["false"], "history_interval": ["1"], "frames": ["20"], "checkpoint_interval": ["0"], "restart": [],
    "frame_precision": ["double"], "monitor": ["false"],
}


def test_history(expect):
    with_frames = {**WEDGE}
    del with_frames["frames"]
    for ranks in (1, 2):
        result = harness.run(with_frames, ranks=ranks)
        header = (result.folder / "history.csv").read_text().split("\n", 1)[0].split(",")
        expect.that(f"history.csv, {ranks} ranks: columns", header[: len(COLUMNS)] == COLUMNS)
        steps = result.history["step"]
        expect.that(f"history.csv, {ranks} ranks: a row a step", numpy.array_equal(steps, numpy.arange(len(steps))))
        expect(f"history.csv, {ranks} ranks: ends at -end_time", result.history["time"][-1] / 1.6e-9 - 1, near=0, tolerance=1e-12)
        frames = sorted(result.folder.glob("points_*.h5"))
        expect.that(f"20 frames by default, {ranks} ranks", [f.name for f in frames] == [f"points_{k:06d}.h5" for k in range(21)])
        with h5py.File(frames[-1]) as file:
            expect.that(f"the last frame is at the end, {ranks} ranks",
                        file.attrs["step"] == steps[-1] and file.attrs["time"] == result.history["time"][-1])
        check_frame(expect, result, frames[3], f"frame, {ranks} ranks")
        check_displacement(expect, result, f"displacement, {ranks} ranks")
        check_series(expect, result, f"points.xdmf, {ranks} ranks")
        check_summary(expect, result, ranks)
        expect.that(f"nothing unfinished, {ranks} ranks", not list(result.folder.glob("*.part")))


def check_frame(expect, result, path, name):
    with h5py.File(path) as file:
        points = int(result.history["points"][-1])
        level = file["level_0"]
        expect.that(f"{name}: datasets", set(level) == {*DATASETS, "vertex"})
        for dataset, (components, kind) in DATASETS.items():
            shape = (points,) if components == 1 else (points, components)
            expect.that(f"{name}: {dataset}", level[dataset].shape == shape and level[dataset].dtype == kind,
                        f"{level[dataset].shape} {level[dataset].dtype}")
        expect.that(f"{name}: ids are unique", len(set(level["id"][:])) == points)
        F = level["deformation_gradient"][:]
        volume = level["mass"][:] / 2700 * (F[:, 0] * F[:, 3] - F[:, 1] * F[:, 2])
        expect(f"{name}: volume follows from F", numpy.max(numpy.abs(level["volume"][:] / volume - 1)), at_most=1e-14)
        row = numpy.searchsorted(result.history["step"], file.attrs["step"])
        momentum = numpy.sum(level["mass"][:] * level["velocity"][:, 1])
        expect(f"{name}: momentum is that of the history", momentum / result.history["momentum_y"][row] - 1, near=0,
               tolerance=1e-12)


def check_displacement(expect, result, name):
    """Frame 0 is the undeformed body, from which the points of the others are displaced."""
    start, end = result.frame(0), result.frame(20)
    expect.that(f"{name}: none at the start", not start["displacement"].any() and not start["stress"].any())
    moved = end["position"] - start["position"]
    expect(f"{name}: way since frame 0", numpy.max(numpy.abs(end["displacement"] - moved)), at_most=0)
    expect.that(f"{name}: there is some", numpy.max(numpy.abs(moved)) > 1e-8)


def check_series(expect, result, name):
    """Well-formed, a time for each frame, and every dataset there with the dimensions and type that are named."""
    series = xml.etree.ElementTree.parse(result.folder / "points.xdmf").getroot()
    frames = sorted(result.folder.glob("points_*.h5"))
    times = [float(time.get("Value")) for time in series.iter("Time")]
    written = []
    for path in frames:
        with h5py.File(path) as file:
            written.append(float(file.attrs["time"]))
    expect.that(f"{name}: times", times == written)
    wrong = []
    for item in series.iter("DataItem"):
        place, _, dataset = item.text.strip().partition(":")
        with h5py.File(result.folder / place) as file:
            shape = tuple(int(n) for n in item.get("Dimensions").split())
            kind = {"Float": "f", "Int": "i"}[item.get("NumberType")] + item.get("Precision")
            if dataset not in file or file[dataset].shape != shape or file[dataset].dtype != numpy.dtype(kind):
                wrong.append(item.text)
    expect.that(f"{name}: datasets", not wrong and len(list(series.iter("DataItem"))) == len(frames) * (len(DATASETS) + 1), ", ".join(wrong))
    items = [topology.find("DataItem") for topology in series.iter("Topology")]
    expect.that(f"{name}: a list of vertices for each level", len(items) == len(frames) and all(vertices_of(result.folder, item) for item in items))


def vertices_of(folder, item):
    """Whether a DataItem is 0, 1, 2, ..., as many as there are points."""
    place, _, dataset = item.text.partition(":")
    with h5py.File(folder / place) as file:
        points = len(file[dataset.replace("/vertex", "")]["id"])
        return numpy.array_equal(file[dataset][:], numpy.arange(points))


def check_summary(expect, result, ranks):
    summary, name = result.summary, f"summary.json, {ranks} ranks"
    absent = (SUMMARY - set(summary)) | (SUMMARY_VERSIONS - set(summary["versions"]))
    absent |= {key for level in summary["levels"] for key in SUMMARY_LEVEL - set(level)}
    expect.that(f"{name}: keys", not absent, ", ".join(sorted(absent)))
    expect.that(f"{name}: values", summary["status"] == "completed" and summary["ranks"] == ranks
                and summary["steps"] == result.history["step"][-1] and summary["points_lost"] == 0
                and summary["levels"][0]["points"] == result.history["points"][-1]
                and summary["options"]["-geometry"] == "plane_strain" and float(summary["options"]["-cell_size"]) == 250e-9)
    shares = [summary[key] for key in ("contact_share", "transfer_share", "halo_share")]
    expect.that(f"{name}: shares", all(0 <= share <= 1 for share in shares) and sum(shares) <= 1, f"{shares}")


def expect_budgets(expect, name, history, energy_tolerance):
    """Momentum to round-off, energy to what explicit time stepping leaves."""
    for axis in "xy":
        parts = [history[f"{kind}_impulse_{axis}"] for kind in ("contact", "support", "load", "gravity", "damping")]
        momentum = history[f"momentum_{axis}"]
        error = numpy.max(numpy.abs(momentum - momentum[0] - sum(parts)))
        largest = max(numpy.max(numpy.abs(part)) for part in parts + [momentum])
        expect(f"{name}: momentum budget, {axis}", error / largest, at_most=1e-9)
    energy = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    supplied = energy[0] + history["external_work"] + history["indenter_work"]
    expect(f"{name}: energy budget", numpy.max(numpy.abs(energy - supplied)) / numpy.max(supplied), at_most=energy_tolerance)


def test_budgets(expect):
    wedge = {**WEDGE, "frames": 0}
    expect_budgets(expect, "wedge", harness.run(wedge).history, 0.01)
    expect_budgets(expect, "wedge, 2 ranks", harness.run(wedge, ranks=2).history, 0.01)
    expect_budgets(expect, "wedge with damping and a history every 7 steps",
                 harness.run({**wedge, "damping": 2e8, "history_interval": 7}).history, 0.01)
    expect_budgets(expect, "wedge held and fixed", harness.run({**wedge, "boundary_y_lower": "fixed"}).history, 0.01)
    collision = {**COLLISION, "frames": 0, "checkpoint_interval": 0}
    collision["soft_volume_average"] = "false"  # with it see accounting.py
    expect_budgets(expect, "collision", harness.run(collision).history, 0.01)
    expect_budgets(expect, "collision, 3 ranks", harness.run(collision, ranks=3).history, 0.01)


def test_noise_on_a_finer_level(expect):
    """A block all of whose points are on level 1 has as much noise of velocities as on one level with such cells."""
    block = {"domain_lower": "0,0", "domain_upper": "16,16", "boundary_y_lower": "fixed", "materials": "m", "m_youngs_modulus": 1e5,
             "m_poissons_ratio": 0.3, "m_density": 1000, "bodies": "b", "b_lower": "5,0", "b_upper": "11,6", "b_velocity": "0,-0.5",
             "time_step": 0.02, "max_steps": 40, "frames": 0}
    alone = harness.run({**block, "cell_size": 0.5, "time_step": 0.01, "max_steps": 80}).history["noise_energy"]
    finer = harness.run({**block, "cell_size": 1, "levels": 2, "level_1_lower": "2,0", "level_1_upper": "14,10"}).history["noise_energy"]
    expect("noise after the same time, of that on one level", finer[-1] / alone[-1], near=1, tolerance=0.1)


def table_of(text, event):
    """(times called, flops) of an event in the stage 'level 0' of -log_view."""
    stage = re.split(r"^--- Event Stage \d+: ", text, flags=re.MULTILINE)
    level = [part for part in stage if part.startswith("level 0")]
    for line in level[0].splitlines() if level else []:
        if line.startswith(event[:12] + " "):
            words = line.split()
            return float(words[1]), float(words[5])
    return None


def test_log_view(expect):
    log = harness.run({**WEDGE, "log_view": None, "sort_interval": 10}, ranks=2).stdout
    outer = re.search(r"^Output +(\d+) ", log, re.MULTILINE)
    expect.that("-log_view: Output", outer is not None)
    for event in EVENTS[:-1]:
        row = table_of(log, event)
        expect.that(f"-log_view: {event} in level 0", row is not None and row[0] > 0, str(row))
        if event in ("P2G", "GridUpdate", "G2PStress"):
            expect.that(f"-log_view: flops of {event}", row is not None and row[1] > 0)


def datasets_of(folder):
    """Dataset by file and name of all frames of a folder, of points and of the surface."""
    found = {}
    for path in sorted(folder.glob("points_*.h5")):
        with h5py.File(path, "r") as file:
            for group in file:
                found.update({f"{path.name}/{group}/{name}": data[()] for name, data in file[group].items()})
    return found


def test_single_precision(expect, tmp_path):
    """Frames with numbers of four bytes: the same to their rounding, half as large, and told to the readers of both series."""
    wedge = {**WEDGE, "frames": 4, "checkpoint_interval": 10}
    double, single = harness.run(wedge), harness.run({**wedge, "frame_precision": "single"}, ranks=2)
    exact, rounded = datasets_of(double.folder), datasets_of(single.folder)
    expect.that("the same datasets", exact.keys() == rounded.keys(), f"{len(exact)}, {len(rounded)}")
    kinds = {data.dtype.name for name, data in rounded.items() if not name.endswith("/position")}
    expect.that("of eight bytes are ids and positions alone", kinds == {"float32", "int32", "int64"}, str(kinds))
    for group in ("level_0", "surface"):
        last = {name.rsplit("/", 1)[1]: data for name, data in rounded.items() if name.startswith("points_000000.h5/" + group)}
        start = {name.rsplit("/", 1)[1]: data for name, data in exact.items() if name.startswith("points_000000.h5/" + group)}
        worst = max(numpy.abs(numpy.sort(last[name], 0) - numpy.sort(start[name], 0)).max() / (numpy.abs(start[name]).max() or 1)
                    for name in last if last[name].dtype == numpy.float32)
        expect(f"{group}: what four bytes round away", float(worst), at_most=2 ** -24)
        expect.that(f"{group}: positions are whole", bool((numpy.sort(last["position"], 0) == numpy.sort(start["position"], 0)).all()))
    sizes = [sum(path.stat().st_size for path in folder.glob("points_*.h5")) for folder in (double.folder, single.folder)]
    expect("size of the files", sizes[1] / sizes[0], at_most=0.65)
    with h5py.File(single.folder / "points.vtkhdf", "r") as file:
        expect.that("VTKHDF", file["VTKHDF/Points"].dtype == numpy.float64 and file["VTKHDF/PointData/stress"].dtype == numpy.float32)
        shown = file["VTKHDF/Points"][:]
    expect.that("VTKHDF shows the points", bool(numpy.isin(rounded["points_000000.h5/level_0/position"][:, 0], shown[:, 0]).all()))
    xdmf = xml.etree.ElementTree.parse(single.folder / "points.xdmf")
    precisions = {(item.text.endswith("/position"), item.get("Precision")) for item in xdmf.iter("DataItem") if item.get("NumberType") == "Float"}
    expect.that("XDMF", precisions == {(True, "8"), (False, "4")}, str(precisions))
    expect.that("Python has doubles", mlgimp.read(single.folder).frame(2)["stress"].dtype == numpy.float64)


def test_precision_of_a_restart(tmp_path):
    """A run goes on with frames of the same precision alone in the same folder."""
    wedge = {**WEDGE, "frames": 4, "checkpoint_interval": 10, "frame_precision": "single"}
    harness.run({**wedge, "max_steps": 20}, folder=tmp_path)
    on = {**wedge, "restart": tmp_path / "checkpoint_000020.h5", "max_steps": 30}
    for ranks in (1, 2):
        refused = harness.run({**on, "frame_precision": "double"}, folder=tmp_path, ranks=ranks, must_succeed=False)
        assert refused.status == 1 and "-frame_precision double: " in refused.stderr and "other kind" in refused.stderr, refused.stderr
    harness.run(on, folder=tmp_path)


SHARES = ("contact_share", "halo_share", "transfer_share", "coupling_share")


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("option, value, words, kept", [
    ("log_view", ":FILE", "P2G", True), ("log_view", ":FILE:ascii_csv", "P2G", True), ("log_view", ":FILE:ascii_info_detail", "P2G", True),
    ("log_view", ":FILE:ascii_flamegraph", "P2G", False), ("log_view", ":FILE:ascii_xml", "<name>P2G</name>", False),
    ("log_trace", "FILE", "Event begin: P2G", False)], ids=["table", "csv", "detail", "flamegraph", "xml", "trace"])
def test_logs(expect, tmp_path, option, value, words, kept, ranks):
    """Every log of PETSc is written, and shares of the time are there where PETSc keeps the times of single events, else null."""
    result = harness.run({**WEDGE, option: value.replace("FILE", str(tmp_path / "log"))}, ranks=ranks)
    text = "".join(path.read_text() for path in tmp_path.glob("log*"))
    expect.that("the log", words in text, text[:300])
    shares = [result.summary[share] for share in SHARES]
    good = 0 < shares[0] < 1 and sum(shares) <= 1 if kept else shares == [None] * 4
    expect.that("shares in summary.json", good, f"{shares}")


def test_memory(expect):
    for ranks in (1, 3):
        for case, name in ((WEDGE, "wedge"), (COLLISION, "collision")):
            result = harness.run({**case, "malloc_dump": None, "end_time": 3e-10}, ranks=ranks)
            said = [line for line in harness.lines_of(result.stderr) if not line.startswith("mlgimp: warning: ")]
            expect.that(f"-malloc_dump, {name}, {ranks} ranks", not result.stdout and not said, (result.stdout + result.stderr)[:600])


@pytest.mark.parametrize("hardening", ["linear", "table", "johnson_cook"])
def test_help_with_a_law(hardening):
    """Help comes before the law's constants: no list of a table is there yet."""
    done = harness.run({"help": None, "materials": "m", "m_model": "j2", "m_hardening": hardening}, must_succeed=False)
    assert done.status == 0 and "-m_flow_stresses" in done.stdout and not done.stderr


def test_help(expect):
    for word, ranks in (("--help", 2), ("-h", 1), ("-help", 1)):
        done = subprocess.run(harness.command([word], ranks), capture_output=True, text=True, env=harness.ENVIRONMENT)
        expect.that(f"{word}: status, {ranks} ranks", done.returncode == 0 and not done.stderr, done.stderr[:200])
    absent = []
    for option, expected in OPTIONS.items():
        lines = [line for line in done.stdout.splitlines() if re.match(rf"\s*-{option}\b", line)]
        if not lines or any(word not in lines[0] for word in expected):
            absent.append(f"-{option}: {lines[:1]}")
    expect.that("-help: every option with unit and default", not absent, "; ".join(absent))
