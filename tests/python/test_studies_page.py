"""Checks the page and the document of `make verify` on made-up studies."""

import contextlib
import io
import re
import unittest

import pytest

import report_markdown
import studies_page
import verify
import results  # after verify, which knows where it is

pytestmark = pytest.mark.fast

DOCUMENT = "# Title\n\nBefore.\n\n<!-- bars.pull: written by make verify -->\nold\n<!-- end -->\n\nAfter.\n"


def study(limit=0.01):
    """A study with a reached figure, one that falls short, one without a goal, a table and a plot."""
    made = verify.Study("bars.pull", "Bars <pulled>", "Text.")
    with contextlib.redirect_stdout(io.StringIO()):
        made.expect("load | error", 0.004, at_most=limit)
        made.expect("stress error", 0.2, at_most=0.1)
        made.figure("seconds", 12.5, "s")
        made.expect.that("unit: part", True, "residual: 1e-14 (<= 1e-12)")
        made.expect.that("points kept", True)
    made.table("Numbers", ["n", "error"], [[16, "1e-3"], [32, "2e-4"]])
    sizes = [0.25, 0.5, 1.0]
    made.plot("Errors", "cell size (m)", "error (m)", studies_page.curve("seen", sizes, [0.1, 0.4, float("nan")], "points"),
              studies_page.slope(2, sizes, 0.1), log=True, caption="A caption.")
    return {**made.result(), "runs": ["bin/mlgimp -cell_size 1"]}


class Studies(unittest.TestCase):
    def test_rows_have_figure_and_goal(self):
        rows = [(line["name"], line["seen"], line["goal"], line["good"]) for line in study()["rows"]]
        self.assertEqual(rows, [("load | error", "0.004", "<= 0.01", True), ("stress error", "0.2", "<= 0.1", False),
                                ("seconds", "12.5 s", "", True), ("unit: part: residual", "1e-14", "<= 1e-12", True),
                                ("points kept", "yes", "yes", True)])
        self.assertEqual([line["name"] for line in studies_page.falls_short([study()])], ["stress error"])

    def test_curves_are_finite_and_thin(self):
        self.assertEqual(studies_page.curve("", [1, 2, 3], [1, float("inf"), 2])["x"], [1, 3])
        long = studies_page.curve("", range(5000), range(5000))["x"]
        self.assertLessEqual(len(long), studies_page.MOST_POINTS)
        self.assertEqual((long[0], long[-1]), (0, 4999))

    def test_choice_of_studies(self):
        names = ["a.wedge", "a.wedge_axis", "b.bar"]
        self.assertEqual(verify.choose(names, []), names)
        self.assertEqual(verify.choose(names, ["a.wedge"]), ["a.wedge"])
        self.assertEqual(verify.choose(names, ["wedge"]), ["a.wedge", "a.wedge_axis"])


class Page(unittest.TestCase):
    text = studies_page.page("Made up", ["An <introduction>."], [study()])

    def test_all_is_there(self):
        for words in ("Bars &lt;pulled&gt;", "load | error", "≤ 0.01", "falls short", "3 of 4 figures with a goal reach it; 1 fall short",
                      "bin/mlgimp -cell_size 1", "A caption.", "An &lt;introduction&gt;.", "2e-4"):
            self.assertIn(words, self.text)
        self.assertEqual(self.text.count("<img"), 1)

    def test_nothing_is_fetched(self):
        self.assertNotRegex(self.text, r'(src|href)="(?!data:|#)')
        self.assertNotRegex(self.text, r"<script|<link|@import|url\(")


class Document(unittest.TestCase):
    filled = report_markdown.fill_in(DOCUMENT, [study()])

    def test_only_what_is_between_the_marks_changes(self):
        self.assertRegex(self.filled, re.compile(r"^# Title\n\nBefore\.\n\n<!--.*load \\\| error \| 0\.004 \| <= 0\.01 .*<!-- end -->\n\nAfter\.\n$", re.S))
        self.assertNotIn("old", self.filled)
        self.assertIn("| 16 | 1e-3 |", self.filled)

    def test_differences(self):
        self.assertEqual(report_markdown.differences(self.filled, [study()]), [])
        self.assertEqual(report_markdown.differences(self.filled.replace("0.004", "0.005"), [study()]), [])
        self.assertEqual(report_markdown.differences(self.filled, [study(limit=0.02)]),
                         ["bars.pull lacks: load | error (<= 0.02)", "bars.pull still has: load | error (<= 0.01)"])
        self.assertEqual(report_markdown.differences("# Empty\n", [study()]), ["bars.pull has no place"])

    def test_every_study_has_its_place(self):
        """The committed document and the verification book know the studies of tests/cases, each one of the two, and no others."""
        marks = re.findall(r"<!-- (\S+): written by make verify -->", verify.DOCUMENT.read_text())
        self.assertEqual(sorted(marks + results.STUDIES), sorted(verify.collect()))
