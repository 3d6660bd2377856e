"""Shapes of walls: curves with the fluid on one side, in the frame of the body.

Signs, the same for all shapes: a normal points into the fluid; a distance is positive in the fluid; a curvature is
positive where the centre of curvature lies in the body, so that the body is convex towards the fluid: 1/R on a
cylinder in the fluid, -1/R on a cylinder that the fluid is in.

Centroid and polar second moment of the area that a closed wall encloses are integrals along the wall (Green): the
integral of x over the area equals the integral of x^2 n_x/2 along its edge; for r^2 the integrand is r^2 (r . n)/4,
with the normal n outwards. They are computed around the middle of the shape, so that shapes far from the origin lose
no digits.
"""

import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, Protocol

import numpy as np

Side = Literal["outside", "inside"]
"""Where the fluid is, seen from a closed curve."""


@dataclass(frozen=True)
class ClosestPoint:
    """The nearest points of a wall to n places.

    ``point`` (n, 2) on the wall, ``normal`` (n, 2) of the wall there, of length 1, into the fluid, ``curvature`` (n,)
    [1/length] and ``distance`` (n,) [length], both signed as the module says. A place is point + distance * normal.
    """

    point: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    distance: np.ndarray


@dataclass(frozen=True)
class Boundary:
    """m points of a wall: ``point`` (m, 2), ``normal`` (m, 2), ``curvature`` (m,), ``length`` (m,).

    ``length`` is the arc length that each point stands for: sum(f * length) integrates f along the wall.
    """

    point: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    length: np.ndarray


class Shape(Protocol):
    """A wall in the frame of its body."""

    @property
    def fluid_side(self) -> Side:
        """Side of a closed curve on which the fluid is."""

    @property
    def length(self) -> float:
        """Length of the curve, infinite for a line without a period."""

    @property
    def area(self) -> float:
        """Enclosed area, 0 for a line."""

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the smallest box around the curve."""

    @property
    def smallest_radius(self) -> float:
        """Smallest radius of curvature: infinite for a straight wall, 0 for sharp corners."""

    @property
    def convex_radius(self) -> float:
        """Smallest radius of curvature where the wall bulges into the fluid; infinite where it nowhere does."""

    def nearest(self, points: np.ndarray) -> ClosestPoint:
        """Return the closest points of the wall to ``points`` (n, 2)."""

    def images(self, points: np.ndarray, cutoff: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mirror images (k, 2) of ``points`` (n, 2) within ``cutoff``, and the indices (k,) of their points.

        The image of a point is its reflection across the closest point of the wall.
        """
        foot = self.nearest(points)
        near = np.flatnonzero(foot.distance < cutoff)
        return points[near] - 2 * foot.distance[near, None] * foot.normal[near], near

    def boundary_points(self, spacing: float) -> Boundary:
        """Return points of the wall about ``spacing`` apart, evenly in arc length, in the order of the curve."""


