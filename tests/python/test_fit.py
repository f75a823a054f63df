"""Checks scripts/fit.py with a law in place of the program: constants and their intervals, what cannot be told apart, refusals."""
import csv
import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

import fit
import harness
from mlgimp import fit_profiles, fit_search, fitting
from mlgimp.errors import Error
from made_curves import CONE_OPTIONS, curve
from test_scripts import HISTORY

pytestmark = pytest.mark.fast

TRUTH = {"m_youngs_modulus": 70e9, "m_yield_stress": 5e8, "m_hardening_exponent": 0.2}
CASE = ("-materials m,s\n-m_youngs_modulus 50e9\n-m_yield_stress 8e8\n-m_hardening_exponent 0.1\n-m_poissons_ratio 0.3\n"
        "-s_density 1\n-m_density 2\n-m_model j2\n")


def law(constants, depth=0.5, rows=300):
    """Depth (um) and load (mN) of a test whose loading, slope of unloading and curvature depend on all constants of TRUTH."""
    modulus, yields, exponent = (float(constants[name]) for name in TRUTH)
    up = np.linspace(0, depth, rows)
    curvature = 2e-9 * yields**0.6 * modulus**0.4 * (1 + exponent)
    stiffness = modulus * 2e-9 * depth
    recovered = 1.5 * curvature * depth**2 / stiffness
    down = np.linspace(depth, depth - recovered, rows)[1:]
    loading = curvature * up ** (2 - 2 * exponent) * depth ** (2 * exponent)
    return np.append(up, down), np.append(loading, loading[-1] * np.maximum((down - depth) / recovered + 1, 0) ** 1.5)


def only_the_hardness(constants, rows):
    """A test in which modulus and yield stress count by their product alone."""
    product = float(constants["m_youngs_modulus"]) * float(constants["m_yield_stress"])
    return law({**TRUTH, "m_yield_stress": 5e8 * (product / 35e18) ** (5 / 3)}, rows=rows)


