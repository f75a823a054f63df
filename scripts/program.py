"""Running the program from a script: its options as words, as a file and as a dict, and one line where it fails."""
import re
import shlex
import subprocess
import sys

from bench import ENVIRONMENT, ROOT


def fail(message):
    """Ends with one line, as the program does."""
    sys.exit(f"error: {message}")


def whole_number_from(least):
    """Converts whole numbers from `least` on."""
    def convert(text):
        if int(text) < least:
            raise ValueError
        return int(text)
    return convert


def take(options, name, convert, default, allowed):
    """Takes one of the study's own options out of all of them."""
    if name not in options:
        return default
    text = options.pop(name)
    try:
        if text is not None:
            return convert(text)
    except ValueError:
        pass
    fail(f"-{name} {text or '(nothing)'}: must be {allowed}")


def options_of(words):
    """{name: value} of a list of words -name value; a flag has the value None."""
    options, name = {}, None
    for word in words:
        if re.match(r"-[A-Za-z]", word):
            name = word[1:]
            options[name] = None
        elif name is None or options[name] is not None:
            fail(f"{word}: must follow an option")
        else:
            options[name] = word
    return options


def read_options(path):
    """{name: value} of an options file."""
    try:
        words = shlex.split(path.read_text(), comments=True)
    except (OSError, ValueError) as problem:
        fail(f"{path}: must be a text of options ({problem})")
    return options_of(words)


def number_of(options, name, default):
    """The value of an option as a number."""
    try:
        return float(options.get(name) or default)
    except ValueError:
        fail(f"-{name} {options[name]}: must be a number")


def run(file, options, ranks, where):
    """Runs the program; ends with its line and where that was, in words, where it fails."""
    words = [word for name, value in options.items() for word in (f"-{name}", str(value))[:1 if value is None else 2]]
    start = ["mpiexec", "-n", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, str(ROOT / "bin/mlgimp"), "-options_file", str(file), *words], env=ENVIRONMENT, capture_output=True, text=True)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if "error" in line] or [f"exit status {done.returncode}"]
        fail(f"{where}: {lines[0]}")
