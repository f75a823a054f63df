"""A look at a case before it runs: what it is, what it costs, what is doubtful about it, and its picture."""

import json
import os
import subprocess
import tempfile
from collections import namedtuple
from pathlib import Path

from . import checks, options, program
from .errors import RunError
from .needs import need

FIGURES = "load", "stiffness", "hardness"  # that are off like the load

Check = namedtuple("Check", "facts warnings figure")
Check.__doc__ = """What mlgimp.check has found: facts, a dict as the program has them, in SI units (`contact` is None where the largest depth is not
known before the run; `seconds` of the run on this machine, `load_error`, `area_error` and, not in plane strain, `block_error` as shares); warnings, a list of lines; and the
picture of the case, a matplotlib Figure, or None."""


def check(case, ranks=1, *, picture=True, out=None, **more):
    """Sets a case up, takes a few steps to see what they cost, and returns the Check. Nothing is written but the picture, where `out` is given.

    case: the path of an options file, or a dict of options by their names without dashes; more: other options, which count more.
    picture: whether the case is drawn; out: the path of the picture, as "check.png".
    """
    given = options.named(case if isinstance(case, dict) else {"options_file": checks.path("case", case)}) | options.named(more)
    ranks = checks.whole("ranks", ranks, 1)
    facts = json.loads(printed_by({**given, "check": "json", "monitor": False}, ranks).splitlines()[-1])
    figure = drawn(given, facts, out) if picture or out else None
    return Check(facts, facts["warnings"], figure)


def printed_by(given, ranks):
    """Returns what the program prints with these options; raises a RunError with its one line where it refuses them."""
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    words = [*start, program.find_program(), *options.to_words(given)]
    done = subprocess.run(words, capture_output=True, text=True, stdin=subprocess.DEVNULL,
                          env={**program.ENVIRONMENT, **(program.ALONE if ranks == 1 else {}), **os.environ})
    if done.returncode != 0:
        raise RunError(program.line_of_failure(done.stderr.splitlines(), done.returncode))
    return done.stdout


def drawn(given, facts, out):
    """Returns the picture of a case with the place of the tip at its largest depth, and writes it where `out` is given."""
    need("matplotlib")
    from . import case_picture, pictures
    with tempfile.TemporaryDirectory(prefix="mlgimp_check_") as folder:
        start = {"max_steps": 1, "frames": 1, "output_dir": folder, "overwrite": True, "monitor": False, "checkpoint_interval": 0}
        program.execute({**given, **start})
        figure = case_picture.case(folder, facts["contact"])
    figure.axes[0].set_title(facts["case"])
    if out:
        pictures.save(figure, Path(out))
    return figure


def text_of(found, error_of=FIGURES):
    """Returns the lines of a Check for people."""
    facts, contact = found.facts, found.facts["contact"]
    cells = ", ".join(f"{level['cell_size'] * 1e9:.4g}" for level in facts["levels"])
    lines = [f"{facts['case']}: {facts['geometry'].replace('_', ' ')}, {sum(level['points'] for level in facts['levels']):.0f} points, cells of {cells} nm",
             f"{facts['steps']:.0f} steps of level 0, {facts['finest_steps']:.0f} of the finest; {1e-6 * facts['bytes_per_rank']:.3g} MB a rank",
             f"about {time_of(facts['seconds'])} on {facts['ranks']} {'rank' if facts['ranks'] == 1 else 'ranks'} of this machine"]
    if contact:
        less = " less what frame and tip take of it (what follows is without that)" if contact["at_most"] else ""
        block = "" if contact["block_error"] is None else f"; the block makes moduli up to {100 * contact['block_error']:.2g} % too large"
        lines.append(f"{contact['cells']:.3g} cells in half the width of the contact at {1e9 * contact['depth']:.4g} nm{less}: {', '.join(error_of)} off by "
                     f"up to {100 * contact['load_error']:.2g} %, the true area by {100 * contact['area_error']:.2g} %{block}")
    else:
        lines.append("the largest depth is not known before the run, nor the cells in the contact")
    return [*lines, *facts["notes"], *(f"warning: {line}" for line in found.warnings)]


def time_of(seconds):
    """Returns a time in words."""
    return f"{seconds:.3g} s" if seconds < 120 else f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"
