"""How a run starts, and the frame it is computed in: the flow's own, whatever frame the config sees it from."""

from dataclasses import replace

import numpy as np

from tisph.snapshot import Snapshot


def start_values(channel, initial):
    """Return positions and velocities (particles, 2) and polymer stresses (particles, 3) or None at the start."""
    x, y = channel.jittered(initial.seed, initial.jitter)
    u = channel.initial_velocity(y)
    stress = None
    if channel.polymer:
        xx, xy = channel.initial_polymer_stress(y)
        stress = np.stack([xx, xy, np.zeros_like(xx)], 1)
    return np.stack([x, y], 1), np.stack([u, np.zeros_like(u)], 1), stress


def start_snapshot(channel, values, precision):
    """Return the ``start_values`` of ``channel.in_own_frame()`` as a Snapshot in the frame of ``channel``.

    It is the start as the config says, before walls give their impulse. ``precision``: ``f64`` or ``f32``, in which a
    scheme holds positions and velocities.
    """
    position, velocity, stress = values
    kind = np.float32 if precision == "f32" else np.float64
    x, y, u, v = (column.astype(kind) for column in (*position.T, *velocity.T))
    nothing = np.zeros(len(x))
    stresses = {} if stress is None else dict(zip(("stress_xx", "stress_xy", "stress_yy"), stress.T, strict=True))
    state = {"x": x % channel.length, "y": y, "u": u, "v": v, "density": nothing + channel.density}
    snapshot = Snapshot(t=channel.start_time, step=0, pressure=nothing, **state, **stresses)
    return seen_from_config(snapshot, channel)


def seen_from_config(snapshot, channel):
    """Return ``snapshot`` of a run in the frame of ``channel.in_own_frame()`` as the config's ``channel`` sees it."""
    velocity = channel.frame_velocity
    if velocity == 0.0:
        return snapshot
    travelled = velocity * (snapshot.t - channel.start_time)
    x = (snapshot.x.astype(float) + travelled) % channel.length
    return replace(snapshot, x=x, u=snapshot.u.astype(float) + velocity)
