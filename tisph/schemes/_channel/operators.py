"""The operators of the implicit step on particles, closed by ghosts beyond the walls, and their linear systems.

The systems are (1 - c A) x = b, and (1 - c A - D t D) x = b with a tangent t. On a lattice, sheared or not, the
particles of a layer see the same, and the layers are a small system of their own: nothing is left to iterate. For
disordered particles Jacobi iterations grow with the root of the viscous number g h nu/spacing^2, and so with the number
of particles across, as steps are as long as accuracy allows. With two levels there are one or two, each as expensive as
four.
"""

import numpy as np

from tisph.least_squares.operators import FEW
from tisph.neighbours.point_cloud import LANES
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes._channel.stages import even_fit, polynomial_fit, stress_excess
from tisph.solvers.auxiliary_grid import DirichletGrid
from tisph.solvers.bicgstab import BiCGStab, TwoLevel

ROUGH = 3.0
"""Viscous number up to which Jacobi suffices: both took as long from 2 to 4."""

SAMPLED = 8
"""Particles of a layer that its operators are averaged over, where they are disordered."""

IDENTICAL = 1e-9
"""Spacings that particles may be off their layers for all of a layer to see the same."""


@ti.data_oriented
class ClosedParticleOperators:
    """``ClosedOperators`` of ``schemes/_channel/stages.py`` on the particles of a ``channel``; arrays are (fluid,).

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
        """Return the part of the Laplacian from the ``series`` of the images beyond both walls (2, 3)."""
        self.ghosts.prescribe(*series)
        return self.from_images(self.operators.laplacian, self.ghosts.boundary_values())

    def boundary_gradient(self, series):
        """Return the part of d/dy from the ``series`` of the images."""
        self.ghosts.prescribe(*series)
        return self.from_images(self.operators.d_dy, self.ghosts.boundary_values())

    def boundary_stress(self, side, slope, third):
        """Return the part of d/dy of the stress from its derivatives at a wall."""
        return self.from_images(self.operators.d_dy, self.image_stress(side, slope, third))

    def image_stress(self, side, slope, third):
        """Return the stress of each image beyond one wall less the stress of its source (ghosts).

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
        if self.solver.coarse:
            self.solver.coarse.assemble()

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


@ti.data_oriented
class ViscousSolver(BiCGStab):
    """Solver of (1 - c A) x = b in a ``channel``, where x has odd reflections.

    ``two_level`` is the preconditioner of two levels. It comes with the first system that needs it; few particles do
    without, since its kernels take as long to compile as they save in a whole run.
    """

    def __init__(self, operators, ghosts, channel):
        super().__init__(operators, ghosts)
        self.channel, self.two_level = channel, None
        self.coarse = None if ghosts.mirrors else LayerCoarseSpace(operators, ghosts, channel, coupled=False)
        self.roughest = ROUGH * channel.spacing**2

    def solve(self, coefficient, tolerance):
        """Solve (1 - ``coefficient`` A) x = b to a residual of ``tolerance`` |b|; return whether it did."""
        if self.coarse and self.coarse.layers_identical:
            fluid = slice(self.points.fluid)
            view(self.x)[fluid] = self.coarse.solution(view(self.b)[fluid], coefficient)
            return super().solve(coefficient, tolerance)
        if coefficient <= self.roughest or self.points.fluid <= FEW:
            return super().solve(coefficient, tolerance)
        if self.two_level is None:
            self.two_level = TwoLevel(self, DirichletGrid(self.points, self.channel, self.channel.gap))
        self.two_level.grid.sort()
        return super().solve(coefficient, tolerance, preconditioner=self.two_level)


@ti.data_oriented
class CoupledSolver(BiCGStab):
    """Solver of (1 - c A - D t D) x = b; ``tangent_stress`` (slots + 1) is t D x.

    A particle's stress follows the velocities of its neighbours, their gradient and the divergence of the stress, each
    by a row of the same least-squares operators, so that what the solver sees is the scheme's own discrete equation.
    Images of the gradient, and of the stress, are even where those of the velocities are odd, and the other way round
    beyond a wall with ``even_reflection``.
    """

    def __init__(self, operators, ghosts, channel):
        super().__init__(operators, ghosts)
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
        values[self.points.capacity + k] = -self.sign(k) * self.ghosts.value(values, k)

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


