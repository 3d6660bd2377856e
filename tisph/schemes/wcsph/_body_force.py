"""A body force that a user gives as a function, evaluated on the host in each step."""

import numpy as np

from tisph.errors import ConfigError
from tisph.runtime import view

AT_WALLS = 1e-9
"""Acceleration on walls, over the largest in the fluid, that counts as none."""


class BodyForce:
    """Accelerations of the ``particles`` in the middle of each step, by the ``body_force`` of a ``scene``.

    Positions of particles count from ``origin`` [length]. Wall treatments continue pressure and velocity as without a
    body force, so that one which acts on a wall is refused: ``evaluate`` raises ConfigError.
    """

    def __init__(self, scene, particles, origin):
        self.scene, self.particles, self.origin = scene, particles, np.array(origin)
        self.values, self.largest = None, 0.0
        self.outlines = [(body, body.shape.boundary_points(scene.spacing).point) for body in scene.bodies]
        x = np.arange(scene.columns) * scene.spacing
        self.planes = [np.stack([x, np.full_like(x, y)]) for y in (0.0, scene.extent[1]) if scene.walls]

    def evaluate(self, now, middle):
        """Store the accelerations (fluid, 2) at the time ``middle`` of the pending step, whose buffer is ``now``."""
        place = self.origin + view(self.particles.mid_position)[now, : self.particles.fluid].astype(float)
        place = np.where(self.scene.periodic, place % self.scene.extent, place)
        self.values = np.stack(self.scene.body_force(*place.T, middle), axis=1)
        self.largest = float(np.hypot(*self.values.T).max())
        walls = [body.at(middle).to_lab_frame(points).T for body, points in self.outlines]
        if any(
            np.abs(self.scene.body_force(*wall, middle)).max() > AT_WALLS * self.largest
            for wall in (*self.planes, *walls)
        ):
            raise ConfigError("body_force: must be 0 on walls with scheme wcsph; scheme implicit has no such limit")

    def apply(self, now, length, half):
        """Add them to the step of ``length`` that is in the buffer ``now``, and to the ``half`` step after it."""
        fluid, given = self.particles.fluid, self.values
        view(self.particles.velocity)[now, :fluid] += length * given
        view(self.particles.mid_velocity)[now, :fluid] += (length + half) * given
        view(self.particles.mid_position)[now, :fluid] += half * length * given
