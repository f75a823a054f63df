"""What all pictures share: units of the laboratory, the look, saving; and the line plots of a run."""

import contextlib
import contextvars
import functools
from collections import namedtuple
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from . import checks, results
from .errors import ResultError

Unit = namedtuple("Unit", "factor name")  # value in SI x factor = value in the unit of this name

LABORATORY = {"m": Unit(1e6, "µm"), "N": Unit(1e3, "mN")}  # what is used where numbers stay readable
READABLE = 0.1, 2e4  # the largest number on an axis
LETTER = 0.55  # mean width of letters, of their height
FEW = 40  # rows, below which points are joined
SHALLOW = 0.1  # of the largest depth: where a tip has hardly touched, figures may be any, and no axis follows them
DOTS_PER_INCH = 160
STYLE = {
    "figure.dpi": DOTS_PER_INCH, "font.size": 12, "axes.titlesize": 13, "axes.titlepad": 10,
    "legend.frameon": False, "legend.fontsize": 11, "legend.handlelength": 2.6,
    "axes.grid": False, "grid.color": "0.9", "axes.axisbelow": True, "lines.linewidth": 1.8,
    "axes.prop_cycle": plt.cycler(color=["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"],
                                  linestyle=["-", "--", "-.", "-", "--", "-."]),  # curves may coincide
}
Look = namedtuple("Look", "text width has_titles ending dots")
Look.__doc__ = """How pictures look: size of the text in points, width of a whole picture in inches or None for each its own, whether it has a title,
the ending of its file, and dots per inch."""
LOOKS = {"screen": Look(STYLE["font.size"], None, True, ".png", DOTS_PER_INCH),
         "paper": Look(8, 85 / 25.4, False, ".pdf", 600)}  # a column of a journal is 85 mm wide
ENDINGS = ".png", ".pdf", ".svg"
OTHER_ENDINGS = ".jpg", ".jpeg", ".gif", ".eps", ".tif", ".tiff", ".bmp", ".webp"
LOOK = contextvars.ContextVar("look", default=LOOKS["screen"])
PAPER_LINES = {"axes.linewidth": 0.6, "lines.linewidth": 1.0, "grid.linewidth": 0.5, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
               "xtick.major.size": 2.5, "ytick.major.size": 2.5, "svg.fonttype": "none", "pdf.fonttype": 42}
HIDDEN = 0.01  # of the largest energy: a line below lies on the axis
ENERGIES = {"kinetic_energy": "-", "strain_energy": "-", "dissipated_energy": "-", "external_work": "--", "indenter_work": "--"}


@contextlib.contextmanager
def looking(style):
    """While it is open, pictures are drawn and saved in a style of LOOKS."""
    if style not in LOOKS:
        raise checks.refusal("style", style, f"one of {', '.join(LOOKS)}")
    token = LOOK.set(LOOKS[style])
    try:
        yield
    finally:
        LOOK.reset(token)


def settings():
    """Returns the settings of matplotlib for the present Look."""
    look = LOOK.get()
    if look == LOOKS["screen"]:
        return STYLE
    texts = {name: look.text for name in ("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize")}
    return {**STYLE, **PAPER_LINES, **texts, "figure.dpi": look.dots, "axes.titlepad": 4, "legend.handlelength": 1.6}


def styled(draw):
    """Decorates a function that draws: settings() count while it does, the user's own settings before and after.

    rc_context would forget the backend, too, which a notebook chooses with its first figure.
    """
    @functools.wraps(draw)
    def drawn(*arguments, **named):
        own = settings()
        before = {name: plt.rcParams[name] for name in own}
        plt.rcParams.update(own)
        try:
            return draw(*arguments, **named)
        finally:
            plt.rcParams.update(before)
    return drawn


def size_of(width, height):
    """Returns the size in inches of a picture that on a screen has a width and a height in inches."""
    whole = LOOK.get().width
    return (width, height) if whole is None else (whole, whole * height / width)


def shrink():
    """Returns how large the text, and what is made for it as margins, is beside that on a screen."""
    return LOOK.get().text / LOOKS["screen"].text


def title_of(directory):
    """Returns the name of the case in a result folder, of which matplotlib shows each letter: a $ begins no formula."""
    return results.case_name(directory).replace("$", r"\$")


def entitle(axes, title):
    """Gives axes a title, where pictures have one."""
    if LOOK.get().has_titles:
        axes.set_title(title)


