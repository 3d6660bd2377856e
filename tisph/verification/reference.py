"""The exact solution at the particles of a snapshot, beside what they have."""

from dataclasses import replace

import numpy as np


def with_reference(channel, snapshot):
    """Return ``snapshot`` with its ``reference``: exact u, with polymer also the stresses, arrays (particles,)."""
    if snapshot.reference is not None:
        return snapshot
    reference = {"u": channel.exact_velocity(snapshot.y, snapshot.t)}
    if channel.polymer:
        xx, xy = channel.exact_polymer_stress(snapshot.y, snapshot.t)
        reference |= {"stress_xx": xx, "stress_xy": xy, "stress_yy": np.zeros_like(xy)}
    return replace(snapshot, reference=reference)
