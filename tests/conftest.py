"""What pytest needs to know of this project: expectations that go on, unit programs, studies, and the last line."""
import os
import pathlib
import re
import subprocess
import tempfile

import pytest

import harness

RANKS = {False: (1,), True: (1, 3)}  # of unit tests: those whose suite ends in OnRanks run on several

# Files of half a minute and more, the longest first: processes that -n has started take files in this order, and so end together.
LONGEST_FIRST = ("stops", "hardness", "ranks", "friction", "restart", "borders", "metals", "following", "limits", "bad_input", "bending", "rounding",
                 "elastic_contact", "test_tutorial", "quasi_static", "test_measured", "test_package", "test_refusals", "bad_input_of_contact")
LONGEST_STUDIES_FIRST = ("hardness", "crystals", "tables", "following", "unloading", "debian_package", "creep_laws", "fuzz", "half_plane", "instrument")


def pytest_configure(config):
    """Each process that -n has started keeps to a core of its own: ranks that wait for each other would take those of the rest."""
    if hasattr(config, "workerinput") and hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {cores[int(config.workerinput["workerid"].removeprefix("gw")) % len(cores)]})


# ---- expectations ----

@pytest.fixture
def expect():
    """expect(name, value, at_most=..., at_least=..., near=..., tolerance=...) and expect.that(name, good, detail).

    A limit follows from theory, or from a measurement that the test names: "Seen: ..." in its text is what it printed when its limits were last
    looked at, the largest of all its cases, in the order of its figures. Between that and the limit is room for other machines.
    """
    return harness.Expectations()


@pytest.fixture
def study(request):
    """What a function verify_* fills: see verify.Study. The page is written by tests/verify.py."""
    import verify
    made = verify.Study.of(request.function, request.path)
    yield made
    made.store()


@pytest.hookimpl(hookwrapper=True)
def pytest_pyfunc_call(pyfuncitem):
    """Fails a test at its end with what it expected in vain."""
    outcome = yield
    values = pyfuncitem.funcargs
    missed = values["expect"].missed if "expect" in values else []
    if "study" in values:
        if outcome.excinfo:
            values["study"].expect.that("went through", False, f"{outcome.excinfo[0].__name__}: {outcome.excinfo[1]}")
        missed = missed + values["study"].expect.missed
    if missed and not outcome.excinfo:
        pytest.fail(f"{len(missed)} expectations missed:\n" + "\n".join(missed), pytrace=False)


# ---- unit programs ----

def pytest_collect_file(file_path, parent):
    if file_path.suffix == ".cpp" and file_path.parent.name in ("unit", "simulation") and file_path.name != "main.cpp":
        return UnitFile.from_parent(parent, path=file_path)


class UnitFile(pytest.File):
    """A source of GoogleTest; its program says which tests are in it."""

    def collect(self):
        self.program = "test_units" if self.path.parent.name == "unit" else "test_" + self.path.stem
        tests = [name for name, source in self.listed() if pathlib.Path(source).name == self.path.name]
        if not tests and self.wanted():
            raise self.CollectError(f"bin/{self.program} has no test of {self.path.name}; make programs")
        for test in tests:
            for ranks in RANKS[test.split(".")[0].endswith("OnRanks")]:
                yield UnitTest.from_parent(self, name=test + (f"[{ranks}]" if ranks > 1 else ""), test=test, ranks=ranks)

    def wanted(self):
        """Whether the program must be there: a selection by -k need not have built what it does not name."""
        words = self.config.option.keyword.split(" or ")
        return any(word in f"{self.program} {self.path.name}" for word in words)

    def listed(self):
        """(name, source) of all tests of the program."""
        report = tempfile.mktemp(suffix=".json", dir=harness.scratch())
        program = harness.BIN / self.program
        if program.exists():
            subprocess.run([program, "--gtest_list_tests", f"--gtest_output=json:{report}"], stdout=subprocess.DEVNULL,
                           check=True)
        return [(name, test["file"]) for name, test in harness.unit_tests(report)]


class UnitTest(pytest.Item):
    """One test of a unit program on a number of ranks."""

    def __init__(self, *, test, ranks, **other):
        super().__init__(**other)
        self.test, self.ranks = test, ranks
        self.extra_keyword_matches.add(self.parent.program)
        self.add_marker("fast" if self.parent.program == "test_units" else "slow")
        self.add_marker(pytest.mark.timeout(1200))
        if ranks > 1:
            self.add_marker("mpi")

    def runtest(self):
        done = unit_run(self)
        begin = re.escape(f"[ RUN      ] {self.test}\n")
        print("".join(re.findall(rf"{begin}(.*?)^\[ ", done.output, re.M | re.S)))
        if self.test not in done.tests or (done.status != 0 and not any(done.tests.values())):
            raise UnitFailure(f"exit status {done.status}:\n{done.output[-3000:]}\n{done.error[-3000:]}")
        if done.tests[self.test] is None:
            pytest.skip("by the test itself")
        if done.tests[self.test]:
            raise UnitFailure("\n".join(done.tests[self.test]))

    def repr_failure(self, excinfo, style=None):
        return str(excinfo.value) if isinstance(excinfo.value, UnitFailure) else super().repr_failure(excinfo, style)

    def reportinfo(self):
        return self.path, None, self.name


class UnitFailure(Exception):
    """A test of a unit program failed, or the program did."""


unit_runs = {}  # by file and ranks


def unit_run(item):
    """The run of the item's program with all tests of its file that were selected."""
    if (item.path, item.ranks) not in unit_runs:
        tests = [other.test for other in item.session.items
                 if isinstance(other, UnitTest) and (other.path, other.ranks) == (item.path, item.ranks)]
        unit_runs[item.path, item.ranks] = harness.run_units(item.parent.program, ":".join(tests), item.ranks)
    return unit_runs[item.path, item.ranks]


# ---- selection and the last line ----

@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    if hasattr(config, "workerinput"):
        are_studies = any(item.name.startswith("verify_") for item in items)
        places = {f"{name}.py": place for place, name in enumerate(LONGEST_STUDIES_FIRST if are_studies else LONGEST_FIRST)}
        items.sort(key=lambda item: places.get(item.path.name, len(places)))
    for item in items:
        if item.name.startswith("verify_"):
            item.add_marker("study")
            item.add_marker(pytest.mark.timeout(4 * 3600))


counts = {}


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """Counts; a session in which no test passed has failed."""
    harness.clean_up()
    if hasattr(session.config, "workerinput"):
        return  # a process that -n has started; the one that started it counts
    stats = session.config.pluginmanager.get_plugin("terminalreporter").stats
    failed = len(stats.get("failed", [])) + len(stats.get("error", []))
    counts.update(passed=len(stats.get("passed", [])), failed=failed, skipped=len(stats.get("skipped", [])))
    if session.exitstatus == 0 and not counts["passed"] and not session.config.option.collectonly:
        session.exitstatus = 1


def pytest_unconfigure():
    """The last line of `make test`."""
    if counts:
        skipped = f", {counts['skipped']} skipped" if counts["skipped"] else ""
        print(f"{counts['passed']} passed, {counts['failed']} failed{skipped}")
