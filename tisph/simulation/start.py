"""How a run starts: threads, first state, and the frame of the flow, whatever frame the config sees it from."""

import math
from dataclasses import replace

import numpy as np

from tisph import runtime
from tisph.snapshot import STRESSES, STRESSES_AROUND, Bodies, Snapshot

PARTICLES_PER_THREAD = 512
"""Taichi does not split a loop into shorter pieces than this."""

PARTICLES_PER_THREAD_WITH_PRESSURE = 2048
"""The same in two-dimensional flow with a pressure equation: loops of its linear solvers, most of all that there are,
run on one thread anyway."""


def useful_threads(config, scene):
    """Return the number of threads that ``runtime.threads`` means for this many particles."""
    if config.runtime.threads != "auto":
        return config.runtime.threads
    least = PARTICLES_PER_THREAD
    if config.scheme.type != "wcsph" and not config.parallel:
        least = PARTICLES_PER_THREAD_WITH_PRESSURE
    return min(runtime.available_threads(), math.ceil(scene.particles / least))


def start_values(scene, initial):
    """Return positions (particles, 2), velocities (particles, components) and polymer stresses or None at the start.

    Stresses have shape (particles, numbers), with those around the axis of axisymmetric flow after the three others.
    """
    x, y = scene.jittered(initial.seed, initial.jitter)
    fields = scene.initial(x, y)
    stresses = [fields[name] for name in (*STRESSES, *STRESSES_AROUND) if name in fields]
    stress = np.stack(stresses, 1) if scene.polymer else None
    return np.stack([x, y], 1), np.stack([fields[name] for name in ("u", "v", "w")[: scene.components]], 1), stress


def start_snapshot(scene, values, precision):
    """Return the ``start_values`` of ``scene.in_flow_frame()`` as a Snapshot in the frame of ``scene``.

    It is the start as the config says, before walls give their impulse. ``precision``: ``f64`` or ``f32``, in which a
    scheme holds positions and velocities.
    """
    position, velocity, stress = values
    kind = np.float32 if precision == "f32" else np.float64
    x, y, *velocities = (column.astype(kind) for column in (*position.T, *velocity.T))
    nothing = np.zeros(len(x))
    stresses = {} if stress is None else dict(zip((*STRESSES, *STRESSES_AROUND), stress.T, strict=False))
    x, y = (
        place % size if periodic else place
        for place, size, periodic in zip((x, y), scene.extent, scene.periodic, strict=True)
    )
    state = {
        "x": x,
        "y": y,
        **dict(zip(("u", "v", "w"), velocities, strict=False)),
        "density": nothing + scene.density,
        "pressure": nothing,
    }
    if "pressure" in scene.fields:
        state["pressure"] = scene.exact("pressure", x, y, scene.start_time)
    if scene.bodies:
        state["bodies"] = Bodies.at(scene.start_time, scene.in_flow_frame().bodies)
    return seen_from_config(Snapshot(t=scene.start_time, step=0, **state, **stresses), scene)


def seen_from_config(snapshot, scene):
    """Return ``snapshot`` of a run in the frame of ``scene.in_flow_frame()`` as the config's ``scene`` sees it."""
    velocity = scene.frame_velocity
    if velocity == 0.0:
        return snapshot
    travelled = velocity * (snapshot.t - scene.start_time)
    x = (snapshot.x.astype(float) + travelled) % scene.extent[0]
    bodies, along = snapshot.bodies, np.array([1.0, 0.0])
    if bodies is not None:
        bodies = replace(bodies, centre=bodies.centre + travelled * along, velocity=bodies.velocity + velocity * along)
    return replace(snapshot, x=x, u=snapshot.u.astype(float) + velocity, bodies=bodies)
