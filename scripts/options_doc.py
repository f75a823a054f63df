#!/usr/bin/env python3
"""Writes docs/cheat_sheet.md and the tables of docs/options.md from `bin/mlgimp -help`, and docs/presets.md from `bin/mlgimp -presets`; the text around the
tables of options is kept.

The first table under each heading that is a group of -help is replaced; other tables and all notes are hand-written.
With --check nothing is written: the exit status is 1 where a page is not what it would be, and the first difference is shown.
"""
import argparse
import itertools
import os
import pathlib
import re
import subprocess
import sys
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / os.environ.get("MLGIMP_BIN", "bin") / "mlgimp"
PAGE = ROOT / "docs" / "options.md"
SHEET = ROOT / "docs" / "cheat_sheet.md"
PRESETS = ROOT / "docs" / "presets.md"
SHEET_BEGINS = """# Options on one page

What `bin/mlgimp -help` lists, in few words; [options.md](options.md) has it all, with notes. A unit
is in brackets, what holds by default is bold, and NAME is the name of a material, a body or a load.
`scripts/options_doc.py` writes this page.
"""
PRESETS_BEGIN = """# Materials and tips by name

`-NAME_preset aluminium_6061` gives a material all constants that are not given by hand, and `-indenter
berkovich_R50` a tip its shape; a run prints what it has got by them. `bin/mlgimp -presets` lists all;
`scripts/options_doc.py` writes this page. Behind +- stands the standard uncertainty. Where a source has
none it is how far published values lie apart: 2 % of a metal's modulus, 10 % of a flow stress, since
heats and tempers differ, 1 % of a crystal's constants. The values are quoted as they are in use: where
a result hangs on one, look it up in the source, or measure it.

From Python: `mlgimp.indent("copper_ofhc", tip="berkovich_R150", depth="200nm")`, and
`mlgimp.presets.materials()` and `mlgimp.presets.tips()` for the constants with their uncertainties. In
axisymmetry a pyramid is the cone with the same area at each depth.

Flow stresses are those of slow tests at room temperature, of Johnson and Cook's law `A + B eps^n`
without its rate and heat: `-NAME_hardening ludwik`. A law that is given by hand replaces that of the
preset, with the constants that belong to it.
"""
HEADER = ["| option | meaning | unit | default |", "| --- | --- | --- | --- |"]

# "  -name <now 1 : formerly 1>: meaning [unit] (None)", as PETSc prints an option; later versions have a colon behind the name.
OPTION = re.compile(r"  (-\w+):? <now (.*) : formerly \2>: (.*?)(?: \[([^\]]*)\])? \(None\)")
# A default that is not one value is said at the end of the meaning.
DEFAULT = re.compile(r"(.*) \(default: (.*)\)")


class Option(NamedTuple):
    name: str
    meaning: str
    unit: str
    default: str

    @classmethod
    def parse(cls, line):
        found = OPTION.fullmatch(line)
        if not found:
            return None
        name, default, meaning, unit = found.groups()
        if said := DEFAULT.fullmatch(meaning):
            meaning, default = said.groups()
        return cls(name, meaning, unit or "", default or "none")

    def row(self):
        return row_of([f"`{self.name}`", self.meaning, self.unit, self.default])

    def short_row(self):
        return row_of([f"`{self.name}`", re.sub(r"(?<!\w)-(?:NAME_)?[a-z]\w\w+", r"`\g<0>`", self.in_few_words())])

    def in_few_words(self):
        """The meaning up to its first semicolon, the choices, the unit, and the default in bold."""
        before, _, choices = self.meaning.rpartition(": ")
        choices, default = choices.split(", "), self.default.split(";")[0]
        if default in choices:
            return f"{before.split(';')[0]}: " + ", ".join(f"**{each}**" if each == default else each for each in choices)
        phrase = self.meaning.split(";")[0] + (f" [{self.unit}]" if self.unit else "")
        explained = re.search(rf"; {re.escape(default)} = ([^;]*)", self.meaning)
        return phrase if default == "none" else f"{phrase}, **{default}**" + (f" = {explained[1]}" if explained else "")


def row_of(cells):
    """A row of a table."""
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def groups(text):
    """{heading: [options]} of what -help prints; what stands in brackets after a heading is left out."""
    found, heading = {}, None
    for line in text.splitlines():
        if option := Option.parse(line):
            found.setdefault(heading, []).append(option)
        elif line.endswith(":") and not line.startswith((" ", "-")):
            heading = line[:-1].split(" (")[0]
    return found


def rewrite(page, options):
    """The page with the first table of each group replaced."""
    lines = page.splitlines()
    for heading, of_group in options.items():
        if f"## {heading}" not in lines:
            raise ValueError(f"{PAGE.name} has no heading '## {heading}', which -help has")
        section = lines.index(f"## {heading}") + 1
        next_section = next((k for k in range(section, len(lines)) if lines[k].startswith("## ")), len(lines))
        start = next((k for k in range(section, next_section) if lines[k].startswith("|")), None)
        if start is None:
            raise ValueError(f"{PAGE.name} has no table under '## {heading}'")
        end = next((k for k in range(start, next_section) if not lines[k].startswith("|")), next_section)
        lines[start:end] = HEADER + [option.row() for option in of_group]
    return "\n".join(lines) + "\n"


def sheet(options):
    """The page that has all options in few words."""
    parts = [f"\n## {heading}\n\n| option | in few words |\n| --- | --- |\n" + "\n".join(option.short_row() for option in of_group) + "\n"
             for heading, of_group in options.items()]
    return SHEET_BEGINS + "".join(parts)


def presets(text):
    """The page of what -presets prints, a line for each: "NAME: -option value +- p %, ... (source)"."""
    rows = {False: [], True: []}
    for line in text.splitlines():
        name, values, source = re.fullmatch(r"(\w+): (.*?) \((.*)\)", line).groups()
        rows["-NAME_" in values].append(row_of([f"`{name}`", values.replace("-NAME_", "").replace("-indenter_", "").replace("-indenter ", ""), source]))
    tables = [f"\n## {heading}\n\n| name | {what} | from |\n| --- | --- | --- |\n" + "\n".join(rows[of_material]) + "\n"
              for heading, what, of_material in (("Materials", "constants (options -NAME_...)", True), ("Tips", "shape (options -indenter...)", False))]
    return PRESETS_BEGIN + "".join(tables)


def first_difference(path, page, wanted):
    """One line each for what the page has and what it should have, at the first place where they differ."""
    for number, (have, want) in enumerate(itertools.zip_longest(page.splitlines(), wanted.splitlines(), fillvalue="(nothing)"), 1):
        if have != want:
            return f"{path.relative_to(ROOT)}:{number} has\n  {have}\n-help says\n  {want}\nrun scripts/options_doc.py"
    return "the page does not end with a new line"


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="only compare")
    check = parser.parse_args(arguments).check
    text, table = (subprocess.run([str(PROGRAM), word], capture_output=True, text=True, check=True).stdout for word in ("-help", "-presets"))
    options, stale = groups(text), False
    for path, wanted in ((PAGE, rewrite(PAGE.read_text(), options)), (SHEET, sheet(options)), (PRESETS, presets(table))):
        page = path.read_text() if path.exists() else ""
        if page == wanted:
            continue
        stale = True
        if check:
            print(first_difference(path, page, wanted), file=sys.stderr)
        else:
            path.write_text(wanted)
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
