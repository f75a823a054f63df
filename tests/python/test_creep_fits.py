"""Checks fits of creep and relaxation on holds that are integrated step by step here: constants, intervals, warnings, refusals."""
import csv
import json
import math
import re

import numpy as np
import pytest

import fit
import mlgimp
from made_curves import CONE_OPTIONS, curve, write_run
from mlgimp import creep, creep_fits, tips
from mlgimp.errors import Error

pytestmark = pytest.mark.fast

CONE, BALL = tips.make_tip("cone", half_angle=80), tips.make_tip("sphere", radius=10.0)
SHAPES = {"cone": (CONE, {"half_angle": 80}), "ball": (BALL, {"radius": 10e-6})}
TWO = (0.3, 0.3), (2.0, 30.0)


def times_of(ramp, hold, rows=1200):
    """A ramp and a hold, in which rows are dense at first, s."""
    return np.concatenate([np.linspace(0, ramp, 400), (ramp + np.linspace(0, 1, rows) ** 2 * hold)[1:]])


def noisy(depth, load, time, tip, noise, seed):
    random = np.random.default_rng(seed)
    depth = depth + noise * depth.max() * random.normal(size=len(time))
    return curve(depth, load + noise * load.max() * random.normal(size=len(time)), tip=tip, time=time)


def norton(kind, exponent, noise=0.0, ramp=1.0, hold=100.0, seed=1):
    """s0 100 MPa, a0 1e-3/s under 1 mN: dh/dt = a a0 (p_m/(F s0))^n, by Runge and Kutta in the hold from the depth that the ramp has left."""
    tip, shape = SHAPES[kind]
    time, (constraint, cone, ball) = times_of(ramp, hold), creep.norton_factors(exponent)
    def rate(h):
        radius = cone * h * math.tan(math.radians(80)) if kind == "cone" else math.sqrt(2 * ball * 10e-6 * h)
        return radius * 1e-3 * (1e-3 / (math.pi * radius**2 * constraint * 1e8)) ** exponent
    depth = creep.norton_depth(ramp / (exponent + 1) * (time / ramp) ** (exponent + 1), 1e-3, 1e8, 1e-3, exponent, **shape)
    for row in range(400, len(time)):
        step, h = time[row] - time[row - 1], depth[row - 1]
        k1 = rate(h)
        k2 = rate(h + step * k1 / 2)
        k3 = rate(h + step * k2 / 2)
        depth[row] = h + step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(h + step * k3))
    return noisy(1e6 * depth, np.minimum(time / ramp, 1), time, tip, noise, seed)


def viscoelastic(kind, terms=TWO, held="load", noise=0.0, ramp=1.0, hold=100.0, seed=1, rows=1200):
    """E_0 3 GPa, nu 0.3: the law's own rate equations by the implicit rule of the middle, with a strain C h^m or a stress P/E*."""
    tip, shape = SHAPES[kind]
    factor, power = (4 / 3 * math.sqrt(10e-6), 1.5) if kind == "ball" else (2 / math.pi * math.tan(math.radians(80)), 2.0)
    time = np.union1d(times_of(ramp, hold, rows), np.linspace(0, ramp + hold, 20001))
    shares, lags = map(np.array, terms)
    given = np.minimum(time / ramp, 1) if held == "load" else (0.3 * np.minimum(time / ramp, 1)) ** power
    left, found, before = np.zeros(len(lags)), np.zeros(len(time)), 0.0
    for row in range(1, len(time)):
        step = time[row] - time[row - 1]
        part = step / (lags + step / 2)
        if held == "load":  # P = e - sum g a with a = left + part ((e + before)/2 - left)
            strain = (given[row] + shares @ (left + part * (before / 2 - left))) / (1 - shares @ part / 2)
        else:
            strain = given[row]
        left = left + part * ((strain + before) / 2 - left)
        found[row], before = strain if held == "load" else strain - shares @ left, strain
    places = np.searchsorted(time, times_of(ramp, hold, rows))
    time, given, found = time[places], given[places], found[places]
    modulus = 3e9 / (1 - 0.3**2)
    if held == "load":
        return noisy(1e6 * (1e-3 * found / (modulus * factor)) ** (1 / power), given, time, tip, noise, seed)
    return noisy(given ** (1 / power), 1e3 * modulus * factor * 1e-6**power * found, time, tip, noise, seed)


