"""Pair weights by table: the slope of the kernel over the distance, without a root or a division.

A root, a division and three powers are nearly half the arithmetic of a pair. A piecewise linear function of
the squared distance takes their place; it is a kernel as good as the one it comes from, since the consistent
operators are normalised by their own moments, whatever the weights are.
"""

import numpy as np

from tisph.runtime import holding, real, scalar, ti

INTERVALS = 2048
"""Intervals within the support, a power of two: the weights are within 1e-5 of the largest (tested)."""

ENTRIES = 2 * INTERVALS
"""Table size: zero from the support to sqrt(2) times its radius, farther than any pair of a list can be; 64 kB."""


@ti.data_oriented
class WeightTable:
    """Weights -h^4 W'(r)/r of ``kernel`` for smoothing length ``length``, zero beyond its support.

    Entry k holds intercept and slope of the weight over the squared distance in interval k.
    """

    def __init__(self, kernel, length):
        squares = np.arange(INTERVALS + 1) * (kernel.SUPPORT**2 / INTERVALS)
        # the limit at zero distance, where no pair is, need not be exact
        values = np.array([kernel.slope_over_q(q) for q in np.sqrt(np.maximum(squares, 1e-6))])
        slopes = np.diff(values) / np.diff(squares)
        lines = np.zeros((ENTRIES, 2))
        lines[:INTERVALS] = np.stack([values[:-1] - slopes * squares[:-1], slopes / length**2], 1)
        self.entries = holding(ti.Vector.field(2, real(), shape=ENTRIES), lines)
        self.per_square = scalar(INTERVALS / (kernel.SUPPORT * length) ** 2)

    @ti.func
    def at(self, squared):
        """Return the weight of a pair at a squared distance; whatever that is, even NaN, no entry outside is read."""
        line = self.entries[ti.cast(squared * self.per_square[None], ti.i32) & (ENTRIES - 1)]
        return line.x + squared * line.y
