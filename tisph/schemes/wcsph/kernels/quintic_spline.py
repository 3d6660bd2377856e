"""Quintic spline, support 3 h (Morris, Fox & Zhu 1997, eq. 17; normalised for two dimensions)."""

from math import pi

SUPPORT = 3.0
"""Radius beyond which the kernel is zero, in smoothing lengths."""

NORM = 7.0 / (478.0 * pi)


def value(q: float) -> float:
    """Kernel h^2 W at distance ``q`` = r/h: NORM [(3-q)+^5 - 6 (2-q)+^5 + 15 (1-q)+^5]."""
    far = max(0.0, 3.0 - q)
    middle = max(0.0, 2.0 - q)
    near = max(0.0, 1.0 - q)
    return NORM * (far**5 - 6.0 * middle**5 + 15.0 * near**5)


def slope_over_q(q: float) -> float:
    """Minus the slope over the distance, -h^4 W'(r)/r at ``q`` = r/h > 0: the weight of every pair sum.

    Written without branches so that the pair loop stays straight-line code.
    """
    far = max(0.0, 3.0 - q)
    middle = max(0.0, 2.0 - q)
    near = max(0.0, 1.0 - q)
    far2 = far * far
    middle2 = middle * middle
    near2 = near * near
    return 5.0 * NORM * (far2 * far2 - 6.0 * middle2 * middle2 + 15.0 * near2 * near2) / q
