"""A body: a wall that is somewhere, and moves as a rigid whole.

Velocity V + w x r and acceleration A + dw/dt x r - w^2 r of its points, r from its centre: the last part is the
centripetal one. In a periodic cell a body is all its copies: what is nearest, and what r is, goes by the nearest one.

``gap`` and ``smallest_gap`` measure how close bodies and walls come to each other. A ``SlidingWall`` stays where it is
and slides along itself, with a speed that varies from place to place.
"""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial

from tisph.geometry.motion import REST, STILL, FreeMotion, RigidMotion, WallMotion
from tisph.geometry.shape import Boundary, ClosestPoint, Shape

POINTS = 1000
"""On each wall of a pair, from which distances to the other one are taken."""


def gap(one, other, time=0.0, points=POINTS):
    """Smallest distance [length] between two bodies, negative where they overlap.

    Between smooth walls good to 1e-6 of their size with 1000 ``points`` on each; a sharp corner may be missed by half a
    thousandth of the wall.
    Copies in a periodic cell count. Either may be a straight wall, two of them are parallel or meet.
    """
    both = [(one, other), (other, one)]
    distances = [_least(a, b, time, points) for a, b in both if math.isfinite(a.shape.length)]
    if not distances:
        raise ValueError("the gap between two straight walls needs their period: give them a length")
    return min(distances)


def smallest_gap(bodies, time=0.0, points=POINTS):
    """Smallest gap among ``bodies``, and the indices (i, j) of the two; (infinity, None) for one alone.

    A body in a periodic cell also meets its own copies: then i = j.
    """
    least = math.inf, ()
    for bound, pair in _bounds(bodies, time, points):
        if bound > least[0]:
            break
        least = min(least, (_gap_of(bodies, pair, time, points), pair))
    return least if math.isfinite(least[0]) else (least[0], None)


def _bounds(bodies, time, points):
    """Pairs (bound, (i, j)) of all bodies i <= j, the lowest bound first: no gap of two is below their bound."""
    count, in_fluid = len(bodies), np.array([_is_in_fluid(body) for body in bodies], dtype=bool)
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
    # half the distance of two points is more than what the parabola of ``_least`` takes off, an eighth at most
    slack = 0.5 * np.maximum(spacings, spacings[:, None])
    bounds = np.minimum(apart, apart.T) - radii - radii[:, None] - slack
    rows, columns = np.triu_indices(count)
    return sorted(zip(bounds[rows, columns].tolist(), zip(rows.tolist(), columns.tolist(), strict=True), strict=True))


def _is_in_fluid(body):
    return body.shape.area > 0 and body.shape.fluid_side == "outside"


def _gap_of(bodies, pair, time, points):
    i, j = pair
    return _gap_to_copies(bodies[i], time, points) if i == j else gap(bodies[i], bodies[j], time, points)


def _gap_to_copies(body, time, points):
    if not _is_in_fluid(body):
        return math.inf
    copies = [
        replace(body, centre=tuple(body.centre + offset), periods=(math.inf, math.inf))
        for offset in body.periodic_offsets()
    ]
    alone = replace(body, periods=(math.inf, math.inf))
    return min((gap(alone, copy, time, points) for copy in copies), default=math.inf)


def _least(one, other, time, points):
    """Least distance of the points of ``one`` from ``other``: a parabola through the least and its neighbours."""
    distance = other.nearest(one.boundary_points(one.shape.length / points, time).point, time).distance
    k = int(np.argmin(distance))
    before, least, after = distance[k - 1], distance[k], distance[(k + 1) % len(distance)]
    bend = before - 2 * least + after
    return float(least - (after - before) ** 2 / (8 * bend)) if bend > 0 else float(least)