def held_by(found, truth):
    """How many of the intervals hold the truth."""
    return sum(found.lower[name] <= value <= found.upper[name] for name, value in truth.items())


# ---- Norton's law ----

@pytest.mark.parametrize("kind", SHAPES)
@pytest.mark.parametrize("exponent", [1, 2, 5, 20])
def test_norton_without_noise(expect, kind, exponent):
    found = mlgimp.fit_creep(norton(kind, exponent), "norton", creep_stress=1e8)
    expect("n", found.constants["creep_exponent"] / exponent - 1, near=0, tolerance=1e-3)
    expect("a0", found.constants["creep_rate_per_s"] / 1e-3 - 1, near=0, tolerance=3e-3)
    expect("log10 a0/s0^n", found.constants["log10_prefactor"], near=-3 - 8 * exponent, tolerance=2e-3 * exponent)


def test_norton_of_the_reference(expect):
    """The four depths of the reference, 80 degrees, 1 mN, s0 100 MPa, a0 1e-3/s, n 5, with depths between them along h^10 ~ t."""
    time = np.geomspace(1, 1000, 400)
    depth = np.exp(np.interp(np.log(time), np.log([1, 10, 100, 1000]), np.log([0.1257, 0.1583, 0.1993, 0.2509])))
    ramp = np.linspace(0, 1, 50)[:-1]
    made = curve(np.append(0.1257 * ramp**0.6, depth), np.append(ramp, np.ones(400)), tip=CONE, time=np.append(ramp, time))
    found = mlgimp.fit_creep(made, "norton", creep_stress=1e8)
    expect("n", found.constants["creep_exponent"], near=5, tolerance=0.02)
    expect("a0", found.constants["creep_rate_per_s"], near=1e-3, tolerance=2e-5)


def test_intervals_of_norton_hold_the_truth(expect):
    """Noise of 0.2 %, holds of 100 and of 1 s: 95 % of the intervals hold the truth, those of the short hold from resampled curves."""
    for hold, ramp, wide in ((100.0, 1.0, 0.05), (2.0, 10.0, 1.0)):
        count = 0
        for seed in range(10):
            found = mlgimp.fit_creep(norton("cone", 5, 2e-3, ramp, hold, seed), "norton", creep_stress=1e8)
            count += held_by(found, {"creep_exponent": 5, "creep_rate_per_s": 1e-3})
            expect("width of n", (found.upper["creep_exponent"] - found.lower["creep_exponent"]) / 5, at_most=wide)
        expect(f"intervals of 20 that hold the truth, hold of {hold:g} s", count, at_least=16)
        assert found.resampled == (hold < 10)


def test_exponent_of_a_short_hold(expect):
    """Of a tenth of the ramp: n and the time before the hold go together, and the fit says so."""
    found = mlgimp.fit_creep(norton("cone", 5, 2e-3, ramp=20.0, hold=2.0), "norton")
    assert any("time up to its start and exponent cannot be distinguished" in line for line in found.warnings), found.warnings
    assert found.resampled and abs(found.correlation[1, 2]) > 0.99 and found.lower["creep_exponent"] < 5 < found.upper["creep_exponent"]


def test_stress_of_the_prefactor(expect):
    """Another s0 is another a0 = B s0^n, and by default s0 is about that in the hold."""
    made = norton("ball", 3)
    one, other, own = (mlgimp.fit_creep(made, "norton", creep_stress=stress).constants for stress in (1e8, 2e8, None))
    expect("a0 of twice s0", other["creep_rate_per_s"] / one["creep_rate_per_s"], near=8, tolerance=0.02)
    expect("prefactor", own["log10_prefactor"], near=one["log10_prefactor"], tolerance=1e-6)
    radius = math.sqrt(2 * creep.norton_factors(3)[2] * 10 * made.depth.max())
    expect("s0", own["creep_stress_Pa"] / (1e9 / (math.pi * radius**2) / creep.norton_factors(3)[0]), near=1, tolerance=0.5)


