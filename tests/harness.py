"""What tests share: running the program, reading its results, and stating what is expected."""
import csv
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import namedtuple

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / os.environ.get("MLGIMP_BIN", "bin")
PROGRAM = BIN / "mlgimp"
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "python")]

ENVIRONMENT = dict(
    os.environ,
    OMPI_ALLOW_RUN_AS_ROOT="1",
    OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
    OMPI_MCA_rmaps_base_oversubscribe="1",
    PRTE_MCA_rmaps_default_mapping_policy=":oversubscribe",  # the same for Open MPI 5
    OMPI_MCA_orte_execute_quiet="1",
    OMPI_MCA_pml="ob1",
    OMPI_MCA_btl="self,vader",
    OMP_NUM_THREADS="1",
    ASAN_OPTIONS="detect_leaks=0",  # MPI's own leaks drown any of ours; -malloc_dump and valgrind look for those
)


def environment(ranks):
    """For one run: a folder of its own for MPI's files, so that no other run disturbs it; alone it needs no daemon of MPI."""
    alone = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_btl": "self"} if ranks == 1 else {}
    return dict(ENVIRONMENT, TMPDIR=tempfile.mkdtemp(dir=scratch()), **alone)


def lines_of(error):
    """Lines on standard error but those that mpiexec adds: between two lines of dashes, as that of Open MPI 5 cannot be silenced, and
    warnings of its event loop as it stops the other ranks."""
    own = re.sub(r"^-{60,}\n(.*\n)*?-{60,}$\n?", "", error.replace("\0", ""), flags=re.MULTILINE)
    own = re.sub(r"^\[warn\] Epoll .*\n?", "", own, flags=re.MULTILINE).strip("\n")
    return own.split("\n") if own else []


class Result:
    """A finished run: exit status, printed text and the results in its folder."""

    def __init__(self, status, stdout, stderr, folder):
        self.status, self.stdout, self.stderr, self.folder = status, stdout, stderr, pathlib.Path(folder)

    @property
    def history(self):
        """Columns of history.csv as a dict of numpy arrays."""
        from mlgimp import results
        return results.read_history(self.folder)

    @property
    def summary(self):
        return json.loads((self.folder / "summary.json").read_text())

    def frame(self, number=None):
        """All points of a frame (the last by default), ordered by id."""
        import numpy

        from mlgimp import results
        points = results.all_points(results.read_frame(results.find_frame(self.folder, number)).levels)
        order = numpy.argsort(points["id"])
        return {name: values[order] for name, values in points.items()}


def up_to(ranks):
    """So many ranks, or as many as there are cores for them: for long runs whose results are the same on any number (tests/cases/ranks.py).
    Two that share a core need three times as long as one alone."""
    return min(ranks, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else ranks)


def command(arguments, ranks):
    """The command line on a number of ranks."""
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    return start + [str(PROGRAM)] + [str(a) for a in arguments]


def to_arguments(options):
    """{'cell_size': 1, 'overwrite': None} -> ['-cell_size', '1', '-overwrite']; lists are joined by commas."""
    arguments = []
    for name, value in options.items():
        arguments.append("-" + name)
        if isinstance(value, (list, tuple)):
            arguments.append(",".join(repr(float(v)) if isinstance(v, float) else str(v) for v in value))
        elif value is not None:
            arguments.append(repr(float(value)) if isinstance(value, float) else str(value))
    return arguments


Ran = namedtuple("Ran", "command folder")
ran = []  # runs of the program so far: command line without where the results went, and that folder


def run(options, file=None, ranks=1, folder=None, must_succeed=True, timeout=1200):
    """Runs a case from an options file of the repository and/or a dict of options; returns a Result.

    The results go to `folder`, or to a temporary one that scratch() removes at the end.
    """
    folder = pathlib.Path(folder or tempfile.mkdtemp(dir=scratch()))
    arguments = (["-options_file", f"options/{file}"] if file else []) + to_arguments(options)
    ran.append(Ran(shlex.join(command(arguments, ranks)).replace(f"{ROOT}/", ""), folder))
    arguments += to_arguments({"output_dir": folder, "overwrite": None, "monitor": "false"})
    done = subprocess.run(command(arguments, ranks), capture_output=True, text=True, env=environment(ranks), cwd=ROOT,
                          timeout=timeout)
    result = Result(done.returncode, done.stdout, done.stderr, folder)
    if must_succeed and done.returncode != 0:
        raise AssertionError(f"exit status {done.returncode}: {done.stderr.strip()[-500:]}")
    return result


_runs = {}


def run_once(options, file=None, ranks=1):
    """run() for what several tests compare with: once in a process of pytest; its folder is only read."""
    key = (*to_arguments(options), file, ranks)
    if key not in _runs:
        _runs[key] = run(options, file, ranks)
    return _runs[key]


