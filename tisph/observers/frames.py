"""Frames: what the movie shows, in ``frames.h5``, and the movie itself."""

import h5py
import numpy as np

from tisph.observers._schedule import Schedule, even_times
from tisph.observers._storage import read_snapshot, write_snapshot

FIELDS = ("x", "y", "u", "v", "stress_xy")
"""What a movie may show; the stress is there only with polymer."""


class Frames:
    """Draws a frame at evenly spaced times and stores its particles in single precision.

    The stored frames let ``tisph render`` draw the movie again and an interrupted run go on with it; those up
    to ``resumed_at`` are drawn first.
    """

    def __init__(self, path, movie, times, resumed_at=None):
        self.movie = movie
        self.schedule = Schedule(times)
        self.file = h5py.File(path, "w" if resumed_at is None else "r+")
        self.count = 0
        if resumed_at is not None:
            self.schedule.mark(resumed_at)
            self._take_up(resumed_at)

    def observe(self, snapshot):
        """Store and draw one frame."""
        self.schedule.mark(snapshot.t)
        write_snapshot(self.file.create_group(f"frame_{self.count:05d}"), snapshot, FIELDS, np.float32)
        self.file.flush()
        self.count += 1
        self.movie.add(snapshot)

    def close(self):
        """Finish the movie: what was drawn by now can be played."""
        self.file.close()
        self.movie.close()

    def _take_up(self, resumed_at):
        for name in sorted(self.file):
            if self.file[name].attrs["t"] > resumed_at:
                del self.file[name]
            else:
                self.movie.add(read_snapshot(self.file[name], FIELDS))
                self.count += 1


def frame_times(channel, end, count):
    """Return the times of ``count`` frames over the whole run."""
    return even_times(channel.start_time, end, count)


def read_frames(path):
    """Yield the stored frames as snapshots; density and pressure, which no frame shows, are empty."""
    with h5py.File(path, "r") as file:
        for name in sorted(file):
            yield read_snapshot(file[name], FIELDS)
