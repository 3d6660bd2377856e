"""The velocity along the channel at the end of a step: its derivatives, and the volume of the particles."""

import math

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real, ti, view

VOLUME_SMOOTHING = 0.5
"""Part of the difference of a particle's volume from the mean around it that a step takes away."""


@ti.data_oriented
class VelocityField:
    """Measures the velocity at the ``end`` of an ``ImplicitStep``.

    ``slope`` (fluid, 2): its gradient; ``curvature`` (fluid, 3): its xx, xy, yy derivatives; ``steepest``: the largest
    magnitude of the gradient. ``log_volume`` (fluid): of a particle's volume over that at the start.
    """

    def __init__(self, step):
        self.step, self.operators, self.ghosts, self.points = step, step.operators, step.ghosts, step.points
        self.slope = self.points.field(ti.types.vector(2, real()))
        self.curvature = self.points.field(ti.types.vector(3, real()))
        self.log_volume = self.points.field(real())
        self.values = ti.field(real(), self.points.slots + 1)
        self.found = ti.field(ti.types.vector(2, real()), self.points.capacity)
        self.volumes = ti.field(real(), self.points.capacity)
        self.values.used = self.found.used = self.volumes.used = None
        self.steepest = 0.0

    def measure(self):
        """Compute the derivatives of the velocity at the end of the step."""
        ghosts, slope, curvature = self.ghosts, active(self.slope), active(self.curvature)
        ghosts.prescribe(*self.step.walls.series(-1))
        slope[...] = self.gradient(active(self.step.end), -ghosts.sign(), ghosts.boundary_values())
        curvature[:, :2] = self.gradient(slope[:, 0], -ghosts.sign(), 0.0)
        curvature[:, 2] = self.gradient(slope[:, 1], ghosts.sign(), ghosts.series_slope())[:, 1]
        self.steepest = math.sqrt(np.einsum("nk,nk->n", slope, slope).max())

    def gradient(self, values, parity, boundary):
        """Return the gradient (fluid, 2) of ``values`` (fluid), until the next is computed.

        Ghosts have ``parity`` times the value of their source in the fluid, plus their value of the ``boundary``.
        """
        everywhere = view(self.values)
        everywhere[: self.points.fluid] = values
        ghosts = self.ghosts.part(everywhere)
        ghosts[...] = parity * self.ghosts.source_values(everywhere)
        ghosts += boundary
        self.differentiate()
        return view(self.found)[: self.points.fluid]

    @ti.kernel
    def differentiate(self):
        """Compute the gradient of ``values``."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            along = self.operators.apply(self.operators.d_dx, self.values, i)
            across = self.operators.apply(self.operators.d_dy, self.values, i)
            self.found[i] = [along, across]

    @ti.kernel
    def advance_volumes(self, dt: float):
        """Let the volumes follow the divergence for a step, and even them out among neighbours.

        The divergence of disordered particles has a truncation error that differs from one to the next. As the density
        of the explicit scheme is diffused, so are the volumes here: what is larger than a neighbourhood stays.
        """
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.volumes[i] = self.log_volume[i] + dt * self.slope[i].x
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            total, number = 0.0, 0
            for k in range(self.points.count[i]):
                j = self.points.neighbours[i, k]
                if j < self.points.capacity:
                    total += self.volumes[j]
                    number += 1
            mean = total / ti.max(number, 1)
            self.log_volume[i] = self.volumes[i] + VOLUME_SMOOTHING * (mean - self.volumes[i])