def in_lines(title, width):
    """Returns a title in lines that fit into a width in inches, broken behind commas."""
    letters, lines = int(width * 72 / (LETTER * STYLE["axes.titlesize"])), [""]
    for part in title.split(", "):
        if lines[-1] and len(f"{lines[-1]}, {part}") > letters:
            lines.append(part)
        else:
            lines[-1] += ", " * bool(lines[-1]) + part
    return "\n".join(lines)


# ---- units ----

def si_unit(values, symbol):
    """Returns the Unit with the prefix (n, u, m, k, ...) that puts the largest of |values| into 1 .. 1000."""
    largest = np.max(np.abs(values), initial=0)
    exponent = 3 * int(np.floor(np.log10(largest * (1 + 1e-9)) / 3)) if largest > 0 else 0
    exponent = min(max(exponent, -15), 12)
    return Unit(10.0**-exponent, "fpnµm kMGT"[exponent // 3 + 5].strip() + symbol)


def lab_unit(values, symbol):
    """Returns the laboratory's Unit for lengths (m) and forces (N) where numbers in it are readable, else that of si_unit."""
    largest = np.max(np.abs(values), initial=0)
    unit = LABORATORY.get(symbol)
    return unit if unit and READABLE[0] <= largest * unit.factor <= READABLE[1] else si_unit(values, symbol)


def in_si_unit(value, symbol):
    """Returns a value as text with a prefixed unit: 2.25e-8, 's' gives '22.5 ns'."""
    unit = si_unit(value, symbol)
    return f"{value * unit.factor:.4g} {unit.name}"


# ---- lines ----

def line_axes(axes, xlabel, ylabel):
    """Gives axes the look that all line plots share."""
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.grid(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.02)


def draw_load_depth(axes, curves, load_unit, depth_unit, what="load"):
    """Draws load against depth; curves is a list of (label, depth [rows] m, load [rows] N, line style); what: the load in words."""
    for label, depth, load, style in curves:
        axes.plot(depth * depth_unit.factor, load * load_unit.factor, label=label, **style)
    line_axes(axes, f"depth ({depth_unit.name})", f"{what} ({load_unit.name})")
    if len(curves) > 1:
        axes.legend()


@styled
def load_depth(history, title):
    """Returns the picture of load against depth of one run."""
    load, depth = history["load"], history.beside("load", "depth")
    figure, axes = plt.subplots(figsize=size_of(6.4, 4.6), layout="constrained")
    what = "load with inertia and damping" if "load_quasi_static" in history else "load"
    draw_load_depth(axes, [(title, depth, load, {})], lab_unit(load, "N"), lab_unit(depth, "m"), what)
    entitle(axes, title)
    return figure


@styled
def compared(tests):
    """Returns the picture of tests beside each other, a list of (measured load_depth.Curve, runs): the curve as dots, and of the runs, a
    list of (label, Curve, colour), lines."""
    figure, beside = plt.subplots(1, len(tests), figsize=(6.8 * len(tests), 4.8), layout="constrained", squeeze=False)
    for axes, (measured, runs) in zip(beside[0], tests):
        axes.plot(measured.depth, measured.load, ".", color="C0", markersize=2, linestyle="none", label=measured.name)
        for label, curve, colour in runs:
            axes.plot(curve.depth, curve.load, color=colour, linestyle="-", linewidth=1.3, label=label)
        line_axes(axes, "depth (µm)", "load (mN)")
        axes.legend()
    return figure


@styled
def over_depth(curves):
    """Returns the picture of figures over the depth in panels: curves is a list of (name, depths [rows] um, {label of a panel: values [rows]})."""
    figure, panels = plt.subplots(len(curves[0][2]), 1, sharex=True, figsize=(6.8, 8.4), layout="constrained")
    for axes, label in zip(panels, curves[0][2]):
        for number, (name, depth, values) in enumerate(curves):
            style = {"marker": "o", "markersize": 4} if len(depth) < FEW else {"marker": ".", "markersize": 2, "linestyle": "none"}
            axes.plot(depth, values[label], color=f"C{number}", label=name, **style)
        line_axes(axes, "", label)
        deep = np.concatenate([values[label][depth >= SHALLOW * depth.max()] for _, depth, values in curves])
        axes.set_ylim(0, 1.3 * np.nanmax(deep))
    panels[-1].set_xlabel("depth (µm)")
    if len(curves) > 1:
        panels[0].legend()
    return figure


@styled
def hold(time, measured, fitted_time, fitted, ylabel, name):
    """Returns the picture of a hold: measured values [rows] over the time of the test (s) as dots, and what was fitted to them as a line."""
    figure, axes = plt.subplots(figsize=(6.8, 4.8), layout="constrained")
    axes.plot(time, measured, ".", color="C0", markersize=2, linestyle="none", label=name)
    axes.plot(fitted_time, fitted, color="C1", linestyle="-", linewidth=1.3, label="fit")
    line_axes(axes, "time of the test (s)", ylabel)
    axes.legend()
    return figure


@styled
def test(history, title):
    """Returns the picture of depth and load of one run over the time of its test, from its first thousandth on."""
    time, depth, load = (history[name] for name in ("test_time", "depth", "load"))
    depth_unit, load_unit, rows = lab_unit(depth, "m"), lab_unit(load, "N"), time >= 1e-3 * time[-1]
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=size_of(6.4, 5.2), height_ratios=[2, 1], layout="constrained")
    above.plot(time[rows], depth[rows] * depth_unit.factor)
    below.plot(time[rows], load[rows] * load_unit.factor)
    line_axes(above, "", f"depth ({depth_unit.name})")
    line_axes(below, "time of the test (s)", f"load ({load_unit.name})")
    below.set_xscale("log")
    entitle(above, title)
    figure.align_ylabels()
    return figure


def size_if_hidden(history, name):
    """Returns the largest value of one of the ENERGIES in words, where its line lies on the axis beside the others; else nothing."""
    largest, most = np.abs(history[name]).max(), max(np.abs(history[each]).max() for each in ENERGIES)
    return f",\nat most {in_si_unit(largest, 'J')}" if 0 < largest < HIDDEN * most else ""


@styled
def energy(history, title):
    """Returns the picture of the energies and works against time, with the residual of their balance below."""
    residual = results.energy_residual(history)
    time_unit, residual_unit = si_unit(history["time"], "s"), si_unit(residual, "J")
    unit = si_unit([history[name] for name in ENERGIES], "J")
    time = history["time"] * time_unit.factor
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=size_of(7.6, 6.2), height_ratios=[2.6, 1], layout="constrained")
    for name, style in ENERGIES.items():
        above.plot(time, history[name] * unit.factor, style, label=name.replace("_", " ") + size_if_hidden(history, name))
    below.plot(time, residual * residual_unit.factor, "-", color="0.25")
    below.axhline(0, color="0.6", linewidth=0.8)
    line_axes(above, "", f"energy ({unit.name})")
    line_axes(below, f"time ({time_unit.name})", f"residual ({residual_unit.name})")
    above.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    entitle(above, title)
    figure.align_ylabels()
    return figure


