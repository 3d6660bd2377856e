"""Whether the particles resolve the flow, and whether it has become steady.

Resolved: layers, radii and gaps against the spacing of the particles; the divergence. Steady: by the kinetic energy
over the last times, at any time of a run (the errors of a cavity's samples wait for it), or at the end of a run by the
numbers that its scene follows, which do not scatter as means over particles do.
"""

import math

import numpy as np

CHANGE = 1e-3
"""Change, over the size of a number, up to which it is the same."""

LAST = 0.1
"""Part of the run over which nothing may have changed."""

SPAN = 5.0
"""Times ``_moment`` that are looked back."""

STEADY = 3e-4
"""Relative change of the kinetic energy in such a time, below which a flow is called steady."""

SCATTER = 6.0
"""Standard errors of the slope, were its values independent, up to which it may be scatter: three, since those that
follow one another are not. Means over particles scatter by 2e-3 in a cavity of 25 x 25, slopes over ``SPAN`` by 2.5e-4,
and every fourth time was called unsteady."""


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


def steadiness(scene, t, series, column=0, words="kinetic energy"):
    """Return ``energy_change``, ``steady`` and ``steady_reason`` (None where it is) at time ``t``, by name.

    The first is the relative change of the kinetic energy in a ``_moment``: the slope of a straight line through what
    was followed in the last ``SPAN`` of them. ``series`` is that of ``Scene.diagnostics``; another ``column`` of it
    than the first, the last of the ``words``, has its own name, such as ``torque_change``.
    """
    key = f"{words.split()[-1]}_change"
    step = _moment(scene)
    times, series_values = series[2] if len(series) > 2 else (np.empty(0), np.empty((0, 1)))
    if t < scene.start_time + SPAN * step:
        return _unsteady(key, f"the flow has run for less than {SPAN * step:.3g}")
    recent = (times >= t - SPAN * step) & (times <= t)
    if np.count_nonzero(recent) < 3:
        return _unsteady(key, "the history has too few times")
    when, values = times[recent] / step, series_values[recent, column]
    mean = np.mean(values)
    change = float(abs(np.polyfit(when, values, 1)[0] / mean))
    scatter = np.std(values - np.polyval(np.polyfit(when, values, 2), when)) / abs(mean)
    if not change <= max(STEADY, SCATTER * scatter / (np.std(when) * np.sqrt(len(when)))):
        return _unsteady(key, f"the {words} changes by {change:.1e} in a time of {step:.3g}", change)
    return {key: change, "steady": True, "steady_reason": None}


def _moment(scene):
    """The shorter of the times in which the flow goes the reference length, and a fifth of that of its viscosity."""
    return min(scene.reference_length / scene.reference_velocity, 0.2 * scene.viscous_time)


def _unsteady(key, reason, change=None):
    return {key: change, "steady": False, "steady_reason": reason}


LEAST_DEPTH = 2.0
"""Depth of a layer, in particle spacings, from which on a sample counts as resolved.

The error of the velocities of the layer is then at most 1.5 % (L2) and that of the wall shear 1 %, with both schemes
and every order; with polymer that of the wall shear is 5 %. ``benchmarks/resolution.py`` measures it, and prints
the table of which docs/reference/files.md has a part.
"""

LEAST_RADIUS, LEAST_GAP = 3.0, 3.0
"""The same of the radius of curvature of a wall that bulges into the fluid, and of the gap between two walls.

Errors of drag and flow rate are then at most 1.5 %; with 2 to 2.5 spacings 0.1 to 7 % (docs/evidence/verification.md).
"""

LARGEST_DIVERGENCE = 0.01
"""Divergence of the velocities over their gradient, both as root mean squares, up to which a sample counts as resolved.

The error of drag and flow rate around bodies is up to 2.6 times that (docs/evidence/verification.md).
"""

LARGEST_DRIFT = 0.01
"""Velocity by which all together moves too fast in a box without walls, over that of bodies against the fluid, up to
which a sample counts as resolved: what one asks for of forces and velocities around bodies elsewhere."""

