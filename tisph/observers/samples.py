"""Whole states: samples at exact times in ``samples.h5``, frames of the movie and the movie itself in ``frames.h5``."""

import numpy as np

from tisph.measures.metrics import with_reference
from tisph.observers._storage import Storage, read_snapshots
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import Times

FRAME_FIELDS = ("x", "y", "u", "v", "w", "stress_xy")
"""What every movie may show: the stress is there only with polymer, w only in axisymmetric flow."""

FRAME_DELAY = 5.0
"""Seconds of the clock after which a frame is in its file at the latest, if the next one comes: writing one at a time
takes longer than many a simulation, and what is written before the end is written twice, once into each file."""


class Frames(StateObserver):
    """Draws a frame at evenly spaced times and stores its particles in single precision, and bodies as they are.

    The stored frames let ``tisph render`` draw the movie again and an interrupted run go on with it; those up
    to ``resumed_at``, as far as there are any, are drawn first. ``flush`` belongs before a checkpoint: a run that goes
    on from there has no other way to them. ``more`` are fields beside ``FRAME_FIELDS`` that this or another movie of
    the run may show.
    """

    def __init__(self, path, movie, times, resumed_at=None, more=()):
        self.path = path
        self.movie = movie
        self.schedule = Times(times)
        self.storage = Storage(path, "frame_{:05d}", (*FRAME_FIELDS, *more), np.float32, FRAME_DELAY)
        if resumed_at is not None:
            self.schedule.mark(resumed_at)
        self.storage.start(self._drawn_again(resumed_at))

    def observe(self, snapshot):
        """Store and draw one frame."""
        self.storage.add(snapshot)
        self.movie.add(snapshot)

    def flush(self):
        """Have all frames in the file."""
        self.storage.flush()

    def close(self):
        """Finish the movie: what was drawn by now can be played."""
        try:
            self.storage.close()
        finally:
            self.movie.close()

    def _drawn_again(self, resumed_at):
        """Yield the frames of an interrupted run that are kept, and draw each."""
        if resumed_at is None or not self.path.exists():
            return
        for snapshot in read_frames(self.path):
            if snapshot.t <= resumed_at:
                self.movie.add(snapshot)
                yield snapshot


def read_frames(path):
    """Yield the stored frames as snapshots; fields that they do not show are empty.

    ConfigError where the file is damaged.
    """
    return read_snapshots(path, FRAME_FIELDS)


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
