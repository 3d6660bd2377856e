"""``fastest.csv``: the largest speed in the fluid over time."""

import numpy as np

from tisph.observers.protocol import StateObserver, every


class Fastest(StateObserver):
    """A line each ``interval`` [time] in the file ``path``."""

    def __init__(self, path, interval):
        self.schedule = every(time=interval)
        self.file = open(path, "w")  # noqa: SIM115, closed by close()
        self.file.write("t,speed\n")

    def observe(self, snapshot):
        """Write one line."""
        self.file.write(f"{snapshot.t},{np.hypot(snapshot.u, snapshot.v).max()}\n")

    def flush(self):
        """Write all lines to the disk."""
        self.file.flush()

    def close(self):
        """Close the file."""
        self.file.close()
