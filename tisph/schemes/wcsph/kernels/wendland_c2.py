"""Wendland C2, support 2 h (Wendland 1995; normalised for two dimensions). Use a smoothing ratio near 1.3."""

from math import pi

SUPPORT = 2.0
"""Radius beyond which the kernel is zero, in smoothing lengths."""

NORM = 7.0 / (4.0 * pi)


def value(q: float) -> float:
    """Kernel h^2 W at distance ``q`` = r/h: NORM (1 - q/2)+^4 (1 + 2 q)."""
    rest = max(0.0, 1.0 - 0.5 * q)
    return NORM * rest**4 * (1.0 + 2.0 * q)


def slope_over_q(q: float) -> float:
    """Minus the slope over the distance, -h^4 W'(r)/r at ``q`` = r/h: 5 NORM (1 - q/2)+^3."""
    rest = max(0.0, 1.0 - 0.5 * q)
    return 5.0 * NORM * rest * rest * rest
