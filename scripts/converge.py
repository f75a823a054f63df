#!/usr/bin/env python3
"""A convergence study of a case: runs it on cells of its own size, half of it, a quarter ..., and says what follows.

usage: scripts/converge.py options/CASE.opts [-refine N] [-quantity NAME] [-depth D | -maximum] [-place X,Y[,Z]] [-ranks N]
                           [options of mlgimp, on all resolutions]

    scripts/converge.py options/wedge_500nm.opts -refine 3 -quantity load -depth 200nm -ranks 2 -indenter_max_depth 250nm

Each resolution is in a folder of its own under output/converge_CASE/ (or -output_dir), which also gets convergence.csv and
convergence.png. Boxes of levels stay where they are. -time_step is halved with the cells, and -max_steps and
-history_interval are doubled, so that rows of the history lie at about the same times.

Order, extrapolated value and error follow from three resolutions in a row with the values a, b, c (Richardson): order
p = log2((a - b)/(b - c)), extrapolated value c + (c - b)/(2^q - 1) with q = p, but at most 2, the order of the method, and
error its distance from c. Where the differences do not shrink there is no order; then the error is how far the last three values lie
apart, and a line says why. Cells are those of level 0. A quantity that the case prescribes, as the load under load control, is refused.
Lengths may have units; options may begin with one dash or two.
"""
import csv
import math
import re
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import asks_for_help, command, one_dash, save, take, whole_number_from

import numpy as np

from mlgimp import fields, pictures, results, units
from mlgimp.errors import Error, RunError
from mlgimp.options import number_of, of_words, read_options
from mlgimp.program import execute

Study = namedtuple("Study", "file refine quantity depth maximum place ranks")
Resolution = namedtuple("Resolution", "cell_size folder points steps value")
METHOD_ORDER = 2
ROUNDING = 1e-6  # of the largest depth, in which a run is some digits short
STRESSES = {**fields.STRESS_COLUMN, "yz": 4, "xz": 5}
NEIGHBOURS = 12  # points that a plane is laid through for the stress at a place
COLUMNS = ("cell_size_m", "points", "steps", "value", "difference", "order", "extrapolated", "error")


def read_length(text):
    """A length in m, of a number or of one with a unit."""
    try:
        return units.in_si(text, "a length")
    except Error as problem:
        raise ValueError from problem


def read_place(text):
    """X,Y or X,Y,Z as an array."""
    place = np.array([read_length(part) for part in text.split(",")])
    if len(place) not in (2, 3):
        raise ValueError
    return place


def written(place):
    """A place as it is given."""
    return ",".join(f"{x:g}" for x in place)


def parse(words):
    """The study that the command line asks for, and the options that are passed on to the program."""
    file, passed = Path(words[0]), of_words(words[1:])
    if not file.is_file():
        raise Error(f"{file}: there is no such options file")
    own = Study(file, take(passed, "refine", whole_number_from(2), 3, "a whole number >= 2"), take(passed, "quantity", str, "load", "a name"),
                take(passed, "depth", read_length, None, "a number in m, or one with a unit of a length (nm, um, mm, m)"), "maximum" in passed,
                take(passed, "place", read_place, None, "X,Y or X,Y,Z"),
                take(passed, "ranks", whole_number_from(1), 1, "a whole number >= 1"))
    if passed.pop("maximum", None) is not None:
        raise Error("-maximum: must stand without a value")
    check(own)
    return own, passed


def check(own):
    """Refuses what does not fit together."""
    is_stress = own.quantity.startswith("stress_")
    if is_stress and own.quantity.removeprefix("stress_") not in STRESSES:
        raise Error(f"-quantity {own.quantity}: must be {', '.join('stress_' + name for name in STRESSES)}")
    if is_stress and own.place is None:
        raise Error(f"-quantity {own.quantity}: needs -place")
    if not is_stress and own.place is not None:
        raise Error(f"-quantity {own.quantity}: is not at a place; leave -place out")
    if (own.depth is not None) + own.maximum + is_stress > 1:
        raise Error("only one of -depth, -maximum and a stress, which is that at the end")


def check_free(own, case):
    """Refuses a quantity that the case prescribes: all resolutions would find the same."""
    by_load = case.get("indenter_control") == "load" or "indenter_loads" in case
    if own.quantity == "depth" and own.depth is not None:
        raise Error("-quantity depth: is what -depth gives; take another quantity, or leave -depth out")
    if own.quantity == "load" and by_load and own.depth is None:
        raise Error("-quantity load: the case prescribes the load (-indenter_loads); take -quantity depth -maximum, or the load at a -depth")
    if own.quantity == "depth" and not by_load and "indenter" in case and "indenter_stiffness" not in case:
        raise Error("-quantity depth: the case prescribes the depth of the tip; take -quantity load")


