"""Velocity gradients at the particles of a box, by moving least squares.

They are the linear coefficients of the fits of ``fits.py`` around the particles: exact for velocities that are
polynomials of the fits' degree n, and with errors that fall with the n-th power of the spacing, wherever the particles
are.
"""

import numpy as np

from tisph.measures.fits import local_fits, parts, periodic_tree

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
