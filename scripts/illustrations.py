#!/usr/bin/env python3
"""Runs the cases of the documents' pictures of fields one after the other and draws these, docs/images/NAME.png. Results go to
output/illustrations/.

    scripts/illustrations.py                 all: some minutes
    scripts/illustrations.py locking         only these
    scripts/illustrations.py --draw-only     draws results that are there anew
"""

import argparse
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
import figures
from command import ROOT, Parser, command

from mlgimp import program
from mlgimp.errors import Error

Panel = namedtuple("Panel", "case label frame options", defaults=(None, {}))
Panel.__doc__ = "A panel: a file in options/ without .opts, what stands above it, the number of the frame (the last by default), and other options."
Illustration = namedtuple("Illustration", "component window panels")
Illustration.__doc__ = "A picture: what is drawn, the window xmin,xmax,ymin,ymax (m) or None of all, and its Panels."

RESULTS, PICTURES = ROOT / "output" / "illustrations", ROOT / "docs" / "images"
ILLUSTRATIONS = {
    "tension": Illustration("xx", None, [Panel("tension", "original MPM", options={"shape_function": "linear"}), Panel("tension", "cpGIMP")]),
    "pressure": Illustration("yy", None, [Panel("pressure", "500 increments", 2), Panel("pressure", "2000 increments", 8)]),
    "locking": Illustration("pressure", "0,16e-6,20e-6,33e-6", [
        Panel("punch_plastic", "each point its own volume", options={"metal_volume_average": False}), Panel("punch_plastic", "the mean of a cell")]),
    "plastic_wedge": Illustration("equivalent_plastic_strain", "0,24e-6,38e-6,54e-6", [Panel("wedge_plastic", "wedge of 60 degrees, E/sy = 1000")]),
    "plastic_cone": Illustration("equivalent_plastic_strain", "-1.2e-6,1.2e-6,24.4e-6,26e-6", [Panel("cone_metal", "cone of 70.3 degrees, E/sy = 50")]),
    "taylor_bar": Illustration("equivalent_plastic_strain", None, [Panel("taylor_bar", "copper", frame) for frame in (1, 2, 4)])}


def folder_of(panel):
    """Returns the result folder of a Panel: panels of one run share it."""
    return RESULTS / "_".join([panel.case, *(f"{name}_{value}" for name, value in panel.options.items())])


def run(panels):
    """Runs the cases of Panels, each once."""
    for folder, panel in {folder_of(each): each for each in panels}.items():
        print(folder.relative_to(ROOT))
        program.execute({"options_file": ROOT / "options" / f"{panel.case}.opts", **panel.options, "output_dir": folder, "overwrite": None}, tell=print)


def draw(name):
    """Draws a picture of results that are there."""
    component, window, panels = ILLUSTRATIONS[name]
    frames = [f"{folder_of(panel)}{'' if panel.frame is None else f':{panel.frame}'}:{panel.label}" for panel in panels]
    figures.main(["fields", str(PICTURES / f"{name}.png"), *frames, "--component", component, *([f"--window={window}"] if window else [])])


@command
def main(arguments=None):
    """Runs and draws the pictures that the command line names, by default all."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"pictures (default: all, {', '.join(ILLUSTRATIONS)})")
    parser.add_argument("--draw-only", action="store_true", help="run nothing, draw the results in output/illustrations/")
    options = parser.parse_args(arguments)
    unknown = set(options.names) - set(ILLUSTRATIONS)
    if unknown:
        raise Error(f"{', '.join(sorted(unknown))}: must be of {', '.join(ILLUSTRATIONS)}")
    names = options.names or list(ILLUSTRATIONS)
    if not options.draw_only:
        run([panel for name in names for panel in ILLUSTRATIONS[name].panels])
    for name in names:
        draw(name)


if __name__ == "__main__":
    main()