def refined(case, factor):
    """Options that differ from the case's where its cells are `factor` times smaller."""
    changed = {"cell_size": repr(number_of(case, "cell_size", "nan") / factor),
               "history_interval": round(number_of(case, "history_interval", 1) * factor)}
    if number_of(case, "time_step", 0) > 0:
        changed["time_step"] = repr(number_of(case, "time_step", 0) / factor)
    if number_of(case, "max_steps", 0) > 0:
        changed["max_steps"] = round(number_of(case, "max_steps", 0) * factor)
    return changed


def history_value(folder, own):
    """The quantity of a history at its end, at a depth on the way in, or its largest."""
    history = results.read_history(folder)
    values = column(history, own.quantity)
    if own.maximum:
        return values.max()
    if own.depth is None:
        return values[-1]
    first, deepest = history["depth"][0], history["depth"].max()
    if not first <= own.depth <= deepest * (1 + ROUNDING):
        raise Error(f"-depth {own.depth:g}: must be in [{first:g}, {deepest:g}], as the run went")
    way_in = slice(0, np.argmax(history["depth"]) + 1)
    depths, values = history.beside(own.quantity, "depth")[way_in], values[way_in]
    if own.depth > depths[-1] and len(depths) > 1:  # a mean lies half an interval before its row
        return values[-1] + (values[-1] - values[-2]) / (depths[-1] - depths[-2]) * (own.depth - depths[-1])
    return np.interp(own.depth, depths, values)


def column(history, quantity):
    """A column of a history; energy is what moves and what is stored."""
    if quantity == "energy":
        return history["kinetic_energy"] + history["strain_energy"]
    if quantity not in history:
        raise Error(f"-quantity {quantity}: must be energy, a stress or one of {', '.join(history)}")
    return history[quantity]


def stress_at(folder, component, place):
    """A component of the stress at a place at the end: that of a plane through the points next to it."""
    points = results.all_points(results.read_frame(results.find_frame(folder)).levels)
    if points["position"].shape[1] != len(place) or points["stress"].shape[1] <= STRESSES[component]:
        raise Error(f"-place {written(place)}, -quantity stress_{component}: must be those of the case's geometry")
    away = points["position"] - place
    distance = np.linalg.norm(away, axis=1)
    next_to = np.argsort(distance)[:NEIGHBOURS]
    reach = 2 * points["half_size"][next_to].max()
    if distance[next_to[0]] > reach:
        raise Error(f"-place {written(place)}: must be inside a body at the end of the run")
    planes = np.column_stack([np.ones(len(next_to)), away[next_to] / reach])
    return np.linalg.lstsq(planes, points["stress"][next_to, STRESSES[component]], rcond=None)[0][0]


def resolve(own, case, passed, folder, factor):
    """Runs one resolution and reads what it found."""
    into = folder / f"cells_{number_of(case, 'cell_size', 'nan') / factor:.4g}"
    changed = refined(case, factor)
    try:
        execute({"options_file": own.file, "frames": 1, **passed, **changed, "output_dir": into}, own.ranks)
    except RunError as problem:
        raise Error(f"on cells of {changed['cell_size']} m: {problem}") from None
    summary = results.read_summary(into)
    value = stress_at(into, own.quantity.removeprefix("stress_"), own.place) if own.place is not None else history_value(into, own)
    points = sum(level["points"] for level in summary["levels"])
    return Resolution(number_of(case, "cell_size", "nan") / factor, into, points, summary["steps"], value)


def richardson(values):
    """(difference, order, extrapolated value, error) of the last of the values; NaN for what does not follow. The error is the distance
    from the extrapolated value, or without one how far the last three values lie apart."""
    difference = values[-1] - values[-2] if len(values) > 1 else math.nan
    before = values[-2] - values[-3] if len(values) > 2 else math.nan
    if not abs(difference) < abs(before) or before * difference <= 0:
        return difference, math.nan, math.nan, float(np.ptp(values[-3:])) if len(values) > 2 else math.nan
    order = math.log2(before / difference)
    rest = difference / (2 ** min(order, METHOD_ORDER) - 1)
    return difference, order, values[-1] + rest, abs(rest)


def why_no_order(values):
    """Why there is no order of the last three values, in a sentence with what is given in its place; empty where there is one."""
    if len(values) < 3:
        return "no order: it follows from three resolutions, -refine 3"
    before, difference = np.diff(values[-3:])
    if not math.isnan(richardson(values)[1]):
        return ""
    spread = float(np.ptp(values[-3:]))
    share = f" ({100 * spread / abs(values[-1]):.2g} % of the last)" if values[-1] else ""
    why = ("all three values are the same" if before == difference == 0 else
           "from the coarser to the finer cells the value goes up and down" if before * difference < 0 else
           "the differences do not shrink")
    return (f"no order: {why}, so these cells are not in the range where an order shows; the error is how far the last three values lie "
            f"apart, {spread:.3g}{share}")


