"""History: velocities at the tracers on a vertical line, in ``history.csv``."""

import io
import os

import numpy as np

from tisph.observers._files import readable, replaced, written
from tisph.observers._schedule import Schedule, even_times
from tisph.verification.interpolation import Probes

RECORDS = 401
"""Lines of the history, evenly spaced in time."""


class History:
    """Appends a line ``t, u at each tracer`` at evenly spaced times from ``start`` to ``end``.

    ``x`` and ``y`` are the arrays of tracer positions. The header names the heights. Lines of an interrupted
    run up to ``resumed_at`` are kept.
    """

    def __init__(self, path, channel, tracers, end, resumed_at=None):
        self.path = path
        self.heights = tracers[1]
        self.probes = Probes(channel, *tracers)
        self.schedule = Schedule(even_times(channel.start_time, end, RECORDS))
        kept = []
        if resumed_at is not None:
            times, velocities = read_history(path)
            kept = [(t, row) for t, row in zip(times, velocities, strict=True) if t <= resumed_at]
            self.schedule.mark(resumed_at)
        heights = ",".join(f"u(y={y:.6g})" for y in self.heights)
        with replaced(path) as new:
            new.write_text(f"t,{heights}\n" + "".join(_line(*record) for record in kept), encoding="utf-8")

    def observe(self, snapshot):
        """Append one line."""
        self.schedule.mark(snapshot.t)
        self._append(_line(snapshot.t, self.probes.velocity(snapshot)).encode())

    def tracers(self, snapshot):
        """Return the pair (y, u) at the tracers, arrays of shape (tracers,)."""
        return self.heights, self.probes.velocity(snapshot)

    def flush(self):
        """Do nothing: what was observed is in the file."""

    def close(self):
        """Do nothing: the file is closed after each line."""

    def _append(self, line):
        """Add all of ``line`` to the file, or nothing."""
        with written(self.path), io.FileIO(self.path, "r+") as file:
            end = file.seek(0, os.SEEK_END)
            try:
                while line:  # a disk may have room for a part, and fails with the rest
                    line = line[file.write(line) :]
            except OSError:
                file.truncate(end)
                raise


def _line(t, velocities):
    return ",".join(repr(float(value)) for value in (t, *velocities)) + "\n"


def read_history(path):
    """Return times (records,) and tracer velocities (records, tracers) of a ``history.csv``.

    A last line without its end, which a killed run may leave, does not count. ConfigError where lines are damaged.
    """
    with readable(path):
        text = path.read_text(encoding="utf-8")
        lines = text[: text.rfind("\n") + 1].splitlines()[1:]
        if not lines:
            return np.empty(0), np.empty((0, 0))
        table = np.loadtxt(lines, delimiter=",", ndmin=2)
    return table[:, 0], table[:, 1:]
