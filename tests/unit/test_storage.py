"""Snapshots in HDF5 files: what is written is read again, in the order of time."""

import h5py
import numpy as np

from tisph.observers._storage import write_snapshot
from tisph.observers.samples import read_samples
from tisph.snapshot import Snapshot


def test_samples_are_read_in_the_order_of_time(tmp_path):
    """By name the thousandth would come before the second: sample_1000 < sample_101."""
    times = (100, 101, 999, 1000, 1001)
    with h5py.File(tmp_path / "samples.h5", "w") as file:
        for t in times:
            write_snapshot(file.create_group(f"sample_{t:03d}"), Snapshot(float(t), t, *np.full((6, 3), t)))
    found = read_samples(tmp_path / "samples.h5")
    assert [snapshot.t for snapshot in found] == list(times)
    assert all(np.array_equal(snapshot.u, np.full(3, snapshot.t)) for snapshot in found)
