"""Fixed ghosts: layers that continue the lattice beyond the walls, mirroring the fluid at their mirror points.

The value there is a least-squares fit of c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2 to the fluid particles around it
(F. Bierbrauer, "No-Slip Boundary Conditions in Smoothed Particle Hydrodynamics", slides 4 and 6, second way, whose fit
is linear: the Laplacian of a fourth-order row needs the curvature right).
"""

import math

import numpy as np

from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes.implicit._ghosts import Ghosts

UNKNOWNS = 6

SMALLEST_PIVOT = 1e-8
"""Of the moments, scaled to the sum of the weights: below, the unknown is left out."""


@ti.data_oriented
class FixedGhosts(Ghosts):
    """Fixed ghosts; ``share[k, n]`` is what neighbour n of the mirror point of ghost k contributes."""

    mirrors = True

    def __init__(self, points, channel, cutoff):
        super().__init__(points, channel, cutoff)
        self.share = ti.field(real(), shape=(points.ghost_slots, points.row_capacity))
        self.radius = scalar(cutoff)
        self.vector, self.matrix = ti.types.vector(UNKNOWNS, real()), ti.types.matrix(UNKNOWNS, UNKNOWNS, real())
        self.place(channel)

    @staticmethod
    def ghost_capacity(channel, cutoff):
        """Return the number of ghosts: all layers within cutoff."""
        return 2 * min(math.ceil(cutoff / channel.spacing), channel.rows) * channel.columns

    def place(self, channel):
        """Lay out the layers; they stay where they are."""
        layers = self.points.ghost_capacity // (2 * channel.columns)
        layer, column = np.divmod(np.arange(layers * channel.columns), channel.columns)
        x, depth = (column + 0.5) * channel.spacing, (layer + 0.5) * channel.spacing
        heights, mirrored = np.concatenate([-depth, channel.gap + depth]), np.concatenate([depth, channel.gap - depth])
        count, first = heights.size, self.points.capacity
        holding(self.points.position, _padded(np.stack([np.tile(x, 2), heights], 1), first, self.points.slots + 1))
        holding(self.points.mirror, _padded(np.stack([np.tile(x, 2), mirrored], 1), 0, self.points.ghost_slots))
        holding(self.count, count)
        self.depth, self.side = np.tile(depth, 2), np.repeat([0, 1], depth.size)

    def prepare(self):
        """Fit at all mirror points."""
        super().prepare()
        self.fit()

    @ti.kernel
    def fit(self):
        """Compute all shares."""
        ti.loop_config(serialize=self.points.serial)
        for k in range(self.count[None]):
            row = self.points.capacity + k
            moments = self.matrix(0.0)
            for n in range(self.points.count[row]):
                basis, weight = self.weighted_basis(k, self.points.neighbours[row, n])
                moments += weight * basis.outer_product(basis)
            coefficients = self.solved(moments)
            for n in range(self.points.count[row]):
                basis, weight = self.weighted_basis(k, self.points.neighbours[row, n])
                self.share[k, n] = weight * coefficients.dot(basis)

    @ti.func
    def weighted_basis(self, k, j):
        """Return basis and weight of point ``j`` around mirror point ``k``; the sentinel has the weight 0."""
        apart = self.points.position[j] - self.points.mirror[k]
        x, y = self.points.domain.minimum_image_x(apart.x) / self.radius[None], apart.y / self.radius[None]
        nearness = ti.max(0.0, 1.0 - x * x - y * y)
        inside = ti.cast(nearness > 0.0, self.share.dtype)
        x, y = x * inside, y * inside
        return self.vector(1.0, x, y, x * x, x * y, y * y), nearness * nearness

    @ti.func
    def solved(self, moments):
        """Return the first row of the inverse of ``moments``, by L D L^T; undetermined unknowns are left out."""
        lower, first = moments, self.vector(0.0)
        first[0] = 1.0
        for k in ti.static(range(UNKNOWNS)):
            usable = ti.cast(lower[k, k] > SMALLEST_PIVOT * moments[0, 0], self.share.dtype)
            inverse = usable / ti.select(usable > 0.0, lower[k, k], 1.0)
            for i in ti.static(range(k + 1, UNKNOWNS)):
                factor = lower[i, k] * inverse
                for j in ti.static(range(k + 1, UNKNOWNS)):
                    lower[i, j] -= factor * lower[k, j]
                first[i] -= factor * first[k]
        for back in ti.static(range(UNKNOWNS)):
            k = ti.static(UNKNOWNS - 1 - back)
            usable = ti.cast(lower[k, k] > SMALLEST_PIVOT * moments[0, 0], self.share.dtype)
            for j in ti.static(range(k + 1, UNKNOWNS)):
                first[k] -= lower[k, j] * first[j]
            first[k] *= usable / ti.select(usable > 0.0, lower[k, k], 1.0)
        return first

    def source_values(self, values):
        """Return the values at the mirror points, of an array over the slots or of two, (slots + 1, 2)."""
        count = self.side.size
        table, listed = self.points.listed_neighbours(slice(self.points.capacity, self.points.capacity + count))
        return np.einsum("nk,nk...->n...", np.where(listed, view(self.share)[:count], 0.0), values[table])

    @ti.func
    def value(self, values: ti.template(), k):
        """Return the value at the mirror point of ghost ``k``."""
        row = self.points.capacity + k
        total = 0.0 * values[0]
        for n in range(self.points.count[row]):
            total += self.share[k, n] * values[self.points.neighbours[row, n]]
        return total


def _padded(values, first, size):
    """Return an array of ``size`` with ``values`` from ``first`` on, else zeros."""
    after = size - first - len(values)
    return np.pad(values, [(first, after)] + [(0, 0)] * (values.ndim - 1))
