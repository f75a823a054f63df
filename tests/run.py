#!/usr/bin/env python3
"""Runs every test: the C++ unit tests, the scripts' tests and the cases; ends with 'N passed, N failed'.

usage: tests/run.py [WORD ...]      only the tests whose name contains one of the words
Cases are functions test_* (report) in tests/cases/*.py; the functions verify_* there belong to `make verify`.
"""
import importlib
import pathlib
import subprocess
import sys
import time
import traceback

import harness

HERE = pathlib.Path(__file__).resolve().parent


def run_unit_test(program, report):
    """A unit test prints 'ok NAME: detail' or 'FAIL NAME: detail' for each check and exits with 0 when it got through."""
    done = subprocess.run([str(program)], capture_output=True, text=True, env=harness.ENVIRONMENT)
    for line in done.stdout.splitlines():
        word, _, rest = line.partition(" ")
        if word in ("ok", "FAIL"):
            name, _, detail = rest.partition(": ")
            report.note(f"{program.name}: {name}", word == "ok", detail)
    if done.returncode != 0:
        report.note(program.name, False, f"exit status {done.returncode}: {done.stderr.strip()[-500:]}")


def run_function(name, function, report):
    begin = time.time()
    try:
        function(report)
    except Exception as error:
        traceback.print_exc()
        report.note(name, False, f"{type(error).__name__}: {error}")
    print(f"      {name} took {time.time() - begin:.1f} s", flush=True)


def collect(prefix):
    """(name, function) of the functions in tests/cases whose name begins with the prefix."""
    sys.path.insert(0, str(HERE / "cases"))
    for path in sorted((HERE / "cases").glob("*.py")):
        module = importlib.import_module(path.stem)
        for name in sorted(vars(module)):
            if name.startswith(prefix):
                yield f"{path.stem}: {name}", getattr(module, name)


def selected(name, words):
    return not words or any(word in name for word in words)


def run_script_test(script, report):
    """The tests of a script are those of unittest."""
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    report.note(script.stem, done.returncode == 0, (done.stderr.strip() or "nothing printed").splitlines()[-1])


def main(words):
    report = harness.Report()
    try:
        for program in sorted(harness.BIN.glob("test_*")):
            if selected(f"bin/{program.name}", words):
                run_unit_test(program, report)
        for script in sorted((HERE / "python").glob("test_*.py")):
            if selected(script.stem, words):
                run_script_test(script, report)
        for name, function in collect("test_"):
            if selected(name, words):
                run_function(name, function, report)
    finally:
        harness.clean_up()
    failures = [name for name, good, _ in report.rows if not good]
    for name in failures:
        print("failed: " + name)
    print(f"{report.passed} passed, {report.failed} failed")
    return 1 if report.failed or report.passed == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
