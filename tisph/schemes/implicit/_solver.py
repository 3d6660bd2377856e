"""The linear systems of an implicit stage on particles: (1 - c A) x = b, and (1 - c A - D t D) x = b with a tangent t.

On a lattice, sheared or not, the particles of a layer see the same, and the layers are a small system of their own:
nothing is left to iterate. For disordered particles Jacobi iterations grow with the root of the viscous number
g h nu/spacing^2, and so with the number of particles across, as steps are as long as accuracy allows. With two levels
there are one or two, each as expensive as four.
"""

import numpy as np

from tisph.least_squares.operators import FEW
from tisph.neighbours.point_cloud import LANES
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes.implicit._coarse_space import LayerCoarseSpace
from tisph.solvers.bicgstab import BiCGStab

ROUGH = 3.0
"""Viscous number up to which Jacobi suffices: both took as long from 2 to 4."""


@ti.data_oriented
class ViscousSolver(BiCGStab):
    """Solver of (1 - c A) x = b in a ``channel``, where x has odd reflections.

    ``two_level`` is the preconditioner of two levels. It comes with the first system that needs it; few particles do
    without, since its kernels take as long to compile as they save in a whole run.
    """

    def __init__(self, operators, ghosts, channel):
        super().__init__(operators, ghosts, -1.0)
        self.channel, self.two_level = channel, None
        self.coarse = None if ghosts.mirrors else LayerCoarseSpace(operators, ghosts, channel, coupled=False)
        self.roughest = ROUGH * channel.spacing**2

    def assemble(self):
        """Get ready for systems with the operators as they are now."""
        if self.coarse:
            self.coarse.assemble()

    def solve(self, coefficient, tolerance):
        """Solve (1 - ``coefficient`` A) x = b to a residual of ``tolerance`` |b|; return whether it did."""
        if self.coarse and self.coarse.layers_identical:
            fluid = slice(self.points.fluid)
            view(self.x)[fluid] = self.coarse.solution(view(self.b)[fluid], coefficient)
            return super().solve(coefficient, tolerance)
        if coefficient <= self.roughest or self.points.fluid <= FEW:
            return super().solve(coefficient, tolerance)
        if self.two_level is None:
            self.set_two_level()
        self.two_level.grid.sort()
        return super().solve(coefficient, tolerance, preconditioner=self.two_level)

    def set_two_level(self):
        """Set up ``two_level``."""
        from tisph.solvers.auxiliary_grid import DirichletGrid  # of no use to most channels
        from tisph.solvers.two_level import TwoLevel

        self.two_level = TwoLevel(self, DirichletGrid(self.points, self.channel, self.channel.gap))


@ti.data_oriented
class CoupledSolver(BiCGStab):
    """Solver of (1 - c A - D t D) x = b; ``tangent_stress`` (slots + 1) is t D x.

    A particle's stress follows the velocities of its neighbours, their gradient and the divergence of the stress, each
    by a row of the same least-squares operators, so that what the solver sees is the scheme's own discrete equation.
    Images of the gradient, and of the stress, are even where those of the velocities are odd, and the other way round
    beyond a wall with ``even_reflection``.
    """

    def __init__(self, operators, ghosts, channel):
        super().__init__(operators, ghosts, -1.0)
        self.coarse = None if ghosts.mirrors else LayerCoarseSpace(operators, ghosts, channel, coupled=True)
        self.tangent, self.tangent_stress = self.points.field(real()), ti.field(real(), self.points.slots + 1)
        self.fluid = slice(self.points.fluid)
        self.mixed, self.middle = any(ghosts.even_reflection), scalar(channel.gap / 2.0)
        signs = [-1.0 if even else 1.0 for even in ghosts.even_reflection]
        self.signs = holding(ti.field(real(), 2), signs)

    @ti.func
    def sign(self, k):
        """Return 1, or -1 for a ghost beyond a wall with even reflection."""
        sign = ti.cast(1.0, self.signs.dtype)
        if ti.static(self.mixed):
            upper = ti.cast(self.points.position[self.points.capacity + k].y > self.middle[None], ti.i32)
            sign = self.signs[upper]
        return sign

    @ti.func
    def reflect(self, values, k):
        """Give ghost ``k`` its value."""
        values[self.points.capacity + k] = self.parity * self.sign(k) * self.ghosts.value(values, k)

    @ti.func
    def update_ghosts(self, values: ti.template(), particles):
        """Reflect ``values``, and evaluate their ``tangent_stress`` on particles and images."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect(values, k)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.tangent_stress[i] = self.tangent[i] * self.operators.apply(self.operators.d_dy, values, i)
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            image = self.sign(k) * self.ghosts.value(self.tangent_stress, k)
            self.tangent_stress[self.points.capacity + k] = image

    @ti.func
    def row(self, values: ti.template(), i):
        """Return row ``i`` of the system times ``values``, whose ``tangent_stress`` is known."""
        centre, stress, total = values[i], self.tangent_stress[i], 0.0 * values[i]
        for group in range(self.points.count[i] // LANES):
            for lane in ti.static(range(LANES)):  # both sums at once: what they read is the same
                k = group * LANES + lane
                j = self.points.neighbours[i, k]
                viscous = self.coefficient[None] * self.operators.laplacian[i, k] * (values[j] - centre)
                total += viscous + self.operators.d_dy[i, k] * (self.tangent_stress[j] - stress)
        return self.sigma[None] * centre - total

    def assemble(self):
        """Get ready for systems with the operators as they are now."""
        if self.coarse:
            self.coarse.assemble()

    def solve(self, coefficient, tolerance):
        """Solve (1 - ``coefficient`` A) x = b, of velocities across the channel; return whether it did."""
        view(self.tangent)[self.fluid] = 0.0
        return super().solve(coefficient, tolerance)

    def solve_coupled(self, coefficient, tangent, tolerance):
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = b to ``tolerance`` |b|; return whether it did."""
        view(self.tangent)[self.fluid] = tangent
        if self.coarse:
            view(self.coefficient)[()], view(self.sigma)[()] = coefficient, 1.0
            self.start()
            residual = view(self.residual)[self.fluid].astype(float)
            correction = self.coarse.correction(residual, coefficient, np.broadcast_to(tangent, residual.shape))
            view(self.x)[self.fluid] += correction
        return super().solve(coefficient, tolerance)
