"""Checks the command that analyses indentation tests: runs, measured curves beside them, what is written and printed, refusals."""
import csv
import json
import math
import re

import numpy as np
import pytest

import mlgimp
from made_curves import CONE_OPTIONS, GOOD, HALF, OPTIONS, QUARTER, STIFFNESS, curve, main, metal, refusal, text_of, write_run
from mlgimp import load_depth, oliver_pharr
from mlgimp.errors import ResultError
from mlgimp.pictures import plt
from test_scripts import HISTORY

pytestmark = pytest.mark.fast


# ---- runs ----

@pytest.mark.parametrize("options, parts, tip", [(OPTIONS, 2, None), (CONE_OPTIONS, 1, "cone"), (QUARTER, 4, "vickers"), (HALF, 2, "berkovich"),
                                                 ({**OPTIONS, "-indenter_tip": "1e-6,8e-06"}, 1, None), (None, 1, None)],
                         ids=["half in plane strain", "axisymmetric", "quarter", "half", "away from the side", "not known"])
def test_parts_of_a_tip(tmp_path, options, parts, tip):
    read = load_depth.read_run(write_run(tmp_path / "run", options))
    assert abs(read.load.max() / parts - 10) < 0.01 and abs(read.area[-1] - 3 * parts) < 1e-12
    assert (read.tip and read.tip.name) == tip and read.plane == (options is not None and options["-geometry"] == "plane_strain")
    assert any("equal parts" in note for note in read.notes) == (parts > 1)


@pytest.mark.parametrize("more, warned", [({}, False), ({"-gravity": "0,0"}, False), ({"-gravity": "0,-9.81"}, True), ({"-loads": "p"}, True)])
def test_loads_that_move_the_surface_are_noted(tmp_path, more, warned):
    read = load_depth.read_run(write_run(tmp_path / "run", {**CONE_OPTIONS, **more}))
    assert any("move the surface" in note for note in read.notes) == warned


def test_contact_above_the_surface_under_the_tip():
    """As on the rim of a hole, where hardness and modulus came out as NaN."""
    depth, load = metal()
    with pytest.raises(ResultError, match="the contact is above that"):
        oliver_pharr.analyse(curve(np.asarray(depth) - 2 * np.max(depth), load))


def test_run_to_files(tmp_path, capsys, expect):
    """Rows that a restart wrote twice do no harm; the files say the same."""
    folder = write_run(tmp_path / "run", CONE_OPTIONS, repeated=True)
    main([str(folder)])
    printed = capsys.readouterr().out
    [described] = json.loads((folder / "indentation.json").read_text())["curves"]
    [cycle], [row] = described["cycles"], list(csv.DictReader(open(folder / "indentation.csv")))
    assert described["tip"] == "cone" and float(row["hardness_GPa"]) == cycle["hardness_GPa"] and "beta" in printed
    expect("stiffness", cycle["stiffness_mN_per_um"] / STIFFNESS - 1, near=0, tolerance=2e-3)
    expect("beta", cycle["beta"], near=1.067, tolerance=5e-4)
    assert np.ptp(plt.imread(folder / "indentation.png")) > 0.5


def test_expected_errors(tmp_path, capsys):
    """Of runs, by how many cells are in contact; measured curves have none."""
    [row] = oliver_pharr.analyse(curve(*metal(), is_run=True))
    assert row["cells"] == 8 and row["expected_error"]["hardness_GPa"] == pytest.approx(0.3 / 8) and row["expected_error"]["true_area_um2"] == pytest.approx(0.6 / 8)
    assert row["expected_error"]["modulus_GPa"] == pytest.approx(0.3 / 8 + 1.09 / 20) and set(row["expected_error"]) < set(row)
    [measured] = oliver_pharr.analyse(curve(*metal()))
    assert math.isnan(measured["cells"]) and measured["expected_error"] is None and list(measured) == list(oliver_pharr.COLUMNS)
    folder = write_run(tmp_path / "run", CONE_OPTIONS)
    table = np.genfromtxt(folder / "history.csv", delimiter=",", names=True)
    half = np.where(table["depth"] > 0, 6e-7, 0)
    lines = (folder / "history.csv").read_text().splitlines()
    place = lines[0].split(",").index("contact_half_width")
    lines[1:] = [",".join([*line.split(",")[:place], repr(float(width)), *line.split(",")[place + 1:]]) for line, width in zip(lines[1:], half)]
    (folder / "history.csv").write_text("\n".join(lines) + "\n")
    summary = json.loads((folder / "summary.json").read_text()) | {"levels": [{"lower": [0, 0], "upper": [1, 1], "cell_size": 4e-7}, {"lower": [0, 0], "upper": [1, 1], "cell_size": 1e-7}]}
    (folder / "summary.json").write_text(json.dumps(summary))
    main([str(folder)])
    printed = capsys.readouterr().out
    [cycle] = json.loads((folder / "indentation.json").read_text())["curves"][0]["cycles"]
    [written] = csv.DictReader(open(folder / "indentation.csv"))
    assert cycle["cells"] == pytest.approx(6) and cycle["expected_error"]["load_mN"] == pytest.approx(0.3 / 6)
    assert cycle["expected_error"]["modulus_GPa"] == pytest.approx(0.3 / 6 + 1.09 * 6e-7 / 1e-5)  # the tip is on the axis
    assert re.search(r"^  hardness  .* GPa \+- 5 % by cells and block$", printed, re.M) and float(written["expected_error_true_hardness_GPa"]) == pytest.approx(0.6 / 6)