UnitRun = namedtuple("UnitRun", "status output error tests")  # tests: {name: messages of its failures, None where it was skipped}


def run_units(program, names="*", ranks=1, timeout=1200):
    """Runs tests of a GoogleTest program bin/test_*; names are joined by colons."""
    report = tempfile.mktemp(suffix=".json", dir=scratch())
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, str(BIN / program), "--gtest_color=no", f"--gtest_filter={names}",
                           f"--gtest_output=json:{report}"],
                          capture_output=True, text=True, env=environment(ranks), cwd=ROOT, timeout=timeout)
    ran = {name: test for name, test in unit_tests(report) if test["result"] in ("COMPLETED", "SKIPPED")}
    tests = {name: None if test["result"] == "SKIPPED" else [failure["failure"] for failure in test.get("failures", [])]
             for name, test in ran.items()}
    return UnitRun(done.returncode, done.stdout, done.stderr, tests)


def unit_tests(report):
    """(full name, description) of all tests in a report of GoogleTest; none where there is no report."""
    if not os.path.exists(report):
        return []
    suites = json.loads(pathlib.Path(report).read_text())["testsuites"]
    return [(f"{suite['name']}.{test['name']}", test) for suite in suites for test in suite["testsuite"]]


def load_on_points(points, hoop=False, up=None):
    """Load in N that the pressures of contact on the points of a frame are, on their upper faces; in the plane for a thickness of 1.

    hoop: faces go around the axis. up: vertical part of the indenter's normal, by default that of each face.
    """
    import numpy
    dim = points["position"].shape[1]
    F = points["deformation_gradient"].reshape(-1, dim, dim)
    half = numpy.sqrt(numpy.linalg.solve(F**2, points["half_size"][:, :, None] ** 2)[..., 0])  # undeformed
    edges = 2 * F * half[:, None, :]
    if dim == 3:
        area = numpy.cross(edges[:, :, 0], edges[:, :, 1])
    else:
        around = 2 * numpy.pi * (points["position"][:, 0] + edges[:, 0, 1] / 2) if hoop else 1
        area = edges[:, ::-1, 0] * numpy.reshape(around, (-1, 1))
    size = area[:, -1] if up is None else up * numpy.linalg.norm(area, axis=1)
    return points["contact_pressure"] @ size


_scratch = None


def scratch():
    """A folder for results, removed when the tests end."""
    global _scratch
    if _scratch is None:
        _scratch = tempfile.mkdtemp(prefix="mlgimp_test_")
    return _scratch


def clean_up():
    if _scratch:
        shutil.rmtree(_scratch, ignore_errors=True)


def size_of(folder):
    """(steps of the finest level, cells of it in half the widest contact) of a run; None where there are no such."""
    from mlgimp import errors, results
    try:
        finest = json.loads((pathlib.Path(folder) / "summary.json").read_text())["levels"][-1]
        widest = max(results.read_history(folder).get("contact_half_width", [0]), default=0)
    except (OSError, ValueError, KeyError, errors.Error):
        return None, None
    return finest["steps"], round(float(widest / finest["cell_size"]), 1) or None


class Expectations:
    """Figures and their limits. Each is printed; a test with one that is missed goes on, and fails at its end."""

    def __init__(self, listener=None):
        """listener(name, good, detail) is called for each."""
        self.missed = []
        self.listener = listener

    def __call__(self, name, value, at_most=None, at_least=None, near=None, tolerance=None):
        """The value lies within the limits given; a NaN never does."""
        good, limits = True, []
        if at_most is not None:
            good &= bool(value <= at_most)
            limits.append(f"<= {at_most:g}")
        if at_least is not None:
            good &= bool(value >= at_least)
            limits.append(f">= {at_least:g}")
        if near is not None:
            good &= bool(abs(value - near) <= tolerance)
            limits.append(f"{near:g} +- {tolerance:g}")
        self.that(name, good, f"{value:.4g} ({', '.join(limits)})")

    def that(self, name, good, detail=""):
        """Something is so."""
        line = name + (": " + detail if detail else "")
        if not good:
            self.missed.append(line)
        if self.listener:
            self.listener(name, bool(good), detail)
        print(("ok    " if good else "FAIL  ") + line, flush=True)


def given_by_contact(history):
    """The work of contact on points, and what it stored and did between the nodes, an array [rows] in J."""
    return history["contact_work"] + history["contact_strain_energy"] + history["contact_plastic_work"]


def read_csv(path):
    """A CSV with '#' comments and a header as a dict of lists of floats."""
    with open(path) as file:
        lines = [line for line in file if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    return {name: [float(row[name]) for row in table] for name in table[0]}
