"""The verification book: every page has its data and its picture, cheap pages are found again, and pages of made-up studies say what they must."""
import contextlib
import io
import re

import pytest

import book  # which knows where the pages are
import harness
import result_page
import results
import sketches
import verify
from mlgimp import pictures
from mlgimp.errors import Error

LARGEST = 40000  # bytes of a picture
DATA = {page.name: results.read(page) for page in results.PAGES}


def row(name, seen, goal, good=True, **more):
    return {"name": name, "seen": seen, "goal": goal, "good": good, **more}


PAGE = result_page.Page("made_up", "Made up", "A problem.", ("A. Author (1900): A title.",), "Nothing was read.", (("bars.pull", "load"),), "1 %", "none")
ROWS = [row("load, of the exact one", "1.02", "1 +- 0.04", ours="3.06 N", theirs="3 N"), row("load | error", "0.05", "<= 0.04", False),
        row("load's order", "2.04", ">= 1.8"), row("loads", "7", ""), row("load left", "0.001", "0 +- 0.01")]
STUDY = {"name": "bars.pull", "title": "Bars", "seconds": 61.2, "date": "2026-01-02 03:04", "runs": ["bin/mlgimp -indenter_profile /a/b/p.txt -cfl 0.4"],
         "steps": 1200, "cells": 8.1, "rows": [*ROWS, row("other", "1", "")], "plots": [],
         "tables": [{"title": "Numbers", "header": ["n", "error"], "cells": [["16", "1e-3"]]}]}


# ---- the committed book ----

@pytest.mark.fast
@pytest.mark.parametrize("page", results.PAGES, ids=lambda page: page.name)
def test_page_has_its_data_and_picture(page):
    data = DATA[page.name]
    assert data["rows"] and all(result_page.number(line["seen"]) is not None or line["seen"] in ("yes", "no") for line in data["rows"])
    assert set(data["studies"]) == {name for name, _ in page.parts} <= set(verify.collect())
    picture = results.FOUND / f"{page.name}.png"
    assert 0 < picture.stat().st_size <= LARGEST
    assert not page.sketch or (harness.ROOT / "docs" / "images" / page.sketch).exists()
    assert all((harness.ROOT / "options" / f"{name}.opts").exists() for name in page.files)
    assert not any(" /" in line for line in data["runs"]), "a command line names a folder of a machine"
    assert not page.headline or any(re.search(page.headline, line["name"]) for line in result_page.with_goal(data["rows"]))


@pytest.mark.fast
def test_book_has_nothing_else():
    names = [page.name for page in results.PAGES]
    assert len(set(names)) == len(names)
    assert {path.name for path in results.FOUND.iterdir()} == {f"{name}.{kind}" for name in names for kind in ("json", "png")}


@pytest.mark.fast
def test_sketches_are_those_of_the_pages():
    names = {page.sketch.removeprefix("sketches/").removesuffix(".png") for page in results.PAGES if page.sketch.startswith("sketches/")}
    assert names == set(sketches.DRAWN) == {path.stem for path in sketches.SKETCHES.iterdir()}
    for name in sketches.DRAWN:
        figure = sketches.sketch(name)
        assert figure.axes[0].get_children()
        pictures.plt.close(figure)


@pytest.mark.fast
def test_studies_that_a_command_line_asks_for():
    studies = verify.collect()
    assert verify.select(studies, ["--report"]) == []
    assert verify.select(studies, ["--book", "cone_angles"]) == ["hardness.angle_50", "hardness.angle_60", "hardness.angle_80"]
    assert verify.select(studies, ["hardness.angle_50"]) == ["hardness.angle_50"]
    assert verify.select(studies, []) == list(studies)


@pytest.mark.fast
def test_a_value_beside_an_exact_one():
    study = verify.Study("bars.pull", "", "")
    with contextlib.redirect_stdout(io.StringIO()):
        study.compare("load", 3.06, 3, 0.04, "N")
        study.compare("radius", 1.2, 1, 0.1)
    assert [(line["name"], line["seen"], line["goal"], line["good"], line["ours"], line["theirs"]) for line in study.figures] == [
        ("load, of the exact one", "1.02", "1 +- 0.04", True, "3.06 N", "3 N"), ("radius, of the exact one", "1.2", "1 +- 0.1", False, "1.2", "1")]


@pytest.mark.fast
def test_verdicts_follow_from_figures_and_goals():
    """A row says that it is good where its figure is within its goal, to the digits that are shown."""
    for name, data in DATA.items():
        for line in data["rows"]:
            seen, aim, limit = result_page.number(line["seen"]), result_page.target(line), re.fullmatch(r"([<>])= (\S+)", line["goal"])
            if aim:
                good, nearly = abs(seen - aim[0]) <= aim[1], abs(abs(seen - aim[0]) - aim[1]) < 1e-3 * max(abs(seen), aim[1])
            elif limit:
                bound = float(limit[2])
                good, nearly = seen <= bound if limit[1] == "<" else seen >= bound, abs(seen - bound) <= 1e-3 * abs(bound)
            else:
                continue
            assert good == line["good"] or nearly, (name, line)


