"""Straight wall without ends, continued periodically. The fluid is on its left."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tisph.geometry.shape import Boundary, ClosestPoint, Shape, Side, evenly


@dataclass(frozen=True)
class Line(Shape):
    """The line through ``point`` along ``tangent`` (of any length but 0), with the fluid on the left of it.

    ``length`` is its period [length], which points on it need. ValueError where the tangent has no direction.
    """

    point: tuple[float, float] = (0.0, 0.0)
    tangent: tuple[float, float] = (1.0, 0.0)
    length: float = math.inf

    fluid_side: ClassVar[Side] = "outside"
    area: ClassVar[float] = 0.0
    smallest_radius: ClassVar[float] = math.inf
    convex_radius: ClassVar[float] = math.inf

    def __post_init__(self) -> None:
        size = math.hypot(*self.tangent)
        if not 0 < size < math.inf:
            raise ValueError(f"a straight wall needs a tangent with a direction, not {self.tangent}")
        if not self.length > 0:
            raise ValueError(f"a straight wall needs a length above 0, not {self.length}")
        object.__setattr__(self, "point", tuple(map(float, self.point)))
        object.__setattr__(self, "tangent", (self.tangent[0] / size, self.tangent[1] / size))

    @property
    def normal(self) -> np.ndarray:
        """Normal (2,) into the fluid."""
        return np.array([-self.tangent[1], self.tangent[0]])

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of one period, from ``point`` on."""
        ahead = [0.0 if part == 0 else part * self.length for part in self.tangent]
        ends = np.add(self.point, [[0.0, 0.0], ahead])
        return np.stack([ends.min(axis=0), ends.max(axis=0)])

    def nearest(self, points: np.ndarray) -> ClosestPoint:
        """Return the closest points of the wall to ``points`` (n, 2)."""
        away = np.asarray(points, dtype=float) - self.point
        normal = self.normal
        distance = away @ normal
        point = self.point + (away @ self.tangent)[:, None] * np.array(self.tangent)
        return ClosestPoint(point, np.tile(normal, (len(away), 1)), np.zeros(len(away)), distance)

    def boundary_points(self, spacing: float) -> Boundary:
        """Return points of one period, half a spacing from its ends; ValueError for a line without a period."""
        if not math.isfinite(self.length):
            raise ValueError("points on a straight wall need its period: give it a length")
        along = evenly(self.length, spacing)
        count = len(along)
        point = self.point + along[:, None] * np.array(self.tangent)
        return Boundary(point, np.tile(self.normal, (count, 1)), np.zeros(count), np.full(count, self.length / count))
