"""Snapshots as HDF5 groups: attributes ``t`` and ``step``, and a dataset for each field."""

import numpy as np

from tisph.snapshot import Snapshot

FIELDS = ("x", "y", "u", "v", "density", "pressure")
STRESSES = ("stress_xx", "stress_xy", "stress_yy")
"""Fields that only liquids with polymer have."""


def write_snapshot(group, snapshot, fields=FIELDS + STRESSES, dtype=None):
    """Write those of ``fields`` that ``snapshot`` has into ``group``, as ``dtype`` where one is given."""
    group.attrs["t"] = snapshot.t
    group.attrs["step"] = snapshot.step
    for name in fields:
        if getattr(snapshot, name) is not None:
            group.create_dataset(name, data=getattr(snapshot, name), dtype=dtype)


def read_snapshot(group, fields=FIELDS):
    """Return the snapshot in ``group``; fields other than ``fields`` are empty. KeyError where one is missing."""
    stored = {name: group[name][...] if name in fields else np.empty(0) for name in FIELDS}
    stored |= {name: group[name][...] for name in STRESSES if name in group}
    return Snapshot(t=float(group.attrs["t"]), step=int(group.attrs["step"]), **stored)
