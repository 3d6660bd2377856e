"""How much memory a run would need, known before anything is allocated."""

import math
import os
from typing import Any

from tisph.size_class import size_class

REALS = {False: 25, True: 280}
"""Numbers with fractions that a particle has in fields, by whether the scheme is implicit: the explicit one keeps two
copies of 11 and where the lists were made, the implicit one three rows of operators with 52 entries and vectors."""

WALLED_REALS = 200
"""What a particle has more than that in two-dimensional flow between walls: operators reach farther, and there are
points on the walls, ``WALL_POINTS`` times the root of the number of particles as around an annulus of ratio 1/2."""

WALL_POINTS = 6.0

STRESS_REALS = {False: 12, True: 110}
"""A particle's polymer stress: of the explicit scheme three numbers in two copies, at full and at half steps; of the
implicit one three, and their slopes, at the ends of three steps, and what solving for them takes."""

INTEGER_BYTES = {False: 24, True: 240}
"""A particle's places in lists and cells; those of its neighbours too in the implicit scheme."""

NEIGHBOUR_BYTES = 4 * 1.6
"""Bytes of the explicit scheme's lists for each particle within reach: an index, and room for disorder."""

REACH = 0.15
"""What lists reach beyond the kernel support, in particle spacings."""

HOST_BYTES = 165
"""What a particle takes outside the fields while a run is set up or output is written."""

MOST_PARTICLES = 20_000_000


def estimated_bytes(particles: float, config: Any, implicit: bool) -> float:
    """Estimated growth of a run's memory with its particles in bytes; ``implicit``: with which scheme.

    ``tisph bench throughput`` compares it with what a process takes.
    """
    reals = REALS[implicit] + STRESS_REALS[implicit] * config.fluid.rheology.carries_stress
    if implicit and not config.parallel and (getattr(config, "bodies", ()) or not all(config.periodic)):
        reals += WALLED_REALS
        particles += WALL_POINTS * math.sqrt(particles)
    fields = reals * (8 if config.discretisation.precision == "f64" else 4) + INTEGER_BYTES[implicit]
    lists = 0.0 if implicit else NEIGHBOUR_BYTES * math.pi * (config.support + REACH) ** 2
    return size_class(particles) * (fields + lists) + particles * HOST_BYTES


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
