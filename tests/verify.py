#!/usr/bin/env python3
"""Runs the studies that take longer than a test should, the functions verify_* in tests/cases, and reports on them.

usage: tests/verify.py [WORD ...]      only the studies whose name (file.study) is, or else contains, one of the words
       tests/verify.py --report        none: only writes the page and the document anew

Writes to output/verify/: report.html, one page with all figures, goals and plots; verification.md, docs/verification.md
with the figures of this run; studies/NAME.json, what each study found. Studies that were not selected are shown as they
were found last. The exit status is 0 only if every study shown reached all its goals.
"""
import datetime
import inspect
import json
import re
import sys
import time

import harness
import run

import report
import report_markdown

FOLDER = harness.ROOT / "output" / "verify"
DOCUMENT = harness.ROOT / "docs" / "verification.md"
INTRODUCTION = [
    "Every figure that the program is judged by, as computed by make verify. Unless said, with default settings: cpGIMP, MUSL, "
    "short-wave viscosity 0.001,8, CFL 0.4, neo-Hookean, four points per cell, plane strain.",
    "Most studies drive bin/mlgimp by its options alone; each lists its command lines. The manufactured solution needs a body "
    "force, and the waves and vibrating blocks an initial velocity, that no option offers: those come from the programs bin/test_*.",
]


def split_detail(detail):
    """(rest of the name, figure, goal) of what a check says, "REST: FIGURE (GOAL)"; a figure begins as a number does."""
    text, goal = re.fullmatch(r"(.*?)(?: \(((?:[<>]= |\S+ \+- ).*)\))?", detail, re.S).groups()
    rest, _, figure = text.rpartition(": ")
    is_figure = re.match(r"[-+.\d\[]|nan|inf", figure)
    return (rest, figure, goal or "") if is_figure else (text, "", "")


class Study(harness.Report):
    """A report that keeps its rows, and plots and tables beside them, for the page. See scripts/report.py."""

    def __init__(self, name, title, text):
        super().__init__()
        self.name, self.title, self.text = name, title, text
        self.command = f"tests/verify.py {name}"  # what shows the figures that follow
        self.figures, self.tables, self.plots = [], [], []

    def note(self, name, good, detail=""):
        """A check without a figure has the goal yes."""
        super().note(name, good, detail)
        rest, seen, goal = split_detail(detail)
        if not seen:
            seen, goal = ("yes" if good else "no"), "yes"
        self.figures.append(report.row(f"{name}: {rest}" if rest else name, seen, goal, good, self.command))

    def figure(self, name, value, unit=""):
        """A figure without a goal."""
        self.note(name, True, f"{value:.4g} {unit}".strip())

    def table(self, title, header, cells):
        self.tables.append(report.table(title, header, cells))

    def plot(self, title, xlabel, ylabel, *curves, **options):
        self.plots.append(report.figure(title, xlabel, ylabel, curves, **options))

    def result(self, seconds, runs):
        """All that the page needs, as a dict."""
        return {"name": self.name, "title": self.title, "text": self.text, "command": f"tests/verify.py {self.name}",
                "seconds": seconds, "date": datetime.datetime.now().isoformat(" ", "minutes"), "runs": runs,
                "rows": self.figures, "tables": self.tables, "plots": self.plots}


def collect():
    """{name: function} of all studies."""
    return {name.replace(": verify_", "."): function for name, function in run.collect("verify_")}


def choose(names, words):
    """The names that a word is, or else is a part of; all without words."""
    return [name for name in names if not words or name in words or any(word in name for word in words if word not in names)]


def carry_out(name, function):
    """Runs a study; returns what it found."""
    title, _, text = inspect.getdoc(function).partition("\n")
    study = Study(name, title.rstrip("."), " ".join(text.split()))
    begin, runs_before = time.time(), len(harness.ran)
    run.run_function(name, function, study)
    return study.result(time.time() - begin, list(dict.fromkeys(harness.ran[runs_before:])))


def stored(name):
    return FOLDER / "studies" / f"{name}.json"


def known(names):
    """What the studies found last, of those that have been run."""
    return [json.loads(stored(name).read_text()) for name in names if stored(name).exists()]


def check_document(studies):
    """A study about docs/verification.md itself: it has the rows of all studies, with the same goals."""
    study = Study("--report", "docs/verification.md", "The committed document has a row for each figure of this page, with the same goal.")
    lines = report_markdown.differences(DOCUMENT.read_text(), studies)
    differ = f"{len(lines)} differences, the first: {lines[0]}" if lines else ""
    study.note("docs/verification.md has the figures and goals of this page", not lines, differ)
    return study.result(0, [])


def write(studies):
    """The page and the document."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "verification.md").write_text(report_markdown.fill_in(DOCUMENT.read_text(), studies))
    shown = studies + [check_document(studies)]
    (FOLDER / "report.html").write_text(report.page("Verification of mlgimp", INTRODUCTION, shown))
    return report.falls_short(shown)


def main(words):
    studies = collect()
    chosen = [] if words == ["--report"] else choose(studies, words)
    if not chosen and words != ["--report"]:
        sys.exit(f"error: {' '.join(words)}: must be part of one of {', '.join(studies)}")
    stored("any").parent.mkdir(parents=True, exist_ok=True)
    try:
        for number, name in enumerate(chosen, start=1):
            print(f"[{number}/{len(chosen)}] {name}", flush=True)
            stored(name).write_text(json.dumps(carry_out(name, studies[name]), indent=1))
    finally:
        harness.clean_up()
    missed = write(known(studies))
    for line in missed:
        print(f"falls short: {line['name']}: {line['seen']} ({line['goal']})")
    print(f"{(FOLDER / 'report.html').relative_to(harness.ROOT)}: {len(missed)} figures fall short of their goals")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
