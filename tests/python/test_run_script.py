"""make run compiles on all cores, and runs on those that are idle: ranks that share a core with another program make all of them slow."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def start_line(tmp_path, busy):
    """What scripts/run.sh says it does, with a program that does nothing, while some processes keep cores busy."""
    tools = tmp_path / "tools"
    for folder in (tools, tmp_path / "bin", tmp_path / "scripts"):
        folder.mkdir()
    shutil.copy(ROOT / "scripts" / "run.sh", tmp_path / "scripts")
    for tool in (tools / "mpiexec", tmp_path / "bin" / "mlgimp", tools / "python"):
        tool.write_text("#!/bin/sh\necho \"$0 $*\"\n")
        tool.chmod(0o755)
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(busy)]
    try:
        return subprocess.run(["sh", "scripts/run.sh", str(tools / "python")], cwd=tmp_path, capture_output=True, text=True, check=True,
                              env={**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}, timeout=60).stdout
    finally:
        for other in others:
            other.kill()
            other.wait()


def test_busy_cores_are_left_alone(tmp_path):
    said = start_line(tmp_path, busy=2 * os.cpu_count())
    assert "and 1 ranks:" in said and "mpiexec" not in said
    assert "bin/mlgimp -options_file options/wedge_3level.opts" in said
    assert f"of {os.cpu_count()} cores busy" in said


def test_never_more_ranks_than_cores(tmp_path):
    said = start_line(tmp_path, busy=0)
    ranks = int(said.split(" ranks:")[0].split()[-1])
    assert 1 <= ranks <= min(4, os.cpu_count())


def compilers_of(*words):
    """As how many at once `make` with these words would compile; 0 where it leaves that to the make that it was started by."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    said = subprocess.run(["make", "-n", *words], cwd=ROOT, capture_output=True, text=True, check=True, env=environment, timeout=60).stdout
    return int(re.search(r"^\S*make --no-print-directory (?:-j(\d+))?", said, re.MULTILINE)[1] or 0)


def test_make_compiles_on_all_cores():
    cores = len(os.sched_getaffinity(0))
    assert compilers_of("run") == compilers_of("test") == cores
    assert compilers_of("run", "-j3") == compilers_of("test", "-j1") == 0
