#!/usr/bin/env python3
"""Analyses indentation tests by Oliver and Pharr: result folders of runs, and measured curves beside them.

    scripts/indentation.py output/cone
    scripts/indentation.py output/cone measured.csv --depth "Displacement:nm" --load "Force:mN"
    scripts/indentation.py measured.csv --tip berkovich --poisson 0.3 --tip-elastic 1141,0.07

Writes indentation.json, indentation.csv (a row for each unloading of each curve) and indentation.png. Lengths are in um, loads in mN,
stresses in GPa, work in nJ; a run's loads and areas are those of the whole tip. A measured curve has the tip that is given, or that
of the first run. docs/indentation.md explains the figures.
"""

import argparse
import csv
import json
import math
from pathlib import Path

import numpy as np
from command import Parser, command, save

from mlgimp import load_depth, oliver_pharr, pictures, tips
from mlgimp.checks import Rule
from mlgimp.errors import Error, ResultError
from mlgimp.oliver_pharr import Constants

SHOWN = (("load", "load_mN", "mN"), ("depth", "depth_um", "um"), ("stiffness", "stiffness_mN_per_um", "mN/um"), ("exponent m", "exponent", ""),
         ("contact depth", "contact_depth_um", "um"), ("area", "area_um2", "um2"), ("true area", "true_area_um2", "um2"),
         ("hardness", "hardness_GPa", "GPa"), ("load over true area", "true_hardness_GPa", "GPa"), ("reduced modulus", "reduced_modulus_GPa", "GPa"),
         ("specimen's modulus", "modulus_GPa", "GPa"), ("the same with the true area", "true_modulus_GPa", "GPa"), ("epsilon", "epsilon", ""),
         ("beta", "beta", ""), ("pile-up (< 0: sink-in)", "pile_up_um", "um"), ("plastic over total work", "plastic_share", ""))


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


def spelt(name, value=""):
    """Returns an argument of the package as the command line has it."""
    return f"--{name.replace('_', '-')} {value}".rstrip()


E, NU = (oliver_pharr.RULES[name] for name in ("tip_modulus", "tip_poisson"))
TIP_ELASTIC = Rule(lambda pair: len(pair) == 2 and E.good(pair[0]) and NU.good(pair[1]),
                   f"E,NU with NU {NU.allowed}, E {E.allowed}")
FINITE = Rule(math.isfinite, "a number")
COEFFICIENTS = Rule(lambda numbers: all(map(math.isfinite, numbers)), "C0,C1,...")


def add_tip_options(parser):
    """Adds the options that describe the tip of measured curves."""
    group = parser.add_argument_group("tip of measured curves, and of runs that do not say theirs")
    group.add_argument("--tip", choices=tips.NEEDS, help="its kind")
    group.add_argument("--half-angle", type=checked(tips.RULES["half_angle"]), metavar="DEGREES",
                       help="of a cone or a pyramid, from the axis to a face")
    group.add_argument("--radius", type=checked(tips.RULES["radius"]), metavar="UM", help="of a sphere or a flat punch")
    group.add_argument("--tip-radius", type=checked(tips.RULES["tip_radius"]), metavar="UM",
                       help="of a rounded cone or pyramid (0)")
    group.add_argument("--faces", type=checked(tips.RULES["faces"], int), metavar="N", help="of a pyramid (4)")
    group.add_argument("--area-function", type=checked(COEFFICIENTS, load_depth.numbers),
                       metavar="C0,C1,...", help="area C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) ... in nm2 of a contact depth h in nm")


def given_tip(options):
    """Returns the Tip of the command line; None where it names none."""
    sizes = {name: getattr(options, name) for name in tips.RULES}
    given = {name: size for name, size in sizes.items() if size is not None}
    if options.area_function and options.tip:
        raise Error("--area-function: must stand without --tip")
    if given and not options.tip:
        raise Error(f"{spelt(next(iter(given)))}: must stand beside --tip")
    if options.area_function:
        return tips.tip_of_function(options.area_function)
    if options.tip is None:
        return None
    tips.check_sizes(options.tip, sizes, spelt)
    return tips.make_tip(options.tip, **given)