def test_slow_run(tmp_path, expect):
    """Of a run with -quasi_static the load is taken without inertia and damping."""
    [row] = oliver_pharr.analyse(load_depth.read_run(write_run(tmp_path / "run", CONE_OPTIONS, slow=True)))
    expect("load", row["load_mN"], near=10, tolerance=0.02)


def test_plane_strain_has_only_the_mean_pressure(tmp_path, capsys):
    folder = write_run(tmp_path / "run", OPTIONS)
    main([str(folder)])
    [cycle] = json.loads((folder / "indentation.json").read_text())["curves"][0]["cycles"]
    assert cycle["hardness_GPa"] is None and cycle["modulus_GPa"] is None and abs(cycle["true_hardness_GPa"] - 20 / 6) < 0.01
    assert "plane strain" in capsys.readouterr().out


# ---- measured curves ----

def test_measured_beside_a_run(tmp_path, capsys, expect):
    """In nm and uN, with drift and rows written twice; the tip is that of the run."""
    folder = write_run(tmp_path / "run", CONE_OPTIONS)
    depth, load = (np.repeat(each, 2) for each in metal())
    times = np.repeat(np.arange(len(depth) // 2), 2) * 0.1
    np.savetxt(tmp_path / "m.csv", np.column_stack([times, 1e3 * depth + 0.05 * times, 1e3 * load]), delimiter=",", header="t,h,F", comments="")
    main([str(folder), str(tmp_path / "m.csv"), "--depth", "h:nm", "--load", "F:uN", "--time", "t:s", "--drift", "0.05"])
    assert capsys.readouterr().out.count("  hardness") == 2
    run, measured = (each["cycles"][0] for each in json.loads((folder / "indentation.json").read_text())["curves"])
    for name in ("load_mN", "stiffness_mN_per_um", "hardness_GPa", "reduced_modulus_GPa"):
        expect(name, measured[name] / run[name] - 1, near=0, tolerance=5e-3)
    assert measured["modulus_GPa"] == pytest.approx(run["modulus_GPa"], rel=5e-3)  # with the run's Poisson's ratio


def test_measured_curves_have_no_cells(tmp_path, capsys):
    """A curve whose unloading is a line has no cells that could be smaller."""
    depth, load = metal(exponent=1)
    (tmp_path / "m.csv").write_text(text_of(depth, load))
    main([str(tmp_path / "m.csv"), "--tip", "vickers"])
    printed = capsys.readouterr().out
    assert "the exponent is at its limit 1" in printed and "cell" not in printed


def test_units_of_no_solid_give_a_warning(tmp_path, capsys):
    """Depths in nm read as um make a hardness of 1e-6 of it, loads in mN read as N one of 1000 times it."""
    (tmp_path / "m.csv").write_text(text_of(*metal()))
    for unit, warned in (("N", True), ("mN", False)):
        main([str(tmp_path / "m.csv"), "--tip", "berkovich", "--depth", "depth:um", "--load", f"load:{unit}"])
        assert ("is that of no solid" in capsys.readouterr().out) == warned


def test_a_modulus_that_is_not_known_is_said(tmp_path, capsys):
    """As of a film on a substrate with another Poisson's ratio; with --poisson the page has it too."""
    run = write_run(tmp_path / "run", {**CONE_OPTIONS, "-s_poissons_ratio": "0.2"})
    main([str(run)])
    assert "note: there is no modulus of the specimen" in capsys.readouterr().out
    main([str(run), "--poisson", "0.25", "--report"])
    printed = capsys.readouterr().out
    assert "no modulus of the specimen" not in printed and "specimen's modulus" in printed
    assert re.search(r"Poisson(&#x27;|')s ratio</t[dh]><td[^>]*>0.25<", (run / "indentation.html").read_text())


def test_a_run_without_an_unloading_says_how_to_get_one():
    depth, load = metal()
    with pytest.raises(ResultError, match="there is no unloading.*-indenter_unload_velocity"):
        oliver_pharr.analyse(curve(depth[:400], load[:400], is_run=True))


def test_tips_by_name(tmp_path, capsys):
    """A tip that -presets lists, with its sizes; one that is given counts more; a name in other capitals leads to the right one."""
    (tmp_path / "m.csv").write_text(GOOD)
    areas = []
    for words in (["berkovich_R50"], ["berkovich", "--tip-radius", "0.05"], ["berkovich_R50", "--tip_radius", "0.1"]):
        main([str(tmp_path / "m.csv"), "-tip", *words])
        areas.append(re.search(r"area +(\S+) um2", capsys.readouterr().out)[1])
    assert areas[0] == areas[1] != areas[2]
    assert "--tip Berkovich_R50: must be berkovich_R50, which is nearest" in refusal(tmp_path / "m.csv", "--tip", "Berkovich_R50")


# ---- refusals ----

WORDS = {
    "no curve": [], "no such file": ["none.csv"], "tip not known": ["m.csv"], "cone without angle": ["m.csv", "--tip", "cone"],
    "sphere without radius": ["m.csv", "--tip", "sphere"], "unknown tip": ["m.csv", "--tip", "brinell"],
    "two tips": ["m.csv", "--tip", "vickers", "--area-function", "24.5"],
    "window upside down": ["m.csv", "--tip", "vickers", "--window", "0.9,0.5"], "empty window": ["m.csv", "--tip", "vickers", "--window", "0.96,0.961"],
    "unit": ["m.csv", "--tip", "vickers", "--depth", "depth:inch"], "no unit": ["m.csv", "--tip", "vickers", "--load", "load"],
    "Poisson's ratio": ["m.csv", "--tip", "vickers", "--poisson", "0.7"], "beta": ["m.csv", "--tip", "vickers", "--beta", "0"],
    "drift without time": ["m.csv", "--tip", "vickers", "--drift", "0.1"], "area function": ["m.csv", "--area-function", "24.5,x"],
    "out": ["m.csv", "--tip", "vickers", "--out", "/dev/null/none"],
    "modulus in Pa": ["m.csv", "--tip", "vickers", "--tip-elastic", "1141e9,0.07"],
    "angle of another tip": ["m.csv", "--tip", "berkovich", "--half-angle", "30"],
    "radius of another tip": ["m.csv", "--tip", "berkovich", "--radius", "5"],
    "faces of another tip": ["m.csv", "--tip", "vickers", "--faces", "3"],
    "size without a tip": ["m.csv", "--area-function", "24.5", "--radius", "5"],
    "rounded sphere": ["m.csv", "--tip", "sphere", "--radius", "5", "--tip-radius", "0.1"],
    "tip radius in m": ["m.csv", "--tip", "vickers", "--tip-radius", "1e-7"],
    "radius in m": ["m.csv", "--tip", "sphere", "--radius", "5e-6"],
}


@pytest.mark.parametrize("name", WORDS)
def test_words(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.csv").write_text(GOOD)
    refusal(*WORDS[name])


@pytest.mark.parametrize("given, line", [
    ({"poisson": 33}, "poisson=33: must be in"), ({"poisson": 0.7}, "poisson=0.7"), ({"poisson": 1.0}, "poisson=1.0"),
    ({"poisson": "0.3"}, "not as a text"), ({"epsilon": -1}, "epsilon=-1"), ({"beta": math.nan}, "beta=nan"),
    ({"window": (0.98, 0.2)}, "LOW < HIGH"), ({"window": 0.5}, "LOW < HIGH"),
    ({"tip_modulus": 1141e9}, "1141 GPa are 1141, not 1141e9"),
    ({"tip_poisson": 0.6}, "tip_poisson=0.6"), ({"foo": 1}, "foo: must be one of window, epsilon")])
def test_constants_from_python(tmp_path, given, line):
    """Python takes no constants that the command refuses."""
    run = mlgimp.read(write_run(tmp_path / "run", CONE_OPTIONS))
    with pytest.raises(mlgimp.Error, match=line):
        run.oliver_pharr(**given)
    good = {"poisson": np.float32(0.3), "window": "0.4,0.9", "tip_modulus": np.array(1141), "tip_poisson": 0.07, "epsilon": None}
    assert math.isfinite(run.oliver_pharr(**good)[0]["modulus_GPa"])


def test_folders(tmp_path):
    assert "history.csv" in refusal(tmp_path)
    (tmp_path / "history.csv").write_text(",".join(HISTORY) + "\n")
    assert "history.csv has 0 rows" in refusal(tmp_path)
    folder = write_run(tmp_path / "run", {**CONE_OPTIONS, "-indenter_half_angle": "steep"})
    assert "summary.json" in refusal(folder)
    (folder / "summary.json").unlink()
    assert "--tip" in refusal(folder)
