"""Particles that fill a region evenly: a lattice, relaxed to the walls, and shaken where wanted.

Relaxing moves every particle down the gradient of the particles' density (Fick's law: S. J. Lind et al., J. Comput.
Phys. 231 (2012) 1499-1523), in which the mirror images of the particles behind the walls count: the first
layer comes to rest about half a spacing from a wall (0.46 to 0.52 on average, as the rows pack).
"""

import numpy as np

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
    box = np.where(region.periodic, region.size, 0.0)
    shifted = np.where(region.periodic, (places - region.low) % region.size, places)
    i, j = cKDTree(shifted, boxsize=box if box.any() else None).query_pairs(radius, output_type="ndarray").T
    real = (i < len(points)) | (j < len(points))
    i, j = i[real], j[real]
    apart = shifted[i] - shifted[j]
    apart -= np.where(region.periodic, region.size * np.round(apart / region.size), 0.0)
    q = np.linalg.norm(apart, axis=1) / radius
    # Wendland C2 in the plane, 7/(pi R^2) (1 - q)^4 (1 + 4 q): its gradient over the distance vector
    slope = -140 / np.pi * (1 - q) ** 3 * (spacing / radius**2) ** 2
    push = slope[:, None] * apart
    count = len(places)
    total = [np.bincount(i, push[:, c], count) - np.bincount(j, push[:, c], count) for c in (0, 1)]
    return np.stack(total, axis=1)[: len(points)]
