"""The search of a fit: least squares over few runs, whose results are replaced by a smooth surface through those that are known.

Each residual is a polynomial of second order in the constants' logarithms x, by least squares over all runs, with little weight for
those far away and a penalty on the second order, so that few runs give slopes and many give curvatures, as in the search without
derivatives of Powell (Math. Program. 100 (2004) 183) and Cartis and Roberts (Math. Program. Comput. 11 (2019) 631). The sum of squares of
the surface is least within a region around the best run; there the next run is made.
"""

from collections import namedtuple

import numpy as np
from scipy.optimize import least_squares

FIRST = 0.1  # of a logarithm: how far the first runs lie from the guess; slopes of curves with waves need that much
REGION = 0.5  # of a logarithm: how far the next run may lie at first; the surface of the first runs is a plane
GROWS, SHRINKS = 1.6, 0.5  # of the region after a step to its edge that is better, and of a step that is worse, which the region becomes
EXACT = 0.03  # of the third order at the region's edge: what a run that is the centre may be missed by
STRAIGHT = 1e-2  # weight of the penalty on curvatures over that of a residual: runs waver by a tenth of what a curvature adds in the region
LINEAR = 1e-8  # the same on slopes, which keeps the equations regular alone
NEAR = 0.3  # of a standard error: a step less than that ends the search; squares add, so that it would make errors larger by 4 %
CLOSE = 1e-4  # of a logarithm: the same where all is exact
ROUGH = 1e-2  # of a logarithm: a smaller region ends the search, as waves of the runs decide there which one is better
ALONG = 0.05, 0.25  # of a logarithm: how far the last runs lie along the axes of the error's ellipsoid, of which it is two standard errors
LEAST_FACTOR = 1e-2  # of the errors by noise: less is left by rounding alone

Solution = namedtuple("Solution", "x residuals slopes covariance")
Solution.__doc__ = "What the surface says at a place x [n]: residuals [rows], their slopes [rows][n], and the covariance [n][n] of x."


class Surface:
    """Residuals over x from those of runs: polynomials of second order, exact as few runs allow, around a centre."""

    def __init__(self, places, residuals, centre, region):
        """places [runs][n], residuals [runs][rows], centre [n]; region: how far from it the surface is meant."""
        self.centre, self.region = centre, region
        near = (np.asarray(places) - centre) / region
        weights = 1 / (EXACT + np.linalg.norm(near, axis=1) ** 3)  # the third order, which is left out, grows so with the distance
        design = np.array([features(u) for u in near]) * weights[:, None]
        n = len(centre)
        penalty = np.sqrt(np.r_[0, np.full(n, LINEAR), np.full(design.shape[1] - 1 - n, STRAIGHT)])
        self.table = np.linalg.lstsq(np.vstack([design, np.diag(penalty)]),
                                     np.vstack([np.asarray(residuals) * weights[:, None], np.zeros((len(penalty), np.shape(residuals)[1]))]), rcond=None)[0]

    def residuals(self, x):
        """[rows] at x."""
        return features((x - self.centre) / self.region) @ self.table

    def slopes(self, x):
        """Derivatives [rows][n] of the residuals at x."""
        u, n = (x - self.centre) / self.region, len(x)
        first, second = np.triu_indices(n)
        by = np.zeros((n, self.table.shape[0]))
        by[:, 1:n + 1] = np.eye(n)
        for k in range(n):
            by[k, n + 1:] = (first == k) * u[second] + (second == k) * u[first]
        return (by @ self.table).T / self.region


def features(u):
    """The terms of a polynomial of second order of u [n]."""
    first, second = np.triu_indices(len(u))
    return np.concatenate([[1.0], u, u[first] * u[second]])


def solved(surface, start, limits, error):
    """Returns the x of least squares on a Surface, of residuals over their standard errors [rows], between limits (lower [n], upper [n])."""
    return least_squares(lambda x: surface.residuals(x) / error, np.clip(start, *limits), lambda x: surface.slopes(x) / error[:, None], limits).x


