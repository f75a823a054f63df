#!/usr/bin/env python3
"""Finds area function and frame compliance from a series of indentations of a specimen with a known modulus, as of fused silica.

    scripts/calibrate.py silica_*.txt
    scripts/calibrate.py silica.xls --modulus 72 --poisson 0.17 --tip-elastic 1141,0.07 --coefficients 6
    scripts/indentation.py measured.txt --calibration calibration.json

FILES are what scripts/indentation.py reads; each unloading is a depth. The depths must still have the frame's compliance in them, unless
it is known (--frame-compliance). Writes calibration.json, which scripts/indentation.py takes by --calibration, and calibration.png.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command, save

import numpy as np

from mlgimp import calibration, corrections, cycles, load_depth, pictures, tips, zeros
from mlgimp.errors import Error, ResultError

ROUGH = 0.05  # of the areas: what a function of few coefficients may miss of a tip


def parse(arguments):
    """Returns the options of the command line; which values are allowed calibration.calibrate() says."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE", help="measured tests of the specimen")
    parser.add_argument("--modulus", type=float, default=72.0, metavar="GPA", help="of the specimen (72, fused silica)")
    parser.add_argument("--poisson", type=float, default=0.17, help="Poisson's ratio of the specimen (0.17)")
    parser.add_argument("--tip-elastic", type=load_depth.numbers, default=[1141.0, 0.07], metavar="GPA,NU", help="of the tip (1141,0.07, diamond)")
    parser.add_argument("--reduced-modulus", type=float, metavar="GPA", help="of both, in their place")
    parser.add_argument("--coefficients", type=int, default=6, metavar="N", help="of the area function (6)")
    parser.add_argument("--frame-compliance", type=float, metavar="NM/MN", help="of a frame that is known (it is found)")
    parser.add_argument("--window", type=load_depth.numbers, metavar="LOW,HIGH", help="part of the unloadings that is fitted, of their load (0.5,0.97)")
    parser.add_argument("--zero-depth", choices=sorted(zeros.RULES), help="how the depth of the surface is found (the files' is zero)")
    parser.add_argument("--zero-load", choices=[zeros.AUTO], help="the load of the free tip is found (the files' is zero)")
    parser.add_argument("--beta", type=float, default=calibration.BETA, help="of S = 2 beta Er sqrt(A/pi), with which the area is used (1)")
    parser.add_argument("--drift", choices=[corrections.AUTO], help="thermal drift is found and taken off")
    parser.add_argument("--out", metavar="DIR", help="folder for what is written (that of the first file)")
    options = parser.parse_args(arguments)
    if len(options.tip_elastic) != 2:
        raise Error(f"--tip-elastic {','.join(f'{value:g}' for value in options.tip_elastic)}: must be GPA,NU")
    return options


def curves(options):
    """Yields the Curves of all files that have an unloading, and prints why others have none."""
    wished = {"zero_depth": options.zero_depth or 0, "zero_load": options.zero_load or 0, "drift": options.drift}
    for path in options.files:
        try:
            for test in load_depth.measured_tests(path, **wished):
                try:
                    curve = test.read()
                    cycles.find_cycles(curve)
                    yield curve
                except ResultError as problem:
                    print(f"left out: {test.name}: {problem.problem}")
        except ResultError as problem:
            print(f"left out: {problem}")


@pictures.styled
def draw(found, path):
    """Writes the picture: the area over the contact depth with its function, what that misses, and hardness over depth."""
    figure, (left, right) = pictures.plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
    _, depth, _, area, hardness = found.rows.T
    tip = tips.tip_of_function(found.coefficients)
    depths = np.linspace(0, found.depths[1], 300)
    left.plot(depth, 1e-6 * area, "o", label="measured")
    left.plot(depths, tip.area(1e-3 * depths), "-", color="C1", label=f"function, misses {100 * found.area_error:.2g} %")
    left.legend()
    right.plot(depth[found.shown], hardness[found.shown], "o", label="counts for the frame")
    right.plot(depth[~found.shown], hardness[~found.shown], "o", markerfacecolor="none", linestyle="none", label="does not")
    right.set_ylim(0, 1.2 * hardness.max())
    right.legend()
    pictures.line_axes(left, "contact depth (nm)", "area (µm²)")
    pictures.line_axes(right, "contact depth (nm)", "hardness (GPa)")
    save(figure, path)


@command
def main(arguments=None):
    """Calibrates by the files that the command line names."""
    options = parse(arguments)
    found = calibration.calibrate(list(curves(options)), modulus=options.modulus, poisson=options.poisson, tip_modulus=options.tip_elastic[0],
                                  tip_poisson=options.tip_elastic[1], reduced_modulus=options.reduced_modulus, coefficients=options.coefficients,
                                  window=options.window, beta=options.beta, frame_compliance=options.frame_compliance)
    folder = Path(options.out) if options.out else Path(options.files[0]).parent
    pictures.make_folder(folder)
    calibration.write(found, folder / "calibration.json")
    print(folder / "calibration.json")
    draw(found, folder / "calibration.png")
    print(f"area function (nm): {','.join(f'{value:.8g}' for value in found.coefficients)}, misses {100 * found.area_error:.2g} % in {len(found.rows)} depths")
    stiffness = f" ({1 / found.frame:.4g} N/um)" if found.frame > 0 else ""
    print(f"frame: {found.frame:.4g} +- {found.frame_error:.2g} nm/mN{stiffness}, of {found.shown.sum()} depths with a hardness of {found.hardness:.4g} GPa")
    if found.area_error > ROUGH:
        print(f"warning: the function misses {100 * found.area_error:.2g} % of the areas: do all depths count from the surface, and is the specimen the same?")
    if found.frame == 0 and options.frame_compliance is None:
        print("warning: no compliance of a frame was found: the depths may be free of it already")
    print(f"contact depths: {found.depths[0]:.4g} to {found.depths[1]:.4g} nm")


if __name__ == "__main__":
    main()
