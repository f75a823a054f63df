#!/usr/bin/env python3
"""Analyses indentation tests by Oliver and Pharr: result folders of runs, and measured curves beside them.

    scripts/indentation.py output/cone
    scripts/indentation.py output/cone measured.csv --depth "Displacement:nm" --load "Force:mN"
    scripts/indentation.py export.xlsx other.hld --tip berkovich --poisson 0.3 --tip-elastic 1141,0.07 --iso
    scripts/indentation.py measured.txt --calibration calibration.json --drift auto --zero-depth power

Writes indentation.json, indentation.csv (a row for each unloading of each curve) and indentation.png; by options hardness and modulus
over the depth, uncertainties, the curves as instruments write them, and a page. Lengths are in um, loads in mN,
stresses in GPa, work in nJ; a run's loads and areas are those of the whole tip. A measured curve has the tip that is given, or that
of the first run, and its Poisson's ratio. docs/indentation.md explains the figures.

The exit status is 0 where all curves have figures, 2 where some have not, of which a row says why while the others are written, and
1 where none has or the command line is wrong; then nothing is written.
"""

import argparse
import csv
import json
import math
import sys
from collections import namedtuple
from pathlib import Path
from types import MappingProxyType

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import Parser, command, save
import indentation_outputs as outputs

import numpy as np
from matplotlib.ticker import MaxNLocator

from mlgimp import calibration, corrections, load_depth, oliver_pharr, pictures, presets, report_page, tips, zeros
from mlgimp.checks import Rule
from mlgimp.errors import Error, ResultError

LETTERS = 40  # of names beside each other, for which there is room below a panel
MOST_NAMES = 8  # of curves in a legend
MOST_FITS = 20  # curves beside each other: of more the fits and tangents would cover them

Analysis = namedtuple("Analysis", "name curve rows fits problem", defaults=(None, (), (), None))
Analysis.__doc__ = """What is known of a test: its name and Curve, a dict of results for each unloading and its Unloading, None where it
cannot be fitted; or the problem, a ResultError, for which there are no figures."""


# ---- command line ----

def checked(rule, convert=float):
    """Returns a function that reads a value that meets a Rule for a command line."""
    def read(text):
        try:
            value = convert(text)
            if rule.good(value):
                return value
        except ValueError:
            pass
        raise argparse.ArgumentTypeError(f"{text}: must be {rule.allowed}")
    return read


def column(units):
    """Returns a function that reads COLUMN:UNIT for a command line."""
    def read(text):
        try:
            return load_depth.column_argument(units)(text)
        except ValueError as problem:
            raise argparse.ArgumentTypeError(f"{text}: {problem}") from None
    return read


def number_or(words):
    """Returns a function that reads a number, or one of some words, for a command line."""
    return lambda text: text if text in words else checked(Rule(math.isfinite, f"a number, or {', '.join(words)}"))(text)


def spelt(name, value=""):
    """Returns an argument of the package as the command line has it."""
    return f"--{name.replace('_', '-')} {value}".rstrip()


E, NU = (oliver_pharr.RULES[name] for name in ("tip_modulus", "tip_poisson"))
TIP_ELASTIC = Rule(lambda pair: len(pair) == 2 and E.good(pair[0]) and NU.good(pair[1]),
                   f"E,NU with NU {NU.allowed}, E {E.allowed}")
FINITE = Rule(math.isfinite, "a number")
WHOLE = Rule(lambda number: number >= 1, "a whole number >= 1")
COEFFICIENTS = Rule(lambda numbers: all(map(math.isfinite, numbers)), "C0,C1,...")


