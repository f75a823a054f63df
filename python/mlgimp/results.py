"""Reads the result folder of a run: history.csv, points_FFFFFF.h5 and summary.json. All values are SI."""

import json
from collections import namedtuple
from pathlib import Path

import h5py
import numpy as np

from . import checks
from .errors import Error, ResultError

Frame = namedtuple("Frame", "time step levels")
Frame.__doc__ = """One frame of points: time (s), step of level 0, and levels, a list with one dict per grid
level that maps each dataset's name to its array [points of the level][components]."""


HISTORY_COLUMNS = ("time", "depth", "load", "kinetic_energy", "strain_energy", "dissipated_energy", "external_work",
                   "indenter_work")  # that the scripts look at
POINT_DATASETS = {2: {"position": 2, "half_size": 2, "stress": 4},  # components by dimension
                  3: {"position": 3, "half_size": 3, "stress": 6}}


NOT_ENDED = "not ended"  # the status in summary.json while a run goes on, and for good where it was ended from outside
MEANS = ("load", "load_quasi_static", "friction_force")  # since the row before


class History(dict):
    """The columns of history.csv by name, arrays [rows] in SI units, in the order of the file."""

    def __missing__(self, name):
        raise Error(f"history.csv has no column {name}; there are {', '.join(self)}")

    def beside(self, name, column):
        """Returns the numbers of a column, as depths, to which those of the column `name` belong, [rows].

        A force is the mean since the row before, so that it belongs to the middle between both.
        """
        values = self[column]
        return np.append(values[:1], (values[1:] + values[:-1]) / 2) if name in MEANS else values

    def table(self):
        """Returns the columns as a pandas.DataFrame, or where there is no pandas as a record array of numpy."""
        try:
            import pandas
        except ImportError:
            return np.rec.fromarrays(list(self.values()), names=list(self))
        return pandas.DataFrame(self)


def read_history(directory):
    """Returns the History of a result folder."""
    path = Path(directory) / "history.csv"
    try:
        header, *lines = path.read_text().splitlines() or [""]
    except OSError:
        raise ResultError(directory, "no results here (history.csv cannot be read)") from None
    except ValueError:
        raise ResultError(path, "not a table of numbers, but no text") from None
    names = header.split(",")
    absent = [name for name in HISTORY_COLUMNS if name not in names]
    if absent:
        raise ResultError(path, f"not the history of a run: there is no column {absent[0]}")
    try:
        table = np.array([line.split(",") for line in lines], float).reshape(-1, len(names))
    except ValueError:
        raise ResultError(path, f"not a table of {len(names)} columns of numbers") from None
    return History(zip(names, table.T))


def read_summary(directory):
    """Returns summary.json as a dict, whose status is NOT_ENDED while the run goes on; an empty one where there is none."""
    path = Path(directory) / "summary.json"
    if not path.exists():
        return {}
    try:
        summary = json.loads(path.read_text())
    except (OSError, ValueError) as problem:
        raise ResultError(path, f"not valid JSON ({problem})") from None
    try:
        level_boxes(summary)
    except (AttributeError, KeyError, TypeError, ValueError):
        raise ResultError(path, "not the summary of a run: it must be an object whose levels have lower and upper") from None
    return summary


def case_name(directory):
    """Returns the name of the case in a result folder, or the folder's own name where there is no summary.json."""
    return read_summary(directory).get("case") or Path(directory).resolve().name


def level_boxes(summary, time=None):
    """Returns the boxes of the grid levels as an array [levels][lower, upper][x, y, in space z] in m, coarsest first.

    time (s): of boxes that follow the contact those at this time, without levels that rest then; by default those at the end.
    """
    levels = summary.get("levels", [])
    boxes = [(level["lower"], level["upper"]) for level in levels]
    if time is not None:
        boxes = [box for box in (box_at(summary, level, time, box) for level, box in enumerate(boxes)) if box]
    return np.array(boxes, float).reshape(len(boxes), 2, len(levels[0]["lower"]) if levels else 2)


def box_at(summary, level, time, last):
    """Returns the box (lower, upper) of a level at a time, `last` where it never moves, None where it rests or has not moved yet."""
    moves = [move for move in summary.get("regrids", []) if move["level"] == level]
    before = [move for move in moves if move["time"] < time]  # boxes move after the frame of a step
    if not before:
        return None if moves else last
    return (before[-1]["lower"], before[-1]["upper"]) if before[-1]["active"] else None


