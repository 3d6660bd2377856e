"""Polygon with sharp corners, or with corners rounded by arcs of one radius."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry.shape import ClosedCurve, ClosestPoint, Side, check_side, checked_points, crossing, evenly

STRAIGHT = 1e-12
"""Turn of the tangent, in radians, and part of a length, below which there is only round-off."""


class _Wall:
    """Sides and arcs of a polygon through ``corner`` (k, 2), counterclockwise, rounded with ``radius``.

    Side i goes from corner i to the next one; arc i is at corner i, before side i. All arrays are (k, 2) or (k,).
    ``tangent``, ``normal``: of the sides, the normal outwards. ``turn``: angle by which the tangent turns at a corner,
    positive at convex ones; ``bend``: its sign, 0 where there is no corner. ``middle``: normal halfway round a corner.
    ``trim``: length that an arc cuts off both its sides. ``start``, ``end``: ends of the straight sides. ``centre``:
    centres of the arcs. ``lengths`` (2 k,): of arc 0, side 0, arc 1 and so on.

    ValueError where corners coincide or fold back, sides cross, or arcs do not fit.
    """

    def __init__(self, corner: np.ndarray, radius: float):
        self.corner, self.radius = corner, radius
        side = np.roll(corner, -1, axis=0) - corner
        size = np.linalg.norm(side, axis=1)
        if not (size > 0).all():
            raise ValueError("corners of a polygon that follow each other must be two places")
        self.tangent = side / size[:, None]
        self.normal = self.tangent[:, ::-1] * [1.0, -1.0]
        before, after = np.roll(self.tangent, 1, axis=0), self.tangent
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        self.turn = np.arctan2(cross, np.sum(before * after, axis=1))
        if (np.abs(self.turn) > math.pi - 1e-6).any():
            place = corner[np.argmax(np.abs(self.turn))]
            raise ValueError(f"the polygon folds back at its corner {_words(place)}: corners need an angle above 0")
        _check_crossing(corner)
        if not 0 <= radius < math.inf:
            raise ValueError(f"the radius of corners must be 0 or more, not {radius}")
        slope = np.tan(0.5 * np.abs(self.turn))
        need = slope + np.roll(slope, -1)
        if (radius * need > size * (1 + 1e-12)).any():
            largest = np.min(size[need > 0] / need[need > 0])
            raise ValueError(f"corners of radius {radius:g} do not fit: at most {largest:.6g}")
        self.bend = np.where(np.abs(self.turn) > STRAIGHT, np.sign(self.turn), 0.0)
        middle = self.normal + np.roll(self.normal, 1, axis=0)
        self.middle = middle / np.linalg.norm(middle, axis=1)[:, None]
        self.trim = radius * slope
        self.start = corner + self.trim[:, None] * self.tangent
        self.end = np.roll(corner, -1, axis=0) - np.roll(self.trim, -1)[:, None] * self.tangent
        self.centre = self.start - (self.bend * radius)[:, None] * self.normal
        arc, straight = radius * np.abs(self.bend * self.turn), np.sum((self.end - self.start) * self.tangent, axis=1)
        self.lengths = np.maximum(np.stack([arc, straight], axis=1), 0.0).ravel()
        if radius:
            _check_crossing(self.polyline())

    def polyline(self) -> np.ndarray:
        """Return points (n, 2) of the wall, nine on each arc."""
        part = np.linspace(-0.5, 0.5, 9)
        angle = np.arctan2(self.middle[:, 1], self.middle[:, 0])[:, None] + part * self.turn[:, None]
        arcs = np.stack([np.cos(angle), np.sin(angle)], axis=2) * (self.bend * self.radius)[:, None, None]
        places = (self.centre[:, None] + arcs)[np.abs(self.turn) > STRAIGHT].reshape(-1, 2)
        step = np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1)
        return places[step > STRAIGHT * step.max()]  # arcs that meet, without a side between them, share an end

    def on_arcs(self, points: np.ndarray, corner: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return normals (n, 2) of arcs ``corner`` (n,) towards ``points`` (n, 2), whether on them, and distances."""
        bend, away = self.bend[corner], points - self.centre[corner]
        size = np.linalg.norm(away, axis=1)
        outward = np.where(size[:, None] > 0, bend[:, None] * away, self.middle[corner])
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        within = np.sum(outward * self.middle[corner], axis=1) >= np.cos(0.5 * self.turn[corner])
        return outward, within, bend * (size - self.radius)

    def nearest_on_sides(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points, normals and distances of the nearest places of the straight sides, their ends included."""
        length = self.lengths[1::2]
        along = np.clip(np.einsum("nkc,kc->nk", points[:, None] - self.start, self.tangent), 0.0, length)
        foot = self.start + along[..., None] * self.tangent
        rows = np.arange(len(points))
        side = np.argmin(np.sum((points[:, None] - foot) ** 2, axis=2), axis=1)
        point, along, length = foot[rows, side], along[rows, side], length[side]
        normal = self.normal[side].copy()
        if not self.radius:  # at sharp corners the normals of both sides distinguish inside and outside
            normal = np.where((along <= 0)[:, None], self.middle[side], normal)
            normal = np.where((along >= length)[:, None], np.roll(self.middle, -1, axis=0)[side], normal)
        away = points - point
        size = np.linalg.norm(away, axis=1)
        distance = np.copysign(size, np.sum(away * normal, axis=1))
        at_end = ((along <= 0) | (along >= length)) & (size > STRAIGHT * length)
        normal[at_end] = away[at_end] / distance[at_end, None]
        return point, normal, distance

    def at(self, along: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return points, outward normals, and curvatures at arc lengths ``along`` (n,) from arc 0 on."""
        ends = np.cumsum(self.lengths)
        piece = np.minimum(np.searchsorted(ends, along, side="right"), len(ends) - 1)
        rest, i, straight = along - (ends - self.lengths)[piece], piece // 2, (piece % 2)[:, None]
        curvature = np.where(piece % 2, 0.0, self.bend[i] / (self.radius or 1.0))
        first = np.where(straight, self.normal[i], np.roll(self.normal, 1, axis=0)[i])
        angle = curvature * rest
        left = first[:, ::-1] * [-1.0, 1.0]
        normal = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * left
        on_arc = self.centre[i] + (self.bend[i] * self.radius)[:, None] * normal
        on_side = self.start[i] + rest[:, None] * self.tangent[i]
        return np.where(straight, on_side, on_arc), normal, curvature


@dataclass(frozen=True)
class Polygon(ClosedCurve):
    """The polygon through ``corners`` (k, 2), in either order, its corners arcs of ``corner_radius`` [length].

    Where the closest point is a sharp corner, the normal points at the place and the curvature is 0. ValueError where
    there are fewer than three corners, two of them coincide, the sides cross, or the arcs do not fit.
    """

    corners: tuple[tuple[float, float], ...]
    corner_radius: float = 0.0
    fluid_side: Side = "outside"

    def __post_init__(self) -> None:
        check_side(self.fluid_side)
        corners = checked_points(self.corners, "polygon", "corners")
        if _enclosed(corners) < 0:
            corners = corners[::-1]
        object.__setattr__(self, "corners", tuple(map(tuple, corners.tolist())))
        _ = self._wall  # ValueError where it is impossible

    @cached_property
    def _wall(self) -> _Wall:
        return _Wall(np.array(self.corners), self.corner_radius)

    @property
    def length(self) -> float:
        """Perimeter, of sides and arcs."""
        return float(self._wall.lengths.sum())

    @property
    def extent(self) -> np.ndarray:
        """Lowest and highest corner (2, 2) of the box around the wall."""
        wall = self._wall
        places = [wall.start, wall.end]
        for axis in np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]) if self.corner_radius else ():
            inside = (wall.bend > 0) & (wall.middle @ axis >= np.cos(0.5 * wall.turn))
            places.append(wall.centre[inside] + self.corner_radius * axis)
        points = np.concatenate(places)
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def smallest_radius(self) -> float:
        """Radius of the corners, 0 for sharp ones."""
        return self.corner_radius

    @property
    def convex_radius(self) -> float:
        """Radius of the corners where the wall bulges into the fluid."""
        return self.corner_radius if (self._side * self._wall.bend > 0).any() else math.inf

    @property
    def area(self) -> float:
        """Enclosed area."""
        turn = np.abs(self._wall.turn)
        cut = self.corner_radius**2 * (np.tan(0.5 * turn) - 0.5 * turn)
        return float(_enclosed(self._wall.corner) - np.sum(self._wall.bend * cut))

    def images(self, points: np.ndarray, cutoff: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mirror images (k, 2) of ``points`` (n, 2) within ``cutoff``, and the indices (k,) of their points.

        A point has an image across each side, and each arc, that it is beside. Where the fluid fills a sharp corner, a
        point beside both sides has an image across the corner, too. The body's own corners fill with images of the
        sides.
        """
        wall, side, cutoff = self._wall, self._side, np.broadcast_to(cutoff, len(points))
        away = points[:, None] - wall.start
        along = np.einsum("nkc,kc->nk", away, wall.tangent)
        height = side * np.einsum("nkc,kc->nk", away, wall.normal)
        beside = (along >= 0) & (along <= wall.lengths[1::2]) & (height < cutoff[:, None])
        beside &= height > -0.25 * cutoff[:, None]  # behind a wall there may be another one
        of, sides = np.nonzero(beside)
        across = points[of] - 2 * side * height[of, sides, None] * wall.normal[sides]
        source, foot = self._at_corners(points, beside, cutoff)
        return np.concatenate([across, 2 * foot - points[source]]), np.concatenate([of, source])

    def _at_corners(self, points: np.ndarray, beside: np.ndarray, cutoff: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices (k,) of ``points`` with an image across a corner, and the places (k, 2) halfway to it."""
        wall = self._wall
        near = np.linalg.norm(points[:, None] - wall.corner, axis=2) < 1.5 * cutoff[:, None] + wall.trim
        if not self.corner_radius:
            filled = wall.bend < 0 if self.fluid_side == "outside" else wall.bend > 0
            of, corner = np.nonzero(near & filled & beside & np.roll(beside, 1, axis=1))
            return of, wall.corner[corner]
        of, corner = np.nonzero(near & (wall.bend != 0))
        outward, within, distance = wall.on_arcs(points[of], corner)
        within &= (distance if self.fluid_side == "outside" else -distance) < cutoff[
            of
        ]  # others have images in the fluid
        foot = wall.centre[corner] + (wall.bend[corner] * self.corner_radius)[:, None] * outward
        return of[within], foot[within]

    def _nearest(self, points: np.ndarray) -> ClosestPoint:
        wall = self._wall
        point, normal, distance = wall.nearest_on_sides(points)
        curvature = np.zeros(len(points))
        for i in np.flatnonzero(wall.bend * self.corner_radius):
            bend = wall.bend[i]
            outward, within, to_arc = wall.on_arcs(points, np.full(len(points), i))
            nearer = within & (np.abs(to_arc) < np.abs(distance))
            point[nearer] = (wall.centre[i] + bend * self.corner_radius * outward)[nearer]
            normal[nearer], distance[nearer] = outward[nearer], to_arc[nearer]
            curvature[nearer] = bend / self.corner_radius
        return ClosestPoint(point, normal, curvature, distance)

    def _spread(self, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Evenly along the whole wall; with sharp corners along each side, half a spacing and more from its ends."""
        wall, ends = self._wall, np.cumsum(self._wall.lengths)
        if self.corner_radius:
            along = evenly(self.length, spacing, least=3)
            return *wall.at(along), np.full(len(along), self.length / len(along))
        lengths = wall.lengths[1::2]
        sides = [evenly(length, spacing) for length in lengths]
        along = np.concatenate([start + side for start, side in zip(ends[1::2] - lengths, sides, strict=True)])
        length = np.concatenate([np.full(len(s), c / len(s)) for s, c in zip(sides, lengths, strict=True)])
        return *wall.at(along), length


def _enclosed(corners: np.ndarray) -> float:
    """Return the area within ``corners`` (k, 2), negative where they run clockwise."""
    (x, y), (next_x, next_y) = corners.T, np.roll(corners, -1, axis=0).T
    return 0.5 * np.sum(x * next_y - y * next_x)


def _check_crossing(outline: np.ndarray) -> None:
    place = crossing(outline)
    if place is not None:
        raise ValueError(f"the polygon meets itself near {_words(place)}: its sides must not cross or touch")


def _words(place: np.ndarray) -> str:
    return f"({place[0]:.6g}, {place[1]:.6g})"
