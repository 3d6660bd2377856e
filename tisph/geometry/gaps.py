"""How close bodies and walls come to each other."""

import itertools
import math
from dataclasses import replace

import numpy as np

POINTS = 1000
"""On each wall of a pair, from which distances to the other one are taken."""


def gap(one, other, time=0.0, points=POINTS):
    """Smallest distance [length] between two bodies, negative where they overlap.

    Between smooth walls good to 1e-6 of their size with 1000 ``points`` on each; a sharp corner may be missed by half a
    thousandth of the wall.
    Copies in a periodic cell count. Either may be a straight wall, two of them are parallel or meet.
    """
    both = [(one, other), (other, one)]
    distances = [_least(a, b, time, points) for a, b in both if math.isfinite(a.shape.length)]
    if not distances:
        raise ValueError("the gap between two straight walls needs their period: give them a length")
    return min(distances)


def smallest_gap(bodies, time=0.0, points=POINTS):
    """Smallest gap among ``bodies``, and the indices (i, j) of the two; (infinity, None) for one alone.

    A body in a periodic cell also meets its own copies: then i = j.
    """
    pairs = itertools.combinations_with_replacement(range(len(bodies)), 2)
    gaps = ((_gap_of(bodies, pair, time, points), pair) for pair in pairs)
    least, pair = min(gaps, default=(math.inf, None))
    return least, pair if math.isfinite(least) else None


def _gap_of(bodies, pair, time, points):
    i, j = pair
    return _gap_to_copies(bodies[i], time, points) if i == j else gap(bodies[i], bodies[j], time, points)


def _gap_to_copies(body, time, points):
    if body.shape.fluid_side == "inside" or not body.shape.area:
        return math.inf
    copies = [
        replace(body, centre=tuple(body.centre + offset), periods=(math.inf, math.inf))
        for offset in body.periodic_offsets()
    ]
    alone = replace(body, periods=(math.inf, math.inf))
    return min((gap(alone, copy, time, points) for copy in copies), default=math.inf)


def _least(one, other, time, points):
    """Least distance of the points of ``one`` from ``other``: a parabola through the least and its neighbours."""
    distance = other.nearest(one.boundary_points(one.shape.length / points, time).point, time).distance
    k = int(np.argmin(distance))
    before, least, after = distance[k - 1], distance[k], distance[(k + 1) % len(distance)]
    bend = before - 2 * least + after
    return float(least - (after - before) ** 2 / (8 * bend)) if bend > 0 else float(least)
