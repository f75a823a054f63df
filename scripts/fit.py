#!/usr/bin/env python3
"""Finds the constants of a material from a measured load-depth curve: least squares over runs of a case, several at once.

usage: scripts/fit.py MEASURED options/CASE.opts -vary NAME,... [-depth COLUMN:UNIT] [-load COLUMN:UNIT] [-test N]
                      [-zero_depth DEPTH|auto] [-zero_load LOAD|auto] [-runs N] [-ranks N] [-evaluations N]
                      [options of mlgimp, on all runs]

    scripts/fit.py measured.csv options/cone_load.opts -vary E,yield_stress -depth Displacement:nm -load Force:mN

MEASURED is a text with columns (scripts/indentation.py says which) or the folder of a run. NAME is an option of the case, with or
without the name of the material or body before it; E and nu stand for youngs_modulus and poissons_ratio. The case's values are the
first guess, and constants stay within a factor of 30 of it. -runs are made at the same time, on -ranks ranks each; the search takes
at most -evaluations steps (30), each of a run and one more for each constant.

The folder output/fit_CASE/ (or -output_dir) gets the runs, fit.csv with every evaluation, fit.json with the constants, and fit.png.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import command, save, take, whole_number_from

from mlgimp import fitting, load_depth, zeros
from mlgimp.errors import Error
from mlgimp.options import of_words


def parse(words):
    """The arguments of fitting.fit that the command line asks for."""
    if len(words) < 2:
        raise Error("MEASURED and options/CASE.opts must be given; -help tells more")
    measured, file, passed = Path(words[0]), Path(words[1]), of_words(words[2:])
    for path in (measured, file):
        if not path.exists():
            raise Error(f"{path}: there is no such file")
    at_once, count = "a whole number >= 1", whole_number_from(1)
    vary = take(passed, "vary", lambda text: text.split(","), None, "names of options")
    depth = take_column(passed, "depth", load_depth.DEPTH_UNITS, "um")
    load = take_column(passed, "load", load_depth.LOAD_UNITS, "mN")
    if not vary:
        raise Error("-vary: must be given")
    for name, least in (("ranks", 1), ("runs", None), ("evaluations", 30)):
        passed[name] = take(passed, name, count, least, at_once)
    test = take(passed, "test", count, None, at_once)
    offsets = {name: take(passed, name, zero, 0, "a number, or auto") for name in ("zero_depth", "zero_load")}
    curve = load_depth.read_run(measured) if measured.is_dir() else load_depth.read_measured(measured, depth, load, test=test, **offsets)
    return {"measured": curve, "case": file, "vary": vary, **passed}


def zero(text):
    """Reads a zero of depths or loads."""
    return text if text == zeros.AUTO else float(text)


def take_column(passed, name, units, unit):
    """Takes the column of the measured curve with a name, by default one of that name."""
    default = load_depth.Column(name, units[unit], units)
    return take(passed, name, load_depth.column_argument(units), default, f"COLUMN:UNIT with a unit of {', '.join(units)}")


@command
def main(words):
    if words and words[0] in ("-help", "--help", "-h"):
        print(__doc__)
        return
    found = fitting.fit(**parse(words))
    for each, value, lower, upper in zip(found.variables, found.values, found.lower, found.upper):
        print(f"{each.option} {value:.6g}, 95 % confidence {lower:.6g} to {upper:.6g}")
    for line in found.warnings:
        print(f"warning: {line}")
    print(found.folder / "fit.csv", found.folder / "fit.json", sep="\n")
    save(found.plot(), found.folder / "fit.png")


if __name__ == "__main__":
    main(sys.argv[1:])
