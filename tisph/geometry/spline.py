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
"""Most iterations; 4 or 5 suffice from the nearest sample, except near a centre of curvature."""


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

    def _normals(self, parameter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return normals (n, 2) for fluid outside and curvatures (n,) at parameters (n,)."""
        slope, bend = self._curve(parameter, 1), self._curve(parameter, 2)
        speed = np.linalg.norm(slope, axis=-1)
        return slope[..., ::-1] * [1.0, -1.0] / speed[..., None], _cross(slope, bend) / speed**3

    def _nearest(self, points: np.ndarray) -> ClosestPoint:
        parameter = self._nearest_parameter(points)
        point, (normal, curvature) = self._curve(parameter), self._normals(parameter)
        distance = np.sum((points - point) * normal, axis=1)
        return ClosestPoint(point, normal, curvature, distance)

    def _nearest_parameter(self, points: np.ndarray) -> np.ndarray:
        """Solve (c - p).c' = 0 by Newton's method from the nearest sample, bisecting where it leaves its bracket."""
        parameter, low, high = self._nearest_sample(points)
        period = self._knots[-1]
        left = np.arange(len(points))
        for _ in range(NEWTON_STEPS):
            here = parameter[left]
            away, slope = self._curve(here % period) - points[left], self._curve(here % period, 1)
            value = np.sum(away * slope, axis=1)
            low[left], high[left] = np.where(value < 0, here, low[left]), np.where(value > 0, here, high[left])
            change = np.sum(slope**2 + away * self._curve(here % period, 2), axis=1)
            there = here - value / np.where(change > 0, change, np.inf)
            outside = (there <= low[left]) | (there >= high[left]) | (change <= 0)
            there = np.where(outside & (value != 0), 0.5 * (low[left] + high[left]), there)
            parameter[left] = there
            left = left[np.abs(there - here) > 1e-14 * period]
            if not len(left):
                break
        return parameter % period

    def _nearest_sample(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the parameters (n,) of the nearest sample of the nearest branch, and of the samples before and after.

        The nearest sample may lie on another branch of the curve; therefore the chords of four samples are compared.
        From the nearest chord the search goes to the sample that is nearer than its neighbours.
        """
        from scipy.spatial import cKDTree

        parameter, place = self._samples
        period, count = self._knots[-1], len(parameter)
        near = cKDTree(place).query(points, k=4)[1]
        first = np.concatenate([near - 1, near], axis=1) % count
        chord = np.roll(place, -1, axis=0) - place
        along = np.sum((points[:, None] - place[first]) * chord[first], axis=2) / np.sum(chord[first] ** 2, axis=2)
        away = points[:, None] - place[first] - np.clip(along, 0.0, 1.0)[..., None] * chord[first]
        sample = first[np.arange(len(points)), np.argmin(np.sum(away**2, axis=2), axis=1)]
        while True:
            around = (sample[:, None] + np.array([0, -1, 1])) % count
            nearer = np.argmin(np.sum((points[:, None] - place[around]) ** 2, axis=2), axis=1)
            if not nearer.any():
                break
            sample = around[np.arange(len(points)), nearer]
        closed = np.concatenate([[parameter[-1] - period], parameter, [period]])
        return closed[sample + 1], closed[sample], closed[sample + 2]

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


def _radius(curvature: float) -> float:
    """Return the radius of a ``curvature``, infinite for one of 0 or below."""
    return float(1 / curvature) if curvature > 0 else math.inf


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the cross products (...) of vectors (..., 2)."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
