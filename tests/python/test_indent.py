"""Checks mlgimp.indent: the case it makes of a material and a tip, what it estimates, and what it refuses."""
import numpy as np
import pytest

import harness
import mlgimp
from mlgimp import indentation, options

pytestmark = pytest.mark.fast

METAL = {"youngs_modulus": 70e9, "yield_stress": 400e6}
COPPER = {"youngs_modulus": 124e9, "yield_stress": 90e6, "hardening": "johnson_cook", "hardening_modulus": 292e6,
          "hardening_exponent": 0.31, "rate_sensitivity": 0.0, "reference_rate": 1.0, "thermal_exponent": 1.09, "melting_temperature": 1356.0}


def test_indent(tmp_path, monkeypatch, expect):
    """An options file that gives the same run again, and the hardness of the metal."""
    monkeypatch.chdir(tmp_path)
    test = mlgimp.indent("j2", **METAL, hardening_modulus=1e9, tip="sphere", radius=2e-6, depth=100e-9, cells=4, block=8, tolerance=0.1, file="ball.opts",
                         progress=False, frames=0, options={"block_points_per_cell": 1, "history_interval": 10})
    row, = test.oliver_pharr()
    expect("depth, um", row["depth_um"], near=0.1, tolerance=1e-6)
    expect("hardness over the flow stress at 8 % of strain", row["true_hardness_GPa"] / 0.48, at_least=2.2, at_most=3.2)  # Tabor: 2.8; here on 4 cells
    text = (tmp_path / "ball.opts").read_text()
    assert "-block_points_per_cell 1\n" in text and text.startswith("# Indentation of j2 by sphere, 1e-07 m deep")
    assert test.folder.resolve() == tmp_path / "output" / "ball"
    given = options.read_options("ball.opts")
    assert given["specimen_yield_stress"] == "4e+08" and given["indenter_radius"] == "2e-06" and test.summary["options"]["-indenter_radius"] == "2e-06"
    with pytest.raises(mlgimp.Error, match="ball.opts: is there already"):
        mlgimp.indent("j2", **METAL, depth=100e-9, file="ball.opts")
    again = harness.run({"options_file": tmp_path / "ball.opts", "max_steps": 40})
    np.testing.assert_array_equal(again.history["load"], test.history["load"][:len(again.history["load"])])


@pytest.mark.parametrize("cells", [4, 5, 6])
def test_expected_errors_hold(tmp_path, expect, cells):
    """Of few cells and a small block, where they are large: Young's modulus that was given, the rest as on 20 cells."""
    groups = indentation.indentation_options("j2", **METAL, poissons_ratio=0.33, hardening_modulus=1e9, depth=200e-9, cells=cells, block=15, tolerance=0.05, options={"frames": 0})
    options.write_options(tmp_path / "case.opts", groups)
    row, = mlgimp.read(harness.run({"options_file": tmp_path / "case.opts"}).folder).oliver_pharr()
    expect("cells in contact", row["cells"], near=cells, tolerance=1.1)
    for name, right in (("modulus_GPa", 77.5), ("hardness_GPa", 1.675), ("true_hardness_GPa", 1.436), ("true_modulus_GPa", 70)):
        expect(f"error of {name}, of that expected", abs(row[name] / right - 1) / row["expected_error"][name], at_most=1.0)


def test_flow_stress_of_a_metal():
    """That of johnson_cook is Ludwik's, less what the metal softens up to its temperature; a law that is not known is hard."""
    rise = indentation.TABOR * (90e6 + 292e6 * indentation.STRAIN ** 0.31)
    assert indentation.hardness(COPPER) == pytest.approx(rise, rel=1e-12)
    assert indentation.hardness({**COPPER, "initial_temperature": 700}) == pytest.approx(rise, rel=1e-12)
    hot = {**COPPER, "reference_temperature": 300, "melting_temperature": 1300, "thermal_exponent": 0.5, "initial_temperature": 550}
    assert indentation.hardness(hot) == pytest.approx(rise / 2, rel=1e-12)
    assert indentation.hardness({**hot, "initial_temperature": 200}) == pytest.approx(rise, rel=1e-12)
    for law in ("table", "of a later version"):
        assert indentation.hardness({**COPPER, "hardening": law}) == np.inf


def test_tip_goes_back_until_it_is_free(tmp_path):
    """Also from a metal of johnson_cook, which was taken for one that does not harden: 0.28 of the load were left."""
    groups = indentation.indentation_options("j2", **COPPER, depth=200e-9, cells=4, block=8, tolerance=0.1, options={"frames": 0})
    options.write_options(tmp_path / "case.opts", groups)
    load = harness.run({"options_file": tmp_path / "case.opts"}).history["load"]
    assert load[-1] < 0.02 * load.max()


