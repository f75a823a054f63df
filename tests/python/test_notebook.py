"""Runs the notebook in examples/ and compares what it prints with what is stored in it."""
import json
import shutil

import pytest

import notebook
from harness import ROOT
from test_tutorial import differ

pytestmark = pytest.mark.fast

NOTEBOOK = ROOT / "examples" / "first_indentation.ipynb"


def shown(cell):
    """(kinds of the outputs, printed text) of a code cell."""
    kinds = [next(iter(output.get("data", ["text"]))) for output in cell["outputs"]]
    return kinds, "".join(line for output in cell["outputs"] for line in output.get("text", []))


def test_first_indentation(tmp_path, monkeypatch, expect):
    stored, again = (json.loads(NOTEBOOK.read_text()) for _ in range(2))
    shutil.copy(NOTEBOOK.parent / "measured.csv", tmp_path)
    monkeypatch.chdir(tmp_path)
    namespace = {}
    notebook.run_cells(again, namespace)
    pictures = 0
    for old, new in zip(stored["cells"], again["cells"]):
        if old["cell_type"] != "code":
            continue
        assert shown(old)[0] == shown(new)[0], old["source"]
        pictures += shown(old)[0].count("image/png")
        if not shown(old)[1].startswith(" run"):  # the table of the fit, with the seconds of each run
            assert differ(shown(old)[1], shown(new)[1]) == ""
    expect("pictures", pictures, at_least=4)
    found = namespace["found"].constants
    expect("modulus, GPa", found["specimen_youngs_modulus"] / 1e9, near=110, tolerance=3)
    expect("yield stress, MPa", found["specimen_yield_stress"] / 1e6, near=300, tolerance=6)


def test_what_a_cell_shows():
    """Printed text, the value of the last line unless a semicolon ends it, and figures."""
    cells = [{"cell_type": "code", "source": [line]} for line in ("print(1)\n2 + 2", "x = 3", "x;", "import matplotlib.pyplot as plt\nplt.figure();")]
    notebook.run_cells({"cells": cells})
    assert [shown(cell)[0] for cell in cells] == [["text", "text/plain"], [], [], ["image/png"]]
    assert shown(cells[0])[1] == "1\n" and cells[0]["outputs"][1]["data"]["text/plain"] == ["4"]
