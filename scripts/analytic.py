"""Exact solutions to compare with, independent of the program. All values are SI, all functions vectorised.

Plane strain but for crystals; tension is positive; positions are those of the reference configuration.
"""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

sys.path.insert(0, str(Path(__file__).resolve().parent))  # python3 -I leaves it out
import command  # first, as it says in one line where there is no numpy

import numpy as np


def lame_constants(youngs_modulus, poissons_ratio):
    """Returns Lame's lambda and mu (Pa)."""
    mu = youngs_modulus / (2 * (1 + poissons_ratio))
    return 2 * mu * poissons_ratio / (1 - 2 * poissons_ratio), mu


def plane_strain_modulus(youngs_modulus, poissons_ratio):
    """Returns E* = E/(1 - nu^2) (Pa), the contact modulus against a rigid indenter."""
    return youngs_modulus / (1 - poissons_ratio**2)


def confined_modulus(youngs_modulus, poissons_ratio):
    """Returns M = lambda + 2 mu (Pa), the stiffness of a bar that cannot move sideways; its c^2 is M/rho."""
    lam, mu = lame_constants(youngs_modulus, poissons_ratio)
    return lam + 2 * mu


def neo_hookean_stress(F, youngs_modulus, poissons_ratio):
    """Returns the Cauchy stress sigma = (mu/J)(B - I) + (lambda ln J / J) I, array [...][2][2] in Pa.

    F [...][2][2] is the deformation gradient in the plane; the stretch out of it is 1 (plane strain).
    """
    lam, mu = lame_constants(youngs_modulus, poissons_ratio)
    J = np.linalg.det(F)[..., None, None]
    B = F @ np.swapaxes(F, -1, -2)
    return (mu * (B - np.eye(2)) + lam * np.log(J) * np.eye(2)) / J


@dataclass(frozen=True)
class ManufacturedSolution:
    """The axis-aligned displacement of a unit square on rollers, and the body force that makes it exact.

    u_i = A sin(2 pi X_i) sin(c pi t + phase_i), phase = (0, pi), c = sqrt(E/rho0); neo-Hookean material.
    Source: Wallstedt & Guilkey, J. Comput. Phys. 227 (2008) 9628, 'axis-aligned displacement'.
    """

    amplitude: float = 0.05  # A, m
    youngs_modulus: float = 1e7  # Pa
    poissons_ratio: float = 0.3
    density: float = 1000.0  # rho0, kg/m3

    @property
    def wave_speed(self):
        """c = sqrt(E/rho0) in m/s; the period is 2/c seconds."""
        return np.sqrt(self.youngs_modulus / self.density)

    def _swing(self, t):
        """Returns sin(c pi t + phase) of both directions, array [...][2], for times t [...] in s."""
        return np.sin(self.wave_speed * np.pi * np.asarray(t)[..., None] + np.array([0, np.pi]))

    def displacement(self, X, t):
        """Returns u, array [...][2] in m, at reference positions X [...][2] in m and times t [...] in s."""
        return self.amplitude * np.sin(2 * np.pi * np.asarray(X)) * self._swing(t)

    def velocity(self, X, t):
        """Returns du/dt, array [...][2] in m/s; arguments as for displacement."""
        quarter_later = np.asarray(t) + 0.5 / self.wave_speed
        return self.wave_speed * np.pi * self.displacement(X, quarter_later)

    def stretches(self, X, t):
        """Returns the deformation gradient's diagonal (F_xx, F_yy), array [...][2]; all else is 0."""
        return 1 + 2 * np.pi * self.amplitude * np.cos(2 * np.pi * np.asarray(X)) * self._swing(t)

    def body_acceleration(self, X, t):
        """Returns the body force per mass b, array [...][2] in m/s2, of the point with reference place X."""
        lam, mu = lame_constants(self.youngs_modulus, self.poissons_ratio)
        F = self.stretches(X, t)
        log_J = np.log(F.prod(axis=-1, keepdims=True))
        stiffness = 4 * mu - 4 * (lam * (log_J - 1) - mu) / F**2
        return np.pi**2 * self.displacement(X, t) * (stiffness / self.density - self.wave_speed**2)


@dataclass(frozen=True)
class VibratingBar:
    """The first mode of a linear elastic bar, fixed at x = 0 and free at x = L, that starts undeformed.

    u = (V/w) sin(pi x/2L) sin(w t) with w = pi c/2L. Source: separation of variables in the wave equation.
    """

    length: float  # L, m
    wave_speed: float  # c, m/s
    peak_velocity: float  # V, m/s

    @property
    def angular_frequency(self):
        """w in 1/s."""
        return np.pi * self.wave_speed / (2 * self.length)

    def displacement(self, x, t):
        """Returns u in m at positions x (m) and times t (s), which broadcast."""
        w = self.angular_frequency
        return self.peak_velocity / w * np.sin(np.pi * x / (2 * self.length)) * np.sin(w * t)

    def velocity(self, x, t):
        """Returns v in m/s; arguments as for displacement."""
        return self.peak_velocity * np.sin(np.pi * x / (2 * self.length)) * np.cos(self.angular_frequency * t)


