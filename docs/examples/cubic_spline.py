"""Cubic spline, support 2 h (normalised for two dimensions)."""

from math import pi

SUPPORT = 2.0
"""Radius beyond which the kernel is zero, in smoothing lengths."""

NORM = 5.0 / (14.0 * pi)


def value(q):
    """Kernel h^2 W at distance ``q`` = r/h."""
    far = max(0.0, 2.0 - q)
    near = max(0.0, 1.0 - q)
    return NORM * (far**3 - 4.0 * near**3)


def slope_over_q(q):
    """Minus the slope over the distance, -h^4 W'(r)/r at ``q`` > 0."""
    far = max(0.0, 2.0 - q)
    near = max(0.0, 1.0 - q)
    return 3.0 * NORM * (far * far - 4.0 * near * near) / q
