"""Pair weights by table: the slope of the kernel over the distance, without a root or a division.

A root, a division and three powers are nearly half the arithmetic of a pair. A piecewise linear function of
the squared distance takes their place; it is a kernel as good as the one it comes from, since the consistent
operators are normalised by their own moments, whatever the weights are.
"""

import numpy as np

from tisph.runtime import real, scalar, ti

INTERVALS = 2048
"""Table size: the weights are within 1e-5 of the largest (tested); 32 kB stay in cache."""


@ti.data_oriented
class WeightTable:
    """Weights -h^4 W'(r)/r of ``kernel`` for smoothing length ``length``, zero beyond its support."""

    def __init__(self, kernel, length):
        squares = np.arange(INTERVALS + 2) * (kernel.SUPPORT**2 / INTERVALS)
        # the limit at zero distance, where no pair is, need not be exact
        values = np.array([kernel.slope_over_q(q) for q in np.sqrt(np.maximum(squares, 1e-6))])
        self.entries = ti.Vector.field(2, real(), shape=INTERVALS + 1)
        self.entries.from_numpy(np.stack([values[:-1], np.diff(values)], 1))
        self.per_square = scalar(INTERVALS / (kernel.SUPPORT * length) ** 2)

    @ti.func
    def at(self, squared):
        """Return the weight of a pair at a squared distance."""
        place = ti.min(squared * self.per_square[None], float(INTERVALS))
        entry = ti.cast(place, ti.i32)
        value = self.entries[entry]
        return value.x + (place - entry) * value.y
