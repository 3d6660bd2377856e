"""Numbers over time: what a scene follows in ``history.csv``, what the bodies in the fluid do in ``bodies.h5``."""

import io
import math
import os
import time

import h5py
import numpy as np

from tisph.measures.resolution import resolution
from tisph.observers._storage import hdf5_file, readable, replaced, written
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import Times, even_times

RECORDS = 401
"""Lines of the history, evenly spaced in time."""

RESOLVED = "resolved"
"""Name of the column after those that are followed; in files of older versions they are the last."""


class History(StateObserver):
    """Appends a line ``t, NUMBERS, resolved`` at evenly spaced times from the start of the run to ``end``.

    ``series`` (``scenes/_views.py: TimeSeries``) says which numbers. ``resolved`` is 1 or 0, see
    ``measures/resolution.py``. ``close`` adds their references, of all lines at once, which costs little.
    What the scene has ``extra_series`` stands after ``resolved``, in the same lines.
    Lines of an interrupted run up to ``resumed_at`` are kept. ``about`` is the ``Description`` of the run, if the file
    is to say what it is, in lines that begin with ``#``. A cell is empty where there is no number.
    """

    def __init__(self, path, scene, series, end, resumed_at=None, about=None):
        self.path = path
        self.scene = scene
        self.time_series, self.extra_series = series, scene.extra_series
        self.more = [] if self.extra_series is None else list(self.extra_series.columns)
        self.schedule = Times(even_times(scene.start_time, end, RECORDS))
        kept = []
        if resumed_at is not None:
            records = zip(*read_history(path, len(self.more)), self._flags(), strict=True)
            kept = [record for record in records if record[0] <= resumed_at]
            self.schedule.mark(resumed_at)
        names = ",".join(["t", *series.columns, RESOLVED, *self.more])
        self.header = ("" if about is None else about.comment(series.content)) + names
        with replaced(path) as new:
            new.write_text(f"{self.header}\n" + "".join(self._line(*record) for record in kept), encoding="utf-8")

    def tell(self, step, times):
        """Append lines: from the particles around the probes, where that is enough, else from whole states."""
        if self.probes is None or step.steps == 0:
            super().tell(step, times)
        else:
            when, x, y, u = step.around(times, self.probes.centre, self.probes.half_width)
            self.record(times, self.probes.velocities(len(times), when, x, y, u))

    def observe(self, snapshot):
        """Append one line."""
        values = self.time_series.measure(snapshot)
        if self.extra_series:
            values = np.append(values, self.extra_series.measure(snapshot))
        self._append(self._line(snapshot.t, values, self._resolved(self.scene.seen(snapshot), snapshot.t)).encode())

    @property
    def probes(self):
        """What reads the numbers from particles around some places; None where a line needs all of them."""
        return None if self.extra_series else self.time_series.probes

    def record(self, times, values):
        """Append lines of ``values`` (times, numbers) at ``times``."""
        flags = [self._resolved(self.scene, t) for t in times]
        self._append("".join(map(self._line, times, values, flags)).encode())

    def reading(self, snapshot):
        """Return what is followed: places and values, arrays of shape (numbers,), and times and values so far."""
        return self.time_series.places, self.time_series.measure(snapshot), read_history(self.path)

    def close(self):
        """Add the references."""
        times, values = read_history(self.path, len(self.more))
        exact = self.time_series.exact(times) if len(times) else None
        if exact is None:
            return
        names = list(self.time_series.exact_columns)
        if self.extra_series:
            names += self.extra_series.final_columns
            final = self.extra_series.final(times, values[:, len(self.time_series.columns) :])
            exact = np.hstack([np.broadcast_to(exact, (len(times), exact.shape[-1])), final])
        more = [",".join(map(_digits, row)) for row in exact]
        lines = self.path.read_text(encoding="utf-8").splitlines()[-len(more) :]
        text = "".join(f"{line},{rest}\n" for line, rest in zip(lines, more, strict=True))
        with replaced(self.path) as new:
            new.write_text(f"{self.header},{','.join(names)}\n{text}", encoding="utf-8")

    @staticmethod
    def _resolved(scene, t):
        return int(resolution(scene, t)[0])

    def _flags(self):
        """Return ``resolved`` of each line of the file, as it says, or where it does not, as the scene does."""
        flags = read_resolved(self.path)
        return [self._resolved(self.scene, t) for t in read_history(self.path)[0]] if flags is None else flags

    def _line(self, t, values, resolved):
        count = len(self.time_series.columns)
        return ",".join([*map(_digits, (t, *values[:count])), f"{resolved:d}", *map(_digits, values[count:])]) + "\n"

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
    return "" if math.isnan(value) else repr(float(value))


