"""Wrong options of indenters, contact, friction, load control, slow tests and boxes that follow: refused as other bad input is."""
import pytest

import following
import friction
import load_control
import quasi_static
from bad_input import BLOCK, POLYGON, WEDGE
from limits import PRESS
from refusals import Table, expect_refused
from tip_warnings import IN_SPACE, TIP

PUSHED = {"indenter_control": None, "indenter_loads": None, "end_time": None, "indenter_velocities_x": None, "indenter_times": "0",
          "indenter_velocities": "1", "indenter_friction": 0.1}
ROUND = {"geometry": "axisymmetric", "indenter_friction": 0.1, "indenter_width": None, "indenter_radius": 4, "indenter_tip": "0,16", "boundary_x_lower": None}
BY_PATH = {**following.FLIGHT, "level_1_lower": "2,2", "level_1_upper": "18,18", "level_follow": "path"}
PRESSED = {"indenter": "wedge", "indenter_half_angle": 70}
RASH = {"indenter_friction": 30, "indenter_velocities": 1e4}
SLIDING = {**friction.PUNCH, **friction.schedule(friction.TIMES, friction.LOADS, x=friction.along(friction.SPEED))}

TABLES = {
    "indenter and contact": Table(BLOCK, [
        ("indenter of another geometry", {**WEDGE, "indenter": "cone"}, ["-indenter cone:", "wedge", "plane_strain"]),
        ("indenter of no geometry", {**WEDGE, "indenter": "ball"}, ["-indenter ball:", "cube_corner"]),
        ("half-angle 90", {**WEDGE, "indenter_half_angle": "90"}, ["-indenter_half_angle 90:", "(0, 90)"]),
        ("indenter inside the body", {**WEDGE, "indenter_tip": "4,7.5"}, ["-indenter_tip 4,7.5:", "outside"]),
        ("indenter's times not increasing", {**WEDGE, "indenter_times": "0,0", "indenter_velocities": "1,2"},
         ["-indenter_times", "increasing"]),
        ("more times than velocities", {**WEDGE, "indenter_times": "0,1"}, ["-indenter_velocities", "as many as -indenter_times"]),
        ("indenter polygon not convex", {**POLYGON, "indenter_vertices": "0,0,4,3,2,3,2,2,-2,3"}, ["-indenter_vertices", "convex"]),
        ("indenter polygon with an odd number", {**POLYGON, "indenter_vertices": "0,0,1,1,-1,1,0"}, ["-indenter_vertices", "x,y pairs"]),
        ("depth out of reach", {**WEDGE, "max_steps": None, "indenter_velocities": "-1", "indenter_max_depth": "1"},
         ["-indenter_max_depth 1:", "reached"]),
        ("deeper than the domain", {**WEDGE, "max_steps": None, "indenter_velocities": "1", "indenter_max_depth": "1e3"},
         ["-indenter_max_depth 1e3: must be such that the tip stays in the domain", "where the domain ends at"]),
        ("tip below its depth", {**WEDGE, "indenter_tip": "4,1", "indenter_max_depth": "1"}, ["-indenter_tip 4,1:", "above y = "]),
        ("unloading speed 0", {**WEDGE, "indenter_max_depth": "1", "indenter_unload_velocity": "0"},
         ["-indenter_unload_velocity 0:", "not zero"]),
        ("contact unknown", {**WEDGE, "contact": "glue"}, ["-contact glue:", "pressure"]),
        ("contact solver unknown", {**WEDGE, "contact_ksp_type": "nonsense"}, ["-contact_ksp_type nonsense:", "cg"]),
        ("contact preconditioner unknown", {**WEDGE, "contact_pc_type": "nonsense"}, ["-contact_pc_type nonsense:", "jacobi"]),
        ("contact tolerance is text", {**WEDGE, "contact_ksp_rtol": "tight"}, ["-contact_ksp_rtol tight:"]),
        ("contact iterations is text", {**WEDGE, "contact_ksp_max_it": "many"}, ["-contact_ksp_max_it many:", "whole"]),
        ("contact tolerance negative", {**WEDGE, "contact_ksp_rtol": "-1"}, ["-contact_ksp_rtol -1:"]),
        ("contact tolerance of a tenth", {**WEDGE, "contact_ksp_rtol": "0.1"}, ["-contact_ksp_rtol 0.1:", "(0, 0.001]"]),
    ]),
    # Contact leaves out faces that do not lean toward the indenter: a steeper wedge once went through the body without a load. What is narrower than
    # a cell lies between the columns that pressures belong to. Of what is refused nothing is warned: speed and friction would have a line each.
    "needles": Table(PRESS, [
        *[(f"half-angle {angle}", {"indenter": "wedge", "indenter_half_angle": angle}, [f"-indenter_half_angle {angle}: must be above"])
          for angle in (5.6, 3, 0.01)],
        *[(f"flat punch {width} wide", {"indenter": "flat_punch", "indenter_width": width}, ["-indenter flat_punch: must be at least as wide as 1 m"])
          for width in (0.13, 0.99)],
        ("half a cell", {"indenter": "flat_punch", "indenter_width": 0.5, "indenter_max_depth": 0.05, "indenter_velocities": 20, "domain_upper": "16,12"},
         ["at least as wide"]),
        ("thin cylinder", {"indenter": "cylinder", "indenter_radius": 0.06}, ["-indenter cylinder: must be at least as wide as 1 m"]),
        ("thin polygon", {"indenter": "polygon", "indenter_vertices": "0,0,0.3,3,0,4,-0.3,3"}, ["-indenter polygon: must be at least as wide as 1 m"]),
        ("frames, with much to warn of", {**PRESSED, **RASH, "frames": -1}, ["-frames -1: must be"]),
        ("unread option, with much to warn of", {**PRESSED, **RASH, "indenter_radius": 1}, ["unknown or unused option"]),
        ("unloading that cannot end", {"indenter": "cylinder", "indenter_radius": 10, "indenter_max_depth": 0.1, "indenter_unload_velocity": 1e-300},
         ["must be in reach"]),
        # Depths in another unit: such runs went on until a point was strained too much, or ended in few steps.
        ("depth beyond the domain", {**PRESSED, "indenter_max_depth": 9}, ["where the domain ends at 8 m"]),
        ("end beyond the domain", {**PRESSED, "indenter_max_depth": None, "end_time": 0.2}, ["where the domain ends at 8 m"]),
    ]),
    # What is left of such tips and their mirror images carries less, down to a fifth, and is no indenter.
    "tips at sides of symmetry": Table(TIP, [
        *[(f"hardly off, {tip}", {"indenter_tip": tip}, ["must be on the side of symmetry x_lower"]) for tip in ("1e-6,8", "0.04,8")],
        *[(f"beyond {side}, {name}", {**changes, "indenter_tip": tip}, [f"must be inside {side}, a side of symmetry, at all times; the tip gets"])
          for name, changes, tip, side in (
              ("plane", {}, "-0.3,8", "x_lower"), ("far side", {"boundary_x_upper": "symmetry"}, "13,8", "x_upper"),
              ("space", {**IN_SPACE, "indenter_radius": None}, "0,-0.5,8", "y_lower"),
              ("later", {"indenter_times": "0,0.01", "indenter_velocities": "50,50", "indenter_velocities_x": "-500,-500"}, "4,8", "x_lower"))],
    ], every=1),
    "friction": Table(SLIDING, [
        ("below zero", {"indenter_friction": "-0.1"}, ["-indenter_friction -0.1:", ">= 0"]),
        ("not a number", {"indenter_friction": "nan"}, ["-indenter_friction nan:", ">= 0"]),
        ("minus infinite", {"indenter_friction": "-inf"}, ["-indenter_friction -inf:", ">= 0"]),
        ("a word", {"indenter_friction": "rough"}, ["-indenter_friction rough:", "inf"]),
        ("nothing", {"indenter_friction": ""}, ["-indenter_friction (nothing):", ">= 0"]),
        ("an empty word", ["-indenter_friction", ""], ["-indenter_friction (nothing):", ">= 0"]),
        ("a solver that needs the matrix", {"indenter_friction": 0.1, "contact_pc_type": "lu"}, ["-contact_pc_type lu:", "jacobi"]),
        ("two", {"indenter_friction": "0.1,0.2"}, ["-indenter_friction 0.1,0.2:", ">= 0"]),
        ("fewer speeds than times", {"indenter_velocities_x": "0,1"}, ["-indenter_velocities_x 2 values:", "as many as -indenter_times has: 5"]),
        ("speeds that are none", {"indenter_velocities_x": "0,0,0,0,fast"}, ["-indenter_velocities_x 0,0,0,0,fast:", "numbers"]),
        ("a third axis in the plane", {"indenter_velocities_y": "0,0,0,0,1"}, ["-indenter_velocities_y:"]),
        ("from a side of symmetry", {"indenter_tip": "0,16"}, ["-indenter_velocities_x:", "side of symmetry"]),
        ("out of a level", {"cell_size": 2, "levels": 2, "level_1_lower": "4,6", "level_1_upper": "24,20", "indenter_velocities_x": "0,0,0,0.4,0.4"},
         ["-level_1_upper 24,20:", "indenter's tip at x"]),
        ("multi-mesh contact", {**PUSHED, "contact": "multimesh"},
         ["-indenter_friction 0.1:", "-contact multimesh"]),
        ("pressures of points", {**PUSHED, "contact": "point_pressure"},
         ["-indenter_friction 0.1:", "-contact point_pressure"]),
        ("no contact", {**PUSHED, "contact": "none"},
         ["-indenter_friction 0.1:", "-contact none"]),
        ("sideways in axisymmetry", ROUND, ["-indenter_velocities_x:", "axisymmetric"]),
    ], ranks=2, every=8),
    "load control": Table(load_control.WEDGE, [
        ("times that do not increase", load_control.schedule((0, 1, 1), (0, 1, 1)), ["-indenter_times 1:", "increasing"]),
        ("loads of the wrong sign", load_control.schedule((0, 1), (0, -1)), ["-indenter_loads 0,-1:", ">= 0"]),
        ("no loads", {"indenter_times": "0,1"}, ["-indenter_loads:", "given"]),
        ("no times", {"indenter_loads": "0,1"}, ["-indenter_times:", "given"]),
        ("fewer loads than times", load_control.schedule((0, 1, 2), (0, 1)), ["-indenter_loads 2 values:", "as many as -indenter_times has: 3"]),
        ("velocities", {**load_control.schedule((0, 1), (0, 1)), "indenter_velocities": "0,1"}, ["-indenter_velocities 0,1:", "-indenter_control load"]),
        ("a largest depth", {**load_control.schedule((0, 1), (0, 1)), "indenter_max_depth": "1"}, ["-indenter_max_depth 1:", "-indenter_control load"]),
        ("loads with displacement control", {**load_control.schedule((0, 1), (0, 1)), "indenter_control": "displacement"},
         ["-indenter_loads 0,1:", "-indenter_control displacement"]),
        ("another contact", {**load_control.schedule((0, 1), (0, 1)), "contact": "multimesh"}, ["-contact multimesh:", "pressure"]),
        ("no such control", {**load_control.schedule((0, 1), (0, 1)), "indenter_control": "force"}, ["-indenter_control force:", "displacement, load"]),
    ], every=1),
    "slow tests": Table(quasi_static.CONE, [
        ("no indenter", {"indenter": None, "indenter_half_angle": None, "indenter_tip": None, "indenter_depths": None, "end_time": 1},
         ["-quasi_static true:", "-indenter"]),
        ("no end of the history", {"indenter_depths": None, "indenter_times": "0", "indenter_velocities": "1"}, ["-indenter_max_depth:", "-indenter_times"]),
        ("not to the surface", {"indenter_depths": None, "indenter_times": "0,1", "indenter_velocities": "-1,-1"}, ["-quasi_static true:", "surface"]),
        ("depths under load control", {"indenter_control": "load", "indenter_times": "0,1", "indenter_loads": "0,1"}, ["-indenter_control load:", "depths"]),
        ("no load", {**quasi_static.LOADS, "indenter_loads": "0,0,0,0"}, ["-quasi_static true:", "load above 0"]),
        ("pressures that change", {"loads": "p", "p_body": "block", "p_side": "y_upper", "p_times": "0,1", "p_pressures": "0,1"},
         ["-quasi_static true:", "not stretched"]),
        ("sideways motion, whose times would be others", {"indenter_velocities_x": "0,1"}, ["-indenter_velocities_x 0,1:", "-quasi_static"]),
        ("too large a tolerance", {"quasi_static_tolerance": 0.5}, ["-quasi_static_tolerance 0.5:", "0.1"]),
        ("depths of a fast test", {"quasi_static": "false", "indenter_times": "0,1", "indenter_velocities": "1,1", "end_time": 1}, ["-indenter_depths", "unused"]),
    ]),
    "boxes that follow": Table({}, [
        ("no indenter", {**following.FLIGHT, "level_follow": "contact"}, ["-level_follow contact:", "-indenter"]),
        ("copies", {**following.WEDGE, "level_coupling": "points"}, ["-level_follow contact:", "-level_coupling points"]),
        ("counts", {**following.CONE, "level_cells_min": 10}, ["-level_cells_max 16:", ">= 30"]),
        ("kind", {**following.CONE, "level_follow": "tip"}, ["-level_follow", "none, contact, path"]),
        ("margin", {**following.CONE, "level_2_margin": -3}, ["-level_2_margin"]),
        ("margins", {**following.CONE, "level_2_margin": "3,4,5"}, ["-level_2_margin"]),
        ("unknown level", {**following.CONE, "level_4_margin": 3}, ["-level_4_margin", "unknown or unused option"]),
        ("too fast for the cells", {**following.CONE, "levels": 13}, ["-level_follow contact: the tip goes", "that level 12 keeps free"]),
        ("interval", {**following.CONE, "regrid_interval": 0}, ["-regrid_interval 0"]),
        ("path without times", {**BY_PATH, "level_1_path": "0,0"},
         ["-level_1_times"]),
        ("times without path", {**BY_PATH, "level_1_times": "0,1"},
         ["-level_1_path", "0 numbers"]),
        ("numbers", {**BY_PATH, "level_1_times": "0,1", "level_1_path": "0,1,2"},
         ["-level_1_path 3 numbers", "2 for each time"]),
        ("a path away from the tip", {**following.SCRATCH, "level_1_path": "0,0,9,0,9,0"}, ["-level_1_lower 9,4: must be at least 3.5", "from the indenter's tip at x = 12 at time"]),
        ("a tip that leaves its path", {**following.SCRATCH, "indenter_velocities_x": "0,0,0.05,0.05"}, ["-level_1_upper 2", "must be at least 3.5", "from the indenter's tip at x = "]),
        ("a jump away from the tip", {**following.SCRATCH, "level_1_times": "0,10,10.001", "level_1_path": "0,0,0,0,24,0"}, ["-level_1_path: must be such that the level's box contains", "has left it"]),
        ("boxes as well", {**following.CONE, "level_1_lower": "0,0"}, ["-level_1_lower", "unknown or unused option"]),
        ("out of the domain", {**BY_PATH, "level_1_times": "0,10", "level_1_path": "0,0,100,0"},
         ["-level_1_path: must be such that the level's box stays within level 0", "33,2 to 49,18 at time 3", "in 0,0 to 48,20"]),
    ], every=4),
}


@pytest.mark.mpi
@pytest.mark.parametrize("name", TABLES)
def test_refused(expect, name):
    expect_refused(expect, TABLES[name])
