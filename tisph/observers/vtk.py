"""The samples as ParaView reads them, while the run goes on: ``samples.vtkhdf``."""

from tisph.observers._storage import EXACT, FIELDS, STRESSES, Storage
from tisph.observers._vtkhdf import append
from tisph.observers.protocol import StateObserver
from tisph.observers.schedule import Times


class Vtk(StateObserver):
    """Appends each of ``samples`` (a ``Samples`` observer, which sees a snapshot before this one) to the file ``path``.

    Once there is one, the file can be read at any time, and is what ``tisph export --to vtkhdf`` makes. ``resumed_at``
    as for ``Samples``, whose kept ones begin a new file.
    """

    def __init__(self, path, samples, resumed_at, about):
        self.samples = samples
        self.schedule = Times(samples.schedule.times)
        if resumed_at is not None:
            self.schedule.mark(resumed_at)
        self.storage = _Steps(path, about)
        self.storage.start(samples.snapshots)

    def observe(self, snapshot):
        """Append one sample."""
        self.storage.add(next(kept for kept in reversed(self.samples.snapshots) if kept.t == snapshot.t))

    def close(self):
        """Leave nothing but the file."""
        self.storage.close()


class _Steps(Storage):
    """A file of steps; there is none before the first."""

    def __init__(self, path, about):
        super().__init__(path, "{}")
        self.units, self.config = about.units, about.config
        self.text = about.resolved

    def start(self, snapshots):
        """Make a file of ``snapshots``, if there are any; none is left of an earlier run."""
        self.path.unlink(missing_ok=True)
        if snapshots:
            super().start(snapshots)

    def flush(self):
        """Have all steps in the file."""
        if self.waiting and not self.path.exists():
            super().start([])
        super().flush()

    def put(self, file, name, snapshot):
        """Append a snapshot."""
        append(file, _Arrays(snapshot, self.units), self.config.units, self.text)


class _Arrays(dict):
    """The arrays of a snapshot with their units, named as in ``samples.h5``."""

    def __init__(self, snapshot, units):
        found = {name: getattr(snapshot, name) for name in FIELDS + STRESSES}
        found |= {name + EXACT: values for name, values in (snapshot.reference or {}).items()}
        super().__init__({name: values for name, values in found.items() if values is not None})
        self.t = snapshot.t
        self.units = {name: units.get(name.removesuffix(EXACT), "") for name in self}
