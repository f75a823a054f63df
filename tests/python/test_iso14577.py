"""Checks the numbers of ISO 14577 and the hardness scales, against published values and formulas that are written here a second time."""
import csv
import math

import numpy as np
import pytest

from made_curves import curve, main, metal, text_of
from made_files import columns, fischer
from mlgimp import cycles, iso14577, load_depth, oliver_pharr, tips

pytestmark = pytest.mark.fast

ISO = oliver_pharr.checked_constants(iso=True, poisson=0.3, tip_modulus=1141.0, tip_poisson=0.07)


@pytest.mark.parametrize("exponent, value", [(1, 1), (1.2, 0.79), (1.3, 0.77), (1.5, 0.75), (2, 2 - 4 / math.pi)])
def test_epsilon(exponent, value):
    """1 of a punch, 3/4 of a paraboloid and 2 - 4/pi of a cone are exact; those between are in Pharr and Bolshakov's table with two digits."""
    assert iso14577.epsilon(exponent) == pytest.approx(value, abs=0.005 if exponent in (1.2, 1.3) else 1e-12)


@pytest.mark.parametrize("kind, over_depth, over_contact", [("vickers", 26.429, 24.504), ("berkovich", 26.968, 24.494)])
def test_numbers_of_pyramids(kind, over_depth, over_contact):
    """HM, H_IT and E_IT of an exact curve from the areas of the faces over h^2 and of the section over h_c^2, written out here."""
    [row] = oliver_pharr.analyse(curve(*metal(rows=2000), tip=tips.make_tip(kind)), ISO)
    stiffness, epsilon = 175.0, iso14577.epsilon(1.4)
    contact = 0.5 - epsilon * 10 / stiffness
    area = over_contact * contact**2
    reduced = math.sqrt(math.pi) * stiffness / (2 * math.sqrt(area))
    strain = 1 / (1 / reduced - (1 - 0.07**2) / 1141)
    martens = 10 / (over_depth * 0.25)
    expected = {"HM_GPa": martens, "HMs_GPa": martens, "H_IT_GPa": 10 / area, "E_IT_plane_strain_GPa": strain,
                "E_IT_GPa": (1 - 0.09) * strain, "HV": 94.5 * 10 / area, "eta_IT_percent": 100 * (10 * 0.08 / 2.4) / (10 * 0.5 / 3),
                "epsilon": epsilon, "beta": 1}
    for name, value in expected.items():
        assert row[name] == pytest.approx(value, rel=2e-4), name
    assert all(math.isnan(row[name]) for name in ("HBW", "HRC", "HRB"))


def test_martens_of_the_slope_knows_no_zero_of_depths():
    depth, load = metal(rows=2000)
    made = curve(depth + 0.02, load, tip=tips.make_tip("vickers"))
    [cycle] = cycles.find_cycles(made)
    assert iso14577.martens_of_slope(made, cycle, 10, 26.429) == pytest.approx(10 / (26.429 * 0.25), rel=1e-4)


def test_only_with_iso():
    [row] = oliver_pharr.analyse(curve(*metal(), tip=tips.make_tip("vickers")))
    assert all(math.isnan(row[name]) for name in iso14577.COLUMNS) and row["epsilon"] == 0.75 and row["beta"] == 1.012


def test_what_the_user_chooses_counts_more():
    chosen = oliver_pharr.checked_constants(iso=True, window=(0.2, 0.9), epsilon=0.72, beta=1.05)
    assert chosen.window == (0.2, 0.9) and oliver_pharr.checked_constants(iso=True).window == iso14577.WINDOW
    [row] = oliver_pharr.analyse(curve(*metal(), tip=tips.make_tip("vickers")), chosen)
    assert row["epsilon"] == 0.72 and row["beta"] == 1.05


@pytest.mark.parametrize("across, value", [(2.5, 601), (3.0, 415), (4.0, 229), (5.0, 143)])
def test_brinell(across, value):
    """Known values of the table of HBW 10/3000 over the diameter of the imprint in mm, rounded to whole numbers."""
    found = iso14577.brinell(3000 / 0.102 * 1e3, 5000, math.pi / 4 * (1e3 * across) ** 2)
    assert found == pytest.approx(value, abs=0.6)


