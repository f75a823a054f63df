"""The verification book: its chapters, where the figures of its pages are, and how the pages are written."""

import json
from pathlib import Path

import results_elastic
import results_inelastic
import results_motion
from result_page import front_of, text_of

FOUND = Path(__file__).resolve().parents[1] / "images" / "results"  # NAME.json and NAME.png of each page

CHAPTERS = {
    "Contact of elastic bodies": results_elastic.CONTACT,
    "Metals": results_inelastic.METALS,
    "Impact and rings": results_inelastic.IMPACT,
    "Creep and relaxation": results_inelastic.TIME,
    "Bodies without an indenter": results_elastic.FREE,
    "Order of convergence": results_motion.ORDER,
    "Waves and vibration": results_motion.WAVES,
    "The paper's figures, and levels": results_motion.FIGURES,
}
PAGES = [page for chapter in CHAPTERS.values() for page in chapter]
STUDIES = sorted({study for page in PAGES for study, _ in page.parts})  # those whose rows are in the book


def read(page):
    """Returns what is known of a page, its JSON file."""
    return json.loads((FOUND / f"{page.name}.json").read_text())


def texts():
    """Returns the pages as Markdown by their names, the front page as index."""
    found = {page.name: read(page) for page in PAGES}
    return {"index": front_of(CHAPTERS, found), **{page.name: text_of(page, found[page.name]) for page in PAGES}}
