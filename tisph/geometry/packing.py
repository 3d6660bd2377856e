"""Particles that fill a region: a lattice or points on a curve, relaxed to the walls, and jittered; circles at random.

Relaxing moves every particle down the gradient of the particles' density (Fick's law: S. J. Lind et al., J. Comput.
Phys. 231 (2012) 1499-1523). The mirror images of the particles behind the walls count: the first layer comes to rest
about half a spacing from a wall (0.46 to 0.52 on average, as the rows pack).

Where the spacing h varies, particles start on a Hilbert curve through cells of half a spacing, one for each unit of the
integral of 1/h^2 along the curve. The particles i and j of a pair at the distance r move apart by

    h_ij phi(r/h_ij),    h_ij = (h_i + h_j)/2,

both by the same length. The factor h_ij is the power of h with which these pushes cancel in an arrangement of the
density 1/h^2, to first order in its growth. With h_i^2/h_ij the nearest two came nearer with each sweep (0.65 spacings
after 120, in place of 0.82).

Circles at random places have gaps between one another and to walls. They are added one after another, the largest
first, each at a random free place (random sequential addition: B. Widom, J. Chem. Phys. 44 (1966) 3888-3894). Circles
of one size block one another at an area fraction of 0.547, gaps included (E. L. Hinrichsen, J. Feder and T. Jossang, J.
Stat. Phys. 44 (1986) 793-827). Where no free place is left, all circles start at random places and push one another
apart.
"""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.geometry.region import Region, nearest_image
from tisph.geometry.wanted_spacing import WantedSpacing

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

SWEEPS, SWEEPS_FROM_CURVE = 30, 40
SWEEPS_AFTER_JITTER = 2
LEAST_DISTANCE = 0.25
"""Least distance of a particle from walls, in spacings."""

CELLS = 2.0
"""Least number of cells of the curve along a spacing."""

QUARTERS = np.array(
    [
        [[1.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.0, 0.5, 0.0]],
        [[1.0, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]],
        [[1.0, 0.5, 0.5], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]],
        [[1.0, 0.5, 1.0], [0.0, 0.0, -0.5], [0.0, -0.5, 0.0]],
    ]
)
"""Corner and sides a, b of the quarters of a cell, in the order of the curve, over corner and sides of the cell. The
curve goes through a cell from the corner to corner + b (D. Hilbert, Math. Ann. 38 (1891) 459-460)."""


def number_of_particles(region: Region, spacing: WantedSpacing, time: float = 0.0) -> int:
    """Return the integral of 1/h^2 over the ``region``, rounded, with the ``spacing`` h at ``time``."""
    if not spacing.varies:
        return round(region.area / spacing.largest**2)
    return round(_curve(region, spacing, time)[1].sum())


def pack(
    region: Region,
    spacing: float | WantedSpacing,
    jitter: float = 0.0,
    seed: int = 0,
    count: int | None = None,
    time: float = 0.0,
) -> np.ndarray:
    """Return places (n, 2) of particles that fill ``region``, n the ``count``, or the ``number_of_particles``.

    Their distance from walls is at least a quarter of the spacing, at ``time``. ``jitter``: largest random displacement
    along x and y, in spacings, drawn from ``seed``. ValueError where the region has too few places.
    """
    wanted = spacing if isinstance(spacing, WantedSpacing) else WantedSpacing(spacing)
    count = number_of_particles(region, wanted, time) if count is None else count
    if wanted.varies:
        start, sweeps = _along_curve(region, wanted, count, time), SWEEPS_FROM_CURVE
    else:
        start, sweeps = _start(region, wanted.largest, count), SWEEPS
    points = relaxed(region, start, wanted, sweeps, time=time)
    if jitter:
        length = jitter * np.reshape(_local(wanted, points, time), (-1, 1))
        points = points + length * np.random.default_rng(seed).uniform(-1.0, 1.0, points.shape)
        points = region.off_walls(points, LEAST_DISTANCE * _local(wanted, points, time))
        points = relaxed(region, points, wanted, SWEEPS_AFTER_JITTER, time=time)
    return region.wrapped(points)


def _local(wanted: WantedSpacing, points: np.ndarray, time: float) -> Any:
    """Return the spacing: one number, or (n,) at ``points`` (n, 2) where it varies."""
    return wanted.at(points, time) if wanted.varies else wanted.largest