STEEPEST = 2.0
"""Change of the logarithm of a conformation tensor within a spacing up to which a sample counts as resolved.

The error of the drag of a confined cylinder is 0.4 % with 1.5 and 1 % with 2.6, that of flow between cylinders 1e-3
with 0.5 (docs/evidence/verification.md).
"""

LARGEST_ADDED_POWER = 0.01
"""Power of the viscous force that only errors of the operators add, over the dissipation, up to which a sample of a
fluid of varying viscosity counts as resolved. The error of the velocity is one to two times that in pipes
(docs/evidence/stability.md).
"""

LARGEST_SCATTER = 0.01
"""Scatter of the force on a body from step to step, over that force, up to which a sample counts as resolved.

Single steps are off by three times that (docs/evidence/stability.md).
"""


def resolution(scene, t, snapshot=None):
    """Tell whether the flow of a scene is resolved at time ``t``, and why not: (True, None) or (False, reason)."""
    found = unresolved(scene, t, snapshot)
    return (True, None) if found is None else (False, found[1])


def unresolved(scene, t, snapshot=None):
    """What is not resolved of the flow of a scene at time ``t``, briefly, as in frames, and in full; None where all is.

    ``snapshot``: the state then, once there is one; some of it is known before the run.
    """
    given, scene = scene, scene if snapshot is None else scene.seen(snapshot)
    depth, layer = scene.thinnest_layer(t)
    spacings = depth / scene.spacing
    if spacings < LEAST_DEPTH:
        text = f"{layer} is {spacings:.2g} spacings thin; resolved from {LEAST_DEPTH:g} spacings on"
        return f"{spacings:.1f} spacings", text
    radius, gap = scene.narrowest(t)
    for name, (size, what), least in (("radius", radius, LEAST_RADIUS), ("gap", gap, LEAST_GAP)):
        spacings = size / scene.spacing
        if spacings < least * (1 - 1e-4):  # what gaps of bodies that move are good to
            text = f"{what} is {spacings:.2g} spacings; resolved from {least:g} on"
            return f"{name} {spacings:.2g} dx", text
    return None if snapshot is None else _of_state(given, snapshot)


def _of_state(scene, snapshot):
    drift = scene.drift(snapshot)
    if drift > LARGEST_DRIFT:
        text = f"without walls, fluid and bodies drift together by {drift:.2g} of their velocity against each other"
        return f"drift {drift:.2g}", f"{text}; resolved up to {LARGEST_DRIFT:g}"
    if snapshot.divergence is not None and snapshot.divergence > LARGEST_DIVERGENCE:
        text = f"the divergence is {snapshot.divergence:.2g} of the velocity gradient"
        return f"div u {snapshot.divergence:.2g}", f"{text}; resolved up to {LARGEST_DIVERGENCE:g}"
    if snapshot.added_power is not None and snapshot.added_power > LARGEST_ADDED_POWER:
        found = snapshot.added_power
        text = f"errors of the viscous force, where the viscosity jumps, do {found:.2g} of the dissipation"
        return f"viscosity {found:.2g}", f"{text}; resolved up to {LARGEST_ADDED_POWER:g}"
    if snapshot.load_scatter is not None and snapshot.load_scatter[0] > LARGEST_SCATTER:
        found, (x, y) = snapshot.load_scatter[0], snapshot.bodies.centre[int(snapshot.load_scatter[1])]
        text = f"the force on the body at ({x:.4g}, {y:.4g}) scatters by {found:.2g} of it from step to step"
        return f"force {found:.2g}", f"{text}; resolved up to {LARGEST_SCATTER:g}"
    if snapshot.steepest is not None and snapshot.steepest[0] > STEEPEST:
        change, x, y = snapshot.steepest
        text = f"the polymer's stretch changes {math.exp(change):.2g}-fold within a spacing at ({x:.4g}, {y:.4g})"
        return "polymer", f"{text}; resolved up to {math.exp(STEEPEST):.2g}-fold"
    return None
