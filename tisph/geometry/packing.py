"""Particles that fill a region evenly: a lattice, relaxed to the walls, and jittered on request; circles at random.

Relaxing moves every particle down the gradient of the particles' density (Fick's law: S. J. Lind et al., J. Comput.
Phys. 231 (2012) 1499-1523). The mirror images of the particles behind the walls count: the first layer comes to rest
about half a spacing from a wall (0.46 to 0.52 on average, as the rows pack).

Circles at random places have gaps between one another and to walls. They are added one after another, the largest
first, each at a random free place (random sequential addition: B. Widom, J. Chem. Phys. 44 (1966) 3888-3894). Circles
of one size block one another at an area fraction of 0.547, gaps included (E. L. Hinrichsen, J. Feder and T. Jossang, J.
Stat. Phys. 44 (1986) 793-827). Where no free place is left, all circles start at random places and push one another
apart.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.geometry.region import Region, nearest_image

DRAWS = 500
"""Random places tried for a circle; it gets the first free one."""

STARTS, PUSHES = 4, 500
"""Starts from random places from which circles push one another apart, and pushes per start."""

DENSEST = np.pi / 12**0.5
"""Area fraction of circles of one size that touch six others (A. Thue, 1910); mixtures are not packed more densely."""

MARGIN = 1e-3
"""Part of the smallest radius by which circles are pushed farther apart than necessary, so that pushing ends."""


def random_centres(
    radii: Sequence[float] | np.ndarray, region: Region, gap: float = 0.0, seed: int = 0
) -> np.ndarray | None:
    """Return centres (n, 2) of circles of ``radii`` (n,) [length] in ``region``, the same for the same ``seed``.

    Circles, their periodic copies and walls are ``gap`` [length] apart or more. None where no such places are found:
    with half the gap added to each radius, 30 circles of one size find places up to an area fraction of about 0.75 in a
    periodic cell, and of 0.7 between walls ten radii apart.
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


def _drawn(region: Region, count: int, generator: np.random.Generator) -> np.ndarray:
    return region.low + region.size * generator.uniform(size=(count, 2))


