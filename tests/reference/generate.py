#!/usr/bin/env python3
"""Computes the finite-element reference results with CalculiX (ccx 2.20).

    generate.py CASE WORKDIR

CASE is one of the keys of CASES at the end of this file. The decks and the raw results go to WORKDIR, the CSV files, in
SI units, to the folder of this file.
"""
import argparse
from pathlib import Path

import numpy as np

from calculix import (LAW_NAMES, NEO_HOOKE, STVK, Grid, at_time, dynamic_step, element_means, graded, number_set, ramp,
                      run, value_at, write_csv)
from cone import cone_case

HERE = Path(__file__).resolve().parent
SILICON, ALUMINIUM = (170.0, 0.18, 2.33), (70.0, 0.33, 2.70)  # Young's modulus, Poisson's ratio, density


# -------------------------------------------------------------------- tension

def run_tension(workdir, size, increment, peak):
    """Pull the 60 x 40 um silicon block; elements of size um, peak in GPa."""
    grid = Grid(np.linspace(0, 60, round(60 / size) + 1), np.linspace(0, 40, round(40 / size) + 1))
    middle = grid.ny // 2
    every = round(0.25 / increment)
    lines = grid.deck(SILICON)
    lines += number_set("NSET", "END", [grid.node(grid.nx, j) for j in range(grid.ny + 1)])
    lines += number_set("ELSET", "ENDFACE", [grid.element(grid.nx - 1, j) for j in range(grid.ny)])
    lines += number_set("ELSET", "MID", [grid.element(i, j) for i in range(grid.nx)
                                         for j in (middle - 1, middle)])
    lines += ramp("PULL", [(0, 0), (12.5, 1), (25, 1)])
    lines += dynamic_step(increment, 25.0)
    lines += ["*DLOAD, AMPLITUDE=PULL", f"ENDFACE,P4,{-peak}",
              f"*NODE PRINT, NSET=END, FREQUENCY={every}", "U",
              f"*EL PRINT, ELSET=MID, FREQUENCY={every}", "S", "*END STEP"]
    name = f"tension_p{peak:g}_h{size:g}_dt{increment:g}"
    return grid, run(workdir, name, lines)


def tension_history(data):
    """Rows of time and mean, bottom and top x displacement of the end (SI)."""
    rows = [[0.0] * 4]
    for t, block in data["displacements", "END"]:
        u = block[:, 1]
        mean = (u.sum() - 0.5 * (u[0] + u[-1])) / (len(u) - 1)
        rows.append([t * 1e-9, mean * 1e-6, u[0] * 1e-6, u[-1] * 1e-6])
    return np.array(rows)


def tension_profile(grid, data, when):
    """Rows of x and Cauchy stress_xx along y = 20 um (SI)."""
    means = element_means(at_time(data["stresses", "MID"], when), 2)
    middle = grid.ny // 2
    rows = []
    for i in range(grid.nx):
        stress = 0.5 * (means[grid.element(i, middle - 1)] + means[grid.element(i, middle)])
        rows.append([0.5e-6 * (grid.xs[i] + grid.xs[i + 1]), stress * 1e9])
    return rows


def tension_case(workdir):
    """Write tension.csv and tension_profile.csv."""
    history, profile, notes = [], [], []
    for peak in (1.0, 8.0):
        _, coarse = run_tension(workdir, 2.0, 0.05, peak)
        _, small = run_tension(workdir, 2.0, 0.025, peak)
        grid, fine = run_tension(workdir, 1.0, 0.05, peak)
        runs = [tension_history(data) for data in (coarse, small, fine)]
        for when in (12.5, 25.0):
            values = [value_at(rows, when * 1e-9) for rows in runs]
            notes.append("  {:g} GPa, {:g} ns: {:.6e} (2 um), {:.6e} (2 um, 25 ps), {:.6e} (1 um)"
                         .format(peak, when, *values))
            profile += [[peak * 1e9, when * 1e-9, *row] for row in tension_profile(grid, fine, when)]
        history += [[peak * 1e9, *row] for row in runs[-1]]
    setting = ["Tension on the end x = 60 um of a 60 x 40 um silicon block, rollers on x = 0 and y = 0.",
               "Plane strain, 1 um thick; E 170 GPa, nu 0.18, rho 2330 kg/m3, St. Venant-Kirchhoff.",
               "Follower traction, 0 -> peak over 12.5 ns, then constant to 25 ns.",
               "C3D8 (B-bar), 1 um square elements, implicit alpha method (-0.05), 50 ps increments."]
    write_csv(HERE / "tension.csv", setting + ["x displacement (m) of the end: mean over y, at y = 0, at y = 40 um.",
              "Mean at the end of the ramp and of the run, by mesh and increment:"] + notes,
              "peak_Pa,time_s,ux_mean_m,ux_bottom_m,ux_top_m", history)
    write_csv(HERE / "tension_profile.csv", setting + ["Cauchy stress_xx on y = 20 um (reference): mean of the two",
              "elements that share this line; x is the reference position of the element centre."],
              "peak_Pa,time_s,x_m,stress_xx_Pa", profile)


