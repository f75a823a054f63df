#!/usr/bin/env python3
"""The first 200 nm of the wedge at 20 m/s by explicit finite elements, to judge early contact by.

usage: wedge_touch.py ELEMENT_NM ...       e.g. 62.5 31.25 15.625: 15 s, 1 min, 5 min

Bilinear elements with 2 x 2 points, total Lagrangian, lumped masses, the neo-Hookean law, half of the block mirrored at the axis;
elements grow away from the tip. Nodes that would come into the wedge are put on its face in each step, without friction. Until
waves come back from the sides, which they do at 190 nm, nothing but the depth has a length: P/d is constant in the continuum.
"""
import sys
import time

import numpy

E, POISSON, DENSITY, HALF_ANGLE, SPEED, DEPTH = 70e9, 0.33, 2700.0, 70.3, 20.0, 205e-9
LAMBDA, MU = E * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)), E / (2 * (1 + POISSON))
WAVE = numpy.sqrt((LAMBDA + 2 * MU) / DENSITY)
COURANT, AVERAGED, THICKNESS = 0.33, 50, 1e-6  # of a step; steps of a mean load; m


def axis(h, fine, length, growth=1.1, largest=1e-6):
    """Nodes from 0 to `length`: a distance of h up to `fine`, growing beyond."""
    x, step = list(numpy.arange(round(fine / h) + 1) * h), h
    while x[-1] < length:
        step = min(step * growth, largest)
        x.append(x[-1] + step)
    x, n = numpy.array(x), round(fine / h)
    x[n:] = x[n] + (x[n:] - x[n]) * (length - x[n]) / (x[-1] - x[n])
    return x


class Block:
    """Elements, slopes [point][node][axis] and weights of their points, masses of nodes."""

    def __init__(self, h):
        x, y = axis(h, 1e-6, 30e-6), -axis(h, 0.6e-6, 40e-6)[::-1]
        self.X = numpy.array(numpy.meshgrid(x, y, indexing="ij")).reshape(2, -1).T.copy()
        number = numpy.arange(len(self.X)).reshape(len(x), len(y))
        corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        elements = numpy.stack([c.ravel() for c in corners], 1)
        sizes = [s.ravel() for s in numpy.meshgrid(numpy.diff(x), numpy.diff(y), indexing="ij")]
        low, high = 0.5 - 0.5 / numpy.sqrt(3), 0.5 + 0.5 / numpy.sqrt(3)
        slopes = [numpy.stack([numpy.array([-(1 - t), 1 - t, t, -t]) / sizes[0][:, None], numpy.array([-(1 - s), -s, s, 1 - s]) / sizes[1][:, None]], 2)
                  for s, t in ((low, low), (high, low), (high, high), (low, high))]
        self.nodes, self.slopes = numpy.tile(elements, (4, 1)), numpy.concatenate(slopes)
        self.weights = numpy.tile(sizes[0] * sizes[1] / 4, 4)
        self.mass = numpy.bincount(elements.ravel(), numpy.repeat(DENSITY * sizes[0] * sizes[1] / 4, 4), len(self.X))
        self.axis, self.bottom, top = number[0], number[:, 0], number[:, -1]
        self.surface = top[x < 1.2e-6]

    def forces(self, u):
        """Inner forces of nodes: P = mu (F - F^-T) + lambda ln J F^-T."""
        F = numpy.eye(2) + numpy.einsum("pna,pnb->pab", u[self.nodes], self.slopes)
        J = numpy.linalg.det(F)
        cofactor = numpy.stack([F[:, 1, 1], -F[:, 1, 0], -F[:, 0, 1], F[:, 0, 0]], 1).reshape(-1, 2, 2)
        P = MU * F + ((LAMBDA * numpy.log(J) - MU) / J)[:, None, None] * cofactor
        shares = -numpy.einsum("pab,pnb->pna", P, self.slopes) * self.weights[:, None, None]
        return numpy.stack([numpy.bincount(self.nodes.ravel(), shares[:, :, a].ravel(), len(u)) for a in range(2)], 1)


def press(block, h):
    """(depths, mean loads) of half the block, 1 m thick."""
    slope = 1 / numpy.tan(numpy.radians(HALF_ANGLE))
    normal = numpy.tile(numpy.array([slope, -1]) / numpy.sqrt(1 + slope**2), (len(block.surface), 1))
    normal[0] = 0, -1  # on the axis
    u, v = numpy.zeros_like(block.X), numpy.zeros_like(block.X)
    dt, now, loads, rows = COURANT * h / WAVE, 0.0, [], []
    while SPEED * now < DEPTH:
        v += dt * block.forces(u) / block.mass[:, None]
        v[block.axis, 0] = v[block.bottom, 1] = 0
        x = block.X[block.surface] + u[block.surface] + dt * v[block.surface]
        depth = numpy.maximum(x[:, 1] - (slope * x[:, 0] - SPEED * (now + dt)), 0)  # of nodes below the face, along y
        push = (depth * -normal[:, 1])[:, None] * normal / dt
        v[block.surface] += push
        loads.append(-numpy.sum(block.mass[block.surface] * push[:, 1]) / dt)
        u += dt * v
        now += dt
        if len(loads) == AVERAGED:
            rows.append((SPEED * (now - AVERAGED / 2 * dt), numpy.mean(loads)))
            loads = []
    return numpy.array(rows).T


if __name__ == "__main__":
    for nanometres in map(float, sys.argv[1:]):
        start = time.time()
        depth, load = press(Block(nanometres * 1e-9), nanometres * 1e-9)
        slope = THICKNESS * (load / depth)[(depth > 60e-9) & (depth < 190e-9)]
        print(f"{nanometres:g} nm: P/d of half, kN/m, from 60 to 190 nm: {numpy.mean(slope) / 1e3:.3f}, of parts {numpy.std(slope) / 1e3:.3f} "
              f"({time.time() - start:.0f} s)", flush=True)
