"""How Sphinx builds the book from the Markdown of the project, see `make docs`; the source folder is that of the project."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "book"))

project = author = "mlgimp"
html_title = "mlgimp 0.2"
extensions = ["myst_parser", "sphinx_copybutton", "offline", "options_files", "pages"]

root_doc = "docs/index"
include_patterns = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**.md"]
exclude_patterns = ["bin", "build", "output", "docs/paper"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4

html_theme = "furo"
html_static_path = ["book/static"]
html_css_files = ["book.css"]
html_extra_path = ["book/root"]  # index.html, which leads to the front page
html_show_copyright = False
html_copy_source = False
copybutton_prompt_text = "$ "  # a console block is copied without its prompts and without what commands print
