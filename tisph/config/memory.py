"""How much memory a run would need, known before anything is allocated."""

import math
import os

FIELD_BYTES = 350
"""Estimate of a particle's fields: two copies of 14 numbers, and room for images of the particles at the walls."""

STRESS_BYTES = 96
"""A particle's polymer stress: three numbers in two copies, at full and at half steps."""

NEIGHBOUR_BYTES = 4 * 1.6
"""Bytes of the neighbour table for each particle within the kernel support: an index, and room for disorder."""

MOST_PARTICLES = 20_000_000


IMPLICIT_BYTES = 2450
"""A particle of the implicit scheme: three rows of 52 entries and their table, moments, coefficients, 40 vectors."""


def estimated_bytes(particles: float, support: float, carries_stress: bool, implicit: bool) -> float:
    """Estimated memory of the fields of a run in bytes, for a kernel ``support`` radius in particle spacings.

    ``carries_stress`` tells whether every particle has a stress of its own, ``implicit`` whether the scheme stores
    rows of operators.
    """
    if implicit:
        return particles * IMPLICIT_BYTES
    fields = FIELD_BYTES + (STRESS_BYTES if carries_stress else 0)
    return particles * (fields + NEIGHBOUR_BYTES * math.pi * support**2)


def physical_bytes() -> int | None:
    """Memory of this machine in bytes, None where the system does not tell (Windows)."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def format_bytes(count: float) -> str:
    """A byte count as text, such as ``3.1 GB``."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} PB"
