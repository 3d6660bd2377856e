"""Smoothing kernels, as plain arithmetic that Taichi compiles. One file each."""

SKIN = 0.15
"""Radius of the lists beyond the kernel support, in particle spacings: fastest for the sum of pair loops and builds."""


def list_radius(cutoff: float, spacing: float) -> float:
    """Return the radius of the lists for a kernel support radius ``cutoff``."""
    return cutoff + SKIN * spacing