# ---- Prony series ----

TRUTH = {"youngs_modulus_Pa": 3e9, "share_1": 0.3, "time_1_s": 2.0, "share_2": 0.3, "time_2_s": 30.0, "long_term_share": 0.4}


@pytest.mark.parametrize("held", ["load", "depth"])
@pytest.mark.parametrize("kind", SHAPES)
def test_prony_without_noise(expect, kind, held):
    found = mlgimp.fit_creep(viscoelastic(kind, held=held), "prony", terms=2, poisson=0.3)
    for name, value in TRUTH.items():
        expect(name, found.constants[name] / value - 1, near=0, tolerance=2e-3)
    assert found.hold.kind == held and "contact_modulus_Pa" in found.constants


def test_prony_of_the_reference(expect):
    """A ball of 10 um under 1 mN, E_0 3, E_inf 1 GPa, 5 s: numbers of an integration elsewhere, to which rows between are interpolated."""
    known = np.array([(0.5, 111.35), (1, 180.42), (2, 194.25), (5, 228.48), (10, 268.89), (30, 337.06), (100, 359.60)])
    made = viscoelastic("ball", ((2 / 3,), (5.0,)))
    expect("depths", np.max(np.abs(np.interp(known[:, 0], made.time, 1e3 * made.depth) / known[:, 1] - 1)), at_most=3e-4)
    found = mlgimp.fit_creep(made, "prony", poisson=0.3)
    for name, value in (("youngs_modulus_Pa", 3e9), ("share_1", 2 / 3), ("time_1_s", 5)):
        expect(name, found.constants[name] / value - 1, near=0, tolerance=2e-3)


@pytest.mark.parametrize("held", ["load", "depth"])
def test_intervals_of_prony_hold_the_truth(expect, held):
    """Noise of 0.2 % of both: 95 % of the intervals hold the truth, of 48 all but a few, and none is wide."""
    count = 0
    for seed in range(8):
        found = mlgimp.fit_creep(viscoelastic("ball", held=held, noise=2e-3, seed=seed), "prony", terms=2, poisson=0.3)
        count += held_by(found, TRUTH)
        expect("largest width", max((found.upper[name] - found.lower[name]) / value for name, value in TRUTH.items()), at_most=0.1)
    expect("intervals of 48 that hold the truth", count, at_least=40)


def test_shares_are_those_of_a_solid():
    """However far the law is off, shares are above 0 and their sum is below 1; the fit says that the shape is another."""
    found = mlgimp.fit_creep(norton("ball", 2), "prony", terms=2, poisson=0.3)
    shares = [found.constants["share_1"], found.constants["share_2"]]
    assert min(shares) > 0 and sum(shares) < 1 and found.constants["long_term_share"] == pytest.approx(1 - sum(shares))
    one = mlgimp.fit_creep(viscoelastic("ball")._replace(poisson=None), "prony", terms=1)
    assert any("is not of the law's shape" in line for line in one.warnings), one.warnings
    assert "youngs_modulus_Pa" not in one.constants and one.constants["contact_modulus_Pa"] > 0


def test_more_terms_than_a_hold_has():
    found = mlgimp.fit_creep(viscoelastic("ball", ((2 / 3,), (5.0,)), noise=2e-3), "prony", terms=2, poisson=0.3)
    assert any("hardly determined" in line or "cannot be distinguished" in line for line in found.warnings), found.warnings


def test_time_longer_than_the_hold():
    found = mlgimp.fit_creep(viscoelastic("ball", ((0.5,), (20.0,)), noise=1e-3, hold=5.0), "prony", poisson=0.3)
    assert any(re.match(r"time_1_s is .* longer than the hold of 5 s", line) for line in found.warnings), found.warnings