@dataclass(frozen=True)
class Placement:
    """Where a body is: its ``centre`` (2,), and the ``angle`` by which it is turned counterclockwise."""

    centre: np.ndarray
    angle: float

    def rotated(self, vectors):
        """Vectors (n, 2) of the body's frame as seen from outside."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return vectors @ np.array([[cosine, sine], [-sine, cosine]])

    def rotated_back(self, vectors):
        """Vectors (n, 2) as seen in the body's frame."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        return vectors @ np.array([[cosine, -sine], [sine, cosine]])

    def to_lab_frame(self, points):
        """Places (n, 2) of the body's frame as seen from outside."""
        return self.centre + self.rotated(points)

    def to_body_frame(self, points):
        """Places (n, 2) in the body's frame."""
        return self.rotated_back(points - self.centre)


@dataclass(frozen=True)
class Body:
    """``shape``, whose origin is at ``centre`` (2,) and which is turned by ``angle`` at t = 0, and its ``motion``.

    ``periods`` (2,) of the cell along x and y, infinite where it is not periodic. ``spin``: angular velocity [1/time]
    around the axis y = 0 of a wall that is a surface of revolution, in axisymmetric flow. ValueError for a line that
    turns.
    """

    shape: Shape
    centre: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0
    motion: RigidMotion | FreeMotion = REST
    periods: tuple[float, float] = (math.inf, math.inf)
    spin: WallMotion = STILL

    def __post_init__(self):
        if self.shape.smallest_radius == math.inf and self.motion.rotation.largest_speed:
            raise ValueError("a straight wall without ends cannot turn: give it no angular velocity")
        if not all(period > 0 for period in self.periods):
            raise ValueError(f"periods are above 0, infinite where there is none, not {self.periods}")

    @property
    def free(self):
        """Whether the flow moves it: ``motion`` is a ``FreeMotion`` then."""
        return self.motion.free

    @property
    def crosses_axis(self):
        """Whether it is on both sides of the axis y = 0 at t = 0, as half of it alone is in axisymmetric flow."""
        return bool(self.shape.area) and self.boundary_points(self.shape.length / 100).point[:, 1].min() < 0.0

    @property
    def bounding_radius(self):
        """Radius of a circle around the centre that the wall is within."""
        return float(np.linalg.norm(np.abs(self.shape.extent).max(axis=0)))

    def at(self, time=0.0):
        """Where the body is; a periodic cell does not bring it back."""
        motion = self.motion
        return Placement(
            self.centre + motion.displacement(time), self.angle + float(motion.rotation.displacement(time))
        )

    def nearest(self, points, time=0.0):
        """``ClosestPoint`` on the wall to each of ``points`` (n, 2), on the copy of the body that is nearest."""
        points, place = np.asarray(points, dtype=float), self.at(time)
        copy = self.nearest_copy(points - place.centre)
        foot = self._foot(points, copy, place)
        for offset in self.periodic_offsets() if self.shape.fluid_side == "outside" else ():
            other = copy + offset
            nearer = np.linalg.norm(points - place.centre - other, axis=1) - self.bounding_radius < foot.distance
            if nearer.any():
                self._take_nearer(foot, nearer, self._foot(points[nearer], other[nearer], place))
        return foot

    def images(self, points, cutoff, time=0.0):
        """Mirror images (k, 2) of those of ``points`` (n, 2) that are within ``cutoff``, and whose (k,) they are."""
        points, place = np.asarray(points, dtype=float), self.at(time)
        copy = self.nearest_copy(points - place.centre)
        images, whose = self.shape.images(place.to_body_frame(points - copy), cutoff)
        return place.to_lab_frame(images) + copy[whose], whose

    def boundary_points(self, spacing, time=0.0):
        """Points of the wall about ``spacing`` apart, a ``Boundary``: the same points of the body at every time."""
        return self.placed(self.shape.boundary_points(spacing), time)

    def placed(self, boundary, time=0.0):
        """The points ``boundary`` of the shape as seen from outside."""
        place = self.at(time)
        point, normal = place.to_lab_frame(boundary.point), place.rotated(boundary.normal)
        return Boundary(point, normal, boundary.curvature, boundary.length)

    def velocity(self, points, time=0.0):
        """Velocity (n, 2) of the solid at ``points`` (n, 2)."""
        rotation = self.motion.rotation.velocity(time)
        return self.motion.velocity(time) + rotation * _quarter(self._from_centre(points, time))

    def tangential_gradient(self, points, tangents, time=0.0):
        """Derivatives (n, 2) of the solid's velocity along ``tangents`` (n, 2) at ``points`` (n, 2)."""
        return self.motion.rotation.velocity(time) * _quarter(tangents)

    def acceleration(self, points, time=0.0):
        """Acceleration (n, 2) of the solid's material points that are at ``points`` (n, 2); jumps left out."""
        rotation, from_centre = self.motion.rotation, self._from_centre(points, time)
        change = rotation.acceleration(time) * _quarter(from_centre) - rotation.velocity(time) ** 2 * from_centre
        return self.motion.acceleration(time) + change

    def _from_centre(self, points, time):
        away = np.asarray(points, dtype=float) - self.at(time).centre
        return away - self.nearest_copy(away)

    def nearest_copy(self, away):
        """Whole periods (..., 2) from the centre to its copy that is nearest to places ``away`` (..., 2) from it."""
        copy = np.zeros_like(away)
        for axis, period in enumerate(self.periods):
            if math.isfinite(period):
                copy[..., axis] = period * np.round(away[..., axis] / period)
        return copy

    def periodic_offsets(self):
        """Offsets (2,) from the body to its copies around it in a periodic cell."""
        steps = [(-1, 0, 1) if math.isfinite(period) else (0,) for period in self.periods]
        periods = [period if math.isfinite(period) else 0.0 for period in self.periods]
        for step in itertools.product(*steps):
            if any(step):
                yield np.multiply(step, periods)

    def _foot(self, points, copy, place):
        foot = self.shape.nearest(place.to_body_frame(points - copy))
        return ClosestPoint(
            place.to_lab_frame(foot.point) + copy, place.rotated(foot.normal), foot.curvature, foot.distance
        )

    @staticmethod
    def _take_nearer(foot, asked, other):
        """Write into ``foot`` where ``other``, of the places ``asked`` (n,), is nearer."""
        better = other.distance < foot.distance[asked]
        rows = np.flatnonzero(asked)[better]
        for name in ("point", "normal", "curvature", "distance"):
            getattr(foot, name)[rows] = getattr(other, name)[better]


