"""A channel and snapshots for the tests of the pictures: exact velocities on a lattice, no simulation."""

from types import SimpleNamespace

import numpy as np

from tisph.scenes.channel import Channel
from tisph.snapshot import Snapshot

VIDEO = SimpleNamespace(fps=25, width=480, height=240)


def make_channel(rows=10, **changes) -> Channel:
    settings = {
        "gap": 0.01,
        "length": 0.02,
        "density": 1000.0,
        "kinematic_viscosity": 1e-6,
        "bottom_velocity": 0.0,
        "top_velocity": 0.005,
        "initial_state": "rest",
        "start_time": 0.0,
        "units": SimpleNamespace(length="m", mass="kg", time="s"),
        **changes,
    }
    spacing = settings["gap"] / rows
    return Channel(**settings, rows=rows, spacing=spacing, columns=round(settings["length"] / spacing))


def make_snapshot(channel, t, slip=0.0) -> Snapshot:
    """Particles on the lattice with the exact velocity, plus ``slip`` times the reference velocity."""
    x, y = channel.lattice()
    return particles(channel, t, x, y, channel.exact_velocity(y, t) + slip * channel.reference_velocity)


def particles(channel, t, x, y, u) -> Snapshot:
    x, y, u = (np.asarray(values, dtype=float) for values in (x, y, u))
    zero = np.zeros_like(x)
    return Snapshot(t=t, step=0, x=x, y=y, u=u, v=zero, density=zero + channel.density, pressure=zero)
