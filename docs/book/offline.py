"""Copies into the book what its pages would load from elsewhere, so that they need no network and no web server: KaTeX, which draws
formulas in the reader's browser, and normalize.css, which Debian's furo looks for at the root of a server."""

import shutil
from pathlib import Path

from docutils import nodes
from sphinx.errors import ConfigError

SHARED = Path("/usr/share/javascript")  # of Debian's packages
KATEX = "katex/katex.min.js", "katex/katex.min.css", "katex/fonts/*.woff2"
NORMALIZE = "normalize.css/normalize.css"


def visit_formula(translator, node):
    """Writes a formula within a line as it is in the source; formulas.js draws it."""
    translator.body.append(translator.starttag(node, "span", "", CLASS="math") + translator.encode(node.astext()) + "</span>")
    raise nodes.SkipNode


def visit_displayed_formula(translator, node):
    """Writes a formula with lines of its own."""
    translator.body.append(translator.starttag(node, "div", "", CLASS="math") + translator.encode(node.astext()) + "</div>\n")
    raise nodes.SkipNode


def add_katex(app, page, template, context, document):
    """Lets a page with formulas load KaTeX."""
    if app.env.get_domain("math").has_equations(page):
        app.add_css_file("katex/katex.min.css")
        app.add_js_file("katex/katex.min.js")
        app.add_js_file("formulas.js")


def copy_files(app, problem):
    """Copies the files into the book once its pages are written."""
    if problem or app.builder.format != "html":
        return
    for pattern in (*KATEX, NORMALIZE):
        for path in SHARED.glob(pattern):
            target = Path(app.outdir) / "_static" / path.relative_to(SHARED)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


def setup(app):
    """Makes KaTeX what draws formulas."""
    absent = [pattern for pattern in KATEX if not any(SHARED.glob(pattern))]
    if absent:
        raise ConfigError(f"{SHARED / absent[0]} is not there: install libjs-katex and fonts-katex")
    app.add_html_math_renderer("katex", inline_renderers=(visit_formula, None), block_renderers=(visit_displayed_formula, None))
    app.config.html_math_renderer = "katex"
    if (SHARED / NORMALIZE).exists():
        app.add_css_file(NORMALIZE, priority=100)  # before the theme's
    app.connect("html-page-context", add_katex)
    app.connect("build-finished", copy_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
