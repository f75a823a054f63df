#!/usr/bin/env python3
"""Writes a page about a run, report.html, that needs no other file: the case, load and depth, the fields over the frames with a slider,
hardness and modulus, balances of energy and momentum, warnings and options. Any browser of 2023 or later shows it, without a network.

    scripts/report.py output/wedge_3level
    scripts/report.py output/film --out film.html
"""

import argparse
import shlex
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command

from mlgimp import run_report


@command
def main(arguments=None):
    """Writes the page of the result folder that the command line names."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory", metavar="DIR", help="result folder of a run")
    parser.add_argument("--out", metavar="FILE", help="the page (default: report.html in that folder)")
    options = parser.parse_args(arguments)
    print(run_report.report(options.directory, options.out, shlex.join(["scripts/report.py", *(sys.argv[1:] if arguments is None else arguments)])))


if __name__ == "__main__":
    main()