def test_brinell_of_a_test():
    """The contact's diameter is that of the tip at the contact depth; of a run that of its true area."""
    ball = tips.make_tip("sphere", radius=10)
    made = curve(*metal(), tip=ball)
    [row] = oliver_pharr.analyse(made, ISO)
    d, big = 2 * math.sqrt(row["area_um2"] / math.pi), 20.0
    assert row["HBW"] == pytest.approx(0.102 * 2 * 10e-3 / (math.pi * big * (big - math.sqrt(big**2 - d**2)) * 1e-6), rel=1e-9)
    [row] = oliver_pharr.analyse(made._replace(area=np.full(len(made.depth), 30.0)), ISO)
    d = 2 * math.sqrt(30 / math.pi)
    assert row["HBW"] == pytest.approx(0.102 * 2 * 10e-3 / (math.pi * big * (big - math.sqrt(big**2 - d**2)) * 1e-6), rel=1e-9)


def rockwell(total, rest, tip, preload=98.07e3, ends=1.0):
    """A test with a preload, a whole load (mN) and the preload again, `rest` um deeper than before."""
    up = np.linspace(0, 1, 200)
    depth = np.concatenate([40 * up[:-1], np.full(20, 40.0), 40 + (rest + 60) * up[1:], np.full(20, 100.0 + rest), 100 + rest - 60 * up[1:]])
    load = np.concatenate([preload * up[:-1], np.full(20, preload), preload + (total - preload) * up[1:], np.full(20, total),
                           total + (ends * preload - total) * up[1:] ** 0.8])
    return curve(depth, load, tip=tip)


DIAMOND, BALL = tips.make_tip("cone", half_angle=60, tip_radius=200), tips.make_tip("sphere", radius=1587.5 / 2)


@pytest.mark.parametrize("scale, total, tip, value", [("HRC", 1471e3, DIAMOND, 100 - 80 / 2), ("HRB", 980.7e3, BALL, 130 - 80 / 2)])
def test_rockwell(scale, total, tip, value):
    [row] = oliver_pharr.analyse(rockwell(total, 80, tip), ISO)
    assert row[scale] == pytest.approx(value, abs=0.5)
    assert math.isnan(row["HRB" if scale == "HRC" else "HRC"])


@pytest.mark.parametrize("made", [rockwell(1471e3, 80, BALL), rockwell(600e3, 80, DIAMOND), rockwell(1471e3, 80, DIAMOND, ends=3),
                                  rockwell(1471e3, 80, tips.make_tip("cone", half_angle=70, tip_radius=200)), rockwell(1471e3, 80, tips.make_tip("vickers"))],
                         ids=["ball", "load", "not back to the preload", "another angle", "pyramid"])
def test_no_rockwell_without_its_test(made):
    [row] = oliver_pharr.analyse(made, ISO)
    assert math.isnan(row["HRC"]) and math.isnan(row["HRB"])


def test_by_the_command(tmp_path, capsys):
    """The columns are the last of indentation.csv, and the figures are printed."""
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    main([str(tmp_path / "m.csv"), "--tip", "vickers", "--poisson", "0.3", "--tip-elastic", "1141,0.07", "--iso"])
    printed = capsys.readouterr().out
    for name in ("HM ", "HMs ", "H_IT ", "E_IT ", "E_IT/(1 - nu^2) ", "eta_IT ", "HV "):
        assert f"  {name}" in printed
    [row] = csv.DictReader(open(tmp_path / "indentation.csv"))
    assert list(row)[-len(iso14577.COLUMNS):] == list(iso14577.COLUMNS)
    assert float(row["HM_GPa"]) == pytest.approx(10 / (26.429 * 0.25), rel=1e-3) and row["HBW"] == ""


def test_of_a_measured_file_as_of_a_run(tmp_path):
    """One code: the same rows give the same numbers."""
    (tmp_path / "m.txt").write_text(fischer(1))
    tip = tips.make_tip("vickers")
    measured = load_depth.read_measured(tmp_path / "m.txt")._replace(tip=tip, poisson=0.3)
    time, depth, load = columns()
    run = curve(depth, load, tip=tip, is_run=True)
    [one], [other] = (oliver_pharr.analyse(each, ISO) for each in (measured, run))
    assert all(one[name] == pytest.approx(other[name], rel=1e-4, nan_ok=True) for name in iso14577.COLUMNS)
