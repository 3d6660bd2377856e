"""When an observer is told, apart from what it does then; and checkpoints, which an interrupted run goes on from."""

import math
from bisect import bisect_right

from tisph.errors import ConfigError
from tisph.observers.protocol import StateObserver

ROUND_OFF = 1e-9
"""Part of an interval by which a time may miss a multiple of it."""


class Times:
    """Ascending ``times``; each falls due at the end of the first step that reaches it."""

    def __init__(self, times):
        self.times = list(times)
        self.passed = 0

    def begin(self, start, time, steps):
        """Do nothing: the times are given."""

    def due(self, time, _steps=0):
        """Tell whether a time not yet marked has been reached."""
        return self.passed < len(self.times) and time >= self.times[self.passed]

    def pending(self, time, _steps=0):
        """Return the times up to ``time`` that are not yet marked."""
        return self.times[self.passed : bisect_right(self.times, time)]

    def mark(self, time, _steps=0):
        """Count all times up to ``time`` as done."""
        self.passed = bisect_right(self.times, time)


class EveryTime:
    """The multiples of ``interval`` [time] after the start of the run's clock, or after ``origin`` if that is given."""

    def __init__(self, interval, origin=None):
        self.interval = interval
        self.origin = origin
        self.next = 1

    def begin(self, start, time, steps):
        """Count from the ``start`` of the clock, and as done what is not after ``time``."""
        if self.origin is None:
            self.origin = start
        self.mark(time, steps)

    def due(self, time, _steps=0):
        """Tell whether a multiple not yet marked has been reached."""
        return self._reached(time) >= self.next

    def pending(self, time, _steps=0):
        """Return the multiples up to ``time`` that are not yet marked."""
        multiples = range(self.next, self._reached(time) + 1)
        return [min(time, self.origin + multiple * self.interval) for multiple in multiples]

    def mark(self, time, _steps=0):
        """Count all multiples up to ``time`` as done."""
        self.next = self._reached(time) + 1

    def _reached(self, time):
        return math.floor((time - self.origin) / self.interval + ROUND_OFF)


class EverySteps:
    """Each ``number``-th step of the run."""

    def __init__(self, number):
        self.number = number
        self.next = number

    def begin(self, start, time, steps):
        """Count as done what is not after ``steps``."""
        self.mark(time, steps)

    def due(self, _time, steps):
        """Tell whether a step not yet marked has been taken."""
        return steps >= self.next

    def pending(self, time, steps):
        """Return the end of the last step, ``time``, where that is due."""
        return [time] if self.due(time, steps) else []

    def mark(self, _time, steps):
        """Count all steps up to ``steps`` as done."""
        self.next = (steps // self.number + 1) * self.number


def every(*, time=None, steps=None):
    """Return the schedule of something that is to happen every ``time`` of the run's clock, or every ``steps`` steps.

    A ``time`` is in the unit of the config and counts from the start of the run, where nothing is due yet. One of the
    two must be given, and be positive; else ConfigError.
    """
    given = [each for each in (time, steps) if each is not None]
    if len(given) != 1 or not 0 < given[0] < math.inf or (steps is not None and steps != int(steps)):
        raise ConfigError("every: give one of time=SECONDS and steps=NUMBER, positive, the steps as a whole number")
    return EveryTime(float(time)) if steps is None else EverySteps(int(steps))


def even_times(start, end, count):
    """Return ``count`` equally spaced times from ``start`` to ``end``, both included and exact."""
    between = [start + (end - start) * k / (count - 1) for k in range(1, count - 1)]
    return [start, *between, end]


class Checkpoints(StateObserver):
    """Calls ``save`` every ``interval`` [time] from where the run is when its observation begins."""

    def __init__(self, interval, save):
        self.schedule = FromHere(interval)
        self.save = save

    def tell(self, step, times):
        """Write one, however many are due."""
        self.save()


class FromHere(EveryTime):
    """Multiples of an interval after the time at which the observation begins."""

    def begin(self, start, time, steps):
        """Count from ``time``."""
        super().begin(time, time, steps)