def add_reading_options(parser):
    """Adds the options that say what the columns of measured files are, and what is taken off them."""
    group = parser.add_argument_group("columns of measured files, by default those whose heads say so")
    group.add_argument("--depth", type=column(load_depth.DEPTH_UNITS), metavar="COLUMN:UNIT", help="name or number of the column, and its unit")
    group.add_argument("--load", type=column(load_depth.LOAD_UNITS), metavar="COLUMN:UNIT", help="the same of the load")
    group.add_argument("--time", type=column(load_depth.TIME_UNITS), metavar="COLUMN:UNIT", help="to check the order of the rows, for creep and relaxation in "
                       "holds, and for --drift")
    group.add_argument("--zero-depth", type=number_or(zeros.RULES), default=0, metavar="DEPTH", help="what the files have where the tip touches, in the unit "
                       "of the column, or how it is found: power, where the power law of the first loading begins, which auto means, too; threshold and "
                       "stiffness, where load or stiffness leave their noise (0)")
    group.add_argument("--zero-load", type=number_or((zeros.AUTO,)), default=0, metavar="LOAD", help="what they have for the free tip, in the unit of the "
                       "column, or auto: the median of the rows before the contact (0)")
    group.add_argument("--drift", type=number_or((corrections.AUTO,)), metavar="NM/S", help="thermal drift of the depths, which is taken off, or auto: that of "
                       "the hold at a tenth of the load")
    group.add_argument("--frame-compliance", type=checked(corrections.FRAME), metavar="NM/MN", help="of the frame, times the load taken off the depths")


def add_tip_options(parser):
    """Adds the options that describe the tip of measured curves."""
    group = parser.add_argument_group("tip of measured curves, and of runs that do not say theirs")
    group.add_argument("--tip", metavar="KIND",
                       help=f"its kind, {', '.join(tips.NEEDS)}, or a tip by name, as berkovich_R50 (bin/mlgimp -presets lists them)")
    group.add_argument("--half-angle", type=checked(tips.RULES["half_angle"]), metavar="DEGREES",
                       help="of a cone or a pyramid, from the axis to a face")
    group.add_argument("--radius", type=checked(tips.RULES["radius"]), metavar="UM", help="of a sphere or a flat punch")
    group.add_argument("--tip-radius", type=checked(tips.RULES["tip_radius"]), metavar="UM",
                       help="of a rounded cone or pyramid (0)")
    group.add_argument("--edge-radius", type=checked(tips.RULES["edge_radius"]), metavar="UM", help="of a flat punch with a round edge (0)")
    group.add_argument("--faces", type=checked(tips.RULES["faces"], int), metavar="N", help="of a pyramid (4)")
    group.add_argument("--calibration", metavar="FILE", help="area function of the tip and compliance of the frame, by scripts/calibrate.py")
    group.add_argument("--area-function", type=checked(COEFFICIENTS, load_depth.numbers),
                       metavar="C0,C1,...", help="area C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) ... in nm2 of a contact depth h in nm")


def given_tip(options):
    """Returns the Tip of the command line; None where it names none."""
    sizes = {name: getattr(options, name) for name in tips.RULES}
    given = {name: size for name, size in sizes.items() if size is not None}
    if sum(map(bool, (options.calibration, options.area_function, options.tip))) > 1:
        raise Error("--area-function, --calibration: must stand without each other and without --tip")
    if given and not options.tip:
        raise Error(f"{spelt(next(iter(given)))}: must stand beside --tip")
    if options.calibration:
        return calibration.read(options.calibration)[0]
    if options.area_function:
        return tips.tip_of_function(options.area_function)
    if options.tip is None:
        return None
    return presets.make_tip(options.tip, given, spelt)


def parse(arguments):
    """Returns the options of the command line."""
    rules = oliver_pharr.RULES
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("curves", nargs="+", metavar="DIR|FILE", help="result folder of a run, or text with columns of a measured curve")
    parser.add_argument("--out", metavar="DIR", help="folder for what is written (default: that of the first curve)")
    parser.add_argument("--test", type=checked(WHOLE, int), metavar="N", help="of measured files with several tests only this one (all)")
    add_reading_options(parser)
    parser.add_argument("--window", type=checked(rules["window"], load_depth.numbers),
                        metavar="LOW,HIGH", help="part of the unloading that is fitted, of its load (0.5,0.97; with --iso 0.4,0.98)")
    parser.add_argument("--iso", action="store_true", help="by the conventions of ISO 14577: epsilon of the unloading's exponent, beta 1, that window; "
                        "with HM, HMs, H_IT, E_IT, eta_IT, and HV, HBW, HRC or HRB where tip and test have them")
    parser.add_argument("--epsilon", type=checked(rules["epsilon"]), help="of the contact depth h - epsilon P/S (by the tip)")
    parser.add_argument("--beta", type=checked(rules["beta"]), help="of S = 2 beta Er sqrt(A/pi) (by the tip)")
    parser.add_argument("--poisson", type=checked(rules["poisson"]), help="Poisson's ratio of the specimen (that of the run)")
    parser.add_argument("--tip-elastic", type=checked(TIP_ELASTIC, load_depth.numbers), default=(math.inf, 0.0), metavar="GPA,NU",
                        help="modulus and Poisson's ratio of a tip that is not rigid")
    add_tip_options(parser)
    outputs.add_options(parser, checked, column)
    options = parser.parse_args(arguments)
    if options.calibration and options.frame_compliance is None:
        options.frame_compliance = calibration.read(options.calibration)[1]
    outputs.check(options)
    return options


