"""The book: every page is in a table of contents, the gallery has what its pages show, and Sphinx builds it without a warning."""
import html
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from harness import ROOT

sys.path.append(str(ROOT / "docs" / "book"))
import results
from cases import CASES

GALLERY = ROOT / "docs" / "images" / "gallery"
LARGEST = 40000  # bytes of a picture
NEEDS = ("sphinx", "myst_parser", "furo", "sphinx_copybutton")
KATEX = Path("/usr/share/javascript/katex/katex.min.js")
FORMULAS = "# Formulas\n\nIn a line $\\sigma_{yy} < 0$, and by itself\n\n$$v_i = \\frac{p_i}{m_i}, \\quad \\sum_i S_{ip} = 1$$\n"
# Draws the formulas that come as JSON, [[text, whether displayed], ...]; prints those that KaTeX cannot draw.
DRAW = """const katex = require(process.argv[1]);
for (const [text, displayMode] of JSON.parse(require("fs").readFileSync(0, "utf8"))) {
  try { katex.renderToString(text, { displayMode }); } catch (error) { console.log(text + ": " + error.message); }
}"""


def in_contents(page):
    """The pages in the tables of contents of a page, as paths."""
    tables = re.findall(r"^```\{toctree\}\n(.*?)^```$", page.read_text(), re.M | re.S)
    entries = [line for table in tables for line in table.splitlines() if line and not line.startswith(":")]
    return {(page.parent / (re.sub(r".*<(.*)>", r"\1", entry) + ".md")).resolve() for entry in entries}


def build(source, target):
    """Builds the book from a folder with docs/index.md and returns its folder."""
    for module in NEEDS:
        pytest.importorskip(module, reason=f"this Python has no {module}, which `make docs` installs")
    if not KATEX.exists():
        pytest.skip(f"{KATEX} is not there; `make docs` installs it")
    done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-E", "-n", "-W", "--keep-going", "-c", ROOT / "docs", "-d", target / "trees",
                           source, target / "book"], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    return target / "book"


def formulas_of(book):
    """The formulas of a book as (text, whether displayed)."""
    found = [each for page in book.rglob("*.html") for each in re.findall(r'<(div|span) class="math"[^>]*>(.*?)</\1>', page.read_text(), re.S)]
    return [(html.unescape(text), kind == "div") for kind, text in found]


def assert_drawn(formulas):
    """KaTeX draws the formulas; skips where there is no node."""
    if not shutil.which("node"):
        pytest.skip("there is no node to draw formulas with")
    done = subprocess.run(["node", "-e", DRAW, KATEX], input=json.dumps(formulas), capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.returncode) == ("", 0)


@pytest.mark.fast
def test_every_page_is_in_a_table_of_contents():
    front = ROOT / "docs" / "index.md"
    pages = {ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")} | set((ROOT / "docs").glob("*.md")) - {front}
    assert in_contents(front) - {ROOT / "docs" / folder / "index.md" for folder in ("gallery", "results")} == pages


@pytest.mark.fast
def test_the_gallery_has_its_pictures_and_numbers():
    pictures = {f"{case.name}_{name}.png" for case in CASES for name in ("case", *(name for name, _ in case.pictures))}
    assert {path.name for path in GALLERY.glob("*.png")} == pictures
    assert [path.name for path in GALLERY.glob("*.png") if path.stat().st_size > LARGEST] == []
    assert list(json.loads((GALLERY / "numbers.json").read_text())) == [case.name for case in CASES]
    assert all((ROOT / "options" / f"{case.name}.opts").exists() for case in CASES)


def test_the_book_builds_without_warnings(tmp_path):
    book = build(ROOT, tmp_path)
    assert (book / "index.html").exists()
    for page in ("README", "CONTRIBUTING", "CHANGELOG", "docs/index", "docs/method", *(f"docs/gallery/{case.name}" for case in CASES),
                 "docs/results/index", *(f"docs/results/{page.name}" for page in results.PAGES)):
        text = (book / f"{page}.html").read_text()
        loaded = re.findall(r'<(?:script|link|img)[^>]* (?:src|href)="([^"]+)"', text)
        assert loaded and not [each for each in loaded if each.startswith(("http:", "https:", "//"))], page
    assert_drawn(formulas_of(book))


def test_formulas_are_drawn_without_a_network(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text(FORMULAS)
    book = build(tmp_path, tmp_path)
    page, static = (book / "docs" / "index.html").read_text(), book / "_static"
    for name in ("katex/katex.min.js", "katex/katex.min.css", "formulas.js"):
        assert f"../_static/{name}" in page and (static / name).is_file(), name
    fonts = re.findall(r"url\((fonts/[\w-]+\.woff2)\)", (static / "katex" / "katex.min.css").read_text())
    assert fonts and all((static / "katex" / font).is_file() for font in fonts)
    assert formulas_of(book) == [(r"\sigma_{yy} < 0", False), (r"v_i = \frac{p_i}{m_i}, \quad \sum_i S_{ip} = 1", True)]
    assert_drawn(formulas_of(book))
