"""Checkpoints at regular times: what an interrupted run goes on from."""

from tisph.observers.schedule import EveryTime


class Checkpoints:
    """Calls ``save`` every ``interval`` [time] from where the run is when its observation begins."""

    def __init__(self, interval, save):
        self.schedule = FromHere(interval)
        self.save = save

    def tell(self, step, times):
        """Write one, however many are due."""
        self.save()

    def flush(self):
        """Do nothing: it is written whole or not at all."""

    def close(self):
        """Do nothing: at the end of a run that is done there is nothing to go on from."""


class FromHere(EveryTime):
    """Multiples of an interval after the time at which the observation begins."""

    def begin(self, start, time, steps):
        """Count from ``time``."""
        super().begin(time, time, steps)