def table_rows(resolutions):
    """Rows of the table and of convergence.csv."""
    values = [each.value for each in resolutions]
    return [(each.cell_size, each.points, each.steps, each.value, *richardson(values[:count])) for count, each in enumerate(resolutions, start=1)]


def print_row(row):
    cell, points, steps, *figures = row
    shown = ["-" if math.isnan(figure) else f"{figure:.6g}" for figure in figures]
    print(f"{cell:10.4g} {points:9.0f} {steps:7.0f} " + " ".join(f"{figure:>13s}" for figure in shown), flush=True)


def what(own):
    """The quantity in words."""
    if own.place is not None:
        return f"{own.quantity} at {written(own.place)} at the end"
    return own.quantity + (", largest" if own.maximum else f" at depth {own.depth:g} m" if own.depth is not None else " at the end")


def symbol(quantity):
    """The unit of a quantity."""
    units = {"N": "load", "J": "energy|.*_energy|.*_work", "m": "depth|penetration|.*_width", "s": "time", "Pa": ".*_pressure|stress_.*",
             "N s": "momentum_.*|.*_impulse_.*", "kg": "mass"}
    return next((unit for unit, names in units.items() if re.fullmatch(names, quantity)), "")


def scaled(values, quantity):
    """Values in a unit with a prefix, and the label of an axis."""
    unit = pictures.lab_unit(values, symbol(quantity)) if symbol(quantity) else pictures.Unit(1, "1")
    return np.asarray(values) * unit.factor, f"{quantity.replace('_', ' ')} ({unit.name})"


@pictures.styled
def draw(own, resolutions, rows, path):
    """The history of the quantity (for a stress that of the load or the energy) on all resolutions, and its value against cell size."""
    figure, (left, right) = pictures.plt.subplots(1, 2, figsize=(11.5, 4.6), layout="constrained")
    draw_histories(left, own.quantity, resolutions)
    sizes, size_label = scaled([each.cell_size for each in resolutions], "depth")
    extrapolated, order = rows[-1][6], rows[-1][5]
    values, value_label = scaled([each.value for each in resolutions] + [extrapolated] * (not math.isnan(extrapolated)), own.quantity)
    right.plot(sizes, values[:len(sizes)], "o-")
    if len(values) > len(sizes):
        right.axhline(values[-1], color="black", linestyle=":", label=f"extrapolated, order {order:.2f}")
        right.legend()
    pictures.line_axes(right, size_label.replace("depth", "cells"), value_label)
    right.set_title(what(own))
    right.set_xlim(left=0)
    save(figure, path)


def draw_histories(axes, quantity, resolutions):
    """A quantity against depth, or against time where there is no indenter, of all resolutions."""
    histories = [results.read_history(each.folder) for each in resolutions]
    over = "depth" if results.has_indenter(histories[0]) else "time"
    if quantity.startswith("stress_"):
        quantity = "load" if over == "depth" else "strain_energy"
    lengths = np.cumsum([len(history["time"]) for history in histories])[:-1]
    places, place_label = scaled(np.concatenate([history[over] for history in histories]), over)
    values, value_label = scaled(np.concatenate([column(history, quantity) for history in histories]), quantity)
    for each, x, y in zip(resolutions, np.split(places, lengths), np.split(values, lengths)):
        axes.plot(x, y, label=pictures.in_si_unit(each.cell_size, "m"))
    pictures.line_axes(axes, place_label, value_label)
    axes.legend(title="cells")


@command
def main(words):
    if not words or asks_for_help(words):
        print(__doc__)
        return
    own, passed = parse(one_dash(words))
    case = {**read_options(own.file), **passed}
    if not case.get("cell_size"):
        raise Error(f"{own.file}: must give -cell_size")
    check_free(own, case)
    folder = Path(passed.pop("output_dir", None) or f"output/converge_{own.file.stem}")
    print(f"{own.file.stem}: {what(own)}\n" + f"{'cells (m)':>10s} {'points':>9s} {'steps':>7s} " + " ".join(f"{name:>13s}" for name in COLUMNS[3:]))
    resolutions = []
    for count in range(own.refine):
        resolutions.append(resolve(own, case, passed, folder, 2**count))
        print_row(table_rows(resolutions)[-1])
    rows = table_rows(resolutions)
    if why := why_no_order([each.value for each in resolutions]):
        print(why)
    with open(folder / "convergence.csv", "w", newline="") as file:
        csv.writer(file).writerows([COLUMNS, *rows])
    print(folder / "convergence.csv")
    draw(own, resolutions, rows, folder / "convergence.png")


if __name__ == "__main__":
    main(sys.argv[1:])
