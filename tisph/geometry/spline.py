"""Closed smooth curve through given points: a periodic spline of fifth degree, whose curvature is smooth, too.

Its parameter is the length of the chords from point to point. For evenly spaced points of a smooth curve the error
falls with the sixth power of their distance, the error of the curvature with the fourth.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tisph.geometry.shape import ClosedCurve, ClosestPoint, Side, check_side, checked_points, crossing, evenly

DEGREE = 5
SAMPLES = 16
"""Least number of samples between two points, for the search for closest points and crossings."""

LARGEST_TURN, HALVINGS = 0.2, 8
"""Largest turn [radians] from sample to sample, and most halvings of a piece to achieve it."""

NEWTON_STEPS = 60
"""Most iterations; 4 or 5 suffice, except near a centre of curvature."""


@dataclass(frozen=True)
class Spline(ClosedCurve):
    """The smooth closed curve through ``points`` (k, 2), in either order; the last is followed by the first.

    ValueError where there are fewer than three points, two that follow each other coincide, or the curve meets itself.
    """

    points: tuple[tuple[float, float], ...]
    fluid_side: Side = "outside"

    def __post_init__(self) -> None:
        check_side(self.fluid_side)
        points = checked_points(self.points, "curve", "points")
        if not (np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > 0).all():
            raise ValueError("points of a curve that follow each other must be two places (the last is not the first)")
        object.__setattr__(self, "points", tuple(map(tuple, points.tolist())))
        place = crossing(self._samples[1])
        if place is not None:
            x, y = place
            raise ValueError(f"the curve meets itself near ({x:.6g}, {y:.6g}): give points in order, or more of them")
        if self.area < 0:
            object.__setattr__(self, "points", self.points[::-1])
            for name in ("_knots", "_curve", "_samples", "_nodes", "_arc"):
                self.__dict__.pop(name, None)

    @property
    def length(self) -> float:
        """Perimeter."""
        return float(self._arc[-1])

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box around samples of the curve."""
        places = self._samples[1]
        return np.stack([places.min(axis=0), places.max(axis=0)])

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature of samples of the curve."""
        return _radius(np.abs(self._normals(self._samples[0])[1]).max())

    @property
    def convex_radius(self) -> float:
        """Smallest radius of curvature of samples where the curve bulges into the fluid."""
        return _radius((self._side * self._normals(self._samples[0])[1]).max())

    @property
    def area(self) -> float:
        """Enclosed area."""
        parameter, weight = self._nodes
        place, slope = self._curve(parameter), self._curve(parameter, 1)
        return float(0.5 * np.sum(weight * _cross(place, slope)))

    @cached_property
    def _knots(self) -> np.ndarray:
        closed = np.array([*self.points, self.points[0]])
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])

    @cached_property
    def _curve(self) -> Any:
        """The spline: places (n, 2) at parameters (n,), and their derivatives."""
        from scipy.interpolate import make_interp_spline

        closed = np.array([*self.points, self.points[0]])
        return make_interp_spline(self._knots, closed, k=DEGREE, bc_type="periodic")

    @cached_property
    def _samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Parameters (m,) and places (m, 2), closer together where the curve bends."""
        parts = np.arange(SAMPLES) / SAMPLES
        parameter = (self._knots[:-1, None] + parts * np.diff(self._knots)[:, None]).ravel()
        for _ in range(HALVINGS):
            closed = np.append(parameter, self._knots[-1])
            slope = self._curve(closed, 1) @ np.array([1.0, 1j])
            sharp = np.abs(np.angle(slope[1:] / slope[:-1])) > LARGEST_TURN
            parameter = np.sort(np.append(parameter, 0.5 * (closed[:-1] + closed[1:])[sharp]))
        return parameter, self._curve(parameter)

    @cached_property
    def _nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """Parameters and weights (k, 16) of Gauss and Legendre between the points."""
        node, weight = np.polynomial.legendre.leggauss(SAMPLES)
        half = 0.5 * np.diff(self._knots)[:, None]
        return self._knots[:-1, None] + half * (1 + node), half * weight

    @cached_property
    def _arc(self) -> np.ndarray:
        """Arc length (k + 1,) up to the points."""
        parameter, weight = self._nodes
        speed = np.linalg.norm(self._curve(parameter, 1), axis=-1)
        return np.concatenate([[0.0], np.cumsum(np.sum(weight * speed, axis=1))])

    @cached_property
    def _tree(self) -> Any:
        """Search tree of the samples."""
        from scipy.spatial import cKDTree

        return cKDTree(self._samples[1])

    @cached_property
    def _pieces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The polynomials from sample to sample: coefficients (6, m, 2), and half of each piece (m,).

        The place at a parameter t from the middle of a piece is the sum of coefficient k times t^k. And slopes (m, 2)
        of the curve at the samples.
        """
        start = self._samples[0]
        half = 0.5 * np.diff(start, append=self._knots[-1])
        powers = range(DEGREE + 1)
        coefficients = np.stack([self._curve(start + half, power) / math.factorial(power) for power in powers])
        return coefficients, half, self._curve(start, 1)

    def _normals(self, parameter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return normals (n, 2) for fluid outside and curvatures (n,) at parameters (n,)."""
        return _bent(self._curve(parameter, 1), self._curve(parameter, 2))

    def _nearest(self, points: np.ndarray) -> ClosestPoint:
        """Solve (c - p).c' = 0 by Newton's method on the piece with the solution, bisecting where it leaves that."""
        coefficients, halves, slopes = self._pieces
        sample = self._nearest_sample(points)
        beyond = _dot(points - self._samples[1][sample], slopes[sample]) < 0.0
        piece = (sample - beyond) % len(halves)
        half = 1.1 * halves[piece]  # a solution at a sample may be beyond it by round-off, iterates by more
        low, high, along, left = -half, half, np.zeros(len(points)), np.arange(len(points))
        for _ in range(NEWTON_STEPS):
            here = along[left]
            place, slope, bend = _derivatives(np.take(coefficients, piece[left], axis=1), here)
            away = place - points[left]
            value, change = _dot(away, slope), _dot(slope, slope) + _dot(away, bend)
            low[left], high[left] = np.where(value < 0, here, low[left]), np.where(value > 0, here, high[left])
            there = here - value / np.where(change > 0, change, np.inf)
            found = (change > 0) & (np.abs(there - here) <= 1e-14 * self._knots[-1])
            outside = ((there <= low[left]) | (there >= high[left]) | (change <= 0)) & ~found
            along[left] = np.where(outside, 0.5 * (low[left] + high[left]), there)
            left = left[~found]
            if not len(left):
                break
        place, slope, bend = _derivatives(np.take(coefficients, piece, axis=1), along)
        normal, curvature = _bent(slope, bend)
        return ClosestPoint(place, normal, curvature, _dot(points - place, normal))

    def _nearest_sample(self, points: np.ndarray) -> np.ndarray:
        """Return the numbers (n,) of the nearest sample of the nearest branch.

        The nearest sample may lie on another branch of the curve. Therefore, unless the four nearest samples follow
        each other, their chords are compared. From the nearest chord the search goes to the sample that is nearer than
        its neighbours.
        """
        place = self._samples[1]
        count = len(place)
        near = self._tree.query(points, k=4)[1]
        sample = near[:, 0]
        several = np.flatnonzero((np.abs((near - near[:, :1] + 3) % count - 3) > 3).any(axis=1))
        points, first = points[several], np.concatenate([near[several] - 1, near[several]], axis=1) % count
        chord = np.roll(place, -1, axis=0) - place
        along = np.sum((points[:, None] - place[first]) * chord[first], axis=2) / np.sum(chord[first] ** 2, axis=2)
        away = points[:, None] - place[first] - np.clip(along, 0.0, 1.0)[..., None] * chord[first]
        rows = np.arange(len(several))
        nearest = first[rows, np.argmin(np.sum(away**2, axis=2), axis=1)]
        nearer = np.ones(1)
        while nearer.any():
            around = (nearest[:, None] + np.array([0, -1, 1])) % count
            nearer = np.argmin(np.sum((points[:, None] - place[around]) ** 2, axis=2), axis=1)
            nearest = around[rows, nearer]
        sample[several] = nearest
        return sample

    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        along = evenly(self.length, spacing, least=3)
        parameter = self._parameter(along)
        normal, curvature = self._normals(parameter)
        return self._curve(parameter), normal, curvature, np.full(len(along), self.length / len(along))

    def _parameter(self, along: np.ndarray) -> np.ndarray:
        """Return parameters at arc lengths ``along`` (n,): Newton's method, with arc lengths by Gauss quadrature."""
        piece = np.searchsorted(self._arc, along, side="right") - 1
        first, size = self._knots[piece], np.diff(self._knots)[piece]
        parameter = first + size * (along - self._arc[piece]) / np.diff(self._arc)[piece]
        node, weight = np.polynomial.legendre.leggauss(SAMPLES)
        for _ in range(NEWTON_STEPS):
            half = 0.5 * (parameter - first)
            speeds = np.linalg.norm(self._curve(first[:, None] + half[:, None] * (1 + node), 1), axis=-1)
            missing = along - self._arc[piece] - half * (speeds @ weight)
            step = missing / np.linalg.norm(self._curve(parameter, 1), axis=1)
            parameter = parameter + step
            if np.abs(step).max() <= 1e-14 * self._knots[-1]:
                break
        return parameter


def _derivatives(coefficients: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return values, first and second derivatives (n, 2) at ``along`` (n,) of polynomials, ``coefficients`` (k, n, 2).

    By Horner's rule.
    """
    value, t = coefficients[-1], along[:, None]
    slope, bend = np.zeros_like(value), np.zeros_like(value)
    for coefficient in coefficients[-2::-1]:
        bend = bend * t + slope
        slope = slope * t + value
        value = value * t + coefficient
    return value, slope, 2.0 * bend


def _bent(slope: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return normals (n, 2) for fluid outside and curvatures (n,) for derivatives (n, 2) of a curve."""
    speed = np.linalg.norm(slope, axis=-1)
    return slope[..., ::-1] * [1.0, -1.0] / speed[..., None], _cross(slope, bend) / speed**3


def _radius(curvature: float) -> float:
    """Return the radius of a ``curvature``, infinite for one of 0 or below."""
    return float(1 / curvature) if curvature > 0 else math.inf


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the scalar products (n,) of vectors (n, 2)."""
    return np.einsum("ni,ni->n", one, other)


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the cross products (...) of vectors (..., 2)."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
