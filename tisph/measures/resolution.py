"""Whether the particles resolve the flow at a time: layers, radii and gaps against their spacing; the divergence."""

import math

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
