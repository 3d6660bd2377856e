"""How close bodies and walls come to each other."""

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
    least = math.inf, ()
    for bound, pair in _bounds(bodies, time, points):
        if bound > least[0]:
            break
        least = min(least, (_gap_of(bodies, pair, time, points), pair))
    return least if math.isfinite(least[0]) else (least[0], None)


def _bounds(bodies, time, points):
    """Pairs (bound, (i, j)) of all bodies i <= j, the lowest bound first: no gap of two is below their bound."""
    count, in_fluid = len(bodies), np.array([_is_in_fluid(body) for body in bodies], dtype=bool)
    centres = np.array([body.at(time).centre for body in bodies]).reshape(count, 2)
    lengths = np.array([body.shape.length for body in bodies])
    spacings = np.where(np.isfinite(lengths), lengths, 0.0) / points
    radii, apart = np.zeros(count), np.full((count, count), -math.inf)
    for i, body in enumerate(bodies):
        if in_fluid[i]:
            outline = body.shape.boundary_points(spacings[i]).point
            radii[i] = np.linalg.norm(outline, axis=1).max() + spacings[i]
            away = centres[in_fluid] - centres[i]
            apart[i, in_fluid] = np.linalg.norm(away - body.nearest_copy(away), axis=1)
            apart[i, i] = min(body.periods)
        else:  # two walls have no bound
            apart[i, in_fluid] = apart[in_fluid, i] = body.nearest(centres[in_fluid], time).distance
    # half the distance of two points is more than what the parabola of ``_least`` takes off, an eighth at most
    slack = 0.5 * np.maximum(spacings, spacings[:, None])
    bounds = np.minimum(apart, apart.T) - radii - radii[:, None] - slack
    rows, columns = np.triu_indices(count)
    return sorted(zip(bounds[rows, columns].tolist(), zip(rows.tolist(), columns.tolist(), strict=True), strict=True))


def _is_in_fluid(body):
    return body.shape.area > 0 and body.shape.fluid_side == "outside"


def _gap_of(bodies, pair, time, points):
    i, j = pair
    return _gap_to_copies(bodies[i], time, points) if i == j else gap(bodies[i], bodies[j], time, points)


def _gap_to_copies(body, time, points):
    if not _is_in_fluid(body):
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
