"""A page of the verification book: one result, published or exact, and how the program does it; and the front page of them all.

What the studies of `make verify` found is in docs/images/results/NAME.json, which scripts/book.py writes."""

import re
from typing import NamedTuple

PAGE = """# {title}

{problem}

{sketch}## Source

{source}

{known}

## Ours against theirs

![{title}: ours against theirs](../images/results/{name}.png)

{rows}

Uncertainty: ours {ours}; theirs {theirs}.

{size}

{notes}{tables}## Run it

```console
$ make verify BOOK={name}
```

{options}
"""

FRONT = """# The verification book

Results that are published or exact, one page each: the problem and its source, the options that run it, ours against theirs, with the
uncertainty of both. *Cells* are the finest ones in half the contact's width, or across the body; *steps* those of the finest level
in the longest run; *time* that of all runs on one core, or on two where a run takes two ranks. A dash stands for what was not
recorded. `make verify` computes all of it anew, `make verify BOOK={example}` one page.

{verdict}

{chapters}
```{{toctree}}
:hidden:

{names}
```
"""


class Page(NamedTuple):
    """A result. `parts` says which rows are on its page: (study, beginning of their names) each, a name of a study being FILE.NAME of a
    function verify_NAME in tests/cases/FILE.py and a beginning a regular expression."""
    name: str
    title: str
    problem: str  # some sentences: what is pressed, pulled or thrown
    source: tuple  # references, with DOI where it is known
    known: str  # how their value comes here: by a formula of a file, by a table that was typed in, and what was read of the source
    parts: tuple
    ours: str  # uncertainty of ours
    theirs: str  # and of theirs
    cells: str = ""  # where the studies do not say it
    files: tuple = ()  # options files, names in options/ without the ending
    plot: str = ""  # beginning of the title of the study's plot that is shown; without it the rows are
    headline: str = ""  # which rows the front page sums up, a regular expression; without it all with a goal
    sketch: str = ""  # picture of the case, a file of docs/images
    notes: str = ""  # what falls short, by how much and why; what is to be known about the rows


# ---- rows ----

