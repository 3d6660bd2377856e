"""Walls as the scheme sees them: points on them, about a spacing apart, and where they are seen from a particle.

The points are neighbours of known velocity, there are no ghosts. Near walls operators reach farther, because only a
part of a disc around a particle holds any liquid: without that they are unstable.
"""

import itertools

import numpy as np

from tisph.geometry.sliding import SlidingWall

REACH = 2.9
"""Distance from a wall below which operators reach farther, in particle spacings."""

FARTHER = 1.2
"""By how much they reach farther at a wall, in particle spacings; where two walls are near this adds up.

Particles lie in layers along a straight wall: with 0.8 too few are within reach for the fourth derivative across them.
"""

FARTHEST = 0.4
"""The same of the points on walls, beside that: liquid is on one side of them only."""

BENT = 6.0
"""Distance from a wall, in particle spacings, up to which operators go by its curvature."""

LEAST_RADIUS, LEAST_INSIDE = 2.5, 7.0
"""Distance from the centre of curvature, in particle spacings, from which on they do: with the body, or the liquid,
around it. Particles see as far as 4.5 and more, and the other side of the centre is no continuation of this one."""

SEEN = 2
"""Walls that a particle knows of: the nearest ones."""


class Walls:
    """Points on the walls of ``bodies``; all places are those in the box of a flow, whose lowest corner is ``origin``.

    There are ``count``, each for a part of the wall of ``length`` (count,); ``parts`` are slices of them by body.
    """

    def __init__(self, bodies, spacing, origin):
        self.bodies, self.spacing, self.origin = bodies, spacing, np.array(origin)
        self.outlines = [body.shape.boundary_points(spacing) for body in bodies]
        self.length = np.concatenate([outline.length for outline in self.outlines])
        ends = np.cumsum([0, *(len(outline.length) for outline in self.outlines)])
        self.parts = [slice(first, last) for first, last in itertools.pairwise(ends)]
        self.count = len(self.length)
        self.curved = any(0.0 < body.shape.smallest_radius < np.inf for body in bodies)
        self._kept = None, None

    def at(self, time):
        """Return places, normals into the liquid and velocities of the points at ``time``, (count, 2) each."""
        boundaries = self._placed(time)
        velocities = [body.velocity(part.point, time) for body, part in zip(self.bodies, boundaries, strict=True)]
        place = np.concatenate([boundary.point for boundary in boundaries])
        return place - self.origin, np.concatenate([part.normal for part in boundaries]), np.concatenate(velocities)

    def acceleration(self, time):
        """Return the accelerations (count, 2) of the points at ``time``."""
        pairs = zip(self.bodies, self._placed(time), strict=True)
        return np.concatenate([body.acceleration(boundary.point, time) for body, boundary in pairs])

    def carried(self, values, elapsed, time):
        """Return ``values`` (ages, numbers, count), each ``elapsed`` (ages,) ago, where what is at the points was then.

        Walls that slide along themselves carry them past the points, which stay: between those by cubic splines.
        """
        from scipy.interpolate import CubicSpline  # only walls that slide need it

        result = values.copy()
        for body, boundary, part in zip(self.bodies, self._placed(time), self.parts, strict=True):
            if isinstance(body, SlidingWall):
                order = np.argsort(boundary.point[:, 0])
                for age, gone in enumerate(elapsed):
                    curve = CubicSpline(boundary.point[order, 0], values[age][:, part][:, order], axis=1)
                    result[age][:, part] = curve(body.came_from(boundary.point, gone)[:, 0])
        return result

    def gradients(self, gradients, time):
        """Return velocity gradients (2, 2, count), du_a/dx_b, on the points with what is known of them there.

        Along a wall the liquid's velocity varies as the wall's, and its divergence is 0: measured is the shear alone.
        """
        boundaries = self._placed(time)
        normal = np.concatenate([part.normal for part in boundaries]).T
        tangent = np.stack([normal[1], -normal[0]])
        pairs = zip(self.bodies, boundaries, strict=True)
        tangents = (np.stack([part.normal[:, 1], -part.normal[:, 0]], axis=1) for part in boundaries)
        parts = [body.strain(part.point, along, time) for (body, part), along in zip(pairs, tangents, strict=True)]
        strain = np.concatenate(parts).T
        shear = np.einsum("abn,an,bn->n", gradients, tangent, normal)
        across = shear * tangent - np.sum(strain * tangent, axis=0) * normal
        return across[:, None] * normal + strain[:, None] * tangent

    def sums(self, tractions, time):
        """Return force and torque (n, bodies, 3) on each body of n ``tractions`` (n, count, 2) on the points."""
        force, result = self.length[:, None] * tractions, np.zeros((len(tractions), len(self.bodies), 3))
        for number, (body, boundary) in enumerate(zip(self.bodies, self._placed(time), strict=True)):
            arm, part = boundary.point - body.at(time).centre, force[:, self.parts[number]]
            result[:, number, :2] = part.sum(axis=1)
            result[:, number, 2] = (arm[:, 0] * part[..., 1] - arm[:, 1] * part[..., 0]).sum(axis=1)
        return result

    def means(self, values):
        """Return the means (bodies,) along each wall of ``values`` (count,) at the points."""
        return np.array([np.average(values[part], weights=self.length[part]) for part in self.parts])

    def _placed(self, time):
        """Return the points by body at ``time``; those of the last time are kept, which are asked for twice a step."""
        if self._kept[0] != time:
            pairs = zip(self.bodies, self.outlines, strict=True)
            self._kept = time, [body.placed(outline, time) for body, outline in pairs]
        return self._kept[1]

    def seen(self, place, time):
        """Return the tangents to the nearest walls of each of the places (n, 2), as the nearest points see them.

        An array (n, SEEN, 3): normal, then offset, normal . x - offset being the distance, 1e30 of a wall that is not.
        The distances (n, SEEN) themselves, infinite there. And the curvatures (n, SEEN) of the walls.
        """
        count = max(SEEN, len(self.bodies))
        planes, distances = np.zeros((len(place), count, 3)), np.full((len(place), count), np.inf)
        planes[:, len(self.bodies) :, 2] = -1e30
        curvatures = np.zeros((len(place), count))
        places = place + self.origin
        for number, body in enumerate(self.bodies):
            foot = body.nearest(places, time)
            planes[:, number, :2], distances[:, number] = foot.normal, foot.distance
            planes[:, number, 2] = ((foot.point - self.origin) * foot.normal).sum(axis=1)
            curvatures[:, number] = foot.curvature
        nearest = np.argsort(distances, axis=1, kind="stable")[:, :SEEN]
        planes = np.take_along_axis(planes, nearest[..., None], 1)
        return planes, *(np.take_along_axis(values, nearest, 1) for values in (distances, curvatures))

    def bend(self, planes, distances, curvatures):
        """Return the ``bend`` of rows (n, 2), conjugate inverse of the way from the centre, where this is ``seen``."""
        normal, distance, curvature = planes[:, 0, :2], distances[:, 0], curvatures[:, 0]
        radius = 1.0 / np.where(curvature, curvature, 1e-30) + distance
        least = self.spacing * np.where(curvature > 0.0, LEAST_RADIUS, LEAST_INSIDE)
        bent = (curvature != 0.0) & (distance < BENT * self.spacing) & (radius * np.sign(curvature) > least)
        return np.where(bent, 1.0 / radius, 0.0)[:, None] * normal * [1.0, -1.0]

    def stretch(self, distances, support):
        """Return the part by which operators with this ``support``, in spacings, reach farther at such distances."""
        near = np.clip(1.0 - distances / (REACH * self.spacing), 0.0, 1.0).sum(axis=1)
        return 1.0 + FARTHER / support * near
