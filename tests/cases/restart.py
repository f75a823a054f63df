"""Restarts: to the last bit on as many ranks as wrote the checkpoint, to round-off on others. Kills are in faults.py."""
import shutil
import xml.etree.ElementTree

import h5py
import pytest

import harness
from limits import PRESS
from ranks import BALL, BERKOVICH, COLLISION, CONE, FLIGHT, LEVELS, SAME, WEDGE, expect_same, largest_difference
from series import problems_of_series

pytestmark = pytest.mark.mpi
CHECKPOINT = 25  # steps; no multiple of 10, so that the steps between looks at the wave speed go on too
CASE = {**WEDGE, "checkpoint_interval": CHECKPOINT, "frames": 8}


def expect_series(expect, name, folder, frames):
    """Every frame is there, points.xdmf lists each once, in order, and points.vtkhdf shows them."""
    present = sorted(path.name for path in folder.glob("points_*.h5"))
    wanted = [f"points_{number:06d}.h5" for number in range(frames + 1)]
    expect.that(f"{name}: frames", present == wanted, "" if present == wanted else f"{present}")
    series = xml.etree.ElementTree.parse(folder / "points.xdmf")
    listed = [item.text.split(":")[0] for item in series.iter("DataItem") if item.text.endswith("/position")]
    expect.that(f"{name}: series", listed == wanted, "" if listed == wanted else f"{listed}")
    wrong = problems_of_series(folder)
    expect.that(f"{name}: points.vtkhdf", not wrong, "; ".join(wrong[:5]))


def rows_after(folder, step):
    """The lines of history.csv after a step."""
    return [line for line in (folder / "history.csv").read_text().splitlines()[1:] if int(line.split(",")[0]) > step]


def expect_continued(expect, name, case, rank_counts, writers=(1, 3)):
    """From checkpoints that each number of writers wrote, into new folders, on each number of ranks."""
    for wrote in writers:
        whole = harness.run(case, ranks=wrote)
        steps = whole.history["step"]
        checkpoint = whole.folder / f"checkpoint_{2 * CHECKPOINT:06d}.h5"
        for ranks in rank_counts:
            here = f"{name}from {wrote} on {ranks} ranks"
            result = harness.run({**case, "restart": checkpoint}, ranks=ranks)
            difference, column = largest_difference(result.history, whole.history)
            expect(f"{here}: history (worst column {column})", difference, at_most=SAME)
            expect.that(f"{here}: rows", list(result.history["step"]) == list(steps[steps > 2 * CHECKPOINT]))
            if ranks == wrote:
                expect.that(f"{here}: to the last bit", rows_after(whole.folder, 2 * CHECKPOINT) == rows_after(result.folder, 0))
            expect.that(f"{here}: points", list(result.frame()["id"]) == list(whole.frame()["id"]))


def test_ranks(expect):
    expect_continued(expect, "", CASE, (1, 2, 3))


def test_levels(expect):
    """Three levels go on, also while points cross borders."""
    for kind, case, ranks in (("wedge", LEVELS, (1, 3)), ("flight", FLIGHT, (1, 8))):
        expect_continued(expect, f"levels, {kind}, ", {**case, "checkpoint_interval": CHECKPOINT}, ranks)


@pytest.mark.parametrize("name, case", {"cone": CONE, "berkovich": BERKOVICH, "ball": BALL}.items())
def test_geometries(expect, name, case):
    """In axisymmetry and space."""
    expect_continued(expect, f"{name}, ", {**case, "checkpoint_interval": CHECKPOINT}, (1, 3), writers=(3,))


METHODS = {"points": {**LEVELS, "level_coupling": "points"},
           "points by place": {**LEVELS, "level_coupling": "points", "ghost_ownership": "place"},
           "point pressure": {**WEDGE, "contact": "point_pressure"}, "multimesh": {**WEDGE, "contact": "multimesh"},
           "usf": {**WEDGE, "stress_update": "usf"}, "xpic": {**WEDGE, "xpic_fraction": 0.02, "damping": 1e8},
           "merging": {**FLIGHT, "merge_siblings": "true"}, "collision": COLLISION}


@pytest.mark.parametrize("name", METHODS)
def test_methods(name):
    """To the last bit with what other methods carry from step to step: copies of points, momentum, contact pressures."""
    case = {**METHODS[name], "checkpoint_interval": CHECKPOINT, "frames": 0, "max_steps": CHECKPOINT + 20}
    whole = harness.run(case, ranks=2)
    again = harness.run({**case, "restart": whole.folder / f"checkpoint_{CHECKPOINT:06d}.h5", "checkpoint_interval": 0}, ranks=2)
    assert rows_after(whole.folder, CHECKPOINT) == rows_after(again.folder, 0)


