"""Fields between the particles of a box and at them, by moving least squares; how evenly the particles fill the box.

Around a point a polynomial of degree n in (x - X, y - Y)/R is fitted to the values at its nearest particles by weighted
least squares, weight (1 - q)^4 (1 + 4 q) of the distance q over R, the distance of the farthest of them: exact for
fields that are polynomials of degree n, wherever the particles are. No scheme has a part in it, so it can judge all.

Velocity gradients are the linear coefficients of such fits around the particles; their errors fall with the n-th power
of the spacing. The mean velocity over a cell with bodies is an integral over values between the particles. The mean
over the particles is no good measure: where walls have them a twentieth of a spacing farther off than half a
spacing, it is too large by some 1e-3 although the velocities themselves are right to 1e-4.

Stokes' stream function of axisymmetric flow, u = (1/r) dpsi/dr and v = -(1/r) dpsi/dx with r the distance from the
axis, is the integral of u r over r from the inner wall, or the axis, where it is 0: 2 pi psi flows through the
cross-section up to r. u is fitted at the nodes of a grid as fine as the particles; within bodies it is their velocity,
so that the integral continues behind them.

Sources: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; weight: H. Wendland, Adv. Comput.
Math. 4 (1995) 389-396; stream function: G. K. Batchelor, An Introduction to Fluid Dynamics (1967), section 2.2.
"""

from functools import lru_cache

import numpy as np

from tisph.geometry.region import nearest_image

CHUNK = 4096
"""Points at a time: some tens of megabytes."""

PLANE = 6, 56
"""Degree and nearest particles of values in the plane: twice as many as coefficients. Waves of 25, 35 and 50 particles
are met to 7e-7, 6e-8 and 5e-9 of their size, a hundredth and less of what any scheme makes of them."""

ACROSS = 4, 9
"""Degree and nearest rows of values that depend on y alone; above degree 4 the fit at a wall is badly conditioned."""


def with_walls(scene, snapshot):
    """Return positions and velocities (n, 2) of the particles, and after them of points on walls a spacing apart."""
    scene = scene.seen(snapshot)
    points = [body.boundary_points(scene.spacing, snapshot.t).point for body in scene.bodies]
    walls = [body.velocity(positions, snapshot.t) for body, positions in zip(scene.bodies, points, strict=True)]
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    velocity = np.stack([snapshot.u, snapshot.v], axis=1).astype(float)
    return np.concatenate([positions, *points]), np.concatenate([velocity, *walls])


def interpolated(scene, positions, values, points):
    """Return ``values`` (particles, fields) at ``positions`` (particles, 2) as they are at ``points`` (n, 2).

    An array (n, fields). Where all flow is along x the values are taken to depend on y alone. NaN everywhere where a
    number is none.
    """
    if not (np.isfinite(values).all() and np.isfinite(positions).all()):
        return np.full((len(points), values.shape[1]), np.nan)
    axes = [1] if scene.parallel else [0, 1]
    degree, near = ACROSS if scene.parallel else PLANE
    near = min(near * scene.columns if scene.parallel else near, len(positions))
    tree, _ = periodic_tree(scene, positions, axes)
    points = _wrapped(points[:, axes], _sizes(scene, axes))
    return np.concatenate([local_fits(tree, part, values, degree, near)[0][:, 0] for part in parts(points)])


def parts(points):
    """Yield ``points`` by ``CHUNK``."""
    yield from (points[start : start + CHUNK] for start in range(0, len(points), CHUNK))


def local_fits(tree, points, values, degree, near):
    """Return coefficients (points, terms, fields) of the fits around ``points`` to ``near`` of ``values``, and radii R.

    ``tree`` holds the positions of the ``values`` (n, fields). Terms are the constant, x/R, y/R and then the rest.
    """
    equations, weighted, nearest, radius = _normal_equations(tree, points, degree, near)
    return np.linalg.solve(equations, weighted @ values[nearest]), radius


def value_weights(tree, points, degree, near):
    """Return what ``near`` values are multiplied with in the fits at ``points``: weights (points, near), and indices.

    ``tree`` holds the positions of the values.
    """
    equations, weighted, nearest, _ = _normal_equations(tree, points, degree, near)
    return np.linalg.solve(equations, weighted)[:, 0], nearest


def _normal_equations(tree, points, degree, near):
    """Return matrices (points, terms, terms) and (points, terms, near), the ``near`` values, and the radii R."""
    distance, nearest = tree.query(points, near)
    radius = distance[:, -1:]
    offset = nearest_image(tree.data[nearest] - points[:, None], tree.boxsize)
    fraction = distance / radius
    weight = (1 - fraction) ** 4 * (1 + 4 * fraction)
    basis = np.stack(_terms((offset / radius[..., None]).transpose(2, 0, 1), degree), axis=1)
    weighted = basis * weight[:, None]
    return weighted @ basis.transpose(0, 2, 1), weighted, nearest, radius


