"""Fields between the particles of a box and at them, by moving least squares; how evenly the particles fill the box.

Around a point (X, Y) a polynomial of degree n in (x - X, y - Y)/R is fitted to the values at its nearest particles by
weighted least squares, with the weight (1 - q)^4 (1 + 4 q) of the distance q over R, the distance of the farthest of
them. It is exact for polynomials of degree n, for all positions of the particles. No scheme uses these fits, so that
they can judge all schemes.

Velocity gradients are the linear coefficients of such fits around the particles; their errors fall with the n-th power
of the spacing. The mean velocity over a cell with bodies is an integral over values between the particles. The mean
over the particles is less accurate: where the first particles are a twentieth of a spacing too far from the walls, it
is too large by some 1e-3, while the velocities are correct to 1e-4.

Stokes' stream function of axisymmetric flow, u = (1/r) dpsi/dr and v = -(1/r) dpsi/dx with r the distance from the
axis, is the integral of u r over r from the inner wall, or the axis, where it is 0: 2 pi psi is the flow rate through
the cross-section up to r. u is fitted at the nodes of a grid as fine as the particles; within bodies it is their
velocity, so that the integral continues behind them.

Sources: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; weight: H. Wendland, Adv. Comput.
Math. 4 (1995) 389-396; stream function: G. K. Batchelor, An Introduction to Fluid Dynamics (1967), section 2.2.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legder, legval, legvander

from tisph.geometry.region import nearest_image, wrapped
from tisph.geometry.wanted_spacing import graded_boundary
from tisph.measures.flow import FlowInBox
from tisph.snapshot import Snapshot

CHUNK = 512
"""Points that are fitted at a time: their arrays, some megabytes, stay in the cache of a processor."""

NEIGHBOURS = {2: 18, 4: 44}
"""Number of particles of a fit by its degree: three times as many as coefficients, so that it is determined for any
disorder. Gradients, means and the stream function use these fits."""

PLANE = 6, 56
"""Degree and number of particles of fits in the plane: twice as many as coefficients. The errors of waves of 25, 35 and
50 particles are 7e-7, 6e-8 and 5e-9 of their size, at most a hundredth of the errors of any scheme."""

ACROSS = 4, 9
"""Degree and number of rows of fits in y alone; above degree 4 the fit at a wall is badly conditioned."""


def with_walls(scene: FlowInBox, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities (n, 2) of the particles, then of points on walls and inlets a spacing apart."""
    walls = wall_points(scene.seen(snapshot), snapshot.t)
    velocities = [body.velocity(points, snapshot.t) for body, points in walls]
    positions, velocity = _particles(snapshot)
    return np.concatenate([positions, *(points for _, points in walls)]), np.concatenate([velocity, *velocities])


def wall_points(scene: FlowInBox, t: float) -> list[tuple[Any, np.ndarray]]:
    """Return the walls and ends at which the velocity is known, each with points (n, 2) on it a spacing apart."""
    wanted, walls = scene.wanted_spacing, [body for body in scene.bodies if body.moves_fluid]
    if wanted.varies:
        return [(body, body.placed(graded_boundary(body, wanted, t), t).point) for body in walls]
    return [(body, body.boundary_points(scene.spacing, t).point) for body in walls]