@pytest.mark.fast
def test_a_page_that_falls_short_says_why():
    for page in results.PAGES:
        assert page.notes or not result_page.missed(DATA[page.name]["rows"]), page.name


@pytest.mark.parametrize("name", ["elastic_ring", "expanding_ring", "lame"])
def test_cheap_pages_are_found_again(name):
    """Their studies, run here, have the figures of the book within half a per cent, and errors within 0.001, whatever the machine."""
    [page] = [each for each in results.PAGES if each.name == name]
    [(study_name, _)] = page.parts
    module, _, function = study_name.partition(".")
    study = verify.Study(study_name, "", "")
    with contextlib.redirect_stdout(io.StringIO()):
        getattr(__import__(module), f"verify_{function}")(study)
    assert not study.expect.missed
    committed = {line["name"]: result_page.number(line["seen"]) for line in DATA[name]["rows"]}
    found = {line["name"]: result_page.number(line["seen"]) for line in study.figures}
    assert found == pytest.approx(committed, rel=5e-3, abs=1e-3)


# ---- made-up pages ----

@pytest.mark.fast
def test_data_of_a_page():
    data = book.data_of(PAGE, {"bars.pull": STUDY})
    assert [line["name"] for line in data["rows"]] == [line["name"] for line in ROWS]
    assert data["runs"] == ["bin/mlgimp -indenter_profile p.txt -cfl 0.4"]
    assert (data["seconds"], data["steps"], data["cells"]) == (61.2, 1200, 8.1)
    assert data["studies"] == {"bars.pull": {"date": "2026-01-02 03:04"}}


@pytest.mark.fast
def test_text_of_a_page():
    text = result_page.text_of(PAGE, book.data_of(PAGE, {"bars.pull": STUDY}))
    for words in ("# Made up", "- A. Author (1900)", "| load, of the exact one | 3.06 N | 3 N | +2 % | ± 4 % | yes |",
                  "| load \\| error |  |  | 0.05 | ≤ 0.04 | **no** |",
                  "| load's order | 2.04 |  |  | ≥ 1.8 | yes |", "| load left |  |  | 0.001 | ± 0.01 | yes |",
                  "Cells: 8.1; steps: 1200; time: 61 s; date: 2026-01-02.",
                  "make verify BOOK=made_up", "## Numbers", "-indenter_profile p.txt"):
        assert words in text, words


@pytest.mark.fast
def test_front_page_says_what_falls_short():
    data = book.data_of(PAGE, {"bars.pull": STUDY})
    text = result_page.front_of({"Bars": [PAGE]}, {"made_up": data})
    for words in ("1 results, 4 values with a goal, 3 of which reach it. Values that fall short are in: [Made up](made_up.md).",
                  "| 1.02 | 1 % | none | 8.1 | 1200 |",
                  '<span class="short">1 of 4 fall short</span>'):
        assert words in text, words


@pytest.mark.fast
def test_headlines():
    assert result_page.headline(PAGE, ROWS[:1]) == "1.02"
    assert result_page.headline(PAGE, ROWS[1:3]) == "off by 0.05 at most"
    assert result_page.headline(PAGE, ROWS[2:3]) == "2.04 at least"
    assert result_page.headline(PAGE, [row("points kept", "yes", "yes")]) == "as expected"
    assert result_page.headline(PAGE, ROWS[3:4]) == "–"
    assert result_page.front_row(PAGE, book.data_of(PAGE, {"bars.pull": {**STUDY, "rows": ROWS[3:4]}}))[-1] == "no goals"


@pytest.mark.fast
def test_picture_of_rows():
    shown = [(line["name"], book.share(line)) for line in ROWS]
    assert shown == [("load, of the exact one", pytest.approx(0.5)), ("load | error", pytest.approx(1.25)), ("load's order", pytest.approx(1.8 / 2.04)),
                     ("loads", None), ("load left", pytest.approx(0.1))]
    axes = book.picture(PAGE, {"bars.pull": STUDY}, ROWS).axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == [line["name"] for line in ROWS if line["goal"]]


@pytest.mark.fast
def test_pages_by_words_and_rows_on_no_page():
    assert [page.name for page in book.pages_of(["hertz"])] == ["hertz_ball", "hertz_cylinder"]
    with pytest.raises(Error, match="must be part of a page's name"):
        book.pages_of(["no_such"])
    [line] = book.differences({"tips.sneddon": {"rows": [row("strange: load", "1", "")]}})
    assert line == "tips.sneddon: strange: load is on 0 pages of the book"


@pytest.mark.fast
def test_all_rows_of_the_book_are_on_one_page():
    """Those of the committed data, whose studies are in the book."""
    rows = {}
    for data in DATA.values():
        for study in data["studies"]:
            rows.setdefault(study, {"rows": []})
    for page in results.PAGES:
        for line in DATA[page.name]["rows"]:
            owners = [study for study, begin in page.parts if re.match(begin, line["name"])]
            rows[owners[0]]["rows"].append(line)
    assert book.differences(rows) == []
