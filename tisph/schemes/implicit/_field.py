"""The velocity field at the end of a step: its derivatives, its divergence, the volumes, and the pressure projection.

The projection is incremental, for flows that are not free of divergence by themselves. The velocities of a step with
the old pressure gradient are made free of divergence by u -= h grad phi, where A phi = div u / h, and p += phi
(K. Goda, J. Comput. Phys. 30 (1979) 76-95). phi has even reflections in the walls, p_n = 0. A shear flow between plane
walls never needs it: its divergence stays a truncation error.
"""

import math

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real, ti, view
from tisph.solvers.bicgstab import BiCGStab

VOLUME_SMOOTHING = 0.5
"""Part of the difference of a particle's volume from the mean around it that a step takes away."""

REGULARISATION = 1e-3
"""Fixes the constant up to which a pressure is given: A - 1e-3/gap^2 instead of A. Only its gradient counts."""

RESIDUAL = 1e-4
MOST_ITERATIONS = 2000


@ti.data_oriented
class VelocityField:
    """Measures the ``end`` of an ``ImplicitStep``, component by component.

    ``slope`` (2, fluid) vectors: gradient of a component; ``curvature`` (2, fluid): its xx, xy, yy derivatives.
    ``log_volume`` (fluid): of a particle's volume over that at the start.
    """

    def __init__(self, step):
        self.step, self.operators, self.ghosts, self.points = step, step.operators, step.ghosts, step.points
        self.slope = self.points.field(ti.types.vector(2, real()), 2)
        self.curvature = self.points.field(ti.types.vector(3, real()), 2)
        self.log_volume = self.points.field(real())
        self.values = ti.field(ti.types.vector(2, real()), self.points.slots + 1)
        self.found = ti.field(ti.types.matrix(2, 2, real()), self.points.capacity)
        self.volumes = ti.field(real(), self.points.capacity)
        self.values.used = self.found.used = self.volumes.used = None
        self.steepest = self.divergence_squared = self.gradient_squared = 0.0

    def measure(self, transverse):
        """Take up the derivatives of the velocities at the end of the step.

        ``transverse``: whether there are velocities across the channel.
        """
        self.ghosts.prescribe(*self.step.walls.series(-1))
        slope, curvature = active(self.slope), active(self.curvature)
        both = self.ghosts.parities(-1.0, -1.0)
        both[..., 1] = -1.0  # across the channel every wall is at rest
        slope[...] = self.gradients(active(self.step.end).T, both, [self.ghosts.boundary_values(), 0.0])
        for component in range(1 + transverse):
            boundary = self.ghosts.series_slope() if component == 0 else 0.0  # the walls move the first alone
            parity = self.ghosts.parities(-1.0, 1.0) if component == 0 else np.array([-1.0, 1.0])
            along, across = self.gradients(slope[component], parity, [0.0, boundary])
            curvature[component, :, :2] = along
            curvature[component, :, 2] = across[:, 1]
        along, across = slope
        volume_rate = along[:, 0] + across[:, 1]
        square = np.einsum("nk,nk->n", along, along) + np.einsum("nk,nk->n", across, across)
        self.divergence_squared = float(np.einsum("n,n", volume_rate, volume_rate))
        self.gradient_squared = float(square.sum())
        self.steepest = math.sqrt(square.max())

    def gradients(self, values, parity, boundary):
        """Return the gradients of two fields, ``values`` (fluid, 2), until the next are computed: (field, fluid, 2).

        Ghosts have ``parity`` times what they take from the fluid, and what the ``boundary`` adds, for each field.
        """
        everywhere = view(self.values)
        everywhere[: self.points.fluid] = values
        ghosts = self.ghosts.part(everywhere)
        ghosts[...] = parity * self.ghosts.source_values(everywhere)
        for field, more in enumerate(boundary):
            ghosts[:, field] += more
        self.differentiate()
        return view(self.found)[: self.points.fluid].transpose(1, 0, 2)

    @property
    def residual(self):
        """Divergence over the gradient, both as root mean squares: 0 for an incompressible flow."""
        gradient = self.gradient_squared
        return math.sqrt(self.divergence_squared / gradient) if gradient > 0.0 else 0.0

    @ti.kernel
    def differentiate(self):
        """Compute the gradients of ``values``."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            along = self.operators.apply(self.operators.d_dx, self.values, i)
            across = self.operators.apply(self.operators.d_dy, self.values, i)
            self.found[i] = [[along[0], across[0]], [along[1], across[1]]]

    @ti.kernel
    def advance_volumes(self, dt: float):
        """Let the volumes follow the divergence for a step, and even them out among neighbours.

        The divergence of disordered particles has a truncation error that differs from one to the next. As the density
        of the explicit scheme is diffused, so are the volumes here: what is larger than a neighbourhood stays.
        """
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.volumes[i] = self.log_volume[i] + dt * (self.slope[0, i].x + self.slope[1, i].y)
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


class Projection:
    """``pressure`` (fluid), per unit density, of one arrangement of points; ``solver`` comes with the first use."""

    def __init__(self, step, field, gap):
        self.step, self.field, self.points = step, field, step.points
        self.regularisation = REGULARISATION / gap**2
        self.pressure = self.points.field(real())
        self.solver = None

    def gradient(self, values):
        """Return the gradient (2, fluid) of ``values`` (fluid), whose reflections are even."""
        both = np.stack([values, values], axis=1)
        return self.field.gradients(both, 1.0, [0.0, 0.0])[0].T.astype(float)

    def project(self, dt):
        """Take the divergence out of the velocities at the end of a step; return whether that could be solved."""
        if self.solver is None:
            self.solver = BiCGStab(self.step.operators, self.step.ghosts, 1.0)
        x, b = (view(field)[: self.points.fluid] for field in (self.solver.x, self.solver.b))
        along, across = active(self.field.slope)
        x[...], b[...] = 0.0, (along[:, 0] + across[:, 1]) / dt
        solved = self.solver.solve(-1.0, RESIDUAL, sigma=-self.regularisation, max_iterations=MOST_ITERATIONS)
        slope = self.gradient(x)
        active(self.pressure)[...] += x
        active(self.step.end)[...] -= dt * slope
        active(self.step.end_rate)[...] -= slope
        return solved
