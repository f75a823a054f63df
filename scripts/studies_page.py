"""Writes one self-contained HTML page about a list of studies: a table of all figures, then each study's plots and tables.

A study is a dict, as tests/verify.py stores it: name, title, text, command, seconds, date, runs (command lines of the
program), rows, tables and plots. The functions below make the parts.
"""

import base64
import html
import io
import itertools
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import pictures

import numpy as np

MOST_POINTS = 300  # of a curve; more are thinned out
MARKERS = "os^Dv*PX"
STYLES = {"line": {}, "points": {"markersize": 5}, "dots": {"linestyle": "none", "marker": "o", "markersize": 3.5},
          "reference": {"color": "black", "linestyle": ":"}, "guide": {"color": "0.55", "linestyle": "-", "linewidth": 1.2},
          "slope": {"color": "0.6", "linestyle": "-", "linewidth": 0.9}}


def row(name, seen, goal, good, command):
    """A figure, its goal as text ('' where it has none), whether it is reached, and the command that shows it."""
    return {"name": name, "seen": seen, "goal": goal, "good": bool(good), "command": command}


def table(title, header, cells):
    """A table of texts, shown as it is."""
    return {"title": title, "header": [str(cell) for cell in header], "cells": [[str(cell) for cell in line] for line in cells]}


def curve(label, x, y, kind="line"):
    """A curve of a plot; kind is one of STYLES: reference is for exact solutions and finite elements, guide for
    what helps the eye, slope is labelled at its end. A label that begins with _ is not shown."""
    x, y = np.array(list(x), float), np.array(list(y), float)
    if len(x) > MOST_POINTS:
        kept = np.unique(np.linspace(0, len(x) - 1, MOST_POINTS).round().astype(int))
        x, y = x[kept], y[kept]
    finite = np.isfinite(x) & np.isfinite(y)
    return {"label": label, "x": x[finite].tolist(), "y": y[finite].tolist(), "kind": kind}


def slope(order, x, y):
    """A guide of a given order that starts at the first place x and height y; x are the places of a log-log plot."""
    x = np.asarray(x, float)
    return curve(f"_order {order:g}", x, y * (x / x[0]) ** order, "slope")


def figure(title, xlabel, ylabel, curves, log=False, caption=""):
    """A plot; axes carry their units in the labels. log: whether both axes are logarithmic; "x": that one alone."""
    return {"title": title, "xlabel": xlabel, "ylabel": ylabel, "curves": list(curves), "log": log, "caption": caption}


def falls_short(studies):
    """Rows of the studies that do not reach their goals."""
    return [line for study in studies for line in study["rows"] if not line["good"]]


# ---- drawing ----

@pictures.styled
def draw(drawing):
    """A plot as an SVG picture in a data URL."""
    canvas, axes = pictures.plt.subplots(figsize=(6.4, 4.4))
    draw_on(axes, drawing)
    text = io.StringIO()
    canvas.savefig(text, format="svg", metadata={"Date": None})
    pictures.plt.close(canvas)
    return "data:image/svg+xml;base64," + base64.b64encode(text.getvalue().encode()).decode()


def draw_on(axes, drawing):
    """Draws a plot on axes."""
    for each, marker in zip(drawing["curves"], itertools.cycle(MARKERS)):
        style = {"marker": marker} if each["kind"] == "points" else {}
        axes.plot(each["x"], each["y"], label=each["label"], **STYLES[each["kind"]], **style)
        if each["kind"] == "slope":
            axes.annotate(each["label"][1:], (each["x"][-1], each["y"][-1]), (5, 0), textcoords="offset points", va="center",
                          color="0.4", size=10)
    pictures.line_axes(axes, drawing["xlabel"], drawing["ylabel"])
    if drawing["log"]:
        axes.set(xscale="log")
    if drawing["log"] is True:
        axes.set(yscale="log")
        log_ticks(axes, drawing["curves"])
    labels = [each["label"] for each in drawing["curves"] if not each["label"].startswith("_")]
    if len(drawing["curves"]) > 1:
        widest = max(map(len, labels))
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=1 if widest > 34 else 2 if widest > 16 else 3)


