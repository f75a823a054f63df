"""Quantities with units in Python, as arguments and as options that are read back, beside the program's own table."""
import math
import re

import pytest

import harness
import mlgimp
from mlgimp import fitting, indentation, options, presets, units

METAL = {"youngs_modulus": 70e9, "yield_stress": 400e6}


def test_table_is_that_of_the_program():
    table = (harness.ROOT / "src" / "program" / "options" / "units.cpp").read_text().partition("kSymbols[] = {")[2].partition("};\n")[0]
    rows = re.findall(r'\{"(.+?)",\s*(?:\w+|\{\}),\s*(.+?),\s*(-?\d+),\s*"(\w*)"', re.sub(r'"\s+"', "", table))  # one text has two parts
    names = {bytes(name, "ascii").decode("unicode_escape").encode("latin-1").decode(): (int(tens), prefixes) for name, _, tens, prefixes in rows}
    assert names == {name: (tens, prefixes) for name, (_, _, tens, prefixes) in units.SYMBOLS.items()}


@pytest.mark.parametrize("text, value", [
    ("200nm", 200e-9), ("0.1 nm", 1e-10), ("2\u00b5m", 2e-6), ("2.7g/cm3", 2700), ("10mN", 0.01), ("25gf", 0.24516625), ("0.05nm/s", 5e-11), ("20degC", 293.15),
    ("3/s", 3), ("1e3 kJ/mol", 1e6), ("5%", 0.05), ("70.3\u00b0", 70.3), ("1rad", 180 / math.pi), ("-9.81m/s^2", -9.81), ("12", 12)])
def test_value(text, value):
    assert units.in_si(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text, kind, line", [
    ("70GPa", "a length", "GPa is a stress"), ("5foo", "a length", "with a unit of a length"), ("mN", None, "must be a number"), ("1mPa", "a stress", "a unit of a stress"),
    ("nan", None, "must be a number"), ("1e", None, "must be a number"), ("", None, "must be a number")])
def test_refused(text, kind, line):
    with pytest.raises(mlgimp.Error, match=line):
        units.in_si(text, kind)


def test_options_with_units(tmp_path):
    """A file with blanks before units, and the value of an option as a number."""
    (tmp_path / "a.opts").write_text("-cell_size 500 nm  # cells\n-domain_upper 12um,12um\n-monitor\n")
    read = options.read_options(tmp_path / "a.opts")
    assert read == {"cell_size": "500nm", "domain_upper": "12um,12um", "monitor": None}
    assert options.number_of(read, "cell_size", 1) == 5e-7 and options.number_of(read, "time_step", 0) == 0
    assert units.numbers_of(read["domain_upper"]) == [1.2e-5, 1.2e-5]


def test_indent_with_units():
    given = indentation.indentation_options("j2", **METAL, tip="cone", half_angle=70.3, depth=200e-9, tip_radius=50e-9)
    texts = indentation.indentation_options("j2", youngs_modulus="70GPa", yield_stress="400 MPa", tip="cone", half_angle="70.3deg", depth="200nm", tip_radius="50 nm")
    assert given == texts
    for tip in (mlgimp.Tip("cone", half_angle=70.3, frame="3N/um", tip_radius="50nm"), mlgimp.Tip("cone", half_angle="70.3deg", frame=3e6, tip_radius=50e-9)):
        assert tip.options() == {"indenter": "cone", "indenter_half_angle": 70.3, "indenter_tip_radius": 50e-9, "indenter_stiffness": 3e6}


@pytest.mark.parametrize("case, line", [
    ({"depth": "200GPa"}, "depth=200GPa: must be a length"), ({"depth": "200"}, "depth='200': must be a number in SI units, or a text with a unit"),
    ({"depth": "200nm", "density": "3GPa"}, "density=3GPa"), ({"load": "10nm"}, "load=10nm: must be a force")])
def test_indent_refuses(case, line):
    with pytest.raises(mlgimp.Error, match=line):
        indentation.indentation_options("j2", **METAL, **case)


def test_a_case_written_out():
    """What a fit may vary is what the preset gives, unless the case has it itself."""
    case = presets.written_out({"al_preset": "aluminium_2024", "al_yield_stress": "300MPa", "cell_size": "1um"})
    assert case["al_yield_stress"] == "300MPa" and case["al_youngs_modulus"] == "73.1GPa" and case["al_hardening_exponent"] == "0.34"
    found = fitting.variable("E", case)
    assert (found.option, found.start) == ("al_youngs_modulus", 73.1e9) and fitting.variable("yield_stress", case).start == 300e6


def group_with(groups, name):
    [found] = [group for group in groups if name in group]
    return found


def test_materials_and_tips_by_name():
    """Constants that are given count more, and the grid follows those of the preset."""
    groups = indentation.indentation_options("copper_ofhc", tip="berkovich_R150", depth="200nm", yield_stress="150MPa")
    assert group_with(groups, "materials") == {"materials": "specimen", "specimen_preset": "copper_ofhc", "specimen_yield_stress": 150e6}
    assert group_with(groups, "indenter")["indenter_tip_radius"] == pytest.approx(150e-9) and group_with(groups, "indenter")["indenter"] == "cone"
    written = {"youngs_modulus": 124e9, "poissons_ratio": 0.34, "hardening": "ludwik", "yield_stress": 150e6, "hardening_modulus": 292e6,
               "hardening_exponent": 0.31}
    same = indentation.indentation_options("j2", **written, tip="cone", half_angle=70.3, tip_radius=150e-9, depth=200e-9)
    assert group_with(groups, "domain_upper") == group_with(same, "domain_upper") and groups[-2] == same[-2]
    for law, line in (("silicon_crystal", "is a crystal"),
                      ("copper", "must be copper_ofhc, which is nearest, or a law, .* or a material, aluminium_6061")):
        with pytest.raises(mlgimp.Error, match=line):
            indentation.indentation_options(law, depth=1e-7)
    assert presets.materials()["copper_ofhc"].percents["youngs_modulus"] == 2 and presets.tips()["rockwell_c"].source == "ISO 6508-2"
