"""Polygon with sharp corners, or with corners rounded by arcs of one radius."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tisph.geometry.shape import ClosedCurve, ClosestPoint, Side, check_side, checked_points, crossing, evenly

STRAIGHT = 1e-12
"""Turn of the tangent, in radians, and share of a length, below which there is rounding only."""


@dataclass(frozen=True)
class Polygon(ClosedCurve):
    """The polygon through ``corners`` (k, 2), in either order, its corners arcs of ``corner_radius`` [length].

    Where the nearest point of a wall is a sharp corner, the normal points at the place and the curvature is 0.
    ValueError where there are fewer than three corners, two of them coincide, the sides cross, or the arcs do not fit.
    """

    corners: tuple[tuple[float, float], ...]
    corner_radius: float = 0.0
    fluid_side: Side = "outside"

    def __post_init__(self):
        check_side(self.fluid_side)
        corners = checked_points(self.corners, "polygon", "corners")
        if _enclosed(corners) < 0:
            corners = corners[::-1]
        object.__setattr__(self, "corners", tuple(map(tuple, corners.tolist())))
        self._check()

    @property
    def length(self):
        """Perimeter, of sides and arcs."""
        return float(self._lengths.sum())

    @property
    def extent(self):
        """Lowest and highest corner (2, 2) of the box around the wall."""
        places = [self._start, self._end]
        for axis in np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]) if self.corner_radius else ():
            inside = (self._bend > 0) & (self._middle @ axis >= np.cos(0.5 * self._turn))
            places.append(self._centre[inside] + self.corner_radius * axis)
        places = np.concatenate(places)
        return np.stack([places.min(axis=0), places.max(axis=0)])

    @property
    def smallest_radius(self):
        """Radius of the corners, 0 for sharp ones."""
        return self.corner_radius

    @property
    def convex_radius(self):
        """The radius of corners where the wall bulges into the fluid."""
        return self.corner_radius if (self._side * self._bend > 0).any() else math.inf

    @property
    def _area(self):
        radius, turn = self.corner_radius, np.abs(self._turn)
        cut = radius**2 * (np.tan(0.5 * turn) - 0.5 * turn)
        return float(_enclosed(self._corner) - np.sum(self._bend * cut))

    def images(self, points, cutoff):
        """Mirror images (k, 2) of those of ``points`` (n, 2) within ``cutoff``, and whose (k,) they are.

        A place has an image across each side, and each arc, that it is beside. Where the fluid fills a sharp corner, a
        place beside both sides has one across the corner too; the body's own corners fill with images of the sides.
        """
        side, away = self._side, points[:, None] - self._start
        along = np.einsum("nkc,kc->nk", away, self._tangent)
        height = side * np.einsum("nkc,kc->nk", away, self._normal)
        beside = (along >= 0) & (along <= self._lengths[1::2]) & (height < cutoff)
        beside &= height > -0.25 * cutoff  # behind a wall there may be another one
        of, sides = np.nonzero(beside)
        across = points[of] - 2 * side * height[of, sides, None] * self._normal[sides]
        whose, foot = self._at_corners(points, beside, cutoff)
        return np.concatenate([across, 2 * foot - points[whose]]), np.concatenate([of, whose])

    def _at_corners(self, points, beside, cutoff):
        """Return which (k,) of ``points`` have an image across a corner, and the places (k, 2) half way to it."""
        near = np.linalg.norm(points[:, None] - self._corner, axis=2) < 1.5 * cutoff + self._trim
        before = np.roll(beside, 1, axis=1)
        if not self.corner_radius:
            filled = self._bend < 0 if self.fluid_side == "outside" else self._bend > 0
            of, corner = np.nonzero(near & filled & beside & before)
            return of, self._corner[corner]
        of, corner = np.nonzero(near & (self._bend != 0))
        outward, within, distance = self._on_arcs(points[of], corner)
        within &= (distance if self.fluid_side == "outside" else -distance) < cutoff  # farther ones come out behind
        foot = self._centre[corner] + (self._bend[corner] * self.corner_radius)[:, None] * outward
        return of[within], foot[within]

    def _on_arcs(self, points, corner):
        """Return normals (n, 2) of arcs ``corner`` (n,) towards ``points`` (n, 2), whether on them, and distances."""
        bend, away = self._bend[corner], points - self._centre[corner]
        size = np.linalg.norm(away, axis=1)
        outward = np.where(size[:, None] > 0, bend[:, None] * away, self._middle[corner])
        outward /= np.linalg.norm(outward, axis=1)[:, None]
        within = np.sum(outward * self._middle[corner], axis=1) >= np.cos(0.5 * self._turn[corner])
        return outward, within, bend * (size - self.corner_radius)

    def _check(self):
        corner = self._corner
        if not (np.linalg.norm(np.roll(corner, -1, axis=0) - corner, axis=1) > 0).all():
            raise ValueError("corners of a polygon that follow each other must be two places")
        if (np.abs(self._turn) > math.pi - 1e-6).any():
            place = corner[np.argmax(np.abs(self._turn))]
            raise ValueError(f"the polygon folds back at its corner {_words(place)}: corners need an angle above 0")
        self._check_crossing(corner)
        if not 0 <= self.corner_radius < math.inf:
            raise ValueError(f"the radius of corners must be 0 or more, not {self.corner_radius}")
        slope = np.tan(0.5 * np.abs(self._turn))
        side, need = np.linalg.norm(np.roll(corner, -1, axis=0) - corner, axis=1), slope + np.roll(slope, -1)
        if (self.corner_radius * need > side * (1 + 1e-12)).any():
            largest = np.min(side[need > 0] / need[need > 0])
            raise ValueError(f"corners of radius {self.corner_radius:g} do not fit: at most {largest:.6g}")
        if self.corner_radius:
            self._check_crossing(self._outline())

    def _check_crossing(self, outline):
        place = crossing(outline)
        if place is not None:
            raise ValueError(f"the polygon meets itself near {_words(place)}: its sides must not cross or touch")

    def _outline(self):
        """Return the wall as a polyline, arcs by nine points each."""
        part = np.linspace(-0.5, 0.5, 9)
        angle = np.arctan2(self._middle[:, 1], self._middle[:, 0])[:, None] + part * self._turn[:, None]
        arcs = np.stack([np.cos(angle), np.sin(angle)], axis=2) * (self._bend * self.corner_radius)[:, None, None]
        places = (self._centre[:, None] + arcs)[np.abs(self._turn) > STRAIGHT]
        places = places.reshape(-1, 2)
        step = np.linalg.norm(places - np.roll(places, 1, axis=0), axis=1)
        return places[step > STRAIGHT * step.max()]  # arcs that meet, without a side between them, share an end

    # Side i goes from corner i to the next one; arc i is at corner i, before side i. Arrays (k, 2) or (k,).

    @cached_property
    def _corner(self):
        return np.array(self.corners)

    @cached_property
    def _tangent(self):
        side = np.roll(self._corner, -1, axis=0) - self._corner
        return side / np.linalg.norm(side, axis=1)[:, None]

    @cached_property
    def _normal(self):
        return self._tangent[:, ::-1] * [1.0, -1.0]

    @cached_property
    def _turn(self):
        """Angles by which the tangent turns at the corners, positive at convex ones."""
        before, after = np.roll(self._tangent, 1, axis=0), self._tangent
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        return np.arctan2(cross, np.sum(before * after, axis=1))

    @cached_property
    def _bend(self):
        """Sign of the curvature of the arcs, 0 where there is no corner."""
        return np.where(np.abs(self._turn) > STRAIGHT, np.sign(self._turn), 0.0)

    @cached_property
    def _middle(self):
        """Normals half way round the corners."""
        middle = self._normal + np.roll(self._normal, 1, axis=0)
        return middle / np.linalg.norm(middle, axis=1)[:, None]

    @cached_property
    def _trim(self):
        return self.corner_radius * np.tan(0.5 * np.abs(self._turn))

    @cached_property
    def _start(self):
        return self._corner + self._trim[:, None] * self._tangent

    @cached_property
    def _end(self):
        return np.roll(self._corner, -1, axis=0) - np.roll(self._trim, -1)[:, None] * self._tangent

    @cached_property
    def _centre(self):
        return self._start - (self._bend * self.corner_radius)[:, None] * self._normal

    @cached_property
    def _lengths(self):
        """Lengths (2 k,) of arc 0, side 0, arc 1 and so on."""
        side = np.sum((self._end - self._start) * self._tangent, axis=1)
        arc = self.corner_radius * np.abs(self._bend * self._turn)
        return np.maximum(np.stack([arc, side], axis=1), 0.0).ravel()

    def _nearest(self, points):
        point, normal, distance = self._nearest_on_sides(points)
        curvature = np.zeros(len(points))
        for i in np.flatnonzero(self._bend * self.corner_radius):
            bend = self._bend[i]
            outward, within, to_arc = self._on_arcs(points, np.full(len(points), i))
            nearer = within & (np.abs(to_arc) < np.abs(distance))
            point[nearer] = (self._centre[i] + bend * self.corner_radius * outward)[nearer]
            normal[nearer], distance[nearer] = outward[nearer], to_arc[nearer]
            curvature[nearer] = bend / self.corner_radius
        return ClosestPoint(point, normal, curvature, distance)

    def _nearest_on_sides(self, points):
        """Return points, normals and distances of the nearest places of the straight sides, their ends included."""
        away = points[:, None] - self._start
        length = self._lengths[1::2]
        along = np.clip(np.einsum("nkc,kc->nk", away, self._tangent), 0.0, length)
        foot = self._start + along[..., None] * self._tangent
        rows = np.arange(len(points))
        side = np.argmin(np.sum((points[:, None] - foot) ** 2, axis=2), axis=1)
        point, along, length = foot[rows, side], along[rows, side], length[side]
        normal = self._normal[side].copy()
        if not self.corner_radius:  # at sharp corners the normals of both sides tell in from out
            normal = np.where((along <= 0)[:, None], self._middle[side], normal)
            normal = np.where((along >= length)[:, None], np.roll(self._middle, -1, axis=0)[side], normal)
        away = points - point
        size = np.linalg.norm(away, axis=1)
        distance = np.copysign(size, np.sum(away * normal, axis=1))
        at_end = ((along <= 0) | (along >= length)) & (size > STRAIGHT * length)
        normal[at_end] = away[at_end] / distance[at_end, None]
        return point, normal, distance

    def _spread(self, spacing):
        """Evenly along the whole wall; where corners are sharp along each side, half a spacing and more off them."""
        if self.corner_radius:
            along = evenly(self.length, spacing, least=3)
            return *self._at(along), np.full(len(along), self.length / len(along))
        sides = [evenly(length, spacing) for length in self._lengths[1::2]]
        before = np.cumsum(self._lengths)[1::2] - self._lengths[1::2]
        along = np.concatenate([start + side for start, side in zip(before, sides, strict=True)])
        length = np.concatenate([np.full(len(s), c / len(s)) for s, c in zip(sides, self._lengths[1::2], strict=True)])
        return *self._at(along), length

    def _at(self, along):
        """Return points, normals for fluid outside, and curvatures at arc lengths ``along`` from arc 0 on."""
        ends = np.cumsum(self._lengths)
        piece = np.minimum(np.searchsorted(ends, along, side="right"), len(ends) - 1)
        rest, i = along - (ends - self._lengths)[piece], piece // 2
        curvature = np.where(piece % 2, 0.0, self._bend[i] / (self.corner_radius or 1.0))
        first = np.where((piece % 2)[:, None], self._normal[i], np.roll(self._normal, 1, axis=0)[i])
        angle = curvature * rest
        left = first[:, ::-1] * [-1.0, 1.0]
        normal = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * left
        on_arc = self._centre[i] + (self._bend[i] * self.corner_radius)[:, None] * normal
        on_side = self._start[i] + rest[:, None] * self._tangent[i]
        return np.where((piece % 2)[:, None], on_side, on_arc), normal, curvature


def _enclosed(corners):
    """Area within ``corners`` (k, 2), negative where they run clockwise."""
    (x, y), (next_x, next_y) = corners.T, np.roll(corners, -1, axis=0).T
    return 0.5 * np.sum(x * next_y - y * next_x)


def _words(place):
    return f"({place[0]:.6g}, {place[1]:.6g})"