def finest_cells(summary, times):
    """Returns the edge (m) of the finest cells at times (s), [times], without those of levels that rest; NaN where it is not known."""
    sizes = np.full(len(times), np.nan)
    for level, each in enumerate(summary.get("levels", [])):
        moves = [move for move in summary.get("regrids", []) if move["level"] == level]
        begins = np.array([move["time"] for move in moves])
        is_active = np.array([not moves, *(move["active"] for move in moves)])
        sizes[is_active[np.searchsorted(begins, times)]] = each.get("cell_size", np.nan)
    return sizes


def numbered_frames(directory):
    """Returns {number: path} of the frames points_FFFFFF.h5 of a result folder, in the order of their numbers."""
    frames = sorted(Path(directory).glob("points_[0-9]*.h5"), key=number_in)
    return {number_in(path): path for path in frames if path.stem.removeprefix("points_").isdigit()}


def find_frame(directory, number=None):
    """Returns the path of the frame with this number, by default of the last one."""
    numbered = numbered_frames(directory)
    if not numbered:
        raise ResultError(directory, "no results here (there is no points_*.h5)")
    number = max(numbered) if number is None else checks.whole("frame", number)
    if number not in numbered:
        raise ResultError(directory, f"no frame {number}; there are {min(numbered)} to {max(numbered)}")
    return numbered[number]


def read_time(path):
    """Returns the time (s) of a frame."""
    try:
        with h5py.File(path, "r") as file:
            return float(file.attrs["time"])
    except (OSError, KeyError, TypeError, ValueError) as problem:
        raise ResultError(path, f"not a frame of points ({problem})") from None


def read_contact_area(path):
    """Returns the area of contact (m2) at the time of a frame, 0 where there is none or the frame does not have it."""
    with h5py.File(path, "r") as file:
        return float(file.attrs.get("contact_area", 0))


def numbers_of(dataset):
    """Returns the numbers of a dataset of a frame; real ones as doubles, also those of -frame_precision single."""
    return dataset.astype(float)[()] if dataset.dtype.kind == "f" else dataset[()]


def read_frame(path):
    """Returns the Frame stored in a points_FFFFFF.h5; a level without points has arrays of length 0."""
    try:
        with h5py.File(path, "r") as file:
            groups = sorted((name for name in file if name.startswith("level_")), key=number_in)
            levels = [{name: numbers_of(data) for name, data in file[group].items() if name != "vertex"} for group in groups]  # of ParaView
            if not levels:
                raise KeyError("no group level_0")
            for group, level in zip(groups, levels):
                check_points(group, level)
            return Frame(float(file.attrs["time"]), int(file.attrs["step"]), levels)
    except (OSError, KeyError, AttributeError, TypeError, ValueError) as problem:
        raise ResultError(path, f"not a frame of points ({problem})") from None


def check_points(group, level):
    """Raises a ValueError where a level lacks a dataset that the scripts need, or has it in another shape."""
    dim = level["position"].shape[1] if "position" in level and level["position"].ndim == 2 else 2
    for name, components in POINT_DATASETS.get(dim, POINT_DATASETS[2]).items():
        if name not in level:
            raise ValueError(f"{group} has no {name}")
        if level[name].shape != (len(level["position"]), components):
            raise ValueError(f"{name} of {group} has not {components} components a point")


def all_points(levels):
    """Returns the points of all levels as one dict of arrays; `level` tells where each point came from."""
    counts = [len(level["position"]) for level in levels]
    points = {name: np.concatenate([level[name] for level in levels]) for name in levels[0]}
    return points | {"level": np.repeat(np.arange(len(levels)), counts)}


def has_indenter(history):
    """True where a history [rows] tells of an indenter: one that has moved from where it began."""
    return bool(np.any(np.nan_to_num(history["depth"])))


def energy_residual(history):
    """Returns the energy that the run cannot account for, an array [rows] in J.

    Energy now (kinetic, strain, dissipated) less the work put in (external, indenter), the kinetic energy at the start and, of
    bodies with an initial stress, the strain energy at time 0: 0 for a perfect balance, positive where energy has appeared.
    """
    present = history["kinetic_energy"] + history["strain_energy"] + history["dissipated_energy"]
    supplied = history["external_work"] + history["indenter_work"]
    stored = history["strain_energy"][:1] * (history["time"][:1] == 0)
    return present - supplied - history["kinetic_energy"][:1] - stored


def number_in(name):
    """Returns the number at the end of a frame's path or of a group's name: 12 for points_000012.h5."""
    digits = Path(name).stem.rpartition("_")[2]
    return int(digits) if digits.isdigit() else -1