def _particles(snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities (particles, 2) in double precision."""
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    return positions, np.stack([snapshot.u, snapshot.v], axis=1).astype(float)


def _finite(*arrays: np.ndarray) -> bool:
    return all(np.isfinite(array).all() for array in arrays)


UNDETERMINED = 1e-13
"""Eigenvalues of the equations of a fit, over the largest, that count as 0: disordered particles have 4e-11 or more."""


def interpolated(
    scene: FlowInBox, positions: np.ndarray, values: np.ndarray, points: np.ndarray, fit: tuple[int, int] = PLANE
) -> np.ndarray:
    """Interpolate ``values`` (particles, fields) at ``positions`` (particles, 2) to ``points`` (n, 2).

    Returns an array (n, fields), NaN where any number is not finite. In parallel flow the values depend on y alone.
    Rows and columns of a lattice leave terms of the fits undetermined, which are then as small as possible. ``fit``:
    degree and number of particles of fits in the plane.
    """
    if not _finite(values, positions):
        return np.full((len(points), values.shape[1]), np.nan)
    axes = [1] if scene.parallel else [0, 1]
    degree, near = ACROSS if scene.parallel else fit
    near = min(near * scene.columns if scene.parallel else near, len(positions))
    tree, _ = periodic_tree(scene, positions, axes)
    points, found = _in_box(scene, points, axes)[0], []
    for part in parts(points):
        equations, weighted, nearest, _ = _normal_equations(tree, part, degree, near)
        inverse = np.linalg.pinv(equations, rcond=UNDETERMINED, hermitian=True)
        found.append((inverse[:, :1] @ (weighted @ values[nearest]))[:, 0])
    return np.concatenate(found)


def parts(points: np.ndarray) -> Iterator[np.ndarray]:
    """Yield ``points`` in parts of ``CHUNK``."""
    yield from (points[start : start + CHUNK] for start in range(0, len(points), CHUNK))


def local_fits(
    tree: Any, points: np.ndarray, values: np.ndarray, degree: int, near: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return coefficients (points, terms, fields) of fits around ``points`` to ``near`` of ``values``, and radii R.

    ``tree`` contains the positions of the ``values`` (n, fields). Terms are the constant, x/R, y/R and then the rest.
    """
    equations, weighted, nearest, radius = _normal_equations(tree, points, degree, near or NEIGHBOURS[degree])
    return np.linalg.solve(equations, weighted @ values[nearest]), radius


def _normal_equations(
    tree: Any, points: np.ndarray, degree: int, near: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return matrices (points, terms, terms) and (points, terms, near), indices of the ``near`` values, and radii R."""
    distance, nearest = tree.query(points, near)
    radius = distance[:, -1:]
    fraction = distance / radius
    weight = (1 - fraction) ** 4 * (1 + 4 * fraction)
    coordinates = []
    for axis, period in enumerate(tree.boxsize):
        offset = tree.data[:, axis][nearest] - points[:, axis, None]
        coordinates.append((nearest_image(offset, period) if period else offset) / radius)
    basis = _terms(coordinates, degree)
    weighted = basis * weight[:, None]
    return weighted @ basis.transpose(0, 2, 1), weighted, nearest, radius


def periodic_tree(scene: FlowInBox, positions: np.ndarray, axes: Sequence[int] = (0, 1)) -> tuple[Any, np.ndarray]:
    """Return a search tree of ``positions`` (n, 2) in the box of ``scene``, and the positions wrapped into it.

    With one of the ``axes`` it contains that coordinate alone.
    """
    from scipy.spatial import cKDTree  # a fifth of a second to import, which only some runs need

    positions, sizes = _in_box(scene, positions, axes)
    return cKDTree(positions, boxsize=sizes), positions


def _in_box(scene: FlowInBox, positions: np.ndarray, axes: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates along ``axes`` of ``positions`` (n, 2), wrapped, and the periods, 0 for none."""
    sizes = np.where(scene.periodic, scene.extent, 0.0)[list(axes)]
    columns = [
        wrapped(positions[:, axis], size) if size else positions[:, axis]
        for axis, size in zip(axes, sizes, strict=True)
    ]
    return np.stack(columns, axis=1), sizes


def _terms(coordinates: Sequence[np.ndarray], degree: int) -> np.ndarray:
    """Return the products of powers of one or two ``coordinates`` (points, near) up to ``degree``.

    An array (points, terms, near): the constant, the coordinates, the rest.
    """
    along, *across = coordinates
    count = (degree + 1) * (degree + 2) // 2 if across else degree + 1
    terms = np.empty((len(along), count, along.shape[1]))
    terms[:, 0] = 1.0
    first, end = 0, 1  # the terms of the last power
    for _ in range(degree):
        first, end, last = end, end + end - first + len(across), first
        np.multiply(terms[:, last:first], along[:, None], out=terms[:, first : first + first - last])
        for other in across:
            np.multiply(terms[:, first - 1], other, out=terms[:, end - 1])
    return terms


def velocity_gradients(scene: FlowInBox, snapshot: Snapshot, degree: int = 4) -> np.ndarray:
    """Return du/dx, du/dy, dv/dx, dv/dy at the particles, array (4, particles); ``degree`` is 2 or 4.

    NaN everywhere where any number of the snapshot is not finite.
    """
    positions, velocity = _particles(snapshot)
    if not _finite(velocity, positions):
        return np.full((4, len(positions)), np.nan)
    tree, positions = periodic_tree(scene, positions)
    gradients = []
    for part in parts(positions):
        coefficients, radius = local_fits(tree, part, velocity, degree)
        slopes = coefficients[:, 1:3] / radius[:, :, None]  # (particles, along x or y, u or v)
        gradients.append(slopes.transpose(2, 1, 0).reshape(4, -1))
    return np.concatenate(gradients, axis=1)


def vorticity(scene: FlowInBox, snapshot: Snapshot, degree: int = 4) -> np.ndarray:
    """Return dv/dx - du/dy at the particles, array (particles,), from ``velocity_gradients``."""
    gradients = velocity_gradients(scene, snapshot, degree)
    return gradients[2] - gradients[1]


MARGIN = 4.0
"""Largest spacings by which a periodic box is continued: wider than any void of a coherent fluid."""


def min_distance(scene: FlowInBox, snapshot: Snapshot) -> float:
    """Return the smallest distance of a particle from another over its width; 1 on a lattice."""
    tree, positions = periodic_tree(scene, _particles(snapshot)[0])
    return (tree.query(positions, 2)[0][:, 1] / snapshot.widths(scene.spacing)).min()


def max_void_radius(scene: FlowInBox, snapshot: Snapshot) -> float:
    """Return the largest radius of a circle without a particle, over its spacing; sqrt(1/2) on a lattice.

    It goes through the corners of a triangle of the Delaunay triangulation of the particles; its spacing is the largest
    of their widths. Where the box is not periodic, only centres between particles count. No particle is farther from a
    centre than the corners are, so that the largest circles are searched first.
    """
    from scipy.spatial import Delaunay  # a fifth of a second to import, which only some runs need

    low, sizes = np.asarray(scene.origin), np.asarray(scene.extent)
    periods = np.where(scene.periodic, sizes, 1.0)
    particles = _particles(snapshot)[0]
    positions, widths = np.where(scene.periodic, particles % periods, particles), snapshot.widths(scene.spacing)
    for axis in (0, 1):
        if scene.periodic[axis]:
            copies = [positions + shift * sizes[axis] * np.eye(2)[axis] for shift in (-1, 0, 1)]
            positions = np.concatenate(copies)
            near = np.abs(positions[:, axis] - 0.5 * sizes[axis]) <= 0.5 * sizes[axis] + MARGIN * scene.spacing
            positions, widths = positions[near], np.tile(widths, 3)[near]
    triangles = Delaunay(positions).simplices
    (corner, *others), spacing = positions[triangles].transpose(1, 0, 2), widths[triangles].max(axis=1)
    (ax, ay), (bx, by) = ((other - corner).T for other in others)
    squares, doubled = (ax**2 + ay**2, bx**2 + by**2), 2.0 * (ax * by - ay * bx)
    with np.errstate(divide="ignore", invalid="ignore"):  # three particles in line at the edge
        away = np.stack([by * squares[0] - ay * squares[1], ax * squares[1] - bx * squares[0]], axis=1)
        away /= doubled[:, None]
    vertices, radii = corner + away, np.hypot(*away.T) / spacing
    within = np.flatnonzero(((vertices >= low) & (vertices <= low + sizes)).all(axis=1))
    tree, _ = periodic_tree(scene, particles)
    seen, largest = scene.seen(snapshot) if scene.bodies else None, 0.0
    for part in parts(within[np.argsort(-radii[within])]):
        if radii[part[0]] * (1 + 1e-6) < largest:  # rounding errors of flat triangles
            break
        part = part[seen.contains(vertices[part], snapshot.t)] if seen else part
        distances = tree.query(np.where(scene.periodic, vertices[part] % periods, vertices[part]))[0]
        largest = max(largest, (distances / spacing[part]).max(initial=0.0))
    return largest


MOST_NODES = 1600
"""Most nodes of a mean over a cell, so that it costs no more than a step."""

NODES_ACROSS = 40
"""Least number of nodes in a cross-section."""


def cell_mean(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return the mean (2,) of the velocity over the box of ``scene``, bodies included.

    The integral has nodes at least the smallest spacing apart: Gauss-Legendre nodes between walls, where the velocity
    has a slope at the ends, else a lattice. NaN where any number of the snapshot is not finite.
    """
    scene = scene.seen(snapshot)
    positions, velocity = with_walls(scene, snapshot)
    if not _finite(velocity, positions):
        return np.full(2, np.nan)
    tree, _ = periodic_tree(scene, positions)
    nodes, weights = _nodes(scene)
    feet = np.stack([body.nearest(nodes, snapshot.t).distance for body in scene.bodies])
    values, nearest, in_fluid = np.zeros_like(nodes), np.argmin(feet, axis=0), feet.min(axis=0) > 0.0
    for index, body in enumerate(scene.bodies):
        within = (nearest == index) & ~in_fluid & body.in_fluid
        values[within] = body.velocity(nodes[within], snapshot.t)
    values[in_fluid] = local_fits(tree, nodes[in_fluid], velocity, 2)[0][:, 0]
    return weights @ values


CELL = 8
"""Rows and columns of particles in a cell of ``fluid_mean``: three times as many particles as coefficients."""

CELL_DEGREE = 5
"""Degree of the polynomials in a cell. For a wave u of 64 particles, a jitter of a fifth of the spacing and a density
that varies by a hundredth, the mean of u^2 is 5e-7 off, and the mean over the particles 4e-3; of 32 particles 2e-5."""


def fluid_mean(
    places: np.ndarray, values: np.ndarray, weight: Any, rows: np.ndarray, periodic: Sequence[bool]
) -> float:
    """Return the mean over a unit square of ``values`` (n,) at ``places`` (n, 2), however unevenly these lie.

    ``rows``: particles along x and along y that an even arrangement has; ``weight`` of each particle. In each cell of
    about ``CELL`` rows and columns a polynomial is fitted by least squares. It is summed over the places of the even
    arrangement, so that even particles have their own mean; at walls, ends that are not ``periodic``, the terms of
    Euler and Maclaurin make the sum an integral. NaN where any number is not finite.
    """
    if not _finite(places, values):
        return np.nan
    local, cells, sums = zip(*map(_along, places.T, rows, periodic), strict=True)
    powers = np.array([(i, j) for i in range(CELL_DEGREE + 1) for j in range(CELL_DEGREE + 1 - i)])
    index, total = cells[0] * len(sums[1]) + cells[1], len(sums[0]) * len(sums[1])
    order, number = np.argsort(index, kind="stable"), np.bincount(index, minlength=total)
    cell, row = index[order], np.arange(len(index)) - np.repeat(np.cumsum(number) - number, number)
    basis, value = np.zeros((total, number.max(), len(powers))), np.zeros((total, number.max(), 1))
    along, across = (legvander(coordinate[order], CELL_DEGREE) for coordinate in local)
    root = np.sqrt(weight * np.ones(len(values)))[order, None]
    basis[cell, row] = root * along[:, powers[:, 0]] * across[:, powers[:, 1]]
    value[cell, row] = root * values[order, None]
    equations, right = basis.transpose(0, 2, 1) @ basis, basis.transpose(0, 2, 1) @ value
    if number.min() < 2 * len(powers):  # of a flow that went wrong, or of a few particles
        coefficients = np.linalg.pinv(equations, rcond=UNDETERMINED, hermitian=True) @ right
    else:
        coefficients = np.linalg.solve(equations, right)
    integrals = sums[0][:, None, powers[:, 0]] * sums[1][None, :, powers[:, 1]]
    return float(np.sum(integrals.reshape(total, -1) * coefficients[..., 0]))


def _along(place: np.ndarray, rows: float, periodic: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return coordinates from -1 to 1 in cells (n,), the cells (n,), and weights (cells, terms) of their polynomials.

    ``place`` (n,): coordinates from 0 to 1.
    """
    rows = max(1, round(rows))
    edges = np.round(np.linspace(0.0, rows, max(1, rows // CELL) + 1)).astype(int)
    counts = np.diff(edges)
    at = place % 1.0 if periodic else np.clip(place, 0.0, 1.0)
    cell = np.repeat(np.arange(len(counts)), counts)[np.minimum((at * rows).astype(int), rows - 1)]
    walls = np.zeros((len(counts), 2), dtype=bool)
    walls[0, 0] = walls[-1, 1] = not periodic
    sums = [
        count / rows * _mean_of_terms(int(count), *ends) for count, ends in zip(counts, walls.tolist(), strict=True)
    ]
    return 2.0 * (at * rows - edges[cell]) / counts[cell] - 1.0, cell, np.stack(sums)


END_TERMS = (1, 1 / 24), (3, -7 / 5760), (5, 31 / 967_680)
"""Derivatives, and factors of their differences between the ends, in the formula of Euler and Maclaurin for a sum over
the middles of intervals: the integral is the sum plus these, each times the power of the interval."""


@lru_cache
def _mean_of_terms(count: int, wall_before: bool, wall_behind: bool) -> np.ndarray:
    """Return means (terms,) of the Legendre polynomials over ``count`` even places, with ``END_TERMS`` at walls."""
    means = legvander((2.0 * np.arange(count) + 1.0) / count - 1.0, CELL_DEGREE).mean(axis=0)
    for order, factor in END_TERMS:
        for end, wall in ((-1.0, wall_before), (1.0, wall_behind)):
            slopes = legval(end, legder(np.eye(CELL_DEGREE + 1), order))
            means += wall * end * 0.5 * factor * (2.0 / count) ** (order + 1) * slopes
    return means


BAND = 8.0
"""Largest spacings on both sides of a cross-section in which all particles of its fits lie, also in a gap of three."""


def section_mean(scene: FlowInBox, snapshot: Snapshot, place: float, degree: int = 4) -> float:
    """Return the mean of u over the cross-section at ``place``, see ``section_weights``; NaN if a number is not finite.

    In an incompressible flow it is the mean over all of a box that is periodic in x, solids included, at a tenth of the
    cost of ``cell_mean``. The two differ by the errors of their nodes, up to 3e-4 of the velocity. ``degree``: 2 or 4.
    """
    if not np.isfinite(snapshot.x + snapshot.y + snapshot.u).all():
        return np.nan
    scene, t = scene.seen(snapshot), snapshot.t
    nodes, weights = _section(scene, place, t)

    def near(x: np.ndarray) -> np.ndarray:
        return np.flatnonzero(np.abs(nearest_image(x - nodes[0, 0], scene.extent[0])) <= BAND * scene.spacing)

    chosen = near(snapshot.x.astype(float))
    positions = [np.stack([snapshot.x[chosen], snapshot.y[chosen]], axis=1).astype(float)]
    velocity = [snapshot.u[chosen, None].astype(float)]
    for body, points in wall_points(scene, t):
        points = points[near(points[:, 0])]
        if len(points):
            positions.append(points)
            velocity.append(body.velocity(points, t)[:, :1])
    tree, _ = periodic_tree(scene, np.concatenate(positions))
    return float(weights @ local_fits(tree, nodes, np.concatenate(velocity), degree)[0][:, 0, 0])


def section_weights(scene: FlowInBox, positions: np.ndarray, t: float) -> np.ndarray:
    """Return weights (n,) of values at ``positions`` in their mean over the cross-section ``scene.open_section``.

    ``positions`` (n, 2) are the particles and points on walls at time ``t``. In axisymmetric flow the mean is taken
    over the area of the section. NaN where any number is not finite.
    """
    if not _finite(positions):
        return np.full(len(positions), np.nan)
    tree, _ = periodic_tree(scene, positions)
    place = scene.open_section(t)
    assert place is not None
    nodes, weights = _section(scene, place, t)
    return sum_weights(tree, nodes, weights)


def sum_weights(tree: Any, nodes: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return factors (n,) of values at the ``tree``'s n places in the sum of their fits at ``nodes`` times ``weights``.

    ``nodes`` (m, 2), ``weights`` (m,); the fits are exact for polynomials of degree 4.
    """
    equations, weighted, nearest, _ = _normal_equations(tree, nodes, 4, NEIGHBOURS[4])
    at_nodes = np.linalg.solve(equations, weighted)[:, 0]  # factors of the nearest values in the constant term
    return np.bincount(nearest.ravel(), (weights[:, None] * at_nodes).ravel(), tree.n)


def _section(scene: FlowInBox, place: float, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes (n, 2) of a mean over the cross-section at ``place`` along x, and their weights (n,).

    There are as many as particles across at the smallest spacing on it at time ``t``.
    """
    finest = scene.wanted_spacing.at(_across(scene, place, NODES_ACROSS)[0], t).min()
    nodes, weights, size = _across(scene, place, max(NODES_ACROSS, round(scene.extent[1] / finest)))
    if scene.axisymmetric:
        return nodes, weights * nodes[:, 1] / (weights @ nodes[:, 1])
    return nodes, weights * (size / scene.extent[1])


def _across(scene: FlowInBox, place: float, count: int) -> tuple[np.ndarray, np.ndarray, Any]:
    """Return ``count`` nodes (count, 2) across the box at ``place``, weights of sum 1, and the height between walls."""
    heights, weights = _rule(count, periodic=False)
    x = np.full_like(heights, place % scene.extent[0])
    low, size = scene.section(x)
    return np.stack([x, low + size * heights], axis=1), weights, size


def _nodes(scene: FlowInBox) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes (n, 2) of a mean over the cell and their weights (n,), which add up to 1."""
    size = np.asarray(scene.extent)
    pitch = max(scene.wanted_spacing.smallest, np.sqrt(size.prod() / MOST_NODES))
    counts = np.maximum(1, np.floor(size / pitch + 1e-9)).astype(int)
    rows = [_rule(int(count), periodic) for count, periodic in zip(counts, scene.periodic, strict=True)]
    nodes = np.stack(np.meshgrid(*(positions for positions, _ in rows), indexing="ij"), axis=-1).reshape(-1, 2)
    x = scene.origin[0] + size[0] * nodes[:, 0]
    low, height = scene.section(x)
    weights = np.outer(*(weights for _, weights in rows)).ravel()
    return np.stack([x, low + height * nodes[:, 1]], axis=1), weights * (height / size[1])


@lru_cache
def _rule(count: int, periodic: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes (count,) and weights (count,) of the integral over the interval from 0 to 1."""
    if periodic:
        return (np.arange(count) + 0.5) / count, np.full(count, 1.0 / count)
    positions, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (positions + 1.0), 0.5 * weights


GRID_NODES = 10_000
"""Nodes of the grid of the stream function up to which it is finer than the largest spacing: some 0.1 s a frame."""


def stream_function(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return psi at the particles, array (particles,) of length^3/time; NaN where any number is not finite."""
    from scipy.interpolate import CubicSpline, RectBivariateSpline  # some tenths of a second to import

    positions, velocity = with_walls(scene, snapshot)
    if not _finite(velocity, positions):
        return np.full(len(snapshot.x), np.nan)
    pitch = max(scene.wanted_spacing.smallest, min(scene.spacing, np.sqrt(np.prod(scene.extent) / GRID_NODES)))
    x, r = (
        np.linspace(low, low + size, 4 + int(size / pitch))  # a cubic spline needs four
        for low, size in zip(scene.origin, scene.extent, strict=True)
    )
    u = _velocity(scene, snapshot, positions, velocity, np.stack(np.meshgrid(x, r, indexing="ij"), axis=2))
    psi = CubicSpline(r, u * r, axis=1).antiderivative()(r)
    return RectBivariateSpline(x, r, psi).ev(snapshot.x, snapshot.y)


def _velocity(
    scene: FlowInBox, snapshot: Snapshot, positions: np.ndarray, velocity: np.ndarray, nodes: np.ndarray
) -> np.ndarray:
    """Return u (columns, rows) at ``nodes`` (columns, rows, 2); the last column may be a period behind the first."""
    last = len(nodes) - scene.periodic[0]
    points, t = nodes[:last].reshape(-1, 2), snapshot.t
    tree, wet = periodic_tree(scene, positions)[0], np.ones(len(points), dtype=bool)
    u: np.ndarray = np.zeros(len(points))
    for body in scene.seen(snapshot).bodies:
        within = body.nearest(points, t).distance < 0.0
        u[within] = body.velocity(points[within], t)[:, 0]
        wet &= ~within
    fits = [local_fits(tree, part, velocity[:, :1], 2)[0] for part in parts(points[wet])]
    u[wet] = np.concatenate(fits)[:, 0, 0]
    u = u.reshape(nodes[:last].shape[:2])
    return np.concatenate([u, u[: len(nodes) - last]])
