"""Scatter of the forces on bodies from step to step: what a sample's drag may be off by at random.

Where particles close to a body come to lie in layers its operators, and so its drag, jump for a few steps. Each force
is compared with the cubic in time through the two before and the two after it, which a drag that varies smoothly
follows.
"""

import math

import numpy as np

STEPS = 12
"""Last steps whose forces count."""

NEIGHBOURS = -2, -1, 1, 2
"""Steps, from one of them, through whose forces the cubic goes."""


def scatter(times, forces):
    """Return the largest scatter of a body's force, relative to its size, and the number of that body; None if unknown.

    ``times`` (steps,), newest first, ``forces`` (steps, bodies, 2). It is the root mean square over the steps of the
    difference from the cubic, without the part that the forces on the cubic have in it, over that of the largest force.
    """
    if len(times) <= len(NEIGHBOURS):
        return None
    middles, squares = np.arange(2, len(times) - 2), 0.0
    for middle in middles:
        others = times[[middle + offset for offset in NEIGHBOURS]] - times[middle]
        weights = np.array([math.prod(b / (b - a) for b in others if b != a) for a in others])
        cubic = np.einsum("s,sbi->bi", weights, forces[[middle + offset for offset in NEIGHBOURS]])
        squares = squares + ((forces[middle] - cubic) ** 2).sum(axis=1) / (1.0 + weights @ weights)
    size = np.sqrt((forces[middles] ** 2).sum(axis=2).mean(axis=0).max())
    worst = int(np.argmax(squares))
    return (math.sqrt(squares[worst] / len(middles)) / size, worst) if size > 0.0 else None
