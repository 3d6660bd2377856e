"""A body: a wall at a place that moves as a rigid whole.

Its points have the velocity V + w x r and the acceleration A + dw/dt x r - w^2 r, with r from its centre. In a periodic
cell a body stands for all its copies: nearest points and r belong to the nearest copy.

``gap`` and ``smallest_gap`` measure how close bodies and walls come to each other. A ``SlidingWall`` stays where it is
and slides along itself, with a speed that varies from place to place.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.polynomial import Polynomial

from tisph.geometry.motion import REST, STILL, FreeMotion, RigidMotion, Schedule, SmoothSchedule, WallMotion
from tisph.geometry.shape import Boundary, ClosestPoint, Shape

POINTS = 1000
"""Points on each wall of a pair, from which distances to the other wall are computed."""


@dataclass(frozen=True)
class Placement:
    """Place of a body: its ``centre`` (2,), and the ``angle`` of its frame, counterclockwise.

    The frame of the simulation is the lab frame. Vectors and points have shape (n, 2).
    """

    centre: np.ndarray
    angle: float

    def rotated(self, vectors: np.ndarray) -> np.ndarray:
        """Return ``vectors`` of the body's frame in the lab frame."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return vectors @ np.array([[cosine, sine], [-sine, cosine]])

    def rotated_back(self, vectors: np.ndarray) -> np.ndarray:
        """Return ``vectors`` of the lab frame in the body's frame."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return vectors @ np.array([[cosine, -sine], [sine, cosine]])

    def to_lab_frame(self, points: np.ndarray) -> np.ndarray:
        """Return ``points`` of the body's frame in the lab frame."""
        return self.centre + self.rotated(points)

    def to_body_frame(self, points: np.ndarray) -> np.ndarray:
        """Return ``points`` of the lab frame in the body's frame."""
        return self.rotated_back(points - self.centre)


@dataclass(frozen=True)
class BodyState(Placement):
    """A ``body`` at one ``time``: its place, from which points and velocities of the wall follow.

    A step finds the place once, and takes points, distances and velocities from it.
    """

    body: "Body"
    time: float

    def nearest(self, points: np.ndarray) -> ClosestPoint:
        """Return the closest points of the wall to ``points``, on the nearest copy of the body."""
        points, body = np.asarray(points, dtype=float), self.body
        copy = body.nearest_copy(points - self.centre)
        foot = self._foot(points, copy)
        for offset in body.periodic_offsets() if body.in_fluid else ():
            other = copy + offset
            nearer = np.linalg.norm(points - self.centre - other, axis=1) - body.bounding_radius < foot.distance
            if nearer.any():
                its = self._foot(points[nearer], other[nearer])
                better = its.distance < foot.distance[nearer]
                rows = np.flatnonzero(nearer)[better]
                for name in ("point", "normal", "curvature", "distance"):
                    getattr(foot, name)[rows] = getattr(its, name)[better]
        return foot

    def _foot(self, points: np.ndarray, copy: np.ndarray) -> ClosestPoint:
        """Return the closest points to ``points`` on the copies at offsets ``copy`` (n, 2) from the body."""
        foot = self.body.shape.nearest(self.to_body_frame(points - copy))
        point, normal = self.to_lab_frame(foot.point) + copy, self.rotated(foot.normal)
        return ClosestPoint(point, normal, foot.curvature, foot.distance)

    def placed(self, boundary: Boundary) -> Boundary:
        """Return the points ``boundary`` of the shape in the lab frame."""
        point, normal = self.to_lab_frame(boundary.point), self.rotated(boundary.normal)
        return Boundary(point, normal, boundary.curvature, boundary.length)

    def from_centre(self, points: np.ndarray) -> np.ndarray:
        """Return the vectors to ``points`` from the centre of the nearest copy."""
        away = np.asarray(points, dtype=float) - self.centre
        return away - self.body.nearest_copy(away)

    def velocity(self, points: np.ndarray) -> np.ndarray:
        """Return the velocity of the solid at ``points``."""
        return self.body.point_velocity(points, self)

    def acceleration(self, points: np.ndarray) -> np.ndarray:
        """Return the acceleration of the solid's material at ``points``, without jumps."""
        return self.body.point_acceleration(points, self)


