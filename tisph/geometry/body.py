"""A body: a wall that is somewhere, and moves as a rigid whole.

Velocity V + w x r and acceleration A + dw/dt x r - w^2 r of its points, r from its centre: the last part is the
centripetal one. In a periodic cell a body is all its copies: what is nearest, and what r is, goes by the nearest one.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from tisph.geometry._shape import Boundary, ClosestPoint, Shape
from tisph.geometry.free_motion import FreeMotion
from tisph.geometry.motion import REST, STILL, RigidMotion, WallMotion


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
