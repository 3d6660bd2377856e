"""What every wall is: a curve with the fluid on one side, in the frame of the body that it bounds.

Signs, the same for all shapes: a normal points into the fluid; a distance is positive in the fluid; a curvature is
positive where the centre of curvature lies in the body, so that the body is convex as the fluid sees it: 1/R on a
cylinder in the fluid, -1/R on a cylinder that the fluid is in.

Centroid and polar second moment of the area that a closed wall encloses are integrals along the wall (Green): the
integral of x over the area is the one of x^2 n_x/2 along its edge, and the integral of r^2 the one of r^2 (r . n)/4,
with the normal n outwards. They are taken around the middle of the shape, so that shapes far from the origin lose
nothing.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal, Protocol

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
    """A wall in the frame of its body.

    ``length`` of the curve; ``area`` that it encloses, 0 for a line; ``extent`` (2, 2), the lowest and the highest
    corner of the smallest box around it; ``smallest_radius`` of curvature, infinite where it is straight and 0 where
    it has sharp corners; ``convex_radius``, the same of where it bulges into the fluid alone, infinite where it
    nowhere does; ``fluid_side``, the side of a closed curve that the fluid is on.
    """

    fluid_side: Side
    length: float
    area: float
    extent: np.ndarray
    smallest_radius: float
    convex_radius: float

    def nearest(self, points: np.ndarray) -> ClosestPoint:
        """Nearest points of the wall to ``points`` (n, 2)."""

    def images(self, points: np.ndarray, cutoff: float) -> tuple[np.ndarray, np.ndarray]:
        """Mirror images (k, 2) of those of ``points`` (n, 2) that are within ``cutoff``, and whose (k,) they are."""

    def boundary_points(self, spacing: float) -> Boundary:
        """Points of the wall about ``spacing`` apart, evenly in arc length, in the order of the curve."""


class ClosedCurve(ABC):
    """A closed curve, run through counterclockwise; what subclasses say of it is said for fluid outside."""

    fluid_side: Side

    @property
    def area(self):
        """Area that the curve encloses."""
        return self._area

    @property
    def convex_radius(self):
        """The smallest radius with the fluid outside a curve that bulges everywhere."""
        return self.smallest_radius if self.fluid_side == "outside" else math.inf

    def nearest(self, points):
        """Nearest points of the wall to ``points`` (n, 2), a ``ClosestPoint``."""
        foot, side = self._nearest(np.asarray(points, dtype=float)), self._side
        return ClosestPoint(foot.point, side * foot.normal, side * foot.curvature, side * foot.distance)

    def images(self, points, cutoff):
        """Mirror images (k, 2) of those of ``points`` (n, 2) that are within ``cutoff``, and whose (k,) they are."""
        return mirrored(self, points, cutoff)

    def boundary_points(self, spacing):
        """Points evenly along the wall, the nearest whole number to length/spacing: a ``Boundary``."""
        point, normal, curvature, length = self._spread(spacing)
        return Boundary(point, self._side * normal, self._side * curvature, length)

    @property
    def _side(self):
        return 1.0 if self.fluid_side == "outside" else -1.0

    @abstractmethod
    def _nearest(self, points):
        """Return the ``ClosestPoint`` of each point for fluid outside."""

    @abstractmethod
    def _spread(self, spacing):
        """Return points, normals for fluid outside, curvatures and lengths."""


def checked_points(points, of, words):
    """Return the ``points`` (k, 2) of a curve, which is called ``of``, as an array; ValueError for less than three."""
    points = np.array(points, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3:
        raise ValueError(f"a {of} needs three {words} (x, y) or more, not {len(points)}")
    if not np.isfinite(points).all():
        raise ValueError(f"the {words} of a {of} must be finite")
    return points


def check_side(fluid_side):
    """Raise ValueError where ``fluid`` is no ``Side``."""
    if fluid_side not in ("outside", "inside"):
        raise ValueError(f"the fluid is outside or inside a closed curve, not {fluid_side!r}")


def mirrored(shape, points, cutoff):
    """Images (k, 2) of ``points`` (n, 2) within ``cutoff``, each across its nearest point, and whose (k,) they are."""
    foot = shape.nearest(points)
    near = np.flatnonzero(foot.distance < cutoff)
    return points[near] - 2 * foot.distance[near, None] * foot.normal[near], near


def evenly(length, spacing, least=1):
    """Places (k + 1/2) length/n for k < n, n at least ``least`` and the nearest whole number to length/spacing."""
    if not spacing > 0:
        raise ValueError(f"points on a wall need a spacing above 0, not {spacing}")
    count = max(least, round(length / spacing))
    return (np.arange(count) + 0.5) * (length / count)


def crossing(points):
    """Place (2,) where the closed polyline through ``points`` (m, 2) crosses or touches itself, None where nowhere."""
    start, end = points, np.roll(points, -1, axis=0)
    count = len(points)
    for i in range(count - 2):
        # the next piece, and for the first piece the last, share an end with this one
        others = slice(i + 2, count - 1 if i == 0 else count)
        met = _meet(start[i], end[i], start[others], end[others])
        if met.any():
            return start[others][np.argmax(met)]
    return None


def _meet(a, b, c, d):
    """Whether the piece from ``a`` to ``b`` (2,) meets each of those from ``c`` to ``d`` (k, 2)."""
    apart = (_side(a, b, c) * _side(a, b, d) > 0) | (_side(c, d, a) * _side(c, d, b) > 0)
    # pieces of one line are on no side of each other: then their boxes tell
    over = (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b))
    return ~apart & over.all(axis=1)


def _side(a, b, c):
    """Twice the area of the triangles a, b, c: positive where c is on the left of the line from a to b."""
    (ax, ay), (bx, by), (cx, cy) = a.T, b.T, c.T
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


POINTS = 20_000
"""Along the wall. On circles, and on ellipses with axes of up to 30 to 1, sums over them are exact but for round-off.

