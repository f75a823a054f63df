"""Checks what is taken off measured curves: drift by a hold, the depth of the surface by three rules, the frame's compliance."""
import numpy as np
import pytest

import mlgimp
from made_curves import STIFFNESS, main, metal, refusal, text_of
from made_files import table
from mlgimp import corrections, drifts, load_depth, oliver_pharr, zeros

pytestmark = pytest.mark.fast

RATE = 0.05  # nm/s


def held(seconds=100, rate=RATE, noise=0.2, seed=0, place="unloading", slow=0.0):
    """A test with 10 rows a second and a hold at a tenth of the load in the unloading, or before the loading, with drift (nm/s) and noise
    (nm; slow: correlation of rows beside each other)."""
    ends = ([0, 10, 15, 24, 24 + seconds, 25 + seconds], [0, 10, 10, 1, 1, 0]) if place == "unloading" else (
        [0, 1, 1 + seconds, 11 + seconds, 16 + seconds, 26 + seconds], [0, 0.1, 0.1, 10, 10, 0])
    time = np.arange(0, ends[0][-1], 0.1)
    random = np.random.default_rng(seed)
    load = np.interp(time, *ends)
    falls = time >= ends[0][2 if place == "unloading" else 4]
    depth = np.where(falls, 0.42 + 0.08 * (load / 10) ** (1 / 1.4), 0.5 * np.sqrt(load / 10))
    white = random.normal(size=len(time))
    for k in range(1, len(white)):
        white[k] = slow * white[k - 1] + np.sqrt(1 - slow**2) * white[k]
    depth, load = depth + 1e-3 * rate * time + 1e-3 * noise * white, load + 0.002 * random.normal(size=len(time))
    return load_depth.Curve("held", time, depth, load, None, None, None, False, [])


@pytest.mark.parametrize("place", ["unloading", "loading"])
def test_drift_of_a_hold(expect, place):
    """Found within 5 %, and within the error that is said: a line through n rows in T seconds has one of noise sqrt(12/n)/T."""
    found = [drifts.drift_of(held(place=place, seed=seed)) for seed in range(20)]
    rates, errors = (np.array([getattr(each, name) for each in found]) for name in ("rate", "error"))
    expect("worst of 20", np.abs(rates / RATE - 1).max(), at_most=0.05)
    expect("error that is said, over theory", errors.mean() / (0.2 * np.sqrt(12 / 800) / 80), near=1, tolerance=0.1)
    expect("spread over the error that is said", rates.std() / errors.mean(), near=1, tolerance=0.5)  # 3 standard deviations of one of 20
    assert found[0].where == ("in the unloading" if place == "unloading" else "before the loading")


def test_error_of_a_drift_knows_slow_noise(expect):
    found = [drifts.drift_of(held(seed=seed, slow=0.9)) for seed in range(30)]
    expect("spread over the error that is said", np.std([each.rate for each in found]) / np.mean([each.error for each in found]), near=1, tolerance=0.45)


def test_curves_without_a_hold_for_drift():
    time = np.linspace(0, 30, 799)
    turn = np.concatenate([np.linspace(0, 10, 100), np.linspace(10, 1, 90), np.linspace(1, 10, 90), np.linspace(10, 0, 100)])
    turned = load_depth.Curve("turn", 0.1 * np.arange(380), 0.1 * turn, turn, None, None, None, False, [])
    for curve in (held(seconds=0.5), turned, load_depth.Curve("ramp", time, *metal(), None, None, None, False, [])):
        assert drifts.find(curve) is None
        with pytest.raises(mlgimp.ResultError, match="no drift can be found: there is no hold"):
            drifts.drift_of(curve)


