"""Bad input: one line that names the option, the value and what is allowed, on any number of ranks, and nothing left behind."""
import math
import os
import pathlib
import tempfile

import h5py
import pytest

import harness
from refusals import Table, expect_refused, inputs, problem_of, without, words_of

BLOCK = {
    "domain_lower": "0,0", "domain_upper": "12,12", "cell_size": "1", "max_steps": "40", "frames": "0",
    "materials": "al", "al_youngs_modulus": "1e9", "al_poissons_ratio": "0.3", "al_density": "1000",
    "bodies": "block", "block_lower": "0,0", "block_upper": "8,8",
}
WEDGE = {"indenter": "wedge", "indenter_half_angle": "70", "indenter_tip": "4,8", "indenter_times": "0",
         "indenter_velocities": "1"}
POLYGON = {**WEDGE, "indenter": "polygon", "indenter_half_angle": None}
LOAD = {"loads": "press", "press_side": "y_upper", "press_times": "0,1e-3", "press_pressures": "0,1e3"}
DISK = {"block_shape": "disk", "block_lower": None, "block_upper": None, "block_center": "4,4", "block_radius": "3"}
VERTICES = {"block_shape": "polygon", "block_lower": None, "block_upper": None}
TWO = {"bodies": "block,ball", "ball_shape": "disk", "ball_center": "6,10", "ball_radius": "1.5"}
J2 = {"al_model": "j2", "al_yield_stress": "1e6", "al_hardening_modulus": "0"}

AXIS = {"geometry": "axisymmetric"}
CONE = {**WEDGE, **AXIS, "indenter": "cone", "indenter_tip": "0,8"}
SPACE = {"geometry": "3d", "domain_lower": "0,0,0", "domain_upper": "12,12,12", "block_lower": "0,0,0", "block_upper": "8,8,8"}
PYRAMID = {**WEDGE, **SPACE, "indenter": "pyramid", "indenter_tip": "4,4,8"}
QUARTER = {**PYRAMID, "indenter_tip": "0,0,8", "boundary_x_lower": "symmetry", "boundary_y_lower": "symmetry"}
LEVELS = {**BLOCK, "levels": "2", "level_1_lower": "2,2", "level_1_upper": "10,10"}
THREE = {"levels": "3", "level_2_lower": "6,6", "level_2_upper": "8,8", "level_1_lower": "0,0"}
METAL = {"geometry": "plane_strain", "domain_lower": "0,0", "domain_upper": "4,4", "cell_size": 1, "materials": "m", "m_model": "j2",
         "m_youngs_modulus": 1e9, "m_poissons_ratio": 0.3, "m_density": 1000, "m_yield_stress": 1e6, "bodies": "b", "b_lower": "0,0", "b_upper": "2,2", "max_steps": 1}
COOK = {"m_hardening": "johnson_cook", "m_hardening_modulus": 1e6, "m_hardening_exponent": 0.3, "m_rate_sensitivity": 0.01,
        "m_reference_rate": 1, "m_thermal_exponent": 1, "m_melting_temperature": 1000}
CURVE = {"m_yield_stress": None, "m_hardening": "table", "m_plastic_strains": "0,0.1", "m_flow_stresses": "1e6,2e6"}

WIDE = {"bodies": "block,other", "domain_upper": "100,12", "block_upper": "50,8"}
ENDLESS = {"max_steps": None, "end_time": 1}
TOO_MANY = {"block_lower": None, "block_upper": None, "domain_upper": "1020,12", "bodies": ",".join(f"b{k}" for k in range(255)),
            **{f"b{k}_lower": f"{4 * k},1" for k in range(255)}, **{f"b{k}_upper": f"{4 * k + 2},3" for k in range(255)}}
SQUARE = [(1, 1), (5, 1), (5, 5), (1, 5)]
NO_INSIDE = {
    "bow tie": [(1, 1), (5, 5), (5, 1), (1, 5)], "repeated vertex": SQUARE + [(1, 1)], "twice wound": SQUARE * 2, "on a line": [(1, 1), (3, 3), (5, 5)],
    "star": [(6 + 5 * math.sin(4 * math.pi * k / 5), 6 + 5 * math.cos(4 * math.pi * k / 5)) for k in range(5)],
    "spike": [(1, 1), (5, 1), (5, 5), (5, 8), (5, 6), (1, 5)], "touching": [(1, 1), (9, 1), (5, 5), (9, 9), (1, 9), (5, 5)],
    "vertex on an edge": [(1, 1), (9, 1), (9, 9), (5, 1), (1, 9)]}
FILE = ["-options_file", "case.opts"]


def corners(vertices):
    return ",".join(f"{x!r},{y!r}" for x, y in vertices)