# ------------------------------------------------------------------- pressure

def run_pressure(workdir, size, increment, peak, law=STVK):
    """Press the 30 x 40 um silicon half model on 0 <= x <= 4 um; peak in GPa."""
    grid = Grid(np.linspace(0, 30, round(30 / size) + 1), np.linspace(0, 40, round(40 / size) + 1))
    every = round(0.2 / increment)
    top = grid.ny - 1
    lines = grid.deck(SILICON, law)
    lines += number_set("NSET", "TOP", [grid.node(i, grid.ny) for i in range(round(6 / size) + 1)])
    lines += number_set("ELSET", "LOADED", [grid.element(i, top) for i in range(round(4 / size))])
    lines += number_set("ELSET", "AXIS", [grid.element(0, j) for j in range(grid.ny)])
    lines += ramp("PUSH", [(0, 0), (30, 1), (40, 1)])
    lines += dynamic_step(increment, 40.0)
    lines += ["*DLOAD, AMPLITUDE=PUSH", f"LOADED,P5,{peak}",
              f"*NODE PRINT, NSET=TOP, FREQUENCY={every}", "U",
              f"*EL PRINT, ELSET=AXIS, FREQUENCY={every}", "S", "*END STEP"]
    name = f"pressure{'_nh' * (law is NEO_HOOKE)}_p{peak:g}_h{size:g}_dt{increment:g}"
    return grid, run(workdir, name, lines)


def pressure_history(data):
    """Rows of time and y displacement of the top node on the axis (SI)."""
    rows = [[0.0, 0.0]]
    rows += [[t * 1e-9, block[0, 2] * 1e-6] for t, block in data["displacements", "TOP"]]
    return np.array(rows)


def axis_profile(grid, data, when):
    """Rows of reference y and Cauchy stress_yy in the first element column (um, GPa)."""
    block = at_time(data["stresses", "AXIS"], when)
    if block is None:
        return []
    means = element_means(block, 3)
    return [[0.5 * (grid.ys[j] + grid.ys[j + 1]), means[grid.element(0, j)]]
            for j in range(grid.ny)]


STVK_COLLAPSE = ["At 60 GPa the run stops after 18 ns (36 GPa): there the St. Venant-Kirchhoff",
                 "law loses its stiffness in compression and the loaded elements collapse."]


def write_pressure(workdir, name, law, cases, notes):
    """Write NAME.csv and NAME_axis.csv; cases are (peak, times of the profiles)."""
    history, profile, meshes = [], [], []
    for peak, times in cases:
        _, coarse = run_pressure(workdir, 1.0, 0.1, peak, law)
        grid, fine = run_pressure(workdir, 0.5, 0.1, peak, law)
        rough, best = pressure_history(coarse), pressure_history(fine)
        for when in times:
            at_1um, at_05um = (value_at(rows, when * 1e-9) for rows in (rough, best))
            meshes.append(f"  {peak:g} GPa, {when} ns: {at_1um:.5e} (1 um), {at_05um:.5e} (0.5 um)")
            profile += [[peak * 1e9, when * 1e-9, y * 1e-6, s * 1e9]
                        for y, s in axis_profile(grid, fine, when)]
        history += [[peak * 1e9, *row] for row in best]
    setting = ["Pressure on 0 <= x <= 4 um of the top of a 30 x 40 um silicon half model.",
               f"Plane strain, 1 um thick; E 170 GPa, nu 0.18, rho 2330 kg/m3, {LAW_NAMES[law]}.",
               "Follower pressure, 0 -> peak over 30 ns, then constant to 40 ns.",
               "C3D8 (B-bar), 0.5 um square elements, implicit alpha method (-0.05), 0.1 ns increments."]
    write_csv(HERE / f"{name}.csv", setting + ["y displacement (m) of the node x = 0, y = 40 um."] + notes
              + ["The same by mesh:"] + meshes, "peak_Pa,time_s,uy_m", history)
    write_csv(HERE / f"{name}_axis.csv", setting + ["Cauchy stress_yy, mean of the element column next to the",
              "axis (centres at x = 0.25 um); y is the reference height of the element centre."],
              "peak_Pa,time_s,y_m,stress_yy_Pa", profile)