# ---- curves ----

def attempt(name, read):
    """Returns the Analysis of a test with the Curve that read() gives, or with the problem that it meets."""
    try:
        return Analysis(name, read())
    except ResultError as problem:
        return Analysis(name, problem=problem)


def read_curves(path, options):
    """Returns a list with an Analysis for the run in a folder, or for each test in a measured file."""
    name = Path(path).name
    if Path(path).is_dir():
        return [attempt(Path(path).resolve().name, lambda: load_depth.read_run(path))]
    try:
        tests = load_depth.measured_tests(path, options.depth, options.load, options.time, options.zero_depth, options.zero_load, options.drift,
                                          options.frame_compliance, options.stiffness)
        if options.test and options.test > len(tests):
            raise ResultError(path, f"there is no test {options.test}; there are {len(tests)}")
    except ResultError as problem:
        return [Analysis(name, problem=problem)]
    return [attempt(*test) for test in (tests[options.test - 1:options.test] if options.test else tests)]


def completed(read, given):
    """Returns Analyses with different names, whose Curves have a tip, that of a run or of a file's head, else `given` or that of the
    first that has one, and if they are measured the Poisson's ratio of the runs, where these have the same. `given` counts more than a file's head."""
    curves = [each.curve for each in read if each.curve]
    tip = given or next((curve.tip for curve in curves if curve.tip), None)

    def tip_of(curve):
        return (curve.cells is None and given) or curve.tip or tip
    ratios = {curve.poisson for curve in curves if curve.cells is not None}
    poisson = ratios.pop() if len(ratios) == 1 else None
    names = [each.name for each in read]
    for number, (name, curve, *_, problem) in enumerate(read, start=1):
        name += f" {number}" * (names.count(name) > 1)
        if curve and not curve.plane and not (curve.tip or tip):
            problem = ResultError(curve.name, "its tip is not known: give --tip or --area-function")
        if problem:
            yield Analysis(name, problem=problem)
            continue
        if curve.cells is None and poisson is not None:
            curve = curve._replace(poisson=poisson, notes=curve.notes + [f"Poisson's ratio is {poisson:g}, that of the run, unless --poisson says another"])
        own = None if curve.plane else tip_of(curve)
        continued = [f"below {1e3 * own.repaired:.3g} nm the area function is not calibrated, or that of no tip, and is continued by a power"] if own and own.repaired else []
        yield Analysis(name, curve._replace(name=name, tip=own, notes=curve.notes + continued))


def analysed(each, constants):
    """Returns an Analysis with the figures of its Curve, or with the problem that keeps it from having some."""
    if each.problem:
        return each
    try:
        rows, fits = zip(*oliver_pharr.analysed(each.curve, constants))
    except ResultError as problem:
        return each._replace(problem=problem)
    return each._replace(rows=rows, fits=fits, curve=each.curve._replace(notes=[*each.curve.notes, *oliver_pharr.notes_on(rows)]))


# ---- output ----

def without_nan(row):
    """Returns a row for JSON, where what is not known is null."""
    return {name: without_nan(value) if isinstance(value, dict) else None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in row.items()}


