#!/usr/bin/env python3
"""Finds the constants of a material from measured load-depth curves: least squares over runs of their cases, several at once; or those of
creep and relaxation from the hold of a curve, without runs.

usage: scripts/fit.py MEASURED options/CASE.opts [MEASURED options/CASE.opts ...] -vary NAME,... [-depth COLUMN:UNIT] [-load COLUMN:UNIT]
                      [-test N] [-zero_depth DEPTH|auto] [-zero_load LOAD|auto] [-profile FILE,... [-profile_radius COLUMN:UNIT] [-profile_height COLUMN:UNIT]]
                      [-runs N] [-ranks N] [-evaluations N] [options of mlgimp, on all runs]
       scripts/fit.py MEASURED -creep norton|prony [-time COLUMN:UNIT] [-tip KIND -half_angle DEGREES|-radius UM] [-terms N]
                      [-creep_stress PA] [-poisson NU] [-drift NM/S] [-output_dir DIR] [-depth, -load, -test and zeros as above]

    scripts/fit.py measured.csv options/cone_load.opts -vary E,yield_stress -depth Displacement:nm -load Force:mN
    scripts/fit.py cone.csv cone.opts sharp.csv sharp.opts -vary E,yield_stress,hardening_exponent
    scripts/fit.py hold.csv -creep norton -time Time:s -depth Displacement:nm -load Force:mN -tip berkovich
    scripts/fit.py hold.csv -creep prony -terms 2 -time Time:s -tip sphere -radius 10 -poisson 0.4

MEASURED is what scripts/indentation.py reads, or the folder of a run; columns that are not named are those whose heads say so. NAME is
an option of the case, with or without the name of the material or body before it; E and nu stand for youngs_modulus and
poissons_ratio. The case's values are the first guess, and constants stay within a factor of 30 of it. -runs are made at the same time,
on -ranks ranks each; after the first runs, one more than constants, which tell how well the test will determine these, the search takes
at most -evaluations steps (30), each of a run.

Several tests, as under two tips, each have a curve and a case; the first case is the first guess, and a step is a run of each.
-profile names the heights over the radius that are left after unloading, one file for each test, empty where there is none;
-profile_radius and -profile_height are its columns (radius:um, height:um), from the tip's axis and over the undeformed surface.

The folder output/fit_CASE/ (or -output_dir) gets the runs, fit.csv with every evaluation, fit.json with the constants, and fit.png.

-creep norton: exponent n and rate a0 at the stress s0 (-creep_stress, by default about that in the hold) of the stress s0 (rate/a0)^(1/n),
from a hold at the largest load under a ball, a cone or a pyramid. -creep prony: modulus E_0, shares g_k and times tau_k of -terms terms (1)
of E_0 (1 - sum g_k (1 - exp(-t/tau_k))), from a hold of the load or of the depth; E_0 needs -poisson. A run with -test_times has its tip,
times and Poisson's ratio. -drift takes thermal drift off the depths. The folder output/fit_MEASURED/ gets fit.json, fit.csv with the
hold and the fit, and fit.png.
"""
import itertools
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import asks_for_help, command, one_dash, save, take, whole_number_from

from mlgimp import checks, corrections, creep_fits, fitting, imprint, load_depth, presets, tips, zeros
from mlgimp.errors import Error
from mlgimp.options import of_words


