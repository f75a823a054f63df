#!/usr/bin/env python3
"""Runs the code of a Jupyter notebook without Jupyter and stores what it prints and draws in it.

    scripts/notebook.py examples/first_indentation.ipynb

Cells share one namespace, and run in the notebook's folder. Stored are what a cell prints, the value of its last line, and the
figures of pyplot that it leaves open, as Jupyter would. The first cell that fails ends the command.
"""
import argparse
import ast
import base64
import contextlib
import io
import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command

from mlgimp.errors import ResultError
from mlgimp.pictures import plt

DOTS_PER_INCH = 80


def run_cells(notebook, namespace=None):
    """Runs the code cells of a notebook, a dict as in its file, and puts their outputs into it."""
    namespace = {"__name__": "__main__"} if namespace is None else namespace
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    for number, cell in enumerate(code, start=1):
        plt.close("all")
        cell.update(execution_count=number, outputs=outputs_of("".join(cell["source"]), number, namespace))


def outputs_of(source, number, namespace):
    """Runs the source of a cell and returns its outputs as a notebook stores them."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, f"cell {number}", "exec"), namespace)
        value = None if last is None else eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), namespace)
    outputs = []
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(True)})
    if value is not None and not source.rstrip().endswith(";"):
        outputs.append({"output_type": "execute_result", "execution_count": number, "metadata": {},
                        "data": {"text/plain": repr(value).splitlines(True)}})
    return outputs + [picture(plt.figure(each)) for each in plt.get_fignums()]


def picture(figure):
    """Returns a figure as a notebook stores it."""
    file = io.BytesIO()
    figure.savefig(file, dpi=DOTS_PER_INCH, bbox_inches="tight")
    data = {"image/png": base64.b64encode(file.getvalue()).decode(), "text/plain": ["<Figure>"]}
    return {"output_type": "display_data", "metadata": {}, "data": data}


@command
def main(arguments=None):
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("notebook", metavar="FILE.ipynb")
    path = Path(parser.parse_args(arguments).notebook).resolve()
    try:
        notebook = json.loads(path.read_text())
    except (OSError, ValueError) as problem:
        raise ResultError(path, f"cannot be read as a notebook ({problem})") from None
    os.chdir(path.parent)
    run_cells(notebook)
    path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")
    print(path)


if __name__ == "__main__":
    main()
