"""Where an error is: near which wall or in the middle, where it is largest, and whether it grows or falls."""

import numpy as np

from tisph.measures.metrics import root_mean_square, velocities

STANDS_OUT = 2.0
"""A third of the channel has the error where its root mean square is that many times those of the others."""

TOO_SMALL = 1e-8
"""Root mean square error over U below which there is nothing to explain: numerical references are exact to that."""

CHANGES = 1.1
"""An error grows or falls where it changes by that factor from the first time to the last."""


def error_location(scene, snapshot):
    """Words and numbers of the place of the error of one sample.

    Between plane walls ``thirds``: root mean square errors over U near the bottom wall, in the middle, near the top
    wall; everywhere ``largest``: the place (x, y) of the largest one.
    """
    values, exact = velocities(scene, snapshot)
    size = np.sqrt(np.square(values - exact).sum(axis=0)) / scene.reference_velocity
    index = int(np.argmax(size))
    found = {"largest": [float(snapshot.x[index]), float(snapshot.y[index])], "largest_error": float(size[index])}
    if root_mean_square(size) < TOO_SMALL:
        return {**found, "words": "as small as that of the reference, or round-off"}
    if not scene.parallel:
        return {**found, "words": f"largest at ({snapshot.x[index]:.4g}, {snapshot.y[index]:.4g})"}
    thirds = _thirds(snapshot.y / scene.gap, size)
    excess = float((values - exact)[0, index])
    found |= {"thirds": thirds, "words": f"{_side(thirds)}; {_largest(scene, snapshot.y[index], excess)}"}
    return found


def _thirds(height, size):
    part = np.clip((3 * height).astype(int), 0, 2)
    return {
        name: root_mean_square(size[part == index]) if (part == index).any() else 0.0
        for index, name in enumerate(("bottom", "middle", "top"))
    }


def _side(thirds):
    ranked = sorted(thirds, key=thirds.get, reverse=True)
    places = {"bottom": "near the bottom wall", "middle": "in the middle", "top": "near the top wall"}
    if thirds[ranked[0]] >= STANDS_OUT * thirds[ranked[1]]:
        return places[ranked[0]]
    if thirds[ranked[1]] >= STANDS_OUT * thirds[ranked[2]]:
        return f"{places[ranked[0]]} and {places[ranked[1]]}"
    return "all across the channel"


def _largest(scene, y, excess):
    below = y < 0.5 * scene.gap
    distance = abs(y if below else scene.gap - y) / scene.spacing
    name = "bottom" if below else "top"
    way = "above" if excess > 0 else "below"
    return f"largest {distance:.3g} spacings from the {name} wall (y = {y:.4g}), where u is {way} the exact one"


def trend(samples):
    """Words on how the root mean square error changes in time; empty with one time only.

    ``samples`` are pairs (t, rms) in the order of time.
    """
    if len(samples) < 2 or min(rms or 0.0 for _, rms in samples) < TOO_SMALL:
        return ""
    (first, before), (last, after) = samples[0], samples[-1]
    change = after / before
    span = f"from t = {first:g} to {last:g}"
    if change > CHANGES:
        return f"the error grows {span}, by a factor of {change:.3g}"
    if change < 1 / CHANGES:
        return f"the error falls {span}, by a factor of {1 / change:.3g}"
    return f"the error stays as it is {span}"
