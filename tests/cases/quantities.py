"""Values with units and materials and tips by name: the same case, to the last digit, and refusals that say what a unit is of."""
import harness
from mlgimp import presets, units
from refusals import Table, expect_refused

PLAIN = {"geometry": "axisymmetric", "domain_lower": "0,0", "domain_upper": "12e-6,12e-6", "cell_size": "500e-9", "boundary_y_lower": "symmetry",
         "materials": "m", "m_model": "j2", "m_youngs_modulus": "70e9", "m_poissons_ratio": "0.33", "m_density": "2700", "m_yield_stress": "0.4e9",
         "m_hardening_modulus": "0", "bodies": "block", "block_lower": "0,0", "block_upper": "12e-6,10e-6", "indenter": "cone",
         "indenter_half_angle": "70.3", "indenter_tip": "0,10e-6", "indenter_times": "0,1e-9,20e-9", "indenter_velocities": "0,10,10",
         "damping": "1e8", "max_steps": "30", "history_interval": "5", "frames": "0"}
WITH_UNITS = {"domain_upper": "12um,0.012mm", "cell_size": "0.5um", "m_youngs_modulus": "70GPa", "m_poissons_ratio": "33%", "m_density": "2.7g/cm3",
              "m_yield_stress": "400MPa", "block_upper": "12um,10\u00b5m", "indenter_half_angle": "70.3deg", "indenter_tip": "0,10um",
              "indenter_times": "0,1ns,20ns", "indenter_velocities": "0,10m/s,10m/s", "damping": "100MHz"}


def history(result):
    return (result.folder / "history.csv").read_bytes()


def test_same_case(tmp_path):
    """In SI and with units, on the command line and in a file with blanks before the units; the summary is in SI."""
    plain = harness.run(PLAIN)
    (tmp_path / "units.opts").write_text("".join(f"-{name} {value}  # a comment\n" for name, value in {**PLAIN, **WITH_UNITS}.items())
                                         .replace("0.5um", "0.5 um").replace("70GPa", "70 GPa"))
    for result in (harness.run({**PLAIN, **WITH_UNITS}), harness.run({"options_file": tmp_path / "units.opts"}, ranks=2)):
        assert result.summary["options"] == plain.summary["options"]
    assert history(harness.run({**PLAIN, **WITH_UNITS})) == history(plain)


def test_units_that_are_refused(expect):
    expect_refused(expect, Table({**PLAIN, "output_dir": "out"}, [
        ("another kind", {"cell_size": "200GPa"}, ["-cell_size 200GPa", "GPa is a stress, -cell_size is a length"]),
        ("a kind without a name", {"m_density": "2.7kg/m4"}, ["kg/m4 is a quantity in m-4 kg, -m_density is a density"]),
        ("unknown", {"cell_size": "0.5micron"}, ["micron is no unit of a length (nm, um, mm, m)"]),
        ("a capital", {"m_youngs_modulus": "70gPa"}, ["gPa is no unit of a stress (kPa, MPa, GPa)"]),
        ("milli for mega", {"m_yield_stress": "400mPa"}, ["mPa is no unit of a stress", "it may be MPa"]),
        ("a small letter", {"m_youngs_modulus": "114Gpa"},
         ["-m_youngs_modulus 114Gpa: must be a number, or one with its unit; Gpa is no unit", "it may be GPa"]),
        ("some have units", {"domain_upper": "12um,12"}, ["12 has no unit, and others have one"]),
        ("of a pure number", {"cfl": "0.4um"}, ["um is a length, -cfl is a pure number"]),
        ("of a count", {"max_steps": "30s"}, ["-max_steps 30s: must be a whole number"]),
        ("two units", {"cell_size": "0.5 um nm"}, ["no unit"]),
        ("a degree below none", {"initial_temperature": "-300degC"}, ["must be > 0"]),
        ("out of range", {"m_poissons_ratio": "60%"}, ["-m_poissons_ratio 60%: must be in (-1, 0.5)"]),
        ("hexadecimal", {"cell_size": "0x5nm"}, ["no finite number"]),
    ]))


def test_material_by_name():
    """It is the case with its constants written out; those that are given count more, and a law of one's own takes what the law needs."""
    preset = {name: value for name, value in PLAIN.items() if not name.startswith("m_")} | {"m_preset": "aluminium_2024"}
    written = {**PLAIN, "m_youngs_modulus": "73.1e9", "m_density": "2770", "m_yield_stress": "265e6", "m_hardening": "ludwik", "m_hardening_modulus": "426e6",
               "m_hardening_exponent": "0.34"}
    run = harness.run(preset)
    assert history(run) == history(harness.run(written))
    assert "-m_preset aluminium_2024: -m_density 2.77g/cm3 +- 0.5 %" in run.stdout and "(G. R. Johnson" in run.stdout
    softer, linear = harness.run({**preset, "m_yield_stress": "200MPa"}), harness.run({**preset, "m_model": "linear"})
    assert [float(softer.summary["options"][f"-m_{name}"]) for name in ("yield_stress", "hardening_modulus")] == [200e6, 426e6]
    assert "-m_yield_stress" not in softer.stdout
    assert linear.summary["options"]["-m_model"] == "linear" and "-m_yield_stress" not in linear.summary["options"]