@dataclass(frozen=True)
class RampedBar:
    """A linear elastic bar at rest, fixed at x = 0 and pulled at x = L by p min(t/t_r, 1).

    Source: d'Alembert. The wave that the end sends out, reflected with its sign kept at the fixed end and
    turned at the loaded one, comes from images at distances (2n + 1)L -+ x, with the signs (-1)^n.
    """

    length: float  # L, m
    wave_speed: float  # c, m/s
    modulus: float  # M, Pa
    traction: float  # p, Pa, positive pulls
    rise_time: float  # t_r, s

    def ramp(self, t):
        """Returns the traction in Pa at times t (s); 0 before t = 0."""
        return self.traction * np.clip(t / self.rise_time, 0, 1)

    def impulse(self, t):
        """Returns the traction's integral over time up to t, in Pa s."""
        rising = np.clip(t, 0, self.rise_time)
        return self.traction * (rising**2 / (2 * self.rise_time) + np.maximum(t - self.rise_time, 0))

    def _images(self, x, t):
        """Yields sign, and the times (s) since the waves travelling to -x and to +x left, for each image."""
        last = int(np.ceil(self.wave_speed * np.max(t) / (2 * self.length))) + 1
        for n in range(last):
            odd = (2 * n + 1) * self.length
            yield (-1) ** n, t - (odd - x) / self.wave_speed, t - (odd + x) / self.wave_speed

    def stress(self, x, t):
        """Returns the axial stress in Pa at positions x (m) and times t (s), which broadcast."""
        return sum(sign * (self.ramp(t1) + self.ramp(t2)) for sign, t1, t2 in self._images(x, t))

    def displacement(self, x, t):
        """Returns u in m; arguments as for stress."""
        scale = self.wave_speed / self.modulus
        images = self._images(x, t)
        return scale * sum(sign * (self.impulse(t1) - self.impulse(t2)) for sign, t1, t2 in images)

    def velocity(self, x, t):
        """Returns v in m/s; arguments as for stress."""
        scale = self.wave_speed / self.modulus
        return scale * sum(sign * (self.ramp(t1) - self.ramp(t2)) for sign, t1, t2 in self._images(x, t))

    def end_displacement(self, t):
        """Returns u(L, t) in m at times t (s)."""
        return self.displacement(self.length, t)


@dataclass(frozen=True)
class HalfPlaneContact:
    """Frictionless contact of a rigid indenter, symmetric about x = 0, with the elastic half-plane y < 0.

    Both halves of the model are counted: `load` is twice that of a half model, per thickness.
    Depth has no value of its own (it is logarithmic in the block's size): compare loads at equal half-widths.
    Source: K.L. Johnson, Contact Mechanics (1985), sections 2.7, 4.2 and 5.2.
    """

    half_width: float  # a, m
    load: float  # P, N/m
    pressure_inside: Callable  # p(x), Pa, for |x| < a

    def pressure(self, x):
        """Returns the pressure p in Pa at surface positions x (m); 0 outside the contact."""
        inside = np.abs(x) < self.half_width
        return np.where(inside, self.pressure_inside(np.where(inside, x, self.half_width / 2)), 0)

    def axis_stress(self, y):
        """Returns sigma_xx and sigma_yy in Pa on the axis, at (0, y) for y (m) < 0.

        Integrates Flamant's solution for a line load over p(x); sigma_xy is 0 there by symmetry and
        sigma_zz = nu (sigma_xx + sigma_yy).
        """
        x, weights = self._quadrature()
        force = 2 * self.pressure_inside(x) * weights
        depth = -np.asarray(y, float)[..., None]
        line_load = -2 / np.pi * depth / (depth**2 + x**2) ** 2
        return (line_load * x**2) @ force, (line_load * depth**2) @ force

    def _quadrature(self):
        """Returns positions 0 < x < a (m) and weights (m) of a rule for edge and centre singularities.

        x = a sin(theta) takes away a square root at the edge; Gauss points on intervals of theta that halve
        towards 0 resolve a logarithm at the centre, and the kernel's peak there at depths down to 1e-6 a.
        """
        nodes, weights = np.polynomial.legendre.leggauss(20)
        ends = np.pi / 2 * np.append(0, 2.0 ** np.arange(-40, 1))
        middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
        theta = (middle[:, None] + half[:, None] * nodes).ravel()
        width = (half[:, None] * weights).ravel()
        return self.half_width * np.sin(theta), self.half_width * np.cos(theta) * width


