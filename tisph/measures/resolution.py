"""Criteria of resolved flow: layers, radii and gaps in particle spacings; the divergence; scatter."""

import math

import numpy as np

from tisph.measures import heat
from tisph.measures.flow import FlowInBox
from tisph.snapshot import Snapshot

CUBIC_NEIGHBOURS = -2, -1, 1, 2
"""Times, from one of them, through whose values a cubic goes."""


def scatter_in_time(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the scatter (...) of ``values`` (n, ...) that vary smoothly otherwise, at n >= 5 ``times`` (n,).

    It is the root mean square of the differences of the values from the cubics through the two before and the two after
    each, without the scatter of the values on the cubic.
    """
    middles = np.arange(2, len(times) - 2)
    around = middles[:, None] + CUBIC_NEIGHBOURS
    others = times[around] - times[middles, None]
    apart = others[:, None] - others[:, :, None]
    np.einsum("maa->ma", apart)[...] = others  # a factor b / (b - a) of 1 for b = a
    weights = np.prod(others[:, None] / apart, axis=2)
    beside = values[middles] - np.einsum("ms,ms...->m...", weights, values[around])
    variance = 1.0 + np.square(weights).sum(axis=1)
    return np.sqrt(np.tensordot(1.0 / variance, beside**2, 1) / len(middles))


LEAST_DEPTH = 2.0
"""Least depth of a resolved layer, in particle spacings at its wall.

The L2 error of the velocities of the layer is then at most 1.5 % and the error of the wall shear 1 %, with both schemes
and every order; with polymer the error of the wall shear is 5 %. ``benchmarks/resolution.py`` measures them; a part of
its table is in docs/reference/files.md.
"""

LEAST_RADIUS, LEAST_GAP = 3.0, 3.0
"""Least radius of curvature of a convex wall, and least gap between two walls, in particle spacings.

Errors of drag and flow rate are then at most 1.5 %; with 2 to 2.5 spacings 0.1 to 7 % (docs/evidence/verification.md).
"""

LARGEST_DIVERGENCE = 0.01
"""Largest divergence of the velocities in a resolved sample, over their gradient, both as root mean squares.

The error of drag and flow rate around bodies is up to 2.6 times that.
"""

LARGEST_DRIFT = 0.01
"""Largest error of the common velocity of fluid and bodies in a resolved sample in a box without walls, over the
velocity of bodies relative to the fluid: the tolerance of forces and velocities around bodies elsewhere."""

STEEPEST = 2.0
"""Largest change of the logarithm of a conformation tensor within a spacing in a resolved sample.

The error of the drag of a confined cylinder is 0.4 % with 1.5 and 1 % with 2.6, the error of flow between cylinders
1e-3 with 0.5.
"""

LARGEST_ADDED_POWER = 0.01
"""Largest power that errors of the viscous operators add to a fluid of varying viscosity in a resolved sample, over the
dissipation. The error of the velocity in pipes is one to two times this ratio (docs/evidence/stability.md).
"""

LARGEST_SCATTER = 0.01
"""Largest scatter of the force on a body, or of the pressure at an inlet, from step to step in a resolved sample, over
that force or pressure.

The error of single steps is three times the scatter (docs/how-to/accuracy.md).
"""

ERROR_OF_LOADS = 1e-3
"""Error of drag, lift and torque over the largest load on a body: by so much the drag changes with the arrangement of
the particles (docs/how-to/accuracy.md). Forces that are 0 by symmetry had up to 9e-4 of the whole: the lift of a
cylinder in the middle of a channel, with a polymer, 24 across."""


def load_scatters(scene: FlowInBox, snapshot: Snapshot) -> dict[str, float | str | None]:
    """Return the scatter of each of ``scene.named_loads``, such as ``lift_scatter_0``, and ``zero_within_error``.

    That is the names of the loads that are zero within their error, None without any.
    """
    named, bodies = scene.named_loads, snapshot.bodies
    if not named:
        return {}
    known = None if bodies is None else bodies.load_scatter
    found: dict[str, float | str | None] = {}
    for name, place in named.items():
        kind, *rest = name.split("_", 1)
        found["_".join([kind, "scatter", *rest])] = None if known is None else float(known[place])
    return {**found, "zero_within_error": ", ".join(_loads_that_scatter(scene, snapshot)[1]) or None}


def _loads_that_scatter(scene: FlowInBox, snapshot: Snapshot) -> tuple[dict[str, float], list[str]]:
    """Return the loads that scatter by more than ``LARGEST_SCATTER`` of themselves, and others that are zero.

    The first are names and scatter over the larger of value and size, the root mean square over the last steps. A load
    is zero within its error if its mean square is at most twice the square of its scatter, so that its mean is below
    the scatter, or if its size is at most ``ERROR_OF_LOADS`` times the largest load on a body.
    """
    named, bodies = scene.named_loads, snapshot.bodies
    if not named or bodies is None or bodies.load_scatter is None or bodies.load_size is None:
        return {}, []
    sizes = {number: bodies.load_size[number] for number, _ in named.values()}
    arms = {number: math.sqrt(scene.bodies[number].shape.area / math.pi) for number in sizes}
    whole = max(max(math.hypot(*size[:2]), size[2] / arms[number]) for number, size in sizes.items())
    scattering, zero = {}, []
    for name, (number, part) in named.items():
        value = abs((*bodies.force[number], bodies.torque[number])[part])
        scatter, size = bodies.load_scatter[number, part], sizes[number][part]
        if scatter > LARGEST_SCATTER * max(size, value):
            error = ERROR_OF_LOADS * whole * (arms[number] if part == 2 else 1.0)
            if size <= max(math.sqrt(2.0) * scatter, error):
                zero.append(name)
            else:
                scattering[name] = float(scatter / max(size, value))
    return scattering, zero


def resolution(scene: FlowInBox, t: float, snapshot: Snapshot | None = None) -> tuple[bool, str | None]:
    """Return whether the flow of a scene is resolved at time ``t``, and the reason: (True, None) or (False, reason)."""
    found = unresolved(scene, t, snapshot)
    return (True, None) if found is None else (False, found[1])


def unresolved(scene: FlowInBox, t: float, snapshot: Snapshot | None = None) -> tuple[str, str] | None:
    """Return a short text for frames and a full reason if the flow is not resolved at time ``t``; None if it is.

    Before the run, without a ``snapshot``, only layers, radii and gaps are checked. Without inertia there is no layer.
    """
    given, scene = scene, scene if snapshot is None else scene.seen(snapshot)
    for depth, layer, *there in (*([scene.thinnest_layer(t)] if scene.inertia else []), heat.thinnest_layer(scene, t)):
        spacings = depth / (there[0] if there else scene.wall_spacing)
        if spacings < LEAST_DEPTH:
            text = f"{layer} is {spacings:.2g} spacings thin; resolved from {LEAST_DEPTH:g} spacings on"
            return f"layer of {spacings:.1f} spacings" if spacings else "layer that starts", text
    radius, gap = scene.narrowest(t)
    for name, (size, what, *there), least in (("radius", radius, LEAST_RADIUS), ("gap", gap, LEAST_GAP)):
        spacings = size / (there[0] if there else scene.wall_spacing)
        if spacings < least * (1 - 1e-4):  # the error of gaps of moving bodies
            text = f"{what} is {spacings:.2g} spacings; resolved from {least:g} on"
            return f"{name} of {spacings:.2g} spacings", text
    return None if snapshot is None else _unresolved_state(given, snapshot)


def _unresolved_state(scene: FlowInBox, snapshot: Snapshot) -> tuple[str, str] | None:
    """Return a short text and the reason for the first criterion that a state fails (drift, ...), or None."""
    drift = scene.drift(snapshot)
    if drift > LARGEST_DRIFT:
        text = f"without walls, fluid and bodies drift together by {drift:.2g} of their velocity against each other"
        return f"bodies drift by {drift:.2g}", f"{text}; resolved up to {LARGEST_DRIFT:g}"
    if at_ends := scene.unresolved_ends(snapshot):
        return at_ends
    if snapshot.divergence is not None and snapshot.divergence > LARGEST_DIVERGENCE:
        text = f"the divergence is {snapshot.divergence:.2g} of the velocity gradient"
        return f"divergence {snapshot.divergence:.2g}", f"{text}; resolved up to {LARGEST_DIVERGENCE:g}"
    if snapshot.added_power is not None and snapshot.added_power > LARGEST_ADDED_POWER:
        found = snapshot.added_power
        text = f"where the viscosity jumps, errors of the viscous force have a power of {found:.2g} of the dissipation"
        return f"viscous force off by {found:.2g}", f"{text}; resolved up to {LARGEST_ADDED_POWER:g}"
    if snapshot.load_scatter is not None and snapshot.bodies is not None and snapshot.load_scatter[0] > LARGEST_SCATTER:
        found, number = snapshot.load_scatter[0], int(snapshot.load_scatter[1])
        name, place = scene.bodies[number].load_name(snapshot.bodies.centre[number])
        text = f"the {name} {place} scatters from step to step by {found:.2g} of its size"
        return f"{name} scatters by {found:.2g}", f"{text}; resolved up to {LARGEST_SCATTER:g}"
    if scattering := _loads_that_scatter(scene, snapshot)[0]:
        (name, found), *others = sorted(scattering.items(), key=lambda pair: -pair[1])
        text = f"{name} scatters from step to step by {found:.2g} of itself"
        text = ", ".join([text, *(f"{other} by {value:.2g}" for other, value in others)])
        return f"{name} scatters by {found:.2g}", f"{text}; resolved up to {LARGEST_SCATTER:g}"
    if snapshot.velocity_scatter is not None and snapshot.velocity_scatter > LARGEST_SCATTER:
        text = f"velocities scatter from step to step by {snapshot.velocity_scatter:.2g} of the largest one"
        return f"velocities scatter by {snapshot.velocity_scatter:.2g}", f"{text}; resolved up to {LARGEST_SCATTER:g}"
    if snapshot.steepest is not None and snapshot.steepest[0] > STEEPEST:
        change, x, y = snapshot.steepest
        text = f"the polymer's stretch changes {math.exp(change):.2g}-fold within a spacing at ({x:.4g}, {y:.4g})"
        return "polymer stress too steep", f"{text}; resolved up to {math.exp(STEEPEST):.2g}-fold"
    spacings, name = heat.steepest(scene, snapshot)
    if spacings < LEAST_DEPTH:
        text = f"{name} changes by its whole range within {spacings:.2g} spacings"
        return f"{name} too steep", f"{text}; resolved from {LEAST_DEPTH:g} spacings on"
    return None
