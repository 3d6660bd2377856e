"""How much memory a run would need, known before anything is allocated."""

import os

BYTES_PER_PARTICLE = 600
"""Estimate: two copies of about 20 f64 fields (the sort needs both), and some 60 neighbours at 4 bytes."""

MOST_PARTICLES = 20_000_000


def estimated_bytes(particles: float) -> float:
    """Estimated memory of a run in bytes."""
    return particles * BYTES_PER_PARTICLE


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
