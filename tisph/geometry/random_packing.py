"""Random places for circles that keep apart from one another and from walls.

Circles are put in one after another, the largest first, each where it is drawn to lie free (random sequential addition:
B. Widom, J. Chem. Phys. 44 (1966) 3888-3894). Circles of one size block one another at an area fraction of 0.547
(E. L. Hinrichsen, J. Feder and T. Jossang, J. Stat. Phys. 44 (1986) 793-827), gaps and the places between them counted
as theirs. What this cannot place starts at any places, and circles that are too close push one another apart.
"""

import numpy as np

DRAWS = 500
"""Places that are drawn for a circle, of which the first free one is taken."""

STARTS, SWEEPS = 4, 500
"""How often circles start to push one another apart, and how often they push."""

DENSEST = np.pi / 12**0.5
"""Area fraction of circles of one size that touch six others (A. Thue, 1910): of no others more is ever found."""

MARGIN = 1e-3
"""Part of the smallest radius by which circles are pushed farther apart than they need, so that pushing ends."""


def random_centres(radii, region, gap=0.0, seed=0):
    """Centres (n, 2) of circles of ``radii`` (n,) [length] in the ``Region``, the same ones for a ``seed``.

    Circles, their periodic copies and walls are ``gap`` [length] apart or more. None where no such places are found:
    with half the gap around each counted as its own, 30 circles of one size find places up to an area fraction of about
    0.75 in a periodic cell, and of 0.7 between walls ten radii apart.
    """
    radii, generator = np.asarray(radii, dtype=float), np.random.default_rng(seed)
    largest = radii.max(initial=0.0)
    taken = np.pi * ((radii + 0.5 * gap) ** 2).sum()
    if 2 * largest + gap > region.size.min() or taken > DENSEST * region.area:
        return None
    centres = _added(radii, region, gap, generator)
    for _ in range(STARTS):
        if centres is not None:
            break
        centres = _pushed_apart(radii, region, gap, generator)
    return centres


def _drawn(region, count, generator):
    return region.low + region.size * generator.uniform(size=(count, 2))


def _apart(region, one, other):
    """Vectors (n, m, 2) to places ``one`` (n, 2) from the nearest copies of ``other`` (m, 2)."""
    apart = one[:, None] - other
    return apart - np.where(region.periodic, region.size * np.round(apart / region.size), 0.0)


def _added(radii, region, gap, generator):
    """Centres by random sequential addition, None where a circle finds no place."""
    centres, placed = np.empty((len(radii), 2)), []
    for index in np.argsort(-radii, kind="stable"):
        places = _drawn(region, DRAWS, generator)
        distances = np.linalg.norm(_apart(region, places, centres[placed]), axis=-1) - radii[placed] - radii[index]
        free = (distances >= gap).all(axis=1) & (region.distance(places) - radii[index] >= gap)
        if not free.any():
            return None
        centres[index] = places[np.argmax(free)]
        placed.append(index)
    return centres


def _pushed_apart(radii, region, gap, generator):
    """Centres of circles that start anywhere, None where they are still too close after all sweeps."""
    wanted, margin = radii + radii[:, None] + gap, MARGIN * radii.min()
    np.fill_diagonal(wanted, -margin)
    centres = _drawn(region, len(radii), generator)
    for _ in range(SWEEPS):
        centres = region.off_walls(centres, radii + gap + margin)
        apart = _apart(region, centres, centres)
        distance = np.linalg.norm(apart, axis=-1)
        if (distance >= wanted).all() and (region.distance(centres) >= radii + gap).all():
            return region.wrapped(centres)
        overlap = np.maximum(wanted + margin - distance, 0.0)
        direction = apart / np.where(distance > 0, distance, 1.0)[..., None]
        centres = centres + 0.5 * (overlap[..., None] * direction).sum(axis=1)
    return None
