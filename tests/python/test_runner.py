"""Checks the rules of tests/conftest.py on small projects: what counts as a failure, and the last line."""
import shutil
import subprocess
import sys

import pytest

from harness import ROOT

pytestmark = pytest.mark.fast

REPORT = '{"testsuites": [{"name": "Unit", "testsuite": [{"name": "Works", "file": "one.cpp", "result": "COMPLETED"%s}]}]}'
PROGRAM = """#!/bin/sh
for word; do case $word in --gtest_output=json:*) report=${word#--gtest_output=json:};; --gtest_list_tests) list=1;; esac; done
%s
"""
WRITE = f"echo '{REPORT % ''}' > $report"
WRITE_FAILURE = f"""echo '{REPORT % ', "failures": [{"failure": "5 instead of 6"}]'}' > $report"""


@pytest.fixture
def project(tmp_path):
    """Runs pytest on test functions and a unit program made of shell commands; returns (status, all, last line)."""
    def run(functions="", program=None, *words):
        (tmp_path / "tests" / "cases").mkdir(parents=True)
        (tmp_path / "tests" / "unit").mkdir()
        (tmp_path / "bin").mkdir()
        for name in ("conftest.py", "harness.py"):
            shutil.copy(ROOT / "tests" / name, tmp_path / "tests")
        shutil.copy(ROOT / "pytest.ini", tmp_path)
        (tmp_path / "tests" / "cases" / "made_up.py").write_text(functions)
        if program is not None:
            (tmp_path / "tests" / "unit" / "one.cpp").touch()
            (tmp_path / "bin" / "test_units").write_text(PROGRAM % program)
            (tmp_path / "bin" / "test_units").chmod(0o755)
        done = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "tests", *words], cwd=tmp_path,
                              capture_output=True, text=True)
        return done.returncode, done.stdout, done.stdout.splitlines()[-1]
    return run


def test_all_pass(project):
    status, _, last = project("def test_a(expect):\n    expect('figure', 1.0, at_most=1)\n", WRITE)
    assert (status, last) == (0, "2 passed, 0 failed")


def test_missed_expectations_fail_at_the_end(project):
    status, printed, last = project("def test_a(expect):\n    expect('first', 2, at_most=1)\n"
                                    "    expect('second', float('nan'), near=0, tolerance=1)\n"
                                    "    expect.that('third', True)\n    expect.that('fourth', False, 'why')\n")
    assert (status, last) == (1, "0 passed, 1 failed")
    for line in ("3 expectations missed", "first: 2 (<= 1)", "second: nan (0 +- 1)", "fourth: why"):
        assert line in printed


def test_an_error_is_a_failure(project):
    status, _, last = project("import pytest\n@pytest.fixture\ndef broken():\n    raise OSError\n"
                              "def test_a(broken): pass\ndef test_b(): pass\n")
    assert (status, last) == (1, "1 passed, 1 failed")


def test_a_skip_is_a_skip(project):
    status, _, last = project("import pytest\ndef test_a(): pytest.skip('not here')\ndef test_b(): pass\n")
    assert (status, last) == (0, "1 passed, 0 failed, 1 skipped")


def test_nothing_passed(project):
    status, _, last = project("import pytest\ndef test_a(): pytest.skip('not here')\n")
    assert (status, last) == (1, "0 passed, 0 failed, 1 skipped")


def test_studies_are_no_tests(project):
    status, _, last = project("def verify_a(): assert False\ndef test_b(): pass\n")
    assert (status, last) == (0, "1 passed, 0 failed")


@pytest.mark.parametrize("program, expected", [
    ("", "has no test of one.cpp"),
    (f"[ $list ] && {WRITE}; exit 0", "exit status 0"),  # says that it has a test and runs none
    (f"{WRITE}; [ $list ] || exit 3", "exit status 3"),
    (f"if [ $list ]; then {WRITE}; else kill -9 $$; fi", "exit status -9"),
    (WRITE_FAILURE, "5 instead of 6")])
def test_unit_program_that_fails(project, program, expected):
    status, printed, last = project("", program)
    assert (status != 0, last) == (True, "0 passed, 1 failed")
    assert expected in printed