@pytest.mark.parametrize("law, case", [
    ("j2", dict(METAL, depth=200e-9)), ("j2", dict(METAL, load=10e-3)), ("neo_hookean", dict(youngs_modulus=70e9, tip="flat_punch", radius=1e-6, depth=20e-9)),
    ("j2", dict(METAL, tip="sphere", radius=5e-6, load=5e-3, unload=False)), ("j2", dict(METAL, tip="vickers", depth=1e-6, geometry="3d", cells=5, block=10)),
    ("j2", dict(METAL, tip="berkovich", load=1e-3, geometry="3d", cells=4, block=9)), ("j2", dict(METAL, depth=200e-9, hardening="power", hardening_exponent=0.1)), ("j2", dict(COPPER, depth=200e-9)), ("j2", dict(COPPER, load=1e-3)),
    ("neo_hookean", dict(youngs_modulus=1e6, tip="cone", half_angle=60, tip_radius=1e-7, depth=1e-5, cells=40, block=8))])
def test_cases_are_accepted(tmp_path, law, case):
    """The program takes each, and the contact stays inside the finest level."""
    groups = indentation.indentation_options(law, **case, options={"max_steps": 1, "frames": 0, "block_points_per_cell": 1})
    options.write_options(tmp_path / "case.opts", groups)
    result = harness.run({"options_file": tmp_path / "case.opts"})
    finest = result.summary["levels"][-1]
    shape = indentation.shape_of(case.get("tip", "berkovich"), case.get("geometry", "axisymmetric"), case.get("half_angle"), case.get("radius"), 0)
    radius = indentation.size_of_contact(shape, {"poissons_ratio": 0.3, **case}, case.get("depth"), case.get("load"))
    assert radius == pytest.approx(case.get("cells", 8) * finest["cell_size"], rel=0.05)
    assert finest["upper"][0] > 2.2 * radius


def test_a_misspelt_material_leads_to_the_right_one(tmp_path):
    with pytest.raises(mlgimp.Error, match="law=coper_ofhc: must be copper_ofhc, which is nearest, or a law"):
        mlgimp.indent("coper_ofhc", depth=1e-7, file=tmp_path / "case.opts")


@pytest.mark.parametrize("case, line", [
    (dict(METAL), "depth, load, test: one of them must be given"), (dict(METAL, depth=1e-7, load=1e-3), "^depth and load: only one of depth, load and test may be given$"), (dict(METAL, depth=200), "depth=200: must be in .* m; 200 nm"),
    (dict(METAL, depth="deep"), "depth=deep"), (dict(METAL, depth=float("nan")), "depth=nan"), (dict(METAL, load=-1), "load=-1: must be a number > 0 in N"),
    (dict(youngs_modulus=70, depth=1e-7), "youngs_modulus=70: must be .* in Pa; 70 GPa are 70e9"), (dict(depth=1e-7), "youngs_modulus=None"),
    (dict(METAL, depth=1e-7, poissons_ratio=0.5), "poissons_ratio=0.5"),
    (dict(METAL, depth=1e-7, tip="brinell"), "tip=brinell: must be brinell_1, which is nearest, or one of cone, sphere"),
    (dict(METAL, depth=1e-7, tip="Berkovich_R50"), "tip=Berkovich_R50: must be berkovich_R50, which is nearest"),
    (dict(METAL, depth=1e-7, tip="cone"), "half_angle: must be given for tip=cone"), (dict(METAL, depth=1e-7, radius=1e-6), "radius: must be left out"),
    (dict(METAL, depth=1e-7, tip="sphere", radius=5), "radius=5"), (dict(METAL, depth=2e-6, tip="sphere", radius=1e-6), "depth=2e-06: must be less than the radius"),
    (dict(METAL, depth=1e-7, geometry="plane_strain"), "geometry=plane_strain"), (dict(METAL, depth=1e-7, cells=1), "cells=1"),
    (dict(METAL, depth="2e-7"), "depth='2e-7': must be a number in SI units, or a text with a unit"),
    (dict(METAL, depth=1e-7, poissons_ratio="0.33"), "poissons_ratio=0.33: .* not as a text"),
    (dict(METAL, depth=1e-7, unload="no"), "unload=no: must be True or False"),
    (dict(METAL, depth=1e-7, overwrite="no"), "overwrite=no"),
    (dict(METAL, depth=1e-7, options=[1]), "options=.*: must be a dict"),
    (dict(METAL, depth=1e-7, options={"geometry": "3d"}), "options: geometry must be given as the argument"),
    (dict(METAL, depth=1e-7, tip=["cone"]), "tip=.*: must be one of cone"),
    (dict(METAL, depth=1e-7, tip="sphere", radius=1e-6, tip_radius=1e-8), "tip_radius: must be left out for tip=sphere"),
    (dict(METAL, depth=1e-7, block=2), "block=2"), (dict(METAL, depth=1e-7, hardening="power"), "hardening_exponent: must be given"),
    (dict(COPPER, depth=1e-7, reference_temperature=293, options={"initial_temperature": 1400}), "melting_temperature=1356: must be above"),
    (dict(COPPER, depth=1e-7, options={"initial_temperature": "warm"}), "initial_temperature=warm: must be a number")])
