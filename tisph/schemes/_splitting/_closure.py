"""What walls add to the pressure's equation: its slope at the points on them.

    n . grad p = n . (u^ - g U) / h + n . f - nu n . curl omega,

the momentum equation at the wall, in whose last term the divergence of the velocities has no part (G. E. Karniadakis,
M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991) 414-443, eq. 17). The vorticity omega is that expected at the end
of the step first, and then that of the velocities found with it.
"""

import numpy as np

from tisph.runtime import holding, real, ti, view


@ti.data_oriented
class Closure:
    """Rows and right sides at the points on ``walls``.

    ``normal`` into the liquid and ``weight`` of a point, the length of its part of the wall over the area of a
    particle: with it a constant pressure is left by the equations of particles and points alike.
    """

    def __init__(self, operators, walls, spacing):
        self.operators, self.points = operators, operators.points
        vector, most = ti.types.vector(2, real()), self.points.capacity
        self.normal = ti.field(vector, most)
        self.twist, self.vorticity = (ti.field(real(), size) for size in (most, self.points.slots + 1))
        weight, self.slots = np.zeros(most), slice(self.points.fluid - walls.count, self.points.fluid)
        weight[self.slots] = walls.length / spacing**2
        self.weight = holding(ti.field(real(), most), weight)

    def place(self, normal):
        """Take up the normals of the points, and turn their operators to the normal derivative of the pressure."""
        view(self.normal)[self.slots] = normal
        self.turn()

    @ti.kernel
    def turn(self):
        """Let the operators of the Laplacian be those of the normal derivative times the weight."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            normal, total = self.weight[i] * self.normal[i], 0.0
            for k in range(self.points.count[i]):
                slope = normal.x * self.operators.d_dx[i, k] + normal.y * self.operators.d_dy[i, k]
                self.operators.laplacian[i, k] = slope
                total += slope
            self.operators.diagonal[i] = -total

    @ti.kernel
    def spin(self, velocity: ti.template()):
        """Take up the vorticity of the velocities, and the normal part of its curl at the points."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            own, total = velocity[i], 0.0
            for k in range(self.points.count[i]):
                apart = velocity[self.points.neighbours[i, k]] - own
                total += self.operators.d_dx[i, k] * apart.y - self.operators.d_dy[i, k] * apart.x
            self.vorticity[i] = total
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            self.twist[i] = self.curl(i)

    @ti.func
    def curl(self, i):
        """Return the normal part of the vorticity's curl at a point."""
        own, normal, total = self.vorticity[i], self.normal[i], 0.0
        for k in range(self.points.count[i]):
            slope = normal.x * self.operators.d_dy[i, k] - normal.y * self.operators.d_dx[i, k]
            total += slope * (self.vorticity[self.points.neighbours[i, k]] - own)
        return total

    @property
    def twists(self):
        """Normal parts of the vorticity's curl, (count,), in place."""
        return view(self.twist)[self.slots]

    @ti.func
    def right_side(self, i, push, viscosity):
        """Return the right side at a point where all but pressure and viscosity accelerate the liquid by ``push``."""
        return -self.weight[i] * (push.dot(self.normal[i]) - viscosity * self.twist[i])
