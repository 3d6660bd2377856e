"""A coarse space for the linear systems of a parallel flow: velocities that depend on the height alone.

Its operators are those of the particles, sampled in each layer of the start lattice: where the particles of a layer see
the same, sheared or not, the solution is found there to round-off, and iterations have nothing left to do; elsewhere
they begin nearer to it.
"""

import numpy as np

from tisph.runtime import view

SAMPLED = 8
"""Particles of a layer that its operators are averaged over, where they are disordered."""

IDENTICAL = 1e-9
"""Spacings that particles may be off their layers for all of a layer to see the same."""


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
        """Take up to ``most`` particles of each layer, and what is among their neighbours."""
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
        """Return what to add to velocities (fluid) with this ``residual`` of (1 - coefficient A - D tangent D) x."""
        coupling = np.einsum("ij,jk->ik", self.even_gradient, self.mean(tangent)[:, None] * self.odd_gradient)
        found = np.linalg.solve(np.eye(self.number) - coefficient * self.laplacian - coupling, self.mean(residual))
        return (1.0 - self.offset) * found[self.below] + self.offset * found[self.below + 1]
