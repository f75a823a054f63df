"""Exact depths and loads of indentation tests on bodies that creep and relax, with a rigid tip without friction. All values are SI.

Viscoelastic bodies after Lee and Radok, J. Appl. Mech. 27 (1960) 438, and Ting, J. Appl. Mech. 33 (1966) 845, with a constant
Poisson's ratio and a contact that does not shrink; bodies that creep by Norton's law after Hill, Proc. R. Soc. A 436 (1992) 617, and
Bower and others, Proc. R. Soc. A 441 (1993) 97, with slopes of the surface that are small.
"""

import math

import numpy as np
from scipy.interpolate import PchipInterpolator

from .checks import POSITIVE, Rule, number
from .errors import Error

ANGLE = Rule(lambda angle: 0 < angle < 90, "in (0, 90) degrees from the axis")
POISSON = Rule(lambda nu: -1 < nu <= 0.5, "in (-1, 0.5]")
EXPONENT = Rule(lambda n: 1 <= n < math.inf, "a number >= 1")
NOT_NEGATIVE = Rule(lambda value: 0 <= value < math.inf, "a number >= 0")

# Half spaces of Norton's law by finite elements, over the exponent n: the constraint F, and what pile-up makes of the area under a
# cone, c, and a ball, c2. For n = 1 they are exact as 8/3 pi = 0.849, 2/pi = 0.637 and 1/2: the table is 0.9 % high.
EXPONENTS = (1.0, 2.0, 5.0, 10.0)
CONSTRAINTS = (0.857, 2.182, 2.969, 3.103)
CONE_AREAS = (0.642, 0.923, 1.100, 1.176)
BALL_AREAS = (0.504, 0.856, 1.139, 1.275)


# ---- viscoelastic ----

def checked_terms(shares, times):
    """Returns the shares g_k and times tau_k (s) of a Prony series as two arrays [terms]; refuses those that no solid has."""
    shares, times = (np.atleast_1d(np.asarray(values, float)) for values in (shares, times))
    if shares.shape != times.shape or shares.ndim != 1:
        raise Error("shares, times: must be as many of each")
    if not np.all(shares > 0) or not shares.sum() < 1:
        raise Error(f"shares={','.join(f'{share:g}' for share in shares)}: must be > 0, and their sum < 1")
    if not np.all((times > 0) & (times < math.inf)):
        raise Error(f"times={','.join(f'{time:g}' for time in times)}: must be numbers > 0 in s")
    return shares, times


def relaxation(t, shares, times):
    """Returns E(t)/E_0 = 1 - sum g_k (1 - exp(-t/tau_k)) at t (s), which is 0 for t < 0, in the shape of t."""
    shares, times = checked_terms(shares, times)
    t = np.asarray(t, float)
    return np.where(t < 0, 0.0, 1 + np.expm1(-np.maximum(t, 0)[..., None] / times) @ shares)


def retardation(shares, times):
    """Returns the parts c_k and times lambda_k (s) of the compliance E_0 J(t) = 1 + sum c_k (1 - exp(-t/lambda_k)), [terms] each.

    It is the strain e under the stress E_0 (e - sum g_k a_k) = E_0 with tau_k da_k/dt = e - a_k, whose matrix is symmetric in
    a_k sqrt(g_k tau_k).
    """
    shares, times = checked_terms(shares, times)
    drive = np.sqrt(shares / times)
    rates, modes = np.linalg.eigh(np.outer(drive, drive) - np.diag(1 / times))
    return (modes.T @ drive) ** 2 / -rates, 1 / -rates


