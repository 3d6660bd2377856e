"""Stokes' stream function of axisymmetric flow.

u = (1/r) dpsi/dr and v = -(1/r) dpsi/dx, with r the distance from the axis: 2 pi psi flows through the cross-section up
to r. psi is the integral of u r over r from the inner wall, or the axis, where it is 0. u is fitted (``fits.py``) at
the nodes of a grid as fine as the particles; within bodies it is theirs, so that the integral goes on behind them.

Source: G. K. Batchelor, An Introduction to Fluid Dynamics (1967), section 2.2.
"""

import numpy as np

from tisph.measures.fits import local_fits, parts, periodic_tree, with_walls

_DEGREE, _NEAR = 2, 18  # of the fits, as of gradients that are drawn (``gradients.py``)


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
