"""The linear systems of a viscous step: by rows, by the diagonal where that takes few iterations, or by two levels.

On a lattice, sheared or not, the particles of a row are alike, and the rows are a small system of their own: nothing is
left to iterate. In disorder iterations with the diagonal grow with the root of the viscous number g h nu/spacing^2, and
so with the number of particles across, as steps are as long as accuracy allows. With two levels there are one or two,
each as dear as four.
"""

from tisph.least_squares.operators import FEW
from tisph.runtime import ti, view
from tisph.schemes.implicit._across import Across
from tisph.solvers.bicgstab import BiCGStab

ROUGH = 3.0
"""Viscous number up to which the diagonal is preconditioner enough: both took as long from 2 to 4."""


@ti.data_oriented
class ViscousSolver(BiCGStab):
    """Solver of (1 - c A) x = b in a ``channel``; ``x`` mirrors oddly in the walls.

    ``two_level`` is the preconditioner of two levels. It comes with the first system that needs it; few particles do
    without, since its kernels take as long to compile as they save in a whole run.
    """

    def __init__(self, rows, ghosts, channel):
        super().__init__(rows, ghosts, -1.0)
        self.channel, self.two_level = channel, None
        self.coarse = None if ghosts.mirrors else Across(rows, ghosts, channel)
        self.roughest = ROUGH * channel.spacing**2

    def assemble(self):
        """Get ready for systems with the rows as they are now."""
        if self.coarse:
            self.coarse.sort()
            if self.coarse.alike:
                self.coarse.assemble(seen=1)

    def solve(self, coefficient, tolerance):
        """Solve (1 - ``coefficient`` A) x = b to a residual of ``tolerance`` |b|; return whether it did."""
        if self.coarse and self.coarse.alike:
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
