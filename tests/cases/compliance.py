"""What the grid of material points misses of a half space's compliance, and the constant c of contact that gives it back.

A pressure cos kx moves a half space's surface by 2/(E* k). Through hats, and seen through hats, the grid shows sinc(kh/2)^4 times
the compliance of its nodes, found here from the weights of undeformed points, four in a cell, layer by layer. Contact adds
c (1 - Pi(k)), Pi = sinc(kh/2)^4 in each direction (docs/contact.md)."""
import re

import numpy
import pytest

import harness

E, NU = 1.0, 0.3
LAME, MU, E_STAR = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU), E / (1 - NU**2)
SOURCE = (harness.ROOT / "src" / "contact" / "segment_problem.cpp").read_text()
IN_PLANE, IN_SPACE = (float(re.search(rf"{name} = ([0-9.]+)", SOURCE)[1]) for name in ("kInPlane", "kInSpace"))  # of h/E*


def weight(d, l=0.25):
    """cpGIMP's weight of a node at a distance and its derivative, in cells, for points of half size l (docs/method.md, Eq. 6)."""
    a = abs(d)
    if a < l:
        return 1 - (a * a + l * l) / (2 * l), -d / l
    if a < 1 - l:
        return 1 - a, -numpy.sign(d)
    if a < 1 + l:
        return (1 + l - a) ** 2 / (4 * l), -numpy.sign(d) * (1 + l - a) / (2 * l)
    return 0.0, 0.0


def node_compliance(waves, axis=-1, depth=20):
    """Motion along an axis of the surface's nodes under forces along it, exp(i waves.j), on a body of so many layers of unit cells."""
    dim = len(waves) + 1
    stiffness = numpy.zeros((depth, depth, dim, dim), complex)
    for layer, place in ((layer, place) for layer in range(depth) for place in numpy.ndindex(*(2,) * dim)):
        x = numpy.array(place) / 2 + 0.25
        along = [numpy.sum([numpy.exp(1j * wave * j) * numpy.array(weight(at - j)) for j in range(-2, 4)], axis=0)
                 for at, wave in zip(x, waves)]
        gradients = {}
        for m in range(max(0, layer - 1), min(depth, layer + 3)):  # a node's layer is that many cells below the surface
            value, slope = weight(x[-1] - 1 - layer + m)
            parts = [*along, (value, slope)]
            gradients[m] = numpy.array([numpy.prod([part[int(a == b)] for b, part in enumerate(parts)]) for a in range(dim)])
        for m, one in gradients.items():
            for n, other in gradients.items():
                turned = numpy.conj(one)
                stiffness[m, n] += 0.5**dim * (LAME * numpy.outer(turned, other) + MU * (turned @ other * numpy.eye(dim) + numpy.outer(other, turned)))
    force = numpy.zeros(depth * dim, complex)
    force[axis % dim] = 1
    return numpy.linalg.solve(stiffness.transpose(0, 2, 1, 3).reshape(depth * dim, -1), force)[axis % dim].real


def lacking(kh, direction, axis=-1):
    """(what the grid lacks over h/E*, 1 - Pi) for a wave along a direction, of pressures or of tractions along it (axis 0)."""
    waves = kh * numpy.array(direction)
    shown = numpy.prod(numpy.sinc(waves / 2 / numpy.pi)) ** 4
    wrapped = [max(abs((wave + numpy.pi) % (2 * numpy.pi) - numpy.pi), 1e-3) if wave else 0.0 for wave in waves]
    return 2 / kh - E_STAR * shown * node_compliance(wrapped, axis), 1 - shown


@pytest.mark.parametrize("kh, tolerance", [(2.4, 0.2), (3.14, 0.15), (4, 0.15), (5, 0.15)])
def test_compliance_in_the_plane(expect, kh, tolerance):
    missing, beyond = lacking(kh, [1.0])
    expect(f"k h {kh}: c (1 - Pi) over what the grid lacks", IN_PLANE * beyond / missing, near=1, tolerance=tolerance)


def test_mean_compliance(expect):
    """Over the waves that segments carry and columns do not, from a cell to two and a half cells long."""
    figures = [lacking(kh, [1.0]) for kh in numpy.linspace(2.4, 6, 10)]
    expect("plane: c over the mean constant", IN_PLANE / numpy.mean([missing / beyond for missing, beyond in figures]), near=1, tolerance=0.03)
    turns = numpy.radians([0, 22.5, 45])  # of all directions by symmetry, the ends half
    means = [numpy.mean([missing / beyond for missing, beyond in (lacking(kh, [numpy.cos(turn), numpy.sin(turn)]) for kh in (2.4, 3.3, 4.2, 5.1, 6))])
             for turn in turns]
    expect("space: c over the mean constant", IN_SPACE / numpy.average(means, weights=[0.5, 1, 0.5]), near=1, tolerance=0.1)


def test_compliance_to_tractions(expect):
    """A traction cos kx along the surface moves a half space by 2/(E* k) along it too, of which the grid shows somewhat less."""
    figures = [lacking(kh, [1.0], axis=0) for kh in numpy.linspace(2.4, 6, 10)]
    expect("plane: c over the mean constant", IN_PLANE / numpy.mean([missing / beyond for missing, beyond in figures]), near=1, tolerance=0.15)