def pressure_case(workdir):
    """Write the results of both material laws."""
    write_pressure(workdir, "pressure", STVK,
                   [(6.0, (10, 20, 30, 40)), (60.0, (5, 10, 15, 18))], STVK_COLLAPSE)
    write_pressure(workdir, "pressure_neohooke", NEO_HOOKE, [(60.0, (10, 20, 30, 40))], [])


# ---------------------------------------------------------------------- wedge

WEDGE_SLOPE = np.tan(np.radians(90.0 - 70.3))
WEDGE_LENGTH = 8.0


def wedge_deck(grid, stiffness):
    """Rigid wedge (one hexahedron, all nodes driven) and its frictionless contact."""
    top, first = grid.ys[-1], grid.node_count() + 1
    ends = ((-0.5, 0.0), (WEDGE_LENGTH, 0.0), (WEDGE_LENGTH, 1.0), (-0.5, 1.0))
    lines = ["*NODE, NSET=WEDGE"]
    for k, z in ((0, -0.5), (4, 1.5)):
        lines += [f"{first + k + n},{x},{top + WEDGE_SLOPE * x + lift:.9f},{z}"
                  for n, (x, lift) in enumerate(ends)]
    corners = ",".join(str(first + n) for n in range(8))
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=WEDGE", f"{grid.element_count() + 1},{corners}",
              "*MATERIAL, NAME=RIGID", "*ELASTIC", "1.,0.", "*DENSITY", "1e-6",
              "*SOLID SECTION, ELSET=WEDGE, MATERIAL=RIGID",
              "*SURFACE, NAME=FACE", f"{grid.element_count() + 1},S3",
              "*SURFACE, NAME=SKIN"]
    lines += [f"{grid.element(i, grid.ny - 1)},S5" for i in range(grid.nx)
              if grid.xs[i] < 0.8 * WEDGE_LENGTH]
    return lines + ["*SURFACE INTERACTION, NAME=SLIP",
                    "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness:g}",
                    "*CONTACT PAIR, INTERACTION=SLIP, TYPE=SURFACE TO SURFACE", "SKIN,FACE"]


def flywheel_deck(grid, duration):
    """A detached heavy block moving at constant speed.

    ccx stops a dynamic contact run when the energy balance jumps by 0.25 % of
    the largest energy so far, which the first touch always does; the kinetic
    energy of this block makes that test harmless and acts on nothing else.
    """
    node, element, speed = grid.node_count() + 9, grid.element_count() + 2, 1e-3
    corners = [(x, y, z) for z in (0, 1) for x, y in ((-20, 0), (-19, 0), (-19, 1), (-20, 1))]
    lines = ["*NODE, NSET=FLYWHEEL"]
    lines += [f"{node + n},{x},{y},{z}" for n, (x, y, z) in enumerate(corners)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=FLYWHEEL",
              f"{element}," + ",".join(str(node + n) for n in range(8)),
              "*MATERIAL, NAME=HEAVY", "*ELASTIC", "1.,0.", "*DENSITY", "2e12",
              "*SOLID SECTION, ELSET=FLYWHEEL, MATERIAL=HEAVY",
              "*INITIAL CONDITIONS, TYPE=VELOCITY", f"FLYWHEEL,1,{speed}"]
    return lines + ramp("SPIN", [(0, 0), (duration, speed * duration)])