def flat(row):
    """Returns a row for CSV, where what is not known is empty, and the expected errors are columns of their own."""
    errors = {f"expected_error_{name}": error for name, error in (row.get("expected_error") or {}).items()}
    return {name: "" if isinstance(value, float) and math.isnan(value) else value
            for name, value in {**row, **errors}.items() if name != "expected_error"}


def write_tables(folder, analyses, found):
    """Writes indentation.csv and indentation.json, of outputs.Found too."""
    rows = [flat(row) for each in analyses for row in each.rows or [{"curve": each.name, "warnings": f"no figures: {each.problem.problem}"}]]
    with open(folder / "indentation.csv", "w", newline="") as file:
        known = [name for name in oliver_pharr.COLUMNS if name != "expected_error"]
        writer = csv.DictWriter(file, [*known, *dict.fromkeys(name for row in rows for name in row if name not in known)])
        writer.writeheader()
        writer.writerows(rows)
    described = [{"name": each.name, "tip": each.curve.tip.name if each.curve and each.curve.tip else None,
                  "notes": each.curve.notes if each.curve else [], "problem": each.problem.problem if each.problem else None,
                  "cycles": [without_nan(row) for row in each.rows], **without_nan(outputs.described(each.name, found))} for each in analyses]
    (folder / "indentation.json").write_text(json.dumps({"curves": described}, indent=2) + "\n")


def print_figures(each):
    """Prints the figures of the largest unloading of a curve, and all notes and warnings, or why there are none."""
    if each.problem:
        print(f"{each.name}: no figures: {each.problem.problem}")
        return
    row, _ = max(fitted(each), key=lambda pair: pair[0]["load_mN"])
    print(f"{each.name}: unloading {row['cycle']} of {len(each.rows)}" + (f", {each.curve.tip.name}" if each.curve.tip else ""))
    for label, name, unit in report_page.SHOWN:
        if not math.isnan(row[name]):
            error = (row["expected_error"] or {}).get(name, math.nan)
            print(f"  {label:28s} {row[name]:.5g} {unit}".rstrip() + f" +- {100 * error:.2g} % by cells and block" * math.isfinite(error))
    for note in each.curve.notes:
        print(f"  note: {note}")
    for row in each.rows:
        if row["warnings"]:
            print(f"  warning, unloading {row['cycle']}: {row['warnings']}")


def fitted(each):
    """Returns pairs of a dict of results and an Unloading of an Analysis, without those unloadings that cannot be fitted."""
    return [(row, fit) for row, fit in zip(each.rows, each.fits) if fit]


# ---- picture ----

@pictures.styled
def draw(analyses, path, uncertainties=MappingProxyType({})):
    """Writes the picture: all curves with fits and contact depths, and where there are several unloadings hardness and modulus of each.

    Curves have their names where there is room for these, else the numbers of their order among all.
    """
    several = sum(math.isfinite(row["hardness_GPa"]) for each in analyses for row in each.rows) > 1
    figure = pictures.plt.figure(figsize=(11.5 if several else 6.8, 4.8), layout="constrained")
    grid = figure.add_gridspec(2, 2 if several else 1)
    left = figure.add_subplot(grid[:, 0])
    shown = [(number, each) for number, each in enumerate(analyses, start=1) if each.rows]
    by_name = sum(len(each.name) for _, each in shown) <= LETTERS
    for number, each in shown:
        name = each.name if by_name else f"{number}: {each.name}"
        draw_curve(left, f"C{number - 1}", each, name if len(shown) <= MOST_NAMES else f"_{name}", with_fits=len(shown) <= MOST_FITS)
    slow = any(each.curve.load_is_quasi_static for _, each in shown)
    pictures.line_axes(left, "depth (µm)", f"load{' without inertia and damping' * slow} (mN)")
    handles = dict(zip(*left.get_legend_handles_labels()[::-1]))  # one of a label
    if handles:
        left.legend(handles.values(), handles)
    if several:
        above = figure.add_subplot(grid[0, 1])
        draw_figures((above, figure.add_subplot(grid[1, 1], sharex=above)), shown, by_name, uncertainties)
    save(figure, path)