TABLES = {
    "missing": Table(BLOCK, [
        ("no options at all", without(*BLOCK), ["-domain_lower", "given"]),
        ("no lower corner", without("domain_lower"), ["-domain_lower", "given"]),
        ("no upper corner", without("domain_upper"), ["-domain_upper", "given"]),
        ("no cell size", without("cell_size"), ["-cell_size", "given"]),
        ("no materials", without("materials"), ["-materials", "given"]),
        ("no modulus", without("al_youngs_modulus"), ["-al_youngs_modulus", "given"]),
        ("no Poisson's ratio", without("al_poissons_ratio"), ["-al_poissons_ratio", "given"]),
        ("no density", without("al_density"), ["-al_density", "given"]),
        ("no yield stress", {**J2, "al_yield_stress": None}, ["-al_yield_stress", "given"]),
        ("no hardening", {**J2, "al_hardening_modulus": None}, ["-al_hardening_modulus", "given"]),
        ("no bodies", without("bodies"), ["-bodies", "given"]),
        ("no box", without("block_upper"), ["-block_upper", "given"]),
        ("no radius", {**DISK, "block_radius": None}, ["-block_radius", "given"]),
        ("no vertices", VERTICES, ["-block_vertices", "given"]),
        ("no end", without("max_steps"), ["-end_time", "-max_steps"]),
        ("no tip", {**WEDGE, "indenter_tip": None}, ["-indenter_tip", "given"]),
        ("no half-angle", {**WEDGE, "indenter_half_angle": None}, ["-indenter_half_angle", "given"]),
        ("no indenter times", {**WEDGE, "indenter_times": None}, ["-indenter_times", "given"]),
        ("no indenter velocities", {**WEDGE, "indenter_velocities": None}, ["-indenter_velocities", "given"]),
        ("no cylinder radius", {**WEDGE, "indenter": "cylinder", "indenter_half_angle": None}, ["-indenter_radius", "given"]),
        ("no punch width", {**WEDGE, "indenter": "flat_punch", "indenter_half_angle": None}, ["-indenter_width", "given"]),
        ("no load pressures", {**LOAD, "press_pressures": None}, ["-press_pressures", "given"]),
        ("two materials, none chosen",
         {"materials": "al,si", "si_youngs_modulus": "1e9", "si_poissons_ratio": "0.2", "si_density": "1000"},
         ["-block_material", "given"]),
    ]),
    "misspelt": Table(BLOCK, [
        ("mistyped", {"histroy_interval": "2"}, ["-histroy_interval", "nearest", "-history_interval"]),
        ("mistyped name part", {"al_poisson_ratio": "0.2"}, ["-al_poisson_ratio", "nearest", "-al_poissons_ratio"]),
        ("options file, misspelt", {**without(*BLOCK), "option_file": "case.opts"}, ["-option_file:", "nearest", " -options_file"]),
        ("options file, misspelt like an option of PETSc", {**without(*BLOCK), "options_fil": "case.opts"}, ["-options_fil:", " -options_file"]),
        ("corner, misspelt", {"domain_lower": None, "domian_lower": "0,0"}, ["-domian_lower:", "nearest", " -domain_lower"]),
        ("bodies, misspelt", {"bodies": None, "bodys": "block"}, ["-bodys:", "nearest", " -bodies"]),
        ("materials, misspelt", {"materials": None, "materals": "al"}, ["-materals:", "nearest", " -materials"]),
        ("density, misspelt", {"al_density": None, "al_Densty": "1000"}, ["-al_Densty:", "nearest", " -al_density"]),
        ("end, misspelt", {"max_steps": None, "max_step": "40"}, ["-max_step:", "nearest", " -max_steps"]),
        ("indenter, misspelt", {**WEDGE, "indenter": None, "indentor": "wedge"}, ["-indentor:", "nearest", " -indenter"]),
        ("times, misspelt", {**WEDGE, "indenter_times": None, "indentr_times": "0"}, ["-indentr_times:", "nearest", " -indenter_times"]),
        ("nothing misspelt, all else there", {"domain_lower": None, "levels": "3", "Level_2_lower": "2,2", "CFL": "0.3", "contact_ksp_atol": "1"},
         ["-domain_lower:", "given"]),
        ("equals sign for a blank, nothing else", {**without(*BLOCK), "cell_size=1": ""}, ["-cell_size=1:", "blank"]),
        ("another indenter's option", {**WEDGE, "indenter_width": "1"}, ["-indenter_width", "case"]),
        ("load's option without the load", {"press_side": "y_upper"}, ["-press_side"]),
        ("mistyped contact solver option", {**WEDGE, "contact_ksp_rtoll": "1e-8"}, ["-contact_ksp_rtoll:", "nearest", " -contact_ksp_rtol"]),
        ("frame for frames", {"frame": "3"}, ["-frame:", "-frames"]),
        ("nothing like it", {"bananas": "3"}, ["-bananas", "unknown or unused"]),
        ("with a capital as well", {"damping": "1", "Damping": "2"}, ["-Damping", "capitals"]),
    ]),
    "grid": Table(BLOCK, [
        ("part of a cell", {"domain_upper": "12.5,12"}, ["-cell_size 1:", "whole", "12.5"]),
        ("upside down", {"domain_upper": "12,-3"}, ["-domain_upper 12,-3:", "above -domain_lower"]),
        ("no height", {"domain_upper": "12,0"}, ["-domain_upper 12,0:", "above -domain_lower"]),
        ("a third with too few digits", {"domain_upper": "16,16", "cell_size": "2.66667"},
         ["-cell_size 2.66667:", "to a millionth; 6 cells along x have 2.6666666666666665"]),
        ("cells beyond number", {"cell_size": "1e-9"}, ["-cell_size 1e-09:"]),
        ("more cells than numbers", {"cell_size": "1e-4"}, ["-cell_size 0.0001:"]),
        ("cell size zero", {"cell_size": "0"}, ["-cell_size 0:", "> 0"]),
        ("cell size negative", {"cell_size": "-1"}, ["-cell_size -1:", "> 0"]),
        ("cell size not a number", {"cell_size": "nan"}, ["-cell_size nan:", "> 0"]),
        ("cell size infinite", {"cell_size": "inf"}, ["-cell_size inf:", "> 0"]),
        ("cell size overflows", {"cell_size": "1e999"}, ["-cell_size 1e999:", "> 0"]),
        ("cell size with a unit", {"cell_size": "1kg"}, ["-cell_size 1kg:", "kg is a mass"]),
        ("cell size without value", {"cell_size": ""}, ["-cell_size (nothing):", "> 0"]),
        ("one component", {"domain_upper": "12"}, ["-domain_upper 12:", "2 numbers"]),
        ("three components", {"domain_upper": "12,12,12"}, ["-domain_upper 12,12,12:", "2 numbers"]),
        ("empty component", {"domain_upper": "12,"}, ["-domain_upper 12,:", "2 numbers"]),
        ("levels 0", {"levels": "0"}, ["-levels 0:"]),
        ("levels 1.5", {"levels": "1.5"}, ["-levels 1.5:", "whole"]),
        ("levels -1", {"levels": "-1"}, ["-levels -1:"]),
        ("refinement ratio 1", {"refinement_ratio": "1"}, ["-refinement_ratio 1:", "[2, 16]"]),
        ("geometry unknown", {"geometry": "spherical"}, ["-geometry spherical:", "plane_strain"]),
        ("vectors of another geometry", {"geometry": "3d"}, ["-domain_lower", "must be 3 numbers"]),
        ("boundary unknown", {"boundary_x_lower": "sticky"}, ["-boundary_x_lower sticky:", "free, symmetry, fixed"]),
        ("thickness zero", {"thickness": "0"}, ["-thickness 0:", "> 0"]),
        ("cells too small for numbers", {"domain_upper": "12e-300,12e-300", "cell_size": "1e-300"}, ["-cell_size 1e-300:"]),
        ("cells too large for numbers", {"domain_upper": "12e200,12e200", "cell_size": "1e200"}, ["-cell_size 1e+200:"]),
        ("box off the lines of cells far away", {"domain_lower": "-10000,0", "levels": "2", "level_1_lower": "2.009,2", "level_1_upper": "10,10"},
         ["-level_1_lower 2.009,2:", "cell lines"]),
    ]),
    "axisymmetry and space": Table(BLOCK, [
        ("radii below zero", {**AXIS, "domain_lower": "-1,0"}, ["-domain_lower -1,0:", "axis"]),
        ("domain off the axis", {**AXIS, "domain_lower": "1,0", "block_lower": "1,0"}, ["-domain_lower 1,0:", "axis"]),
        ("axis that is held", {**AXIS, "boundary_x_lower": "fixed"}, ["-boundary_x_lower fixed:", "axis"]),
        ("axis that is free", {**AXIS, "boundary_x_lower": "free"}, ["-boundary_x_lower free:", "axis"]),
        ("hole along the axis", {**AXIS, "block_lower": "0.5,0"}, ["-bodies block:", "axis", "hole of 0.5 m"]),
        ("hole of a rounding along the axis", {**AXIS, "block_lower": "1e-6,0"}, ["-bodies block:", "axis"]),
        ("level that leaves a gap at the axis", {**AXIS, "levels": "2", "level_1_lower": "2,2", "level_1_upper": "6,6"},
         ["-level_1_lower 2,2:", "axis"]),
        ("tip in another unit", {**CONE, "indenter_tip": "0,8000"}, ["-indenter_tip 0,8000:", "height of the domain"]),
        ("thickness of a solid of revolution", {**AXIS, "thickness": "1"}, ["-thickness"]),
        ("body beyond the axis", {**AXIS, "block_lower": "-1,0"}, ["-block_lower -1,0:", "inside the domain"]),
        ("disk across the axis", {**AXIS, **DISK, "block_center": "1,4"}, ["-block_center:", "inside the domain"]),
        ("tip off the axis", {**CONE, "indenter_tip": "1,8"}, ["-indenter_tip 1,8:", "on the axis"]),
        ("level's border near the tip on the axis", {**CONE, "levels": "2", "level_1_lower": "0,4", "level_1_upper": "2,12"},
         ["-level_1_upper 2,12:", "tip"]),
        ("level too shallow for any load", {**WEDGE, "levels": "2", "level_1_lower": "0,6", "level_1_upper": "10,12", "boundary_y_lower": "symmetry",
                                            "indenter_velocities": None, "indenter_control": "load", "indenter_times": "0,1", "indenter_loads": "0,1"},
         ["-level_1_lower 0,6:", "more than", "below where the indenter begins to press, 8"]),
        ("the same in axisymmetry", {**CONE, "levels": "2", "level_1_lower": "0,7", "level_1_upper": "8,12", "boundary_y_lower": "symmetry",
                                     "indenter_velocities": None, "indenter_control": "load", "indenter_times": "0,1", "indenter_loads": "0,1"},
         ["-level_1_lower 0,7:", "more than", "below where the indenter begins to press, 8"]),
        ("copies of points in axisymmetry", {**AXIS, "levels": "2", "level_1_lower": "0,4", "level_1_upper": "6,12", "level_coupling": "points"},
         ["-level_coupling points:", "plane strain"]),
        ("pyramid on the axis", {**CONE, "indenter": "pyramid"}, ["-indenter pyramid:", "cone, sphere"]),
        ("wedge on the axis", {**CONE, "indenter": "wedge"}, ["-indenter wedge:", "cone, sphere"]),
        ("three components of a velocity in axisymmetry", {**AXIS, "block_velocity": "0,0,1"}, ["-block_velocity 0,0,1:", "2 numbers"]),
        ("gravity away from the axis", {**AXIS, "gravity": "9.81,0"}, ["-gravity 9.81,0:", "axis"]),
        ("body that leaves the axis", {**AXIS, "block_velocity": "1,0"}, ["-block_velocity 1,0:", "axis"]),
        ("three components in axisymmetry", {**CONE, "indenter_tip": "0,8,0"}, ["-indenter_tip 0,8,0:", "2 numbers"]),
        ("pyramid with two faces", {**PYRAMID, "indenter_faces": "2"}, ["-indenter_faces 2:", "[3, 360]"]),
        ("two components of a tip in space", {**PYRAMID, "indenter_tip": "4,8"}, ["-indenter_tip 4,8:", "3 numbers"]),
        ("Berkovich tip on two sides of symmetry", {**QUARTER, "indenter": "berkovich", "indenter_half_angle": None},
         ["-indenter berkovich:", "mirror", "x_lower"]),
        ("turned pyramid on a side of symmetry", {**QUARTER, "indenter_turn": "20"}, ["-indenter pyramid:", "mirror", "x_lower"]),
        ("polygon on a side of symmetry", {**POLYGON, "boundary_x_lower": "symmetry", "indenter_tip": "0,8", "indenter_vertices": "0,0,3,1,-1,1"},
         ["-indenter polygon:", "mirror", "x_lower"]),
        ("two components of gravity in space", {**SPACE, "gravity": "0,-1"}, ["-gravity 0,-1:", "3 numbers"]),
        ("two components of a velocity in space", {**SPACE, "block_velocity": "0,1"}, ["-block_velocity 0,1:", "3 numbers"]),
        ("two components of a box in space", {**SPACE, "levels": "2", "level_1_lower": "0,0", "level_1_upper": "8,8,8"},
         ["-level_1_lower 0,0:", "3 numbers"]),
        ("wedge in space", {**PYRAMID, "indenter": "wedge"}, ["-indenter wedge:", "berkovich"]),
        ("multi-mesh contact in space", {**PYRAMID, "contact": "multimesh"}, ["-contact multimesh:", "pressure"]),
        ("copies of points in space", {**SPACE, "levels": "2", "level_1_lower": "0,0,4", "level_1_upper": "6,6,12", "level_coupling": "points"},
         ["-level_coupling points:", "plane strain"]),
        ("disk in space", {**SPACE, **DISK, "block_center": "4,4,4"}, ["-block_shape disk:", "ball"]),
        ("thickness in space", {**SPACE, "thickness": "1"}, ["-thickness"]),
    ]),
    "materials": Table(BLOCK, [
        ("Poisson 0.5", {"al_poissons_ratio": "0.5"}, ["-al_poissons_ratio 0.5: must be in (-1, 0.5)"]),
        ("Poisson -1", {"al_poissons_ratio": "-1"}, ["-al_poissons_ratio -1: must be in (-1, 0.5)"]),
        ("density negative", {"al_density": "-2700"}, ["-al_density -2700:", "> 0"]),
        ("modulus zero", {"al_youngs_modulus": "0"}, ["-al_youngs_modulus 0:", "> 0"]),
        ("yield stress negative", {**J2, "al_yield_stress": "-1"}, ["-al_yield_stress -1:", "> 0"]),
        ("hardening negative", {**J2, "al_hardening_modulus": "-1"}, ["-al_hardening_modulus -1:", ">= 0"]),
        ("model unknown", {"al_model": "putty"}, ["-al_model putty:", "neo_hookean", "j2"]),
        ("material twice", {"materials": "al,al"}, ["-materials al,al:", "different names"]),
        ("material's name illegal", {"materials": "al,6061"}, ["-materials al,6061:", "letters"]),
        ("material's name empty", {"materials": "al,"}, ["-materials al,:", "names"]),
    ]),
    "laws of metals": Table(METAL, [
        ("power below 0", {"m_hardening": "power", "m_hardening_exponent": -0.1}, ["-m_hardening_exponent -0.1:", "[0, 1]"]),
        ("no power", {"m_hardening": "power"}, ["-m_hardening_exponent", "given"]),
        ("hardening unknown", {"m_hardening": "isotropic"}, ["-m_hardening isotropic:", "voce"]),
        ("saturation below yield", {"m_hardening": "voce", "m_saturation_stress": 5e5, "m_saturation_strain": 0.1},
         ["-m_saturation_stress", "-m_yield_stress"]),
        ("saturation at once", {"m_hardening": "voce", "m_saturation_stress": 5e6, "m_saturation_strain": 0}, ["-m_saturation_strain 0:", "> 0"]),
        ("table that begins late", {**CURVE, "m_plastic_strains": "0.01,0.1"}, ["-m_plastic_strains 0.01:", "0 at first"]),
        ("table that turns back", {**CURVE, "m_plastic_strains": "0,0.1,0.05", "m_flow_stresses": "1e6,2e6,3e6"}, ["-m_plastic_strains 0.05:", "rising"]),
        ("table that softens", {**CURVE, "m_flow_stresses": "2e6,1e6"}, ["-m_flow_stresses", "at least the one before"]),
        ("fewer stresses than strains", {**CURVE, "m_flow_stresses": "2e6"}, ["-m_flow_stresses 1 values:", "as many"]),
        ("table and yield stress", {**CURVE, "m_yield_stress": 1e6}, ["-m_yield_stress"]),
        ("molten at the start", {**COOK, "m_melting_temperature": 290}, ["-m_melting_temperature 290:", "-initial_temperature"]),
        ("molten at the reference", {**COOK, "m_reference_temperature": 1000}, ["-m_melting_temperature 1000:", "-m_reference_temperature"]),
        ("heat without capacity", {**COOK, "m_adiabatic": "true"}, ["-m_heat_capacity", "-m_adiabatic"]),
        ("rates times 0", {**COOK, "rate_scale": 0}, ["-rate_scale 0:", "> 0"]),
        ("USF of an average", {"m_hardening_modulus": 0, "stress_update": "usf"}, ["-stress_update usf:", "volume_average"]),
        ("hardening of no metal", {"m_model": "neo_hookean", "m_hardening": "swift"}, ["-m_"]),
    ], every=1),
    "bodies": Table(BLOCK, [
        ("body twice", {"bodies": "block,block"}, ["-bodies block,block:", "different names"]),
        ("body's name illegal", {"bodies": "block,b-2"}, ["-bodies block,b-2:", "letters"]),
        ("body with the name of other options", {**TWO, "bodies": "block,domain"}, ["domain"]),
        ("body outside", {"block_upper": "8,13"}, ["-block_upper 8,13:", "inside the domain"]),
        ("body without points", {"bodies": "block,film", "film_lower": "0,10", "film_upper": "8,10.0000001"}, ["-bodies film:", "point"]),
        ("bodies overlap", {**TWO, "ball_center": "6,9"}, ["-bodies ball:", "block", "overlap"]),
        ("box upside down", {"block_upper": "8,-1"}, ["-block_upper 8,-1:", "above -block_lower 0,0"]),
        ("disk with negative radius", {**DISK, "block_radius": "-3"}, ["-block_radius -3:", "> 0"]),
        ("polygon with an odd number of values", {**VERTICES, "block_vertices": "0,0,8,0,8,8,0"}, ["-block_vertices", "x,y pairs"]),
        ("polygon with two vertices", {**VERTICES, "block_vertices": "0,0,8,0"}, ["-block_vertices 0,0,8,0:", "at least 6"]),
        ("shape unknown", {"block_shape": "star"}, ["-block_shape star:", "box, disk, polygon"]),
        ("material unknown", {"block_material": "si"}, ["-block_material si:", "-materials", "al"]),
        ("points per cell 0", {"block_points_per_cell": "0"}, ["-block_points_per_cell 0:", "[1, 16]"]),
        ("velocity is text", {"block_velocity": "fast,0"}, ["-block_velocity fast,0:", "2 numbers"]),
        ("body below the domain", {"block_lower": "-1,0"}, ["-block_lower -1,0:", "inside the domain"]),
        ("box that overlaps by a thousandth", {**WIDE, "other_lower": "49.9999,0", "other_upper": "60,8"}, ["-bodies other:", "overlap"]),
        ("disk that overlaps thinly", {**WIDE, "other_shape": "disk", "other_center": "53.95,4", "other_radius": "4"}, ["-bodies other:", "overlap"]),
        *[(f"polygon without an inside, {name}", {**VERTICES, "block_vertices": corners(vertices)}, ["-block_vertices: must be a polygon"])
          for name, vertices in NO_INSIDE.items()],
    ]),
    "loads": Table(BLOCK, [
        ("load on an unknown body", {**LOAD, "press_body": "brick"}, ["-press_body brick:", "-bodies", "block"]),
        ("load's span reversed", {**LOAD, "press_span": "5,2"}, ["-press_span 5,2:", "end above start"]),
        ("load on no face", {**LOAD, "press_span": "9,11"}, ["-loads press:", "face", "block"]),
        ("load's side unknown", {**LOAD, "press_side": "top"}, ["-press_side top:", "y_upper"]),
        ("load's times not increasing", {**LOAD, "press_times": "1e-3,0"}, ["-press_times", "increasing"]),
        ("more pressures than times", {**LOAD, "press_pressures": "0,1,2"}, ["-press_pressures", "as many as -press_times"]),
        ("load twice", {**LOAD, "loads": "press,press"}, ["-loads press,press:", "different names"]),
        ("gravity with one component", {"gravity": "-9.81"}, ["-gravity -9.81:", "2 numbers"]),
    ]),
    "method and time": Table(BLOCK, [
        ("shape function unknown", {"shape_function": "spline"}, ["-shape_function spline:", "cpgimp"]),
        ("stress update unknown", {"stress_update": "usx"}, ["-stress_update usx:", "usl, usf, musl"]),
        ("XPIC fraction 2", {"xpic_fraction": "2"}, ["-xpic_fraction 2:", "[0, 1]"]),
        ("XPIC order 3", {"xpic_order": "3"}, ["-xpic_order 3:", "[1, 2]"]),
        ("viscosity with one number", {"short_wave_viscosity": "0.01"}, ["-short_wave_viscosity 0.01:", "2 numbers"]),
        ("damping negative", {"damping": "-1"}, ["-damping -1:", ">= 0"]),
        ("time step over the limit", {"time_step": "1e-3"}, ["-time_step 0.001:", "<="]),
        ("cfl 0", {"cfl": "0"}, ["-cfl 0:", "(0, 1]"]),
        ("cfl 1.1", {"cfl": "1.1"}, ["-cfl 1.1:", "(0, 1]"]),
        ("end time negative", {"end_time": "-1"}, ["-end_time -1:", "> 0"]),
        ("end time empty", {"end_time": ""}, ["-end_time (nothing):", "> 0"]),
        ("max_steps negative", {"max_steps": "-1"}, ["-max_steps -1:", ">= 0"]),
        ("max_steps out of range", {"max_steps": "1e12"}, ["-max_steps 1e12:", "whole number"]),
        ("sort interval 0", {"sort_interval": "0"}, ["-sort_interval 0:"]),
        ("rebalance threshold 0.5", {"rebalance_threshold": "0.5"}, ["-rebalance_threshold 0.5:", ">= 1"]),
    ]),
    "steps": Table(BLOCK, [
        ("longer than damping allows", {"damping": 7000, "time_step": 3e-4, "max_steps": 10},
         ["-time_step 0.0003: must be <= 0.0001429, the inverse of -damping"]),
        # Steps of next to nothing: such runs once went on for ever, and filled their histories with rows of time 0.
        ("as fast as numbers go", {**ENDLESS, "block_velocity": "1e200,0"}, ["-end_time 1", "in reach; a step is"]),
        ("as stiff as numbers go", {**ENDLESS, "al_youngs_modulus": 1e300, "al_density": 1e-300}, ["-end_time 1", "in reach; a step is"]),
        ("of 1e-30 s", {**ENDLESS, "time_step": 1e-30}, ["-end_time 1", "in reach; a step is", "-time_step"]),
        ("by damping of 1e30", {**ENDLESS, "damping": 1e30}, ["-end_time 1", "in reach; a step is"]),
    ], every=1),
    "PETSc": Table(BLOCK, [
        ("an option of PETSc with text", {**WEDGE, "contact_ksp_atol": "tight"}, ["PETSc option", "tight"]),
        ("an option of a solver with text", {**WEDGE, "contact_ksp_type": "gmres", "contact_ksp_gmres_restart": "nonsense"}, ["nonsense"]),
        ("more options than PETSc holds", TOO_MANY, ["options", "512"]),
    ], every=1),
    "output": Table(BLOCK, [
        ("frames -1", {"frames": "-1"}, ["-frames -1:"]),
        ("history interval 0", {"history_interval": "0"}, ["-history_interval 0:"]),
        ("checkpoint interval is text", {"checkpoint_interval": "often"}, ["-checkpoint_interval often:", "whole"]),
        ("overwrite maybe", {"overwrite": "maybe"}, ["-overwrite maybe:", "true or false"]),
        ("output folder empty", {"output_dir": ""}, ["-output_dir (nothing):"]),
        ("output folder without end", {"output_dir": "0" * 5000}, ["-output_dir 000", "(5000 characters)", "folder"]),
        ("output folder is a file", {"output_dir": "a_file"}, ["-output_dir a_file:", "folder"]),
        ("output folder below a file", {"output_dir": "a_file/below"}, ["-output_dir a_file/below:", "folder"]),
        ("output folder cannot be created", {"output_dir": "/proc/mlgimp/results"}, ["-output_dir /proc/mlgimp/results:", "folder"]),
        ("output folder holds results", {"output_dir": "full"}, ["-output_dir full:", "-overwrite"]),
    ]),
    "restart": Table(BLOCK, [
        ("restart from nothing", {"restart": "gone.h5"}, ["-restart gone.h5:", "missing"]),
        ("restart from a path without end", {"restart": "0" * 5000}, ["-restart 000", "(5000 characters)", "missing"]),
        ("restart from a folder", {"restart": "full"}, ["-restart full:"]),
        ("restart from another kind of file", {"restart": "a_file"}, ["-restart a_file:", "whole checkpoint"]),
        ("restart from an empty file", {"restart": "empty.h5"}, ["-restart empty.h5:", "whole checkpoint"]),
        ("restart from other HDF5", {"restart": "other.h5"}, ["-restart other.h5:", "version of mlgimp"]),
        ("restart from a cut file", {"restart": "cut.h5"}, ["-restart cut.h5:", "whole checkpoint"]),
        ("restart from a file with parts missing", {"restart": "parts.h5"}, ["-restart parts.h5:", "missing"]),
        ("restart from a file with rows missing", {"restart": "rows.h5"}, ["-restart rows.h5:", "missing"]),
        ("restart of another format", {"restart": "version.h5"}, ["-restart version.h5: must have format version", "it has 999"]),
        ("restart of an older format", {"restart": "older.h5"}, ["-restart older.h5: must have format version", "it has 4"]),
        ("restart of another case", {"restart": "whole.h5", "al_density": "1001"}, ["-restart whole.h5:", "same case", "-al_density 1001"]),
        ("restart with more levels", {"restart": "whole.h5", "levels": "2", "level_1_lower": "0,4", "level_1_upper": "8,12"},
         ["-restart whole.h5:", "same case", "-levels"]),
        ("restart at the end", {"restart": "whole.h5", "max_steps": "10"}, ["-restart whole.h5:", "before the end"]),
        ("restart with too long a step", {"restart": "whole.h5", "time_step": "1e-3"}, ["-time_step 0.001:", "<="]),
        ("restart into the results of another run", {"restart": "whole.h5", "output_dir": "full"}, ["-output_dir full:", "-overwrite"]),
    ]),
    "levels": Table(LEVELS, [
        ("no level", {"levels": "0"}, ["-levels 0:", "[1, 16]"]),
        ("too many levels", {"levels": "17"}, ["-levels 17:", "[1, 16]"]),
        ("levels are text", {"levels": "two"}, ["-levels two:", "whole"]),
        ("ratio 1", {"refinement_ratio": "1"}, ["-refinement_ratio 1:", "[2, 16]"]),
        ("ratio 2.5", {"refinement_ratio": "2.5"}, ["-refinement_ratio 2.5:", "whole"]),
        ("a comma within a number", {"cell_size": "0,5"}, ["-cell_size 0,5:", "one number, and not 2 with commas"]),
        ("no box", without("level_1_lower"), ["-level_1_lower", "given"]),
        ("no upper corner of a box", without("level_1_upper"), ["-level_1_upper", "given"]),
        ("box off the cell lines", {"level_1_lower": "2.3,2"}, ["-level_1_lower 2.3,2:", "cell lines"]),
        ("box upside down", {"level_1_upper": "1,10"}, ["-level_1_upper 1,10:", "above -level_1_lower 2,2"]),
        ("box outside the domain", {"level_1_upper": "10,13"}, ["-level_1_upper 10,13:", "inside level 0", "y_upper"]),
        ("box too near its parent's border", {**THREE, "level_2_upper": "9,9"}, ["-level_2_upper 9,9:", "inside level 1", "x_upper"]),
        ("boxes of levels that are not there", {"level_2_lower": "4,4"}, ["-level_2_lower"]),
        ("coupling unknown", {"level_coupling": "glue"}, ["-level_coupling glue:", "nodes, points"]),
        ("blend width negative", {"blend_width": "-1"}, ["-blend_width -1:", "[0, 64]"]),
        ("ghost cells without copies", {"ghost_cells": "4"}, ["-ghost_cells"]),
        ("too few ghost cells", {"level_coupling": "points", "ghost_cells": "1"}, ["-ghost_cells 1:", "[2, 64]"]),
        ("ownership unknown", {"level_coupling": "points", "ghost_ownership": "mine"}, ["-ghost_ownership mine:", "flags, place"]),
        ("USF on levels", {"stress_update": "usf"}, ["-stress_update usf:", "usl or musl"]),
        ("points per rank 0", {"points_per_rank": "0"}, ["-points_per_rank 0:"]),
        ("indenter leaves the finest level", {**WEDGE, "max_steps": None, "indenter_max_depth": "5", "level_1_lower": "2,4"},
         ["-level_1_lower 2,4:", "indenter"]),
        ("indenter at a border", {**WEDGE, "indenter_tip": "2.5,8"}, ["-level_1_lower 2,2:", "indenter"]),
    ]),
    "command lines": Table(BLOCK, [
        ("a stray word", ["word"], ["'word'", "option"]),
        ("an option twice in the file", FILE, ["-frames 2:", "once", "line 3"], b"-frames 1\n-damping 1\n-frames 2\n"),
        ("a mistyped option in the file", FILE, ["-dampign", "nearest", "-damping"], b"-dampign 1\n"),
        ("a missing options file", ["-options_file", "gone.opts"], ["-options_file gone.opts:", "readable"]),
        ("an options file that is a folder", ["-options_file", "full"], ["-options_file full:", "readable"]),
        ("no options file after the option", ["-options_file"], ["-options_file", "readable"]),
        ("an empty options file", FILE, ["-options_file case.opts:", "options"], b""),
        ("a binary options file", FILE, ["-options_file case.opts:", "line 1"], bytes(range(256)) * 9),
        ("an options file without dashes", FILE, ["-options_file case.opts:", "line 1", "'frames'"], b"frames 20\n"),
        ("blanks in a value of the file", FILE, ["line 1", "no blanks", "'1'"], b"-gravity 0, 1\n"),
        ("a bad value in the file", FILE, ["-damping none:", ">= 0"], b"\n# comment\n-damping none\n"),
        ("an options file within the file", FILE, ["-options_file"], b"-options_file more.opts\n"),
        ("a control character in the file", FILE, ["line 2", "text"], b"-frames 1\n-damping \x1b[31m\n"),
        ("a null character in the file", FILE, ["line 1", "text"], b"-damping 1\0 2\n"),
        ("a value without end", FILE, ["line 1", "65535 characters"], b"-block_vertices " + b"1," * 40000 + b"\n"),
        ("a long value", FILE, ["-damping 111", "(5001 characters)", ">= 0"], b"-damping " + b"1" * 5000 + b"x\n"),
        ("a bad YAML file", ["-options_file", "case.yaml"], ["-options_file case.yaml:"], b"a: [1\nb: }\n"),
        ("an option twice in the file with one value", FILE, ["once"], b"-damping 1\n-damping 1\n"),
        ("capitals in the file", FILE, ["capitals"], b"-damping 1\n-Damping 2\n"),
        ("a byte-order mark", FILE, ["byte-order mark"], "\ufeff-damping 1\n".encode()),
        ("a no-break space", FILE, ["no-break space"], "-damping\u00a02\n".encode()),
        ("a name for a value", FILE, ["-frames"], b"-damping -frames\n"),
    ]),
}


