#!/usr/bin/env python3
"""Runs the studies that take longer than a test should, the functions verify_* in tests/cases, and reports on them.

usage: tests/verify.py [WORD ...]          only the studies whose name (file.study) is, or else contains, one of the words
       tests/verify.py --book WORD ...     those of the pages of the verification book whose name is, or else contains, one
       tests/verify.py --report            none: only writes the page and the document anew

Writes to output/verify/: report.html, one page with all figures, goals and plots; report.md, docs/report.md
with the figures of this run; studies/NAME.json, what each study found. Studies that were not selected are shown as they
were found last. Data and pictures of the book's pages go to docs/images/results. The exit status is 0 only if every study
shown reached all its goals.

Several studies run side by side, each on a core, but those that measure times or need several ranks, marked `alone`, come one
after the other.
"""
import datetime
import inspect
import json
import os
import re
import sys
import time

import pytest

import harness
import book
import studies_page
import report_markdown
import results

PREFIX = "verify_"  # of the functions that are studies
FOLDER = harness.ROOT / "output" / "verify"
DOCUMENT = harness.ROOT / "docs" / "report.md"
INTRODUCTION = [
    "Every figure that the program is judged by, as computed by make verify. Unless said, with default settings: cpGIMP, MUSL, "
    "short-wave viscosity 0.001,8, CFL 0.4, neo-Hookean, four points per cell, plane strain.",
    "Most studies drive bin/mlgimp by its options alone; each lists its command lines. The manufactured solution needs a body "
    "force, and the waves and vibrating blocks an initial velocity, that no option offers: those come from programs bin/test_*.",
]


def split_detail(detail):
    """(rest of the name, figure, goal) of what a check says, "REST: FIGURE (GOAL)"; a figure begins as a number does."""
    text, goal = re.fullmatch(r"(.*?)(?: \(((?:[<>]= |\S+ \+- ).*)\))?", detail, re.S).groups()
    rest, _, figure = text.rpartition(": ")
    is_figure = re.match(r"[-+.\d\[]|nan|inf", figure)
    return (rest, figure, goal or "") if is_figure else (text, "", "")


def most(values):
    """The largest that is not None, or None."""
    return max((value for value in values if value is not None), default=None)


class Study:
    """Expectations, figures, plots and tables for the page. See scripts/studies_page.py."""

    def __init__(self, name, title, text):
        self.name, self.title, self.text = name, title, text
        self.command = f"tests/verify.py {name}"  # what shows the figures that follow
        self.figures, self.tables, self.plots = [], [], []
        self.expect = harness.Expectations(self.add_row)
        self.begin, self.runs_before = time.time(), len(harness.ran)

    @classmethod
    def of(cls, function, path):
        """That of a function verify_NAME; the first line of its text is the title."""
        title, _, text = inspect.getdoc(function).partition("\n")
        return cls(f"{path.stem}.{function.__name__.removeprefix(PREFIX)}", title.rstrip("."), " ".join(text.split()))

    def add_row(self, name, good, detail):
        """A check without a figure has the goal yes."""
        rest, seen, goal = split_detail(detail)
        if not seen:
            seen, goal = ("yes" if good else "no"), "yes"
        self.figures.append(studies_page.row(f"{name}: {rest}" if rest else name, seen, goal, good, self.command))

    def compare(self, name, ours, theirs, tolerance, unit=""):
        """A value of ours over an exact or published one; the page of the book has both."""
        self.expect(f"{name}, of the exact one", ours / theirs, near=1, tolerance=tolerance)
        self.figures[-1] |= {"ours": f"{ours:.4g} {unit}".strip(), "theirs": f"{theirs:.4g} {unit}".strip()}

    def figure(self, name, value, unit=""):
        """A figure without a goal."""
        self.expect.that(name, True, f"{value:.4g} {unit}".strip())

    def table(self, title, header, cells):
        self.tables.append(studies_page.table(title, header, cells))

    def plot(self, title, xlabel, ylabel, *curves, **options):
        self.plots.append(studies_page.figure(title, xlabel, ylabel, curves, **options))

    def result(self):
        """All that the page needs, as a dict; steps and cells: the most of a run, None where no run has them."""
        runs = harness.ran[self.runs_before:]
        sizes = [harness.size_of(each.folder) for each in runs]
        return {"name": self.name, "title": self.title, "text": self.text, "command": f"tests/verify.py {self.name}",
                "seconds": time.time() - self.begin, "date": datetime.datetime.now().isoformat(" ", "minutes"),
                "runs": list(dict.fromkeys(each.command for each in runs)), "steps": most(size[0] for size in sizes),
                "cells": most(size[1] for size in sizes), "rows": self.figures, "tables": self.tables, "plots": self.plots}

    def store(self):
        stored(self.name).parent.mkdir(parents=True, exist_ok=True)
        stored(self.name).write_text(json.dumps(self.result(), indent=1))


