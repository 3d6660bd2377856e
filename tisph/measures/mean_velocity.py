"""Mean velocity over a cell with bodies in it, by values between the particles.

The mean over the particles is no good measure: where walls have them a twentieth of a spacing farther off than half a
spacing, it is too large by some 1e-3 although the velocities themselves are right to 1e-4.
"""

from functools import lru_cache

import numpy as np

from tisph.measures.fits import local_fits, periodic_tree, value_weights, with_walls

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
