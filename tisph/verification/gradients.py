"""Velocity gradients at the particles of a box, by moving least squares.

Around particle i a polynomial of degree n in (x - x_i, y - y_i)/R is fitted to both velocities of its nearest particles
by weighted least squares, weight (1 - q)^4 (1 + 4 q) of the distance q over R, which is that of the farthest of them.
Gradients are its linear coefficients: exact for velocities that are polynomials of degree n, and with errors that fall
with the n-th power of the spacing, wherever the particles are. No scheme has a part in it, so it can judge all.

Source: P. Lancaster and K. Salkauskas, Math. Comput. 37 (1981) 141-158; weight: H. Wendland, Adv. Comput.
Math. 4 (1995) 389-396.
"""

import numpy as np

NEIGHBOURS = {2: 18, 4: 44}
"""Nearest particles, by degree: three times as many as coefficients, so that disorder leaves none undetermined."""

CHUNK = 4096
"""Particles at a time: some tens of megabytes."""


def velocity_gradients(scene, snapshot, degree=4):
    """Return du/dx, du/dy, dv/dx, dv/dy at the particles, array (4, particles); ``degree`` is 2 or 4.

    NaN everywhere where a number of the snapshot is none.
    """
    velocity = np.stack([snapshot.u, snapshot.v], axis=1).astype(float)
    places = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    if not (np.isfinite(velocity).all() and np.isfinite(places).all()):
        return np.full((4, len(places)), np.nan)
    tree, places = periodic_tree(scene, places)
    parts = [slice(start, start + CHUNK) for start in range(0, len(places), CHUNK)]
    return np.concatenate([_gradients(scene, tree, places[part], velocity, degree) for part in parts], axis=1)


def periodic_tree(scene, places):
    """Return a search tree of ``places`` (n, 2) in the box of ``scene``, and the places as it holds them."""
    from scipy.spatial import cKDTree  # a fifth of a second to import, which only some runs need

    sizes = np.where(scene.periodic, scene.extent, 0.0)
    wrapped = np.where(sizes > 0, places % np.where(sizes > 0, sizes, 1.0), places)
    wrapped = np.where((sizes > 0) & (wrapped >= sizes), 0.0, wrapped)  # what is -1e-20 is a whole size after rounding
    return cKDTree(wrapped, boxsize=sizes), wrapped


def _gradients(scene, tree, places, velocity, degree):
    distance, near = tree.query(places, NEIGHBOURS[degree])
    radius = distance[:, -1:]
    offset = tree.data[near] - places[:, None]
    sizes = np.where(scene.periodic, scene.extent, np.inf)
    offset -= np.where(np.isfinite(sizes), sizes, 0.0) * np.round(offset / sizes)
    fraction = distance / radius
    weight = (1 - fraction) ** 4 * (1 + 4 * fraction)
    along, across = (offset[..., axis] / radius for axis in (0, 1))
    basis = np.stack(_terms(along, across, degree), axis=1)
    weighted = basis * weight[:, None]
    coefficients = np.linalg.solve(weighted @ basis.transpose(0, 2, 1), weighted @ velocity[near])
    slopes = coefficients[:, 1:3] / radius[:, :, None]  # (particles, along x or y, u or v)
    return slopes.transpose(2, 1, 0).reshape(4, -1)


def _terms(along, across, degree):
    """Return the products of powers up to ``degree``: the constant, x, y, and then the rest."""
    terms = last = [np.ones_like(along)]
    for _ in range(degree):
        last = [*(term * along for term in last), last[-1] * across]
        terms = terms + last
    return terms
