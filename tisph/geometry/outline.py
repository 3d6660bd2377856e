"""A wall from end to end of a channel: a polyline with corners rounded by arcs of one radius, or a smooth curve.

Both are computed as the middle part of a longer wall. A ``periodic`` wall is continued by its copies, a period before
and after it. Between open ends the first and last side of a polyline are continued straight, and a smooth curve by its
mirror images, so that it is level at its ends.

A polyline is a part of a polygon around the solid behind it. The other sides of the polygon are so far away that no
place in the channel is next to them.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tisph.geometry.polygon import Polygon, _Wall
from tisph.geometry.shape import Shape, checked_points, evenly
from tisph.geometry.spline import DEGREE, Spline

FAR = 100.0
"""Distance of the polygon's other sides from the wall, in extents of the wall."""

PIECES = 4000
"""Pieces of the wall from which its ``extent`` and its ``height`` are computed."""

LEVEL = 1e-12
"""Difference of the heights of both ends, over the length of the wall, up to which a wall is periodic."""


def _check_periodic(places: np.ndarray) -> None:
    """Raise ValueError where the last of the ``places`` (k, 2) is not as high as the first."""
    low, high = sorted(places[[0, -1], 1].tolist())
    if high - low > LEVEL * np.ptp(places[:, 0]):
        raise ValueError(f"both ends of a periodic wall must be at one height, not at y = {low:g} and {high:g}")