def covariance_of(slopes):
    """Returns the covariance [n][n] of constants by slopes [rows][n] of residuals over their standard errors."""
    return np.linalg.pinv(slopes.T @ slopes, rcond=1e-14, hermitian=True)


def errors_of(residuals, groups, error, unknowns):
    """Returns the standard errors [rows] that residuals have: the given ones, in each group by a factor, the root mean square over them;
    each residual has its part of the unknowns."""
    factor, share = np.empty(len(residuals)), 1 - unknowns / len(residuals)
    for group in groups:
        factor[group] = max(np.sqrt(np.mean((residuals[group] / error[group]) ** 2) / share), LEAST_FACTOR)
    return factor * error


class Search:
    """Goes from a first guess to the least sum of squares. evaluate(places) gives the residuals [places][rows] of runs."""

    def __init__(self, evaluate, lower, upper, groups, error):
        """lower, upper [n]: limits of x, which is 0 at the first guess; groups: slices of rows; error [rows]: that of the test's noise."""
        self.evaluate, self.limits, self.groups, self.error = evaluate, (lower, upper), groups, error
        self.places, self.known, self.region = [], [], REGION

    def add(self, places):
        """Makes runs at places, within the limits."""
        places = [np.clip(x, *self.limits) for x in places]
        self.places += places
        self.known += list(self.evaluate(places))

    def begin(self):
        """Makes the first runs, and returns the covariance [n][n] that the test will have, by its noise and their slopes."""
        n = len(self.limits[0])
        inside = np.where(FIRST < self.limits[1], FIRST, -FIRST)
        self.add([np.zeros(n), *np.diag(inside)])
        return covariance_of(Surface(self.places, self.known, self.places[0], REGION).slopes(self.places[0]) / self.error[:, None])

    def best(self):
        """The place with the least sum of squares of all runs."""
        return self.places[int(np.argmin([np.sum((residuals / self.error) ** 2) for residuals in self.known]))]

    def step(self):
        """Returns the Solution on the surface around the best run, within the region around it."""
        centre = self.best()
        surface = Surface(self.places, self.known, centre, max(self.region, FIRST))
        x = solved(surface, centre, (np.maximum(self.limits[0], centre - self.region), np.minimum(self.limits[1], centre + self.region)), self.error)
        slopes = surface.slopes(x)
        return Solution(x, surface.residuals(x), slopes, covariance_of(slopes / self.error[:, None]))

    def go(self, evaluations):
        """Makes at most so many steps, each of a run; returns the Solution and whether the search came to its end.

        Residuals count by the noise of the test until the search is there; then by what is left of them in each group, as of drift, or of
        what the case does not have.
        """
        looked, found = False, self.step()
        for _ in range(evaluations):
            if self.is_near(found, self.best()):
                if looked:
                    return found, True
                self.look_around(found)
                self.error, looked = errors_of(found.residuals, self.groups, self.error, len(found.x)), True
            else:
                self.follow(found)
            found = self.step()
        return found, False

    def follow(self, found):
        """Makes the run at a Solution, and gives the region another size by it."""
        before = self.best()
        self.add([found.x])
        step = np.abs(found.x - before).max()
        if self.best() is before:
            self.region = SHRINKS * step  # not of the region, or steps that waves make worse would go on until it is small
        elif step > 0.9 * self.region:
            self.region *= GROWS

    def is_near(self, found, place):
        """Whether a Solution is where a run is already, by its standard errors."""
        near = np.maximum(NEAR * np.sqrt(np.diag(found.covariance)), CLOSE)
        return self.region < ROUGH or bool(np.all(np.abs(found.x - place) <= near))

    def look_around(self, found):
        """Makes runs beside a Solution along the axes of its ellipsoid, for the slopes there."""
        lengths, axes = np.linalg.eigh(found.covariance)
        steps = np.clip(2 * np.sqrt(np.maximum(lengths, 0)), *ALONG)
        self.add([found.x + step * axis for step, axis in zip(steps, axes.T)])
        self.region = max(self.region, steps.max())
