"""Whether a closed polyline meets itself."""

import numpy as np


def crossing(points):
    """Place (2,) where the closed polyline through ``points`` (m, 2) crosses or touches itself, None where nowhere."""
    start, end = points, np.roll(points, -1, axis=0)
    count = len(points)
    for i in range(count - 2):
        # the next piece, and for the first piece the last, share an end with this one
        others = slice(i + 2, count - 1 if i == 0 else count)
        met = _meet(start[i], end[i], start[others], end[others])
        if met.any():
            return start[others][np.argmax(met)]
    return None


def _meet(a, b, c, d):
    """Whether the piece from ``a`` to ``b`` (2,) meets each of those from ``c`` to ``d`` (k, 2)."""
    apart = (_side(a, b, c) * _side(a, b, d) > 0) | (_side(c, d, a) * _side(c, d, b) > 0)
    # pieces of one line are on no side of each other: then their boxes tell
    over = (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b))
    return ~apart & over.all(axis=1)


def _side(a, b, c):
    """Twice the area of the triangles a, b, c: positive where c is on the left of the line from a to b."""
    (ax, ay), (bx, by), (cx, cy) = a.T, b.T, c.T
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
