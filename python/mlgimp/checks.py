"""Checks of what a caller gives: values that are not allowed end in an Error with the name, the value and what is allowed."""

import math
import numbers
import os
from collections import namedtuple
from collections.abc import Mapping

from .errors import Error

Rule = namedtuple("Rule", "good allowed")
Rule.__doc__ = "What a number, or several together, must be: a test, false for NaN, and the words for it."

POSITIVE = Rule(lambda value: 0 < value < math.inf, "a number > 0")


def refusal(name, value, allowed):
    """Returns the Error for a value that is not what is allowed."""
    return Error(f"{name}={' '.join(str(value).split())}: must be {allowed}")


def no_number(name, value, allowed):
    """Returns the Error for a value that should be a number; texts look like numbers in it."""
    return refusal(name, value, allowed + ", as a number and not as a text" * isinstance(value, str))


def plain(value):
    """Returns a number of numpy, or an array without dimensions, as a number of Python, and all else as it is."""
    return value.tolist() if hasattr(value, "tolist") else value


def number(name, value, rule):
    """Returns a number that meets a Rule, as float."""
    found = plain(value)
    if isinstance(found, bool) or not isinstance(found, numbers.Real) or not rule.good(found):
        raise no_number(name, value, rule.allowed)
    return float(found)


def several(name, values, rule):
    """Returns numbers that together meet a Rule, as a tuple of float, from a sequence or from a text with commas."""
    try:
        found = tuple(map(float, values.split(",") if isinstance(values, str) else values))
    except (TypeError, ValueError):
        found = None
    if found is None or not rule.good(found):
        raise refusal(name, values, rule.allowed)
    return found


def whole(name, value, least=-math.inf):
    """Returns a whole number of any type, from the least on, as int."""
    found = plain(value)
    if isinstance(found, bool) or not isinstance(found, numbers.Integral) or found < least:
        raise no_number(name, value, "a whole number" + (f" >= {least}" if math.isfinite(least) else ""))
    return int(found)


def flag(name, value):
    """Returns True or False; texts like "no" would count as true."""
    if not isinstance(plain(value), bool):
        raise refusal(name, value, "True or False")
    return plain(value)


def path(name, value):
    """Returns the path of a file or folder, a text or a Path, as it is."""
    if not isinstance(value, (str, os.PathLike)):
        raise refusal(name, value, "the path of a file or folder")
    return value


def mapping(name, value):
    """Returns a dict, or what behaves as one, as it is."""
    if not isinstance(value, Mapping):
        raise refusal(name, value, "a dict {name: value}")
    return value