class EndToEnd(Shape):
    """A wall from one of its ``ends`` (2, 2) to the other, whose x rises or falls."""

    ends: Any

    @property
    def area(self) -> float:
        """Enclosed area: none, as of a line."""
        return 0.0

    @cached_property
    def _fine(self) -> np.ndarray:
        """Places (n, 2) on the wall from end to end, in the order of x."""
        first, last = self.ends
        points = np.array([first, *self.boundary_points(self.length / PIECES).point, last])
        return points if first[0] < last[0] else points[::-1]

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box around the wall."""
        return np.stack([self._fine.min(axis=0), self._fine.max(axis=0)])

    def height(self, x: np.ndarray) -> np.ndarray:
        """Return y (n,) of the wall at ``x`` (n,)."""
        return np.interp(x, *self._fine.T)


@dataclass(frozen=True)
class Outline(EndToEnd, Polygon):
    """The polyline through ``corners`` (k, 2), with the fluid on its left, its corners arcs of ``corner_radius``.

    It encloses no area. ValueError where x of a corner is not between the first and the last corner's, two corners
    coincide, sides cross, the arcs do not fit, or a ``periodic`` wall does not end as high as it begins.
    """

    periodic: bool = False

    def __post_init__(self) -> None:
        corners = np.array(self.corners, dtype=float)
        object.__setattr__(self, "corners", tuple(map(tuple, corners.tolist())))
        first, *between, last = corners[:, 0]
        if not all(min(first, last) < x < max(first, last) for x in between) or first == last:
            raise ValueError(f"all corners must be between the ends of the wall, x = {first:g} and {last:g}")
        if self.periodic:
            _check_periodic(corners)
        _ = self._wall  # ValueError where it is impossible

    @property
    def _own(self) -> slice:
        """Indices of this wall's corners in the polygon."""
        count = len(self.corners)
        first = count if self.periodic else 1
        return slice(first, first + count)

    @cached_property
    def _wall(self) -> _Wall:
        """The polygon, counterclockwise: the corners from the last to the first, with copies, and four far corners."""
        corners = np.array(self.corners)[::-1]
        if self.periodic:
            period = (corners[0, 0] - corners[-1, 0], 0.0)
            corners = np.concatenate([corners[:-1] + period, corners[:-1], corners - period])
        far = FAR * np.ptp(corners, axis=0).sum()
        ahead, back = corners[0] - corners[1], corners[-1] - corners[-2]
        start, end = corners[0] + far / abs(ahead[0]) * ahead, corners[-1] + far / abs(back[0]) * back
        y = corners[:, 1].min() - far if ahead[0] > 0 else corners[:, 1].max() + far
        return _Wall(np.array([start, *corners, end, (end[0], y), (start[0], y)]), self.corner_radius)

    @cached_property
    def _ends(self) -> tuple[float, float]:
        """Arc lengths of the last and the first corner, or the middles of their arcs, along the polygon."""
        lengths = self._wall.lengths
        last, *_, first = (np.cumsum(lengths)[::2] - 0.5 * lengths[::2])[self._own]
        return last, first

    @property
    def ends(self) -> np.ndarray:
        """First and last place (2, 2) of the wall."""
        return self._wall.at(np.array(self._ends[::-1]))[0]

    @property
    def length(self) -> float:
        """Length of the wall, sides and arcs, from its first corner to its last."""
        last, first = self._ends
        return float(first - last)

    @property
    def smallest_radius(self) -> float:
        """Radius of the corners, infinite where there is none."""
        return self.corner_radius if self._wall.bend[self._own].any() else math.inf

    @property
    def convex_radius(self) -> float:
        """Radius of the corners where the wall bulges into the fluid; infinite where there is none."""
        return self.corner_radius if (self._wall.bend[self._own] > 0).any() else math.inf

    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Evenly from the first corner on, half a spacing from the ends."""
        along = evenly(self.length, spacing)
        return *self._wall.at(self._ends[1] - along), np.full(len(along), self.length / len(along))


@dataclass(frozen=True)
class _Waves:
    """A curve whose second period, from the parameter ``period`` on, is ``waves``, and each next one ``ahead`` (2,)."""

    waves: Any
    period: float
    ahead: np.ndarray

    def __call__(self, parameter: np.ndarray, derivative: int = 0) -> np.ndarray:
        """Return places (n, 2) at parameters (n,), or their derivative of an order ``derivative``."""
        along = (parameter / self.period - 1.0, np.full_like(parameter, 1.0 / self.period), np.zeros_like(parameter))
        return self.waves(parameter % self.period, derivative) + along[min(derivative, 2)][..., None] * self.ahead


@dataclass(frozen=True)
class SmoothOutline(EndToEnd, Spline):
    """The smooth curve through ``points`` (k, 2), whose x rises or falls, with the fluid on its left.

    It encloses no area. ValueError where x neither rises nor falls from point to point, the curve leads back between
    them, or a ``periodic`` wall does not end as high as it begins.
    """

    periodic: bool = False

    def __post_init__(self) -> None:
        points = checked_points(self.points, "smooth wall", "places")
        object.__setattr__(self, "points", tuple(map(tuple, points.tolist())))
        steps = np.diff(points[:, 0])
        if not ((steps > 0).all() or (steps < 0).all()):
            raise ValueError("x must rise from place to place of a smooth wall")
        if self.periodic:
            _check_periodic(points)
        forth = self._curve(self._samples[0], 1)[:, 0] * steps[0] > 0
        if not forth.all():
            x, y = self._samples[1][np.argmin(forth)]
            raise ValueError(f"the smooth wall leads back near ({x:.6g}, {y:.6g}): give more places")

    @property
    def _side(self) -> float:
        return -1.0  # the fluid is on the left of the curve

    @cached_property
    def _period(self) -> np.ndarray:
        """Places (m, 2) of one period of the wall and its continuation, from the first point on."""
        points = np.array(self.points)
        image = points[-2::-1] * [-1.0, 1.0] + [2.0 * points[-1, 0], 0.0]
        return points if self.periodic else np.concatenate([points, image])

    @cached_property
    def _knots(self) -> np.ndarray:
        """Parameters of the points of three periods; the wall begins with the second one."""
        sizes = np.linalg.norm(np.diff(self._period, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(np.tile(sizes, 3))])

    @cached_property
    def _curve(self) -> Any:
        """The curve: places (n, 2) at parameters (n,), and their derivatives."""
        from scipy.interpolate import make_interp_spline

        knots = self._knots[: len(self._period)]
        period, ahead = knots[-1], np.array([self._period[-1, 0] - self._period[0, 0], 0.0])
        places = self._period - np.outer(knots / period, ahead)
        places[-1] = places[0]
        return _Waves(make_interp_spline(knots, places, k=DEGREE, bc_type="periodic"), period, ahead)

    @property
    def _ends(self) -> tuple[float, float]:
        """Arc lengths of the first and the last point along three periods."""
        first = len(self._period) - 1
        return self._arc[first], self._arc[first + len(self.points) - 1]

    @property
    def ends(self) -> np.ndarray:
        """First and last place (2, 2) of the wall."""
        return np.array(self.points)[[0, -1]]

    @property
    def length(self) -> float:
        """Length of the wall from its first point to its last."""
        first, last = self._ends
        return float(last - first)

    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Evenly from the first point on, half a spacing from the ends."""
        along = evenly(self.length, spacing)
        parameter = self._parameter(self._ends[0] + along)
        return self._curve(parameter), *self._normals(parameter), np.full(len(along), self.length / len(along))
