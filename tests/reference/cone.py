"""Rigid cones on metals in CalculiX: a sector of two degrees of the axisymmetric block, loaded, and unloaded, slowly."""
from collections import namedtuple
from pathlib import Path

import numpy as np

from calculix import Grid, graded, number_set, run, write_csv

HERE = Path(__file__).resolve().parent
DEPTH, BACK = 0.2, 0.03      # depth, and how far the unloading goes, um
POISSON = 0.3
SECTOR = np.radians(1.0)     # half of it

# Angle from the axis, degrees; E and yield stress, GPa; width and depth of the finest elements and size of the largest, um, and their
# growth; radius of the surface that the cone may touch, um; increments of loading and of unloading.
Case = namedtuple("Case", "angle modulus yield_stress fine largest growth reach loading unloading")
BLUNT = Case(70.3, 130.0, 3.0, (1.0, 0.7), 4.0, 1.12, 1.5, 50, 60)
STEEP = Case(50.0, 90.0, 0.5, (1.2, 1.2), 2.0, 1.1, 0.8, 300, 0)


def size_of(case):
    """Of the block, um."""
    return 64 * DEPTH * np.tan(np.radians(case.angle))


def corner(x, y, side):
    """Coordinates of a point of the middle plane on one side (-1, 1) of the sector."""
    return f"{x * np.cos(SECTOR):.10g},{y:.10g},{side * x * np.sin(SECTOR):.10g}"


