"""File systems without locks, as Lustre mounted without flock or NFS without lockd: a run goes on there, and says so once."""
import errno
import shutil
import subprocess

import h5py
import pytest

import harness
from ranks import LEVELS, SAME, largest_difference
from safety import BLOCK, succeeds

pytestmark = [pytest.mark.fault, pytest.mark.mpi]
CASE = {**LEVELS, "frames": 2, "checkpoint_interval": 5, "max_steps": 10}
CASE.pop("end_time")
SAYS = "the file system gives no locks"


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """What takes the locks away."""
    path = tmp_path_factory.mktemp("library") / "no_locks.so"
    compiler = shutil.which("cc") or shutil.which("gcc") or pytest.skip("there is no C compiler by the name of cc or gcc")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", path, harness.ROOT / "tests" / "no_locks.c", "-ldl"], check=True)
    return path


def run(library, options, folder, ranks, **environment):
    """(exit status, lines on standard error) without locks; mpiexec itself keeps them."""
    words = harness.command(harness.to_arguments({"monitor": "false", **options, "output_dir": folder}), ranks)
    at = words.index(str(harness.PROGRAM))
    words[at:at] = ["env", f"LD_PRELOAD={library}", *(f"{name}={value}" for name, value in environment.items())]
    done = subprocess.run(words, capture_output=True, text=True, env=harness.environment(ranks), cwd=harness.ROOT, timeout=60)
    return done.returncode, harness.lines_of(done.stderr)


def check(library, folder, ranks, warned=True, views=("nodes", "points"), **environment):
    """Frames, checkpoints, a restart in the same folder and the files of PETSc's viewers."""
    viewers = {f"level_0_{kind}_view": f"hdf5:{folder.parent}/{kind}.h5" for kind in views}
    for options in ({**CASE, **viewers}, {**CASE, "restart": folder / "checkpoint_000005.h5"}):
        status, lines = run(library, options, folder, ranks, **environment)
        own = [line for line in lines if "-output_dir" in line]
        assert status == 0 and [SAYS in line for line in own] == [True] * warned, lines
        assert not any("ADIOI" in line for line in lines), lines
    assert not (folder / ".mlgimp_lock").exists()
    result = harness.Result(0, "", "", folder)
    assert len(result.summary["warnings"]) >= warned and result.summary["status"] == "completed"
    for name in ("points_000000.h5", "points_000002.h5", "checkpoint_000010.h5", *(f"../{kind}.h5" for kind in views)):
        with h5py.File(folder / name) as file:
            assert len(file) > 0
    return result


@pytest.mark.parametrize("ranks, error", [(1, errno.ENOLCK), (2, errno.ENOSYS), (4, errno.EOPNOTSUPP), (2, errno.EINVAL), (1, errno.EACCES)])
def test_no_locks(tmp_path, library, ranks, error):
    result = check(library, tmp_path / "run", ranks, NOLOCK_ERRNO=error)
    difference, column = largest_difference(result.history, harness.run(CASE).history)
    assert difference <= SAME, column


def test_no_locks_of_bytes(tmp_path, library):
    """Where a whole file can be locked, nothing is said."""
    check(library, tmp_path / "run", 2, warned=False, NOLOCK_BYTES=1)


@pytest.mark.parametrize("ranks", [1, 2])
def test_no_locks_on_nfs(tmp_path, library, ranks):
    """What MPI has for NFS locks everything that it reads and writes. PETSc's viewers open their files before the run knows that."""
    check(library, tmp_path / "run", ranks, views=(), NOLOCK_NFS=tmp_path)
    check(library, tmp_path / "run_with_viewers", ranks, NOLOCK_NFS=tmp_path, ROMIO_FSTYPE_FORCE="ufs:")


def test_with_ompio(tmp_path, library):
    """Open MPI's own layer for files, where a user asks for it."""
    check(library, tmp_path / "run", 2, OMPI_MCA_io="ompio")


def test_a_lock_that_is_taken(tmp_path, library):
    """EWOULDBLOCK says that a lock is there, and another run has it."""
    status, lines = run(library, BLOCK, tmp_path / "run", 1, NOLOCK_ERRNO=errno.EWOULDBLOCK)
    assert status == 1 and len(lines) == 1 and "one run at a time" in lines[0], lines
    succeeds(BLOCK, tmp_path / "run")
