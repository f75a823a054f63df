"""Indenter tips as a laboratory knows them: projected area over the distance from the tip. Lengths in um, areas in um^2."""

import math
from collections import namedtuple

import numpy as np

from .checks import Rule
from .errors import Error

Tip = namedtuple("Tip", "name area epsilon beta ball slant repaired least largest radius", defaults=(0.0, math.nan, 0.0, 0.0, math.inf, math.nan))
Tip.__doc__ = """A tip: its name; area(h), the projected area (um^2) at distances h (um) from its end; epsilon of the contact
depth; beta(nu, h) of the stiffness at contact depths h (um), nu None where it is not known; how high (um) the ball at its end is, if it is
a cone; the area of its faces over the projected one, NaN of balls and punches; of an area function the depth (um) below which it is
continued, and the least and the largest (um) to which it was calibrated; and the radius (um) of a ball."""

PYRAMIDS = {"berkovich": (3, 65.27), "vickers": (4, 68.0), "cube_corner": (3, math.degrees(math.atan(math.sqrt(0.5))))}  # faces, half angle
KNOOP = 172.5, 130.0  # between opposite edges
BETA_OF_FACES = {3: 1.034, 4: 1.012}  # King, Int. J. Solids Struct. 23 (1987) 1657
NEEDS = {"cone": ("half_angle",), "sphere": ("radius",), "flat_punch": ("radius",), "pyramid": ("half_angle",),
         "knoop": ()} | dict.fromkeys(PYRAMIDS, ())

MAY_HAVE = {"cone": ("tip_radius",), "flat_punch": ("edge_radius",), "pyramid": ("tip_radius", "faces"), "knoop": ("tip_radius",)} | dict.fromkeys(PYRAMIDS, ("tip_radius",))  # too
LEAST_DEPTH, DEEPEST = 0.1, 2e4  # nm, between which an area function is looked at: less is no contact, and no function is fitted deeper
ROUNDING = 1e-9
TRUSTED = 3  # times the depth below which an area function is continued: less deep it is that of few rows of its calibration
STEEPEST = 2.05  # exponent that a calibration may leave: C1 < 0 makes it 2 + |C1|/(C0 h); docs/decisions.md, kMaxPower
RIM = 0.01  # of the contact depth, above and below which the slope of a tip is taken
SHARPEST = 1e-3  # um: a smaller radius is none in um
RULES = {  # for sizes in degrees and um
    "half_angle": Rule(lambda angle: 0 < angle < 90, "in (0, 90) degrees from the axis"),
    "radius": Rule(lambda radius: SHARPEST <= radius < math.inf, f"a number >= {SHARPEST} in um; 5e-6 m are 5"),
    "tip_radius": Rule(lambda radius: radius == 0 or SHARPEST <= radius < math.inf,
                       f"0 or a number >= {SHARPEST} in um; 1e-7 m are 0.1"),
    "edge_radius": Rule(lambda radius: radius == 0 or SHARPEST <= radius < math.inf, f"0 or a number >= {SHARPEST} in um"),
    "faces": Rule(lambda count: count >= 3, "a whole number >= 3"),
}


def as_keyword(name, value=""):
    """Returns an argument as Python has it, the name alone without a value."""
    return f"{name}={value}".rstrip("=")


def check_sizes(kind, given, spelt=as_keyword):
    """Refuses a size that a kind of tip needs and does not get, and one that it does not have.

    given: {name: value or None}; spelt(name) and spelt(name, value): an argument as the user has it.
    """
    for name, value in given.items():
        needs, has = name in NEEDS[kind], name in NEEDS[kind] + MAY_HAVE.get(kind, ())
        if needs if value is None else not has:
            raise Error(f"{spelt(name)}: must be {'given' if needs else 'left out'} for {spelt('tip', kind)}")


