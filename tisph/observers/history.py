"""Numbers over time: the quantities that a scene follows in ``history.csv``, the bodies' motion in ``bodies.h5``."""

import io
import math
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tisph.folder import hdf5_file, readable, replaced, written
from tisph.geometry.body import Body
from tisph.measures.resolution import resolution
from tisph.measures.steadiness import Followed, with_followed
from tisph.observers.protocol import LastStep, StateObserver, StepEnds, even_times
from tisph.observers.samples import Description
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot

RECORDS = 401
"""Most lines of the history: at evenly spaced times, and at most one a step, at its end."""

RESOLVED = "resolved"
"""Name of the column after the followed quantities; in files of older versions they are the last."""


class History(StateObserver):
    """Appends a line ``t, NUMBERS, resolved`` at the end of each step that reaches one of ``RECORDS`` even times.

    ``series`` (``scenes/_views.py: TimeSeries``) defines the numbers. ``resolved`` is 1 or 0, see
    ``measures/resolution.py``. ``close`` adds the references of the numbers, of all lines at once, which costs little.
    The ``extra_series`` of the scene stands after ``resolved``, in the same lines. Lines of an interrupted run up to
    ``resumed_at`` are kept. ``about`` describes the run in lines that begin with ``#``. A cell is empty where there is
    no number.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        series: Any,
        end: float,
        resumed_at: float | None = None,
        about: Description | None = None,
    ):
        self.path = path
        self.scene = scene
        self.time_series, self.extra_series = series, scene.extra_series
        self.more: list[str] = [] if self.extra_series is None else list(self.extra_series.columns)
        self.schedule = StepEnds(even_times(scene.start_time, end, RECORDS), resumed_at)
        kept: list[tuple[float, np.ndarray, bool]] = []
        if resumed_at is not None:
            times, values = read_history(path, len(self.more))
            flags = read_resolved(path)
            if flags is None:
                flags = np.array([resolution(scene, t)[0] for t in times], dtype=bool)
            kept = [record for record in zip(times, values, flags, strict=True) if record[0] <= resumed_at]
        names = ",".join(["t", *series.columns, RESOLVED, *self.more])
        self.header = ("" if about is None else about.comment(series.content)) + names
        with replaced(path) as new:
            new.write_text(f"{self.header}\n" + "".join(self._line(*record) for record in kept), encoding="utf-8")

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Append a line of the end of the step."""
        self.observe(step.end())

    def observe(self, snapshot: Snapshot) -> None:
        """Append one line."""
        values = self.time_series.measure(snapshot)
        if self.extra_series:
            values = np.append(values, self.extra_series.measure(snapshot))
        self.record(snapshot.t, values, self.scene.seen(snapshot))

    def record(self, t: float, values: np.ndarray, scene: Scene) -> None:
        """Append a line of the ``values`` (numbers,) at time ``t``, with bodies where they are in ``scene``."""
        self._append(self._line(t, values, resolution(scene, t)[0]).encode())

    def reading(self, snapshot: Snapshot) -> tuple[Any, ...]:
        """Return places and followed numbers of ``snapshot``, arrays (numbers,), and times and numbers so far.

        A last item has times and numbers with their sizes, where these may be steady.
        """
        series = self.time_series
        return with_followed((series.places, series.measure(snapshot), read_history(self.path)), series.judged_sizes)

    def followed(self, times: np.ndarray, values: np.ndarray) -> Followed:
        """Return numbers so far with their sizes."""
        return Followed(times, values, self.time_series.judged_sizes)

    def close(self) -> None:
        """Add the references."""
        times, values = read_history(self.path, len(self.more))
        exact = self.time_series.exact(times) if len(times) else None
        names, columns = [], np.empty((len(times), 0))
        if exact is not None:
            names, columns = [*self.time_series.exact_columns], np.broadcast_to(exact, (len(times), exact.shape[-1]))
        if self.extra_series and len(times):
            names += self.extra_series.final_columns
            final = self.extra_series.final(times, values[:, len(self.time_series.columns) :])
            columns = np.hstack([columns, final])
        if not names:
            return
        more = [",".join(map(_digits, row)) for row in columns]
        lines = self.path.read_text(encoding="utf-8").splitlines()[-len(more) :]
        text = "".join(f"{line},{rest}\n" for line, rest in zip(lines, more, strict=True))
        with replaced(self.path) as new:
            new.write_text(f"{self.header},{','.join(names)}\n{text}", encoding="utf-8")

    def _line(self, t: float, values: np.ndarray, resolved: bool) -> str:
        count = len(self.time_series.columns)
        return ",".join([*map(_digits, (t, *values[:count])), f"{resolved:d}", *map(_digits, values[count:])]) + "\n"

    def _append(self, lines: bytes) -> None:
        """Add all of ``lines`` to the file, or nothing."""
        with written(self.path), io.FileIO(self.path, "r+") as file:
            end = file.seek(0, os.SEEK_END)
            try:
                while lines:  # a full disk may accept a part before it fails
                    lines = lines[file.write(lines) :]
            except OSError:
                file.truncate(end)
                raise


