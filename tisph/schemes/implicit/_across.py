"""A coarse level for linear systems of a parallel flow: velocities that depend on the height alone.

Its operators are those of the particles, seen by a few of each row: on a lattice, sheared or not, the solution is found
there to rounding, and iterations have nothing left to do; in disorder they begin nearer to it.
"""

import numpy as np

from tisph.runtime import view

SEEN = 8
"""Particles of a row of the start lattice that its operators are averaged over."""


class Across:
    """Rows of a ``channel`` as unknowns, linear in between; for ghosts that mirror a particle each."""

    def __init__(self, rows, ghosts, channel):
        self.rows, self.points, self.ghosts = rows, rows.points, ghosts
        self.spacing, self.number = channel.spacing, channel.rows

    def assemble(self):
        """Take up the operators, for the present places of the particles."""
        height = self.ghosts.heights().astype(float) / self.spacing - 0.5
        below = np.clip(np.floor(height), 0, self.number - 2).astype(int)
        self.below, self.part = below, height - below
        self.row = np.clip(np.rint(height), 0, self.number - 1).astype(int)
        self.counts = np.maximum(np.bincount(self.row, minlength=self.number), 1)
        seen = self._seen()
        source = np.arange(self.points.slots + 1)
        ghosts = self.ghosts.part(source)
        ghosts[...] = view(self.ghosts.source)[: ghosts.size]
        source[self.points.most + ghosts.size :] = source[self.points.fluid : self.points.most] = 0
        table, listed = self.points.listed(seen)
        even = np.ones(self.points.slots + 1)
        ghosts = self.ghosts.part(even)
        ghosts[...] = self.ghosts.sign()
        even = even[table]
        operators = self.rows.laplacian, self.rows.across
        entries = [np.where(listed, view(rows)[seen], 0.0).astype(float) for rows in operators]
        odd = np.where(table >= self.points.most, -even, even)
        self.laplacian = self._matrix(seen, source[table], entries[0], odd)
        self.slope, self.even_slope = (self._matrix(seen, source[table], entries[1], sign) for sign in (odd, even))

    def _seen(self):
        """Return some particles of each row."""
        order = np.argsort(self.row, kind="stable")
        rank = np.arange(len(order)) - np.searchsorted(self.row[order], self.row[order])
        return order[rank < SEEN]

    def _matrix(self, seen, others, entries, sign):
        """Return the operator (rows, rows) with such ``entries`` for the differences of ``others`` from ``seen``."""
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

    def correction(self, residual, coefficient, tangent):
        """Return what to add to velocities (fluid) with this ``residual`` of (1 - coefficient A - D tangent D) x."""
        mean_tangent, mean = (np.bincount(self.row, one, self.number) / self.counts for one in (tangent, residual))
        elastic = np.einsum("ij,jk->ik", self.even_slope, mean_tangent[:, None] * self.slope)  # no threads of BLAS
        found = np.linalg.solve(np.eye(self.number) - coefficient * self.laplacian - elastic, mean)
        return (1.0 - self.part) * found[self.below] + self.part * found[self.below + 1]
