#!/usr/bin/env python3
"""Runs the cases of the gallery one after the other and draws the pictures of their pages, into docs/images/gallery/, with points,
steps and seconds of each run in numbers.json there. Results go to output/gallery/.

    scripts/gallery.py                       all cases of docs/book/cases.py: two minutes
    scripts/gallery.py film scratch          only these
    scripts/gallery.py --draw-only film      draws results that are there anew
"""

import argparse
import io
import json
import resource
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
from command import ROOT, Parser, command

sys.path.insert(0, str(ROOT / "docs" / "book"))
from cases import CASES
from PIL import Image

from mlgimp import case_picture, gallery, pictures, program, results
from mlgimp.errors import Error

RESULTS, PICTURES = ROOT / "output" / "gallery", ROOT / "docs" / "images" / "gallery"
NUMBERS = PICTURES / "numbers.json"
COLOURS, SMALLER = 256, 2  # of a picture; and by how much it is smaller than those of scripts/plot.py
LARGEST = 40000  # bytes


def save_small(figure, path):
    """Saves a figure as a small PNG: half as many dots as other pictures have, and few colours."""
    whole = io.BytesIO()
    pictures.save(figure, whole)
    image = Image.open(whole).convert("RGB")
    image = image.resize((image.width // SMALLER, image.height // SMALLER), Image.Resampling.LANCZOS)
    image.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        raise Error(f"{path}: must have at most {LARGEST} bytes, it has {path.stat().st_size}")
    print(path.relative_to(ROOT))


def run(case):
    """Runs a case on one core and returns the seconds of that core; other programs on the machine hardly change these."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    program.execute({"options_file": ROOT / "options" / f"{case.name}.opts", "output_dir": RESULTS / case.name, "overwrite": None},
                    tell=print)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def numbers_of(folder, seconds):
    """Returns what the page of a case says of its run: points at the start, steps of the coarsest and the finest level, seconds."""
    levels = results.read_summary(folder)["levels"]
    points = int(results.read_history(folder)["points"][0])
    return {"points": points, "steps": [levels[0]["steps"], levels[-1]["steps"]], "seconds": float(f"{seconds:.2g}")}


def draw(case):
    """Draws the pictures of a case: the case before it runs, and those of its result."""
    folder = RESULTS / case.name
    save_small(case_picture.case(folder), PICTURES / f"{case.name}_case.png")
    for name, window in case.pictures:
        save_small(gallery.gallery(folder, None, window)[name](), PICTURES / f"{case.name}_{name}.png")


@command
def main(arguments=None):
    """Runs and draws the cases that the command line names, by default all."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="CASE", help="names in options/, without .opts (default: all of the gallery)")
    parser.add_argument("--draw-only", action="store_true", help="run nothing, draw the results in output/gallery/")
    options = parser.parse_args(arguments)
    unknown = set(options.names) - {case.name for case in CASES}
    if unknown:
        raise Error(f"{', '.join(sorted(unknown))}: must be in the gallery, as {', '.join(case.name for case in CASES)}")
    pictures.make_folder(PICTURES)
    numbers = json.loads(NUMBERS.read_text()) if NUMBERS.exists() else {}
    for case in CASES:
        if options.names and case.name not in options.names:
            continue
        if not options.draw_only:
            numbers[case.name] = numbers_of(RESULTS / case.name, run(case))
        draw(case)
        in_order = {each.name: numbers[each.name] for each in CASES if each.name in numbers}
        NUMBERS.write_text("{\n" + ",\n".join(f'  "{name}": {json.dumps(row)}' for name, row in in_order.items()) + "\n}\n")


if __name__ == "__main__":
    main()