def run_wedge(workdir, name, grid, drive, increment, every, stiffness, law=STVK):
    """Push the wedge along drive, the (time, depth) points; print every few increments."""
    lines = grid.deck(ALUMINIUM, law) + wedge_deck(grid, stiffness)
    lines += flywheel_deck(grid, drive[-1][0])
    lines += number_set("ELSET", "AXIS", [grid.element(0, j) for j in range(grid.ny)])
    lines += number_set("NSET", "SKIN", [grid.node(i, grid.ny) for i in range(grid.nx + 1)
                                         if grid.xs[i] < 0.8 * WEDGE_LENGTH])
    lines += ramp("DRIVE", drive) + dynamic_step(increment, drive[-1][0])
    lines += ["*BOUNDARY, AMPLITUDE=SPIN", "FLYWHEEL,1,1,1.", "FLYWHEEL,2,3,0.",
              "*BOUNDARY, AMPLITUDE=DRIVE", "WEDGE,1,1,0.", "WEDGE,3,3,0.", "WEDGE,2,2,-1.",
              f"*NODE PRINT, NSET=WEDGE, TOTALS=ONLY, FREQUENCY={every}", "RF",
              f"*NODE PRINT, NSET=SKIN, FREQUENCY={every}", "U",
              f"*EL PRINT, ELSET=AXIS, FREQUENCY={every}", "S", "*END STEP"]
    return run(workdir, name, lines)


def shallow_wedge(workdir, size, increment, stiffness=5e4, law=STVK):
    """The 450 nm case: 30 x 40 um half model, wedge at 20 m/s."""
    grid = Grid(graded(size, 1.0, 30.0), 40.0 - graded(size, 0.6, 40.0)[::-1])
    name = f"wedge{'_nh' * (law is NEO_HOOKE)}_h{size:g}_dt{increment:g}_k{stiffness:g}"
    every = round(0.25 / increment)
    drive = [(0, 0), (22.5, 0.45)]
    return grid, run_wedge(workdir, name, grid, drive, increment, every, stiffness, law)


def wedge_load(data):
    """Rows of time and load on the half model (SI)."""
    rows = [[0.0, 0.0]]
    rows += [[t * 1e-9, -block[0, 1] * 1e-3] for t, block in data["total", "WEDGE"]]
    return np.array(rows)


def stress_below(grid, data, when, depths):
    """Cauchy stress_yy (Pa) on the axis at depths (um) below the original surface."""
    heights, stresses = zip(*axis_profile(grid, data, when))
    return [1e9 * np.interp(grid.ys[-1] - depth, heights, stresses) for depth in depths]


def wedge_setting(law):
    """Comment lines that state the wedge problem."""
    return ["Rigid frictionless wedge, half-angle 70.3 degrees, 20 m/s, on aluminium, to 450 nm.",
            "Half model 30 x 40 um, rollers on x = 0 and y = 0; plane strain, 1 um thick; E 70 GPa,",
            f"nu 0.33, rho 2700 kg/m3, {LAW_NAMES[law]}; the wedge touches at t = 0.",
            "C3D8 (B-bar), implicit alpha method (-0.05), 0.125 ns increments; surface-to-surface",
            "penalty 5e19 Pa/m (overclosure 0.4 nm).  Square elements over 1.0 x 0.6 um below the",
            "tip, growing by 1.1 outwards to 1 um; no averaging in time."]


def write_wedge(workdir, name, law, meshes, notes):
    """Write NAME.csv and NAME_axis.csv; meshes are (element size, last valid time in ns)."""
    runs = [shallow_wedge(workdir, size, 0.125, law=law) for size, _ in meshes]
    loads = [wedge_load(data) for _, data in runs]
    times = loads[0][:, 0]
    columns = [[value_at(load, t) if t < 1e-9 * last + 1e-12 else np.nan for t in times]
               for load, (_, last) in zip(loads, meshes)]
    header = "time_s,depth_m," + ",".join(f"load_h{1000 * size:.0f}nm_N" for size, _ in meshes)
    write_csv(HERE / f"{name}.csv", wedge_setting(law)
              + ["Load on the half model (N) by size of the finest elements."] + notes,
              header, np.column_stack([times, 20.0 * times] + columns))
    table = []
    for (size, last), (grid, data) in zip(meshes, runs):
        table += [[size * 1e-6, 20.0 * when * 1e-9,
                   *stress_below(grid, data, when, (1.0, 2.0, 5.0, 10.0))]
                  for when in (5.0, 10.0, 15.0, 20.0, 22.5) if when <= last]
    write_csv(HERE / f"{name}_axis.csv", wedge_setting(law)
              + ["Cauchy stress_yy (Pa) of the material points on the axis that lay 1, 2, 5, 10 um",
                 "below the surface: means of the elements next to the axis, interpolated in y."],
              "mesh_m,depth_m,syy_1um_Pa,syy_2um_Pa,syy_5um_Pa,syy_10um_Pa", table)


