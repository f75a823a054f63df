"""An instrument for simulated tests: its own tip and what gives way behind it, and its test as steps with durations."""

import math
from dataclasses import dataclass

from . import checks, tips, units
from .checks import Rule
from .errors import Error

SIZES = ("half_angle", "radius", "tip_radius", "edge_radius", "faces", "turn")  # of the options -indenter_...
UNITS = {"indenter_half_angle": "an angle", "indenter_turn": "an angle", "indenter_stiffness": "a stiffness", "indenter_youngs_modulus": "a stress"}
UNITS |= dict.fromkeys(("indenter_radius", "indenter_tip_radius", "indenter_edge_radius"), "a length")
POSITIVE = Rule(lambda value: value > 0, "a number > 0")


@dataclass(frozen=True)
class Tip:
    """A tip and what gives way behind it, as `tip` of mlgimp.indent. Lengths in m, angles in degrees, but where a name says nm; or texts with a
    unit, as "5 um".

    kind: of -indenter, with its sizes half_angle, radius, tip_radius, edge_radius, faces and turn. In its place one of
    area_nm: C0, C1, C2, ... of the area function C0 h^2 + C1 h + C2 h^(1/2) + ... in nm^2 of h in nm, of revolution, or in space with
    `faces` a pyramid; depths_nm: the least and the largest depth for which it holds;
    profile: a file of two columns, distance from the axis and height; height_map: a file of heights, map_size: its extents along x
    and y, where it is rows of numbers.
    tilt: angle of the axis from z, and the direction toward which it leans, from x; only in space.
    frame: stiffness of frame or cantilever (N/m); youngs_modulus (Pa) and poissons_ratio: of the tip, which is rigid without.
    """

    kind: str = None
    area_nm: tuple = None
    depths_nm: tuple = None
    profile: str = None
    height_map: str = None
    map_size: tuple = None
    half_angle: float = None
    radius: float = None
    tip_radius: float = None
    edge_radius: float = None
    faces: int = None
    turn: float = None
    tilt: tuple = None
    frame: float = None
    youngs_modulus: float = None
    poissons_ratio: float = None

    def __post_init__(self):
        given = [name for name in ("kind", "area_nm", "profile", "height_map") if getattr(self, name) is not None]
        if len(given) != 1:
            raise Error(f"Tip: one of kind, area_nm, profile and height_map must be given, not {len(given)}")
        for name, needs in (("depths_nm", "area_nm"), ("map_size", "height_map"), ("poissons_ratio", "youngs_modulus")):
            if getattr(self, name) is not None and getattr(self, needs) is None:
                raise Error(f"Tip: {name} must stand beside {needs}")
        for name in ("half_angle", "radius", "tip_radius", "edge_radius"):
            if getattr(self, name) is not None and self.kind is None:
                raise Error(f"Tip: {name} must stand beside kind; {given[0]} has the whole shape")

    def options(self):
        """Returns the options -indenter... of the program, in SI units."""
        kind = self.kind or ("area_function" if self.area_nm is not None else "profile" if self.profile is not None else "height_map")
        found = {"indenter": kind, **{f"indenter_{name}": getattr(self, name) for name in SIZES}}
        if self.area_nm is not None:
            found["indenter_area_coefficients"] = tuple(c * area_factor(k) for k, c in enumerate(self.area_nm))
        if self.depths_nm is not None:
            found["indenter_area_depths"] = tuple(1e-9 * depth for depth in self.depths_nm)
        found |= {"indenter_profile": self.profile, "indenter_map": self.height_map, "indenter_map_size": self.map_size, "indenter_tilt": self.tilt,
                  "indenter_stiffness": self.frame, "indenter_youngs_modulus": self.youngs_modulus, "indenter_poissons_ratio": self.poissons_ratio}
        return {name: units.argument(name.removeprefix("indenter_"), value, UNITS[name]) if name in UNITS else value
                for name, value in found.items() if value is not None}

    def mirrors(self):
        """Returns whether a model of space may end at the tip across x and across y: of what may be turned or measured it does not."""
        if self.height_map is not None or self.tilt is not None or self.turn is not None:
            return [False, False]
        faces = tips.PYRAMIDS[self.kind][0] if self.kind in tips.PYRAMIDS else self.faces or (4 if self.kind == "pyramid" else 0)
        return [faces % 4 == 0, True]


def area_factor(k):
    """Returns C_k of an area in m^2 over C_k of one in nm^2: 10^(-9 (2 - 2^(1 - k)))."""
    return 10.0 ** (-9 * (2 - 2.0 ** (1 - k)))


def quantity(text, kind):
    """Returns a text with a unit, as "10 mN", in SI units; None where it is not of the kind."""
    try:
        return units.argument("goal", text, kind) if isinstance(text, str) else None
    except Error:
        return None


def turns_of(test):
    """Returns (kind, times, values) of a test, a list of steps (seconds, goal): "load" in N or "depth" in m at the times (s), from 0 on.

    goal: a load or a depth with its unit, as "10mN" or "200nm", 0, or "hold". All goals are of one kind.
    """
    if not isinstance(test, (list, tuple)) or not test or any(not isinstance(step, (list, tuple)) or len(step) != 2 for step in test):
        raise Error(f"test={test}: must be a list of (seconds, goal), as [(10, '10mN'), (30, 'hold'), (10, 0)]")
    times, values, kinds = [0.0], [0.0], set()
    for duration, goal in test:
        times.append(times[-1] + checks.number("test", duration, POSITIVE))
        load, depth = quantity(goal, "a force"), quantity(goal, "a length")
        if goal == "hold":
            values.append(values[-1])
        elif goal == 0 or str(goal) == "0":
            values.append(0.0)
        elif (load if depth is None else depth) is None or not (load or 0) + (depth or 0) > 0:
            raise Error(f"test: the goal {goal!r} must be 'hold', 0, or a load or a depth with its unit, as 10mN or 200nm")
        else:
            values.append(depth if load is None else load)
            kinds.add("depth" if load is None else "load")
    if len(kinds) != 1:
        raise Error("test: its goals must be loads, or depths, at least one above 0")
    return kinds.pop(), times, values


def largest_of(kind, values):
    """Returns the arguments depth and load of a test."""
    return {"depth": None, "load": None, kind: max(values, default=math.nan)}