def parse(words):
    """The arguments of fitting.fit that the command line asks for."""
    paths = list(itertools.takewhile(lambda word: not re.match(r"-[A-Za-z]", word), words))
    if len(paths) < 2 or len(paths) % 2:
        raise Error("MEASURED and options/CASE.opts must be given, several tests one after the other; -help tells more")
    passed = of_words(words[len(paths):])
    for path in paths:
        if not Path(path).exists():
            raise Error(f"{path}: there is no such file")
    at_once, count = "a whole number >= 1", whole_number_from(1)
    vary = take(passed, "vary", lambda text: text.split(","), None, "names of options")
    depth = take_column(passed, "depth", load_depth.DEPTH_UNITS)
    load = take_column(passed, "load", load_depth.LOAD_UNITS)
    if not vary:
        raise Error("-vary: must be given")
    for name, least in (("ranks", 1), ("runs", None), ("evaluations", 30)):
        passed[name] = take(passed, name, count, least, at_once)
    profiles = take_profiles(passed, len(paths) // 2)
    measured = take_curves([Path(path) for path in paths[::2]], passed, depth, load)
    cases = [Path(path) for path in paths[1::2]]
    if len(cases) == 1:
        return {"measured": measured[0], "case": cases[0], "vary": vary, "profile": profiles[0], **passed}
    return {"measured": measured, "case": cases, "vary": vary, "profile": profiles, **passed}


def take_profiles(passed, count):
    """Takes the files of imprints, and returns as many Imprints, None where there is no file."""
    radius, height = (take_column(passed, f"profile_{name}", load_depth.DEPTH_UNITS) or f"{name}:um" for name in ("radius", "height"))
    files = take(passed, "profile", lambda text: text.split(","), [""] * count, "names of files")
    if len(files) != count:
        raise Error(f"-profile {','.join(files)}: must have one name for each of the {count} tests, empty where there is none")
    return [imprint.read_profile(file, radius, height) if file else None for file in files]


def take_curves(measured, passed, depth, load, time=None):
    """Takes which test of the files and which zeros, and returns the Curves of files or of runs."""
    test = take(passed, "test", whole_number_from(1), None, "a whole number >= 1")
    offsets = {name: take(passed, name, zero, 0, "a number, or auto") for name in ("zero_depth", "zero_load")}
    return [load_depth.read_run(path) if path.is_dir() else load_depth.read_measured(path, depth, load, time, test=test, **offsets)
            for path in measured]


def parse_creep(words):
    """The arguments of creep_fits.fit_creep that the command line asks for, and the folder for the results."""
    measured, passed = Path(words[0]), of_words(words[1:])
    if not measured.exists():
        raise Error(f"{measured}: there is no such file")
    law = take(passed, "creep", str, None, "norton or prony")
    folder = take(passed, "output_dir", str, f"output/fit_{measured.resolve().stem}", "a folder")
    depth = take_column(passed, "depth", load_depth.DEPTH_UNITS)
    load = take_column(passed, "load", load_depth.LOAD_UNITS)
    time = take_column(passed, "time", load_depth.TIME_UNITS)
    more = {"terms": take(passed, "terms", whole_number_from(1), 1, "a whole number >= 1")}
    more |= {name: take(passed, name, float, None, "a number") for name in ("creep_stress", "poisson")}
    tip = take_tip(passed)
    drift = take(passed, "drift", float, 0.0, "a number in nm/s")
    if drift and measured.is_dir():
        raise Error("-drift: must be left out for a run")
    [curve] = take_curves([measured], passed, depth, load, time)
    curve = corrections.without_drift(curve, drift)
    if passed:
        raise Error(f"-{next(iter(passed))}: must be left out beside -creep")
    return {"measured": curve, "law": law, "tip": tip, **more}, folder


def take_tip(passed):
    """Takes the tip with its sizes (degrees and um); None where none is named."""
    kind = take(passed, "tip", str, None, "a kind of tip")
    sizes = {name: take(passed, name, int if name == "faces" else float, None, rule.allowed) for name, rule in tips.RULES.items()}
    given = {name: size for name, size in sizes.items() if size is not None}
    if kind is None:
        if given:
            raise Error(f"-{next(iter(given))}: must stand beside -tip")
        return None
    checked = {name: checks.number(name, size, tips.RULES[name]) if name != "faces" else size for name, size in given.items()}
    return presets.make_tip(kind, checked, lambda name, value="": f"-{name} {value}".rstrip())


def zero(text):
    """Reads a zero of depths or loads."""
    return text if text == zeros.AUTO else float(text)


def take_column(passed, name, units):
    """Takes the column of the measured curve that is a depth, a load or a time; None, which its heads say, by default."""
    return take(passed, name, load_depth.column_argument(units), None, f"COLUMN:UNIT with a unit of {', '.join(units)}")


@command
def main(words):
    if asks_for_help(words):
        print(__doc__)
        return
    words = one_dash(words)
    if any(word.lower() == "-creep" for word in words[1:]):
        creep_main(words)
        return
    found = fitting.fit(**parse(words))
    for each, value, lower, upper in zip(found.variables, found.values, found.lower, found.upper):
        print(f"{each.option} {value:.6g}, 95 % confidence {lower:.6g} to {upper:.6g} by noise alone")
    for line in found.notes:
        print(f"note: {line}")
    for line in found.warnings:
        print(f"warning: {line}")
    print(found.folder / "fit.csv", found.folder / "fit.json", sep="\n")
    save(found.plot(), found.folder / "fit.png")


def creep_main(words):
    """Fits a law of creep or relaxation to a hold."""
    arguments, folder = parse_creep(words)
    found = creep_fits.fit_creep(**arguments)
    for name, value in found.constants.items():
        lower, upper = found.lower[name], found.upper[name]
        print(f"{name} {value:.6g}" + f", 95 % confidence {lower:.6g} to {upper:.6g}" * (name != "creep_stress_Pa"))
    for line in found.warnings:
        print(f"warning: {line}")
    found.write(folder)
    print(Path(folder) / "fit.csv", Path(folder) / "fit.json", sep="\n")
    save(found.plot(), Path(folder) / "fit.png")


if __name__ == "__main__":
    main(sys.argv[1:])
