"""Observers: the protocol that each fulfils, the step that it is given, and the schedules that say when.

After each step the simulation calls, in the order in which they were added, the observers whose schedule has something
due. An observer reads the run and never changes it: with or without a movie the particles are bitwise the same. An
exception in an observer ends the run, and the folder of results is completed as after any other failure.
CONTRIBUTING.md says how to add one.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from tisph.errors import ConfigError
from tisph.snapshot import Snapshot


class LastStep(Protocol):
    """The last step, from which an observer obtains the states that it needs."""

    time: float
    """Time at the end of the step."""

    steps: int
    """Steps of the run so far."""

    def at(self, time: float) -> Snapshot:
        """Return the state at one of the times given to the observer; DivergedError where it is not sound.

        No state is returned before the guard has checked the latest state due in this step.
        """

    def check(self) -> None:
        """Let the guard check the latest state, once; DivergedError where it is not sound."""

    def end(self) -> Snapshot:
        """Return the state at the end of the step; DivergedError for numbers that are not finite.

        The guard checks it in full only once in ``guard.INTERVAL`` steps.
        """


class Schedule(Protocol):
    """When one observer is called: ``Times``, ``EveryTime`` or ``EverySteps``. Times are on the run's clock."""

    def begin(self, start: float, time: float, steps: int) -> None:
        """Start to observe at ``time`` and ``steps`` a run whose clock starts at ``start``."""

    def take(self, time: float, steps: int) -> list[float] | None:
        """Return the times due after ``steps`` steps, at ``time``, and count them as done; None if nothing is due."""


class Observer(Protocol):
    """An object that reads a run while it goes on."""

    @property
    def schedule(self) -> Schedule:
        """When it is called. Times that are due at the start of the run belong to a first step of length 0."""

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Process the states at ``times``, ascending, within the last ``step``.

        A scheme that does not interpolate replaces all of them by the end of the step.
        """

    def flush(self) -> None:
        """Write everything observed so far to the disk: a checkpoint follows, from which a run may continue."""

    def close(self) -> None:
        """Finish: the run has ended, in whatever way."""


class StateObserver:
    """Base of observers that process one state after the other: they define ``observe``."""

    schedule: Schedule

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Observe the states at ``times``."""
        for time in times:
            self.observe(step.at(time))

    def observe(self, snapshot: Snapshot) -> None:
        """Process one state, in the units and the frame of the config."""
        raise NotImplementedError

    def flush(self) -> None:
        """Do nothing: every state is on the disk as soon as it is observed."""

    def close(self) -> None:
        """Do nothing at the end."""


ROUND_OFF = 1e-9
"""Part of an interval by which a time may miss a multiple of it."""


class Times:
    """Ascending ``times``, later than ``after`` if it is given; due at the end of the first step that reaches each."""

    def __init__(self, times: Iterable[float], after: float | None = None):
        self.times = list(times)
        self.passed = 0 if after is None else bisect_right(self.times, after)

    def begin(self, start: float, time: float, steps: int) -> None:
        """Do nothing: the times are given."""

    def take(self, time: float, _steps: int = 0) -> list[float] | None:
        """Return the times up to ``time`` that are not done yet; None if there are none."""
        if self.passed == len(self.times) or time < self.times[self.passed]:
            return None
        first, self.passed = self.passed, bisect_right(self.times, time)
        return self.times[first : self.passed]


class StepEnds(Times):
    """The end of each step that reaches one or more of the ``times``: at most one time a step."""

    def take(self, time: float, _steps: int = 0) -> list[float] | None:
        """Return ``time``, the end of the last step, where it or a time before it is due."""
        return None if super().take(time) is None else [time]


class EveryTime:
    """The multiples of ``interval`` [time] after the start of the run's clock.

    With ``from_here`` they are counted from the time at which the observation begins.
    """

    def __init__(self, interval: float, from_here: bool = False):
        self.interval = interval
        self.from_here = from_here
        self.origin, self.next = 0.0, 1

    def begin(self, start: float, time: float, steps: int) -> None:
        """Start counting at the run's start time; multiples up to ``time`` count as done."""
        self.origin = time if self.from_here else start
        self.next = self._reached(time) + 1

    def take(self, time: float, _steps: int = 0) -> list[float] | None:
        """Return the multiples up to ``time`` that are not done yet; None if there are none."""
        first, self.next = self.next, max(self.next, self._reached(time) + 1)
        multiples = range(first, self.next)
        return [min(time, self.origin + multiple * self.interval) for multiple in multiples] or None

    def _reached(self, time: float) -> int:
        return math.floor((time - self.origin) / self.interval + ROUND_OFF)


class EverySteps:
    """Each ``number``-th step of the run."""

    def __init__(self, number: int):
        self.number = self.next = number

    def begin(self, start: float, time: float, steps: int) -> None:
        """Count the steps up to ``steps`` as done."""
        self.next = (steps // self.number + 1) * self.number

    def take(self, time: float, steps: int) -> list[float] | None:
        """Return the end of the last step, ``time``, where that is due."""
        if steps < self.next:
            return None
        self.next = (steps // self.number + 1) * self.number
        return [time]


def every(*, time: float | None = None, steps: int | None = None) -> Schedule:
    """Return a schedule, due every ``time`` > 0 of the run from its start, or every ``steps`` > 0 steps: give one."""
    given = [each for each in (time, steps) if each is not None]
    if len(given) != 1 or not 0 < given[0] < math.inf or (steps is not None and steps != int(steps)):
        raise ConfigError("every: give one of time=SECONDS and steps=NUMBER, positive, the steps as a whole number")
    return EverySteps(int(steps)) if steps is not None else EveryTime(float(given[0]))


def even_times(start: float, end: float, count: int) -> list[float]:
    """Return ``count`` equally spaced times from ``start`` to ``end``, both included and exact."""
    between = [start + (end - start) * k / (count - 1) for k in range(1, count - 1)]
    return [start, *between, end]


class Checkpoints(StateObserver):
    """Calls ``save`` every ``interval`` [time], counted from the time at which its observation begins."""

    def __init__(self, interval: float, save: Callable[[], None]):
        self.schedule = EveryTime(interval, from_here=True)
        self.save = save

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Write one checkpoint, however many are due."""
        self.save()