@dataclass(frozen=True)
class Body:
    """``shape`` with its origin at ``centre`` (2,), turned by ``angle`` at t = 0, and its ``motion``.

    ``periods`` (2,) of the cell along x and y, infinite where it is not periodic. ``spin``: angular velocity [1/time]
    around the axis y = 0 of a wall that is a surface of revolution, in axisymmetric flow. ``enters``: time from which
    it is in the fluid. ``slip_length`` [length]: the fluid at the wall is faster than the wall by this times the shear
    stress over the viscosity. ValueError for a line that turns. Points, velocities and accelerations have shape (n, 2).
    """

    solid: ClassVar[bool] = True
    """Whether it is a body or a wall, and no end that the fluid passes through."""

    shape: Shape
    centre: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0
    motion: RigidMotion | FreeMotion = REST
    periods: tuple[float, float] = (math.inf, math.inf)
    spin: Any = STILL
    enters: float = -math.inf
    slip_length: float = 0.0

    def __post_init__(self) -> None:
        if self.shape.smallest_radius == math.inf and self.motion.rotation.largest_speed:
            raise ValueError("a straight wall without ends cannot turn: give it no angular velocity")
        if not all(period > 0 for period in self.periods):
            raise ValueError(f"periods are above 0, infinite where there is none, not {self.periods}")

    @property
    def moves_fluid(self) -> bool:
        """Whether the fluid at the wall has the velocity of the wall."""
        return not self.slip_length

    def load_name(self, centre: np.ndarray) -> tuple[str, str]:
        """Return the load of the fluid on the body at ``centre`` (2,), and its place, in words."""
        return "force", f"on the body at ({centre[0]:.4g}, {centre[1]:.4g})"

    @property
    def free(self) -> bool:
        """Whether the flow moves it; ``motion`` is then a ``FreeMotion``."""
        return self.motion.free

    @property
    def steady(self) -> bool:
        """Whether its wall stays where it is, with velocities that never change."""
        return not (self.free or self.motion.largest_speed(1.0))

    @property
    def in_fluid(self) -> bool:
        """Whether it is a closed wall with the fluid outside."""
        return self.shape.area > 0 and self.shape.fluid_side == "outside"

    @property
    def crosses_axis(self) -> bool:
        """Whether it is on both sides of the axis y = 0 at t = 0; in axisymmetric flow half of it counts."""
        return bool(self.shape.area) and self.boundary_points(self.shape.length / 100).point[:, 1].min() < 0.0

    @property
    def bounding_radius(self) -> float:
        """Radius of a circle around the centre that contains the wall."""
        return float(np.linalg.norm(np.abs(self.shape.extent).max(axis=0)))

    def at(self, time: float = 0.0) -> BodyState:
        """Return the body at ``time``; its place is not wrapped into a periodic cell."""
        displacement, angle = self.motion.travel(time)
        return BodyState(self.centre + displacement, self.angle + angle, self, time)

    def nearest(self, points: np.ndarray, time: float = 0.0) -> ClosestPoint:
        """Return the closest points of the wall to ``points``, on the nearest copy of the body."""
        return self.at(time).nearest(points)

    def images(
        self, points: np.ndarray, cutoff: float | np.ndarray, time: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return mirror images (k, 2) of ``points`` within ``cutoff`` of the wall, and indices (k,) of the points."""
        points, place = np.asarray(points, dtype=float), self.at(time)
        copy = self.nearest_copy(points - place.centre)
        images, source = self.shape.images(place.to_body_frame(points - copy), cutoff)
        return place.to_lab_frame(images) + copy[source], source

    def boundary_points(self, spacing: float, time: float = 0.0) -> Boundary:
        """Return points of the wall about ``spacing`` apart: the same points of the body at every time."""
        return self.placed(self.shape.boundary_points(spacing), time)

    def placed(self, boundary: Boundary, time: float = 0.0) -> Boundary:
        """Return the points ``boundary`` of the shape in the lab frame."""
        return self.at(time).placed(boundary)

    def velocity(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the velocity of the solid at ``points``."""
        return self.at(time).velocity(points)

    def point_velocity(self, points: np.ndarray, state: BodyState) -> np.ndarray:
        """Return the velocity of the solid at ``points``, from the ``state`` of the body."""
        velocity, rotation = self.motion.rates(state.time)
        return velocity + rotation * _quarter(state.from_centre(points))

    def tangential_gradient(self, points: np.ndarray, tangents: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the derivative of the solid's velocity along ``tangents`` (n, 2) at ``points``."""
        return self.motion.rotation.velocity(time) * _quarter(tangents)

    def acceleration(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the acceleration of the solid's material at ``points``, without jumps."""
        return self.at(time).acceleration(points)

    def point_acceleration(self, points: np.ndarray, state: BodyState) -> np.ndarray:
        """Return the acceleration of the solid's material at ``points``, from the ``state`` of the body."""
        rotation, from_centre, time = self.motion.rotation, state.from_centre(points), state.time
        change = rotation.acceleration(time) * _quarter(from_centre) - rotation.velocity(time) ** 2 * from_centre
        return self.motion.acceleration(time) + change

    def nearest_copy(self, away: np.ndarray) -> np.ndarray:
        """Return the offset (..., 2), whole periods, of the copy that is nearest to places ``away`` from the centre."""
        copy = np.zeros_like(away)
        for axis, period in enumerate(self.periods):
            if math.isfinite(period):
                copy[..., axis] = period * np.round(away[..., axis] / period)
        return copy

    def periodic_offsets(self) -> Iterator[np.ndarray]:
        """Yield the offsets (2,) from the body to its copies around it in a periodic cell."""
        steps = [(-1, 0, 1) if math.isfinite(period) else (0,) for period in self.periods]
        periods = [period if math.isfinite(period) else 0.0 for period in self.periods]
        for step in itertools.product(*steps):
            if any(step):
                yield np.multiply(step, periods)


def _quarter(vectors: np.ndarray) -> np.ndarray:
    """Return vectors (n, 2) turned by a right angle counterclockwise."""
    return vectors[:, ::-1] * [-1.0, 1.0]


@dataclass(frozen=True, kw_only=True)
class SlidingWall(Body):
    """A line along x that slides along x with the velocity ``course`` * ``profile``, a polynomial in x/``width``."""

    course: WallMotion | Schedule | SmoothSchedule
    width: float
    profile: Polynomial

    @property
    def steady(self) -> bool:
        """See ``Body.steady``."""
        return not self.course.oscillates

    def _along(self, points: np.ndarray, polynomial: Polynomial) -> np.ndarray:
        values = polynomial(np.asarray(points, dtype=float)[:, 0] / self.width)
        return np.stack([values, np.zeros(len(values))], axis=1)

    def point_velocity(self, points: np.ndarray, state: BodyState) -> np.ndarray:
        """Return the velocity of the wall at ``points``, from its ``state``."""
        return self.course.velocity(state.time) * self._along(points, self.profile)

    def departure_point(self, points: np.ndarray, elapsed: float, time: float) -> np.ndarray:
        """Return where the material at ``points`` at ``time`` was ``elapsed`` before, by a step of Runge-Kutta."""
        start, middle, before = np.asarray(points, dtype=float), time - 0.5 * elapsed, time - elapsed
        first = -elapsed * self.velocity(start, time)
        second = -elapsed * self.velocity(start + 0.5 * first, middle)
        third = -elapsed * self.velocity(start + 0.5 * second, middle)
        return start + (first + 2.0 * (second + third) - elapsed * self.velocity(start + third, before)) / 6.0

    def tangential_gradient(self, points: np.ndarray, tangents: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the derivative of the wall's velocity along ``tangents`` (n, 2) at ``points``."""
        return self.course.velocity(time) / self.width * self._along(points, self.profile.deriv()) * tangents[:, :1]

    def point_acceleration(self, points: np.ndarray, state: BodyState) -> np.ndarray:
        """Return the acceleration of the wall's material at ``points``: du/dt + u du/dx."""
        speed, acceleration = self.course.velocity(state.time), self.course.acceleration(state.time)
        carried = speed**2 / self.width * self._along(points, self.profile * self.profile.deriv())
        return carried + acceleration * self._along(points, self.profile)


def gap(one: Body, other: Body, time: float = 0.0, points: int = POINTS) -> float:
    """Return the smallest distance [length] between two bodies, copies included; negative where they overlap.

    Between smooth walls it is correct to 1e-6 of their size with 1000 ``points`` on each; a sharp corner may be missed
    by half a thousandth of the wall. Either may be a straight wall; two straight walls must be parallel or meet.
    """
    both = [(one, other), (other, one)]
    distances = [_least_distance(a, b, time, points) for a, b in both if math.isfinite(a.shape.length)]
    if not distances:
        raise ValueError("the gap between two straight walls needs their period: give them a length")
    return min(distances)


def _least_distance(one: Body, other: Body, time: float, points: int) -> float:
    """Return the least distance of points of ``one`` from ``other``, by a parabola through the three least values."""
    distance = other.nearest(one.boundary_points(one.shape.length / points, time).point, time).distance
    k = int(np.argmin(distance))
    if not 0 < k < len(distance) - 1 and one.shape.smallest_radius < math.inf and not one.shape.area:
        return float(distance[k])  # at an end of a wall with corners, whose points go on nowhere
    before, least, after = distance[k - 1], distance[k], distance[(k + 1) % len(distance)]
    bend = before - 2 * least + after
    return float(least - (after - before) ** 2 / (8 * bend)) if bend > 0 else float(least)


def smallest_gap(
    bodies: Sequence[Body], time: float = 0.0, points: int = POINTS, below: float = math.inf
) -> tuple[float, tuple[int, int] | None]:
    """Return the smallest gap among ``bodies`` and the indices (i, j) of the two.

    (infinity, None) for one alone, and where no gap can be ``below`` a given one. i = j for a body and its own copy in
    a periodic cell.
    """
    least, closest = math.inf, None
    for bound, (i, j) in _bounds(bodies, time, points):
        if bound > min(least, below):
            break
        apart = _apart(bodies[i], bodies[j], time, points)
        if apart < least or (closest and apart == least and (i, j) < closest):
            least, closest = apart, (i, j)
    return least, closest


def gaps_below(
    bodies: Sequence[Body], below: float, time: float = 0.0, points: int = POINTS
) -> list[tuple[float, int, int]]:
    """Return the gaps among ``bodies`` that are smaller than ``below``, each with the indices i <= j of the two."""
    pairs = [pair for bound, pair in _bounds(bodies, time, points) if bound < below]
    found = [(_apart(bodies[i], bodies[j], time, points), i, j) for i, j in pairs]
    return [each for each in found if each[0] < below]


def _apart(one: Body, other: Body, time: float, points: int) -> float:
    """Return the gap between two bodies, or between a body and its own copy; infinite for a wall and itself."""
    if one is not other:
        return gap(one, other, time, points)
    if not one.in_fluid:
        return math.inf
    alone = replace(one, periods=(math.inf, math.inf))
    copies = [replace(alone, centre=tuple(one.centre + offset)) for offset in one.periodic_offsets()]
    return min((gap(alone, copy, time, points) for copy in copies), default=math.inf)


def _bounds(bodies: Sequence[Body], time: float, points: int) -> list[tuple[float, tuple[int, int]]]:
    """Return pairs (bound, (i, j)) of all bodies i <= j, the lowest bound first: no gap is smaller than its bound."""
    count, in_fluid = len(bodies), np.array([body.in_fluid for body in bodies], dtype=bool)
    centres = np.array([body.at(time).centre for body in bodies]).reshape(count, 2)
    lengths = np.array([body.shape.length for body in bodies])
    spacings = np.where(np.isfinite(lengths), lengths, 0.0) / points
    radii, apart = np.zeros(count), np.full((count, count), -math.inf)
    for i, body in enumerate(bodies):
        if in_fluid[i]:
            outline = body.shape.boundary_points(spacings[i]).point
            radii[i] = np.linalg.norm(outline, axis=1).max() + spacings[i]
            away = centres[in_fluid] - centres[i]
            apart[i, in_fluid] = np.linalg.norm(away - body.nearest_copy(away), axis=1)
            apart[i, i] = min(body.periods)
        else:  # two walls have no bound
            apart[i, in_fluid] = apart[in_fluid, i] = body.nearest(centres[in_fluid], time).distance
    # half the distance of two points exceeds the correction by the parabola of ``_least_distance``, an eighth at most
    slack = 0.5 * np.maximum(spacings, spacings[:, None])
    bounds = np.minimum(apart, apart.T) - radii - radii[:, None] - slack
    rows, columns = np.triu_indices(count)
    return sorted(zip(bounds[rows, columns].tolist(), zip(rows.tolist(), columns.tolist(), strict=True), strict=True))
