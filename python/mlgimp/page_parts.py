"""The parts of a page that needs no other file: texts, tables, pictures and data, in the style of page.css."""

import base64
import html
import io
import json
import platform
from datetime import datetime
from pathlib import Path

import numpy as np
import scipy

from .errors import ResultError

HERE = Path(__file__).parent


def document(title, parts, script=""):
    """Returns the text of a page of parts, texts in HTML; script: the name of a file of this package that runs at its end."""
    code = [f"<script>{(HERE / script).read_text(encoding='utf-8')}</script>"] if script else []
    return "\n".join(["<!DOCTYPE html>", '<html lang="en">', "<head>", '<meta charset="utf-8">',
                      '<meta name="viewport" content="width=device-width, initial-scale=1">', f"<title>{html.escape(title)}</title>",
                      f"<style>{(HERE / 'page.css').read_text(encoding='utf-8')}</style>", "</head>", "<body>", f"<h1>{html.escape(title)}</h1>",
                      *parts, *code, "</body>", "</html>", ""])


def table(head, rows, numbers=()):
    """Returns a table of texts; numbers: places of the columns that are aligned at their right ends."""
    def cells(kind, row):
        return "".join(f'<{kind} class="number">{html.escape(str(text))}</{kind}>' if place in numbers else f"<{kind}>{html.escape(str(text))}</{kind}>"
                       for place, text in enumerate(row))
    lines = ["<table>"] + [f"<tr>{cells('th', head)}</tr>"] * bool(head)
    return "\n".join([*lines, *(f"<tr>{cells('td', row)}</tr>" for row in rows), "</table>"])


def paragraphs(lines, kind=""):
    """Returns paragraphs of texts, a list; kind: their class in page.css."""
    mark = f' class="{kind}"' if kind else ""
    return [f"<p{mark}>{html.escape(line)}</p>" for line in lines]


def bullets(lines):
    """Returns a list of texts with bullets, a list of parts; an empty one of none."""
    return ["<ul>", *(f"<li>{html.escape(line)}</li>" for line in lines), "</ul>"] if lines else []


def folded(title, part):
    """Returns a part that opens under a title, as a list of parts."""
    return ["<details>", f"<summary>{html.escape(title)}</summary>", part, "</details>"]


def image(data, kind, words):
    """Returns a picture of bytes, of a kind as png or svg+xml; words: what stands in its place where it cannot be seen."""
    return f'<img alt="{html.escape(words)}" src="data:image/{kind};base64,{base64.b64encode(data).decode()}">'


def drawing(figure, words):
    """Returns a matplotlib Figure as a picture of lines, and closes it."""
    from matplotlib import pyplot as plt  # pages without pictures need no matplotlib
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    plt.close(figure)
    return image(text.getvalue().encode(), "svg+xml", words)


def data(name, values):
    """Returns values as JSON for a script of the page, which finds them by their name."""
    return f'<script type="application/json" id="{name}">{json.dumps(values, separators=(",", ":")).replace("<", chr(92) + "u003c")}</script>'


def how_made(command=""):
    """Returns the parts about date, versions and the command that made the page."""
    versions = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    parts = ["<h2>How it was made</h2>", f"<p>{datetime.now():%Y-%m-%d %H:%M}, {html.escape(versions)}.</p>"]
    return parts + [f"<p><code>{html.escape(command)}</code></p>"] * bool(command)


def write(path, text):
    """Writes the text of a page to a file."""
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as problem:
        raise ResultError(path, f"cannot be written ({problem.strerror})") from None
