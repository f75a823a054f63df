#!/usr/bin/env python3
"""Prints the manual page mlgimp(1), with the options that `bin/mlgimp -help` lists; `make install` calls it."""
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
import options_doc

HEAD = r""".TH MLGIMP 1 "" "mlgimp {version}" "User Commands"
.SH NAME
mlgimp \- explicit GIMP simulation of indentation and contact on nested grid levels
.SH SYNOPSIS
.B mlgimp
\-options_file
.I FILE
.RI [ \-option " " value " ...]"
.br
.B mpiexec \-n
.I N
.B mlgimp
\-options_file
.I FILE
.RI [ \-option " " value " ...]"
.SH DESCRIPTION
Runs the case that the options describe and writes its history, frames of the material points, checkpoints and a summary into the
folder of \-output_dir. All values are SI. What is given twice counts as it was given last. Options of PETSc work too, among them
\-log_view and \-options_left.
.SH EXIT STATUS
0 where the run reached its end, or stopped in time for \-max_wall_time; else one line on standard error says what is wrong and what
is allowed.
.SH SIGNALS
SIGUSR1 writes a checkpoint. SIGTERM writes one and ends the run; a second one ends it at once.
"""

FOOT = r""".SH FILES
The folder share/mlgimp beside this page's share/man holds README.md, the documents in docs (tutorial.md is the first, options.md has
notes to each option), examples of cases in options, a notebook in examples, scripts for pictures and analysis, the Python package in
python, CHANGELOG.md, CITATION.cff and LICENSE.
"""


def escape(text):
    """Text as roff prints it literally."""
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return r"\&" + text if text.startswith((".", "'")) else text


def entry(option):
    """One option: its name, and below it meaning, unit and default."""
    unit = f" [{option.unit}]" if option.unit else ""
    return f".TP\n.B {escape(option.name)}\n{escape(f'{option.meaning}{unit}; default: {option.default}')}\n"


def page(help_text, version):
    """The manual page as roff."""
    parts = [HEAD.replace("{version}", version)]
    for heading, options in options_doc.groups(help_text).items():
        parts.append(f".SH {escape(heading.upper())}\n" + "".join(map(entry, options)))
    return "".join(parts) + FOOT


if __name__ == "__main__":
    text = subprocess.run([str(options_doc.PROGRAM), "-help"], capture_output=True, text=True, check=True).stdout
    header = (options_doc.ROOT / "src/program/system/versions.cpp").read_text()
    print(page(text, re.search(r'kVersion = "([^"]+)"', header).group(1)), end="")