# ---- the command ----

def written(path, made, names=("time", "depth", "load")):
    np.savetxt(path, np.column_stack([made.time, made.depth, made.load]), delimiter=",", header=",".join(names), comments="")
    return str(path)


def test_command(tmp_path, capsys):
    """Files and lines of both laws, from curves that end in their hold."""
    path = written(tmp_path / "h.csv", norton("cone", 5, 1e-3))
    fit.main([path, "-creep", "norton", "-time", "time:s", "-tip", "cone", "-half_angle", "80", "-creep_stress", "1e8", "-output_dir", str(tmp_path / "n")])
    report, rows = json.loads((tmp_path / "n" / "fit.json").read_text()), list(csv.DictReader(open(tmp_path / "n" / "fit.csv")))
    assert report["law"] == "norton" and report["hold"]["constant"] == "load" and report["hold"]["end_s"] == pytest.approx(101)
    assert report["constants"]["creep_exponent"]["lower"] < 5 < report["constants"]["creep_exponent"]["upper"] and len(rows) > 50
    assert re.search(r"^creep_exponent [\d.]+, 95 % confidence [\d.]+ to [\d.]+$", capsys.readouterr().out, re.M)
    assert (tmp_path / "n" / "fit.png").stat().st_size > 1000 and float(rows[-1]["fitted_depth_um"]) == pytest.approx(float(rows[-1]["depth_um"]), rel=0.01)
    path = written(tmp_path / "r.csv", viscoelastic("ball", held="depth"))
    fit.main([path, "--creep", "prony", "-terms", "2", "-time", "time:s", "-tip", "sphere", "-radius", "10", "-poisson", "0.3", "-output_dir", str(tmp_path / "p")])
    report = json.loads((tmp_path / "p" / "fit.json").read_text())
    assert report["hold"]["constant"] == "depth" and report["constants"]["time_2_s"]["value"] == pytest.approx(30, rel=0.01)


def test_drift_is_taken_off(tmp_path, expect):
    made = norton("cone", 5)
    path = written(tmp_path / "h.csv", made._replace(depth=made.depth + 1e-4 * made.time))
    words = [path, "-creep", "norton", "-time", "time:s", "-tip", "cone", "-half_angle", "80", "-output_dir", str(tmp_path / "n")]
    for drift, tolerance, off in (("0.1", 0.01, 0), ("0", 0.4, -0.5)):
        fit.main([*words, "-drift", drift])
        found = json.loads((tmp_path / "n" / "fit.json").read_text())["constants"]["creep_exponent"]["value"]
        expect(f"n with {drift} nm/s", found - 5, near=off, tolerance=tolerance)


