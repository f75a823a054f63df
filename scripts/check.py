#!/usr/bin/env python3
"""Looks at a case before it runs: what it is, what it costs, what is doubtful about it, and its picture.

    scripts/check.py options/cone_metal.opts
    scripts/check.py mine.opts -cell_size 400nm --ranks 2 --out mine.png

Takes a few steps, one to two seconds. Options of the program may follow, and count more. Nothing is written but check.png, or what --out
names. `bin/mlgimp -options_file mine.opts -check` prints much the same without Python.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command, one_dash, whole_number_from

from mlgimp import case_check
from mlgimp.options import of_words


@command
def main(arguments=None):
    """Checks the case that the command line names."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE", help="options file")
    parser.add_argument("--ranks", type=whole_number_from(1), default=1, metavar="N", help="processes (1)")
    parser.add_argument("--out", default="check.png", metavar="FILE", help="the picture (check.png)")
    own, others = parser.parse_known_args(arguments)
    found = case_check.check(own.file, own.ranks, out=own.out, **of_words(one_dash(others)))
    print(*case_check.text_of(found), own.out, sep="\n")


if __name__ == "__main__":
    main()
