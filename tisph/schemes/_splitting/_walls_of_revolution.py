"""Walls of axisymmetric flow: curves in the half-plane y >= 0, each that of a surface of revolution around y = 0.

Velocities are the unknowns of ``_coordinates``: u, v/r and w/r. What such a wall is to the other half-plane is no wall
to the fluid: points are those with y > 0.
"""

import numpy as np

from tisph.geometry.shape import Boundary
from tisph.schemes._splitting._wall_points import WallPoints

NEAR_AXIS = 2.0
"""Distance from the axis, in particle spacings, up to which operators do not use the curvature of walls. With 3 to 5
the least eigenvalue of D G L^-1, divergence, gradient and inverse Laplacian of the pressure, is -0.08 to -0.15 beside a
sphere of 8 spacings, in place of -0.06: what is to remove divergence then makes it grow, and at Re = 50 a run diverged.
With 0 the largest one is above 2."""


class WallsOfRevolution(WallPoints):
    """Points on walls, ``WallPoints``, that may turn around the axis as well, by the ``spin`` of their bodies.

    ``across_axis`` says whether flow along one of them goes to the axis, or from it.
    """

    def __init__(self, bodies, spacing, origin):
        super().__init__(bodies, spacing, origin)
        self.near_axis = NEAR_AXIS * spacing
        self.across_axis = any(np.abs(outline.normal[:, 0]).max() > 0.5 for outline in self.outlines)

    def _outline(self, body):
        """Return points on the upper half of a wall that is symmetric about the axis, none of them on it."""
        length = body.shape.length
        outline = body.shape.boundary_points(length / (2 * round(0.5 * length / self.spacing)))
        above = body.placed(outline).point[:, 1] > 0.0
        return Boundary(*(getattr(outline, name)[above] for name in ("point", "normal", "curvature", "length")))

    def velocities(self, time):
        """Return u, v/r and w/r (count, 3) of the points at ``time``."""
        along, across = super().velocities(time).T
        return np.stack([along, across / self.radii(time), self._spins("velocity", time)], axis=1)

    def acceleration(self, time):
        """Return the accelerations (count, 3) of the points, over r across and around the axis."""
        (along, across), radius = super().acceleration(time).T, self.radii(time)
        centripetal = self._spins("velocity", time) ** 2
        return np.stack([along, across / radius - centripetal, self._spins("acceleration", time)], axis=1)

    def radii(self, time):
        """Return the distances (count,) of the points from the axis."""
        return np.concatenate([boundary.point[:, 1] for boundary in self._placed(time)])

    def _spins(self, name, time):
        parts = zip(self.bodies, self.parts, strict=True)
        return np.concatenate([np.full(part.stop - part.start, getattr(body.spin, name)(time)) for body, part in parts])

    def inwards(self, normal, velocity):
        """Return the parts (count,) into the fluid of the unknowns (count, 3) of a velocity."""
        return normal[:, 0] * velocity[:, 0] + normal[:, 1] * self.radii(self._kept[0]) * velocity[:, 1]

    def strain(self, velocity, d_dx, d_dy):
        """Return 2 D (5, count): xx, xy, yy, and of x and y with the direction around the axis."""
        radius = self.radii(self._kept[0])
        shear = radius * (d_dy[0] + d_dx[1])
        across = 2.0 * (velocity[1] + radius**2 * d_dy[1])
        return np.stack([2.0 * d_dx[0], shear, across, radius * d_dx[2], radius**2 * d_dy[2]])

    def gradient_around(self, gradient):
        """Return derivatives (2, count) of w/r, by x and y, with what is known at the points: all turns with a wall."""
        normal = np.concatenate([boundary.normal for boundary in self._kept[1]]).T
        return normal * (normal * gradient).sum(axis=0)

    def sums(self, tractions, time):
        """Return force along the axis, 0, torque around it, and 0, on whole bodies (n, bodies, 4).

        ``tractions`` (n, count, 2 or 3): those of a pressure have no part around the axis.
        """
        radius = self.radii(time)
        force = (2.0 * np.pi * radius * self.length)[:, None] * tractions
        result = np.zeros((len(tractions), len(self.bodies), 4))
        for number, part in enumerate(self.parts):
            result[:, number, 0] = force[:, part, 0].sum(axis=1)
            result[:, number, 2] = (radius[part, None] * force[:, part, 2:]).sum(axis=(1, 2))
        return result

    def means(self, values):
        """Return the means (bodies,) over each wall of ``values`` (count,) at the points."""
        area = self.length * self.radii(self._kept[0])
        return np.array([np.average(values[part], weights=area[part]) for part in self.parts])

    def polar_map(self, place, planes, distances, curvatures):
        """Return what ``WallPoints`` gives; near the axis, where operators are those of even functions, nothing."""
        away = place[:, 1] + self.origin[1] > self.near_axis
        return away[:, None] * super().polar_map(place, planes, distances, curvatures)

    def mirrors(self, place, planes, distances):
        """Return the planes of ``WallPoints`` with that of the axis instead of the last where it is nearer."""
        nearer, planes = place[:, 1] + self.origin[1] < distances[:, -1], planes.copy()
        planes[nearer, -1] = 0.0, 1.0, -self.origin[1]
        return planes
