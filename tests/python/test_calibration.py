"""Checks the calibration of area function and frame: a series of exact curves gives both back, and the analysis by them the modulus."""
import json
import math
import re
import runpy

import numpy as np
import pytest

import harness
import mlgimp
from made_curves import main, metal, refusal, text_of
from made_files import table
from mlgimp import calibration, load_depth, oliver_pharr, tips

pytestmark = pytest.mark.fast

calibrate_main = runpy.run_path(str(harness.ROOT / "scripts" / "calibrate.py"))["main"]
SHARP = [32.9049, -6418.303798, 288484.8518, -989287.0625, 103588.5588, 675977.3345]  # a vendor's, in nm: that of no tip below 17 nm
TIP = tips.tip_of_function(SHARP)
REDUCED = 1 / ((1 - 0.17**2) / 72 + (1 - 0.07**2) / 1141)  # of fused silica and diamond
FRAME = 1 / 3  # nm/mN: 3 N/um
DEPTHS = np.geomspace(0.05, 1, 10)  # um, of the contact


def silica(contact_depth, hardness=9.5, frame=FRAME, noise=0.0, seed=0, rows=300):
    """A curve that has exactly the contact depth, the hardness and the modulus, beside a frame: depths (um) and noise (nm)."""
    area = float(TIP.area(contact_depth))
    load, stiffness, exponent = hardness * area, 2 * REDUCED * math.sqrt(area / math.pi), 1.3
    top = contact_depth + 0.75 * load / stiffness
    final = top - exponent * load / stiffness
    up, down = np.linspace(0, top, rows), np.linspace(top, final, rows)[1:]
    depth, loads = np.append(up, down), np.append(load * (up / top) ** 1.9, load * np.maximum((down - final) / (top - final), 0) ** exponent)
    depth = depth + 1e-3 * frame * loads + 1e-3 * noise * np.random.default_rng(seed).normal(size=len(depth))
    return load_depth.Curve(f"silica {1e3 * contact_depth:.0f}", None, depth, loads, None, None, None, False, [])


def off(found, low=DEPTHS[0]):
    """By how much the area function misses the tip's most, over the calibrated range."""
    depths = np.geomspace(low, DEPTHS[-1], 200)
    return np.abs(tips.tip_of_function(found.coefficients).area(depths) / TIP.area(depths) - 1).max()


def test_exact_series(expect):
    """Area function and frame are found back: to rounding, as nothing in it is approximate."""
    found = mlgimp.calibrate([silica(depth) for depth in DEPTHS])
    expect("area", off(found), at_most=1e-6)
    expect("frame", found.frame / FRAME - 1, near=0, tolerance=1e-6)
    expect("hardness", found.hardness, near=9.5, tolerance=1e-6)
    assert found.shown.all() and found.depths == pytest.approx((50, 1000), rel=1e-6)


def test_series_with_noise(expect):
    """0.2 nm of noise: the area within 2 and the frame within 3 %, and four of its standard errors."""
    for seed in range(4):
        found = mlgimp.calibrate([silica(depth, noise=0.2, seed=10 * seed + k) for k, depth in enumerate(np.geomspace(0.1, 1, 10))])
        expect("area", off(found, 0.1), at_most=0.02)
        expect("frame", found.frame / FRAME - 1, near=0, tolerance=0.03)
        expect("frame over its error", abs(found.frame - FRAME) / found.frame_error, at_most=4)


def test_a_hardness_that_falls_at_small_depths(expect):
    """As under a rounded tip: those depths do not count for the frame, but they do for the area."""
    found = mlgimp.calibrate([silica(depth, hardness=9.5 - 2 * math.exp(-depth / 0.03)) for depth in DEPTHS])
    assert not found.shown[0] and found.shown[-5:].all()
    expect("area", off(found), at_most=0.02)
    expect("frame", found.frame / FRAME - 1, near=0, tolerance=0.03)


def test_depths_without_a_frame():
    """None is found, and none below zero; one that is known is taken off."""
    free = mlgimp.calibrate([silica(depth, frame=-0.01) for depth in DEPTHS])
    assert free.frame == 0
    known = mlgimp.calibrate([silica(depth) for depth in DEPTHS], frame_compliance=FRAME)
    assert known.frame == pytest.approx(FRAME) and off(known) < 1e-6


def test_curves_of_files(tmp_path):
    """A path, paths and Curves are the same."""
    files = write_series(tmp_path)
    curves = [curve for file in files for curve in mlgimp.read_tests(file)]
    assert mlgimp.calibrate(files).coefficients == mlgimp.calibrate(curves).coefficients
    assert len(calibration.curves_of(files[0])) == len(calibration.curves_of(curves[0])) == 1
    with pytest.raises(mlgimp.Error, match="curves=3: must be load_depth.Curves or paths of files"):
        mlgimp.calibrate(3)


def test_refusals():
    series = [silica(depth) for depth in DEPTHS]
    with pytest.raises(mlgimp.Error, match="at least 3 different depths; there are 2"):
        mlgimp.calibrate([silica(0.1)] * 2)
    refused = (({"modulus": 72e9}, "modulus=.*must be in"), ({"coefficients": 0}, "coefficients=0: must be"),
               ({"coefficients": 12}, "coefficients=12: must be"), ({"window": (0.9, 0.2)}, "window=.*LOW < HIGH"),
               ({"reduced_modulus": -1}, "reduced_modulus=-1: must be"), ({"frame_compliance": 3.4}, "gives way more than"))
    for given, words in refused:
        with pytest.raises(mlgimp.Error, match=words):
            mlgimp.calibrate(series, **given)