def make_tip(kind, half_angle=None, radius=None, tip_radius=0, faces=4, edge_radius=0):
    """Returns the Tip of a kind of NEEDS; angles in degrees from the axis, lengths in um."""
    if kind == "sphere":
        return Tip(kind, lambda h: np.pi * bulge(h, radius), 0.75, constant(1.0), radius=radius)
    if kind == "flat_punch":
        return Tip(kind, lambda h: np.pi * (radius - edge_radius + np.sqrt(bulge(h, edge_radius))) ** 2, 1.0, constant(1.0))
    if kind in PYRAMIDS:
        faces, half_angle = PYRAMIDS[kind]
    sectors = sectors_of_rhombus(*KNOOP) if kind == "knoop" else None
    if sectors:
        half_angle = math.degrees(math.atan(sectors[0][1] * math.cos(sectors[0][2])))
    tangent, slant = math.tan(math.radians(half_angle)), 1 / math.sin(math.radians(half_angle))
    if kind == "cone":
        return Tip(kind, lambda h: np.pi * section_radius(h, half_angle, tip_radius) ** 2, 0.72, lambda nu, h: hay(tangent, nu),
                   ball_height(half_angle, tip_radius), slant, radius=tip_radius)
    sectors = sectors or sectors_of(faces, tangent)
    return Tip(kind, np.vectorize(lambda h: pyramid_area(h, sectors, tip_radius), otypes=[float]), 0.75,
               constant(BETA_OF_FACES.get(faces, 1.0)), slant=slant)


def bulge(h, radius):
    """Returns the square of the half width (um^2) of a ball of a radius at a height h (um) over its end, at most that of the radius."""
    height = np.clip(h, 0, radius)
    return height * (2 * radius - height)


def ball_height(half_angle, tip_radius):
    """Returns how high (um) the ball at the end of a rounded cone is: there the flanks are tangent to it; degrees, um."""
    return tip_radius * (1 - math.sin(math.radians(half_angle)))


def section_radius(h, half_angle, tip_radius):
    """Returns the radius (um) of a rounded cone's section at distances h (um) from its end, 0 where they are below zero.

    The end is a ball of the tip radius R (um), to which the cone of the half angle a (degrees) is tangent. The apex of the cone by
    itself would lie R (1/sin a - 1) beyond the ball's end, from which depths count. The same is half the width of a wedge whose
    edge is a cylinder.
    """
    angle, h = math.radians(half_angle), np.maximum(h, 0)
    ball = np.sqrt(np.maximum(h * (2 * tip_radius - h), 0))
    flank = math.tan(angle) * (h + tip_radius * (1 / math.sin(angle) - 1))
    return np.where(h < ball_height(half_angle, tip_radius), ball, flank)


def tip_of_function(coefficients, least=0.0, largest=math.inf):
    """Returns the Tip whose area is C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) ..., h in nm and the area in nm^2.

    A function that was fitted above some depth need not be that of a tip below it. Below h_m, the least calibrated depth from which up to ten
    times that p = h A'/A is between that of a paraboloid, 1, and STEEPEST, that of a cone, 2, and a little more, the tip is
    A = A(h_m) (h/h_m)^p, as in the program: A and A' go on, and depth zero stays. least, largest: calibrated depths (nm). beta is 1, with which
    laboratories find such functions; where the function is the shape itself, as of a run, of_shape() gives another.
    """
    start, power = repaired_from(coefficients, least, largest)

    def area(h):
        nanometres = np.maximum(1e3 * np.asarray(h, float), 0)
        return 1e-6 * np.where(nanometres < start, polynomial(coefficients, max(start, LEAST_DEPTH)) * (nanometres / max(start, LEAST_DEPTH)) ** power,
                               polynomial(coefficients, nanometres))
    return Tip("area function", area, 0.75, constant(1.0), slant=make_tip("berkovich").slant, repaired=1e-3 * start,
               least=1e-3 * least, largest=1e-3 * largest if largest > 0 else math.inf)


def doubts(tip, depth):
    """Yields what makes the area of a Tip at a contact depth (um) doubtful."""
    if 0 < depth < TRUSTED * tip.repaired:
        yield (f"the area function is that of no tip below {1e3 * tip.repaired:.3g} nm, where it is continued by a power, and the contact depth is "
               f"{1e3 * depth:.3g} nm: the area is not sure")
    if 0 < depth < tip.least:
        yield f"the contact depth is {1e3 * depth:.3g} nm, below {1e3 * tip.least:.3g} nm, the least to which the tip was calibrated: the area is not sure"


def polynomial(coefficients, h, derivative=False):
    """Returns C0 h^2 + C1 h + C2 h^(1/2) + ... in nm^2 at depths h (nm), or its derivative times h."""
    powers = [2.0 ** (1 - k) for k in range(len(coefficients))]
    return sum(c * (q if derivative else 1) * h**q for c, q in zip(coefficients, powers))


