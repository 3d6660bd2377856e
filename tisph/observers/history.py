"""History: velocities at the tracers on a vertical line, in ``history.csv``."""

import io
import os

import numpy as np

from tisph.observers._files import readable, replaced, written
from tisph.observers._schedule import Schedule, even_times
from tisph.verification.interpolation import Probes
from tisph.verification.resolution import resolution

RECORDS = 401
"""Lines of the history, evenly spaced in time."""

MEASURED = "u(y="
"""What the name of a column with the velocity at a tracer begins with."""

CONTENT = "velocities u along x over time t at tracers at heights y"


class History:
    """Appends a line ``t, u at each tracer, resolved`` at evenly spaced times from the start of the run to ``end``.

    ``tracers`` is the pair of arrays x, y of their positions. The header names the heights; ``resolved`` is 1 or 0, see
    ``verification/resolution.py``. ``close`` adds the exact u at each tracer, of all lines at once, which costs little.
    Lines of an interrupted run up to ``resumed_at`` are kept. ``about`` is the ``Description`` of the run, if the file
    is to say what it is, in lines that begin with ``#``.
    """

    def __init__(self, path, channel, tracers, end, resumed_at=None, about=None):
        self.path = path
        self.channel = channel
        self.heights = tracers[1]
        self.probes = Probes(channel, *tracers)
        self.schedule = Schedule(even_times(channel.start_time, end, RECORDS))
        kept = []
        if resumed_at is not None:
            times, velocities = read_history(path)
            kept = [(t, row) for t, row in zip(times, velocities, strict=True) if t <= resumed_at]
            self.schedule.mark(resumed_at)
        names = [f"{MEASURED}{y:.6g})" for y in self.heights]
        self.header = ("" if about is None else about.comment(CONTENT)) + ",".join(["t", *names, "resolved"])
        with replaced(path) as new:
            new.write_text(f"{self.header}\n" + "".join(self._line(*record) for record in kept), encoding="utf-8")

    def observe(self, snapshot):
        """Append one line."""
        self.record([snapshot.t], [self.probes.velocity(snapshot)])

    def record(self, times, velocities):
        """Append lines of the velocities (times, tracers) at ``times``."""
        self.schedule.mark(times[-1])
        self._append("".join(map(self._line, times, velocities)).encode())

    def tracers(self, snapshot):
        """Return the pair (y, u) at the tracers, arrays of shape (tracers,)."""
        return self.heights, self.probes.velocity(snapshot)

    def flush(self):
        """Do nothing: what was observed is in the file."""

    def close(self):
        """Add the exact velocities."""
        times, velocities = read_history(self.path)
        if not len(times):
            return
        exact = self.channel.exact_velocity(self.heights, times[:, None])
        names = ",".join(f"u_exact(y={y:.6g})" for y in self.heights)
        lines = [self._line(*record) for record in zip(times, velocities, exact, strict=True)]
        with replaced(self.path) as new:
            new.write_text(f"{self.header},{names}\n" + "".join(lines), encoding="utf-8")

    def _line(self, t, velocities, exact=()):
        resolved = str(int(resolution(self.channel, t)[0]))
        return ",".join([*map(_digits, (t, *velocities)), resolved, *map(_digits, exact)]) + "\n"

    def _append(self, lines):
        """Add all of ``lines`` to the file, or nothing."""
        with written(self.path), io.FileIO(self.path, "r+") as file:
            end = file.seek(0, os.SEEK_END)
            try:
                while lines:  # a disk may have room for a part, and fails with the rest
                    lines = lines[file.write(lines) :]
            except OSError:
                file.truncate(end)
                raise


def _digits(value):
    return repr(float(value))


def read_history(path):
    """Return times (records,) and tracer velocities (records, tracers) of a ``history.csv``.

    Lines that begin with ``#`` and other columns do not count, nor does a last line without its end, which a killed run
    may leave. ConfigError where lines are damaged.
    """
    with readable(path):
        text = path.read_text(encoding="utf-8")
        lines = [line for line in text[: text.rfind("\n") + 1].splitlines() if not line.startswith("#")]
        if len(lines) < 2:
            return np.empty(0), np.empty((0, 0))
        tracers = lines[0].count(f",{MEASURED}")
        table = np.loadtxt(lines[1:], delimiter=",", ndmin=2)
    return table[:, 0], table[:, 1 : 1 + tracers]