def periodic_tree(scene, positions, axes=(0, 1)):
    """Return a search tree of ``positions`` (n, 2) in the box of ``scene``, and the positions as it holds them.

    With one of the ``axes`` alone it is of that coordinate.
    """
    from scipy.spatial import cKDTree  # a fifth of a second to import, which only some runs need

    sizes = _sizes(scene, list(axes))
    wrapped = _wrapped(positions[:, list(axes)], sizes)
    return cKDTree(wrapped, boxsize=sizes), wrapped


def _sizes(scene, axes):
    return np.where(scene.periodic, scene.extent, 0.0)[axes]


def _wrapped(positions, sizes):
    wrapped = np.where(sizes > 0, positions % np.where(sizes > 0, sizes, 1.0), positions)
    return np.where((sizes > 0) & (wrapped >= sizes), 0.0, wrapped)  # what is -1e-20 is a whole size after rounding


def _terms(coordinates, degree):
    """Return the products of powers of one or two ``coordinates`` up to ``degree``: the constant, these, the rest."""
    terms = last = [np.ones_like(coordinates[0])]
    for _ in range(degree):
        along, *across = coordinates
        last = [*(term * along for term in last), *(last[-1] * other for other in across)]
        terms = terms + last
    return terms


NEIGHBOURS = {2: 18, 4: 44}
"""Nearest particles, by degree: three times as many as coefficients, so that disorder leaves none undetermined."""


def velocity_gradients(scene, snapshot, degree=4):
    """Return du/dx, du/dy, dv/dx, dv/dy at the particles, array (4, particles); ``degree`` is 2 or 4.

    NaN everywhere where a number of the snapshot is none.
    """
    velocity = np.stack([snapshot.u, snapshot.v], axis=1).astype(float)
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    if not (np.isfinite(velocity).all() and np.isfinite(positions).all()):
        return np.full((4, len(positions)), np.nan)
    tree, positions = periodic_tree(scene, positions)
    return np.concatenate([_gradients(tree, part, velocity, degree) for part in parts(positions)], axis=1)


def vorticity(scene, snapshot, degree=4):
    """Return dv/dx - du/dy at the particles, array (particles,); ``degree`` and NaN as of ``velocity_gradients``."""
    gradients = velocity_gradients(scene, snapshot, degree)
    return gradients[2] - gradients[1]


def _gradients(tree, points, velocity, degree):
    coefficients, radius = local_fits(tree, points, velocity, degree, NEIGHBOURS[degree])
    slopes = coefficients[:, 1:3] / radius[:, :, None]  # (particles, along x or y, u or v)
    return slopes.transpose(2, 1, 0).reshape(4, -1)


MARGIN = 4.0
"""Spacings by which a periodic box is continued: wider than any void of a fluid that has not broken up."""


def min_distance(scene, snapshot):
    """Smallest distance of two particles over the spacing; 1 on a lattice."""
    tree, positions = periodic_tree(scene, _positions(snapshot))
    return tree.query(positions, 2)[0][:, 1].min() / scene.spacing


def max_void_radius(scene, snapshot):
    """Radius over the spacing of the largest circle in the box without a particle; sqrt(1/2) on a lattice.

    Its centre is a corner of the Voronoi cells of the particles. Where the box is not periodic, only circles around
    centres in between particles count.
    """
    from scipy.spatial import Voronoi  # a fifth of a second to import, which only some runs need

    low, sizes = np.asarray(scene.origin), np.asarray(scene.extent)
    periods = np.where(scene.periodic, sizes, 1.0)
    positions = np.where(scene.periodic, _positions(snapshot) % periods, _positions(snapshot))
    for axis in (0, 1):
        if scene.periodic[axis]:
            copies = [positions + shift * sizes[axis] * np.eye(2)[axis] for shift in (-1, 0, 1)]
            positions = np.concatenate(copies)
            near = np.abs(positions[:, axis] - 0.5 * sizes[axis]) <= 0.5 * sizes[axis] + MARGIN * scene.spacing
            positions = positions[near]
    cells = Voronoi(positions)
    within = cells.vertices[((cells.vertices >= low) & (cells.vertices <= low + sizes)).all(axis=1)]
    centres = within[scene.seen(snapshot).contains(within, snapshot.t)] if scene.bodies else within
    tree, _ = periodic_tree(scene, _positions(snapshot))
    return tree.query(np.where(scene.periodic, centres % periods, centres))[0].max() / scene.spacing


def _positions(snapshot):
    return np.stack([snapshot.x, snapshot.y], axis=1).astype(float)


MOST_NODES = 1600
"""At which the velocity is taken: at most, so that a mean costs no more than a step."""

DEGREE, NEAREST = 2, 18
"""Of the fits at the nodes, whose neighbours are particles and points on walls."""

PRECISE, MOST_ACROSS = (4, 44), 40
"""The same of the fits in a cross-section, and the nodes in it, if there are no more particles across."""


