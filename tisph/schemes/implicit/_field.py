"""The velocity field at the end of a step: its derivatives, its divergence, and the volume of the particles."""

import math

from tisph.runtime import real, scalar, ti, view

EVENED = 0.5
"""Part of the difference of a particle's volume from the mean around it that a step takes away."""


@ti.data_oriented
class VelocityField:
    """Measures ``viscous.end``, component by component.

    ``slope`` (2, fluid) vectors: gradient of a component; ``curvature`` (2, fluid): its xx, xy, yy derivatives.
    ``volume`` (fluid): logarithm of a particle's volume over that at the start.
    """

    def __init__(self, viscous):
        self.viscous, self.rows, self.ghosts, self.points = viscous, viscous.rows, viscous.ghosts, viscous.points
        self.slope = self.points.field(ti.types.vector(2, real()), 2)
        self.curvature = self.points.field(ti.types.vector(3, real()), 2)
        self.volume = self.points.field(real())
        self.values = ti.field(real(), self.points.slots + 1)
        self.values.used = None
        self.steepest, self.divergence_squared, self.gradient_squared = (scalar(0.0) for _ in range(3))

    def measure(self, time, transverse):
        """Take up the derivatives of the velocities at the end of the step, at ``time``.

        ``transverse``: whether there are velocities across the channel.
        """
        self.ghosts.prescribe(*self.viscous.wall_series(time))
        for component in range(1 + transverse):
            self.differentiate(component, component == 0)

    @property
    def residual(self):
        """Divergence over the gradient, both as root mean squares: 0 for an incompressible flow."""
        gradient = float(view(self.gradient_squared))
        return math.sqrt(float(view(self.divergence_squared)) / gradient) if gradient > 0.0 else 0.0

    @ti.kernel
    def differentiate(self, component: ti.i32, driven: float):
        """Compute slopes and curvatures of one component; ``driven`` is 1 for the one that the walls drive, else 0."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(particles):
            self.values[i] = self.viscous.end[component, i]
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.values[self.points.most + k] = driven * self.ghosts.given(k) - self.ghosts.value(self.values, k)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(particles):
            self.slope[component, i] = [
                self.rows.apply(self.rows.along, self.values, i),
                self.rows.apply(self.rows.across, self.values, i),
            ]
        for part in ti.static(range(2)):
            ti.loop_config(serialize=self.rows.serial_light)
            for i in range(particles):
                self.values[i] = self.slope[component, i][part]
            ti.loop_config(serialize=True)
            for k in range(self.ghosts.count[None]):
                source = self.ghosts.value(self.values, k)
                if ti.static(part == 0):
                    self.values[self.points.most + k] = -source
                else:
                    self.values[self.points.most + k] = source + driven * self.ghosts.series_slope(k)
            ti.loop_config(serialize=self.rows.serial_light)
            for i in range(particles):
                across = self.rows.apply(self.rows.across, self.values, i)
                if ti.static(part == 0):
                    self.curvature[component, i] = [self.rows.apply(self.rows.along, self.values, i), across, 0.0]
                else:
                    self.curvature[component, i].z = across
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.add_up(particles)

    @ti.func
    def add_up(self, particles):
        """Sum the squares, in a fixed order."""
        divergence, gradient, steepest = 0.0, 0.0, 0.0
        for i in range(particles):
            along, across = self.slope[0, i], self.slope[1, i]
            volume_rate = along.x + across.y
            square = along.dot(along) + across.dot(across)
            divergence += volume_rate * volume_rate
            gradient += square
            steepest = ti.max(steepest, square)
        self.divergence_squared[None] = divergence
        self.gradient_squared[None] = gradient
        self.steepest[None] = ti.sqrt(steepest)

    @ti.kernel
    def stretch(self, length: float):
        """Let the volumes follow the divergence for a step, and even them out among neighbours.

        The divergence of disordered particles has a truncation error that differs from one to the next. As the density
        of the explicit scheme is diffused, so are the volumes here: what is larger than a neighbourhood stays.
        """
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(particles):
            self.values[i] = self.volume[i] + length * (self.slope[0, i].x + self.slope[1, i].y)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(particles):
            total, number = 0.0, 0
            for k in range(self.points.count[i]):
                j = self.points.table[i, k]
                if j < self.points.most:
                    total += self.values[j]
                    number += 1
            mean = total / ti.max(number, 1)
            self.volume[i] = self.values[i] + EVENED * (mean - self.values[i])
