"""The Debian package: built, looked at by lintian, installed into a fresh tree of Debian and run there."""
import os
import pathlib
import shutil
import subprocess
import tempfile

import pytest

import harness

RELEASE = "bookworm"


def run_in(tree, words):
    """What a command prints in a tree of Debian."""
    return subprocess.run(["chroot", tree, "sh", "-c", words], capture_output=True, text=True, check=True, timeout=900,
                          env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8", "DEBIAN_FRONTEND": "noninteractive",
                               "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}).stdout


def verify_installed(study):
    """The Debian package

    Built by dpkg-buildpackage of what is committed, and installed by apt into a tree of Debian that had nothing but its base.
    """
    if os.geteuid() != 0 or not shutil.which("apt-get"):
        pytest.skip("needs root on Debian, to make a tree of Debian and to install packages in it")
    subprocess.run(["sh", "scripts/install_packages.sh", "mmdebstrap"], cwd=harness.ROOT, check=True, capture_output=True)
    built = subprocess.run(["sh", "packaging/build_deb.sh"], cwd=harness.ROOT, capture_output=True, text=True, check=False)
    study.expect("errors and warnings of lintian", sum(line.startswith(("E:", "W:")) for line in (built.stdout + built.stderr).splitlines()), near=0, tolerance=0)
    study.expect("dpkg-buildpackage and lintian: exit status", built.returncode, near=0, tolerance=0)
    package = next((harness.ROOT / "output" / "deb").glob("mlgimp_*.deb"))
    study.figure("size of the package", package.stat().st_size / 1e6, "MB")
    tree = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch())) / "debian"
    subprocess.run(["mmdebstrap", "--variant=minbase", "--mode=root", RELEASE, tree], check=True, capture_output=True)
    shutil.copy(package, tree / "tmp")
    run_in(tree, f"apt-get update -q && apt-get install -q -y --no-install-recommends /tmp/{package.name}")
    summary = run_in(tree, "cd /tmp && mlgimp -options_file /usr/share/mlgimp/options/wedge_500nm.opts -max_steps 3 -frames 1 && cat output/*/summary.json")
    study.expect("a run there is completed", '"status": "completed"' in summary, near=True, tolerance=0)
    pictures = run_in(tree, "cd /tmp && python3 /usr/share/mlgimp/scripts/plot.py output/wedge_500nm && ls output/wedge_500nm")
    study.expect("pictures", pictures.count(".png"), at_least=5)
    run_in(tree, "apt-get remove -q -y mlgimp && test ! -e /usr/share/mlgimp")
