"""Snapshots as HDF5 groups: attributes ``t`` and ``step``, and a dataset for each field."""

import numpy as np

from tisph.snapshot import Snapshot

FIELDS = ("x", "y", "u", "v", "density", "pressure")


def write_snapshot(group, snapshot, fields=FIELDS, dtype=None):
    """Write ``fields`` of ``snapshot`` into ``group``, as ``dtype`` where one is given."""
    group.attrs["t"] = snapshot.t
    group.attrs["step"] = snapshot.step
    for name in fields:
        group.create_dataset(name, data=getattr(snapshot, name), dtype=dtype)


def read_snapshot(group, fields=FIELDS):
    """Return the snapshot in ``group``; fields other than ``fields`` are empty. KeyError where one is missing."""
    stored = {name: group[name][...] if name in fields else np.empty(0) for name in FIELDS}
    return Snapshot(t=float(group.attrs["t"]), step=int(group.attrs["step"]), **stored)
