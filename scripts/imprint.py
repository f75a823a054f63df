#!/usr/bin/env python3
"""Writes the imprint that a test leaves as a map of heights, as an atomic force microscope gives it.

    scripts/imprint.py output/cone
    scripts/imprint.py output/vickers --frame 12 --pixel 20

Writes surface.gsf, which Gwyddion opens, and surface.csv, the same as a matrix of heights in m with commas, row by row from above, below
lines with # that tell its size; into the folder of the run, or --out. Heights are over the undeformed surface, pile-up and all. Of half
and quarter models the whole imprint is written, of axisymmetric ones that by revolution. x goes to the right, y up, the tip's axis is in
the middle.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command

import numpy as np

from mlgimp import imprint, results
from mlgimp.errors import Error


def parse(arguments):
    """Returns the options of the command line."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", metavar="DIR", help="result folder of a run")
    parser.add_argument("--frame", type=int, metavar="N", help="number of the frame (the last one)")
    parser.add_argument("--pixel", type=float, metavar="NM", help="width of a pixel (half a finest cell)")
    parser.add_argument("--out", metavar="DIR", help="folder for what is written (that of the run)")
    options = parser.parse_args(arguments)
    if options.pixel is not None and not 0 < options.pixel < np.inf:
        raise Error(f"--pixel {options.pixel:g}: must be a number > 0 in nm")
    return options


@command
def main(arguments=None):
    """Writes the map of the run that the command line names."""
    options = parse(arguments)
    image = imprint.height_map(options.run, options.frame, options.pixel and 1e-3 * options.pixel)
    print(*imprint.write(options.out or options.run, image, f"imprint of {results.case_name(options.run)}"), sep="\n")
    pixel = image.x[1] - image.x[0]
    print(f"{len(image.x)} x {len(image.y)} pixels of {1e3 * pixel:.4g} nm, heights from {1e3 * np.nanmin(image.height):.4g} "
          f"to {1e3 * np.nanmax(image.height):.4g} nm")
    if imprint.surface_of(options.run, options.frame)[2]:
        print("warning: the tip still touches in this frame: it is no imprint after unloading")


if __name__ == "__main__":
    main()