def read_history(path, more=0):
    """Return times (records,) and what was followed (records, numbers) of a ``history.csv``.

    With ``more``, (records, numbers + more): as many columns of what is monitored stand after them.

    Other columns do not count. ConfigError where lines are damaged.
    """
    with readable(path):
        names, rows = read_rows(path)
        if not rows:
            return np.empty(0), np.empty((0, 0))
        count = names.index(RESOLVED) - 1 if RESOLVED in names else len(names) - 1
        table = np.array(rows)
    return table[:, 0], np.hstack([table[:, 1 : 1 + count], table[:, 2 + count : 2 + count + more]])


def read_resolved(path):
    """Return whether the flow was resolved at the times of a ``history.csv``, bool (records,); None where that is old.

    ConfigError where lines are damaged.
    """
    with readable(path):
        names, rows = read_rows(path)
        if RESOLVED not in names:
            return None
        return np.array([row[names.index(RESOLVED)] for row in rows], dtype=bool)


def read_rows(path):
    """Return the names of the columns of a ``history.csv``, and its rows, each a tuple of numbers.

    Lines that begin with ``#`` do not count, nor does a last line without its end, which a killed run may leave. An
    empty cell is NaN.
    """
    text = path.read_text(encoding="utf-8")
    lines = [line for line in text[: text.rfind("\n") + 1].splitlines() if not line.startswith("#")]
    names = lines[0].split(",") if lines else ["t"]
    return names, [tuple(float(cell or "nan") for cell in line.split(",")) for line in lines[1:]]


TRAJECTORIES = "trajectories of the bodies in the fluid, over time t"

BODY_FIELDS = ("centre", "angle", "velocity", "angular_velocity", "force", "torque", "stresslet", "contact_force")
"""Those of ``tisph.snapshot.Bodies`` that are followed."""

DELAY = 5.0
"""Seconds of the clock after which a record is in the file at the latest, if the next one comes: all are written each
time, at most some megabytes."""


class Trajectories(StateObserver):
    """Keeps the bodies in the fluid at evenly spaced times from the start to ``end``, as many as ``History``.

    Datasets: ``t`` (records,) and each of ``BODY_FIELDS``, (records, bodies, ...), in the units of the config.
    Attributes ``names`` (bodies,): their numbers among those of the config, as columns of the history have them;
    ``shapes`` (bodies,): what they are; ``free`` (bodies,): whether the flow carries them. ``about`` is the
    ``Description`` of the run. ``resumed_at`` is the time up to which records of an interrupted run are kept, None for
    a new file. The file can be read at any time, whatever ends the process.
    """

    def __init__(self, path, scene, end, resumed_at=None, about=None):
        self.path, self.about = path, about
        shapes = [body.shape for body in scene.bodies]
        self.chosen = [k for k, shape in enumerate(shapes) if shape.area and shape.fluid_side == "outside"]
        self.shapes = [type(shapes[index]).__name__.lower() for index in self.chosen]
        self.free = [scene.bodies[index].free for index in self.chosen]
        self.schedule = Times(even_times(scene.start_time, end, RECORDS))
        self.times, self.records = [], {name: [] for name in BODY_FIELDS}
        if resumed_at is not None:
            self.schedule.mark(resumed_at)
            self._keep(resumed_at)
        self.flush()

    def _keep(self, resumed_at):
        """Take up the records of an interrupted run."""
        with readable(self.path), h5py.File(self.path, "r") as file:
            times = file["t"][...]
            self.times = times[times <= resumed_at].tolist()
            self.records = {name: list(file[name][: len(self.times)]) for name in BODY_FIELDS}

    def observe(self, snapshot):
        """Add one record."""
        self.times.append(snapshot.t)
        for name, records in self.records.items():
            records.append(getattr(snapshot.bodies, name)[self.chosen])
        if time.monotonic() >= self.due:
            self.flush()

    def flush(self):
        """Have all records in the file."""
        with replaced(self.path) as new, hdf5_file(new) as file:
            if self.about:
                file.attrs.update(self.about.attributes(TRAJECTORIES))
            file.attrs["names"] = list(map(str, self.chosen))
            file.attrs["shapes"] = self.shapes
            file.attrs["free"] = self.free
            for name, values in {"t": self.times, **self.records}.items():
                data = file.create_dataset(name, data=np.array(values) if values else np.empty(0))
                if self.about:
                    data.attrs["units"] = self.about.units[name]
        self.due = time.monotonic() + DELAY

    def close(self):
        """Have all records in the file."""
        self.flush()