def history_integral(t, at, values, instant, parts, times):
    """Returns the integral of K(t - s) dv(s) with K(x) = instant + sum parts_k (1 - exp(-x/times_k)), [t].

    v(s) is linear between values [rows] at times `at` (s) [rows], not in falling order; it is zero before the first of them,
    to whose value it jumps, and constant after the last.
    """
    t, at, values = (np.atleast_1d(np.asarray(each, float)) for each in (t, at, values))

    def kernel(x):
        return np.where(x < 0, 0.0, instant - np.expm1(-np.maximum(x, 0)[..., None] / times) @ parts)

    def integrated(x):
        x = np.maximum(x, 0)[..., None]
        return instant * x[..., 0] + (x + times * np.expm1(-x / times)) @ parts

    spans, steps = np.diff(at), np.diff(values)
    jumps = spans <= 0
    found = values[0] * kernel(t - at[0]) + kernel(t[:, None] - at[1:][jumps]) @ steps[jumps]
    return found - np.diff(integrated(t[:, None] - at), axis=1) @ np.where(jumps, 0, steps / np.where(jumps, 1, spans))


def shape_factor(radius=None, half_angle=None):
    """Returns C and m of an elastic contact P = C E* h^m: of a ball of a radius (m), Hertz's 4/3 sqrt(R) and 3/2, or of a cone with a
    half angle (degrees from the axis), Sneddon's 2/pi tan(alpha) and 2."""
    if (radius is None) == (half_angle is None):
        raise Error("radius, half_angle: one of them must be given")
    if radius is not None:
        return 4 / 3 * math.sqrt(number("radius", radius, POSITIVE)), 1.5
    return 2 / math.pi * math.tan(math.radians(number("half_angle", half_angle, ANGLE))), 2.0


def contact_modulus(youngs_modulus, poissons_ratio):
    """Returns E* = E/(1 - nu^2) (Pa) of Young's modulus E (Pa)."""
    return number("youngs_modulus", youngs_modulus, POSITIVE) / (1 - number("poissons_ratio", poissons_ratio, POISSON) ** 2)


def lee_radok(t, load_times, loads, youngs_modulus, poissons_ratio, shares, times, *, radius=None, half_angle=None):
    """Returns the depth (m) at times t (s), [t], under a load that does not fall: C h^m = the integral of J(t - s) dP(s).

    loads (N) at load_times (s) [rows], linear in between and constant after the last; youngs_modulus is E_0 (Pa), at once, and
    shares g_k with their times tau_k (s) [terms] are what relaxes of it: E_inf = E_0 (1 - sum g_k). The tip is a ball of a
    radius (m) or a cone with a half angle (degrees).
    """
    factor, power = shape_factor(radius, half_angle)
    parts, lags = retardation(shares, times)
    strain = history_integral(t, load_times, loads, 1.0, parts, lags) / contact_modulus(youngs_modulus, poissons_ratio)
    return np.maximum(strain / factor, 0) ** (1 / power)


def lee_radok_load(t, depth_times, depths, youngs_modulus, poissons_ratio, shares, times, *, radius=None, half_angle=None):
    """Returns the load (N) at times t (s), [t], at a depth that does not fall: P = C times the integral of E*(t - s) d(h^m)/ds.

    depths (m) at depth_times (s) [rows]: h^m is linear in between, and constant after the last; the rest is that of lee_radok().
    """
    factor, power = shape_factor(radius, half_angle)
    shares, times = checked_terms(shares, times)
    strain = np.maximum(np.asarray(depths, float), 0) ** power
    return factor * contact_modulus(youngs_modulus, poissons_ratio) * history_integral(t, depth_times, strain, 1.0, -shares, times)


# ---- Norton's law: stress s0 (rate/a0)^(1/n) ----

def over_exponent(exponent, values):
    """Returns values of a table over the exponents n at another n: monotone and cubic in 1/n, and from n = 10 on along its last line."""
    places = 1 / np.array(EXPONENTS[::-1])
    wanted, values = 1 / number("exponent", exponent, EXPONENT), np.array(values[::-1])
    beyond = values[0] + (wanted - places[0]) * (values[1] - values[0]) / (places[1] - places[0])
    return float(PchipInterpolator(places, values)(wanted)) if wanted >= places[0] else float(beyond)