class ClosedCurve(Shape):
    """A closed curve, counterclockwise. Subclasses define ``_nearest`` and ``_spread`` for fluid outside."""

    @property
    def convex_radius(self) -> float:
        """Smallest radius with the fluid outside a curve that bulges everywhere."""
        return self.smallest_radius if self.fluid_side == "outside" else math.inf

    @cached_property
    def largest_distance(self) -> float:
        """Largest distance of points of the curve from the origin of the frame."""
        return float(np.linalg.norm(self.boundary_points(self.length / 1000).point, axis=1).max())

    def nearest(self, points: np.ndarray) -> ClosestPoint:
        """Return the closest points of the wall to ``points`` (n, 2)."""
        foot, side = self._nearest(np.asarray(points, dtype=float)), self._side
        return ClosestPoint(foot.point, side * foot.normal, side * foot.curvature, side * foot.distance)

    def boundary_points(self, spacing: float) -> Boundary:
        """Return points evenly along the wall; their number is length/spacing, rounded."""
        point, normal, curvature, length = self._spread(spacing)
        return Boundary(point, self._side * normal, self._side * curvature, length)

    @property
    def _side(self) -> float:
        return 1.0 if self.fluid_side == "outside" else -1.0

    @abstractmethod
    def _nearest(self, points: np.ndarray) -> ClosestPoint:
        """Return the closest points for fluid outside."""

    @abstractmethod
    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return points, normals for fluid outside, curvatures and lengths for points about ``spacing`` apart."""


def checked_points(points: Any, of: str, words: str) -> np.ndarray:
    """Return ``points`` (k, 2) of a curve named ``of`` as an array; ValueError for fewer than three."""
    points = np.array(points, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3:
        raise ValueError(f"a {of} needs three {words} (x, y) or more, not {len(points)}")
    if not np.isfinite(points).all():
        raise ValueError(f"the {words} of a {of} must be finite")
    return points


def check_side(fluid_side: str) -> None:
    """Raise ValueError where ``fluid_side`` is no ``Side``."""
    if fluid_side not in ("outside", "inside"):
        raise ValueError(f"the fluid is outside or inside a closed curve, not {fluid_side!r}")


def evenly(length: float, spacing: float, least: int = 1) -> np.ndarray:
    """Return places (k + 1/2) length/n for k < n, with n = length/spacing rounded, but at least ``least``."""
    if not spacing > 0:
        raise ValueError(f"points on a wall need a spacing above 0, not {spacing}")
    count = max(least, round(length / spacing))
    return (np.arange(count) + 0.5) * (length / count)


def crossing(points: np.ndarray) -> np.ndarray | None:
    """Return a place (2,) where the closed polyline through ``points`` (m, 2) meets itself; None where it does not."""
    start, end = points, np.roll(points, -1, axis=0)
    count = len(points)
    for i in range(count - 2):
        # the next piece, and for the first piece the last, share an end with this one
        others = slice(i + 2, count - 1 if i == 0 else count)
        met = _meet(start[i], end[i], start[others], end[others])
        if met.any():
            return start[others][np.argmax(met)]
    return None


def _meet(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return whether (k,) the piece from ``a`` to ``b`` (2,) meets each piece from ``c`` to ``d`` (k, 2)."""
    apart = (_side(a, b, c) * _side(a, b, d) > 0) | (_side(c, d, a) * _side(c, d, b) > 0)
    # for pieces of one line, which are on no side of each other, the boxes decide
    over = (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b))
    return ~apart & over.all(axis=1)


def _side(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> Any:
    """Return twice the area of the triangles a, b, c: positive where c is on the left of the line from a to b."""
    (ax, ay), (bx, by), (cx, cy) = a.T, b.T, c.T
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


POINTS = 20_000
"""Points along the wall. On circles, and on ellipses up to 30 to 1, sums over them are exact but for round-off.

On polygons, whose curvature jumps, the error is of second order: at most 1e-7 of the polar moment for corners rounded
by 1/100 of the perimeter, 4e-7 by 1/250.
"""


def centroid(shape: Shape) -> np.ndarray:
    """Return the centroid (2,) [length] of the area within a closed ``shape``, in the frame of its body."""
    points, normals, lengths, middle = _outline(shape)
    return middle + _first_moment(points, normals, lengths) / shape.area


def polar_moment(shape: Shape) -> float:
    """Return the integral [length^4] of x^2 + y^2 over the area within a closed ``shape``."""
    points, normals, lengths, middle = _outline(shape)
    square = np.sum(points**2, axis=1)
    around_middle = 0.25 * np.sum(lengths * square * np.sum(points * normals, axis=1))
    shifted = 2 * middle @ _first_moment(points, normals, lengths) + middle @ middle * shape.area
    return float(around_middle + shifted)


def volume_of_revolution(wall: Boundary) -> float:
    """Return the volume [length^3] of the body of revolution around y = 0 whose half section lies within ``wall``.

    By Gauss: the integral of pi y^2 n_y along the wall, with normals outwards.
    """
    return float(np.pi * np.sum(wall.length * np.maximum(wall.point[:, 1], 0.0) ** 2 * wall.normal[:, 1]))


def _first_moment(points: np.ndarray, normals: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the integral (2,) of x and y over the area."""
    return 0.5 * lengths @ (points**2 * normals)


def _outline(shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return points (m, 2) relative to the middle of the shape, outward normals, lengths (m,), and the middle (2,)."""
    wall = shape.boundary_points(shape.length / POINTS)
    middle = 0.5 * shape.extent.sum(axis=0)
    outwards = 1.0 if shape.fluid_side == "outside" else -1.0
    return wall.point - middle, outwards * wall.normal, wall.length, middle
