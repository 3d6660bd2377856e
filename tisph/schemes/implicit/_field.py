"""The velocity field at the end of a step: its derivatives, its divergence, and the volume of the particles."""

import math

from tisph.runtime import real, scalar, ti

EVENED = 0.5
"""Part of the difference of a particle's volume from the mean around it that a step takes away."""


@ti.data_oriented
class VelocityField:
    """Measures ``viscous.end``, component by component.

    ``slope`` (2, fluid) vectors: gradient of a component; ``curvature`` (2, fluid): its xx, xy, yy derivatives.
    ``volume`` (fluid): logarithm of a particle's volume over that at the start.
    """

    def __init__(self, viscous):
        self.viscous, self.rows, self.ghosts = viscous, viscous.rows, viscous.ghosts
        self.fluid = viscous.fluid
        self.slope = ti.field(ti.types.vector(2, real()), (2, self.fluid))
        self.curvature = ti.field(ti.types.vector(3, real()), (2, self.fluid))
        self.volume = ti.field(real(), self.fluid)
        self.values, self.wall_slope = (ti.field(real(), viscous.points.slots + 1) for _ in range(2))
        self.steepest, self.divergence_squared, self.gradient_squared = (scalar(0.0) for _ in range(3))

    def measure(self, time, transverse):
        """Take up the derivatives of the velocities at the end of the step, at ``time``.

        ``transverse``: whether there are velocities across the channel.
        """
        self.ghosts.lay(self.viscous.data, *self.viscous.wall_series(time))
        for component in range(1 + transverse):
            self.differentiate(component, float(component == 0))
        self.add_up()

    @property
    def residual(self):
        """Divergence over the gradient, both as root mean squares: 0 for an incompressible flow."""
        gradient = self.gradient_squared[None]
        return math.sqrt(self.divergence_squared[None] / gradient) if gradient > 0.0 else 0.0

    @ti.kernel
    def differentiate(self, component: ti.i32, driven: float):
        """Compute slopes and curvatures of one component; ``driven`` is 1 for the one that the walls drive, else 0."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            self.values[i] = self.viscous.end[component, i]
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            ghost = self.fluid + k
            self.values[ghost] = driven * self.viscous.data[ghost] - self.ghosts.value(self.values, k)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            self.slope[component, i] = [
                self.rows.apply(self.rows.along, self.values, i),
                self.rows.apply(self.rows.across, self.values, i),
            ]
        for part in ti.static(range(2)):
            ti.loop_config(serialize=self.rows.serial_light)
            for i in range(self.fluid):
                self.values[i] = self.slope[component, i][part]
            ti.loop_config(serialize=True)
            for k in range(self.ghosts.count[None]):
                source = self.ghosts.value(self.values, k)
                if ti.static(part == 0):
                    self.values[self.fluid + k] = -source
                else:
                    self.values[self.fluid + k] = source + driven * self.ghosts.series_slope(k)
            ti.loop_config(serialize=self.rows.serial_light)
            for i in range(self.fluid):
                across = self.rows.apply(self.rows.across, self.values, i)
                if ti.static(part == 0):
                    self.curvature[component, i] = [self.rows.apply(self.rows.along, self.values, i), across, 0.0]
                else:
                    self.curvature[component, i].z = across

    @ti.kernel
    def add_up(self):
        """Sum the squares, in a fixed order."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            divergence, gradient, steepest = 0.0, 0.0, 0.0
            for i in range(self.fluid):
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
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            self.values[i] = self.volume[i] + length * (self.slope[0, i].x + self.slope[1, i].y)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            total, number = 0.0, 0
            for k in range(self.viscous.points.count[i]):
                j = self.viscous.points.table[i, k]
                if j < self.fluid:
                    total += self.values[j]
                    number += 1
            mean = total / ti.max(number, 1)
            self.volume[i] = self.values[i] + EVENED * (mean - self.values[i])