def wedge_case(workdir):
    """Write the results of both material laws."""
    base, halved_step, doubled_penalty = (
        wedge_load(shallow_wedge(workdir, 0.0625, increment, stiffness)[1])
        for increment, stiffness in ((0.125, 5e4), (0.0625, 5e4), (0.125, 1e5)))
    notes = ["nan: at a depth of ten elements the element at the tip collapses, the limit of the",
             "law in compression.  Sensitivities of the 62 nm mesh:"]
    notes += ["  {:.0f} nm: {:.5e}, {:.5e} (half the increment), {:.5e} (twice the penalty)"
              .format(20 * t, *(value_at(load, t * 1e-9)
                                for load in (base, halved_step, doubled_penalty)))
              for t in (5.0, 10.0, 15.0, 20.0, 22.5)]
    write_wedge(workdir, "wedge", STVK,
                [(0.125, 22.5), (0.0625, 22.5), (0.05, 22.5), (0.03125, 15.0)], notes)
    write_wedge(workdir, "wedge_neohooke", NEO_HOOKE, [(0.125, 22.5), (0.0625, 22.5)], [])


def levels_case(workdir):
    """Write levels.csv."""
    loads = [wedge_load(five_level_wedge(workdir, size, 0.05)) for size in (0.5, 0.35, 0.25)]
    times = loads[0][:, 0]
    columns = [[value_at(load, t) if t < limit * 1e-9 else np.nan for t in times]
               for load, limit in zip(loads, (24, 24, 20.5))]
    rows = np.column_stack([times, [1e-6 * five_level_depth(t * 1e9) for t in times]] + columns)
    write_csv(HERE / "levels.csv",
              ["Rigid frictionless wedge, half-angle 70.3 degrees, on aluminium, to 2 um depth:",
               "speed 0 -> 150 m/s over 20 ns, then constant.  Half model 125 x 125 um, rollers on",
               "x = 0 and y = 0; plane strain, 1 um thick; E 70 GPa, nu 0.33, rho 2700 kg/m3,",
               "St. Venant-Kirchhoff; the wedge touches at t = 0.  C3D8 (B-bar), implicit alpha",
               "method (-0.05), 0.05 ns increments; surface-to-surface penalty 5e19 Pa/m.",
               "Square elements over 2.5 x 1.5 um below the tip, growing by 1.1 outwards to 2 um.",
               "nan: at a depth of about six elements the element at the tip collapses, the limit",
               "of the law in compression.",
               "Load on the half model (N) by size of the finest elements."],
              "time_s,depth_m,load_h500nm_N,load_h350nm_N,load_h250nm_N", rows)


def five_level_depth(t):
    """Depth (um) of the ramped wedge at a time (ns)."""
    return 0.00375 * min(t, 20.0) ** 2 + 0.15 * max(t - 20.0, 0.0)


def five_level_wedge(workdir, size, increment, stiffness=5e4):
    """The ramped case: 125 x 125 um half model, 0 -> 150 m/s over 20 ns, to 2 um depth."""
    across = graded(size, 2.5, 125.0, largest=2.0)
    down = 125.0 - graded(size, 1.5, 125.0, largest=2.0)[::-1]
    times = np.append(np.linspace(0, 20, 401), 20 + 0.5 / 0.15)
    drive = [(t, five_level_depth(t)) for t in times]
    name = f"levels_h{size:g}_dt{increment:g}_k{stiffness:g}"
    every = round(0.2 / increment)
    return run_wedge(workdir, name, Grid(across, down), drive, increment, every, stiffness)


CASES = {"tension": tension_case, "pressure": pressure_case,
         "wedge": wedge_case, "levels": levels_case, "cone": cone_case}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", choices=CASES)
    parser.add_argument("workdir", help="folder for decks and raw results; a run whose deck has not changed is only read")
    arguments = parser.parse_args()
    CASES[arguments.case](arguments.workdir)
