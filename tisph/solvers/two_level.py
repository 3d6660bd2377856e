"""Preconditioner of two levels, with which the number of iterations does not grow with that of the particles.

The fast solver of an ``AuxiliaryGrid`` reduces what is smooth, and a damped Jacobi sweep on the particles what is
rough, or what the transfers between the two have left. One more sweep before saves fewer iterations than it costs. Rows
of points on walls, one-sided derivatives, are not dominated by their diagonal: a sweep satisfies them after those of
the fluid, for what these have given.
"""

from tisph.runtime import ti, view

DAMPING = 0.8
"""Of the Jacobi sweep."""


@ti.data_oriented
class TwoLevel:
    """Preconditioner of a ``solver``, a ``BiCGStab``, by a ``grid`` that has sorted the particles as they lie.

    ``walls``: whether the unknowns of the ``solver`` include those of points on walls, after those of the fluid.
    """

    def __init__(self, solver, grid, walls=False):
        self.solver, self.grid, self.walls, self.points = solver, grid, walls, solver.points
        self.smooth = ti.field(solver.kind, solver.points.slots + 1)
        self.nodes = grid.nodes(solver.kind)

    def apply(self):
        """One cycle."""
        self.restrict()
        self.grid.invert(self.nodes, float(view(self.solver.sigma)), float(view(self.solver.coefficient)))
        self.prolong()

    @ti.func
    def satisfy_walls(self, values: ti.template(), particles):
        """Change the ``values`` at points on walls so that their rows hold, but for those of the others among them."""
        if ti.static(self.walls):
            fluid = self.points.n_fluid[None]
            ti.loop_config(serialize=self.solver.serial)
            for i in range(fluid, particles):
                residual = self.solver.input[i] - self.solver.row(values, i)
                self.solver.product[i] = values[i] + self.solver.inverse[i] * residual
            ti.loop_config(serialize=self.solver.serial)
            for i in range(fluid, particles):
                values[i] = self.solver.product[i]

    @ti.kernel
    def restrict(self):
        """Bring what is to be solved for to the grid."""
        ti.loop_config(serialize=self.solver.serial)
        for node in range(self.grid.rows[None] * self.grid.columns[None]):
            self.nodes[node] = self.grid.deposit(self.solver.input, node)

    @ti.kernel
    def prolong(self):
        """Take what the grid has found, a sweep, and the matrix times the result."""
        particles = self.solver.number[None]
        ti.loop_config(serialize=self.solver.serial)
        for i in range(particles):
            self.smooth[i] = self.grid.interpolate(self.nodes, i)
        self.solver.update_ghosts(self.smooth, particles)
        ti.loop_config(serialize=self.solver.serial)
        for i in range(particles):
            damping = DAMPING
            if ti.static(self.walls):
                damping = ti.select(i < self.points.n_fluid[None], DAMPING, 0.0)
            residual = self.solver.input[i] - self.solver.row(self.smooth, i)
            self.solver.correction[i] = self.smooth[i] + damping * self.solver.inverse[i] * residual
        self.satisfy_walls(self.solver.correction, particles)
        self.solver.multiply(particles)
