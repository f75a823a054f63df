"""What is needed to compute with CalculiX (ccx): meshes and cards of decks, running them, reading what was printed.

Decks are in um, ns and GPa (so forces are in mN and densities in g/cm3). Plane strain is one layer of C3D8 elements,
1 um thick, with u_z = 0 and the back nodes tied to the front ones.
"""
import os
import re
import subprocess
import time
from pathlib import Path

import numpy as np

STVK, NEO_HOOKE = ("SOLID", "*ELASTIC"), ("CIARLET_EL", "*USER MATERIAL, CONSTANTS=2")
LAW_NAMES = {STVK: "St. Venant-Kirchhoff", NEO_HOOKE: "neo-Hookean (Ciarlet)"}
FIELD_CONTROLS = "*CONTROLS, PARAMETERS=FIELD\n1e-4, 1e-3"


# ---------------------------------------------------------------- deck pieces

class Grid:
    """Structured one-layer hexahedral mesh over the lines xs, ys."""

    def __init__(self, xs, ys):
        self.xs, self.ys = np.asarray(xs), np.asarray(ys)
        self.nx, self.ny = len(xs) - 1, len(ys) - 1

    def node(self, i, j, k=0):
        """Number of the node on lines i, j of layer k."""
        return 1 + i + (self.nx + 1) * (j + (self.ny + 1) * k)

    def element(self, i, j):
        """Number of the element in column i, row j."""
        return 1 + i + self.nx * j

    def node_count(self):
        """Number of nodes of both layers."""
        return 2 * (self.nx + 1) * (self.ny + 1)

    def element_count(self):
        """Number of elements."""
        return self.nx * self.ny

    def deck(self, material, law=STVK):
        """Mesh, supports (rollers on the left and the bottom) and material."""
        rows, columns = range(self.ny + 1), range(self.nx + 1)
        lines = ["*NODE, NSET=BODY"]
        for k in (0, 1):
            lines += [f"{self.node(i, j, k)},{self.xs[i]:.9g},{self.ys[j]:.9g},{k}"
                      for j in rows for i in columns]
        lines.append("*ELEMENT, TYPE=C3D8, ELSET=BODY")
        for j in range(self.ny):
            for i in range(self.nx):
                corners = [self.node(i + a, j + b, k) for k in (0, 1)
                           for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                lines.append(f"{self.element(i, j)}," + ",".join(map(str, corners)))
        lines += number_set("NSET", "LEFT", [self.node(0, j, k) for j in rows for k in (0, 1)])
        lines += number_set("NSET", "BOTTOM", [self.node(i, 0, k) for i in columns for k in (0, 1)])
        lines += ["*BOUNDARY", "LEFT,1", "BOTTOM,2", "BODY,3", "*EQUATION"]
        for j in rows:
            for i in columns:
                for d in [1] * (i > 0) + [2] * (j > 0):
                    lines.append(f"2\n{self.node(i, j, 1)},{d},1.,{self.node(i, j)},{d},-1.")
        young, poisson, density = material
        lines += [f"*MATERIAL, NAME={law[0]}", law[1], f"{young},{poisson}",
                  "*DENSITY", f"{density}", f"*SOLID SECTION, ELSET=BODY, MATERIAL={law[0]}"]
        return lines


def graded(size, fine, length, growth=1.1, largest=1.0):
    """Lines from 0 to length: uniform up to fine, then growing to largest."""
    steps = [size] * round(fine / size)
    while sum(steps) < length:
        steps.append(min(steps[-1] * growth, largest))
    lines = np.concatenate([[0.0], np.cumsum(steps)])
    uniform = round(fine / size)
    excess = (length - lines[uniform]) / (lines[-1] - lines[uniform])
    lines[uniform:] = lines[uniform] + excess * (lines[uniform:] - lines[uniform])
    return lines


def number_set(kind, name, numbers):
    """A *NSET or *ELSET card."""
    return [f"*{kind}, {kind}={name}"] + [str(n) for n in numbers]


def ramp(name, points):
    """A tabular *AMPLITUDE card through (time, value) points."""
    return [f"*AMPLITUDE, NAME={name}"] + [f"{t:.9g},{v:.9g}" for t, v in points]


def dynamic_step(increment, duration, alpha=-0.05):
    """Head of an implicit geometrically nonlinear step of fixed increments."""
    count = round(duration / increment)
    return [f"*STEP, NLGEOM, INC={count + 10}", FIELD_CONTROLS,
            f"*DYNAMIC, DIRECT, ALPHA={alpha}", f"{increment:.9g},{duration:.9g}"]


# ------------------------------------------------------- running and reading

def run(workdir, name, lines):
    """Write the deck, run ccx (one thread) unless its result is there, read it."""
    deck = Path(workdir) / f"{name}.inp"
    data = deck.with_suffix(".dat")
    text = "\n".join(lines) + "\n"
    if not (data.exists() and deck.exists() and deck.read_text() == text):
        deck.parent.mkdir(parents=True, exist_ok=True)
        deck.write_text(text)
        environment = dict(os.environ, OMP_NUM_THREADS="1", CCX_NPROC_EQUATION_SOLVER="1")
        start = time.time()
        with open(deck.with_suffix(".log"), "w") as log:
            subprocess.run(["ccx", name], cwd=deck.parent, stdout=log, env=environment)
        print(f"{name}: {time.time() - start:.0f} s of wall clock")
    return read_dat(data)


def number(word):
    """Value of a printed number; ccx drops the E of three-digit exponents."""
    return float(re.sub(r"(\d)([+-]\d{3})$", r"\1E\2", word))


def read_dat(path):
    """Blocks of a .dat file: {(first word, set): [(time, array), ...]}."""
    blocks, rows = {}, None
    for line in open(path):
        if " for set " in line:
            words = line.split()
            name = words[words.index("set") + 1]
            rows = []
            blocks.setdefault((words[0], name), []).append((float(words[-1]), rows))
        elif line.strip() and rows is not None:
            rows.append([number(w) for w in line.split()])
    return {key: [(t, np.array(r)) for t, r in value] for key, value in blocks.items()}


def at_time(series, when):
    """The block of a series at a time, or None if the run stopped before it."""
    t, rows = min(series, key=lambda block: abs(block[0] - when))
    return rows if abs(t - when) < 1e-6 * max(when, 1.0) else None


def value_at(history, when):
    """Second column of a history at a time, or nan if the run stopped before it."""
    row = history[np.abs(history[:, 0] - when).argmin()]
    return row[1] if abs(row[0] - when) < 1e-12 else np.nan


def element_means(rows, column):
    """Mean over the integration points of each element: {element: value}."""
    elements = rows[:, 0].astype(int)
    return {e: rows[elements == e, column].mean() for e in np.unique(elements)}


def write_csv(path, comments, header, rows):
    """Write rows to a file under '#' comments and a column header."""
    with open(path, "w") as out:
        out.writelines(f"# {line}\n" for line in comments)
        out.write(header + "\n")
        out.writelines(",".join(f"{v:.7g}" for v in row) + "\n" for row in rows)
