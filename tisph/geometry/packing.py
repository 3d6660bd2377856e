"""Particles that fill a region evenly: a lattice, relaxed to the walls, and shaken where wanted.

Relaxing moves every particle down the gradient of the particles' density (Fick's law: S. J. Lind et al., J. Comput.
Phys. 231 (2012) 1499-1523), in which the mirror images of the particles behind the walls count: the first
layer comes to rest about half a spacing from a wall (0.46 to 0.52 on average, as the rows pack).

Circles at random places keep apart from one another and from walls. They are put in one after another, the largest
first, each where it is drawn to lie free (random sequential addition: B. Widom, J. Chem. Phys. 44 (1966) 3888-3894).
Circles of one size block one another at an area fraction of 0.547 (E. L. Hinrichsen, J. Feder and T. Jossang, J. Stat.
Phys. 44 (1986) 793-827), gaps and the places between them counted as theirs. What this cannot place starts at any
places, and circles that are too close push one another apart.
"""

import numpy as np

from tisph.geometry.region import nearest_image

DRAWS = 500
"""Places that are drawn for a circle, of which the first free one is taken."""

STARTS, PUSHES = 4, 500
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
    return nearest_image(one[:, None] - other, region.periods)


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
"""Radius, in spacings, of the kernel (Wendland C2) by which the density is taken."""

DIFFUSION = 0.25
"""Share of spacing^2 times the gradient of the density, in particles per spacing^2, that a sweep moves a particle."""

SWEEPS = 30
SWEEPS_AFTER_JITTER = 2
LEAST_DISTANCE = 0.25
"""From walls, in spacings, that no particle goes below."""


def pack(region, spacing, jitter=0.0, seed=0):
    """Places (n, 2) of particles that fill ``region``, n the whole number nearest to area / spacing^2.

    None is nearer to a wall than a quarter of the spacing.

    ``jitter``: largest random displacement along x and y, in spacings, drawn from ``seed``. ValueError where the
    lattice has too few places in the region.
    """
    points = _relaxed(region, _start(region, spacing), spacing, SWEEPS)
    if jitter:
        points = points + jitter * spacing * np.random.default_rng(seed).uniform(-1.0, 1.0, points.shape)
        points = _relaxed(region, region.off_walls(points, LEAST_DISTANCE * spacing), spacing, SWEEPS_AFTER_JITTER)
    return region.wrapped(points)


def _start(region, spacing):
    """Return the places of a lattice that are deepest in the region, as many as its area has room for."""
    wanted = round(region.area / spacing**2)
    for finer in (0, 1):  # of a side that the spacing does not divide the nearest number of rows may be too small
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


def _relaxed(region, points, spacing, sweeps):
    for _ in range(sweeps):
        points = points - DIFFUSION * spacing**2 * _density_gradient(region, points, spacing)
        points = region.off_walls(points, LEAST_DISTANCE * spacing)
    return points


def _density_gradient(region, points, spacing):
    """Gradient (n, 2) of the density, 1 where particles are ``spacing`` apart, of the particles and their images."""
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