def parse(arguments):
    """Returns the options of the command line."""
    rules = oliver_pharr.RULES
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("curves", nargs="+", metavar="DIR|FILE", help="result folder of a run, or text with columns of a measured curve")
    parser.add_argument("--out", metavar="DIR", help="folder for what is written (default: that of the first curve)")
    parser.add_argument("--depth", type=column(load_depth.DEPTH_UNITS), default="depth:um", metavar="COLUMN:UNIT",
                        help="of measured curves: name or number of the column, and its unit (depth:um)")
    parser.add_argument("--load", type=column(load_depth.LOAD_UNITS), default="load:mN", metavar="COLUMN:UNIT", help="(load:mN)")
    parser.add_argument("--time", type=column(load_depth.TIME_UNITS), metavar="COLUMN:UNIT", help="to check the order of the rows, and for --drift")
    parser.add_argument("--drift", type=checked(FINITE), default=0, metavar="NM/S",
                        help="thermal drift of measured depths, which is taken off; needs --time")
    parser.add_argument("--window", type=checked(rules["window"], load_depth.numbers), default=oliver_pharr.WINDOW,
                        metavar="LOW,HIGH", help="part of the unloading that is fitted, of its load (0.5,0.97)")
    parser.add_argument("--epsilon", type=checked(rules["epsilon"]), help="of the contact depth h - epsilon P/S (by the tip)")
    parser.add_argument("--beta", type=checked(rules["beta"]), help="of S = 2 beta Er sqrt(A/pi) (by the tip)")
    parser.add_argument("--poisson", type=checked(rules["poisson"]), help="Poisson's ratio of the specimen (that of the run)")
    parser.add_argument("--tip-elastic", type=checked(TIP_ELASTIC, load_depth.numbers), default=(math.inf, 0.0), metavar="GPA,NU",
                        help="modulus and Poisson's ratio of a tip that is not rigid")
    add_tip_options(parser)
    options = parser.parse_args(arguments)
    if options.drift and options.time is None:
        raise Error("--drift: needs --time COLUMN:UNIT")
    return options


def read_curves(options):
    """Returns the Curves of the command line, in its order, each with a tip where one is known."""
    given = given_tip(options)
    curves = [load_depth.read_run(path) if Path(path).is_dir() else read_measured(path, options) for path in options.curves]
    of_runs = next((curve.tip for curve in curves if curve.tip), None)
    curves = [curve if curve.tip or curve.plane else curve._replace(tip=given or of_runs) for curve in curves]
    for curve in curves:
        if curve.tip is None and not curve.plane:
            raise ResultError(curve.name, "its tip is not known: give --tip or --area-function")
    names = [curve.name for curve in curves]
    return [curve._replace(name=curve.name if names.count(curve.name) == 1 else f"{curve.name} {k}") for k, curve in enumerate(curves, start=1)]


def read_measured(path, options):
    """Returns a measured Curve without its drift."""
    curve = load_depth.read_measured(path, options.depth, options.load, options.time)
    if options.drift:
        curve = curve._replace(depth=curve.depth - 1e-3 * options.drift * (curve.time - curve.time[0]))
    return curve


# ---- output ----

def without_nan(row):
    """Returns a row for JSON, where what is not known is null."""
    return {name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in row.items()}