def draw_curve(axes, colour, each, label, with_fits):
    """Draws load over depth, for each unloading the power law down to zero load, and the tangent that leads to the contact depth."""
    axes.plot(each.curve.depth, each.curve.load, color=colour, linestyle="-", linewidth=1.2 if with_fits else 0.5, label=label)
    for row, fit in fitted(each) if with_fits else []:
        depth = np.linspace(fit.final_depth, fit.depth, 200)
        axes.plot(depth, oliver_pharr.fitted_load(fit, depth), color="black", linestyle="--", linewidth=1, label="power law")
        if math.isfinite(row["contact_depth_um"]):
            foot = fit.depth - fit.load / fit.stiffness
            axes.plot([foot, fit.depth], [0, fit.load], color="0.5", linestyle=":", linewidth=1)
            axes.plot(row["contact_depth_um"], 0, "o", color=colour, markersize=5, clip_on=False)
            axes.plot([], [], "o", color="0.3", markersize=5, label="contact depth")  # of all curves, in the legend


def draw_figures(both, shown, by_name, uncertainties):
    """Draws hardness into the upper and modulus into the lower axes: over depth, or where no curve has several unloadings by curve; with the
    interval that holds 95 % of the draws at the largest load of curves that have one, {name: Uncertainty}."""
    rows = [row for _, each in shown for row, _ in fitted(each)]
    modulus = "modulus_GPa" if all(math.isfinite(row["modulus_GPa"]) for row in rows) else "reduced_modulus_GPa"
    over_depth = any(len(fitted(each)) > 1 for _, each in shown)
    for axes, name in zip(both, ("hardness_GPa", modulus)):
        for number, each in shown:
            own = [row for row, _ in fitted(each)]
            places = [row["depth_um"] if over_depth else number for row in own]
            axes.plot(places, [row[name] for row in own], "o-", color=f"C{number - 1}", markersize=6 if len(shown) <= MOST_FITS else 2)
            if each.name in uncertainties:
                known, row = uncertainties[each.name], outputs.largest(each)[0]
                axes.vlines(row["depth_um"] if over_depth else number, known.lower[name], known.upper[name], color=f"C{number - 1}", label="_95 %")
        pictures.line_axes(axes, "", name.replace("_GPa", "").replace("_", " ") + " (GPa)")
        axes.set_ylim(0, 1.2 * np.nanmax([row[name] for row in rows]))
        axes.margins(x=0.05)
    both[0].tick_params(labelbottom=False)
    both[1].set_xlabel("depth (µm)" if over_depth else "" if by_name else "curve")
    if not over_depth:
        numbers = [number for number, _ in shown]
        both[1].set_xlim(numbers[0] - 0.5, numbers[-1] + 0.5)
        both[1].xaxis.set_major_locator(MaxNLocator(integer=True))
    if by_name and not over_depth:
        both[1].set_xticks(numbers, [each.name for _, each in shown])


@command
def main(arguments=None):
    """Analyses the curves that the command line names."""
    options = parse(arguments)
    constants = oliver_pharr.checked_constants(options.iso, window=options.window, epsilon=options.epsilon, beta=options.beta, poisson=options.poisson,
                                               tip_modulus=options.tip_elastic[0], tip_poisson=options.tip_elastic[1])
    read = [each for path in options.curves for each in read_curves(path, options)]
    analyses = [analysed(each, constants) for each in completed(read, given_tip(options))]
    good = [each for each in analyses if not each.problem]
    found = outputs.found_of(analyses, constants, options)
    if not good and not found.over_depth:
        raise analyses[0].problem
    first = Path(options.curves[0])
    folder = Path(options.out) if options.out else first if first.is_dir() else first.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_tables(folder, analyses, found)
    except OSError as problem:
        raise ResultError(folder, f"cannot be written to ({problem.strerror})") from None
    print(folder / "indentation.csv", folder / "indentation.json", sep="\n")
    draw(analyses, folder / "indentation.png", found.uncertainties)
    outputs.write(folder, analyses, found, options)
    for each in analyses:
        print_figures(each)
        outputs.print_figures(each.name, found)
    return 0 if len(good) == len(analyses) else 2


if __name__ == "__main__":
    main()
