"""Checks figures over the depth: of exact curves with a stiffness, of many unloadings, what is written, refusals."""
import csv
import json
import math

import numpy as np
import pytest

import mlgimp
from made_curves import curve, cycles_of, main, metal, refusal
from mlgimp import csm, load_depth, oliver_pharr, tips
from mlgimp.errors import Error

pytestmark = pytest.mark.fast

HARDNESS, REDUCED, EPSILON = 3.0, 70.0, 0.75  # GPa


def exact(rows=400, stiffness=1.0):
    """Depth (um), load (mN), stiffness (mN/um) of a body of the same hardness and modulus at each depth under a tip of 24.5 h^2, to 1 um,
    then an unloading without stiffness; P = H A(h_c), S = 2 Er sqrt(A/pi), h = h_c + epsilon P/S."""
    contact = np.linspace(0, 1, rows)
    area = 24.5 * contact**2
    load, own = HARDNESS * area, stiffness * 2 * REDUCED * np.sqrt(area / np.pi)
    depth = contact + EPSILON * load / np.maximum(own, 1e-12)
    down = np.linspace(depth[-1], 0.9 * depth[-1], rows // 2)[1:]
    back = load[-1] * ((down - down[-1]) / (depth[-1] - down[-1])) ** 1.5
    return np.append(depth, down), np.append(load, back), np.append(own, np.full(len(down), np.nan))


def text_of(depth, load, stiffness, unit="N/m", factor=1e3, blank="", decimal="."):
    """A file in nm, mN and a unit of the stiffness, which is left out or is a word where there is none."""
    lines = [f"Displacement (nm)\tLoad (mN)\tHarmonic Contact Stiffness ({unit})"]
    lines += ["\t".join(blank if math.isnan(value) else f"{value:.10g}" for value in row) for row in zip(1e3 * depth, load, factor * stiffness)]
    return "\n".join(lines).replace(".", decimal) + "\n"


WORDS = ["--area-function", "24.5", "--poisson", "0.3", "--depth", "Displacement:nm", "--load", "Load:mN"]


@pytest.mark.parametrize("unit, factor, blank, decimal", [("N/m", 1e3, "", "."), ("uN/nm", 1.0, "NaN", "."), ("mN/um", 1.0, "-", ","),
                                                          ("N/m", 1e3, "1.79769e+308", "."), ("\N{MICRO SIGN}N/nm", 1.0, "", ".")])
def test_hardness_and_modulus_of_an_exact_curve(tmp_path, capsys, expect, unit, factor, blank, decimal):
    """Units, empty and senseless cells as instruments write them, decimal commas."""
    (tmp_path / "m.txt").write_text(text_of(*exact(), unit, factor, blank, decimal), encoding="utf-8")
    main([str(tmp_path / "m.txt"), *WORDS, "--stiffness", f"Harmonic Contact Stiffness:{unit}"])
    rows = list(csv.DictReader(open(tmp_path / "csm.csv")))
    assert len(rows) == 399 and "hardness" in capsys.readouterr().out  # but for the first, without load
    for name, value in (("hardness_GPa", HARDNESS), ("reduced_modulus_GPa", REDUCED), ("modulus_GPa", 0.91 * REDUCED),
                        ("load_over_squared_stiffness_um2_per_mN", math.pi * HARDNESS / (4 * REDUCED**2))):
        seen = np.array([float(row[name]) for row in rows])
        expect(name, np.max(np.abs(seen / value - 1)), at_most=1e-6)
    [described] = json.loads((tmp_path / "indentation.json").read_text())["curves"]
    own = described["over_depth"]
    expect("mean hardness", own["hardness_GPa"], near=HARDNESS, tolerance=1e-6)
    assert own["hardness_GPa_deviation"] < 1e-6 and own["from_depth_um"] == pytest.approx(0.5 * exact()[0].max(), rel=1e-6) and (tmp_path / "csm.png").stat().st_size > 5000


def test_range_and_a_curve_without_unloading(tmp_path, capsys):
    """Figures over the depth need no unloading, which a row then says is missing."""
    depth, load, stiffness = (values[:400] for values in exact())
    (tmp_path / "m.txt").write_text(text_of(depth, load, stiffness))
    with pytest.raises(SystemExit) as caught:
        main([str(tmp_path / "m.txt"), *WORDS, "--stiffness", "3:N/m", "--csm-range", "200,300"])
    assert caught.value.code == 2 and "no unloading" in capsys.readouterr().out
    [described] = json.loads((tmp_path / "indentation.json").read_text())["curves"]
    assert described["over_depth"]["from_depth_um"] == pytest.approx(0.2) and described["over_depth"]["hardness_GPa"] == pytest.approx(HARDNESS)
    assert "no row lies between the depths of 5000 and 6000 nm" in refusal(tmp_path / "m.txt", *WORDS, "--stiffness", "3:N/m", "--csm-range", "5000,6000")


def test_many_unloadings(tmp_path):
    """Each unloading gives the stiffness at its depth: exact power laws, so that P/S^2 is the same at all depths but for the fits."""
    depth, load = cycles_of([1, 2, 4, 6, 8, 10], lowest=0.5)
    rows = oliver_pharr.analyse(curve(depth, load))
    found = csm.over_depth(curve(depth, load), rows)
    expected = load.max() / (10 * 1.4 / 0.08) ** 2  # of the last: P = 10 mN, S = m P/(h - hf)
    assert len(found.depth) == 6 and np.allclose(found.ratio, expected, rtol=1e-3) and np.allclose(found.hardness, found.hardness[0], rtol=1e-3)
    assert csm.over_depth(curve(*metal()), oliver_pharr.analyse(curve(*metal()))) is None
    np.savetxt(tmp_path / "m.csv", np.column_stack([depth, load]), delimiter=",", header="depth,load", comments="")
    main([str(tmp_path / "m.csv"), "--tip", "cone", "--half-angle", "70.3", "--csm"])
    assert len(list(csv.DictReader(open(tmp_path / "csm.csv")))) == 6


def test_from_python(tmp_path):
    (tmp_path / "m.txt").write_text(text_of(*exact()))
    read = mlgimp.read_measured(tmp_path / "m.txt", "Displacement:nm", "Load:mN", stiffness="Harmonic Contact Stiffness:N/m")
    found = csm.of_stiffness(read._replace(tip=tips.tip_of_function([24.5])), oliver_pharr.Constants(poisson=0.3))
    assert np.allclose(found.hardness, HARDNESS) and len(read.stiffness) == len(read.depth) and np.isnan(read.stiffness[-1])
    assert load_depth.read_measured(tmp_path / "m.txt", "1:nm", "2:mN").stiffness is None


@pytest.mark.parametrize("words, line", [
    (["--stiffness", "Harmonic Contact Stiffness:nm"], "must be COLUMN:UNIT with a unit of N/m"), (["--stiffness", "None:N/m"], "no column None"),
    (["--stiffness", "Harmonic Contact Stiffness:mN/um"], "is in N/m"), (["--csm-range", "1,2"], "--csm-range: needs --csm or --stiffness"),
    (["--csm-range", "2,1", "--csm"], "LOW,HIGH in nm"), (["--csm"], "a curve with 3 unloadings")])
def test_refusals(tmp_path, words, line):
    (tmp_path / "m.txt").write_text(text_of(*exact()))
    assert line in refusal(tmp_path / "m.txt", *WORDS, *words)


def test_a_stiffness_that_is_nowhere_above_zero():
    depth, load, stiffness = exact()
    with pytest.raises(Error, match="no row of the loading has a stiffness above zero"):
        csm.of_stiffness(curve(depth, load)._replace(stiffness=-np.nan_to_num(stiffness)))


def test_a_stiffness_is_known_by_its_head(tmp_path):
    """Without an option, in its unit; a column of zeros, as of a test without oscillations, is none."""
    depth = np.linspace(1, 500, 60)
    for stiffness, known in ((np.sqrt(depth), True), (np.zeros(60), False)):
        rows = "".join(f"{h}\t{1e-4 * h**2}\t{s}\n" for h, s in zip(depth, stiffness))
        (tmp_path / "m.txt").write_text("Displacement (nm)\tLoad (mN)\tHarmonic Contact Stiffness (mN/um)\n" + rows)
        read = mlgimp.read_measured(tmp_path / "m.txt")
        assert (read.stiffness is not None) == known
        assert not known or read.stiffness == pytest.approx(np.sqrt(depth[-len(read.stiffness):]))


def test_waves_of_cells_change_one_exponent_less_than_many(expect):
    """Unloadings of a run with waves of .3 % of the load: their stiffness over the square root of the load, which is the same at each."""
    depth, load = cycles_of([1, 2, 4, 6, 8, 10], lowest=0.5)
    run = curve(depth, load * (1 + 0.003 * np.sin(2 * np.pi * depth / 0.031)), is_run=True)
    rows = oliver_pharr.analyse(run)
    own, common = (found.stiffness / np.sqrt(found.load) for found in (csm.of_unloadings(rows), csm.over_depth(run, rows)))
    expect("scatter with a common exponent, of that with their own", np.std(common / np.mean(common)) / np.std(own / np.mean(own)), at_most=0.7)
    expect("mean, of the exact one", np.mean(common) / (10 * 1.4 / 0.08 / np.sqrt(10)), near=1, tolerance=0.02)
