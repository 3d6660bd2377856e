"""The operators of the implicit step on particles: least-squares rows, closed by ghosts beyond the walls."""

import numpy as np

from tisph.runtime import real, ti, view
from tisph.schemes._stages.fits import even_fit, polynomial_fit, stress_excess
from tisph.schemes.implicit._solver import CoupledSolver, ViscousSolver


@ti.data_oriented
class ClosedParticleOperators:
    """``ClosedOperators`` of ``schemes/_stages/stages.py`` on the particles of a ``channel``; arrays are (fluid,).

    ``coupled``: whether there is an extra stress.
    """

    def __init__(self, operators, ghosts, channel, coupled):
        self.operators, self.ghosts, self.points = operators, ghosts, operators.points
        self.solver = (CoupledSolver if coupled else ViscousSolver)(operators, ghosts, channel)
        self.values, self.found = ti.field(real(), self.points.slots + 1), self.points.field(real())
        self.fluid = slice(self.points.fluid)

    def laplacian(self, values):
        """Return A of velocities."""
        return self.derivative(self.operators.laplacian, values, -1.0)

    def gradient(self, values, parity):
        """Return d/dy of ``values``, whose images have ``parity`` times theirs."""
        return self.derivative(self.operators.d_dy, values, parity)

    def derivative(self, rows, values, parity):
        """Return that by the ``rows`` of an operator."""
        self.close(values, parity)
        self.apply(rows)
        return view(self.found)[self.fluid].astype(float)

    def close(self, values, parity):
        """Put values and their images where derivatives are taken from; return the images, in place."""
        everywhere = view(self.values)
        everywhere[self.fluid] = values
        ghosts = self.ghosts.part(everywhere)
        ghosts[...] = parity * self.ghosts.sign() * self.ghosts.source_values(everywhere)
        return ghosts

    @ti.kernel
    def apply(self, rows: ti.template()):
        """Compute a derivative of ``values``."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.found[i] = self.operators.apply(rows, self.values, i)

    def boundary_laplacian(self, series):
        """Return what the ``series`` of the images beyond both walls (2, 3) add to the Laplacian."""
        self.ghosts.prescribe(*series)
        return self.from_images(self.operators.laplacian, self.ghosts.boundary_values())

    def boundary_gradient(self, series):
        """Return what they add to d/dy."""
        self.ghosts.prescribe(*series)
        return self.from_images(self.operators.d_dy, self.ghosts.boundary_values())

    def boundary_stress(self, side, slope, third):
        """Return what d/dy of the stress has more by its derivatives at a wall."""
        return self.from_images(self.operators.d_dy, self.image_stress(side, slope, third))

    def image_stress(self, side, slope, third):
        """Return what each image beyond one wall has of the stress more than its source (ghosts).

        Beyond a wall with even reflection ``slope`` is the stress there, and ``third`` its second derivative.
        """
        excess = stress_excess(self.ghosts.depth, side, self.ghosts.even_reflection[side], slope, third)
        return np.where(self.ghosts.side == side, excess, 0.0)

    def from_images(self, rows, values):
        """Return the sums over the images with such ``values``."""
        sums = np.zeros(self.points.fluid)
        sums[self.ghosts.near] = self.ghosts.sums(rows, values[self.ghosts.listed])[0]
        return sums

    def assemble(self):
        """Get ready for linear systems with the operators as they are now."""
        self.solver.assemble()

    def solve(self, coefficient, tangent, right, guess, tolerance):
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = ``right``; return x, or None where that fails."""
        solver = self.solver
        view(solver.x)[self.fluid], view(solver.b)[self.fluid] = guess, right
        if tangent is None:
            solved = solver.solve(coefficient, tolerance)
        else:
            solved = solver.solve_coupled(coefficient, tangent, tolerance)
        return view(solver.x)[self.fluid].astype(float) if solved else None

    def even_fit(self, side):
        """Return particles near a wall, their distance from it, and their weights in the ``even_fit``."""
        near, weights = even_fit(self.ghosts.offset[side], self.ghosts.cutoff)
        return self.ghosts.near[near], self.ghosts.offset[side, near], weights

    def wall_fits(self, values):
        """Return the ``polynomial_fit`` at each wall to ``values`` (quantities, fluid)."""
        near = np.asarray(values)[:, self.ghosts.near].T
        return [polynomial_fit(offset, near, self.ghosts.cutoff) for offset in self.ghosts.offset]
