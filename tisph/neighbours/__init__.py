"""Neighbour search: cells by stable counting sort, particles kept in cell order, reusable Verlet lists."""

SKIN = 0.15
"""Reach beyond the kernel support, in particle spacings: measured best for the sum of pair loops and builds."""


def list_radius(cutoff, spacing):
    """Return the radius of the lists for a kernel support radius ``cutoff``."""
    return cutoff + SKIN * spacing
