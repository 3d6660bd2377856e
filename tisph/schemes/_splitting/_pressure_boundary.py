"""Boundary condition of the pressure at walls: its normal derivative at the points on them.

    n . grad p = n . (u^ - gamma_0 U) / dt + n . f - nu n . curl omega,

the momentum equation at the wall, in whose last term the divergence of the velocities has no part (G. E. Karniadakis,
M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991) 414-443, eq. 17). The vorticity omega is first the one
extrapolated to the end of the step, and then that of the velocities found with it.
"""

import numpy as np

from tisph.runtime import holding, real, scalar, ti, view

MEAN = 2.5
"""Radius, in particle spacings, of the mean with which the pressure is continued into a gap that closes."""


@ti.data_oriented
class PressureBoundaryCondition:
    """Equations at the points on ``walls``.

    ``normal`` into the fluid and ``weight`` of a point, the length of its part of the wall over the area of a
    particle: with it a constant pressure is left by the equations of particles and points alike.

    ``closing``: bodies may come so close that between them there is no particle, but points on both, whose equations
    are one and the same: what the pressure is there they leave open. ``continued`` is the part, 0 to 1, in which it is
    the mean of the pressures around instead, which continues it into the gap. ``narrow`` tells whether a particle is in
    a gap in which divergence is left as it is.
    """

    def __init__(self, levels, walls, spacing, closing=False):
        self.operators, self.points, self.coordinates = levels.operators, levels.points, levels.coordinates
        vector, capacity = ti.types.vector(2, real()), self.points.capacity
        self.normal = ti.field(vector, capacity)
        self.normal_curl, self.vorticity = (ti.field(real(), size) for size in (capacity, self.points.slots + 1))
        weight, self.slots = np.zeros(capacity), slice(self.points.fluid - walls.count, self.points.fluid)
        weight[self.slots] = walls.length / spacing**2
        self.weight = holding(ti.field(real(), capacity), weight)
        self.closing = closing
        if closing:
            self.continued = ti.field(real(), capacity)
            self.narrow = ti.field(ti.i32, capacity)
            self.per_spacing = scalar(1.0 / spacing)

    def set_normals(self, normal):
        """Take up the normals of the points, and set their equations."""
        view(self.normal)[self.slots] = normal
        self.impose_neumann_rows()

    @ti.kernel
    def impose_neumann_rows(self):
        """Let the operators of the Laplacian be those of the normal derivative times the weight."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            normal, total = self.weight[i] * self.normal[i], 0.0
            normal.y *= self.coordinates.radius(i)
            for k in range(self.points.count[i]):
                weight = normal.x * self.operators.d_dx[i, k] + normal.y * self.operators.d_dy[i, k]
                if ti.static(self.closing):
                    weight += self.continued[i] * (self.nearness(i, k) - weight)
                self.operators.laplacian[i, k] = weight
                total += weight
            self.operators.diagonal[i] = -total

    @ti.func
    def nearness(self, i, k):
        """Return the weight of neighbour ``k`` of a point in the mean of its neighbours, over the spacing squared."""
        apart = self.points.separation(i, self.points.neighbours[i, k]) * self.per_spacing[None]
        return self.per_spacing[None] ** 2 * ti.max(0.0, 1.0 - apart.dot(apart) / MEAN**2) ** 2

    @ti.func
    def find_normal_curls(self):
        """Take up the normal part of the curl of the ``vorticity`` at the points."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            self.normal_curl[i] = self.curl(i)

    @ti.func
    def curl(self, i):
        """Return the normal part of the vorticity's curl at a point."""
        own, normal, radius = self.vorticity[i], self.normal[i], self.coordinates.radius(i)
        total = self.coordinates.hoop(normal.x * own)
        normal *= ti.Vector([radius * radius, radius])
        for k in range(self.points.count[i]):
            weight = normal.x * self.operators.d_dy[i, k] - normal.y * self.operators.d_dx[i, k]
            total += weight * (self.vorticity[self.points.neighbours[i, k]] - own)
        return total

    @property
    def normal_curls(self):
        """Normal parts of the vorticity's curl, (count,), in place."""
        return view(self.normal_curl)[self.slots]

    @ti.func
    def right_side(self, i, acceleration, viscosity):
        """Return the right side at a point where all but pressure and viscosity give an ``acceleration``."""
        along = self.normal[i].x * acceleration.x + self.coordinates.radius(i) * self.normal[i].y * acceleration.y
        result = -self.weight[i] * (along - viscosity * self.normal_curl[i])
        if ti.static(self.closing):
            result *= 1.0 - self.continued[i]
        return result
