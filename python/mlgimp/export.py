"""Load-depth curves as instruments write them, for programs that read these; with noise, if it is asked for."""

import math
from datetime import datetime
from pathlib import Path

import numpy as np

from . import checks
from .checks import Rule
from .errors import Error, ResultError

NOISE = Rule(lambda sizes: len(sizes) == 2 and all(0 <= size < math.inf for size in sizes), "NM,UN, two numbers >= 0")
HEADS = "Depth (nm)\tLoad (\N{MICRO SIGN}N)\tTime (s)"
FORMATS = {  # lines above the names of the columns, of a date and how many rows there are; the text's encoding
    "hysitron": (lambda date, rows: [date, "", f"Number of Points = {rows}"], "latin-1"),
    "text": (lambda date, rows: [], "utf-8"),
}


def with_noise(curve, noise, seed=1):
    """Returns a Curve with noise added to each row: normal, with standard deviations (nm of the depth, uN of the load)."""
    of_depth, of_load = 1e-3 * np.array(checks.several("noise", noise, NOISE))
    random = np.random.default_rng(checks.whole("seed", seed, 0))
    return curve._replace(depth=curve.depth + of_depth * random.normal(size=len(curve.depth)),
                          load=curve.load + of_load * random.normal(size=len(curve.load)))


def time_of(curve):
    """Returns the times (s) of a Curve: those of the test that a run stands for, else its own, else the numbers of the rows."""
    known = next((time for time in (curve.test_time, curve.time) if time is not None), None)
    return np.arange(len(curve.load), dtype=float) if known is None else known


def write(path, curve, kind="hysitron"):
    """Writes a Curve as columns of depth (nm), load (uN) and time (s), parted by tabs, with decimal points.

    kind: "hysitron", the text that TriboScan writes, with a date, an empty line and the number of rows above the names of the columns;
    or "text", the columns alone. Numbers have ten digits, more than any instrument.
    """
    if kind not in FORMATS:
        raise Error(f"kind={kind}: must be one of {', '.join(FORMATS)}")
    above, encoding = FORMATS[kind]
    lines = above(f"{datetime.now():%d.%m.%Y %H:%M:%S}", len(curve.load)) + [HEADS]
    lines += [f"{1e3 * depth:.10g}\t{1e3 * load:.10g}\t{time:.10g}" for depth, load, time in zip(curve.depth, curve.load, time_of(curve))]
    try:
        Path(path).write_text("\n".join(lines) + "\n", encoding=encoding)
    except OSError as problem:
        raise ResultError(path, f"cannot be written ({problem.strerror})") from None
