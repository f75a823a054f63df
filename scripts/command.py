"""What the commands here share: they find the package mlgimp without its installation, draw without a screen, and end with one
line where something is wrong, as a module that this Python does not have. To be imported before the package and other modules."""

import argparse
import functools
import logging
import os
import re
import signal
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python"))
logging.getLogger("matplotlib").setLevel(logging.ERROR)  # without a home folder it would tell about its cache

from mlgimp.needs import need

need("matplotlib")
import matplotlib

matplotlib.use("Agg")

from mlgimp import pictures
from mlgimp.errors import Error


def command(main):
    """Decorates the main function of a command: what it returns, if not 0 or None, is the exit status; an Error ends it with its line
    on standard error and exit status 1, an interrupt with a line and 130, as in shells; a reader of its output that has gone, such as head,
    ends it in silence."""
    @functools.wraps(main)
    def ended(*arguments):
        try:
            status = main(*arguments)
            sys.stdout.flush()
            if status:
                raise SystemExit(status)
        except Error as problem:
            raise SystemExit(f"error: {problem}") from None
        except KeyboardInterrupt as problem:
            print(str(problem) or "interrupted", file=sys.stderr)
            raise SystemExit(128 + signal.SIGINT) from None
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what Python would still write
            raise SystemExit(1) from None
    return ended


class Parser(argparse.ArgumentParser):
    """Refuses a command line with one line; -h shows how it is used. Options may begin with one dash or two, and have - or _ in their names."""

    def parse_known_args(self, args=None, namespace=None):
        known = self._option_string_actions
        return super().parse_known_args([as_known(word, known) for word in (sys.argv[1:] if args is None else args)], namespace)

    def error(self, message):
        raise SystemExit(f"error: {message}")


def save(figure, path):
    """Writes a picture and says so."""
    pictures.save(figure, path)
    print(path)


def as_known(word, known):
    """Returns a word of a command line, an option as it is spelt among the known ones: --vary of -vary, --frame-compliance of --frame_compliance."""
    name, mark, value = word.partition("=")
    spelt = "--" + name.lstrip("-").replace("_", "-")
    return spelt + mark + value if name.startswith("-") and name not in known and spelt in known else word


# ---- options of a command beside those of mlgimp, in the same form ----

def asks_for_help(words):
    """Whether a command line asks how the command is used, at any place."""
    return any(word in ("-h", "-help", "--help") for word in words)


def one_dash(words):
    """Returns the words of a command line with options that begin with one dash, as --vary=E or --vary E is -vary E."""
    found = []
    for word in words:
        name, mark, value = word.partition("=")
        is_long = re.match(r"--[A-Za-z]", word)
        found += ["-" + name[2:].replace("-", "_"), *[value] * bool(mark)] if is_long else [word]
    return found

def whole_number_from(least):
    """Returns a function that converts whole numbers from `least` on."""
    def convert(text):
        if int(text) < least:
            raise ValueError
        return int(text)
    return convert


def take(options, name, convert, default, allowed):
    """Takes one of the command's own options out of all of them."""
    if name not in options:
        return default
    text = options.pop(name)
    try:
        if text is not None:
            return convert(text)
    except ValueError:
        pass
    raise Error(f"-{name} {text or '(nothing)'}: must be {allowed}")