# ---- files ----

def make_folder(path):
    """Makes a folder for pictures, where there is none."""
    try:
        Path(checks.path("out", path)).mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise ResultError(path, f"must be a folder for pictures ({problem.strerror})") from None


def save_all(figures, out):
    """Writes figures, {name: Figure}, into a folder, or the only one to a file whose name ends as that of a picture, closes them, and returns
    the paths."""
    suffix = Path(checks.path("out", out)).suffix.lower()
    if suffix in OTHER_ENDINGS:
        raise ResultError(out, f"must end in {', '.join(ENDINGS)}, or be a folder")
    if suffix in ENDINGS:
        if len(figures) != 1:
            raise ResultError(out, f"must be a folder for {len(figures)} pictures; a file holds one")
        paths = [Path(out)]
    else:
        make_folder(out)
        paths = [Path(out) / f"{name}{LOOK.get().ending}" for name in figures]
    for figure, path in zip(figures.values(), paths):
        save(figure, path)
    return paths


def save(figure, path):
    """Writes a figure to a file whose ending says of what kind, and closes it; where pictures have a width of their own, it keeps that."""
    look = LOOK.get()
    try:
        with plt.rc_context({name: settings()[name] for name in ("svg.fonttype", "pdf.fonttype") if name in settings()}):
            figure.savefig(path, dpi=look.dots, **({"bbox_inches": "tight", "pad_inches": 0.12} if look.width is None else {}))
    except (OSError, ValueError) as problem:  # no such folder, no such kind of picture, a label that is no formula
        raise ResultError(path, f"cannot be drawn ({' '.join(str(problem).split())})") from None
    finally:
        plt.close(figure)
