#!/usr/bin/env python3
"""Takes what studies found last into the verification book: docs/images/results/NAME.json and NAME.png of each page, from
output/verify/studies/. `make verify` does so with the studies that it has run.

    scripts/book.py                all pages whose studies have been run here
    scripts/book.py hertz norton   only those whose name contains one of the words
"""

import argparse
import json
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import ROOT, Parser, command

sys.path.insert(0, str(ROOT / "docs" / "book"))
import studies_page
import results
from gallery import save_small
from result_page import number, target

from mlgimp import pictures
from mlgimp.errors import Error

STUDIES = ROOT / "output" / "verify" / "studies"
KEPT_RUNS = 2  # command lines on a page, of the first runs of each study
MOST_NAMED = 24  # rows in a picture; of more every second name, or third, is written


# ---- what is kept of studies ----

def rows_of(page, studies):
    """Returns the rows of a page, in the order of its parts; studies: {name: what was found}."""
    return [row for name, begin in page.parts for row in studies[name]["rows"] if re.match(begin, row["name"])]


def portable(line):
    """Returns a command line whose files are named without folders of this machine."""
    return re.sub(r"(?<=\s)/\S*/", "", line)


def largest(values):
    """Returns the largest of some values, without those that are None; None where there are no others."""
    return max((value for value in values if value is not None), default=None)


def data_of(page, studies):
    """Returns what the book keeps of a page: rows, tables, first command lines, cells, steps, and time and date of its studies."""
    own = {name: studies[name] for name in dict.fromkeys(name for name, _ in page.parts)}
    times = [each["seconds"] for each in own.values()]
    return {"studies": {name: {"date": each["date"]} for name, each in own.items()}, "seconds": None if None in times else round(sum(times), 1),
            "cells": largest(each.get("cells") for each in own.values()), "steps": largest(each.get("steps") for each in own.values()),
            "runs": [portable(line) for each in own.values() for line in each["runs"][:KEPT_RUNS]],
            "tables": [each for study in own.values() for each in study["tables"]],
            "rows": [{name: value for name, value in row.items() if name != "command"} for row in rows_of(page, own)]}


def differences(studies):
    """Returns lines about rows of studies of the book that are on no page, or on several; studies: {name: what was found}."""
    lines = []
    for name in results.STUDIES:
        begins = [begin for page in results.PAGES for study, begin in page.parts if study == name]
        for row in studies.get(name, {"rows": []})["rows"]:
            pages = sum(bool(re.match(begin, row["name"])) for begin in begins)
            if pages != 1:
                lines.append(f"{name}: {row['name']} is on {pages} pages of the book")
    return lines


# ---- pictures ----

@pictures.styled
def picture(page, studies, rows):
    """Returns the picture of a page: the plot of its studies, where it names one that they have, else its rows."""
    plots = [each for name in dict.fromkeys(name for name, _ in page.parts) for each in studies[name]["plots"]]
    chosen = [each for each in plots if page.plot and each["title"].startswith(page.plot)]
    figure, axes = pictures.plt.subplots(figsize=(6.4, 4.4))
    if chosen:
        studies_page.draw_on(axes, chosen[0])
        axes.set_title(chosen[0]["title"])
    else:
        draw_rows(axes, rows)
    return figure


def share(row):
    """Returns which part of its goal a row uses up, 1 at the limit, with the sign of the difference; None where it has no such goal."""
    seen, aim, limit = number(row["seen"]), target(row), re.fullmatch(r"([<>])= (\S+)", row["goal"])
    if seen is None or aim and not aim[1] or limit and not float(limit[2]):
        return None
    if aim:
        return (seen - aim[0]) / aim[1]
    return None if not limit else seen / float(limit[2]) if limit[1] == "<" else float(limit[2]) / seen


def draw_rows(axes, rows):
    """Draws which part of its goal each row uses up, between the two limits; where no row has a goal, what was seen."""
    shown = [(row, share(row)) for row in rows if share(row) is not None]
    label = "difference from theirs, as part of the goal"
    if shown:
        axes.axvspan(-1, 1, color="0.92", zorder=0)
        axes.set_xlim(min(-1.15, *(1.1 * value for _, value in shown)), max(1.15, *(1.1 * value for _, value in shown)))
    else:
        shown, label = [(row, number(row["seen"])) for row in rows if number(row["seen"]) is not None], "seen"
    heights = list(range(len(shown), 0, -1))
    axes.axvline(0, color="black", linewidth=1, linestyle=":")
    axes.scatter([value for _, value in shown], heights, c=["#009E73" if row["good"] else "#D55E00" for row, _ in shown], s=28, zorder=3)
    step = 1 + (len(shown) - 1) // MOST_NAMED
    axes.set_yticks(heights[::step], [short(row["name"]) for row, _ in shown][::step], fontsize=8)
    axes.set_xlabel(label)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)


def short(name, most=64):
    """Returns a name that fits beside a picture."""
    return name if len(name) <= most else name[:most - 1] + "…"


# ---- taking ----

def take(page, studies):
    """Writes the data and the picture of a page; studies: {name: what was found}, at least those of the page."""
    pictures.make_folder(results.FOUND)
    data = data_of(page, studies)
    if not data["rows"]:
        raise Error(f"{page.name}: no row of {', '.join(name for name, _ in page.parts)} is on this page")
    (results.FOUND / f"{page.name}.json").write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n")
    figure = picture(page, studies, data["rows"])
    save_small(figure, results.FOUND / f"{page.name}.png")
    pictures.plt.close(figure)


def known():
    """Returns {name: what was found} of the studies of the book that have been run here."""
    return {name: json.loads((STUDIES / f"{name}.json").read_text()) for name in results.STUDIES if (STUDIES / f"{name}.json").exists()}


def pages_of(words):
    """Returns the pages whose name is a word, or else contains one; all without words."""
    names = [page.name for page in results.PAGES]
    chosen = [page for page in results.PAGES if not words or page.name in words
              or any(word in page.name for word in words if word not in names)]
    if not chosen:
        raise Error(f"{' '.join(words)}: must be part of a page's name, as {', '.join(names)}")
    return chosen


def complete(page, studies):
    """Whether all studies of a page are among some."""
    return all(name in studies for name, _ in page.parts)


@command
def main(arguments=None):
    """Takes the pages that the command line names, by default all whose studies have been run here."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", metavar="WORD", help="parts of pages' names (default: all pages)")
    words, studies = parser.parse_args(arguments).words, known()
    for page in pages_of(words):
        if complete(page, studies):
            take(page, studies)
        elif words:
            raise Error(f"{page.name}: run its studies first, by make verify BOOK={page.name}")


if __name__ == "__main__":
    main()
