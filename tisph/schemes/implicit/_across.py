"""A coarse level for linear systems of a parallel flow: velocities that depend on the height alone.

Its operators are those of the particles, seen by a few of each row: on a lattice, sheared or not, the solution is found
there to rounding, and iterations have nothing left to do; in disorder they begin nearer to it.
"""

import numpy as np

from tisph.runtime import view

SEEN = 8
"""Particles of a row of the start lattice that its operators are averaged over, in disorder."""

ALIKE = 1e-9
"""Spacings that particles may be off their rows for all of a row to see the same: a lattice, sheared or not."""


class Across:
    """Rows of a ``channel`` as unknowns, linear in between; for ghosts that mirror a particle each.

    ``alike``: whether all particles of a row see the same, at the last ``sort``.
    """

    def __init__(self, rows, ghosts, channel):
        self.operators, self.points, self.ghosts = rows, rows.points, ghosts
        self.spacing, self.number = channel.spacing, channel.rows
        self.alike = False

    def sort(self):
        """Take up the present places of the particles."""
        height = self.ghosts.heights().astype(float) / self.spacing - 0.5
        below = np.clip(np.floor(height), 0, self.number - 2).astype(int)
        self.below, self.part = below, height - below
        self.row = np.clip(np.rint(height), 0, self.number - 1).astype(int)
        self.counts = np.maximum(np.bincount(self.row, minlength=self.number), 1)
        self.alike = bool(np.abs(height - self.row).max() < ALIKE)

    def assemble(self, seen):
        """Take up the Laplacian, of so many particles ``seen`` of each row."""
        self.seen = self._first(seen)
        source = np.arange(self.points.slots + 1)
        ghosts = self.ghosts.part(source)
        ghosts[...] = view(self.ghosts.source)[: ghosts.size]
        source[self.points.capacity + ghosts.size :] = source[self.points.fluid : self.points.capacity] = 0
        table, self.listed = self.points.listed_neighbours(self.seen)
        signs = np.ones(self.points.slots + 1)
        ghosts = self.ghosts.part(signs)
        ghosts[...] = self.ghosts.sign()
        self.others, self.even = source[table], signs[table]
        self.odd = np.where(table >= self.points.capacity, -self.even, self.even)
        self.laplacian, self.inverted = self.matrix(self.operators.laplacian, self.odd), None

    def _first(self, most):
        """Return up to ``most`` particles of each row."""
        order = np.argsort(self.row, kind="stable")
        rank = np.arange(len(order)) - np.searchsorted(self.row[order], self.row[order])
        return order[rank < most]

    def matrix(self, rows, sign):
        """Return the operator (rows, rows) of the least-squares ``rows``, with such a ``sign`` of what is mirrored."""
        entries = np.where(self.listed, view(rows)[self.seen], 0.0).astype(float)
        seen, others = self.seen, self.others
        first = self.row[seen] * self.number
        matrix = np.zeros(self.number**2)
        own = -entries.sum(axis=1)
        for offset in (0, 1):
            share = sign * entries * (self.part[others] if offset else 1.0 - self.part[others])
            place = (first[:, None] + self.below[others] + offset).ravel()
            matrix += np.bincount(place, share.ravel(), self.number**2)
            share = own * (self.part[seen] if offset else 1.0 - self.part[seen])
            matrix += np.bincount(first + self.below[seen] + offset, share, self.number**2)
        counts = np.bincount(self.row[seen], minlength=self.number)
        return matrix.reshape(self.number, self.number) / np.maximum(counts, 1)[:, None]

    def mean(self, values):
        """Return the means (rows,) of ``values`` (fluid,)."""
        return np.bincount(self.row, values, self.number) / self.counts

    def solution(self, right, coefficient):
        """Solve (1 - coefficient A) x = ``right`` (fluid,) on rows of particles that are alike."""
        if coefficient != self.inverted:  # all stages of a step have the same
            self.inverse = np.linalg.inv(np.eye(self.number) - coefficient * self.laplacian)
            self.inverted = coefficient
        return np.einsum("ij,j", self.inverse, self.mean(right))[self.row]  # no threads of BLAS


class ElasticAcross(Across):
    """The same for a liquid with memory, whose stress answers to the slope of the velocities."""

    def assemble(self, seen=SEEN):
        """Take up the operators, for the present places of the particles."""
        self.sort()
        super().assemble(seen)
        self.slope, self.even_slope = (self.matrix(self.operators.d_dy, sign) for sign in (self.odd, self.even))

    def correction(self, residual, coefficient, tangent):
        """Return what to add to velocities (fluid) with this ``residual`` of (1 - coefficient A - D tangent D) x."""
        elastic = np.einsum("ij,jk->ik", self.even_slope, self.mean(tangent)[:, None] * self.slope)  # likewise
        found = np.linalg.solve(np.eye(self.number) - coefficient * self.laplacian - elastic, self.mean(residual))
        return (1.0 - self.part) * found[self.below] + self.part * found[self.below + 1]