class LayerCoarseSpace:
    """Layers of a ``channel`` as unknowns, linear in between; for ghosts that mirror a particle each.

    ``layers_identical``: whether all particles of a layer see the same. ``coupled``: whether systems have a tangent.
    """

    def __init__(self, operators, ghosts, channel, coupled):
        self.operators, self.points, self.ghosts, self.coupled = operators, operators.points, ghosts, coupled
        self.spacing, self.number = channel.spacing, channel.rows
        self.layers_identical = False

    def assemble(self):
        """Take up the operators, for the present positions of the particles."""
        self.locate()
        if self.coupled or self.layers_identical:
            self.sample(SAMPLED if self.coupled else 1)
            self.laplacian, self.inverted = self.matrix(self.operators.laplacian, self.odd), None
        if self.coupled:
            self.odd_gradient, self.even_gradient = (
                self.matrix(self.operators.d_dy, sign) for sign in (self.odd, self.even)
            )

    def locate(self):
        """Find the layers that particles are in, or between."""
        height = self.ghosts.heights().astype(float) / self.spacing - 0.5
        below = np.clip(np.floor(height), 0, self.number - 2).astype(int)
        self.below, self.offset = below, height - below
        self.layer = np.clip(np.rint(height), 0, self.number - 1).astype(int)
        self.counts = np.maximum(np.bincount(self.layer, minlength=self.number), 1)
        self.layers_identical = bool(np.abs(height - self.layer).max() < IDENTICAL)

    def sample(self, most):
        """Choose up to ``most`` particles of each layer, and list their neighbours."""
        order = np.argsort(self.layer, kind="stable")
        rank = np.arange(len(order)) - np.searchsorted(self.layer[order], self.layer[order])
        self.sampled = order[rank < most]
        source = np.arange(self.points.slots + 1)
        ghosts = self.ghosts.part(source)
        ghosts[...] = view(self.ghosts.source)[: ghosts.size]
        source[self.points.capacity + ghosts.size :] = source[self.points.fluid : self.points.capacity] = 0
        table, self.listed = self.points.listed_neighbours(self.sampled)
        signs = np.ones(self.points.slots + 1)
        ghosts = self.ghosts.part(signs)
        ghosts[...] = self.ghosts.sign()
        self.others, self.even = source[table], signs[table]
        self.odd = np.where(table >= self.points.capacity, -self.even, self.even)

    def matrix(self, rows, sign):
        """Return the operator (layers, layers) of the least-squares ``rows``, with such a ``sign`` of images."""
        entries = np.where(self.listed, view(rows)[self.sampled], 0.0).astype(float)
        sampled, others = self.sampled, self.others
        first = self.layer[sampled] * self.number
        matrix = np.zeros(self.number**2)
        centre = -entries.sum(axis=1)
        for step in (0, 1):
            share = sign * entries * (self.offset[others] if step else 1.0 - self.offset[others])
            index = (first[:, None] + self.below[others] + step).ravel()
            matrix += np.bincount(index, share.ravel(), self.number**2)
            share = centre * (self.offset[sampled] if step else 1.0 - self.offset[sampled])
            matrix += np.bincount(first + self.below[sampled] + step, share, self.number**2)
        counts = np.bincount(self.layer[sampled], minlength=self.number)
        return matrix.reshape(self.number, self.number) / np.maximum(counts, 1)[:, None]

    def mean(self, values):
        """Return the means (layers,) of ``values`` (fluid,)."""
        return np.bincount(self.layer, values, self.number) / self.counts

    def solution(self, right, coefficient):
        """Solve (1 - coefficient A) x = ``right`` (fluid,) on identical layers."""
        if coefficient != self.inverted:  # all stages of a step have the same
            self.inverse = np.linalg.inv(np.eye(self.number) - coefficient * self.laplacian)
            self.inverted = coefficient
        return np.einsum("ij,j", self.inverse, self.mean(right))[self.layer]  # no threads of BLAS

    def correction(self, residual, coefficient, tangent):
        """Return the correction of velocities (fluid) with this ``residual`` of (1 - coefficient A - D tangent D) x."""
        coupling = np.einsum("ij,jk->ik", self.even_gradient, self.mean(tangent)[:, None] * self.odd_gradient)
        found = np.linalg.solve(np.eye(self.number) - coefficient * self.laplacian - coupling, self.mean(residual))
        return (1.0 - self.offset) * found[self.below] + self.offset * found[self.below + 1]