def log_ticks(axes, curves):
    """Ticks along x at the places of the first curve, where these are few (cell sizes, wavelengths); enough of them along y."""
    places = curves[0]["x"]
    if len(places) <= 8:
        axes.set_xticks(places, [f"{place:g}" if place >= 1 else f"1/{1 / place:.3g}" for place in places])
        axes.xaxis.set_minor_locator(pictures.plt.NullLocator())
    heights = [y for each in curves for y in each["y"]]
    if heights and max(heights) < 100 * min(heights):
        axes.yaxis.set_major_locator(pictures.plt.LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_locator(pictures.plt.NullLocator())


# ---- the page ----

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1b1b1b; background: #fff; margin: 0 auto; padding: 1rem; max-width: 1280px; }
h1 { font-size: 1.6rem; margin: 0.5rem 0; }
h2 { font-size: 1.25rem; margin: 2.5rem 0 0.3rem; padding-top: 0.6rem; border-top: 1px solid #ccc; }
h3 { font-size: 1rem; margin: 1.2rem 0 0.3rem; }
p { margin: 0.3rem 0 0.8rem; max-width: 75ch; }
a { color: #0060a0; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.9rem; }
.figures { width: 100%; table-layout: fixed; }
.figures th { width: 13%; }
.figures th:first-child { width: 40%; }
.figures th:last-child { width: 22%; }
th, td { text-align: left; vertical-align: top; padding: 0.2rem 0.9rem 0.2rem 0; border-bottom: 1px solid #e4e4e4; }
th { border-bottom: 2px solid #999; }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
tr.group td { font-weight: 600; padding-top: 0.9rem; border-bottom: 1px solid #999; }
.short td { background: #fdeee4; }
.verdict { white-space: nowrap; }
.short .verdict { color: #a83200; font-weight: 600; }
code, pre { font: 0.82rem/1.45 ui-monospace, monospace; }
code { overflow-wrap: anywhere; }
pre { overflow-x: auto; background: #f5f5f5; padding: 0.6rem; margin: 0.4rem 0; }
.plots { display: grid; gap: 1.4rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 470px), 1fr)); }
figure { margin: 0; min-width: 0; }
figure img { width: 100%; max-width: 640px; height: auto; display: block; }
figcaption { font-size: 0.9rem; max-width: 64ch; }
figcaption b { display: block; }
@media (max-width: 700px) {
  .figures thead { display: none; }
  .figures tr { display: block; padding: 0.4rem 0; border-bottom: 1px solid #e4e4e4; }
  .figures td { display: inline-block; border: 0; padding: 0 0.3rem; }
  .figures td:first-child, .figures td:last-child { display: block; }
  .figures td[data-label]::before { content: attr(data-label) ": "; color: #666; }
}
"""


def page(title, introduction, studies):
    """The whole page as text; the introduction is a list of paragraphs."""
    rows = [line for study in studies for line in study["rows"]]
    with_goal = [line for line in rows if line["goal"] or not line["good"]]
    missed = falls_short(studies)
    verdict = f"{len(with_goal) - len(missed)} of {len(with_goal)} figures with a goal reach it" + (f"; {len(missed)} fall short." if missed else ".")
    parts = ["<!DOCTYPE html>", '<html lang="en"><head><meta charset="utf-8">',
             '<meta name="viewport" content="width=device-width, initial-scale=1">',
             f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>", f"<h1>{escape(title)}</h1>"]
    parts += [f"<p>{escape(paragraph)}</p>" for paragraph in introduction]
    parts += [f"<p><b>{verdict}</b></p>", figures_table(studies)]
    parts += [section(study) for study in studies]
    return "\n".join(parts + ["</body></html>"]) + "\n"


def escape(text):
    return html.escape(text)


def limits(goal):
    """A goal with the signs of print."""
    return escape(goal.replace("<=", "≤").replace(">=", "≥").replace("+-", "±") or "–")


def figures_table(studies):
    """The table at the top: all rows, grouped by study."""
    lines = ['<div class="scroll"><table class="figures"><thead><tr><th>figure</th><th>seen</th><th>goal</th><th>verdict</th><th>command</th></tr></thead><tbody>']
    for study in studies:
        if not study["rows"]:
            continue
        lines.append(f'<tr class="group"><td colspan="5"><a href="#{escape(study["name"])}">{escape(study["title"])}</a></td></tr>')
        for line in study["rows"]:
            verdict = ("reached" if line["goal"] else "") if line["good"] else "falls short"
            lines.append(f'<tr{"" if line["good"] else " class=short"}><td>{escape(line["name"])}</td>'
                         f'<td{"" if len(line["seen"]) > 16 else " class=number"} data-label="seen">{escape(line["seen"])}</td>'
                         f'<td class="number" data-label="goal">{limits(line["goal"])}</td>'
                         f'<td class="verdict">{verdict}</td><td><code>{escape(line["command"])}</code></td></tr>')
    return "\n".join(lines + ["</tbody></table></div>"])


def section(study):
    """A study: its text, plots, tables and the command lines of the program that it ran."""
    parts = [f'<h2 id="{escape(study["name"])}">{escape(study["title"])}</h2>']
    parts += [f"<p>{escape(study['text'])}</p>"] if study["text"] else []
    if study["plots"]:
        parts += ['<div class="plots">', *map(picture, study["plots"]), "</div>"]
    parts += map(plain_table, study["tables"])
    parts.append(f'<p><code>{escape(study["command"])}</code>: {duration(study["seconds"])}, {escape(study["date"])}</p>')
    if study["runs"]:
        lines = "\n".join(escape(line) for line in study["runs"])
        parts.append(f"<details><summary>runs of the program ({len(study['runs'])})</summary><pre>{lines}</pre></details>")
    return "\n".join(parts)


def picture(drawing):
    caption = f" {escape(drawing['caption'])}" if drawing["caption"] else ""
    return (f'<figure><figcaption><b>{escape(drawing["title"])}</b>{caption}</figcaption>'
            f'<img alt="{escape(drawing["title"])}" src="{draw(drawing)}"></figure>')


def plain_table(content):
    header = "".join(f"<th>{escape(cell)}</th>" for cell in content["header"])
    body = "\n".join("<tr>" + "".join(f'<td class="number">{escape(cell)}</td>' for cell in line) + "</tr>" for line in content["cells"])
    return (f'<h3>{escape(content["title"])}</h3><div class="scroll"><table><thead><tr>{header}</tr></thead>'
            f"<tbody>{body}</tbody></table></div>")


def duration(seconds):
    """A time as text: 42 s, or 3 min."""
    return f"{seconds:.0f} s" if seconds < 100 else f"{math.ceil(seconds / 60)} min"