def _apart(region: Region, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return vectors (n, m, 2) to places ``one`` (n, 2) from the nearest copies of ``other`` (m, 2)."""
    return nearest_image(one[:, None] - other, region.periods)


def _added(radii: np.ndarray, region: Region, gap: float, generator: np.random.Generator) -> np.ndarray | None:
    """Return centres (n, 2) by random sequential addition; None where a circle finds no place."""
    centres, placed = np.empty((len(radii), 2)), list[int]()
    for index in np.argsort(-radii, kind="stable"):
        places = _drawn(region, DRAWS, generator)
        distances = np.linalg.norm(_apart(region, places, centres[placed]), axis=-1) - radii[placed] - radii[index]
        free = (distances >= gap).all(axis=1) & (region.distance(places) - radii[index] >= gap)
        if not free.any():
            return None
        centres[index] = places[np.argmax(free)]
        placed.append(index)
    return centres


def _pushed_apart(radii: np.ndarray, region: Region, gap: float, generator: np.random.Generator) -> np.ndarray | None:
    """Return centres (n, 2) by pushing circles apart from random places; None where ``PUSHES`` do not suffice."""
    wanted, margin = radii + radii[:, None] + gap, MARGIN * radii.min()
    np.fill_diagonal(wanted, -margin)
    centres = _drawn(region, len(radii), generator)
    for _ in range(PUSHES):
        centres = region.off_walls(centres, radii + gap + margin)
        apart = _apart(region, centres, centres)
        distance = np.linalg.norm(apart, axis=-1)
        if (distance >= wanted).all() and (region.distance(centres) >= radii + gap).all():
            return region.wrapped(centres)
        overlap = np.maximum(wanted + margin - distance, 0.0)
        direction = apart / np.where(distance > 0, distance, 1.0)[..., None]
        centres = centres + 0.5 * (overlap[..., None] * direction).sum(axis=1)
    return None


REACH = 2.0
"""Radius, in spacings, of the kernel (Wendland C2) of the density."""

DIFFUSION = 0.25
"""Displacement of a particle in a sweep over spacing^2 times the gradient of the density, 1 for an even lattice."""

SWEEPS = 30
SWEEPS_AFTER_JITTER = 2
LEAST_DISTANCE = 0.25
"""Least distance of a particle from walls, in spacings."""


def pack(region: Region, spacing: float, jitter: float = 0.0, seed: int = 0, count: int | None = None) -> np.ndarray:
    """Return places (n, 2) of particles that fill ``region``, n the ``count``, or area / spacing^2 rounded.

    Their distance from walls is at least a quarter of the spacing. ``jitter``: largest random displacement along x and
    y, in spacings, drawn from ``seed``. ValueError where the lattice has too few places in the region.
    """
    wanted = round(region.area / spacing**2) if count is None else count
    points = relaxed(region, _start(region, spacing, wanted), spacing, SWEEPS)
    if jitter:
        points = points + jitter * spacing * np.random.default_rng(seed).uniform(-1.0, 1.0, points.shape)
        points = relaxed(region, region.off_walls(points, LEAST_DISTANCE * spacing), spacing, SWEEPS_AFTER_JITTER)
    return region.wrapped(points)


def _start(region: Region, spacing: float, wanted: int) -> np.ndarray:
    """Return the places (``wanted``, 2) of a lattice that are deepest in the region."""
    for finer in (0, 1):  # where the spacing does not divide a side, its rounded number of rows may be too small
        counts = np.maximum(1, np.round(region.size / spacing).astype(int)) + finer
        sides = zip(region.low, region.size, counts, strict=True)
        rows = [low + (np.arange(n) + 0.5) * size / n for low, size, n in sides]
        lattice = np.stack(np.meshgrid(*rows, indexing="ij"), axis=-1).reshape(-1, 2)
        distance = region.distance(lattice)
        enough = wanted >= 1 and np.count_nonzero(distance > -0.5 * spacing) >= wanted
        if enough:
            break
    if not enough:
        raise ValueError(f"a lattice of spacing {spacing:g} has no room for {wanted} particles in the region")
    deepest = np.sort(np.argsort(-distance, kind="stable")[:wanted])
    return region.off_walls(lattice[deepest], LEAST_DISTANCE * spacing)


def relaxed(region: Region, points: np.ndarray, spacing: float, sweeps: int, chosen: Any = slice(None)) -> np.ndarray:
    """Return ``points`` (n, 2) after ``sweeps`` down the gradient of their density; the ``chosen`` ones move."""
    points = points.copy()
    for _ in range(sweeps):
        moved = points[chosen] - DIFFUSION * spacing**2 * _density_gradient(region, points, spacing)[chosen]
        points[chosen] = region.off_walls(moved, LEAST_DISTANCE * spacing)
    return points


def _density_gradient(region: Region, points: np.ndarray, spacing: float) -> np.ndarray:
    """Return the gradient (n, 2) of the density of particles and images, normalised to 1 for ``spacing``."""
    from scipy.spatial import cKDTree

    radius = REACH * spacing
    places = np.concatenate([points, region.images(points, radius)])
    box = region.periods
    shifted = np.where(region.periodic, (places - region.low) % region.size, places)
    i, j = cKDTree(shifted, boxsize=box if box.any() else None).query_pairs(radius, output_type="ndarray").T
    real = (i < len(points)) | (j < len(points))
    i, j = i[real], j[real]
    apart = nearest_image(shifted[i] - shifted[j], region.periods)
    q = np.linalg.norm(apart, axis=1) / radius
    # Wendland C2 in the plane, 7/(pi R^2) (1 - q)^4 (1 + 4 q): its gradient over the distance vector
    slope = -140 / np.pi * (1 - q) ** 3 * (spacing / radius**2) ** 2
    push = slope[:, None] * apart
    count = len(places)
    total = [np.bincount(i, push[:, c], count) - np.bincount(j, push[:, c], count) for c in (0, 1)]
    return np.stack(total, axis=1)[: len(points)]
