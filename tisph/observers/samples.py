"""Samples: the whole state at exact times, in ``samples.h5``."""

import h5py

from tisph.observers._schedule import Schedule
from tisph.observers._storage import read_snapshot, write_snapshot


class Samples:
    """Writes a group ``sample_000``, ... at each of ``times`` and keeps the snapshots in ``snapshots``.

    A group has the attributes ``t`` and ``step`` and the datasets x, y, u, v, density, pressure, with polymer also
    stress_xx, stress_xy, stress_yy, of shape (particles_fluid,), in the units of the config and the order of
    creation. ``resumed_at`` is the time up to which samples of an interrupted run are kept, None for a new file.
    """

    def __init__(self, path, times, resumed_at=None):
        self.path = path
        self.schedule = Schedule(times)
        self.snapshots = []
        if resumed_at is None:
            h5py.File(path, "w").close()
        else:
            self.snapshots = [snapshot for snapshot in read_samples(path) if snapshot.t <= resumed_at]
            self.schedule.mark(resumed_at)

    def observe(self, snapshot):
        """Write one sample; the file is closed again, so that an interrupt cannot spoil it."""
        self.schedule.mark(snapshot.t)
        name = f"sample_{len(self.snapshots):03d}"
        with h5py.File(self.path, "a") as file:
            if name in file:
                del file[name]
            write_snapshot(file.create_group(name), snapshot)
        self.snapshots.append(snapshot)

    def close(self):
        """Do nothing: the file is closed after each sample."""


def read_samples(path):
    """Return the snapshots of a ``samples.h5`` in the order of time."""
    with h5py.File(path, "r") as file:
        return [read_snapshot(group) for _, group in sorted(file.items())]