def test_what_indent_refuses(tmp_path, case, line):
    with pytest.raises(mlgimp.Error, match=f"^{line}[^\n]*$"):
        mlgimp.indent("j2", **case, file=tmp_path / "case.opts")
    assert not (tmp_path / "case.opts").exists()


def test_contact_of_a_rounded_tip_under_a_load():
    """On the ball at its end it is that of a ball; a sharp cone's would be 15 times smaller here, and the cells with it."""
    constants = {"youngs_modulus": 70e9, "poissons_ratio": 0.3}
    ball, cone, sharp = (indentation.size_of_contact(indentation.shape_of(*shape), constants, None, 1e-6) for shape in (
        ("sphere", "axisymmetric", None, 20e-6, 0), ("cone", "axisymmetric", 60, None, 20e-6), ("cone", "axisymmetric", 60, None, 0)))
    assert cone == pytest.approx(ball, rel=1e-12) and ball / sharp == pytest.approx(15.3, rel=0.01)


def test_numbers_of_any_type():
    """Those of numpy, also as arrays without dimensions, give the same case as those of Python."""
    plain = indentation.indentation_options("j2", youngs_modulus=2.0**36, yield_stress=4e8, depth=0.125e-2, cells=5, unload=False)
    of_numpy = indentation.indentation_options("j2", youngs_modulus=np.float32(2.0**36), yield_stress=np.int64(400000000),
                                               depth=np.array(0.125e-2), cells=np.int64(5), unload=np.bool_(False))
    assert plain == of_numpy


def test_the_program_refuses_the_rest(tmp_path, monkeypatch):
    """The options file of a case that it refuses does not stay in the way of the next call; one that was there before stays."""
    monkeypatch.chdir(tmp_path)
    for before in (False, True):
        if before:
            (tmp_path / "indentation.opts").touch()
        with pytest.raises(mlgimp.RunError, match="-specimen_yield_stres: unknown or unused option"):
            mlgimp.indent("j2", **METAL, yield_stres=1, depth=1e-7, overwrite=before)
        assert (tmp_path / "indentation.opts").exists() == before


@pytest.mark.parametrize("name, value, right", [
    ("E", 70e9, "youngs_modulus"), ("e", 70e9, "youngs_modulus"), ("nu", 0.3, "poissons_ratio"), ("rho", 2700, "density"), ("sigma_y", 4e8, "yield_stress"),
    ("tolerence", 0.1, "tolerance"), ("young_modulus", 70e9, "youngs_modulus"), ("half_angel", 70, "half_angle"), ("rank", 2, "ranks"), ("np", 2, "ranks"),
    ("max_depth", 1e-7, "depth"), ("Blocks", 20, "block"), ("model", "j2", "law")])
def test_names_that_may_have_meant_an_argument(tmp_path, name, value, right):
    """Before anything is missing or written."""
    with pytest.raises(mlgimp.Error, match=f"^{name}: there is no such argument; it may be {right}$"):
        mlgimp.indent("j2", file=tmp_path / "case.opts", **{name: value})
    assert not (tmp_path / "case.opts").exists()


@pytest.mark.parametrize("name, value, hint", [
    ("friction", 0.2, "it may be options={'indenter_friction': ...}"), ("mu", 0.2, "it may be options={'indenter_friction': ...}"),
    ("damping", 1e7, "it may be options={'damping': ...}"), ("history_interval", 10, "it may be options={'history_interval': ...}"),
    ("dampng", 1e7, "it may be options={'damping': ...}"), ("yeld_stress", 1e8, "it may be yield_stress"), ("melting_temp", 900, "it may be melting_temperature"),
    ("hardening_strain", 0.1, "another law or kind of hardening has it"), ("foo", 1, "it may be one of law, tip, depth, load, test, file, .*, or a constant of the law")])
def test_names_that_the_program_does_not_know(tmp_path, monkeypatch, name, value, hint):
    """Its own hint names options of the specimen, which a caller has never seen."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(mlgimp.RunError, match=f"^mlgimp: error: -specimen_{name}: unknown or unused option in this case; {hint}$"):
        mlgimp.indent("j2", **METAL, depth=1e-7, **{name: value})


def test_the_file_of_a_run_that_failed_stays(tmp_path, monkeypatch):
    """It is the record of results that are there, also in a folder that its options name."""
    def fails(file, *others, **more):
        (tmp_path / "there").mkdir()
        (tmp_path / "there" / "history.csv").touch()
        raise mlgimp.RunError("mlgimp: error: step 7")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(indentation, "run", fails)
    with pytest.raises(mlgimp.RunError):
        mlgimp.indent("j2", **METAL, depth=1e-7, file="case.opts", options={"output_dir": "there"})
    assert (tmp_path / "case.opts").exists()
