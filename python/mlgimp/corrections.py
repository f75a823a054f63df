"""What is taken off a measured curve before it is analysed: the load of the free tip, the frame's compliance, drift, the depth of the
surface."""

import math
from collections import namedtuple

from . import checks, drifts, zeros
from .checks import Rule

Corrections = namedtuple("Corrections", "zero_depth zero_load drift frame", defaults=(0, 0, None, None))
Corrections.__doc__ = """The zeros of depths and loads, numbers or how they are found (zeros.py); the drift of the depths (nm/s), or "auto";
and the compliance of the frame (nm/mN); None: nothing."""

AUTO = "auto"
DRIFT = Rule(math.isfinite, f"a number in nm/s, or {AUTO}")
FRAME = Rule(lambda compliance: 0 <= compliance < 1e6, "a number >= 0 in nm/mN; 3 N/um are 0.333 nm/mN")  # 1e6 nm/mN are 1 N/m, of a cantilever


def checked_drift(drift):
    """Returns a drift that a caller gives (nm/s, "auto" or None), as it is."""
    return drift if drift is None or isinstance(drift, str) and drift == AUTO else checks.number("drift", drift, DRIFT)


def checked_frame(compliance):
    """Returns the compliance of a frame (nm/mN) that a caller gives, or None."""
    return None if compliance is None else checks.number("frame_compliance", compliance, FRAME)


def corrected(curve, wished):
    """Returns a Curve with Corrections, and notes on what was found and taken off."""
    curve = zeros.without_zero_load(curve, wished.zero_load)
    if wished.frame:
        curve = curve._replace(depth=curve.depth - 1e-3 * wished.frame * curve.load,
                               notes=[*curve.notes, f"a frame with {wished.frame:.4g} nm/mN is taken off the depths"])
    curve = with_drift_off(curve, wished.drift)
    return zeros.without_zero_depth(curve, wished.zero_depth)


def with_drift_off(curve, drift):
    """Returns a Curve without the drift that is given, that of its own hold where it is "auto", or with a note of that hold where none is."""
    if drift == AUTO:
        found = drifts.drift_of(curve)
        return without_drift(curve._replace(notes=[*curve.notes, f"a {drifts.described(found)} is taken off the depths"]), found.rate)
    if drift is None and (found := drifts.find(curve)) and abs(found.rate) > 2 * found.error:
        return curve._replace(notes=[*curve.notes, f"a {drifts.described(found)} is left in the depths; drift auto takes it off"])
    return without_drift(curve, drift or 0)


def without_drift(curve, drift):
    """Returns a Curve without a drift of the depth (nm/s), which needs its times."""
    if not drift:
        return curve
    if curve.time is None:
        raise drifts.no_time(curve)
    return curve._replace(depth=curve.depth - 1e-3 * drift * (curve.time - curve.time[0]))
