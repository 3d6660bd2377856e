"""Closed smooth curve through given points: a periodic spline of fifth degree, so that its curvature is smooth too.

Its parameter is the length of the chords from point to point. Through n even points of a smooth curve it is off by the
sixth power of their distance, its curvature by the fourth.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry._crossing import crossing
from tisph.geometry._shape import ClosedCurve, Foot, Side, check_side, evenly

DEGREE = 5
SAMPLES = 16
"""Of a piece between two points, where nearest points are looked for and crossings are."""

NEWTON_STEPS = 50
"""At most; from a sample next to the nearest point 4 or 5 do, save near a centre of curvature."""


@dataclass(frozen=True)
class Spline(ClosedCurve):
    """The smooth closed curve through ``points`` (k, 2), in either order; the last is followed by the first.

    ValueError where there are fewer than three points, two that follow each other coincide, or the curve meets itself.
    """

    points: tuple[tuple[float, float], ...]
    liquid: Side = "outside"

    def __post_init__(self):
        check_side(self.liquid)
        points = np.array(self.points, dtype=float)
        if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3:
            raise ValueError(f"a curve needs three points (x, y) or more, not {len(points)}")
        if not np.isfinite(points).all():
            raise ValueError("the points of a curve must be finite")
        if not (np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1) > 0).all():
            raise ValueError("points of a curve that follow each other must be two places (the last is not the first)")
        object.__setattr__(self, "points", tuple(map(tuple, points.tolist())))
        place = crossing(self._samples[1])
        if place is not None:
            x, y = place
            raise ValueError(f"the curve meets itself near ({x:.6g}, {y:.6g}): give points in order, or more of them")
        if self._area < 0:
            object.__setattr__(self, "points", self.points[::-1])
            for name in ("_knots", "_curve", "_samples", "_nodes", "_arc"):
                self.__dict__.pop(name, None)

    @property
    def length(self):
        """Perimeter."""
        return float(self._arc[-1])

    @property
    def extent(self):
        """Lowest and highest corner (2, 2) of the box around samples of the curve."""
        places = self._samples[1]
        return np.stack([places.min(axis=0), places.max(axis=0)])

    @property
    def smallest_radius(self):
        """Smallest radius of curvature of samples of the curve."""
        return float(1 / np.abs(self._normals(self._samples[0])[1]).max())

    @property
    def _area(self):
        parameter, weight = self._nodes
        place, slope = self._curve(parameter), self._curve(parameter, 1)
        return float(0.5 * np.sum(weight * _cross(place, slope)))

    @cached_property
    def _knots(self):
        closed = np.array([*self.points, self.points[0]])
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])

    @cached_property
    def _curve(self):
        """The spline: places (n, 2) of parameters (n,), and their derivatives."""
        from scipy.interpolate import make_interp_spline

        closed = np.array([*self.points, self.points[0]])
        return make_interp_spline(self._knots, closed, k=DEGREE, bc_type="periodic")

    @cached_property
    def _samples(self):
        """Parameters (m,) and places (m, 2), ``SAMPLES`` from each point to the next."""
        parts = np.arange(SAMPLES) / SAMPLES
        parameter = (self._knots[:-1, None] + parts * np.diff(self._knots)[:, None]).ravel()
        return parameter, self._curve(parameter)

    @cached_property
    def _nodes(self):
        """Parameters and weights (k, 16) of Gauss and Legendre between the points."""
        node, weight = np.polynomial.legendre.leggauss(SAMPLES)
        half = 0.5 * np.diff(self._knots)[:, None]
        return self._knots[:-1, None] + half * (1 + node), half * weight

    @cached_property
    def _arc(self):
        """Arc length (k + 1,) up to the points."""
        parameter, weight = self._nodes
        speed = np.linalg.norm(self._curve(parameter, 1), axis=-1)
        return np.concatenate([[0.0], np.cumsum(np.sum(weight * speed, axis=1))])

    def _normals(self, parameter):
        """Return normals (n, 2) for liquid outside and curvatures (n,) at parameters (n,)."""
        slope, bend = self._curve(parameter, 1), self._curve(parameter, 2)
        speed = np.linalg.norm(slope, axis=-1)
        return slope[..., ::-1] * [1.0, -1.0] / speed[..., None], _cross(slope, bend) / speed**3

    def _nearest(self, points):
        parameter = self._nearest_parameter(points)
        point, (normal, curvature) = self._curve(parameter), self._normals(parameter)
        distance = np.sum((points - point) * normal, axis=1)
        return Foot(point, normal, curvature, distance)

    def _nearest_parameter(self, points):
        """Newton's method for (c - p).c' = 0 from the nearest sample, and never past the samples next to it."""
        from scipy.spatial import cKDTree

        samples, period = self._samples[0], self._knots[-1]
        start = cKDTree(self._samples[1]).query(points)[1]
        closed = np.concatenate([[samples[-1] - period], samples, [period]])
        parameter, low, high = samples[start], closed[start], closed[start + 2]
        left = np.arange(len(points))
        for _ in range(NEWTON_STEPS):
            here = parameter[left]
            away, slope = self._curve(here % period) - points[left], self._curve(here % period, 1)
            squared = np.sum(slope**2, axis=1)
            change = squared + np.sum(away * self._curve(here % period, 2), axis=1)
            step = -np.sum(away * slope, axis=1) / np.where(change > 0.1 * squared, change, squared)
            parameter[left] = np.clip(here + step, low[left], high[left])
            left = left[np.abs(parameter[left] - here) > 1e-13 * period]
            if not len(left):
                break
        return parameter % period

    def _spread(self, spacing):
        along = evenly(self.length, spacing, least=3)
        parameter = self._parameter(along)
        normal, curvature = self._normals(parameter)
        return self._curve(parameter), normal, curvature, np.full(len(along), self.length / len(along))

    def _parameter(self, along):
        """Parameters at arc lengths ``along`` (n,), by Newton's method with the arc length inside a piece by Gauss."""
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


def _cross(one, other):
    """Return the cross products (...) of vectors (..., 2)."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
