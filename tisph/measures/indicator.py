"""Where a flow needs particles: the error that fits of degree 4 between the particles would have, at each of them.

The operators of scheme ``implicit`` are exact for polynomials of degree 4. A polynomial of degree 5 is fitted around
each particle (``fits.py``). Its terms of degree 5, at the distance h of one spacing, are what the operators miss:

    e = |c_5| (h/R)^5 / size                                                                          (1)

with the norm of the coefficients c_5 of all components of a field, the radius R of the fit, and the size of the field.
It falls with the fifth power of the spacing. The fields are the velocity over the reference velocity, and the polymer
stress over its root mean square.
"""

import numpy as np

from tisph.measures.fits import local_fits, parts, periodic_tree, with_walls
from tisph.measures.flow import FlowInBox
from tisph.snapshot import STRESSES, STRESSES_AROUND, Snapshot

DEGREE = 5
"""Degree of the fits, one more than that of the operators: ``e`` falls with this power of the spacing."""

NEAR = 42
"""Number of particles of a fit: twice as many as coefficients."""

AROUND = 9
"""Number of particles over which squares are averaged: noise of single particles makes no place fine."""


def missed(scene: FlowInBox, snapshot: Snapshot) -> np.ndarray:
    """Return e of equation (1) at the particles (particles,), the largest one of the fields."""
    positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
    around = [getattr(snapshot, name) for name in (*STRESSES, *STRESSES_AROUND)]
    fields = [(*with_walls(scene, snapshot), scene.reference_velocity)]
    if snapshot.w is not None:
        fields.append((positions, np.reshape(snapshot.w, (-1, 1)).astype(float), scene.reference_velocity))
    if scene.polymer:
        stress = np.stack([each for each in around if each is not None], axis=1).astype(float)
        fields.append((positions, stress, np.sqrt(np.mean(np.sum(stress**2, axis=1))) or 1.0))
    spacing, found = snapshot.widths(scene.spacing), np.zeros(len(positions))
    for places, values, size in fields:
        tree, places = periodic_tree(scene, places)
        highest = []
        for part in parts(places[: len(positions)]):
            coefficients, radius = local_fits(tree, part, values, DEGREE, NEAR)
            highest.append(np.sqrt((coefficients[:, -DEGREE - 1 :] ** 2).sum(axis=(1, 2))) / radius[:, 0] ** DEGREE)
        found = np.maximum(found, np.concatenate(highest) * spacing**DEGREE / size)
    tree, places = periodic_tree(scene, positions)
    return np.sqrt(np.mean(found[tree.query(places, AROUND)[1]] ** 2, axis=1))
