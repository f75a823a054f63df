"""What -check says of a case before it runs, which is what the run then is; nothing is written."""
import json
import time

import numpy
import pytest

import harness
import mlgimp
from mlgimp import case_check
from refusals import Table, expect_refused

CASE = {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "12um,12um", "cell_size": "500nm", "boundary_y_lower": "symmetry",
        "levels": "2", "level_1_lower": "0,6um", "level_1_upper": "6um,12um", "materials": "m", "m_preset": "copper_ofhc", "bodies": "block",
        "block_lower": "0,0", "block_upper": "12um,10um", "indenter": "cone", "indenter_half_angle": "70.3deg", "indenter_tip": "0,10um",
        "indenter_max_depth": "200nm", "indenter_times": "0", "indenter_velocities": "50m/s", "history_interval": "50"}


def facts(folder, ranks=1, **more):
    words = harness.command(harness.to_arguments({**CASE, "check": "json", "output_dir": folder / "out", **more}), ranks)
    done = harness.subprocess.run(words, capture_output=True, text=True, env=harness.environment(ranks), cwd=folder)
    assert done.returncode == 0, done.stderr
    assert not list(folder.iterdir())
    return json.loads(done.stdout)


def test_facts(tmp_path):
    """They are those of the run, and the same on three ranks but for the clock."""
    found, on_three = facts(tmp_path), facts(tmp_path, 3)
    run = harness.run(CASE)
    levels = run.summary["levels"]
    assert found["steps"] == pytest.approx(run.summary["steps"], rel=0.06) and found["steps"] > 50
    assert found["finest_steps"] == 2 * found["steps"] and found["time_step"] == pytest.approx(levels[0]["time_step"], rel=0.06)
    assert sum(level["points"] for level in found["levels"]) == run.history["points"][0] and found["end_time"] == pytest.approx(4e-9)
    contact = found["contact"]
    assert contact["depth"] == pytest.approx(200e-9) and contact["cells"] == pytest.approx(200e-9 * numpy.tan(numpy.radians(70.3)) / 250e-9)
    assert contact["load_error"] == pytest.approx(0.3 / contact["cells"]) and found["seconds"] > 0
    assert contact["block_error"] == pytest.approx(1.09 * contact["half_width"] / 12e-6)
    assert any("copper_ofhc" in note for note in found["notes"]) and any("inertia" in line for line in found["warnings"])
    clock = "seconds", "seconds_per_step", "ranks", "bytes_per_rank"
    assert {key: value for key, value in found.items() if key not in clock} == {key: value for key, value in on_three.items() if key not in clock}


def test_errors_by_cells_are_those_of_the_analysis():
    from mlgimp import oliver_pharr
    source = (harness.ROOT / "src" / "program" / "run" / "check.cpp").read_text()
    assert f"kLoadError = {oliver_pharr.EDGE}, kAreaError = {oliver_pharr.AREA}, kBlockError = {oliver_pharr.STIFFER};" in source


@pytest.mark.parametrize("changes, where, line", [
    ({"indenter_half_angle": "45deg"}, "warnings", "half the contact's width is at most 0.8 cells of level 1, fewer than 6"),
    ({"cell_size": "250nm", "level_1_upper": "1um,12um", "indenter_half_angle": "80deg"}, "warnings", "contact crosses a border of levels by time 4e-09 s, "
     "half its width being 9.074 cells of level 1 and 4.537 of level 0"),
    ({"boundary_x_upper": "symmetry", "geometry": "plane_strain", "indenter": "wedge", "indenter_tip": "11.5um,10um", "level_1_lower": "6um,6um", "level_1_upper": "12um,12um"}, "warnings",
     "contact has reached x_upper"),
    ({"indenter_max_depth": "6um", "level_1_lower": "0,2um", "indenter_half_angle": "30deg"}, "warnings", "the largest depth is 60 % of the height"),
    ({"domain_upper": "12um,20um", "indenter_tip": "0,10.6um"}, "notes", "the tip starts 600 nm above the body: 75 % of the time goes by"), ({}, "notes", None)],
    ids=["few cells", "border", "mirror", "deep", "far above", "nothing of these"])
def test_what_the_run_will_meet(tmp_path, changes, where, line):
    """Warnings of the run that follow from its largest depth, in its words, and a long way to the body."""
    found = facts(tmp_path, **changes)
    if line:
        assert any(line in each for each in found[where]), found[where]
        return
    assert facts(tmp_path, geometry="plane_strain", indenter="wedge")["contact"]["block_error"] is None
    foreseen = "at most", "crosses a border", "has reached", "of the height", "the tip starts"
    assert not [each for each in found["notes"] + found["warnings"] if any(words in each for words in foreseen)]