def test_a_run_has_its_tip_and_its_times(tmp_path, expect):
    """A result folder with test_time needs neither -tip nor -time."""
    made, folder = norton("cone", 5), write_run(tmp_path / "run", {**CONE_OPTIONS, "-indenter_half_angle": "80"})
    head = (folder / "history.csv").read_text().splitlines()[0]
    middle = np.append(0, made.time), np.append(0, made.depth), np.append(0, made.load)
    columns = dict.fromkeys(head.split(","), np.zeros(len(middle[0])))
    columns |= {"time": 1e-9 * np.arange(len(middle[0])), "depth": 1e-6 * middle[1], "load": 1e-3 * middle[2], "test_time": middle[0]}
    np.savetxt(folder / "history.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    found = mlgimp.fit_creep(folder, "norton", creep_stress=1e8)
    expect("n", found.constants["creep_exponent"], near=5, tolerance=0.05)


WORDS = {
    "no hold": (["up.csv", "-creep", "norton", "-time", "time:s", "-tip", "cone", "-half_angle", "80"], "has no hold"),
    "no time": (["n.csv", "-creep", "norton", "-tip", "cone", "-half_angle", "80"], "has no time of the test"),
    "no tip": (["h.csv", "-creep", "norton", "-time", "time:s"], "tip: must be given"),
    "flat punch": (["h.csv", "-creep", "norton", "-time", "time:s", "-tip", "flat_punch", "-radius", "1"], "tip=flat_punch: must be a ball"),
    "unknown tip": (["h.csv", "-creep", "norton", "-time", "time:s", "-tip", "needle"], "-tip needle: must be one of"),
    "unknown head": (["h.csv", "-creep", "norton", "-time", "clock:s", "-tip", "berkovich"], "there is no column clock"),
    "unit": (["h.csv", "-creep", "norton", "-time", "time:week", "-tip", "berkovich"], "-time time:week"),
    "no angle": (["h.csv", "-creep", "norton", "-time", "time:s", "-tip", "cone"], "-half_angle: must be given"),
    "size alone": (["h.csv", "-creep", "norton", "-time", "time:s", "-radius", "1"], "-radius: must stand beside -tip"),
    "unknown law": (["h.csv", "-creep", "garofalo", "-time", "time:s", "-tip", "berkovich"], "creep=garofalo: must be one of norton, prony"),
    "no law": (["h.csv", "-creep", "-time", "time:s"], "-creep (nothing): must be norton or prony"),
    "terms": (["h.csv", "-creep", "prony", "-terms", "0", "-time", "time:s", "-tip", "berkovich"], "-terms 0"),
    "many terms": (["h.csv", "-creep", "prony", "-terms", "9", "-time", "time:s", "-tip", "berkovich"], "terms=9: must be at most 5"),
    "stress": (["h.csv", "-creep", "norton", "-creep_stress", "-1", "-time", "time:s", "-tip", "berkovich"], "creep_stress=-1.0: must be a number > 0"),
    "drift without times": (["n.csv", "-creep", "norton", "-drift", "1", "-tip", "berkovich"], "a drift needs a column of times"),
    "depth": (["r.csv", "-creep", "norton", "-time", "time:s", "-tip", "sphere", "-radius", "10"], "has a hold of the depth"),
    "other options": (["h.csv", "-creep", "norton", "-time", "time:s", "-tip", "berkovich", "-vary", "E"], "-vary: must be left out"),
    "no file": (["none.csv", "-creep", "norton"], "there is no such file"),
    "folder": (["h.csv", "-creep", "norton", "-time", "time:s", "-tip", "cone", "-half_angle", "80", "-output_dir", "/dev/null/f"], "-output_dir"),
}


@pytest.mark.parametrize("name", WORDS)
def test_one_line(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    made, ramp = norton("cone", 5), np.linspace(0, 1, 500)
    written(tmp_path / "h.csv", made)
    written(tmp_path / "n.csv", made, ("step", "depth", "load"))
    written(tmp_path / "up.csv", curve(ramp, ramp**2, time=10 * ramp))
    written(tmp_path / "r.csv", viscoelastic("ball", held="depth", rows=300))
    words, expected = WORDS[name]
    with pytest.raises(SystemExit) as caught:
        fit.main(words)
    assert re.fullmatch(rf"error: [^\n]*{re.escape(expected)}[^\n]*", str(caught.value.code)), caught.value.code


def test_refusals_of_python():
    made = norton("cone", 5)
    for given, line in (({"law": "maxwell"}, "creep=maxwell"), ({"terms": 1.5}, "terms=1.5"), ({"poisson": 0.7}, "poisson=0.7"), ({"measured": 3}, "measured=3")):
        with pytest.raises(Error, match=line):
            mlgimp.fit_creep(**{"measured": made, "law": "prony", **given})
    with pytest.raises(Error, match="has unloadings before its hold"):
        time = np.append(np.linspace(0, 5, 200), 5 + made.time)
        before = 0.5 * np.sin(np.linspace(0, np.pi, 200))
        mlgimp.fit_creep(curve(np.append(before * made.depth[400], made.depth), np.append(before, made.load), tip=CONE, time=time), "prony")
    with pytest.raises(Error, match="are needed"):
        few = slice(None, None, 80)
        mlgimp.fit_creep(curve(made.depth[few], made.load[few], tip=CONE, time=made.time[few]), "prony", terms=5)