def repaired_from(coefficients, least, largest):
    """Returns h_m (nm) and p of tip_of_function(): 0 and 2 where A grows so from zero on, or nowhere."""
    deepest = min(largest, DEEPEST) if largest > 0 else DEEPEST
    depths = np.geomspace(max(least, LEAST_DEPTH), deepest, 4000)
    areas, slopes = polynomial(coefficients, depths), polynomial(coefficients, depths, derivative=True)
    power = np.where(areas > 0, slopes / np.where(areas > 0, areas, 1), np.nan)
    failing = np.append(0, np.cumsum(~((power >= 1 - ROUNDING) & (power <= STEEPEST))))
    decade = failing[np.searchsorted(depths, 10 * depths)] - failing[:-1]  # how many fail from a depth to ten times that
    good = np.flatnonzero(decade == 0)
    if not len(good) or good[0] == 0 and least <= LEAST_DEPTH:
        return 0.0, 2.0
    return float(depths[good[0]]), float(power[good[0]])


def hay(tangent, nu):
    """Returns the stiffness of an elastic contact with a rigid cone over Sneddon's: points under a cone also move inwards.

    Hay, Bolshakov, Pharr, J. Mater. Res. 14 (1999) 2296. Without a Poisson's ratio that of 0.3 is taken.
    """
    nu = 0.3 if nu is None else nu
    inward = (1 - 2 * nu) / (4 * (1 - nu)) / tangent
    return np.pi * (np.pi / 4 + 0.15483073 * inward) / (np.pi / 2 - 0.83119312 * inward) ** 2


def constant(value):
    """Returns a beta(nu, h) that is always the same."""
    return lambda nu, h: value


def of_shape(tip, faces=None):
    """Returns a Tip by its area with the beta of that shape: of a pyramid that of its faces, else that of the cone whose flank has the slope of the
    tip at the rim of the contact, da/dh = A'/(2 sqrt(pi A)), a = sqrt(A/pi)."""
    if faces:
        return tip._replace(beta=constant(BETA_OF_FACES.get(faces, 1.0)))

    def beta(nu, h):
        deeper, higher = (np.sqrt(np.maximum(tip.area(h * share), 0) / np.pi) for share in (1 + RIM, 1 - RIM))
        slope = (deeper - higher) / np.where(np.asarray(h) > 0, 2 * RIM * h, math.nan)
        least = np.sqrt(np.maximum(tip.area(h), 0) / np.pi) / np.where(np.asarray(h) > 0, 2 * h, math.nan)
        return hay(np.fmax(slope, least), nu)[()]
    return tip._replace(beta=beta)


def sectors_of(faces, tangent):
    """Returns the sectors of the section of a regular pyramid: [(corners, distance of a corner from the axis at the height 1, angle
    from a corner to the middle of its side)]."""
    return [(faces, tangent / math.cos(math.pi / faces), math.pi / faces)]


def sectors_of_rhombus(long_edges, short_edges):
    """Returns those of a pyramid over a rhombus by the angles between opposite edges (degrees)."""
    a, b = (math.tan(math.radians(angle / 2)) for angle in (long_edges, short_edges))
    face = math.atan2(1 / b, 1 / a)  # of the normal of a side, from the long diagonal
    return [(2, a, face), (2, b, math.pi / 2 - face)]


def pyramid_area(h, sectors, radius, count=200):
    """Returns the area of the section at distance h from the end of a pyramid with these sectors that is widened by a radius.

    The section is convex, so that its area is half the integral of H^2 - H'^2, H its support function: over the angle psi from
    a corner that of a pyramid with its apex a radius higher is k(psi) c, to which the ball adds.
    """
    if h <= 0:
        return 0.0
    area, c = 0.0, h - radius
    for corners, corner, reach in sectors:
        psi = (np.arange(count) + 0.5) * reach / count
        k, slope = corner * np.cos(psi), -corner * np.sin(psi)
        root = np.sqrt(1 + k**2)
        on_edges = c >= -k * radius / root  # else on the ball at the apex
        support = np.where(on_edges, k * c + radius * root, math.sqrt(max(radius**2 - c**2, 0)))
        change = np.where(on_edges, slope * (c + radius * k / root), 0)
        area += corners * reach * np.mean(support**2 - change**2)
    return area


def depth_of(tip, area, most):
    """Returns the distance from the end where the tip has an area, at the most `most`; NaN where the area does not grow to it."""
    if math.isnan(area):
        return math.nan
    depths = np.linspace(0, most, 4001)
    areas = tip.area(depths)
    beyond = np.flatnonzero(areas >= area)
    if not len(beyond) or beyond[0] == 0:
        return math.nan
    k = beyond[0]
    return float(np.interp(area, areas[k - 1:k + 1], depths[k - 1:k + 1]))