def write_tables(folder, curves, rows):
    """Writes indentation.csv and indentation.json."""
    with open(folder / "indentation.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows({name: "" if isinstance(value, float) and math.isnan(value) else value for name, value in row.items()} for row in rows)
    described = [{"name": curve.name, "tip": curve.tip.name if curve.tip else None, "notes": curve.notes,
                  "cycles": [without_nan(row) for row in rows if row["curve"] == curve.name]} for curve in curves]
    (folder / "indentation.json").write_text(json.dumps({"curves": described}, indent=2) + "\n")


def print_rows(curves, rows):
    """Prints the figures of the largest unloading of each curve, and all notes and warnings."""
    for curve in curves:
        own = [row for row in rows if row["curve"] == curve.name]
        row = max(own, key=lambda each: each["load_mN"])
        print(f"{curve.name}: unloading {row['cycle']} of {len(own)}" + (f", {curve.tip.name}" if curve.tip else ""))
        for label, name, unit in SHOWN:
            if not math.isnan(row[name]):
                print(f"  {label:28s} {row[name]:.5g} {unit}".rstrip())
        for note in curve.notes:
            print(f"  note: {note}")
        for each in own:
            if each["warnings"]:
                print(f"  warning, unloading {each['cycle']}: {each['warnings']}")


@pictures.styled
def draw(curves, rows, fits, path):
    """Writes the picture: all curves with fits and contact depths, and hardness and modulus over depth where there are several."""
    several = len(rows) > 1 and any(math.isfinite(row["hardness_GPa"]) for row in rows)
    figure, axes = pictures.plt.subplots(1, 2 if several else 1, figsize=(11.5 if several else 6.8, 4.8), layout="constrained", squeeze=False)
    for number, curve in enumerate(curves):
        own = [(row, fit) for row, fit in zip(rows, fits) if row["curve"] == curve.name]
        draw_curve(axes[0, 0], f"C{number}", curve, own)
    pictures.line_axes(axes[0, 0], "depth (µm)", "load (mN)")
    handles = dict(zip(*axes[0, 0].get_legend_handles_labels()[::-1]))  # one of a label
    axes[0, 0].legend(handles.values(), handles)
    if several:
        draw_over_depth(axes[0, 1], curves, rows)
    save(figure, path)


def draw_curve(axes, colour, curve, rows):
    """Draws load over depth, for each unloading the power law down to zero load, and the tangent that leads to the contact depth."""
    axes.plot(curve.depth, curve.load, color=colour, linestyle="-", linewidth=1.2, label=curve.name)
    for row, fit in rows:
        depth = np.linspace(fit.final_depth, fit.depth, 200)
        axes.plot(depth, oliver_pharr.fitted_load(fit, depth), color="black", linestyle="--", linewidth=1, label="power law")
        if math.isfinite(row["contact_depth_um"]):
            foot = fit.depth - fit.load / fit.stiffness
            axes.plot([foot, fit.depth], [0, fit.load], color="0.5", linestyle=":", linewidth=1)
            axes.plot(row["contact_depth_um"], 0, "o", color=colour, markersize=5, clip_on=False, label="contact depth")


def draw_over_depth(axes, curves, rows):
    """Draws hardness at the left, modulus at the right axis over depth."""
    other, over = axes.twinx(), {name: [row[name] for row in rows] for name in ("hardness_GPa", "modulus_GPa", "reduced_modulus_GPa")}
    modulus = "modulus_GPa" if np.isfinite(over["modulus_GPa"]).all() else "reduced_modulus_GPa"
    for number, curve in enumerate(curves):
        own = [row for row in rows if row["curve"] == curve.name]
        depth = [row["depth_um"] for row in own]
        axes.plot(depth, [row["hardness_GPa"] for row in own], "o-", color=f"C{number}", label=f"hardness, {curve.name}")
        other.plot(depth, [row[modulus] for row in own], "s--", color=f"C{number}", markerfacecolor="white", label=f"modulus, {curve.name}")
    pictures.line_axes(axes, "depth (µm)", "hardness (GPa)")
    other.set_ylabel(modulus.replace("_GPa", "").replace("_", " ") + " (GPa)")
    other.spines["top"].set_visible(False)
    for each, name, room in ((axes, "hardness_GPa", 1.9), (other, modulus, 1.2)):  # the curves apart from each other
        each.set_ylim(0, room * np.nanmax(over[name]))
        each.margins(x=0.05)
    handles = [each.get_legend_handles_labels() for each in (axes, other)]
    axes.legend(handles[0][0] + handles[1][0], handles[0][1] + handles[1][1], loc="lower center", ncols=2)


@command
def main(arguments=None):
    """Analyses the curves that the command line names."""
    options = parse(arguments)
    constants = Constants(tuple(options.window), options.epsilon, options.beta, options.poisson, *options.tip_elastic)
    curves = read_curves(options)
    rows = [row for curve in curves for row in oliver_pharr.analyse(curve, constants)]
    fits = [oliver_pharr.fit_unloading(curve, cycle, constants.window) for curve in curves for cycle in load_depth.find_cycles(curve)]
    first = Path(options.curves[0])
    folder = Path(options.out) if options.out else first if first.is_dir() else first.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_tables(folder, curves, rows)
    except OSError as problem:
        raise ResultError(folder, f"cannot be written to ({problem.strerror})") from None
    print(folder / "indentation.csv", folder / "indentation.json", sep="\n")
    draw(curves, rows, fits, folder / "indentation.png")
    print_rows(curves, rows)


if __name__ == "__main__":
    main()