def write_series(folder):
    for number, depth in enumerate(DEPTHS):
        curve = silica(depth)
        (folder / f"silica_{number}.txt").write_text(table(["Depth (nm)", "Load (mN)"], [1e3 * curve.depth, curve.load]))
    return [str(path) for path in sorted(folder.glob("silica_*.txt"))]


def test_commands_close(tmp_path, capsys):
    """What the one writes gives the other the modulus and the hardness of the series, within the nine digits of its files."""
    files = write_series(tmp_path)
    calibrate_main(files)
    printed = capsys.readouterr().out
    assert re.search(r"frame: 0\.333\d \+- \S+ nm/mN \(3 N/um\), of 10 depths with a hardness of 9\.5 GPa", printed), printed
    assert (tmp_path / "calibration.png").stat().st_size > 1000
    main([*files, "--calibration", str(tmp_path / "calibration.json"), "--poisson", "0.17", "--tip-elastic", "1141,0.07"])
    for test in json.loads((tmp_path / "indentation.json").read_text())["curves"]:
        [row] = test["cycles"]
        assert any(re.match(r"below 50 nm the area function is not calibrated, or that of no tip, and is continued by a power", note) for note in test["notes"])
        assert row["modulus_GPa"] == pytest.approx(72, rel=2e-4) and row["hardness_GPa"] == pytest.approx(9.5, rel=2e-4)
        assert "a frame with 0.3333 nm/mN is taken off the depths" in test["notes"]


def test_a_series_with_an_aborted_test(tmp_path, capsys):
    """It is left out with a line; the others calibrate."""
    files = write_series(tmp_path)
    (tmp_path / "silica_3.txt").write_text("\n".join((tmp_path / "silica_3.txt").read_text().splitlines()[:200]))
    calibrate_main([*files, str(tmp_path / "none.txt")])
    printed = capsys.readouterr().out
    assert "left out: silica_3.txt: there is no unloading" in printed and "none.txt: cannot be read as text" in printed
    assert len(json.loads((tmp_path / "calibration.json").read_text())["tests"]) == 9


def test_files_that_are_no_calibration(tmp_path, capsys):
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    for content in ("{}", "[1", '{"area_function_nm": [], "frame_compliance_nm_per_mN": 1, "contact_depths_nm": [1, 2]}',
                    '{"area_function_nm": ["x"], "frame_compliance_nm_per_mN": 1, "contact_depths_nm": [1, 2]}'):
        (tmp_path / "c.json").write_text(content)
        assert "is no calibration" in refusal(tmp_path / "m.csv", "--calibration", tmp_path / "c.json")
    assert "cannot be read" in refusal(tmp_path / "m.csv", "--calibration", tmp_path / "none.json")
    (tmp_path / "c.json").write_text('{"area_function_nm": [24.5], "frame_compliance_nm_per_mN": 0, "contact_depths_nm": [50, 300]}')
    assert "is beyond 300 nm, the largest to which the tip was calibrated" in refusal(tmp_path / "m.csv", "--calibration", tmp_path / "c.json")
    (tmp_path / "c.json").write_text('{"area_function_nm": [24.5], "frame_compliance_nm_per_mN": 0, "contact_depths_nm": [480, 600]}')
    main([str(tmp_path / "m.csv"), "--calibration", str(tmp_path / "c.json")])
    assert "below 480 nm, the least to which the tip was calibrated: the area is not sure" in capsys.readouterr().out
    assert "must stand without each other and without --tip" in refusal(tmp_path / "m.csv", "--calibration", tmp_path / "c.json", "--tip", "vickers")


# ---- area functions that are those of no tip ----

def test_continued_area_function():
    """A and A' go on at h_m, A grows from zero, between a paraboloid and a cone; a function that is that of a tip stays as it is."""
    start = 1e3 * TIP.repaired
    assert 15 < start < 20
    h = 1e-3 * start
    slopes = [(float(TIP.area(h + side * 1e-6)) - float(TIP.area(h))) / (side * 1e-6) for side in (-1, 1)]
    assert slopes[0] == pytest.approx(slopes[1], rel=1e-3) and float(TIP.area(h - 1e-9)) == pytest.approx(float(TIP.area(h)), rel=1e-5)
    depths = np.geomspace(1e-5, h, 100)
    powers = np.diff(np.log(TIP.area(depths))) / np.diff(np.log(depths))
    assert np.all((powers >= 1) & (powers <= 2.05)) and float(TIP.area(0)) == 0
    for plain in ([24.5], [24.5, 1000], [0, 628]):
        assert tips.tip_of_function(plain).repaired == 0 and float(tips.tip_of_function(plain).area(0.1)) == pytest.approx(1e-6 * tips.polynomial(plain, 100))


def test_contact_near_the_continued_part_is_warned_of():
    curve = silica(0.03, frame=0)._replace(tip=TIP)
    [row] = oliver_pharr.analyse(curve)
    assert "the area function is that of no tip below 16" in row["warnings"] and row["contact_depth_um"] == pytest.approx(0.03, rel=1e-4)
    [row] = oliver_pharr.analyse(silica(0.3, frame=0)._replace(tip=TIP))
    assert row["warnings"] == ""