def test_gold_on_silicon_in_axisymmetry(expect):
    """By presets alone; their elastic constants are the means of Voigt's and Reuss' averages of the crystals of the same table."""
    film = {name: value for name, value in PLAIN.items() if not name.startswith(("m_", "block_"))}
    bodies = {"materials": "film,wafer", "film_preset": "gold", "wafer_preset": "silicon_isotropic", "bodies": "top,bottom", "top_material": "film",
              "bottom_material": "wafer", "top_lower": "0,9um", "top_upper": "12um,10um", "bottom_lower": "0,0", "bottom_upper": "12um,9um"}
    assert harness.run({**film, **bodies, "max_steps": "3"}).summary["steps"] == 3
    for crystal, name in (("gold_crystal", "gold"), ("silicon_crystal", "silicon_isotropic")):
        c11, c12, c44 = (units.in_si(each) for each in presets.materials()[crystal].values["elastic_constants"].split(","))
        bulk, shear = (c11 + 2 * c12) / 3, ((c11 - c12 + 3 * c44) / 5 + 5 * (c11 - c12) * c44 / (4 * c44 + 3 * (c11 - c12))) / 2
        known = presets.numbers(presets.materials()[name])
        expect(f"{name}: Young's modulus", known["youngs_modulus"] / (9 * bulk * shear / (3 * bulk + shear)), near=1, tolerance=0.01)
        expect(f"{name}: Poisson's ratio", known["poissons_ratio"], near=(3 * bulk - 2 * shear) / (6 * bulk + 2 * shear), tolerance=0.005)


def test_tip_by_name():
    """In axisymmetry a pyramid is the cone of the same area."""
    without = {name: value for name, value in PLAIN.items() if name != "indenter_half_angle"}
    named = harness.run({**without, "indenter": "berkovich_R150"})
    assert history(named) == history(harness.run({**PLAIN, "indenter_half_angle": "70.295975321070472", "indenter_tip_radius": "150e-9"}))
    assert "-indenter berkovich_R150: -indenter cone, -indenter_tip_radius 150nm +- 50 %" in named.stdout
    own = harness.run({**without, "indenter": "rockwell_c", "indenter_tip_radius": "2um"})
    assert float(own.summary["options"]["-indenter_tip_radius"]) == 2e-6 and float(own.summary["options"]["-indenter_half_angle"]) == 60


def test_names_that_are_refused(expect):
    expect_refused(expect, Table({**PLAIN, "output_dir": "out"}, [
        ("no such material", {"m_preset": "unobtainium"}, ["-m_preset unobtainium: must be one of none, aluminium_6061"]),
        ("a letter less", {"m_preset": "coper_ofhc"}, ["-m_preset coper_ofhc: must be copper_ofhc, which is nearest"]),
        ("the beginning alone", {"m_preset": "copper"}, ["-m_preset copper: must be copper_ofhc, which is nearest"]),
        ("no such tip", {"indenter": "needle_R7"}, ["-indenter needle_R7: must be one of berkovich_R50", "-presets"]),
        ("a tip in other capitals", {"indenter": "Berkovich_R50"}, ["-indenter Berkovich_R50: must be berkovich_R50, which is nearest"]),
        ("a cubic crystal in axisymmetry", {"m_preset": "gold_crystal", "m_model": None, "m_youngs_modulus": None, "m_poissons_ratio": None,
                                            "m_yield_stress": None, "m_hardening_modulus": None},
         ["cubic crystals need -geometry 3d", "silicon_isotropic"]),
        ("a pyramid in plane strain", {"geometry": "plane_strain", "indenter": "berkovich_R50", "indenter_half_angle": None},
         ["-indenter berkovich: must be one of", "plane_strain"]),
        ("what the law does not take", {"m_preset": "steel_s7", "m_model": "linear"}, ["-m_hardening_modulus: unknown or unused"]),
    ]))


def test_every_preset_runs():
    """Each material can be set up: -max_steps 1 in three dimensions, where crystals are at home."""
    block = {"geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "4um,4um,4um", "cell_size": "1um", "max_steps": "1", "frames": "0"}
    names = list(presets.materials())
    assert len(names) >= 25 and len(presets.tips()) >= 10
    bodies = {"bodies": ",".join(names), "materials": ",".join(names)}
    for k, name in enumerate(names):
        corner = [k % 4, k // 4 % 4, k // 16]
        bodies |= {f"{name}_preset": name, f"{name}_material": name, f"{name}_lower": ",".join(f"{c}um" for c in corner),
                   f"{name}_upper": ",".join(f"{c + 1}um" for c in corner)}
    run = harness.run({**block, **bodies})
    assert all(f"-{name}_preset {name}: " in run.stdout for name in names)
