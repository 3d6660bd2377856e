"""Fields between the particles of a box, by moving least squares.

Around a point a polynomial of degree n in (x - X, y - Y)/R is fitted to the values at its nearest particles by weighted
least squares, weight (1 - q)^4 (1 + 4 q) of the distance q over R, which is that of the farthest of them: exact for
fields that are polynomials of degree n, wherever the particles are. No scheme has a part in it, so it can judge all.

Source: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; weight: H. Wendland, Adv. Comput.
Math. 4 (1995) 389-396.
"""

import numpy as np

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
    offset = tree.data[nearest] - points[:, None]
    sizes = np.where(tree.boxsize > 0, tree.boxsize, np.inf)
    offset -= np.where(np.isfinite(sizes), sizes, 0.0) * np.round(offset / sizes)
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