def cylinder_contact(half_width, modulus, radius):
    """Returns Hertz's line contact: P = pi E* a^2/4R, p = (E* a/2R) sqrt(1 - x^2/a^2).

    half_width a (m), modulus E* (Pa), radius R (m).
    """
    peak = modulus * half_width / (2 * radius)
    return HalfPlaneContact(half_width, np.pi / 2 * peak * half_width,
                            lambda x: peak * np.sqrt(1 - (x / half_width) ** 2))


def wedge_contact(half_width, modulus, slope):
    """Returns the contact of a blunt wedge: P = E* a tan b, p = (E* tan b/pi) arccosh(a/|x|).

    half_width a (m), modulus E* (Pa), slope = tan b with b the angle from the surface to the wedge's face.
    """
    return HalfPlaneContact(half_width, modulus * half_width * slope,
                            lambda x: modulus * slope / np.pi * np.arccosh(half_width / np.abs(x)))


def flat_punch_contact(half_width, load):
    """Returns the contact of a flat punch: p = P/(pi sqrt(a^2 - x^2)), for half_width a (m), load P (N/m)."""
    return HalfPlaneContact(half_width, load,
                            lambda x: load / (np.pi * np.sqrt(half_width**2 - x**2)))


VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]


def stiffness_tensor(constants):
    """Returns C_ijkl, array [3][3][3][3], of the constants of a crystal in the order of -NAME_elastic_constants (3, 5, 6 or 9)."""
    c, C = list(constants), np.zeros((6, 6))
    if len(c) == 9:
        normal, shear = [[c[0], c[3], c[4]], [c[3], c[1], c[5]], [c[4], c[5], c[2]]], c[6:]
    else:
        c11, c12, c13, c33, c44 = c[:5] if len(c) > 3 else [c[0], c[1], c[1], c[0], c[2]]
        normal = [[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]]
        shear = [c44, c44, c44 if len(c) == 3 else (c11 - c12) / 2]
    C[:3, :3], C[range(3, 6), range(3, 6)] = normal, shear
    if len(c) == 6:
        C[0, 3] = C[3, 0] = C[4, 5] = C[5, 4] = c[5]
        C[1, 3] = C[3, 1] = -c[5]
    place = {pair: k for k, (i, j) in enumerate(VOIGT) for pair in ((i, j), (j, i))}
    return np.array([[[[C[place[i, j], place[k, l]] for l in range(3)] for k in range(3)] for j in range(3)] for i in range(3)])


def indentation_modulus(C, normal, directions=180):
    """Returns the modulus M by which an anisotropic half space yields to a round rigid tip: P = 2 M a h under a flat punch.

    C_ijkl [3][3][3][3]; normal [3] of the surface. A force on the surface moves it at a distance r in the direction t by
    n L(t)^-1 n/(2 pi r), with L(t) = int_0^2pi [(mm) - (mp)(pp)^-1(pm)] dphi/(2 pi), m and p at right angles to t and to each
    other, (ab)_jk = a_i C_ijkl b_l; M = 2/mean(n L^-1 n) over t, E/(1 - nu^2) of isotropic bodies. Exact where the contact is
    round. Source: Barnett & Lothe, Phys. Norv. 8 (1975) 13; Vlassak & Nix, J. Mech. Phys. Solids 42 (1994) 1223.
    """
    n = np.array(normal, float) / np.linalg.norm(normal)
    e1 = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(n, e1)
    angle = np.pi * np.arange(directions) / directions
    across = np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2  # at right angles to t
    c, s = np.cos(angle)[None, :, None], np.sin(angle)[None, :, None]
    m, p = c * across[:, None] + s * n, c * n - s * across[:, None]

    def product(a, b):
        return np.einsum("xyi,ijkl,xyl->xyjk", a, C, b, optimize=True)

    L = np.mean(product(m, m) - product(m, p) @ np.linalg.inv(product(p, p)) @ product(p, m), axis=1)
    return 2 / np.mean(np.einsum("i,xij,j->x", n, np.linalg.inv(L), n))


def hexagonal_indentation_modulus(C11, C12, C13, C33, C44):
    """Returns M on the basal plane of a hexagonal crystal. Source: Delafargue & Ulm, Int. J. Solids Struct. 41 (2004) 7351."""
    return 2 * np.sqrt((C11 * C33 - C13**2) / C11 / (1 / C44 + 2 / (np.sqrt(C11 * C33) + C13)))
