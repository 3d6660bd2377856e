"""Incremental pressure projection, for flows that are not free of divergence by themselves.

The velocities of a step with the old pressure gradient are made free of divergence by u -= h grad phi, where
A phi = div u / h, and p += phi (K. Goda, J. Comput. Phys. 30 (1979) 76-95). phi has even reflections in the walls,
p_n = 0. A shear flow between plane walls never comes here: its divergence stays a truncation error.
"""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real, view
from tisph.solvers.bicgstab import BiCGStab

REGULARISATION = 1e-3
"""Fixes the constant up to which a pressure is given: A - 1e-3/gap^2 instead of A. Only its gradient counts."""

RESIDUAL = 1e-4
MOST_ITERATIONS = 2000


class Projection:
    """``pressure`` (fluid), per unit density, of one arrangement of points; ``solver`` comes with the first use."""

    def __init__(self, step, field, gap):
        self.step, self.field, self.operators, self.ghosts, self.points = (
            step,
            field,
            step.operators,
            step.ghosts,
            step.points,
        )
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
            self.solver = BiCGStab(self.operators, self.ghosts, 1.0)
        x, b = (view(field)[: self.points.fluid] for field in (self.solver.x, self.solver.b))
        along, across = active(self.field.slope)
        x[...], b[...] = 0.0, (along[:, 0] + across[:, 1]) / dt
        solved = self.solver.solve(-1.0, RESIDUAL, sigma=-self.regularisation, max_iterations=MOST_ITERATIONS)
        slope = self.gradient(x)
        active(self.pressure)[...] += x
        active(self.step.end)[...] -= dt * slope
        active(self.step.end_rate)[...] -= slope
        return solved
