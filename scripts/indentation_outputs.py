"""What scripts/indentation.py writes when it is asked to, beside its tables: figures over the depth, uncertainties, curves as instruments
write them, a page."""

import math
import re
import shlex
import sys
from collections import namedtuple
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import save

from mlgimp import csm, export, load_depth, oliver_pharr, page_parts, report_page, uncertainty
from mlgimp.errors import Error
from mlgimp.heads import STIFFNESS_UNITS

Found = namedtuple("Found", "over_depth summaries uncertainties")
Found.__doc__ = "Dicts by the names of curves: csm.OverDepth, its summary, and uncertainty.Uncertainty."


# ---- command line ----

def add_options(parser, checked, column):
    """Adds the options; checked and column are functions that make readers of values, see scripts/indentation.py."""
    group = parser.add_argument_group("more that is written")
    group.add_argument("--stiffness", type=column(STIFFNESS_UNITS), metavar="COLUMN:UNIT", help="of measured curves, of the contact all the time (CSM): "
                       "writes csm.csv and csm.png, hardness and modulus over the depth")
    group.add_argument("--csm", action="store_true", help="the same of the unloadings of each curve that has three or more")
    group.add_argument("--csm-range", type=checked(csm.RANGE, load_depth.numbers), metavar="LOW,HIGH", help="depths in nm between which their means are "
                       "taken (0.5 to 0.95 of the largest depth)")
    group.add_argument("--uncertainty", nargs="?", const=1000, type=checked(uncertainty.DRAWS, int), metavar="N", help="writes uncertainty.csv: standard "
                       "uncertainties of hardness and modulus by source, of N draws (1000)")
    for name, unit, text in (("zero", "NM", "of the contact point"), ("compliance", "NM/MN", "of the frame"), ("area", "PERCENT", "of the tip's area"),
                             ("poisson", "NU", "of Poisson's ratio"), ("depth", "NM", "noise of each row's depth"), ("load", "UN", "noise of its load")):
        rule = next(rule for key, rule in uncertainty.RULES.items() if key.partition("_")[0] == name)
        group.add_argument(f"--u-{name}", type=checked(rule), metavar=unit, help=f"standard uncertainty {text} (docs/indentation.md)")
    group.add_argument("--other-cells", metavar="DIR", help="the same run on other cells, from which the uncertainty by cells follows")
    group.add_argument("--export", choices=export.FORMATS, help="writes each curve as NAME.txt with columns of nm, uN, s")
    group.add_argument("--export-noise", type=checked(export.NOISE, load_depth.numbers), metavar="NM,UN", help="noise that is added to it (0,0)")
    group.add_argument("--seed", type=int, default=1, help="of random numbers (1)")
    group.add_argument("--report", action="store_true", help="writes indentation.html, a page that needs no other file")


def check(options):
    """Refuses options that need others."""
    inputs = [name for name in vars(options) if name.startswith("u_") and getattr(options, name) is not None]
    for name, needed, given in [("--other-cells", "--uncertainty", options.other_cells), ("--export-noise", "--export", options.export_noise),
                                ("--csm-range", "--csm or --stiffness", options.csm_range), *((f"--{each.replace('_', '-')}", "--uncertainty", 1) for each in inputs)]:
        has = {"--uncertainty": options.uncertainty, "--export": options.export, "--csm or --stiffness": options.csm or options.stiffness}[needed]
        if given is not None and not has:
            raise Error(f"{name}: needs {needed}")
    if options.seed < 0:
        raise Error(f"--seed {options.seed}: must be a whole number >= 0")


# ---- figures ----

def found_of(analyses, constants, options):
    """Returns what is Found of Analyses with a curve."""
    if options.other_cells and not any(each.curve and each.curve.cells is not None for each in analyses):
        raise Error("--other-cells: must stand beside a run")
    tables, summaries, known = {}, {}, {}
    for each in analyses:
        if not each.curve:
            continue
        if each.curve.stiffness is not None or options.csm and each.rows:
            over = csm.over_depth(each.curve, each.rows, constants)
            if over is not None:
                tables[each.name] = over
                deep = csm.UNLOADED if each.curve.stiffness is None else csm.DEEP
                summaries[each.name] = csm.summary(over, options.csm_range and [1e-3 * end for end in options.csm_range], deep)
        if options.uncertainty and each.rows:
            known[each.name] = uncertainty_of(each, constants, options)
    if options.csm and not tables:
        raise Error(f"--csm: needs --stiffness, or a curve with {csm.LEAST} unloadings")
    return Found(tables, summaries, known)


def uncertainty_of(each, constants, options):
    """Returns the Uncertainty of the largest unloading of an Analysis."""
    row, fit = largest(each)
    given = uncertainty.Inputs(options.u_zero, options.u_compliance, options.u_area, options.u_poisson, options.u_depth, options.u_load)
    other = None
    if options.other_cells and each.curve.cells is not None:
        other = max(oliver_pharr.analyse(load_depth.read_run(options.other_cells), constants), key=lambda row: row["load_mN"])
    return uncertainty.uncertainty(each.curve, row, fit, constants, given, options.uncertainty, options.seed, other)


