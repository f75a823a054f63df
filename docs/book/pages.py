"""Pages of the book that are written when it is built: those of the gallery, from cases.py and the numbers of scripts/gallery.py, into
docs/gallery/, and those of the verification book, from results.py and what studies found, into docs/results/. It also gives some pages
all the room, and the page of options on one sheet its style."""

import json
from pathlib import Path

import results
from cases import CASES

DOCS = Path(__file__).resolve().parents[1]
PICTURES = DOCS / "images" / "gallery"
SHEET, FRONT, RESULTS = "docs/cheat_sheet", "docs/index", "docs/results/index"

PAGE = """# {title}

{shows}

![The case: bodies, sides of the domain, boxes of levels](../images/gallery/{name}_case.png)

{points} points, {steps}: {seconds} seconds on one core.

```console
$ bin/mlgimp -options_file options/{name}.opts
$ /usr/bin/python3 scripts/plot.py output/{name}
```

{look}

{pictures}

## The options file

```{{literalinclude}} ../../options/{name}.opts
:language: opts
```
"""

OVERVIEW = """# Gallery of runs

Cases of `options/`, each with a picture before it runs, its command, its options file, its result, and how long it takes on one
core.

| | |
| --- | --- |
{rows}

```{{toctree}}
:hidden:

{names}
```
"""


def in_words(steps):
    """Returns what a page says of the steps of the coarsest and the finest level."""
    coarsest, finest = (f"{count:,}".replace(",", " ") for count in steps)
    return f"{coarsest} steps" if coarsest == finest else f"{coarsest} steps of the coarsest level and {finest} of the finest"


def page_of(case, numbers):
    """Returns the page of a case; numbers: its points, steps and seconds."""
    pictures = "\n\n".join(f"![{case.title}: {name.replace('_', ' ')}](../images/gallery/{case.name}_{name}.png)"
                           for name, _ in case.pictures)
    return PAGE.format(name=case.name, title=case.title, shows=case.shows, look=case.look, pictures=pictures,
                       points=f"{numbers['points']:,}".replace(",", " "), steps=in_words(numbers["steps"]),
                       seconds=f"{numbers['seconds']:g}")


def overview():
    """Returns the page that shows all cases, two in a row."""
    cells = [f"[![{case.title}](../images/gallery/{case.name}_{case.pictures[0][0]}.png)]({case.name}.md) "
             f"[{case.title}]({case.name}.md)" for case in CASES] + [""] * (len(CASES) % 2)
    rows = "\n".join(f"| {left} | {right} |" for left, right in zip(cells[::2], cells[1::2]))
    return OVERVIEW.format(rows=rows, names="\n".join(case.name for case in CASES))


def write_pages(app):
    """Writes the pages of the gallery and of the verification book."""
    numbers = json.loads((PICTURES / "numbers.json").read_text())
    write(DOCS / "gallery", {"index": overview(), **{case.name: page_of(case, numbers[case.name]) for case in CASES}})
    write(DOCS / "results", results.texts())


def write(folder, pages):
    """Writes pages {name: text} where they are not what they should be, so that Sphinx reads only what has changed, and no others."""
    folder.mkdir(exist_ok=True)
    for path in folder.glob("*.md"):
        if path.stem not in pages:
            path.unlink()
    for name, page in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text() != page:
            path.write_text(page)


def style_page(app, page, template, context, document):
    """Hides the contents of some pages, which are at the right of others, and gives the page of options its narrow columns."""
    if page in (SHEET, FRONT, RESULTS):
        context["meta"] = {**(context["meta"] or {}), "hide-toc": ""}
    if page == SHEET:
        app.add_css_file("cheat_sheet.css")


def setup(app):
    """Writes pages before Sphinx looks for them."""
    app.connect("builder-inited", write_pages)
    app.connect("html-page-context", style_page, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