def collect():
    """{name: what pytest calls it} of all studies."""
    return {f"{path.stem}.{name}": f"{path}::{PREFIX}{name}"
            for path in sorted((harness.ROOT / "tests" / "cases").glob("*.py"))
            for name in sorted(re.findall(rf"^def {PREFIX}(\w+)", path.read_text(), re.M))}


def choose(names, words):
    """The names that a word is, or else is a part of; all without words."""
    return [name for name in names if not words or name in words or any(word in name for word in words if word not in names)]


def stored(name):
    return FOLDER / "studies" / f"{name}.json"


def known(names):
    """What the studies found last, of those that have been run."""
    return [json.loads(stored(name).read_text()) for name in names if stored(name).exists()]


def check_document(studies):
    """A study about the documents themselves: each row is in docs/report.md, with the same goal, or else on one page of the book."""
    study = Study("--report", "docs/report.md and the book",
                  "The committed document has a row for each figure of this page, with the same goal, or the verification book has it.")
    in_book = {each["name"]: each for each in studies if each["name"] in results.STUDIES}
    lines = report_markdown.differences(DOCUMENT.read_text(), [each for each in studies if each["name"] not in in_book])
    lines += book.differences(in_book)
    differ = f"{len(lines)} differences, the first: {lines[0]}" if lines else ""
    study.expect.that("docs/report.md and the book have the figures and goals of this page", not lines, differ)
    return study.result()


def write(studies):
    """The page and the document."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "report.md").write_text(report_markdown.fill_in(DOCUMENT.read_text(), studies))
    shown = studies + [check_document(studies)]
    (FOLDER / "report.html").write_text(studies_page.page("Verification of mlgimp", INTRODUCTION, shown))
    return studies_page.falls_short(shown)


def select(studies, arguments):
    """Names of the studies that the command line asks for; none with --report."""
    if arguments == ["--report"]:
        return []
    if arguments[:1] == ["--book"]:
        return list(dict.fromkeys(study for page in book.pages_of(arguments[1:]) for study, _ in page.parts))
    chosen = choose(studies, arguments)
    if not chosen:
        sys.exit(f"error: {' '.join(arguments)}: must be part of one of {', '.join(studies)}")
    return chosen


def take_into_book(chosen):
    """Data and pictures of the pages with a study that was run now, of those whose studies are all known."""
    found = book.known()
    for page in results.PAGES:
        if book.complete(page, found) and any(name in chosen for name, _ in page.parts):
            book.take(page, found)


def run(tests):
    """Runs studies, by what pytest calls them; True where one failed. One study prints its figures as it finds them."""
    if len(tests) == 1:
        return pytest.main(["-m", "study", "-s", *tests]) != 0
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    parts = ["-m", "study and not alone", "-v", "-n", str(cores), "--dist", "loadfile"], ["-m", "study and alone", "-v"]
    statuses = [pytest.main([*part, *tests]) for part in parts]
    return any(status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED) for status in statuses)


@book.command
def main(arguments):
    studies = collect()
    chosen = select(studies, arguments)
    failed = chosen and run([studies[name] for name in chosen])
    take_into_book(chosen)
    missed = write(known(studies))
    for line in missed:
        print(f"falls short: {line['name']}: {line['seen']} ({line['goal']})")
    print(f"{(FOLDER / 'report.html').relative_to(harness.ROOT)}: {len(missed)} figures fall short of their goals")
    return 1 if missed or failed else 0


if __name__ == "__main__":
    main(sys.argv[1:])
