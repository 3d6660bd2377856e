"""How evenly particles fill a box: the least distance of two of them, and the largest void between them."""

import numpy as np

from tisph.measures.fits import periodic_tree

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
