"""Quantities with units, as the program reads them: "200nm", "70 GPa", "2.7g/cm3", "10mN". Everything inside is SI; angles are in degrees."""

import math
import numbers
import re

from . import checks
from .errors import Error

# Powers of m, kg, s, K, mol and degree; size beside a power of ten; that power; prefixes that may stand before the symbol.
LENGTH, MASS, TIME, RATE, FORCE = (1, 0, 0, 0, 0, 0), (0, 1, 0, 0, 0, 0), (0, 0, 1, 0, 0, 0), (0, 0, -1, 0, 0, 0), (1, 1, -2, 0, 0, 0)
STRESS, ENERGY, TEMPERATURE = (-1, 1, -2, 0, 0, 0), (2, 1, -2, 0, 0, 0), (0, 0, 0, 1, 0, 0)
AMOUNT, ANGLE, NUMBER = (0, 0, 0, 0, 1, 0), (0, 0, 0, 0, 0, 1), (0, 0, 0, 0, 0, 0)
GRAVITY = 9.80665  # m/s2, exact
SYMBOLS = {
    "1": (NUMBER, 1, 0, ""), "%": (NUMBER, 1, -2, ""), "m": (LENGTH, 1, 0, "fpnumck"), "Angstrom": (LENGTH, 1, -10, ""), "Å": (LENGTH, 1, -10, ""),
    "g": (MASS, 1, -3, "numk"), "s": (TIME, 1, 0, "fpnum"), "min": (TIME, 60, 0, ""), "h": (TIME, 3600, 0, ""), "Hz": (RATE, 1, 0, "kMG"),
    "N": (FORCE, 1, 0, "pnumkM"), "gf": (FORCE, GRAVITY, -3, "k"), "Pa": (STRESS, 1, 0, "kMGT"), "bar": (STRESS, 1, 5, ""),
    "psi": (STRESS, 0.45359237 * GRAVITY / 0.0254**2, 0, "k"), "J": (ENERGY, 1, 0, "fpnumkM"), "eV": (ENERGY, 1.602176634, -19, ""),
    "K": (TEMPERATURE, 1, 0, ""), "degC": (TEMPERATURE, 1, 0, ""), "°C": (TEMPERATURE, 1, 0, ""), "mol": (AMOUNT, 1, 0, ""),
    "deg": (ANGLE, 1, 0, ""), "degrees": (ANGLE, 1, 0, ""), "°": (ANGLE, 1, 0, ""), "rad": (ANGLE, 180 / math.pi, 0, "um"),
}
PREFIXES = {"f": -15, "p": -12, "n": -9, "u": -6, "m": -3, "c": -2, "k": 3, "M": 6, "G": 9, "T": 12}
ZERO_CELSIUS = 273.15  # K
KINDS = {"a length": ("m", "nm, um, mm, m"), "a force": ("N", "nN, uN, mN, N"), "a stress": ("Pa", "kPa, MPa, GPa"), "a time": ("s", "ns, us, ms, s, min, h"),
         "a density": ("kg/m3", "g/cm3, kg/m3"), "a temperature": ("K", "K, degC"), "an angle": ("deg", "deg, rad"), "a speed": ("m/s", "nm/s, um/s, m/s"),
         "a stiffness": ("N/m", "N/m, mN/um"), "an energy": ("J", "nJ, mJ, J"), "a pure number": ("", "%")}
QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def symbol(text):
    """Returns (powers, size, tens) of a symbol with its prefix, or None."""
    for name, (powers, size, tens, prefixes) in SYMBOLS.items():
        if text == name:
            return powers, size, tens
        if text[1:] == name and text[0] in prefixes:
            return powers, size, tens + PREFIXES[text[0]]
    return None


def unit(text):
    """Returns (powers, size, tens) of a unit, as "kg/m3": it is size * 10^tens in base units; None where it is no unit that is known."""
    powers, size, tens, sign = NUMBER, 1.0, 0, 1
    for number, part in enumerate(re.split(r"([/*])", text.replace("µ", "u").replace("μ", "u"))):
        if number % 2:
            sign = -1 if part == "/" else 1
            continue
        if not part and number == 0:
            continue
        found = re.fullmatch(r"(.+?)(?:\^?(-?\d))?", part)
        known = symbol(part) or (found and symbol(found[1]))
        if not known:
            return None
        power = sign * (1 if symbol(part) or not found[2] else int(found[2]))
        powers = tuple(a + power * b for a, b in zip(powers, known[0]))
        size, tens = size * known[1] ** power, tens + power * known[2]
    return powers, size, tens


def kind_of(powers):
    """Returns what a unit with these powers measures, in words."""
    return next((name for name, (base, _) in KINDS.items() if unit(base)[0] == powers), "another quantity")


def in_si(text, kind=None):
    """Returns a quantity, a text of a number with or without a unit, in SI units.

    kind: what it must be where it has a unit, one of KINDS, as "a length". Raises an Error that names the unit where it is unknown or of
    another kind.
    """
    found = QUANTITY.fullmatch(str(text))
    known = unit(found[2]) if found else None
    if not known:
        wanted = f" of {kind} ({KINDS[kind][1]})" if kind else ""
        raise Error(f"{text}: must be a number, or one with a unit{wanted}")
    if not found[2]:
        return float(found[1])
    if kind and known[0] != unit(KINDS[kind][0])[0]:
        raise Error(f"{text}: must be {kind} ({KINDS[kind][1]}), and {found[2]} is {kind_of(known[0])}")
    digits, _, exponent = found[1].lower().partition("e")
    value = known[1] * float(f"{digits}e{int(exponent or 0) + known[2]}")  # so that 0.1 nm is 0.1e-9 m to the last digit
    return value + ZERO_CELSIUS * (found[2] in ("degC", "°C"))


def argument(name, value, kind):
    """Returns the value of an argument in SI units: a number as it is, a text with its unit. None stays None, and what is neither is for others
    to refuse. A text without a unit is refused, since the unit that the caller means is not known; 0 needs none."""
    if not isinstance(value, str):
        return value
    try:
        found = in_si(value, kind)
    except Error as problem:
        raise Error(f"{name}={problem}") from None
    if found and not re.search(r"[^-+.\deE\s]", value):
        raise checks.refusal(name, repr(value), f"a number in SI units, or a text with a unit ({KINDS[kind][1]})")
    return found


def numbers_of(value):
    """Returns the numbers of an option's value in SI units as a list: of a text with commas and units, a number or a sequence."""
    if isinstance(value, numbers.Real):
        return [float(value)]
    return [math.inf if part == "inf" else in_si(part) for part in (value.split(",") if isinstance(value, str) else map(str, value))]


def is_unit_of(value, word):
    """Returns whether a word is the unit of the number that the word before it ends with, as in "200 nm"."""
    return bool(re.search(r"[\d.]$", value or "")) and not word[0].isdigit() and unit(word) is not None
