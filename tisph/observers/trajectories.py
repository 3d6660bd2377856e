"""Trajectories: what the bodies in the fluid do from the start to the end of a run, in ``bodies.h5``."""

import time

import h5py
import numpy as np

from tisph.observers import history
from tisph.observers._files import hdf5_file, readable, replaced
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import Times, even_times

CONTENT = "trajectories of the bodies in the fluid, over time t"

FIELDS = ("centre", "angle", "velocity", "angular_velocity", "force", "torque", "stresslet", "contact_force")
"""Those of ``tisph.snapshot.Bodies`` that are followed."""

DELAY = 5.0
"""Seconds of the clock after which a record is in the file at the latest, if the next one comes: all are written each
time, at most some megabytes."""


class Trajectories(StateObserver):
    """Keeps the bodies in the fluid at evenly spaced times from the start to ``end``, as many as ``History``.

    Datasets: ``t`` (records,) and each of ``FIELDS``, (records, bodies, ...), in the units of the config. Attributes
    ``names`` (bodies,): their numbers among those of the config, as columns of the history have them; ``shapes``
    (bodies,): what they are; ``free`` (bodies,): whether the flow carries them. ``about`` is the ``Description`` of the
    run. ``resumed_at`` is the time up to which records of an interrupted run are kept, None for a new file. The file
    can be read at any time, whatever ends the process.
    """

    def __init__(self, path, scene, end, resumed_at=None, about=None):
        self.path, self.about = path, about
        shapes = [body.shape for body in scene.bodies]
        self.chosen = [k for k, shape in enumerate(shapes) if shape.area and shape.fluid_side == "outside"]
        self.shapes = [type(shapes[index]).__name__.lower() for index in self.chosen]
        self.free = [scene.bodies[index].free for index in self.chosen]
        self.schedule = Times(even_times(scene.start_time, end, history.RECORDS))
        self.times, self.records = [], {name: [] for name in FIELDS}
        if resumed_at is not None:
            self.schedule.mark(resumed_at)
            self._keep(resumed_at)
        self.flush()

    def _keep(self, resumed_at):
        """Take up the records of an interrupted run."""
        with readable(self.path), h5py.File(self.path, "r") as file:
            times = file["t"][...]
            self.times = times[times <= resumed_at].tolist()
            self.records = {name: list(file[name][: len(self.times)]) for name in FIELDS}

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
                file.attrs.update(self.about.attributes(CONTENT))
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