def _quarter(vectors):
    """Return vectors (n, 2) turned by a right angle counterclockwise."""
    return vectors[:, ::-1] * [-1.0, 1.0]


@dataclass(frozen=True, kw_only=True)
class SlidingWall(Body):
    """A body, a line along x, that slides along x with ``speed`` times ``profile``, a polynomial in x/``width``."""

    speed: float
    width: float
    profile: Polynomial

    def _along(self, points, polynomial):
        values = polynomial(np.asarray(points, dtype=float)[:, 0] / self.width)
        return np.stack([values, np.zeros(len(values))], axis=1)

    def velocity(self, points, time=0.0):
        """Velocity (n, 2) of the wall at ``points`` (n, 2)."""
        return self.speed * self._along(points, self.profile)

    def departure_point(self, points, elapsed):
        """Where (n, 2) the wall's material at ``points`` (n, 2) was a time ``elapsed`` ago: a step of Runge-Kutta."""
        start = np.asarray(points, dtype=float)
        first = -elapsed * self.velocity(start)
        second = -elapsed * self.velocity(start + 0.5 * first)
        third = -elapsed * self.velocity(start + 0.5 * second)
        return start + (first + 2.0 * (second + third) - elapsed * self.velocity(start + third)) / 6.0

    def tangential_gradient(self, points, tangents, time=0.0):
        """Derivatives (n, 2) of the wall's velocity along ``tangents`` (n, 2) at ``points`` (n, 2)."""
        return self.speed / self.width * self._along(points, self.profile.deriv()) * tangents[:, :1]

    def acceleration(self, points, time=0.0):
        """Acceleration (n, 2) of its material at ``points`` (n, 2), which is carried along it."""
        return self.speed**2 / self.width * self._along(points, self.profile * self.profile.deriv())