def norton_factors(exponent):
    """Returns (F, c, c2) for an exponent n >= 1: p_m = F s0 (dh/dt/(a a0))^(1/n), under a cone a = c h tan(alpha), under a ball
    a^2 = 2 c2 R h. By finite elements for n from 1 to 10, beyond which they are continued."""
    return tuple(over_exponent(exponent, values) for values in (CONSTRAINTS, CONE_AREAS, BALL_AREAS))


def norton_power(exponent, radius=None, half_angle=None):
    """Returns the power q of the depth that grows evenly under a constant load: 2 n under a cone, n + 1/2 under a ball."""
    shape_factor(radius, half_angle)
    return 2 * exponent if radius is None else exponent + 0.5


def log_growth(load, creep_stress, creep_rate, exponent, *, radius=None, half_angle=None):
    """Returns the natural logarithm of d(h^q)/dt (m^q/s) under a constant load (N), with q of norton_power().

    Cone: 2 n c tan(alpha) a0 (P/(pi c^2 tan(alpha)^2 F s0))^n. Ball: (n + 1/2) a0 sqrt(2 c2 R) (P/(2 pi c2 R F s0))^n.
    creep_stress s0 (Pa) and creep_rate a0 (1/s) are those of Norton's law; radius in m, half_angle in degrees.
    """
    constraint, cone, ball = norton_factors(exponent)
    power = norton_power(exponent, radius, half_angle)
    if radius is None:
        width = cone * math.tan(math.radians(half_angle))
        area = math.pi * width**2
    else:
        width, area = math.sqrt(2 * ball * radius), 2 * math.pi * ball * radius
    return math.log(power * width * creep_rate) + exponent * math.log(load / (area * constraint * creep_stress))


def norton_depth(t, load, creep_stress, creep_rate, exponent, start_depth=0.0, *, radius=None, half_angle=None):
    """Returns the depth (m) at times t (s) after that of the start depth (m), in the shape of t, under a constant load (N):
    h^q = h0^q + t exp(log_growth()), with q of norton_power()."""
    power = norton_power(exponent, radius, half_angle)
    growth = log_growth(load, creep_stress, creep_rate, exponent, radius=radius, half_angle=half_angle)
    with np.errstate(divide="ignore"):  # of times and depths that are 0
        return np.exp(np.logaddexp(power * np.log(start_depth), growth + np.log(np.asarray(t, float))) / power)


def norton_cone(t, load, half_angle, creep_stress, creep_rate, exponent, start_depth=0.0):
    """Returns the depth (m) of a cone, half_angle in degrees from the axis, at times t (s) under a constant load (N); see
    norton_depth()."""
    return norton_depth(t, load, creep_stress, creep_rate, exponent, start_depth, half_angle=half_angle)


def norton_ball(t, load, radius, creep_stress, creep_rate, exponent, start_depth=0.0):
    """Returns the depth (m) of a ball, radius in m, at times t (s) under a constant load (N); see norton_depth()."""
    return norton_depth(t, load, creep_stress, creep_rate, exponent, start_depth, radius=radius)


def norton_pressure(depth_rate, contact_radius, creep_stress, creep_rate, exponent):
    """Returns the mean pressure (Pa) of a tip of any shape that goes in at depth_rate (m/s): F s0 (dh/dt/(a a0))^(1/n), with the
    radius a (m) of the contact."""
    constraint = norton_factors(exponent)[0]
    return constraint * creep_stress * (np.asarray(depth_rate, float) / (np.asarray(contact_radius, float) * creep_rate)) ** (1 / exponent)


def norton_ball_pressure(depth_rate, depth, radius, creep_stress, creep_rate, exponent):
    """Returns the mean pressure (Pa) under a ball of a radius (m) at a depth (m) and a depth_rate (m/s), with a^2 = 2 c2 R h."""
    contact_radius = np.sqrt(2 * norton_factors(exponent)[2] * radius * np.asarray(depth, float))
    return norton_pressure(depth_rate, contact_radius, creep_stress, creep_rate, exponent)