def test_chosen_values_belong_to_the_case():
    """What the program chooses where nothing is given is what the checkpoint says: typed it is the same case, and 1 or 0 is not."""
    slow = {**CASE, "indenter_velocities": None, "indenter_times": None, "end_time": None, "quasi_static": "true", "indenter_depths": "50e-9"}
    for case, name, other in ((slow, "damping", 0), (slow, "xpic_fraction", 0.5)):
        case = {option: value for option, value in {**case, "frames": 0, "max_steps": 2 * CHECKPOINT}.items() if value is not None}
        whole = harness.run(case)
        again = {**case, "restart": whole.folder / f"checkpoint_{CHECKPOINT:06d}.h5"}
        chosen = whole.summary["options"][f"-{name}"]
        assert rows_after(whole.folder, CHECKPOINT) == rows_after(harness.run({**again, name: chosen}).folder, 0)
        refusal = harness.run({**again, name: other}, must_succeed=False)
        assert refusal.status == 1 and f"the checkpoint has '-{name} {chosen}'" in refusal.stderr, refusal.stderr


def test_other_steps(expect):
    """Another end or step of time is taken up at once, also on as many ranks."""
    whole = harness.run({**CASE, "frames": 0})
    checkpoint, times = whole.folder / f"checkpoint_{CHECKPOINT:06d}.h5", whole.history["time"]
    half = harness.run({**CASE, "frames": 0, "restart": checkpoint, "cfl": 0.2}).history
    expect("restart with half the step: length of the first", (half["time"][0] - times[CHECKPOINT]) / (times[CHECKPOINT + 1] - times[CHECKPOINT]), near=0.5, tolerance=0.01)
    longer = harness.run({**CASE, "frames": 0, "restart": checkpoint, "end_time": 2e-9}).history
    expect("restart with another end", longer["time"][-1], near=2e-9, tolerance=1e-21)


def test_same_folder(expect):
    """A run goes on in its own folder as if it had not been interrupted."""
    for ranks in (1, 3):
        whole = harness.run(CASE, ranks=ranks)
        folder = whole.folder.with_name(whole.folder.name + "_again")
        shutil.copytree(whole.folder, folder)
        (folder / "checkpoint_000099.h5.part").write_bytes(b"half a file")
        (folder / "points_000006.h5.part").write_bytes(b"half a file")
        again = harness.run({**CASE, "restart": folder / f"checkpoint_{CHECKPOINT:06d}.h5"}, ranks=ranks, folder=folder)
        name = f"same folder, {ranks} ranks"
        expect_same(expect, name, again, whole)
        expect_series(expect, name, folder, CASE["frames"])
        expect.that(f"{name}: every row once", list(again.history["step"]) == list(whole.history["step"]))


@pytest.mark.parametrize("other, times", [({"frames": 4}, (0.75, 1)), ({"frames": 16}, (0.5625, 0.625, 0.6875, 0.75, 0.8125, 0.875, 0.9375, 1)),
                                          ({"end_time": 2}, (0.75, 1, 1.25, 1.5, 1.75, 2))], ids=["fewer", "more", "later end"])
def test_frames_go_on(expect, other, times):
    """With another number of frames, or another end, those that follow have the next numbers, at the times of the case as it is now."""
    case = {**CASE, "checkpoint_interval": 1}
    whole = harness.run(case)
    end, step = whole.history["time"][-1], whole.history["time"][1]
    middle = int(whole.history["step"][whole.history["time"] >= 0.5 * end][0])
    if "end_time" in other:
        other = {"end_time": other["end_time"] * end}
    harness.run({**case, **other, "restart": whole.folder / f"checkpoint_{middle:06d}.h5"}, folder=whole.folder)
    expect_series(expect, "frames of both", whole.folder, 4 + len(times))
    for number, time in enumerate(times, start=5):
        with h5py.File(whole.folder / f"points_{number:06d}.h5") as frame:
            expect(f"time of frame {number}, steps", (frame.attrs["time"] - time * end) / step, near=0, tolerance=1)


@pytest.mark.parametrize("damping, warned", [(40, False), (100, True)])
def test_warnings(expect, damping, warned):
    """A run that goes on says at its end what the whole run says: it neither forgets nor begins to count anew, nor tells
    what is known at the start twice."""
    case = {**PRESS, "indenter": "cylinder", "indenter_radius": 5, "indenter_max_depth": 0.2, "indenter_unload_velocity": 50,
            "checkpoint_interval": 4, "cell_size": 0.5, "damping": damping, "rate_scale": 2}
    whole = harness.run(case)
    said = whole.summary["warnings"]
    expect.that(f"damping {damping}: warnings of the whole run", [line.split()[0] for line in said] == ["-rate_scale", "-indenter:"] + ["-damping"] * warned, f"{said}")
    for checkpoint in sorted(whole.folder.glob("checkpoint_*.h5")):
        later = harness.run({**case, "restart": checkpoint}).summary["warnings"]
        expect.that(f"damping {damping}: after {checkpoint.stem}", later == said, f"{later}")


def test_fewer_steps_than_frames(expect):
    """The series keeps its frames where some numbers are skipped."""
    case = {**CASE, "end_time": None, "max_steps": 8, "frames": 20, "checkpoint_interval": 4}
    case.pop("end_time")
    whole = harness.run(case)
    before = (whole.folder / "points.xdmf").read_text()
    harness.run({**case, "restart": whole.folder / "checkpoint_000004.h5"}, folder=whole.folder)
    expect.that("frames with gaps: series", (whole.folder / "points.xdmf").read_text() == before)
