"""The samples as ParaView reads them, while the run goes on: ``samples.vtkhdf``, and the bodies beside it."""

from tisph.observers._storage import Storage
from tisph.observers._vtkhdf import append, append_bodies, beside, has_outlines
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
        self.files = [_Steps(path, about, append)]
        if has_outlines(about.scene):
            self.files.append(_Steps(beside(path), about, append_bodies))
        for file in self.files:
            file.start(samples.snapshots)

    def observe(self, snapshot):
        """Append one sample."""
        snapshot = next(kept for kept in reversed(self.samples.snapshots) if kept.t == snapshot.t)
        for file in self.files:
            file.add(snapshot)

    def close(self):
        """Leave nothing but the files."""
        for file in self.files:
            file.close()


class _Steps(Storage):
    """A file of steps, which ``append`` adds to; there is none before the first."""

    def __init__(self, path, about, append):
        super().__init__(path, "{}")
        self.about, self.append = about, append

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
        self.append(file, snapshot, self.about)
