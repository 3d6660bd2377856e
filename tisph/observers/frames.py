"""Frames: what the movie shows, in ``frames.h5``, and the movie itself."""

import numpy as np

from tisph.observers._storage import Storage, read_snapshots
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import Times

FIELDS = ("x", "y", "u", "v", "w", "stress_xy")
"""What every movie may show: the stress is there only with polymer, w only in axisymmetric flow."""

DELAY = 5.0
"""Seconds of the clock after which a frame is in its file at the latest, if the next one comes: writing one at a time
takes longer than many a simulation, and what is written before the end is written twice, once into each file."""


class Frames(StateObserver):
    """Draws a frame at evenly spaced times and stores its particles in single precision, and bodies as they are.

    The stored frames let ``tisph render`` draw the movie again and an interrupted run go on with it; those up
    to ``resumed_at``, as far as there are any, are drawn first. ``flush`` belongs before a checkpoint: a run that goes
    on from there has no other way to them. ``more`` are fields beside ``FIELDS`` that this or another movie of the
    run may show.
    """

    def __init__(self, path, movie, times, resumed_at=None, more=()):
        self.path = path
        self.movie = movie
        self.schedule = Times(times)
        self.storage = Storage(path, "frame_{:05d}", (*FIELDS, *more), np.float32, DELAY)
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
    return read_snapshots(path, FIELDS)
