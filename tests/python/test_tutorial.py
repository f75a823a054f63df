"""Follows docs/tutorial.md: writes its files, runs its commands, and compares what they print with what it shows."""

import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import pytest

import harness
from harness import ROOT

pytestmark = pytest.mark.slow

BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
DIGITS = 0.02  # relative difference of numbers on other machines: the last digits shown, and what plasticity makes of round-off


def commands(block):
    """(command, what it prints) of each command of a console block."""
    for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        command, _, shown = part.partition("\n")
        yield command, shown


def pattern(shown):
    """A pattern for what is shown, with a group for each number, which may be shorter; ... is anything in a line, alone any lines."""
    lines = []
    for line in shown.splitlines():
        pieces = re.split(rf"(\.\.\.|{NUMBER})", line)  # text and what is left open in turn
        for k, piece in enumerate(pieces):
            pieces[k] = re.sub(r"(\\ )+", " +", re.escape(piece)) if k % 2 == 0 else ".*" if piece == "..." else f"({NUMBER})"
        lines.append(r"(?:.*\n)*?" if line == "..." else "".join(pieces) + r"\n")
    return re.compile("".join(lines))


def differ(shown, printed):
    """What is wrong with the text printed; nothing where it is as shown. Newer versions of PETSc have a colon in their help."""
    found = pattern(shown).fullmatch(re.sub(r"^(  -\w+): <", r"\1 <", printed, flags=re.MULTILINE))
    if not found:
        return f"printed\n{printed}instead of\n{shown}"
    for want, have in zip(re.findall(NUMBER, shown), found.groups()):
        if abs(float(have) - float(want)) > DIGITS * abs(float(want)):
            return f"printed {have} instead of {want}:\n{printed}"
    return ""


class Comparison(unittest.TestCase):
    def test_numbers_are_close_and_words_equal(self):
        shown = "load 4.0e-3 N\n...\nlast 12\n"
        self.assertEqual(differ(shown, "load 0.00401 N\none\ntwo\nlast 12\n"), "")
        self.assertEqual(differ(shown, "load 0.00401 N\nlast 12\n"), "")
        self.assertEqual(differ("order  -65.7053  2.3\n", "order   -65.705  2.3\n"), "")
        self.assertIn("0.0042", differ(shown, "load 0.0042 N\nlast 12\n"))
        self.assertIn("instead", differ(shown, "loud 0.004 N\nlast 12\n"))
        self.assertIn("instead", differ("", "mlgimp: error: no\n"))
        self.assertEqual(differ("time ..., level 2\n", "time 3e-6, level 2\n"), "")
        self.assertIn("instead of 2", differ("time ..., level 2\n", "time 3e-6, level 1\n"))


class Tutorial(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="mlgimp_tutorial_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        for name, target in (("bin", harness.BIN), *((name, ROOT / name) for name in ("options", "scripts", "python"))):
            (self.folder / name).symlink_to(target)

    def test_all_blocks(self):
        count = 0
        for kind, name, block in BLOCK.findall((ROOT / "docs" / "tutorial.md").read_text()):
            if kind != "console":
                with open(self.folder / name, "a") as file:
                    file.write(block)
                continue
            for command, shown in commands(block):
                with self.subTest(command=command):
                    done = self.run_in_folder(command)
                    self.assertEqual(differ(shown, done.stdout), "")
                    self.assertEqual(done.returncode != 0, "mlgimp: error" in shown)
                count += 1
        self.assertGreater(count, 20)

    def run_in_folder(self, command):
        """The finished command, with what it printed on both streams in stdout."""
        command = command.replace("/usr/bin/python3", sys.executable)
        return subprocess.run(["bash", "-c", command], cwd=self.folder, env=harness.ENVIRONMENT, timeout=300,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
