"""The particle spacing that is wanted at each place: fine near its sources, growing away from them.

    h(x, t) = min(H, h_1 + g max(0, d_1(x, t) - w_1), h_2 + g max(0, d_2(x, t) - w_2), ...)

with the spacing H of the flow, the growth g per distance, and of each source k its spacing h_k, the distance d_k from
it, and the distance w_k up to which its spacing holds. Without sources it is H everywhere.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.region import nearest_image
from tisph.geometry.shape import Boundary, Shape

GROWTH = 0.1
"""Usual growth of the spacing over the distance from a source: neighbours differ by a tenth."""

PIECES = 1000
"""Pieces of a wall along which the spacing is evaluated."""


class Source(Protocol):
    """A place near which particles are closer to one another: ``spacing`` up to the distance ``within`` [length]."""

    @property
    def spacing(self) -> float:
        """Particle spacing at the source [length]."""

    @property
    def within(self) -> float:
        """Distance up to which it holds [length]."""

    def distance(self, places: np.ndarray, time: float) -> np.ndarray:
        """Return the distances (n,) of ``places`` (n, 2) from the source at ``time``."""

    def placed(self, now: Callable[[Body], Body]) -> "Source":
        """Return the source with each body replaced by the one that it is ``now``."""


@dataclass(frozen=True)
class NearBody:
    """The ``Source`` around a ``body`` or a wall."""

    body: Body
    spacing: float
    within: float = 0.0

    def distance(self, places: np.ndarray, time: float) -> np.ndarray:
        """Return the distances (n,) of ``places`` (n, 2) from the wall at ``time``; 0 beyond it."""
        return np.maximum(self.body.nearest(places, time).distance, 0.0)

    def placed(self, now: Callable[[Body], Body]) -> "NearBody":
        """Return the source with its body as it is ``now``."""
        return replace(self, body=now(self.body))


@dataclass(frozen=True)
class InBox:
    """The ``Source`` in a box from the corner ``low`` to the corner ``high``, or at a point, where they are the same.

    ``periods`` (2,) of the flow along x and y, 0 where it is not periodic.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    spacing: float
    within: float = 0.0
    periods: tuple[float, float] = (0.0, 0.0)

    def distance(self, places: np.ndarray, time: float) -> np.ndarray:
        """Return the distances (n,) of ``places`` (n, 2) from the box; 0 in it."""
        low, high = np.array(self.low), np.array(self.high)
        away = np.abs(nearest_image(places - 0.5 * (low + high), np.array(self.periods))) - 0.5 * (high - low)
        return np.hypot(*np.maximum(away, 0.0).T)

    def placed(self, now: Callable[[Body], Body]) -> "InBox":
        """Return the source, which stays."""
        return self


SHARE = 0.25
"""Spacing in a narrow gap between two walls over its width."""


@dataclass(frozen=True)
class InGaps:
    """The ``Source`` in gaps between ``bodies`` and walls: the spacing is a ``SHARE`` of the gap, at least ``spacing``.

    The gap at a place is the sum of its distances to the two nearest walls. ``growth``: g of ``WantedSpacing``.
    """

    bodies: Sequence[Body]
    spacing: float
    growth: float = GROWTH
    within: float = 0.0

    def distance(self, places: np.ndarray, time: float) -> np.ndarray:
        """Return the distances (n,) from the source that have these spacings."""
        apart = np.array([body.nearest(places, time).distance for body in self.bodies])
        gap = np.maximum(np.sort(apart, axis=0)[:2], 0.0).sum(axis=0)
        return np.maximum(SHARE * gap - self.spacing, 0.0) / self.growth

    def placed(self, now: Callable[[Body], Body]) -> "InGaps":
        """Return the source with the bodies as they are ``now``."""
        return replace(self, bodies=tuple(map(now, self.bodies)))