def cell_mean(scene, snapshot):
    """Mean (2,) of the velocity over the box of ``scene``, in which a body's solid moves as it does.

    Over nodes a particle spacing or more apart: those of Gauss and Legendre between walls, where the velocity has a
    slope at the ends, else of a lattice. NaN where a number of the snapshot is none.
    """
    scene = scene.seen(snapshot)
    positions, velocity = with_walls(scene, snapshot)
    if not (np.isfinite(velocity).all() and np.isfinite(positions).all()):
        return np.full(2, np.nan)
    tree, _ = periodic_tree(scene, positions)
    nodes, weights = _nodes(scene)
    feet = np.stack([body.nearest(nodes, snapshot.t).distance for body in scene.bodies])
    values, nearest, in_fluid = np.zeros_like(nodes), np.argmin(feet, axis=0), feet.min(axis=0) > 0.0
    for index, body in enumerate(scene.bodies):
        within = (nearest == index) & ~in_fluid & bool(body.shape.fluid_side == "outside" and body.shape.area)
        values[within] = body.velocity(nodes[within], snapshot.t)
    values[in_fluid] = local_fits(tree, nodes[in_fluid], velocity, DEGREE, NEAREST)[0][:, 0]
    return weights @ values


def section_weights(scene, positions, t):
    """Weights (n,) of values at ``positions`` in their mean over a cross-section of ``scene``, its ``open_section``.

    ``positions`` (n, 2) are those of particles and of points on walls at time ``t``. In axisymmetric flow the mean is
    that over the area of the section. NaN where a number is none.
    """
    if not np.isfinite(positions).all():
        return np.full(len(positions), np.nan)
    tree, _ = periodic_tree(scene, positions)
    heights, weights = _rule(max(MOST_ACROSS, round(scene.extent[1] / scene.spacing)), periodic=False)
    place = scene.open_section(t) % scene.extent[0]
    nodes = np.stack([np.full_like(heights, place), scene.origin[1] + scene.extent[1] * heights], axis=1)
    if scene.axisymmetric:
        weights = weights * nodes[:, 1] / (weights @ nodes[:, 1])
    at_nodes, nearest = value_weights(tree, nodes, *PRECISE)
    return np.bincount(nearest.ravel(), (weights[:, None] * at_nodes).ravel(), len(positions))


def _nodes(scene):
    """Return the nodes (n, 2) and their weights (n,), which add up to 1."""
    size = np.asarray(scene.extent)
    counts = np.maximum(1, np.floor(size / max(scene.spacing, np.sqrt(size.prod() / MOST_NODES)) + 1e-9)).astype(int)
    rows = [_rule(int(count), periodic) for count, periodic in zip(counts, scene.periodic, strict=True)]
    nodes = np.stack(np.meshgrid(*(positions for positions, _ in rows), indexing="ij"), axis=-1).reshape(-1, 2)
    return scene.origin + size * nodes, np.outer(*(weights for _, weights in rows)).ravel()


@lru_cache
def _rule(count, periodic):
    """Return positions (count,) and weights (count,) to integrate over the interval from 0 to 1."""
    if periodic:
        return (np.arange(count) + 0.5) / count, np.full(count, 1.0 / count)
    positions, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (positions + 1.0), 0.5 * weights


_DEGREE, _NEAR = 2, 18  # of the fits, as of gradients that are drawn (``velocity_gradients``)


def stream_function(scene, snapshot):
    """Return psi at the particles, array (particles,) of length^3/time; NaN everywhere where a number is none."""
    from scipy.interpolate import CubicSpline, RectBivariateSpline  # some tenths of a second to import

    positions, velocity = with_walls(scene, snapshot)
    if not (np.isfinite(velocity).all() and np.isfinite(positions).all()):
        return np.full(len(snapshot.x), np.nan)
    x, r = (
        np.linspace(low, low + size, 4 + int(size / scene.spacing))  # four at least: cubic splines
        for low, size in zip(scene.origin, scene.extent, strict=True)
    )
    u = _velocity(scene, snapshot, positions, velocity, np.stack(np.meshgrid(x, r, indexing="ij"), axis=2))
    psi = CubicSpline(r, u * r, axis=1).antiderivative()(r)
    return RectBivariateSpline(x, r, psi).ev(snapshot.x, snapshot.y)


def _velocity(scene, snapshot, positions, velocity, nodes):
    """Return u (columns, rows) at ``nodes`` (columns, rows, 2); the last column may be a period behind the first."""
    last = len(nodes) - scene.periodic[0]
    points, t = nodes[:last].reshape(-1, 2), snapshot.t
    tree, u, wet = periodic_tree(scene, positions)[0], np.zeros(len(points)), np.ones(len(points), dtype=bool)
    for body in scene.seen(snapshot).bodies:
        within = body.nearest(points, t).distance < 0.0
        u[within] = body.velocity(points[within], t)[:, 0]
        wet &= ~within
    fits = [local_fits(tree, part, velocity[:, :1], _DEGREE, _NEAR)[0] for part in parts(points[wet])]
    u[wet] = np.concatenate(fits)[:, 0, 0]
    u = u.reshape(nodes[:last].shape[:2])
    return np.concatenate([u, u[: len(nodes) - last]])
