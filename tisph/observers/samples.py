"""Samples: the whole state at exact times, in ``samples.h5``."""

from tisph.measures.metrics import with_reference
from tisph.observers._storage import Storage, read_snapshots
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import Times

CONTENT = "particles at the times of the samples"


class Samples(StateObserver):
    """Writes a group ``sample_000``, ... at each of ``times``; ``snapshots`` keeps them, with their reference.

    A group has the attributes ``t`` and ``step`` and the datasets x, y, u, v, density, pressure, with polymer also
    stress_xx, stress_xy, stress_yy, of shape (particles_fluid,), in the units of the config and the order of
    creation; beside u and the stresses those of the exact solution, ``u_exact`` and so on. Where there are bodies, the
    group ``bodies`` has a dataset for each field of ``tisph.snapshot.Bodies``. ``about`` is the ``Description`` of
    the run, if the file is to say what it is. ``resumed_at`` is the time up to which samples of an interrupted run are
    kept, None for a new file.
    """

    def __init__(self, path, scene, times, resumed_at=None, about=None):
        self.scene = scene
        self.schedule = Times(times)
        self.snapshots = []
        if resumed_at is not None:
            self.snapshots = [with_reference(scene, kept) for kept in read_samples(path) if kept.t <= resumed_at]
            self.schedule.mark(resumed_at)
        said = {} if about is None else {"about": (about.attributes(CONTENT), about.units)}
        self.storage = Storage(path, "sample_{:03d}", **said)
        self.storage.start(self.snapshots)

    def observe(self, snapshot):
        """Write one sample."""
        snapshot = with_reference(self.scene, snapshot)
        self.storage.add(snapshot)
        self.snapshots.append(snapshot)

    def close(self):
        """Leave nothing but the samples."""
        self.storage.close()


def read_samples(path):
    """Return the snapshots of a ``samples.h5`` in the order of time; ConfigError where it is damaged."""
    return list(read_snapshots(path))
