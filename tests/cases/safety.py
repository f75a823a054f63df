"""Output folders: nothing of the user's is lost."""
import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

import harness

BLOCK = {
    "domain_lower": "0,0", "domain_upper": "12,12", "cell_size": "1", "max_steps": "40", "frames": "0",
    "materials": "al", "al_youngs_modulus": "1e9", "al_poissons_ratio": "0.3", "al_density": "1000",
    "bodies": "block", "block_lower": "0,0", "block_upper": "8,8", "monitor": "false",
}
FORKS = {**BLOCK, "max_steps": "100000", "cell_size": "0.25"}  # runs long enough to be met


def start(options, folder, ranks=1, **more):
    """The process of a run, with its own environment."""
    words = harness.to_arguments({**options, "output_dir": folder})
    return subprocess.Popen(harness.command(words, ranks), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            env=harness.environment(ranks), cwd=harness.ROOT, **more)


def ended(options, folder, ranks=1, **more):
    """(exit status, lines on standard error) of a run."""
    process = start(options, folder, ranks, **more)
    errors = process.communicate(timeout=60)[1]
    return process.returncode, harness.lines_of(errors)


def refused(options, folder, *words, ranks=1, **more):
    status, lines = ended(options, folder, ranks, **more)
    assert status > 0, lines
    assert len(lines) == 1 and lines[0].startswith("mlgimp: error: "), lines
    for word in words:
        assert word in lines[0], lines
    return lines[0]


def succeeds(options, folder, ranks=1, **more):
    status, lines = ended(options, folder, ranks, **more)
    assert status == 0 and not lines, lines


def wait_for(condition, seconds=20):
    limit = time.time() + seconds
    while not condition() and time.time() < limit:
        time.sleep(0.01)
    assert condition()


def names(folder):
    return {path.name for path in folder.iterdir()}

USERS = {"points.csv", "points_of_interest.txt", "history.csv.bak", "summary.json.old", "checkpoint_000040.h5.keep", "points_30deg.png",
         "points_0001.h5", "points_0000001.h5", "checkpoint_1.h5", "history.csv.part.txt", "points_000001.h5.old"}
OWN = {"history.csv", "summary.json.part", "points.xdmf.part", "points.vtkhdf", "points_000009.h5", "points_1234567.h5.part", "checkpoint_000070.h5"}


def test_users_files_survive_overwrite(tmp_path):
    for name in USERS | OWN:
        (tmp_path / name).write_text("mine")
    succeeds({**BLOCK, "max_steps": "2", "overwrite": None}, tmp_path)
    assert names(tmp_path) == USERS | {"history.csv", "summary.json"}


def test_users_files_survive_a_restart(tmp_path):
    case = {**BLOCK, "checkpoint_interval": "10"}
    succeeds(case, tmp_path)
    for name in USERS:
        (tmp_path / name).write_text("mine")
    succeeds({**case, "restart": tmp_path / "checkpoint_000020.h5", "checkpoint_interval": "0"}, tmp_path)
    assert names(tmp_path) == USERS | {"history.csv", "summary.json", "checkpoint_000010.h5", "checkpoint_000020.h5"}


def test_users_files_are_no_results(tmp_path):
    for name in USERS:
        (tmp_path / name).write_text("mine")
    succeeds({**BLOCK, "max_steps": "2"}, tmp_path)
    assert USERS < names(tmp_path)


def test_each_result_alone_is_refused(tmp_path):
    for name in OWN:
        folder = tmp_path / name
        folder.mkdir()
        (folder / name).write_text("of another run")
        refused(BLOCK, folder, "-output_dir", "-overwrite")
        assert (folder / name).read_text() == "of another run"


def test_folders_with_the_names_of_results_stay(tmp_path):
    for name in ("points_000001.h5", "history.csv"):
        (tmp_path / name).mkdir()
        refused({**BLOCK, "overwrite": None}, tmp_path, "must hold no folder", name)
        assert (tmp_path / name).is_dir()
        (tmp_path / name).rmdir()


def test_the_checkpoint_of_a_restart_stays(tmp_path):
    """Whatever link or name leads to it."""
    case = {**BLOCK, "checkpoint_interval": "10"}
    whole = tmp_path / "whole"
    succeeds(case, whole)
    link, hard, renamed = tmp_path / "link.h5", tmp_path / "hard.h5", "checkpoint_000090.h5"
    for way in ("symbolic", "hard", "renamed"):
        folder = tmp_path / way
        shutil.copytree(whole, folder)
        original = folder / "checkpoint_000020.h5"
        if way == "symbolic":
            link.symlink_to(original)
        elif way == "hard":
            os.link(original, hard)
        else:
            original = original.rename(folder / renamed)
        given = {"symbolic": link, "hard": hard, "renamed": original}[way]
        succeeds({**case, "restart": given, "overwrite": None}, folder)
        assert original.exists()
        assert (folder / "history.csv").read_text() == (whole / "history.csv").read_text()


def test_results_removed_during_the_run(tmp_path):
    for what in ("file", "folder", "replaced"):
        folder = tmp_path / what
        process = start(FORKS, folder)
        wait_for(lambda: (folder / "history.csv").exists())
        if what == "folder":
            shutil.rmtree(folder)
        else:
            (folder / "history.csv").unlink()
        if what == "replaced":
            (folder / "history.csv").write_text("step\n")
        errors = process.communicate(timeout=20)[1]
        assert process.returncode == 1, errors
        assert errors.count("\n") == 1 and "history.csv" in errors and "removed" in errors and "nothing is kept" in errors


def test_a_folder_that_cannot_be_listed(tmp_path):
    folder = tmp_path / "blind"
    folder.mkdir()
    (folder / "history.csv").write_text("step\n")
    folder.chmod(0o333)
    other = {}
    if os.access(folder, os.R_OK):  # root may list everything
        with contextlib.suppress(OSError):
            for parent in (tmp_path, *tmp_path.parents):
                parent.chmod(parent.stat().st_mode | 0o711)
        other = {"user": 65534}
    temporary = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
    words = harness.to_arguments({**BLOCK, "output_dir": folder})
    done = subprocess.run(harness.command(words, 1), capture_output=True, text=True, cwd="/", timeout=60,
                          env={**harness.environment(1), "TMPDIR": "/tmp", "HOME": str(temporary)}, **other)
    assert done.returncode == 1 and "-output_dir" in done.stderr and "listed" in done.stderr and done.stderr.count("\n") == 1, done.stderr
    folder.chmod(0o755)
    assert names(folder) == {"history.csv"}


def test_one_run_a_folder(tmp_path):
    """The second is refused, with or without a restart; a kill leaves a lock that harms nobody."""
    case = {**FORKS, "checkpoint_interval": "20"}
    for ranks in (1, 3):
        folder = tmp_path / f"ranks{ranks}"
        first = start(case, folder, ranks)
        checkpoint = folder / "checkpoint_000020.h5"
        wait_for(checkpoint.exists)
        refused({**case, "overwrite": None}, folder, "-output_dir", "one run at a time")
        refused({**case, "restart": checkpoint}, folder, "-output_dir", "one run at a time", ranks=ranks)
        assert first.poll() is None and checkpoint.exists()
        children = [int(word) for word in pathlib.Path(f"/proc/{first.pid}/task/{first.pid}/children").read_text().split()]
        for one in [first.pid, *children]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(one, signal.SIGKILL)
        first.communicate()
        wait_for(lambda: not any(pathlib.Path(f"/proc/{child}").exists() for child in children))
        succeeds({**case, "max_steps": "25", "restart": checkpoint}, folder)
        assert not (folder / ".mlgimp_lock").exists()