def number(text):
    """Returns the number that a text begins with, or None."""
    found = re.match(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", text.strip(), re.I)
    return float(found[0]) if found else None


def target(row):
    """Returns (middle, tolerance) of a row whose goal is `a +- b`, or None."""
    found = re.fullmatch(r"(\S+) \+- (\S+)", row["goal"])
    return (float(found[1]), float(found[2])) if found else None


def per_cent(share):
    """Returns a signed share as text in per cent."""
    return f"{100 * share:+.2g} %".replace("+0 %", "0 %")


def cells_of(row):
    """Returns what stands in the table about a row: value, ours, theirs, difference, goal, whether it is reached."""
    seen, goal = row["seen"], row["goal"].replace("<=", "≤").replace(">=", "≥").replace("+-", "±")
    reached = "**no**" if not row["good"] else "yes" if goal else "–"
    aim = target(row)
    if "theirs" in row:
        return [row["name"], row["ours"], row["theirs"], per_cent(number(seen) / aim[0] - 1), f"± {100 * aim[1] / aim[0]:.3g} %", reached]
    if aim and aim[0]:
        return [row["name"], seen, f"{aim[0]:g}", per_cent(number(seen) / aim[0] - 1), f"± {100 * aim[1] / aim[0]:.3g} %", reached]
    if aim:
        return [row["name"], "", "", seen, f"± {aim[1]:g}", reached]
    if goal.startswith("≤"):
        return [row["name"], "", "", seen, goal, reached]
    return [row["name"], seen, "", "", goal if goal != "yes" else "", reached]


def table(header, rows):
    """Returns a table of texts in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)


def with_goal(rows):
    """Returns the rows that have a goal, or fall short."""
    return [row for row in rows if row["goal"] or not row["good"]]


def missed(rows):
    """Returns the rows that do not reach their goals."""
    return [row for row in rows if not row["good"]]


def span(numbers):
    """Returns the least and the largest of some numbers as text, or the one that all are."""
    least, largest = f"{min(numbers):.4g}", f"{max(numbers):.4g}"
    return least if least == largest else f"{least} to {largest}"


def headline(page, rows):
    """Returns what the front page says of the rows: the span of ours over theirs, else the largest error, else the least of orders."""
    chosen = [row for row in with_goal(rows) if re.search(page.headline, row["name"])]
    ratios = [number(row["seen"]) / target(row)[0] for row in chosen if target(row) and target(row)[0] and number(row["seen"]) is not None]
    if ratios:
        return span(ratios)
    values = {sign: [number(row["seen"]) for row in chosen if row["goal"].startswith(sign) and number(row["seen"]) is not None] for sign in ("<=", ">=")}
    if values["<="]:
        return f"off by {max(values['<=']):.2g} at most"
    return f"{min(values['>=']):.3g} at least" if values[">="] else "as expected" if chosen else "–"


# ---- pages ----

def seconds_as_text(seconds):
    """Returns a time as text; a dash where it was not recorded."""
    return "–" if seconds is None else f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


def size(page, data):
    """Returns the paragraph about cells, steps, time and date."""
    parts = [f"{name}: {value}" for name, value in (("Cells", page.cells or data["cells"]), ("steps", data["steps"]))
             if value is not None]
    dates = sorted({each["date"][:10] for each in data["studies"].values()})
    return "; ".join([*parts, f"time: {seconds_as_text(data['seconds'])}", f"date: {', '.join(dates)}"]) + "."


def command_lines(data):
    """Returns the command lines of the first runs, folded."""
    if not data["runs"]:
        return ""
    lines = "\n\n".join(line.replace(" -", " \\\n    -") for line in data["runs"])
    return f"<details><summary>Command lines of its first runs</summary>\n\n```\n{lines}\n```\n\n</details>\n"


def options(page, data):
    """Returns what is said of the options: the files and the command lines."""
    studies = " and ".join(f"`verify_{study.partition('.')[2]}` of `tests/cases/{study.partition('.')[0]}.py`" for study in data["studies"])
    files = "".join(f"```console\n$ bin/mlgimp -options_file options/{name}.opts\n```\n\n" for name in page.files)
    return f"{files}The figures are those of {studies}.\n\n{command_lines(data)}"


def text_of(page, data):
    """Returns the page as Markdown; data: of its JSON file."""
    tables = "".join(f"## {each['title']}\n\n{table(each['header'], each['cells'])}\n\n" for each in data["tables"])
    sketch = f"![The case](../images/{page.sketch})\n\n" if page.sketch else ""
    rows = table(["value", "ours", "theirs", "difference", "goal", "reached"], map(cells_of, data["rows"]))
    return PAGE.format(name=page.name, title=page.title, problem=page.problem, sketch=sketch, source="\n".join(f"- {each}" for each in page.source),
                       known=page.known, rows=rows, ours=page.ours, theirs=page.theirs, size=size(page, data), tables=tables,
                       notes=f"{page.notes}\n\n" if page.notes else "", options=options(page, data))


def front_row(page, data):
    """Returns the line of a page in the table of its chapter."""
    goals, short = len(with_goal(data["rows"])), len(missed(data["rows"]))
    verdict = f'<span class="short">{short} of {goals} fall short</span>' if short else f'<span class="good">all {goals}</span>' if goals else "no goals"
    return [f"[{page.title}]({page.name}.md)", headline(page, data["rows"]), page.ours, page.theirs, page.cells or data["cells"] or "–",
            data["steps"] or "–", seconds_as_text(data["seconds"]), verdict]


def front_of(chapters, found):
    """Returns the front page; chapters: {title: pages}, found: {name: data}."""
    pages = [page for each in chapters.values() for page in each]
    short = [page for page in pages if missed(found[page.name]["rows"])]
    rows = [row for page in pages for row in with_goal(found[page.name]["rows"])]
    names = ", ".join(f"[{page.title}]({page.name}.md)" for page in short)
    verdict = (f"{len(pages)} results, {len(rows)} values with a goal, {len(rows) - len(missed(rows))} of which reach it."
               + (f" Values that fall short are in: {names}. Their pages say by how much and why." if short else ""))
    header = ["result", "ours over theirs", "uncertainty of ours", "of theirs", "cells", "steps", "time", "goals reached"]
    parts = [f"## {title}\n\n{table(header, [front_row(page, found[page.name]) for page in each])}\n" for title, each in chapters.items()]
    return FRONT.format(example=pages[0].name, verdict=verdict, chapters="\n".join(parts), names="\n".join(page.name for page in pages))
