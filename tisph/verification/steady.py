"""Since when a flow has been steady, by the numbers that its scene follows in time."""

import numpy as np

CHANGE = 1e-3
"""Change, over the size of a number, up to which it is the same."""

LAST = 0.1
"""Part of the run over which nothing may have changed."""


def steady_since(times, values, sizes):
    """First of the ``times`` (n,) from which on ``values`` (n, numbers) are the last ones; None where that is too late.

    ``sizes`` (numbers,): what changes are taken over.
    """
    if not len(times):
        return None
    off = ~(np.abs(values - values[-1]) <= CHANGE * np.asarray(sizes)).all(axis=1)
    first = np.flatnonzero(off)[-1] + 1 if off.any() else 0
    quiet = first < len(times) and times[first] <= times[-1] - LAST * (times[-1] - times[0])
    return float(times[first]) if quiet else None