def _digits(value: float) -> str:
    return "" if math.isnan(value) else repr(float(value))


def read_history(path: Path, more: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return times (records,) and followed numbers (records, numbers + ``more``) of a ``history.csv``.

    ``more`` is the number of columns of the scene's extra series, which stand after ``resolved``. Other columns are
    ignored. ConfigError where lines are damaged.
    """
    with readable(path):
        names, rows = read_rows(path)
        if not rows:
            return np.empty(0), np.empty((0, 0))
        count = names.index(RESOLVED) - 1 if RESOLVED in names else len(names) - 1
        table = np.array(rows)
    return table[:, 0], np.hstack([table[:, 1 : 1 + count], table[:, 2 + count : 2 + count + more]])


def read_resolved(path: Path) -> np.ndarray | None:
    """Return whether the flow was resolved at the times of a ``history.csv``, bool (records,); None in an old file.

    ConfigError where lines are damaged.
    """
    with readable(path):
        names, rows = read_rows(path)
        return np.array([row[names.index(RESOLVED)] for row in rows], dtype=bool) if RESOLVED in names else None


def read_rows(path: Path) -> tuple[list[str], list[tuple[float, ...]]]:
    """Return the names of the columns of a ``history.csv``, and its rows, each a tuple of numbers.

    Lines that begin with ``#`` are skipped, as is a last line without an end, which a killed run may leave. An empty
    cell is NaN.
    """
    text = path.read_text(encoding="utf-8")
    lines = [line for line in text[: text.rfind("\n") + 1].splitlines() if not line.startswith("#")]
    names = lines[0].split(",") if lines else ["t"]
    return names, [tuple(float(cell or "nan") for cell in line.split(",")) for line in lines[1:]]


TRAJECTORIES = "trajectories of the bodies in the fluid, over time t"

BODY_FIELDS = ("centre", "angle", "velocity", "angular_velocity", "force", "torque", "stresslet", "contact_force")
"""Followed fields of ``tisph.snapshot.Bodies``."""

DELAY = 5.0
"""Seconds of the clock between two writings of all records, at most some megabytes."""


class Trajectories(StateObserver):
    """Records the bodies in the fluid at the times of the ``History`` of a run to ``end``.

    Datasets: ``t`` (records,) and each of ``BODY_FIELDS``, (records, bodies, ...), in the units of the config.
    Attributes ``names`` (bodies,): their numbers among the bodies of the config, as in columns of the history;
    ``shapes`` (bodies,): such as ``circle``; ``free`` (bodies,): whether the flow carries them. ``about`` describes the
    run. ``resumed_at`` is the time up to which records of an interrupted run are kept, None for a new file. The file
    can be read at any time and survives any end of the process.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        end: float,
        resumed_at: float | None = None,
        about: Description | None = None,
    ):
        self.path, self.about = path, about
        bodies: Sequence[Body] = scene.bodies
        self.chosen = [index for index, body in enumerate(bodies) if body.in_fluid]
        self.shapes = [type(bodies[index].shape).__name__.lower() for index in self.chosen]
        self.free = [bodies[index].free for index in self.chosen]
        self.schedule = StepEnds(even_times(scene.start_time, end, RECORDS), resumed_at)
        self.times: list[float] = []
        self.records: dict[str, list[np.ndarray]] = {name: [] for name in BODY_FIELDS}
        if resumed_at is not None:
            with readable(path), h5py.File(path, "r") as file:
                times = file["t"][...]
                self.times = times[times <= resumed_at].tolist()
                self.records = {name: list(file[name][: len(self.times)]) for name in BODY_FIELDS}
        self.flush()

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Add a record of the end of the step."""
        self.observe(step.end())

    def observe(self, snapshot: Snapshot) -> None:
        """Add one record."""
        self.times.append(snapshot.t)
        for name, records in self.records.items():
            records.append(getattr(snapshot.bodies, name)[self.chosen])
        if time.monotonic() >= self.due:
            self.flush()

    def flush(self) -> None:
        """Write all records to the file."""
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

    close = flush
