"""Snapshots as HDF5 groups: attributes ``t`` and ``step``, and a dataset for each field."""

import contextlib
import os
import shutil

import h5py
import numpy as np

from tisph.folder import partial, spare
from tisph.observers._files import hdf5_file, readable, replaced
from tisph.snapshot import Snapshot

FIELDS = ("x", "y", "u", "v", "density", "pressure")
STRESSES = ("stress_xx", "stress_xy", "stress_yy")
"""Fields that only liquids with polymer have."""


class Storage:
    """A file of snapshots in groups, which can be read at any time: whatever ends the process spoils nothing in it.

    ``name`` makes the name of a group from its number; those of ``fields`` that a snapshot has are stored, as ``dtype``
    where one is given. HDF5 cannot add to a file without a moment in which it cannot be read. So there are two: the one
    that nobody reads is brought up to date, then they change places. TisphError where the system lets none be written.
    """

    def __init__(self, path, name, fields=FIELDS + STRESSES, dtype=None):
        self.path = path
        self.name = name
        self.options = (fields, dtype)
        self.count = 0
        self.missing = []
        """Names and snapshots of the groups that the other file lacks."""

    def start(self, snapshots):
        """Make a file of ``snapshots``, in place of one that there may be."""
        self.close()  # what a killed run was writing may be anything
        with replaced(self.path) as new, hdf5_file(new) as file:
            for snapshot in snapshots:
                write_snapshot(file.create_group(self.name.format(self.count)), snapshot, *self.options)
                self.count += 1

    def add(self, snapshot):
        """Add a group."""
        group = (self.name.format(self.count), snapshot)
        with replaced(self.path) as new:
            if not new.exists():
                self.close()
                shutil.copyfile(self.path, new)
                self.missing = []
            with hdf5_file(new, "r+") as file:
                for name, values in (*self.missing, group):
                    write_snapshot(file.create_group(name), values, *self.options)
            with contextlib.suppress(OSError):  # a system without links: next time the file is copied
                os.link(self.path, spare(self.path))
        with contextlib.suppress(OSError):
            os.replace(spare(self.path), new)
        self.missing = [group]
        self.count += 1

    def close(self):
        """Remove the other file."""
        for path in (partial(self.path), spare(self.path)):
            path.unlink(missing_ok=True)


def write_snapshot(group, snapshot, fields=FIELDS + STRESSES, dtype=None):
    """Write those of ``fields`` that ``snapshot`` has into ``group``, as ``dtype`` where one is given."""
    group.attrs["t"] = snapshot.t
    group.attrs["step"] = snapshot.step
    for name in fields:
        if getattr(snapshot, name) is not None:
            group.create_dataset(name, data=getattr(snapshot, name), dtype=dtype)


def read_snapshots(path, fields=FIELDS):
    """Yield the snapshots in a file, in the order of time; fields other than ``fields`` are empty.

    ConfigError where the file is damaged.
    """
    with readable(path), h5py.File(path, "r") as file:
        for group in sorted(file.values(), key=lambda group: group.attrs["t"]):
            stored = {name: group[name][...] if name in fields else np.empty(0) for name in FIELDS}
            stored |= {name: group[name][...] for name in STRESSES if name in group}
            yield Snapshot(t=float(group.attrs["t"]), step=int(group.attrs["step"]), **stored)