def written_by(model):
    """What stands for a run of the program: a result folder with the load of the middle of each interval."""
    def execute(options, ranks):
        depth, load = model({**TRUTH, **options}, rows=1000)
        folder = options["output_dir"]
        folder.mkdir(exist_ok=True)
        columns = dict.fromkeys(HISTORY, np.zeros(len(depth))) | {"time": np.arange(len(depth)) * 1e-9, "depth": 1e-6 * depth,
                                                                 "load": 1e-3 * np.append(0, (load[1:] + load[:-1]) / 2)}
        np.savetxt(folder / "history.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
        (folder / "summary.json").write_text(json.dumps({"case": "made", "options": CONE_OPTIONS}))
    return execute


@pytest.fixture
def fitted(tmp_path, monkeypatch):
    """fitted(model, names, noise, words) runs a fit and returns fit.json and what was printed; names is the text after -vary."""
    def make(model, names, noise=0.0, words=(), seed=1):
        monkeypatch.setattr(fitting, "execute", written_by(model))
        depth, load = law(TRUTH)
        random = np.random.default_rng(seed)
        np.savetxt(tmp_path / "m.csv", np.column_stack([depth, load + noise * load.max() * random.normal(size=len(load))]), delimiter=",",
                   header="depth,load", comments="")
        (tmp_path / "case.opts").write_text(CASE)
        fit.main([str(tmp_path / "m.csv"), str(tmp_path / "case.opts"), "-vary", names, "-output_dir", str(tmp_path / f"fit_{seed}"), *words])
        return json.loads((tmp_path / f"fit_{seed}" / "fit.json").read_text())
    return make


def test_constants_are_found_again(fitted, expect, tmp_path):
    """From a first guess that is off by 30 to 100 %, without noise."""
    found = fitted(law, "E,yield_stress,hardening_exponent")
    for name, value in TRUTH.items():
        expect(name, found["constants"][name]["value"] / value - 1, near=0, tolerance=0.005)
    expect("misfit", found["misfit"], at_most=1e-3)
    rows = list(csv.DictReader(open(tmp_path / "fit_1" / "fit.csv")))
    assert len(rows) == found["runs"] == len(list((tmp_path / "fit_1").glob("run_*"))) and found["warnings"] == []
    assert float(rows[0]["m_youngs_modulus"]) == 50e9 and (tmp_path / "fit_1" / "fit.png").stat().st_size > 1000


def test_intervals_hold_the_truth(fitted, expect):
    """Noise of 1 %: 95 % of the intervals hold the truth, here of 16 all but one or two, and they are not wide."""
    held, widths = 0, []
    for seed in range(8):
        for name, each in fitted(law, "E,yield_stress", noise=0.01, seed=seed)["constants"].items():
            held += each["lower"] <= TRUTH[name] <= each["upper"]
            widths.append((each["upper"] - each["lower"]) / each["value"])
    expect("intervals that hold the truth", held, at_least=13)
    expect("largest width", max(widths), at_most=0.03)


def test_intervals_hold_the_best_run_too(monkeypatch):
    """A run of the table that misses less than the values found lies in the intervals, and a line says so."""
    class Search:
        def __init__(self, *_):
            pass

        def begin(self):
            return np.eye(1)

        def go(self, _):
            return fit_search.Solution(np.zeros(1), np.full(100, 0.02), np.ones((100, 1)), np.array([[1e-6]])), True
    monkeypatch.setattr(fitting.fit_search, "Search", Search)
    rows = [(1, 50e9, 0.021, 1.0), (2, 56e9, 0.015, 1.0)]
    runs = SimpleNamespace(variables=[fitting.Variable("E", "m_youngs_modulus", 50e9, 1e9, 1e12)], values=lambda x: 50e9 * np.exp(x), residuals=None,
                           groups=list, errors=list, rows=rows, targets=[], folder=None)
    found = fitting.search(runs, 1)
    assert found.lower[0] < 50e9 and found.upper[0] == 56e9
    assert "run 2 of fit.csv misses 1.5 % with E 5.6e+10, the values found 2 %" in next(fitting.doubts_of_best(found))


def test_constants_that_cannot_be_told_apart(fitted, capsys):
    [line] = [line for line in fitted(only_the_hardness, "E,yield_stress", noise=1e-3)["warnings"] if "told apart" in line]
    assert "E and yield_stress" in line and f"warning: {line}" in capsys.readouterr().out


def test_a_constant_that_goes_to_its_limit(fitted):
    warnings = fitted(law, "E", words=("-m_youngs_modulus", "2e9"))["warnings"]
    assert any("went to its limit" in line for line in warnings)


def test_a_search_that_is_cut_short(fitted):
    assert any("stopped before its end" in line for line in fitted(law, "E,yield_stress", words=("-evaluations", "2"))["warnings"])


def test_a_curve_that_no_constants_give(fitted):
    """Stiffer by up to 40 % in the second half of the loading, as on a hard layer."""
    def layered(constants, rows):
        depth, load = law(constants, rows=rows)
        return depth, load * np.where(depth > 0.25, 1 + 1.6 * (depth - 0.25), 1)
    found = fitted(layered, "E,yield_stress")
    assert any("misses the measured one" in line for line in found["warnings"]) and 0.02 < found["misfit"] < 0.05, found


def test_a_case_of_another_depth(fitted):
    """What a shallower run would have given beyond its depth is a guess, however well it fits."""
    lines = fitted(lambda constants, rows: law(constants, depth=0.4, rows=rows), "E,yield_stress")["warnings"]
    assert any("is pressed 0.4 um deep, the measured curve 0.5 um" in line for line in lines), lines


def test_another_test_is_seen_after_the_first_runs(fitted, capsys):
    """Another depth under another load; a first guess that is too soft gives either, by what the test prescribes, but not both."""
    fitted(lambda constants, rows: law(constants, depth=0.4, rows=rows), "E,yield_stress")
    printed = capsys.readouterr().out
    assert "pressed 0.4 um deep by" in printed and printed.index("is the case that of the test?") < printed.index("by noise and first slopes")
    fitted(law, "E,yield_stress", seed=2)
    assert "is the case that of the test?" not in capsys.readouterr().out


def test_intervals_say_what_they_do_not_include(fitted, monkeypatch, capsys):
    """Cells and block of the best run; of runs whose cells are not known nothing."""
    assert fitted(law, "E")["notes"] == []
    monkeypatch.setattr(fitting.oliver_pharr, "expected_errors", lambda curve, cycle: {"cells": 5.0, "expected_error": {"load_mN": 0.06, "modulus_GPa": 0.13}})
    [line] = fitted(law, "E")["notes"]
    assert line.endswith("5 cells in half the contact and this block may change the run's loads by 6 %, a modulus by 13 %")
    assert f"note: {line}" in capsys.readouterr().out


@pytest.mark.parametrize("given, line", [
    ({"vary": []}, r"vary=\[\]: must be a list"), ({"vary": None}, "vary="), ({"vary": [1]}, "vary="),
    ({"evaluations": 0}, "evaluations=0: must be a whole number >= 1"), ({"ranks": 0}, "ranks=0"), ({"runs": "2"}, "runs=2"),
    ({"runs": 0}, "runs=0"), ({"measured": None}, "measured=None"), ({"case": {}}, "case=")])
def test_fit_from_python_checks_first(tmp_path, monkeypatch, given, line):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fitting, "execute", lambda *arguments: pytest.fail("there was a run"))
    (tmp_path / "case.opts").write_text(CASE)
    with pytest.raises(Error, match=line):
        fitting.fit(**{"measured": curve(*law(TRUTH)), "case": "case.opts", "vary": "E", **given})


