"""Modes of viscous flow around the axis between two cylinders at rest: u_n(r) exp(-nu k_n^2 t).

    u_n(r) = J1(k r) Y1(k R1) - Y1(k r) J1(k R1),   k the roots of J1(k R2) Y1(k R1) - Y1(k R2) J1(k R1) = 0

With q_n = J1(k R1)/J1(k R2) a function s with s'' + s'/r - s/r^2 = 0 has, in these modes, the coefficients
pi (q_n s(R2) - s(R1))/(q_n^2 - 1), by Green's second identity and the Wronskian 2/(pi z) of J and Y.

Along the axis the order of J and Y is 0 instead of 1, s'' + s'/r = 0, and the coefficients are the same.

Source: H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, section 14.3, for order 0.
"""

from functools import lru_cache

import numpy as np

GRID = 8
"""Places between two roots, on average, where the cross product is evaluated to find them."""


@lru_cache(maxsize=32)
def modes(ratio, count, order=1):
    """Wave numbers k R1 and quotients q, each (count,), of the first ``count`` modes; ``ratio`` = R2/R1 > 1."""
    j, y = _bessel(order)
    spacing = np.pi / (ratio - 1)  # of the roots, far out; none is below the first one's 0.9
    grid = spacing * np.arange(0.5, count + 1.5, 1 / GRID)
    values = j(grid * ratio) * y(grid) - y(grid * ratio) * j(grid)
    first = np.flatnonzero(values[:-1] * values[1:] < 0)[:count]
    low, high, sign = grid[first], grid[first + 1], np.sign(values[first])
    for _ in range(60):
        middle = 0.5 * (low + high)
        after = sign * (j(middle * ratio) * y(middle) - y(middle * ratio) * j(middle)) > 0
        low, high = np.where(after, middle, low), np.where(after, high, middle)
    k = 0.5 * (low + high)
    inner, outer = (j(k), y(k)), (j(k * ratio), y(k * ratio))
    # (J, Y) at both walls are parallel; the quotient of their lengths is sound where one component is near 0
    along = np.sign(inner[0] * outer[0] + inner[1] * outer[1])
    return k, along * np.hypot(*inner) / np.hypot(*outer)


def _bessel(order):
    from scipy.special import j0, j1, y0, y1

    return (j0, y0) if order == 0 else (j1, y1)


def velocities(k, r, order=1):
    """Modes u_n(r), of the broadcast shape of ``k`` = k_n R1 and ``r`` = r/R1."""
    j, y = _bessel(order)
    return j(k * r) * y(k) - y(k * r) * j(k)


def shear_rates(k, r):
    """r d(u_n/r)/dr in units of 1/R1; arguments as ``velocities``."""
    from scipy.special import j1, jv, y1, yv

    return -k * (jv(2, k * r) * y1(k) - yv(2, k * r) * j1(k))
