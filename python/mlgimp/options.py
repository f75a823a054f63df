"""Options of the program as a dict {name without its dash: value}, as words of a command line and as an options file.

Values may be numbers, texts, True and False, sequences of numbers or texts (vectors), paths, or None: a flag without a value.
"""

import os
import re
from pathlib import Path

from . import units
from .errors import Error


def text_of(value):
    """Returns the text of an option's value: numbers with all their digits, vectors with commas."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, os.PathLike)):
        return str(value)
    if hasattr(value, "tolist"):  # numbers and arrays of numpy
        return text_of(value.tolist())
    if isinstance(value, (list, tuple)):
        return ",".join(map(text_of, value))
    return shortest(value) if isinstance(value, float) else str(value)


def shortest(value):
    """Returns the shortest text that is read as this number again: 7e+10, 0.33, 60."""
    return min((text for text in (f"{value:.{digits}g}" for digits in range(1, 17)) if float(text) == value), key=len, default=repr(value))


def to_words(options):
    """Returns a command line: {"cell_size": 1, "overwrite": None} gives ["-cell_size", "1", "-overwrite"]."""
    return [word for name, value in options.items() for word in (f"-{name}", *([] if value is None else [text_of(value)]))]


def of_words(words):
    """Returns the options of a command line by their names in small letters; values are texts, and None for a flag."""
    options, name = {}, None
    for word in words:
        if re.match(r"-[A-Za-z]", word):
            name = word[1:].lower()
            options[name] = None
        elif name is not None and units.is_unit_of(options[name], word):
            options[name] += word
        elif name is None or options[name] is not None:
            raise Error(f"{word}: must follow an option")
        else:
            options[name] = word
    return options


def named(options):
    """Returns options by their names in small letters, since capitals make no difference to the program."""
    small = {}
    for name, value in options.items():
        if not isinstance(name, str) or not re.match(r"[A-Za-z]", name):
            raise Error(f"{name}: must be an option's name without its dash")
        if name.lower() in small:
            raise Error(f"{name}: must be given once; capitals make no difference")
        small[name.lower()] = value
    return small


def read_options(path):
    """Returns the options of an options file; values are texts, and None for a flag."""
    try:
        lines = Path(path).read_text().splitlines()
    except (OSError, ValueError) as problem:
        raise Error(f"{path}: must be a text of options ({problem})") from None
    try:
        return of_words(word for line in lines for word in line.partition("#")[0].split())
    except Error as problem:
        raise Error(f"{path}: {problem}") from None


def write_options(path, options, comment=""):
    """Writes an options file, with a comment of some lines above the options.

    options: {name: value}, or a list of such groups, which empty lines part.
    """
    groups = [options] if isinstance(options, dict) else options
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    for group in groups:
        lines += [""] * bool(lines)
        lines += [line_of(*to_words({name: value})) for name, value in group.items()]
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text("\n".join(lines) + "\n")
    except OSError as problem:
        raise Error(f"{path}: cannot be written ({problem.strerror})") from None


def line_of(name, value=""):
    """Returns a line of an options file, as the program reads it: blanks part words, and # begins a comment."""
    if re.search(r"[\s#]", value):
        raise Error(f"{name} {value}: must have neither blanks nor # in an options file")
    return f"{name} {value}".rstrip()


def number_of(options, name, default):
    """Returns the value of an option, with or without a unit, as a number in SI units."""
    try:
        [value] = units.numbers_of(options.get(name) or default)
        return value
    except (Error, TypeError, ValueError):
        raise Error(f"-{name} {options[name]}: must be a number, or one with its unit") from None
