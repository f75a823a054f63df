#!/usr/bin/env python3
"""Draws the pictures of one result folder: load_depth.png, contact_pressure.png, stress_xx.png, _yy, _xy, von_mises_stress.png,
energy.png; of metals pressure.png and equivalent_plastic_strain.png too. Axisymmetric fields are mirrored at the axis; in space
they are slices through the tip's axis, stress_xx.png, _zz and _xz, and there is the surface of a metal, plastic_surface.png.

    scripts/plot.py output/wedge_3level --window near
    scripts/plot.py output/film --frame 7 --out pictures
    scripts/plot.py output/film --movie film.gif --component von_mises_stress
    scripts/plot.py output/cone --style paper --picture von_mises_stress --log --out figure.pdf
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command

from mlgimp import fields, movie, pictures, results
from mlgimp.errors import Error
from mlgimp.gallery import AUTO, LARGEST_LOAD, gallery

WHOLE = "all"  # window


def window_argument(text):
    """Returns xmin,xmax,ymin,ymax (m) as an array of four numbers, near, or None of all."""
    try:
        return None if text == WHOLE else text if text == AUTO else fields.given_window(text)
    except Error as problem:
        raise argparse.ArgumentTypeError(problem) from None


def add_window_option(parser):
    """Adds --window to a command line."""
    parser.add_argument("--window", type=window_argument, metavar="XMIN,XMAX,YMIN,YMAX",
                        help="part of the fields to show, in m (--window=... where it begins with a minus), near: finest level, or all")


@command
def main(arguments=None):
    """Draws all pictures of the result folder that the command line names, or a movie."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory", metavar="DIR", help="result folder of a run")
    parser.add_argument("--frame", type=lambda text: text if text == LARGEST_LOAD else int(text), metavar="N",
                        help=f"frame to draw, or {LARGEST_LOAD} (default: the last, for the pressure of contact that of the largest load)")
    parser.add_argument("--out", metavar="DIR", help="folder for the pictures (default: the result folder), or of one --picture a file .png, .pdf or .svg")
    parser.add_argument("--picture", metavar="NAME", help="only this one")
    parser.add_argument("--style", choices=pictures.LOOKS, default="screen",
                        help="paper: as wide as a column of a journal, 85 mm, with text of 8 points and no title, in .pdf files")
    parser.add_argument("--log", action="store_true", help="colours by logarithms, of fields that span decades")
    parser.add_argument("--movie", metavar="FILE",
                        help="only write a movie of all frames; its name ends in .gif, or in .mp4 where ffmpeg is installed")
    parser.add_argument("--component", choices=[*fields.STRESS_COLUMN, *fields.SCALARS], default="von_mises_stress",
                        help="what the movie shows")
    add_window_option(parser)
    parser.set_defaults(window=AUTO)  # near where the contact is small in all that there is
    options = parser.parse_args(arguments)
    if options.movie:
        window = None if isinstance(options.window, str) and options.window == AUTO else options.window
        movie.movie(options.directory, options.movie, options.component, window, options.log)
        print(options.movie)
        return
    with pictures.looking(options.style):
        draw(options)


def draw(options):
    """Draws and writes the pictures that the command line asks for."""
    drawn = gallery(options.directory, options.frame, options.window, options.log)
    if options.picture and options.picture not in drawn:
        raise Error(f"--picture {options.picture}: must be one of {', '.join(drawn)}")
    if not options.picture and not results.has_indenter(results.read_history(options.directory)):
        print("no load_depth.png: this run has no indenter, or one that has not moved")
    out = options.out or options.directory
    if not options.picture and Path(out).suffix.lower() in pictures.ENDINGS:
        raise Error(f"--out {out}: must be a folder for {len(drawn)} pictures, or stand beside --picture, one of {', '.join(drawn)}")
    if options.picture:
        print(*pictures.save_all({options.picture: drawn[options.picture]()}, out))
        return
    for name, draw_it in drawn.items():  # one after the other, as each takes memory
        print(*pictures.save_all({name: draw_it()}, Path(out)))


if __name__ == "__main__":
    main()
