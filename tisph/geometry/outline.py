"""A wall from end to end of a channel: an open polyline, its corners rounded by arcs of one radius.

The wall is a part of a polygon around the solid behind it. Its first and last side are continued straight beyond the
ends of the channel. The other sides of the polygon are so far away that no place in the channel is next to them.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry.polygon import STRAIGHT, Polygon, _Wall
from tisph.geometry.shape import Boundary, evenly

FAR = 100.0
"""Distance of the polygon's other sides from the wall, in extents of the wall."""

PIECES = 1000
"""Pieces of the wall from which its ``extent`` is computed."""


@dataclass(frozen=True)
class Outline(Polygon):
    """The polyline through ``corners`` (k, 2), with the fluid on its left, its corners arcs of ``corner_radius``.

    It encloses no area. ValueError where x of a corner is not between the first and the last corner's, two corners
    coincide, sides cross, or the arcs do not fit.
    """

    def __post_init__(self) -> None:
        corners = np.array(self.corners, dtype=float)
        object.__setattr__(self, "corners", tuple(map(tuple, corners.tolist())))
        first, *between, last = corners[:, 0]
        if not all(min(first, last) < x < max(first, last) for x in between) or first == last:
            raise ValueError(f"all corners must be between the ends of the wall, x = {first:g} and {last:g}")
        largest = min((size / slope for size, slope in self._at_ends() if slope > STRAIGHT), default=math.inf)
        if self.corner_radius > largest * (1.0 + STRAIGHT):
            text = f"corners of radius {self.corner_radius:g} reach beyond an end of the wall"
            raise ValueError(f"{text}: at most {largest:.6g}")

    def _at_ends(self) -> list[tuple[float, float]]:
        """Return the lengths of the first and the last side, and the parts that arcs of radius 1 cut off them."""
        corners, slopes = np.array(self.corners), np.tan(0.5 * np.abs(self._wall.turn[1 : len(self.corners) - 1]))
        sizes = np.linalg.norm(corners[[-1, 0]] - corners[[-2, 1]], axis=1)
        return list(zip(sizes.tolist(), slopes[[0, -1]].tolist(), strict=True)) if len(slopes) else []

    @cached_property
    def _wall(self) -> _Wall:
        """The polygon, counterclockwise: the corners from the last to the first, and two far corners."""
        corners = np.array(self.corners)[::-1]
        far = FAR * np.ptp(corners, axis=0).sum()
        ahead, back = corners[0] - corners[1], corners[-1] - corners[-2]
        start, end = corners[0] + far / abs(ahead[0]) * ahead, corners[-1] + far / abs(back[0]) * back
        corners = np.array([start, *corners[1:-1], end])
        y = corners[:, 1].min() - far if ahead[0] > 0 else corners[:, 1].max() + far
        return _Wall(np.array([*corners, (end[0], y), (start[0], y)]), self.corner_radius)

    @property
    def _ends(self) -> tuple[float, float]:
        """Arc lengths of the last and the first corner along the polygon."""
        wall, count = self._wall, len(self.corners)
        last = np.linalg.norm(wall.corner[0] - self.corners[-1])
        first = np.linalg.norm(wall.corner[count - 1] - self.corners[0])
        return wall.lengths[0] + last - wall.trim[0], wall.lengths[: 2 * count - 2].sum() - first + wall.trim[count - 1]

    @property
    def _bends(self) -> np.ndarray:
        """Signs (k - 2,) of the corners, 1 where the wall bulges into the fluid."""
        return self._wall.bend[1 : len(self.corners) - 1]

    @property
    def length(self) -> float:
        """Length of the wall, sides and arcs, from its first corner to its last."""
        last, first = self._ends
        return float(first - last)

    @property
    def area(self) -> float:
        """Enclosed area: none, as of a line."""
        return 0.0

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box around the wall."""
        points = np.array([self.corners[0], *self.boundary_points(self.length / PIECES).point, self.corners[-1]])
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def smallest_radius(self) -> float:
        """Radius of the corners, infinite where there is none."""
        return self.corner_radius if self._bends.any() else math.inf

    @property
    def convex_radius(self) -> float:
        """Radius of the corners where the wall bulges into the fluid; infinite where there is none."""
        return self.corner_radius if (self._bends > 0).any() else math.inf

    def boundary_points(self, spacing: float) -> Boundary:
        """Return points evenly along the wall from its first corner on, half a spacing from its ends."""
        along = evenly(self.length, spacing)
        return Boundary(*self._wall.at(self._ends[1] - along), np.full(len(along), self.length / len(along)))