def test_what_the_program_warns_of(fitted, monkeypatch):
    """The warning is of the best run, not of others."""
    make = written_by(law)

    def with_warning(options, ranks):
        make(options, ranks)
        close = abs(float(options["m_youngs_modulus"]) / TRUTH["m_youngs_modulus"] - 1) < 0.01
        path = options["output_dir"] / "summary.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | {"warnings": ["-damping 1: near" if close else "-damping 1: far"]}))
    monkeypatch.setattr("test_fit.written_by", lambda model: with_warning)
    lines = fitted(law, "E")["warnings"]
    assert "of the best run: -damping 1: near" in lines and not any("far" in line for line in lines), lines


def test_values_do_not_depend_on_rows(expect):
    """A test with a tenth of the rows of a run, and a run that ends before the test does."""
    test, run = (curve(*law(TRUTH, rows=rows), is_run=rows > 1000) for rows in (200, 2000))
    target = fit_profiles.target_of(test)
    expect("rows", np.max(np.abs(fit_profiles.compared(run, None, target) - target.values)) / target.scale, at_most=1e-3)
    shallow = curve(*law(TRUTH, depth=0.48, rows=2000), is_run=True)
    expect("a loading that ends early", np.max(np.abs(fit_profiles.compared(shallow, None, target) / target.values - 1)[target.groups[0]]), at_most=0.02)


# ---- several tests at once ----

ANGLES = 60, 70.3
START = {"m_youngs_modulus": 90e9, "m_yield_stress": 4.5e8, "m_hardening_exponent": 0.2}


def under_a_cone(constants, angle, depth=0.2, rows=300):
    """Depth (um) and load (mN) under a cone of a half angle (degrees): a hardness of 2.8 times the flow stress at a strain of
    0.2 cot(angle), as Tabor has it, and the stiffness of a contact of its area; from touch to touch."""
    modulus, yields, exponent = (float(constants[name]) for name in TRUTH)
    tangent = math.tan(math.radians(angle))
    hardness = 2.8e-9 * yields * (1 + modulus * 0.2 / tangent / yields) ** exponent
    curvature, stiffness = math.pi * tangent**2 * hardness, 2e-9 * modulus / 0.91 * tangent * depth
    recovered = 1.4 * curvature * depth**2 / stiffness
    up, down = np.linspace(0, depth, rows), np.linspace(depth, depth - recovered, rows)[1:]
    return np.append(up, down), np.append(curvature * up**2, curvature * depth**2 * np.maximum((down - depth) / recovered + 1, 0) ** 1.4)


def noisy_tests(seed, rows=200):
    """Curves of both cones with noise of 0.5 % of the load and 0.2 % of the depth."""
    random, found = np.random.default_rng(seed), []
    for angle in ANGLES:
        depth, load = under_a_cone(TRUTH, angle, rows=rows)
        found.append(curve(depth + 0.002 * depth.max() * random.normal(size=len(depth)), load + 0.005 * load.max() * random.normal(size=len(load))))
    return found


@pytest.fixture
def cones(tmp_path, monkeypatch):
    """cones(measured, ...) fits E, yield stress and exponent to curves of both cones, which stand for runs."""
    monkeypatch.setattr(fitting, "execute", lambda options, ranks: written_by(
        lambda constants, rows: under_a_cone(constants, float(str(options["options_file"].stem)), rows=rows))(options, ranks))
    cases = [tmp_path / f"{angle}.opts" for angle in ANGLES]
    for case in cases:
        case.write_text("".join(f"-{name} {value!r}\n" for name, value in START.items()))

    def make(measured, names=("E", "yield_stress", "hardening_exponent"), count=2, **more):
        return fitting.fit(measured[:count], cases[:count], names, output_dir=tmp_path / "fit", **more)
    return make