def body(grid, case):
    """Mesh of the sector, with the motions of its two sides tied to those of an axisymmetric body, supports and material."""
    rows, columns = range(grid.ny + 1), range(grid.nx + 1)
    lines = ["*NODE, NSET=BODY"]
    lines += [f"{grid.node(i, j, k)}," + corner(grid.xs[i], grid.ys[j], 2 * k - 1) for k in (0, 1) for j in rows for i in columns]
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=BODY")
    for j in range(grid.ny):
        for i in range(grid.nx):
            corners = [grid.node(i + a, j + b, k) for k in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
            lines.append(f"{grid.element(i, j)}," + ",".join(map(str, corners)))
    lines.append("*EQUATION")
    for j in rows:
        for i in columns:
            first, second = grid.node(i, j, 0), grid.node(i, j, 1)
            if i > 0:
                lines += [f"2\n{second},1,1.,{first},1,-1.", f"2\n{second},3,1.,{first},1,{-np.tan(SECTOR):.12g}",
                          f"2\n{first},3,1.,{first},1,{np.tan(SECTOR):.12g}"]
            if j > 0:
                lines.append(f"2\n{second},2,1.,{first},2,-1.")
    lines += number_set("NSET", "AXIS", [grid.node(0, j, k) for j in rows for k in (0, 1)])
    lines += number_set("NSET", "SIDE", [grid.node(grid.nx, j) for j in rows])
    lines += number_set("NSET", "BOTTOM", [grid.node(i, 0, k) for i in columns for k in (0, 1)])
    return lines + ["*BOUNDARY", "AXIS,1", "AXIS,3", "SIDE,1", "BOTTOM,2", "*MATERIAL, NAME=METAL", "*ELASTIC", f"{case.modulus},{POISSON}",
                    "*PLASTIC", f"{case.yield_stress},0.", "*SOLID SECTION, ELSET=BODY, MATERIAL=METAL"]


def cone(grid, case, size):
    """The rigid cone, a wedge over the narrow sector, and its frictionless contact, with a penalty by the size of the elements."""
    first, element, slope = grid.node_count() + 1, grid.element_count() + 1, 1 / np.tan(np.radians(case.angle))
    ends = ((-0.1, 0.0), (2.0, 0.0), (2.0, 1.0), (-0.1, 1.0))
    lines = ["*NODE, NSET=CONE"]
    lines += [f"{first + n + 4 * k},{x},{size_of(case) + slope * x + lift:.10g},{z}" for k, z in ((0, -0.2), (1, 0.2)) for n, (x, lift) in enumerate(ends)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=CONE", f"{element}," + ",".join(str(first + n) for n in range(8)),
              "*MATERIAL, NAME=RIGID", "*ELASTIC", f"{case.modulus},{POISSON}", "*SOLID SECTION, ELSET=CONE, MATERIAL=RIGID",
              "*SURFACE, NAME=FACE", f"{element},S3", "*SURFACE, NAME=SKIN"]
    lines += [f"{grid.element(i, grid.ny - 1)},S5" for i in range(grid.nx) if grid.xs[i] < case.reach]
    return lines + ["*SURFACE INTERACTION, NAME=SLIP", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{20 * case.modulus / size:g}",
                    "*CONTACT PAIR, INTERACTION=SLIP, TYPE=SURFACE TO SURFACE", "SKIN,FACE"]


def step(height, increments):
    """A static step that takes the cone to a height over its first place."""
    longest = f"{1 / increments:g}"
    return ["*STEP, NLGEOM, INC=5000", "*STATIC", f"{longest},1.,1e-6,{longest}", "*BOUNDARY", "CONE,1,1,0.", "CONE,3,3,0.",
            f"CONE,2,2,{height:.10g}", "*NODE PRINT, NSET=CONE, TOTALS=ONLY", "RF", "*END STEP"]


def press(workdir, name, case, size):
    """Rows of depth (m) and load (N) of loading and unloading; size: of the finest elements, um."""
    across, down = (graded(size, fine, size_of(case), case.growth, case.largest) for fine in case.fine)
    across[0] = 0.02 * size  # a pin in place of the axis
    grid = Grid(across, size_of(case) - down[::-1])
    deck = body(grid, case) + cone(grid, case, size) + step(-DEPTH, case.loading)
    if case.unloading:
        deck += step(BACK - DEPTH, case.unloading)
    data = run(workdir, f"{name}_h{size:g}", deck)
    times, loads = np.array([(time, -np.pi / SECTOR * rows[0, 1]) for time, rows in data["total", "CONE"]]).T
    depths = np.where(times <= 1, DEPTH * times, DEPTH - BACK * (times - 1))
    return np.column_stack([1e-6 * depths, 1e-3 * loads])


def cone_case(workdir):
    """Write cone_metal.csv and cone_steep.csv."""
    coarse, fine = (press(workdir, "cone", BLUNT, size) for size in (0.04, 0.02))
    write_csv(HERE / "cone_metal.csv",
              ["Rigid frictionless cone, half-angle 70.3 degrees, 200 nm deep and 30 nm back, on a metal without hardening:",
               "E 130 GPa, nu 0.3, yield stress 3 GPa (von Mises, on the Cauchy stress). Axisymmetric block of 64 x 64 times",
               "200 nm tan 70.3 deg = 35.74 um, rollers below and at its side; static. C3D8 (B-bar) in a sector of 2 degrees,",
               "square elements over 1.0 x 0.7 um below the tip, growing by 1.12 outwards to 4 um; surface-to-surface penalty.",
               "Load by size of the finest elements."], "depth_m,load_h40nm_N,load_h20nm_N", np.column_stack([coarse, fine[:, 1]]))
    coarse, fine = (press(workdir, "steep", STEEP, size)[2::3] for size in (0.04, 0.02))
    write_csv(HERE / "cone_steep.csv",
              ["Rigid frictionless cone, half-angle 50 degrees, 200 nm deep, on a metal without hardening: E 90 GPa, nu 0.3, yield",
               "stress 0.5 GPa. As cone_metal.csv, in a block of 15.26 um; square elements over 1.2 x 1.2 um, growing by 1.1 to 2 um.",
               "Load by size of the finest elements."], "depth_m,load_h40nm_N,load_h20nm_N", np.column_stack([coarse, fine[:, 1]]))
