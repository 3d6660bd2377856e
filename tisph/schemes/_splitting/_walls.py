"""Walls as the scheme sees them: points on them, about a spacing apart, and where they are seen from a particle.

The points are neighbours of known velocity, there are no ghosts. Near walls operators reach farther, because only a
part of a disc around a particle holds any liquid: without that they are unstable.
"""

import numpy as np

REACH = 2.9
"""Distance from a wall below which operators reach farther, in particle spacings."""

FARTHER = 1.2
"""By how much they reach farther at a wall, in particle spacings; where two walls are near this adds up.

Particles lie in layers along a straight wall: with 0.8 too few are within reach for the fourth derivative across them.
"""

FARTHEST = 0.4
"""The same of the points on walls, beside that: liquid is on one side of them only."""

SEEN = 2
"""Walls that a particle knows of: the nearest ones."""


class Walls:
    """Points on the walls of ``bodies``; all places are those in the box of a flow, whose lowest corner is ``origin``.

    ``count`` of them, each for a part of the wall of ``length`` (count,), ``body`` (count,) says of which one.
    """

    def __init__(self, bodies, spacing, origin, start_time):
        self.bodies, self.spacing, self.origin = bodies, spacing, np.array(origin)
        boundaries = [body.boundary_points(spacing, start_time) for body in bodies]
        self.length = np.concatenate([boundary.length for boundary in boundaries])
        self.body = np.repeat(np.arange(len(bodies)), [len(boundary.length) for boundary in boundaries])
        self.count = len(self.length)

    def at(self, time):
        """Return places, normals into the liquid and velocities of the points at ``time``, (count, 2) each."""
        boundaries = [body.boundary_points(self.spacing, time) for body in self.bodies]
        velocities = [body.velocity(part.point, time) for body, part in zip(self.bodies, boundaries, strict=True)]
        place = np.concatenate([boundary.point for boundary in boundaries])
        return place - self.origin, np.concatenate([part.normal for part in boundaries]), np.concatenate(velocities)

    def sums(self, traction, time):
        """Return force and torque (bodies, 3) on each body of a ``traction`` (count, 2) on the points."""
        force, result = self.length[:, None] * traction, np.zeros((len(self.bodies), 3))
        for number, body in enumerate(self.bodies):
            of = self.body == number
            arm = body.boundary_points(self.spacing, time).point - body.at(time).centre
            torque = arm[:, 0] * force[of, 1] - arm[:, 1] * force[of, 0]
            result[number] = [*force[of].sum(axis=0), torque.sum()]
        return result

    def acceleration(self, time):
        """Return the accelerations (count, 2) of the points at ``time``."""
        parts = [body.boundary_points(self.spacing, time).point for body in self.bodies]
        return np.concatenate([body.acceleration(part, time) for body, part in zip(self.bodies, parts, strict=True)])

    def seen(self, place, time):
        """Return the tangents to the nearest walls of each of the places (n, 2), as the nearest points see them.

        An array (n, SEEN, 3): normal, then offset, normal . x - offset being the distance, 1e30 of a wall that is not.
        And the distances (n, SEEN) themselves, infinite there.
        """
        planes, distances = np.zeros((len(place), SEEN, 3)), np.full((len(place), SEEN), np.inf)
        planes[:, :, 2] = -1e30
        for body in self.bodies:
            foot = body.nearest(place + self.origin, time)
            plane = np.column_stack([foot.normal, np.sum(foot.normal * (foot.point - self.origin), axis=1)])
            nearest = foot.distance < distances[:, 0]
            second = ~nearest & (foot.distance < distances[:, 1])
            planes[nearest, 1], distances[nearest, 1] = planes[nearest, 0], distances[nearest, 0]
            planes[nearest, 0], distances[nearest, 0] = plane[nearest], foot.distance[nearest]
            planes[second, 1], distances[second, 1] = plane[second], foot.distance[second]
        return planes, distances

    def stretch(self, distances, support):
        """Return the part by which operators with this ``support``, in spacings, reach farther at such distances."""
        near = np.clip(1.0 - distances / (REACH * self.spacing), 0.0, 1.0).sum(axis=1)
        return 1.0 + FARTHER / support * near