def test_intervals_of_two_tips_hold_the_truth(cones, expect):
    """Three constants in ten draws of the noise: of 30 intervals of 95 % all but three or fewer hold the truth, with 40 runs at most."""
    held, runs = [], []
    for seed in range(10):
        found = cones(noisy_tests(seed))
        held.append([lower <= TRUTH[name] <= upper for name, lower, upper in zip(TRUTH, found.lower, found.upper)])
        runs.append(2 * len(found.rows))
        assert found.finished
    expect("intervals that hold the truth", int(np.sum(held)), at_least=27)
    expect("runs of a fit", max(runs), at_most=40)


def test_forecast(cones, capsys):
    """Before the first step: one cone cannot tell yield stress from exponent; with two, the errors are those that are found in the end."""
    tests = noisy_tests(1)
    cones(tests, count=1, evaluations=1)
    printed = capsys.readouterr().out
    assert re.search(r"^this test cannot tell yield_stress from hardening_exponent: correlation -?(0\.99\d|1\.000)$", printed, re.M), printed
    assert printed.index("cannot tell") < printed.index("\n   5 ")
    found = cones(tests)
    expected = np.sqrt(np.diag(found.forecast))
    seen = np.log(found.upper / found.lower) / 4
    assert np.all((expected / seen > 0.5) & (expected / seen < 2)), (expected, seen)


def test_an_imprint_counts_too(cones, monkeypatch):
    """A curve alone determines the yield stress by its load; an imprint that says another one draws it there."""
    radius = np.linspace(0, 1, 40)
    depths = []

    def imprint_of(folder):
        yields = float(json.loads((folder.parent / "constants.json").read_text())[folder.name])
        return fit_profiles.Imprint(radius, -0.1 * (yields / 6e8) ** 2 * np.exp(-radius))
    make = fitting.execute

    def execute(options, ranks):
        make(options, ranks)
        path = options["output_dir"].parent / "constants.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        path.write_text(json.dumps(known | {options["output_dir"].name: options["m_yield_stress"]}))
        depths.append(options["frames"])
    monkeypatch.setattr(fitting, "execute", execute)
    monkeypatch.setattr(fitting.imprint, "profile_of", imprint_of)
    tests = noisy_tests(1)
    alone = cones(tests, ["yield_stress"], count=1, runs=1).values[0]
    assert depths[-1] == 0
    measured = fit_profiles.Imprint(radius, -0.1 * np.exp(-radius))  # that of 600 MPa
    both = cones(tests, ["yield_stress"], count=1, profile=[measured], runs=1)
    assert depths[-1] == 1 and abs(alone / 6e8 - 1) > 0.02 and abs(both.values[0] / 6e8 - 1) < abs(alone / 6e8 - 1), (alone, both.values)


def test_command_of_two_tests(cones, tmp_path, capsys):
    """Pairs of curve and case, and an imprint of the second."""
    for angle, test in zip(ANGLES, noisy_tests(1)):
        np.savetxt(tmp_path / f"{angle}.csv", np.column_stack([test.depth, test.load]), delimiter=",", header="depth,load", comments="")
    pairs = [str(tmp_path / f"{angle}.{kind}") for angle in ANGLES for kind in ("csv", "opts")]
    fit.main([*pairs, "-vary", "E,yield_stress,hardening_exponent", "-output_dir", str(tmp_path / "out")])
    found = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert found["runs"] == len(list((tmp_path / "out").glob("run_*_[12]"))) <= 40 and len(found["forecast"]["standard_errors"]) == 3
    assert all(each["lower"] <= TRUTH[name] <= each["upper"] for name, each in found["constants"].items())
    assert "by noise and first slopes" in capsys.readouterr().out and (tmp_path / "out" / "fit.png").stat().st_size > 1000
    for words, line in ((["-profile", "a.csv"], "one name for each of the 2 tests"), (["-profile", ",none.csv"], "none.csv")):
        with pytest.raises(SystemExit, match=line):
            fit.main([*pairs, "-vary", "E", *words])
    with pytest.raises(SystemExit, match="must be given, several tests one after the other"):
        fit.main([*pairs[:3], "-vary", "E"])


