"""Incremental pressure projection, for flows that are not free of divergence by themselves.

The velocities of a step with the old pressure gradient are made free of divergence by u -= h grad phi, where
A phi = div u / h, and p += phi (K. Goda, J. Comput. Phys. 30 (1979) 76-95). phi mirrors evenly at the walls, p_n = 0.
A shear flow between plane walls never comes here: its divergence stays a truncation error.
"""

from tisph.runtime import real, ti
from tisph.solvers.bicgstab import BiCGStab

SINGULAR = 1e-3
"""Fixes the constant that a pressure has free: A - 1e-3/gap^2 instead of A. Only gradients of the pressure count."""

RESIDUAL = 1e-4
MOST_ITERATIONS = 2000


@ti.data_oriented
class Projection:
    """``pressure`` (fluid), over the density, of one arrangement of points; ``solver`` comes with the first use."""

    def __init__(self, viscous, field, gap):
        self.viscous, self.field, self.operators, self.ghosts = viscous, field, viscous.operators, viscous.ghosts
        self.points = viscous.points
        self.shift = SINGULAR / gap**2
        self.pressure = self.points.field(real())
        self.values = ti.field(real(), self.points.slots + 1)
        self.values.used = None
        self.solver = None

    @ti.kernel
    def lay(self):
        """Put the pressure and its mirror images where gradients are taken from."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.values[i] = self.pressure[i]
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.values[self.points.capacity + k] = self.ghosts.value(self.values, k)

    @ti.kernel
    def push(self, component: ti.i32):
        """Take the gradient of the pressure off the sources of one component."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.viscous.source[i] -= self.slope(component, self.values, i)

    @ti.func
    def slope(self, component, values: ti.template(), i):
        """Return one component of the gradient of ``values``."""
        along = self.operators.apply(self.operators.d_dx, values, i)
        across = self.operators.apply(self.operators.d_dy, values, i)
        return along if component == 0 else across

    def project(self, length):
        """Take the divergence out of the velocities at the end of a step; return whether that could be solved."""
        if self.solver is None:
            self.solver = BiCGStab(self.operators, self.ghosts, 1.0)
        self.prepare(length)
        solved = self.solver.solve(-1.0, RESIDUAL, sigma=-self.shift, max_iterations=MOST_ITERATIONS)
        self.correct(length)
        return solved

    @ti.kernel
    def prepare(self, length: float):
        """Right side and guess of the Poisson equation."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.solver.b[i] = (self.field.slope[0, i].x + self.field.slope[1, i].y) / length
            self.solver.x[i] = 0.0

    @ti.kernel
    def correct(self, length: float):
        """Correct velocities, rates and pressure."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.solver.reflect(self.solver.x, k)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.pressure[i] += self.solver.x[i]
            for component in ti.static(range(2)):
                slope = self.slope(component, self.solver.x, i)
                self.viscous.end[component, i] -= length * slope
                self.viscous.end_rate[component, i] -= slope