def test_drift_by_the_command(tmp_path, capsys):
    """Auto takes it off, a number too, and without either a note tells of it."""
    curve = held()
    (tmp_path / "m.txt").write_text(table(["Time (s)", "Depth (nm)", "Load (mN)"], [curve.time, 1e3 * curve.depth, curve.load]))
    read = {drift: load_depth.read_measured(tmp_path / "m.txt", drift=drift) for drift in ("auto", RATE, None)}
    for drift in ("auto", RATE):
        assert read[drift].depth[-20:].mean() == pytest.approx(held(rate=0).depth[-20:].mean(), abs=1e-3 * 125 * 0.05 * RATE)
    assert "nm/s, of a hold at 1 mN in the unloading" in read["auto"].notes[0] and "is taken off" in read["auto"].notes[0]
    assert "is left in the depths; drift auto takes it off" in read[None].notes[0]
    main([str(tmp_path / "m.txt"), "--tip", "berkovich", "--drift", "auto"])
    assert "is taken off the depths" in capsys.readouterr().out
    (tmp_path / "n.csv").write_text(text_of(*metal()))
    assert "needs a column of times" in refusal(tmp_path / "n.csv", "--tip", "berkovich", "--drift", "auto")
    assert "needs a column of times" in refusal(tmp_path / "n.csv", "--tip", "berkovich", "--drift", "0.1")
    assert "must be a number, or auto" in refusal(tmp_path / "n.csv", "--drift", "none")
    with pytest.raises(mlgimp.Error, match="drift=nan: must be a number in nm/s, or auto"):
        load_depth.read_measured(tmp_path / "n.csv", drift=float("nan"))


def approach(exponent, noise, seed=1, rows=600):
    """A free tip over 0.25 um, a loading with an exponent to 0.5 um and 10 mN, and an unloading; the surface is at 0.25 um."""
    random = np.random.default_rng(seed)
    depth = np.concatenate([np.linspace(-0.25, 0, rows // 3, endpoint=False), np.linspace(0, 0.5, rows), np.linspace(0.5, 0.42, rows)[1:]])
    load = 10 * np.where(np.arange(len(depth)) < rows // 3 + rows, (np.maximum(depth, 0) / 0.5) ** exponent, np.maximum((depth - 0.42) / 0.08, 0) ** 1.4)
    return load_depth.Curve("approach", None, depth + 0.25, load + noise * random.normal(size=len(depth)), None, None, None, False, [])


@pytest.mark.parametrize("exponent", [1, 1.5, 2])
@pytest.mark.parametrize("rule", ["power", "threshold", "stiffness"])
def test_rules_for_the_depth_of_the_surface(expect, rule, exponent):
    """Each holds the truth within what it says, of the power law within four standard errors, without noise, with 0.03 and 0.3 % of the load."""
    for noise in (0, 0.003, 0.03):
        for seed in range(3):
            found = zeros.RULES[rule](approach(exponent, noise, seed))
            within = 4 * found.error + 2e-6 if rule == "power" else 1.1 * found.error
            expect(f"{noise}: off, over what is said", abs(found.depth - 0.25) / within, at_most=1)
            expect(f"{noise}: what is said", found.error, at_most=0.07)


def test_rules_by_the_command(tmp_path, capsys):
    curve = approach(1.5, 0.01)
    (tmp_path / "m.csv").write_text(text_of(curve.depth, curve.load))
    phrases = {"threshold": "where the load leaves that of the free tip by", "stiffness": "where the stiffness dP/dh leaves", "power": "power law",
            "auto": "power law"}
    for rule, words in phrases.items():
        main([str(tmp_path / "m.csv"), "--tip", "sphere", "--radius", "10", "--zero-depth", rule])
        assert words in capsys.readouterr().out
    assert "must be a number, or auto, power, threshold, stiffness" in refusal(tmp_path / "m.csv", "--zero-depth", "guess")
    (tmp_path / "n.csv").write_text(text_of(*metal()))
    for rule in ("threshold", "stiffness"):
        line = refusal(tmp_path / "n.csv", "--tip", "vickers", "--zero-depth", rule)
        assert f"no zero of depths can be found by its {rule}: there are no 10 rows of a free tip" in line


def test_compliance_of_the_frame(tmp_path):
    """h - C_f P gives the curve back that the frame was added to."""
    depth, load = metal()
    (tmp_path / "m.csv").write_text(text_of(depth + 1e-3 * 0.4 * load, load))
    read = load_depth.read_measured(tmp_path / "m.csv", frame_compliance=0.4)
    np.testing.assert_allclose(read.depth, depth, atol=1e-8)
    assert oliver_pharr.analyse(read)[0]["stiffness_mN_per_um"] == pytest.approx(STIFFNESS, rel=1e-5)
    assert "a frame with 0.4 nm/mN is taken off the depths" in read.notes
    assert "must be a number >= 0 in nm/mN" in refusal(tmp_path / "m.csv", "--tip", "vickers", "--frame-compliance", "-1")
    assert corrections.checked_frame(None) is None