@dataclass(frozen=True)
class WantedSpacing:
    """h(x, t), with the ``largest`` spacing H, the ``sources`` and the ``growth`` g."""

    largest: float
    sources: Sequence[Source] = ()
    growth: float = GROWTH

    @property
    def varies(self) -> bool:
        """Whether there is more than one spacing."""
        return self.smallest < self.largest

    @property
    def smallest(self) -> float:
        """Smallest spacing [length]."""
        return min([self.largest, *(source.spacing for source in self.sources)])

    def along(self, body: Body) -> float:
        """Return the largest spacing at t = 0 along those parts of the wall of a ``body`` that bend most."""
        if not self.varies:
            return self.largest
        shape = body.shape
        sharp = not 0.0 < shape.smallest_radius < np.inf
        outline = body.boundary_points(min(shape.length / PIECES, np.inf if sharp else 0.5 * shape.smallest_radius))
        bend = np.abs(outline.curvature)
        return float(self.at(outline.point[bend >= 0.9 * bend.max()]).max())

    def between(self, one: Body, other: Body, time: float) -> float:
        """Return the spacing in the middle of the gap between a closed wall and another one, or its own copy."""
        if not self.varies:
            return self.largest
        if one is other:
            offset = min(one.periodic_offsets(), key=np.linalg.norm)
            other = replace(one, centre=tuple(one.centre + offset), periods=(np.inf, np.inf))
        outline = one.boundary_points(one.shape.length / PIECES, time).point
        foot = other.nearest(outline, time)
        k = int(np.argmin(foot.distance))
        return float(self.at(0.5 * (outline[[k]] + foot.point[[k]]), time)[0])

    def at(self, places: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the spacings (n,) [length] at ``places`` (n, 2), in the frame of the scene, at ``time``."""
        spacing = np.full(len(places), self.largest)
        for source in self.sources:
            away = np.maximum(source.distance(places, time) - source.within, 0.0)
            spacing = np.minimum(spacing, source.spacing + self.growth * away)
        return spacing


FINER = 20.0
"""Points along the smallest spacing from which places on a wall are computed; distances have errors below 0.1 %."""


def graded_boundary(body: Body, wanted: WantedSpacing, time: float = 0.0, above_axis: bool = False) -> Boundary:
    """Return points of a ``body`` at the distances that are ``wanted`` at ``time``, in the frame of the body.

    ``above_axis``: the part at y > 0 alone, whose points do not lie on y = 0. The integral of a smooth f along the
    wall is sum(f * length) with an error of fourth order, whether h is smooth or not.
    """
    shape = body.shape
    fine = shape.boundary_points(shape.length / (2 * round(0.5 * FINER * shape.length / wanted.smallest)))
    places, step, closed = body.placed(fine, time).point, fine.length[0], shape.area > 0
    order = np.arange(len(places))
    if above_axis and not (places[:, 1] > 0.0).all():
        kept = places[:, 1] > 0.0
        first = int(np.argmax(kept & ~np.roll(kept, 1)))
        order, closed = np.roll(order, -first)[: np.count_nonzero(kept)], False
    point = fine.point[order]
    along = np.arange(len(order) + 1) * step
    number = np.append(0.0, np.cumsum(step / wanted.at(places[order], time)))
    count = max(3 if closed else 1, round(number[-1]))
    arc = np.interp((np.arange(count) + 0.5) * (number[-1] / count), number, along)
    ends = (point[-1], point[0]) if closed else (2 * point[0] - point[1], 2 * point[-1] - point[-2])
    around, middle = np.array([ends[0], *point, ends[1]]), np.append(along, along[-1] + step) - 0.5 * step
    foot = shape.nearest(np.stack([np.interp(arc, middle, values) for values in around.T], axis=1))
    return Boundary(foot.point, foot.normal, foot.curvature, _weights(arc, along[-1], closed))


def arc_lengths(shape: Shape, places: np.ndarray) -> np.ndarray:
    """Return the lengths (n,) along the outline of a ``shape`` up to ``places`` (n, 2) on it, to 1e-5 of its radii."""
    from scipy.spatial import cKDTree

    count = max(4.0, FINER * shape.length / shape.smallest_radius)  # of a straight wall 4
    fine = shape.boundary_points(shape.length / round(count))
    nearest = cKDTree(fine.point).query(places)[1]
    along = fine.normal[:, ::-1] * [-1.0, 1.0]
    along *= np.sign(along[0] @ (fine.point[1] - fine.point[0]))
    return fine.length[0] * (nearest + 0.5) + np.sum((places - fine.point[nearest]) * along[nearest], axis=1)


def _weights(arc: np.ndarray, length: float, closed: bool) -> np.ndarray:
    """Return the integrals (n,) along a wall of the cubic polynomials that are 1 at one of the places ``arc`` (n,).

    From place to place they go through the four places around; to the ends of a wall that is not ``closed`` through
    the nearest four.
    """
    count, points = len(arc), np.arange(4 if closed else min(4, len(arc)))
    edges = np.append(arc, arc[0] + length) if closed else np.concatenate([[0.0], arc, [length]])
    first = np.arange(len(edges) - 1) - (1 if closed else 2)
    nodes = (first if closed else np.clip(first, 0, count - len(points)))[:, None] + points
    at, half, weights = arc[nodes % count] + length * (nodes // count), 0.5 * np.diff(edges), np.zeros(count)
    for place in (-(3**-0.5), 3**-0.5):
        x = edges[:-1] + half * (1.0 + place)
        for k in points:
            others = np.delete(at, k, axis=1)
            basis = np.prod((x[:, None] - others) / (at[:, [k]] - others), axis=1)
            weights += np.bincount(nodes[:, k] % count, half * basis, count)
    return weights