def test_text(tmp_path):
    """For people, also where the depth is not known before, a run would be over at once, and results are in the folder already."""
    run = harness.run({**CASE, "max_steps": 3}, folder=tmp_path)
    before = sorted(path.name for path in tmp_path.iterdir())
    again = harness.subprocess.run([*harness.command(harness.to_arguments({**CASE, "check": None, "max_steps": 1, "output_dir": tmp_path}), 1)],
                                   capture_output=True, text=True, env=harness.environment(1))
    assert again.returncode == 0 and sorted(path.name for path in tmp_path.iterdir()) == before and run.summary["steps"] == 3
    lines = again.stdout.splitlines()
    assert [line.split()[0] for line in lines[:6]] == ["case", "level", "level", "contact", "steps", "memory"]
    assert "200 nm" in lines[3] and "2.2 cells" in lines[3] and "cells of 250 nm, " in lines[2] and lines[2].endswith(" points, 6 um x 6 um")


def test_contact_behind_a_frame_or_under_a_load(tmp_path):
    """With a frame the tip comes less deep than is prescribed, so that the line is a bound; under load control a line says why there is none."""
    assert facts(tmp_path)["contact"]["at_most"] is False
    for name, line in (("fused_silica_tip", "contact     at the largest depth, 250 nm less what frame and tip take of it"),
                       ("cone_load", "contact     its width follows from the load and is not known")):
        words = ["-options_file", str(harness.ROOT / "options" / f"{name}.opts"), "-check"]
        done = harness.subprocess.run(harness.command(words, 1), capture_output=True, text=True, env=harness.environment(1), cwd=tmp_path)
        assert line in done.stdout, done.stderr


def test_refused(expect):
    expect_refused(expect, Table({**CASE, "output_dir": "out"}, [
        ("another form", {"check": "html"}, ["-check html: must be one of none, text, json"]),
        ("a wrong case", {"check": "text", "m_preset": "copper"}, ["-m_preset copper"]),
    ]))


def test_from_python(tmp_path, monkeypatch):
    """With the picture, of two dimensions and of space; a wrong case is the program's one line."""
    monkeypatch.chdir(tmp_path)
    found = mlgimp.check(CASE, out="case.png")
    assert [path.name for path in tmp_path.iterdir()] == ["case.png"] and found.facts["levels"][1]["cell_size"] == 250e-9
    assert len(found.figure.axes) == 2 and "2.23 cells" in found.figure.axes[1].get_title()
    lines = case_check.text_of(found)
    assert lines[0].endswith(" points, cells of 500, 250 nm") and any(line.startswith("warning: ") for line in lines)
    framed = case_check.text_of(found._replace(facts={**found.facts, "contact": {**found.facts["contact"], "at_most": True}}))
    assert "at 200 nm: " in lines[3] and "at 200 nm less what frame and tip take of it" in framed[3]
    with pytest.raises(mlgimp.RunError, match="^mlgimp: error: -m_preset Gold: must be gold, which is nearest"):
        mlgimp.check(CASE, m_preset="Gold")


SHIPPED = "pressure", "sphere_axisymmetric", "punch_axisymmetric", "wedge_3level", "cone_metal", "film_stress", "taylor_bar", "berkovich_3d"


@pytest.mark.alone
def verify_time(study):
    """What -check says of the time

    Eight shipped cases, each looked at and run at once after the other: steps and seconds that -check foresees, of those that the run takes.
    """
    rows = []
    for name in SHIPPED:
        begin = time.time()
        done = harness.subprocess.run(harness.command(["-options_file", f"options/{name}.opts", "-check", "json"], 1), capture_output=True, text=True,
                                      env=harness.environment(1), cwd=harness.ROOT)
        looked, found = time.time() - begin, json.loads(done.stdout)
        run = harness.run({}, file=f"{name}.opts").summary
        rows.append([name, found["steps"] / run["steps"], found["seconds"] / run["wall_seconds"], run["wall_seconds"], looked])
    study.expect("steps, largest difference, of them", max(abs(row[1] - 1) for row in rows), at_most=0.1)
    study.expect("seconds, largest difference, of them", max(abs(row[2] - 1) for row in rows), at_most=0.3)
    study.expect("-check itself, longest", max(row[4] for row in rows), at_most=3)
    study.table("Cases", ["case", "steps", "seconds", "seconds of the run", "seconds of -check"], [[row[0], *(f"{value:.3g}" for value in row[1:])] for row in rows])
