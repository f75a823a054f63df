"""Curves, runs and files that tests of the analysis of indentation make, and its command."""
import json
import math
import re
import runpy

import numpy as np
import pytest

import harness
from mlgimp import tips
from mlgimp.load_depth import Curve
from test_scripts import HISTORY

main = runpy.run_path(str(harness.ROOT / "scripts" / "indentation.py"))["main"]  # a module of that name is in tests/cases
CONE = tips.make_tip("cone", half_angle=70.3)
TAN = math.tan(math.radians(70.3))


def curve(depth, load, area=None, tip=CONE, poisson=0.3, time=None, is_run=False):
    cells, block = (np.full(len(depth), 8.0), np.full(len(depth), 20.0)) if is_run else (None, None)
    return Curve("test", time, np.array(depth, float), np.array(load, float), area, tip, poisson, False, [], cells, block)


def metal(top=0.5, load=10.0, final=0.42, exponent=1.4, rows=400, lowest=0.0, first=0.0):
    """Depth (um) and load (mN): load c h^2 up to a largest depth, then the power law down to a share of the load."""
    up = np.linspace(first, top, rows)
    down = top - (top - final) * (1 - lowest ** (1 / exponent)) * np.linspace(0, 1, rows)[1:]
    return np.append(up, down), np.append(load * (up / top) ** 2, load * ((down - final) / (top - final)) ** exponent)


STIFFNESS = 10 * 1.4 / 0.08  # of metal()


def text_of(depth, load, mark=",", head="depth,load\n"):
    return head + "".join(f"{h:.9g}{mark}{p:.9g}\n" for h, p in zip(depth, load))


def cycles_of(loads, lowest=0.1):
    """A test with unloadings to a tenth, or another share, from several loads; all unloadings are alike but for their size."""
    parts, last = [], 0.0
    for load in loads:
        top = 0.5 * math.sqrt(load / 10)
        depth, force = metal(top, load, 0.84 * top, lowest=lowest, first=last)
        up = depth[:400] >= last
        parts.append((depth[:400][up], force[:400][up]))
        parts.append((depth[400:], force[400:]))
        parts.append((depth[400:][::-1], force[400:][::-1]))
        last = top
    return (np.concatenate(each) for each in zip(*parts[:-1]))


OPTIONS = {"-geometry": "plane_strain", "-domain_lower": "0,0", "-domain_upper": "1e-5,1e-5", "-cell_size": "1e-7", "-boundary_x_lower": "symmetry",
           "-boundary_x_upper": "free", "-indenter": "wedge", "-indenter_half_angle": "70.3", "-indenter_tip": "0,8e-06", "-m_poissons_ratio": "0.3"}
CONE_OPTIONS = {**OPTIONS, "-geometry": "axisymmetric", "-indenter": "cone", "-indenter_tip_radius": "0"}
QUARTER = {**CONE_OPTIONS, "-geometry": "3d", "-domain_lower": "0,0,0", "-domain_upper": "1e-5,1e-5,1e-5", "-boundary_y_lower": "symmetry",
           "-boundary_y_upper": "symmetry", "-indenter": "vickers", "-indenter_tip": "0,0,8e-06"}
HALF = {**QUARTER, "-domain_lower": "-1e-5,0,0", "-indenter": "berkovich"}


def write_run(folder, options, repeated=False, slow=False):
    """A result folder with a history of metal(), whose loads are means over the intervals; slow: a fifth of them is inertia and damping."""
    folder.mkdir()
    depth, load = metal(rows=2001)
    depth, load = 1e-6 * depth[::2], 1e-3 * np.append(0, load[1::2])
    columns = dict.fromkeys([*HISTORY, "contact_area"], np.zeros(len(depth))) | {"step": np.arange(len(depth)), "time": 1e-9 * np.arange(len(depth)),
                                                                                 "depth": depth, "load": load}
    columns["contact_area"] = np.full(len(depth), 3e-12)
    columns |= {"load_quasi_static": load, "load": 1.25 * load} if slow else {}
    table = np.column_stack(list(columns.values()))
    table = np.insert(table, 100, table[80:100], axis=0) if repeated else table
    np.savetxt(folder / "history.csv", table, delimiter=",", header=",".join(columns), comments="", fmt="%.17g")
    (folder / "summary.json").write_text(json.dumps({"case": "made", "levels": []} | ({"options": options} if options else {})))
    return folder


GOOD = text_of(*metal())


def refusal(*words):
    with pytest.raises(SystemExit) as caught:
        main([str(word) for word in words])
    assert re.fullmatch(r"error: [^\n]+", str(caught.value.code)), caught.value.code
    return caught.value.code