def largest(each):
    """Returns the dict of results and the Unloading of an Analysis with the largest load of those that are fitted."""
    return max(((row, fit) for row, fit in zip(each.rows, each.fits) if fit), key=lambda pair: pair[0]["load_mN"])


def described(name, found):
    """Returns what indentation.json has of these figures of a curve, a dict."""
    result = {"over_depth": found.summaries[name]} if name in found.summaries else {}
    if name in found.uncertainties:
        known = found.uncertainties[name]
        result["uncertainty"] = {"draws": known.draws, "standard": known.deviation, "lower_95": known.lower, "upper_95": known.upper,
                                 "by_source": {share.source: {"input": share.input, **share.deviation} for share in known.shares},
                                 "not_included": known.left_out}
    return result


# ---- files ----

def write(folder, analyses, found, options):
    """Writes and prints what is found, and what else the options ask for."""
    if found.over_depth:
        csm.write(folder / "csm.csv", found.over_depth)
        print(folder / "csm.csv")
        save(csm.draw(found.over_depth), folder / "csm.png")
    if found.uncertainties:
        uncertainty.write(folder / "uncertainty.csv", found.uncertainties)
        print(folder / "uncertainty.csv")
    for each in analyses:
        if options.export and each.curve:
            curve = export.with_noise(each.curve, options.export_noise, options.seed) if options.export_noise else each.curve
            path = folder / f"{file_name(each.name)}.txt"
            if str(path.resolve()) in [str(Path(given).resolve()) for given in options.curves]:
                raise Error(f"--export: would write over {path}; give another folder by --out")
            export.write(path, curve, options.export)
            print(path)
    if options.report:
        write_report(folder, analyses, found, options)


def file_name(name):
    """Returns a curve's name as that of a file, without its ending; letters that a file may not have become lines."""
    return re.sub(r"[^\w.+-]+", "_", re.sub(r"\.(txt|csv|tsv|dat)\b", "", name)).strip("_.") or "curve"


def print_figures(name, found):
    """Prints the means over the depth and the uncertainties of a curve."""
    if name in found.summaries:
        own = found.summaries[name]
        print(f"  from {1e3 * own['from_depth_um']:.4g} to {1e3 * own['to_depth_um']:.4g} nm, means of {own['rows']} rows:")
        for label, key in (("hardness", "hardness_GPa"), ("reduced modulus", "reduced_modulus_GPa"), ("specimen's modulus", "modulus_GPa")):
            if math.isfinite(own[key]):
                print(f"    {label:26s} {own[key]:.5g} GPa, standard deviation {own[key + '_deviation']:.3g}")
    for line in uncertainty.lines_of(found.uncertainties[name]) if name in found.uncertainties else ():
        print(line)


def write_report(folder, analyses, found, options):
    """Writes indentation.html."""
    runs = {Path(path).resolve().name: path for path in options.curves if Path(path).is_dir()}
    tests = []
    for each in analyses:
        test = {"name": each.name, "facts": [], "options": {}, "figures": [], "sources": [], "notes": [],
                "warnings": [f"no figures: {each.problem.problem}"] if each.problem else []}
        if each.curve:
            known = found.uncertainties.get(each.name)
            run = runs.get(each.name) if each.curve.cells is not None else None
            test["facts"], test["options"] = report_page.facts_of(each.curve, run, options.poisson)
            test["notes"] = list(each.curve.notes)
            test["warnings"] += [f"unloading {row['cycle']}: {row['warnings']}" for row in each.rows if row["warnings"]]
            test["warnings"] += [f"not included in the intervals: {sentence}" for sentence in known.left_out] if known else []
            test["figures"] = report_page.figures_of(largest(each)[0], known) if each.rows else []
            test["sources"] = sources_of(known) if known else []
        tests.append(test)
    pictures = [path for path in (folder / "indentation.png", folder / "csm.png" if found.over_depth else None) if path and path.exists()]
    text = report_page.page("Indentation: " + ", ".join(each.name for each in analyses), tests, pictures, shlex.join(["scripts/indentation.py", *sys.argv[1:]]))
    path = folder / "indentation.html"
    page_parts.write(path, text)
    print(path)


def sources_of(known):
    """Returns the rows of texts of a table of uncertainties by source, of which the first is its head."""
    names = [name for name in uncertainty.QUANTITIES if math.isfinite(known.values[name])]
    rows = [(share.source, share.input, *(f"{100 * share.deviation[name] / known.values[name]:.2f} %" for name in names)) for share in known.shares]
    total = ("total", f"{known.draws} draws", *(f"{100 * known.deviation[name] / known.values[name]:.2f} %" for name in names))
    return [("source", "input", *(name.rpartition("_")[0].replace("_", " ") for name in names)), *rows, total]