def _curve(region: Region, spacing: WantedSpacing, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return cells (k, 3, 2), corners and both sides, in the order of a curve, and the integral (k,) of 1/h^2 in each.

    Cells are at most h/``CELLS`` long, at walls half of it. A wall cuts a cell into two by the distance of the centre
    and its differences along both sides; this is exact for straight walls along a side. The mean of 1/h^2 is that of
    four places (Gauss). The sum had an error of at most 0.3 particles for up to 14 000 with sources at walls.
    """
    along = int(np.argmax(region.size))
    count = max(1, round(region.size[along] / region.size[1 - along]))
    sides = np.diag(region.size / np.where(np.arange(2) == along, count, 1))
    cells = np.array([[region.low + k * sides[along], sides[1 - along], sides[along]] for k in range(count)])
    while True:
        centre = cells[:, 0] + 0.5 * cells[:, 1:].sum(axis=1)
        diagonal = np.linalg.norm(cells[:, 1:].sum(axis=1), axis=1)
        distance = region.distance(centre)
        cells, centre, diagonal, distance = (
            values[distance > -0.5 * diagonal] for values in (cells, centre, diagonal, distance)
        )
        largest = 2**0.5 / CELLS * spacing.at(centre, time) * (1 + 1e-9)
        divided = diagonal > np.where(distance < 0.5 * diagonal, 0.5 * largest, largest)
        if not divided.any():
            break
        quarters = np.where(divided[:, None, None, None], QUARTERS @ cells[:, None], cells[:, None])
        cells = quarters[divided[:, None] | (np.arange(4) == 0)]
    part, cut = np.ones(len(cells)), np.flatnonzero(distance < 0.5 * diagonal)
    ends = [region.distance(centre[cut] + sign * cells[cut, side]) for side in (1, 2) for sign in (-0.5, 0.5)]
    width = np.abs(ends[1] - ends[0]) + np.abs(ends[3] - ends[2])
    part[cut] = np.clip(0.5 + distance[cut] / np.maximum(width, 1e-300), 0.0, 1.0)
    gauss = 0.5 + np.array([-0.5, 0.5]) / 3**0.5
    density = np.mean([spacing.at(cells.transpose(0, 2, 1) @ [1.0, a, b], time) ** -2 for a in gauss for b in gauss], 0)
    area = np.abs(cells[:, 1, 0] * cells[:, 2, 1] - cells[:, 1, 1] * cells[:, 2, 0])
    return cells, part * area * density


def _along_curve(region: Region, spacing: WantedSpacing, count: int, time: float) -> np.ndarray:
    """Return places (``count``, 2) on the curve through the region, at equal parts of the integral of 1/h^2."""
    cells, integral = _curve(region, spacing, time)
    if count < 1 or not integral.any():
        raise ValueError(f"a region of {integral.sum():.3g} squares of the spacing has no room for {count} particles")
    up_to = np.cumsum(integral)
    places = (np.arange(count) + 0.5) * (up_to[-1] / count)
    which = np.searchsorted(up_to, places)
    within = 1.0 - (up_to[which] - places) / integral[which]
    corner, across, along = cells[which].transpose(1, 0, 2)
    points = corner + 0.5 * across + within[:, None] * along
    return region.off_walls(points, 0.5 * spacing.at(points, time))


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


def relaxed(
    region: Region,
    points: np.ndarray,
    spacing: float | WantedSpacing,
    sweeps: int,
    chosen: Any = slice(None),
    time: float = 0.0,
) -> np.ndarray:
    """Return ``points`` (n, 2) after ``sweeps`` down the gradient of their density; the ``chosen`` ones move."""
    wanted = spacing if isinstance(spacing, WantedSpacing) else WantedSpacing(spacing)
    points, step = points.copy(), DIFFUSION * wanted.smallest**2
    for _ in range(sweeps):
        sizes = _local(wanted, points, time)
        moved = points[chosen] - step * _density_gradient(region, points, sizes, wanted)[chosen]
        points[chosen] = region.off_walls(moved, LEAST_DISTANCE * (sizes[chosen] if wanted.varies else sizes))
    return points


def _density_gradient(region: Region, points: np.ndarray, sizes: Any, wanted: WantedSpacing) -> np.ndarray:
    """Return the gradient (n, 2) of the density of particles and images, normalised to 1 for the smallest spacing.

    ``sizes``: the spacing at the ``points``, one or (n,). Where it varies this is no gradient of a density; each pair
    contributes h_ij phi(r/h_ij) to both particles, over the square of the smallest spacing.
    """
    from scipy.spatial import cKDTree

    images, source = region.images(points, REACH * sizes)
    places = np.concatenate([points, images])
    box = region.periods
    shifted = np.where(region.periodic, (places - region.low) % region.size, places)
    tree = cKDTree(shifted, boxsize=box if box.any() else None)
    if wanted.varies:
        i, j = _pairs(tree, shifted, sizes, wanted.growth)
        sizes = np.concatenate([sizes, sizes[source]])
        size = 0.5 * (sizes[i] + sizes[j])
    else:
        i, j = tree.query_pairs(REACH * sizes, output_type="ndarray").T
        real = (i < len(points)) | (j < len(points))
        i, j, size = i[real], j[real], sizes
    radius = REACH * size
    apart = nearest_image(shifted[i] - shifted[j], region.periods)
    q = np.minimum(np.linalg.norm(apart, axis=1) / radius, 1.0)
    # Wendland C2 in the plane, 7/(pi R^2) (1 - q)^4 (1 + 4 q): its gradient over the distance vector
    slope = -140 / np.pi * (1 - q) ** 3 * ((size / radius**2) ** 2 * (size / wanted.smallest) ** 2)
    push = slope[:, None] * apart
    count = len(places)
    total = [np.bincount(i, push[:, c], count) - np.bincount(j, push[:, c], count) for c in (0, 1)]
    return np.stack(total, axis=1)[: len(points)]


def _pairs(tree: Any, places: np.ndarray, sizes: np.ndarray, growth: float) -> tuple[np.ndarray, np.ndarray]:
    """Return i < j (k,) of all pairs within ``REACH`` h_ij, and some more, of n particles and others.

    As h_j <= h_i + ``growth`` r, these are within ``REACH`` h_i / (1 - ``growth`` ``REACH``/2) of each other.
    """
    near = tree.query_ball_point(places[: len(sizes)], REACH * sizes / (1.0 - 0.5 * REACH * growth))
    i = np.repeat(np.arange(len(sizes)), [len(each) for each in near])
    j = np.fromiter(itertools.chain.from_iterable(near), dtype=int, count=len(i))
    return i[i < j], j[i < j]
