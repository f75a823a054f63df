"""Restarts: from checkpoints of any number of ranks on any number of ranks, and after a kill."""
import shutil
import subprocess
import time
import xml.etree.ElementTree

import harness
from ranks import FLIGHT, LEVELS, SAME, WEDGE, expect_same, largest_difference

CHECKPOINT = 25  # steps; no multiple of 10, so that the steps between looks at the wave speed go on too
CASE = {**WEDGE, "checkpoint_interval": CHECKPOINT, "frames": 8}


def expect_series(report, name, folder, frames):
    """Every frame is there, and points.xdmf lists each once, in order."""
    present = sorted(path.name for path in folder.glob("points_*.h5"))
    wanted = [f"points_{number:06d}.h5" for number in range(1, frames + 1)]
    report.note(f"{name}: frames", present == wanted, "" if present == wanted else f"{present}")
    series = xml.etree.ElementTree.parse(folder / "points.xdmf")
    listed = [item.text.split(":")[0] for item in series.iter("DataItem") if item.text.endswith("/position")]
    report.note(f"{name}: series", listed == wanted, "" if listed == wanted else f"{listed}")


def expect_continued(report, name, case, rank_counts):
    """From checkpoints that 1 and 3 ranks wrote, into new folders, on each number of ranks."""
    for wrote in (1, 3):
        whole = harness.run(case, ranks=wrote)
        steps = whole.history["step"]
        checkpoint = whole.folder / f"checkpoint_{2 * CHECKPOINT:06d}.h5"
        for ranks in rank_counts:
            here = f"{name}from {wrote} on {ranks} ranks"
            result = harness.run({**case, "restart": checkpoint}, ranks=ranks)
            difference, column = largest_difference(result.history, whole.history)
            report.expect(f"{here}: history (worst column {column})", difference, at_most=SAME)
            report.note(f"{here}: rows", list(result.history["step"]) == list(steps[steps > 2 * CHECKPOINT]))
            report.note(f"{here}: points", list(result.frame()["id"]) == list(whole.frame()["id"]))


def test_ranks(report):
    expect_continued(report, "", CASE, (1, 2, 3))


def test_levels(report):
    """Three levels go on, also while points cross borders."""
    for kind, case in (("wedge", LEVELS), ("flight", FLIGHT)):
        expect_continued(report, f"levels, {kind}, ", {**case, "checkpoint_interval": CHECKPOINT}, (1, 2, 3, 4, 8))


def test_same_folder(report):
    """A run goes on in its own folder as if it had not been interrupted."""
    for ranks in (1, 3):
        whole = harness.run(CASE, ranks=ranks)
        folder = whole.folder.with_name(whole.folder.name + "_again")
        shutil.copytree(whole.folder, folder)
        (folder / "checkpoint_000099.h5.part").write_bytes(b"half a file")
        (folder / "points_000006.h5.part").write_bytes(b"half a file")
        again = harness.run({**CASE, "restart": folder / f"checkpoint_{CHECKPOINT:06d}.h5"}, ranks=ranks, folder=folder)
        name = f"same folder, {ranks} ranks"
        expect_same(report, name, again, whole)
        expect_series(report, name, folder, CASE["frames"])
        report.note(f"{name}: every row once", list(again.history["step"]) == list(whole.history["step"]))


def test_fewer_steps_than_frames(report):
    """The series keeps its frames where some numbers are skipped."""
    case = {**CASE, "end_time": None, "max_steps": 8, "frames": 20, "checkpoint_interval": 4}
    case.pop("end_time")
    whole = harness.run(case)
    before = (whole.folder / "points.xdmf").read_text()
    harness.run({**case, "restart": whole.folder / "checkpoint_000004.h5"}, folder=whole.folder)
    report.note("frames with gaps: series", (whole.folder / "points.xdmf").read_text() == before)


def test_kill(report):
    """Killed in the middle, a run goes on from its last complete checkpoint to the same end."""
    case = {**CASE, "time_step": 4e-12, "checkpoint_interval": 10}
    whole = harness.run(case)
    folder = whole.folder.with_name(whole.folder.name + "_killed")
    arguments = harness.to_arguments({"output_dir": folder, "monitor": "false", **case})
    process = subprocess.Popen(harness.command(arguments, 1), env=harness.ENVIRONMENT, cwd=harness.ROOT)
    limit = time.time() + 60
    while process.poll() is None and not (folder / "checkpoint_000100.h5").exists() and time.time() < limit:
        time.sleep(0.002)
    process.kill()
    report.note("kill: the run was in the middle", process.wait() < 0)
    last = sorted(folder.glob("checkpoint_*.h5"))[-1]
    again = harness.run({**case, "restart": last}, folder=folder)
    expect_same(report, f"kill: from {last.name}", again, whole)
    expect_series(report, "kill", folder, CASE["frames"])
