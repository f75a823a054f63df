"""Many runs of a case, one for each combination of values: on all cores, with a table of what they found, and going on where it stopped."""

import csv
import hashlib
import itertools
import json
import math
import os
import re
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from . import checks, load_depth, oliver_pharr, results, units
from . import options as text
from .errors import Error, Interrupted, ResultError
from .indentation import indent, indentation_options
from .program import execute, is_watched, show_bar

FOUND = ("largest_load_mN", "largest_depth_um", "hardness_GPa", "modulus_GPa", "true_hardness_GPa", "true_modulus_GPa")  # of a row
LONGEST_NAME = 100  # letters of a folder
KEY = "sweep.json"  # in the folder of each run: what it was made with


def sweep(case, grid, *, folder="output/sweep", jobs=None, progress=None, **fixed):
    """Runs a case with all combinations of some values, one rank each, and returns a table of what they found.

    case: the path of an options file, a dict of options as for run(), mlgimp.indent, or a function that returns a dict of options, which gets
    the values by name. grid: {name: values}, as {"indenter_half_angle": [60, 70.3], "metal_yield_stress": [4e8, 5e8]}; `fixed` are
    options, or arguments of the function, that are the same in all. folder: where each combination has a folder with its values in its name,
    and the table is sweep.csv. jobs: how many runs at once, by default one for each core. progress: a bar, by default where it is seen.

    The rows are in the order of the grid: the values, status, FOUND (NaN where a run has none, as without an unloading), folder, seconds and
    warnings. A combination that has completed with the same options is not run again; one that fails is a row whose status says why.
    An interrupt ends the runs that go on, and becomes an Interrupted. Returns a pandas.DataFrame, or without pandas a list of dicts. Raises an Error where nothing can be run.
    """
    rows = rows_of(case, grid, folder=folder, jobs=jobs, progress=progress, **fixed)
    try:
        import pandas
    except ImportError:
        return rows
    return pandas.DataFrame(rows)


def rows_of(case, grid, *, folder="output/sweep", jobs=None, progress=None, **fixed):
    """Makes the runs of sweep() and returns its rows, a list of dicts."""
    checks.mapping("grid", grid)
    values = {name: list(each) for name, each in grid.items() if not isinstance(each, str)}
    if not grid or len(values) < len(grid) or not all(values.values()):
        raise Error("grid: must have names with lists of values, none of them empty")
    if not callable(case) and not isinstance(case, Mapping) and not Path(checks.path("case", case)).is_file():
        raise ResultError(case, "there is no such options file")
    folder = Path(checks.path("folder", folder))
    shows = is_watched() if progress is None else progress
    jobs = cores() if jobs is None else checks.whole("jobs", jobs, 1)
    combinations = [dict(zip(values, each)) for each in itertools.product(*values.values())]
    rows = [{**each, "status": "waiting"} for each in combinations]
    names = folder_names(combinations)
    make(folder)
    with ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(row_of, case, fixed, each, folder / name): place for place, (each, name) in enumerate(zip(combinations, names))}
        try:
            for done, job in enumerate(as_completed(waiting), start=1):
                rows[waiting[job]] = job.result()
                write(folder / "sweep.csv", rows, values)
                if shows:
                    show_bar(done, len(rows), f"{done} of {len(rows)} runs", end="\n" if done == len(rows) else "")
        except KeyboardInterrupt:
            done = sum(row["status"] != "waiting" for row in rows)
            raise Interrupted(f"stopped when {done} of {len(rows)} runs were done, as {folder / 'sweep.csv'} says; the same call goes on") from None
        finally:
            for job in waiting:
                job.cancel()
    return rows