@pytest.mark.parametrize("given, line", [
    ({"measured": []}, "case="), ({"case": ["a.opts"]}, "a list with a case for each of the 2 curves"),
    ({"measured": "m.csv"}, "case=.*the path of an options file"), ({"profile": "p"}, "profile=.*a list with an imprint"),
    ({"profile": [None]}, "for each of the 2 curves")])
def test_lists_must_agree(monkeypatch, given, line):
    monkeypatch.setattr(fitting, "execute", lambda *arguments: pytest.fail("there was a run"))
    two = [curve(*law(TRUTH))] * 2
    with pytest.raises(Error, match=line):
        fitting.fit(**{"measured": two, "case": ["a.opts", "b.opts"], "vary": "E", **given})


# ---- refusals ----

WORDS = {
    "nothing": ([], "must be given"), "only the curve": (["m.csv"], "must be given"), "no curve": (["none.csv", "case.opts"], "none.csv"),
    "no case": (["m.csv", "none.opts"], "none.opts"), "nothing varied": (["m.csv", "case.opts"], "-vary"),
    "two dashes": (["m.csv", "case.opts", "--vary", "E,yield", "--evaluations=3"], "-vary yield"),
    "no option": (["m.csv", "case.opts", "-vary", "E,yield"], "-vary yield: must be an option that the case gives; the nearest is yield_stress"),
    "no number": (["m.csv", "case.opts", "-vary", "model"], "m_model is j2"),
    "of two materials": (["m.csv", "case.opts", "-vary", "density"], "s_density, m_density"),
    "twice": (["m.csv", "case.opts", "-vary", "E,youngs_modulus"], "twice"),
    "not positive": (["m.csv", "case.opts", "-vary", "E", "-m_youngs_modulus", "-1"], "number > 0"),
    "beyond the limits": (["m.csv", "case.opts", "-vary", "nu", "-m_poissons_ratio", "0.495"], "must begin in"),
    "runs": (["m.csv", "case.opts", "-vary", "E", "-runs", "0"], "-runs 0"),
    "no such test": (["m.csv", "case.opts", "-vary", "E", "-test", "2"], "there is no test 2; there are 1"),
    "zero": (["m.csv", "case.opts", "-vary", "E", "-zero_load", "x"], "-zero_load x: must be a number, or auto"),
    "unit": (["m.csv", "case.opts", "-vary", "E", "-depth", "h:inch"], "-depth h:inch"),
    "no column": (["m.csv", "case.opts", "-vary", "E", "-depth", "h:nm"], "no column h"), "empty": (["empty.csv", "case.opts", "-vary", "E"], "is empty"),
    "a jump": (["jump.csv", "case.opts", "-vary", "E"], "5 rows of its unloading"),
    "begins under load": (["late.csv", "case.opts", "-vary", "E"], "must begin at less than 0.1 of its largest depth"),
    "only loading": (["loading.csv", "case.opts", "-vary", "E"], "no unloading"),
    "folder": (["m.csv", "case.opts", "-vary", "E", "-output_dir", "/dev/null/f"], "-output_dir"),
    "no results": ([".", "case.opts", "-vary", "E"], "history.csv"),
    "the program's own": (["m.csv", "case.opts", "-vary", "E", "-runs", "2"], "at m_youngs_modulus 5e+10: mlgimp: error: -domain_lower"),
}


@pytest.mark.parametrize("name", WORDS)
def test_one_line(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    table = np.column_stack(law(TRUTH))
    for file, rows in (("m.csv", table), ("loading.csv", table[:300]), ("late.csv", table[60:]),
                       ("jump.csv", table[list(range(300)) + [590, 595, 598]])):
        np.savetxt(file, rows, delimiter=",", header="depth,load", comments="")
    (tmp_path / "empty.csv").touch()
    (tmp_path / "case.opts").write_text(CASE)
    words, expected = WORDS[name]
    with pytest.raises(SystemExit) as caught:
        fit.main(words)
    assert re.fullmatch(rf"error: [^\n]*{re.escape(expected)}[^\n]*", str(caught.value.code)), caught.value.code


def test_help(capsys):
    fit.main(["-help"])
    assert "-vary" in capsys.readouterr().out and (harness.ROOT / "scripts" / "fit.py").stat().st_mode & 0o100