def prepare():
    """A folder with files to restart from, a folder with results and a file in the way."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=harness.scratch()))
    made = harness.run({**BLOCK, "checkpoint_interval": 10, "max_steps": 20}, folder=folder / "made")
    whole = (made.folder / "checkpoint_000010.h5").read_bytes()
    (folder / "full").mkdir()
    (folder / "full" / "history.csv").write_text("step\n")
    (folder / "a_file").write_text("no results\n")
    for name in ("whole.h5", "version.h5", "older.h5", "parts.h5", "rows.h5"):
        (folder / name).write_bytes(whole)
    (folder / "cut.h5").write_bytes(whole[: 2 * len(whole) // 3])
    (folder / "empty.h5").write_bytes(b"")
    with h5py.File(folder / "other.h5", "w") as file:
        file["something"] = [1.0, 2.0]
    for name, version in (("version.h5", 999.0), ("older.h5", 4.0)):
        with h5py.File(folder / name, "a") as file:
            file.attrs["format_version"] = version
    with h5py.File(folder / "parts.h5", "a") as file:
        del file["level_0/stress"]
    with h5py.File(folder / "rows.h5", "a") as file:
        half = file["level_0/velocity"][: len(file["level_0/velocity"]) // 2]
        del file["level_0/velocity"]
        file["level_0/velocity"] = half
    return folder


@pytest.fixture(scope="module")
def files():
    return prepare()


@pytest.mark.mpi
@pytest.mark.parametrize("name", TABLES)
def test_refused(expect, files, name):
    expect_refused(expect, TABLES[name], files)


@pytest.mark.alone
def verify_on_three_ranks(study):
    """Bad input on three ranks.

    All that the tests refuse on one rank, a third of it on three, is refused here on three by the same line.
    """
    found, files = harness.Expectations(), prepare()
    for table in TABLES.values():
        expect_refused(found, table, files, on=3)
    count = sum(len(list(inputs(table))) for table in TABLES.values())
    study.expect(f"inputs that three ranks take or refuse otherwise, of {count}", len(found.missed), at_most=0)


def test_unreadable_file(tmp_path):
    file = tmp_path / "unreadable.opts"
    file.write_text("-damping 1\n")
    file.chmod(0)
    if os.access(file, os.R_OK):
        pytest.skip("this user may read every file")
    words = words_of({"output_dir": "out", **BLOCK}) + ["-options_file", file.name]
    problem = problem_of(words, tmp_path, 1, [f"-options_file {file.name}:", "readable"])
    assert not problem, problem