On polygons, whose curvature jumps, they have an error of the second order: of 1e-7 of the polar moment at most for
corners rounded by 1/100 of the perimeter, of 4e-7 by 1/250.
"""


def centroid(shape):
    """Centroid (2,) [length] of the area within a closed ``shape``, in the frame of its body."""
    points, normals, lengths, middle = _outline(shape)
    return middle + _first_moment(points, normals, lengths) / shape.area


def polar_moment(shape):
    """Integral [length^4] of x^2 + y^2 over the area within a closed ``shape``, around the origin of its frame."""
    points, normals, lengths, middle = _outline(shape)
    square = np.sum(points**2, axis=1)
    around_middle = 0.25 * np.sum(lengths * square * np.sum(points * normals, axis=1))
    shifted = 2 * middle @ _first_moment(points, normals, lengths) + middle @ middle * shape.area
    return float(around_middle + shifted)


def volume_of_revolution(wall):
    """Volume [length^3] of what is within a closed ``wall``, a ``Boundary``, and above y = 0, turned around that axis.

    By Gauss: the integral of pi y^2 n_y along the wall, with normals outwards.
    """
    return float(np.pi * np.sum(wall.length * np.maximum(wall.point[:, 1], 0.0) ** 2 * wall.normal[:, 1]))


def _first_moment(points, normals, lengths):
    """Return the integral (2,) of the place over the area."""
    return 0.5 * lengths @ (points**2 * normals)


def _outline(shape):
    """Return points (m, 2) seen from the middle of the shape, normals outwards, lengths (m,), and the middle (2,)."""
    wall = shape.boundary_points(shape.length / POINTS)
    middle = 0.5 * shape.extent.sum(axis=0)
    outwards = 1.0 if shape.fluid_side == "outside" else -1.0
    return wall.point - middle, outwards * wall.normal, wall.length, middle