def cores():
    """Returns how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# ---- one run ----

def row_of(case, fixed, values, folder):
    """Makes the run of a combination, unless it is there, and returns its row."""
    row, warnings = {**values, "status": "", **dict.fromkeys(FOUND, math.nan), "folder": str(folder), "seconds": math.nan, "warnings": ""}, []
    try:
        options = options_of(case, fixed, values)
        key = key_of(options)
        if not is_there(folder, key):
            make(folder)
            (folder / KEY).unlink(missing_ok=True)
            execute({**options, "output_dir": folder, "overwrite": True}, tell=warnings.append)
            (folder / KEY).write_text(key)
        summary = results.read_summary(folder)
        warnings = summary.get("warnings", warnings)
        row |= {"status": summary.get("status", results.NOT_ENDED), "seconds": summary.get("wall_seconds", math.nan)}
        row |= figures_of(folder)
    except Error as problem:
        row["status"] = row["status"] or f"failed: {problem}"
        warnings = warnings + [str(problem)] * row["status"].startswith("completed")
    row["warnings"] = "; ".join(warnings)
    return row


def options_of(case, fixed, values):
    """Returns the options of a combination of values, a dict by names without dashes."""
    if not callable(case):
        own = dict(case) if isinstance(case, Mapping) else {"options_file": checks.path("case", case)}
        return {**text.named(own), **text.named(fixed), **text.named(values)}
    given = (indentation_options if case is indent else case)(**fixed, **values)
    groups = [given] if isinstance(given, Mapping) else given
    return {name: value for group in groups for name, value in group.items()}


def key_of(options):
    """Returns as text what a run is made with: its options, and what its options file says."""
    own = {name: None if value is None else text.text_of(value) for name, value in options.items()}
    file = options.get("options_file")
    try:
        return json.dumps({"options": own, "file": Path(file).read_text() if file else ""}, indent=1)
    except OSError as problem:
        raise ResultError(file, f"cannot be read ({problem.strerror})") from None


def is_there(folder, key):
    """Whether a folder has a run that has completed and was made with the same."""
    try:
        return (folder / KEY).read_text() == key and results.read_summary(folder).get("status") == "completed"
    except OSError:
        return False


def figures_of(folder):
    """Returns FOUND of the run in a folder as a dict: of the unloading from the largest load, as far as there is one."""
    curve = load_depth.read_run(folder)
    found = {"largest_load_mN": float(curve.load.max()), "largest_depth_um": float(curve.depth.max())}
    try:
        largest = max(oliver_pharr.analyse(curve), key=lambda row: row["load_mN"])
    except ResultError:  # no unloading
        return found
    return found | {name: float(largest[name]) for name in FOUND if name in largest}


# ---- folders and the table ----

def folder_names(combinations):
    """Returns a name for the folder of each combination: its values, with a number where two would have the same."""
    names = []
    for values in combinations:
        words = "_".join(f"{name}_{text.text_of(value)}" for name, value in values.items())
        name = re.sub(r"[^\w.+-]+", "_", words)
        if name != words or len(name) > LONGEST_NAME or name in names:
            name = f"{name[:LONGEST_NAME]}_{hashlib.sha256(words.encode()).hexdigest()[:8]}"
        names.append(name)
    return names


def make(folder):
    """Makes a folder, where there is none."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise ResultError(folder, f"must be a folder for the runs ({problem.strerror})") from None


def plotted(name, values):
    """Returns the head of a column of values in the table, and these values as numbers: texts with units are in SI units, which the head names."""
    found = [units.QUANTITY.fullmatch(value) if isinstance(value, str) else None for value in values]
    if not any(each and each[2] and units.unit(each[2]) for each in found):
        return name, {}
    base = {units.unit(base)[0]: base for base, _ in units.KINDS.values()}
    symbol = next((base.get(units.unit(each[2])[0]) for each in found if each and each[2] and units.unit(each[2])), None)
    return name + f"_{symbol}" * bool(symbol), {value: units.in_si(value) for value, each in zip(values, found) if each and units.unit(each[2])}


def cell(name, value):
    """Returns a value of a row as sweep.csv has it: nothing where it is not known, and what a run has found with twelve digits."""
    if isinstance(value, float) and math.isnan(value):
        return ""
    return f"{value:.12g}" if name in FOUND else text.text_of(value)


def write(path, rows, values):
    """Writes the table of the rows that are done, through a file of its own, so that a reader never sees half of it."""
    part = path.with_suffix(".part")
    heads = {name: plotted(name, each) for name, each in values.items()}
    rows = [{heads[name][0] if name in heads else name: heads[name][1].get(value, value) if name in heads and isinstance(value, str) else value
             for name, value in row.items()} for row in rows]
    try:
        with open(part, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, [*(head for head, _ in heads.values()), "status", *FOUND, "folder", "seconds", "warnings"])
            writer.writeheader()
            writer.writerows({name: cell(name, value) for name, value in row.items()}
                             for row in rows if row["status"] != "waiting")
        part.replace(path)
    except OSError as problem:
        raise ResultError(path, f"cannot be written ({problem.strerror})") from None
