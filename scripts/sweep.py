#!/usr/bin/env python3
"""Runs a case with all combinations of some values on all cores, and writes sweep.csv: hardness, modulus and largest load of each.

    scripts/sweep.py options/cone_load.opts --vary indenter_half_angle 60 65 70.3 --vary metal_yield_stress 4e8 5e8
    scripts/sweep.py options/film.opts --vary cell_size 100e-9 50e-9 --set frames 2 --out output/film_sweep --jobs 2

The same command goes on where it was stopped: combinations that have completed with the same options are not run again. One that fails
is a row whose status says why; the exit status is 2 then, and 1 where nothing could be run.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command, whole_number_from

from mlgimp import sweeps
from mlgimp.errors import Error


def grid_of(given):
    """Returns {name: values} of the words behind each --vary."""
    grid = {}
    for name, *values in given:
        if not values or name in grid:
            raise Error(f"--vary {name}: must be given once, with values behind its name")
        grid[name.lstrip("-")] = values
    return grid


@command
def main(arguments=None):
    """Makes the runs that the command line asks for."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", metavar="CASE", help="options file of the case")
    parser.add_argument("--vary", nargs="+", action="append", required=True, metavar=("NAME", "VALUE"), help="an option without its dash, and its values")
    parser.add_argument("--set", nargs=2, action="append", default=[], metavar=("NAME", "VALUE"), help="an option that is the same in all runs")
    parser.add_argument("--out", metavar="DIR", default="output/sweep", help="folder of all runs and of sweep.csv (output/sweep)")
    parser.add_argument("--jobs", type=whole_number_from(1), metavar="N", help="runs at once (one for each core)")
    options = parser.parse_args(arguments)
    fixed = {name.lstrip("-"): value for name, value in options.set}
    rows = sweeps.rows_of(options.case, grid_of(options.vary), folder=options.out, jobs=options.jobs, **fixed)
    for row in rows:
        print(", ".join(f"{name} {row[name]}" for name in grid_of(options.vary)), row["status"], sep=": ")
    print(Path(options.out) / "sweep.csv")
    return 0 if all(row["status"] == "completed" for row in rows) else 2


if __name__ == "__main__":
    main()
