"""Modes of viscous flow round and round between two cylinders at rest: u_n(r) exp(-nu k_n^2 t).

    u_n(r) = J1(k r) Y1(k R1) - Y1(k r) J1(k R1),   k the roots of J1(k R2) Y1(k R1) - Y1(k R2) J1(k R1) = 0

With q_n = J1(k R1)/J1(k R2) a function s with s'' + s'/r - s/r^2 = 0 has, in these modes, the coefficients
pi (q_n s(R2) - s(R1))/(q_n^2 - 1), by Green's second identity and the Wronskian 2/(pi z) of J and Y.

Source: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, section 14.3, for order 1 instead of 0.
"""

from functools import lru_cache

import numpy as np

GRID = 8
"""Places between two roots, on average, where the cross product is evaluated to find them."""


@lru_cache(maxsize=32)
def modes(ratio, count):
    """Wave numbers k R1 and quotients q, each (count,), of the first ``count`` modes; ``ratio`` = R2/R1 > 1."""
    from scipy.special import j1, y1

    spacing = np.pi / (ratio - 1)  # of the roots, far out; none is below the first one's 0.9
    grid = spacing * np.arange(0.5, count + 1.5, 1 / GRID)
    values = j1(grid * ratio) * y1(grid) - y1(grid * ratio) * j1(grid)
    first = np.flatnonzero(values[:-1] * values[1:] < 0)[:count]
    low, high, sign = grid[first], grid[first + 1], np.sign(values[first])
    for _ in range(60):
        middle = 0.5 * (low + high)
        after = sign * (j1(middle * ratio) * y1(middle) - y1(middle * ratio) * j1(middle)) > 0
        low, high = np.where(after, middle, low), np.where(after, high, middle)
    k = 0.5 * (low + high)
    inner, outer = (j1(k), y1(k)), (j1(k * ratio), y1(k * ratio))
    # (J1, Y1) at both walls are parallel; the quotient of their lengths is sound where one component is near 0
    along = np.sign(inner[0] * outer[0] + inner[1] * outer[1])
    return k, along * np.hypot(*inner) / np.hypot(*outer)


def velocities(k, r):
    """Modes u_n(r), of the broadcast shape of ``k`` = k_n R1 and ``r`` = r/R1."""
    from scipy.special import j1, y1

    return j1(k * r) * y1(k) - y1(k * r) * j1(k)


def shear_rates(k, r):
    """r d(u_n/r)/dr in units of 1/R1; arguments as ``velocities``."""
    from scipy.special import j1, jv, y1, yv

    return -k * (jv(2, k * r) * y1(k) - yv(2, k * r) * j1(k))
