"""What an observer must have, and what it is told.

A simulation tells its observers of the run, in the order in which they were given to it: after each step those whose
schedule says that something is due. An observer looks at the run and never changes it: with or without a movie the
particles are the same to the last bit. It returns nothing. What it raises ends the run; the folder is then left as the
failure of a run leaves it. How to add one is told in CONTRIBUTING.md.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from tisph.snapshot import Snapshot


class LastStep(Protocol):
    """The step that was taken last, from which an observer takes the states that it is to see."""

    time: float
    """Time at the end of the step."""

    steps: int
    """Steps of the run so far."""

    def at(self, time: float) -> Snapshot:
        """Return the state at one of the times that the observer is told; DivergedError where it is not sound.

        No state is given out before the guard has seen the latest one that is asked for after this step.
        """

    def check(self) -> None:
        """Let the guard see the latest state, once; DivergedError where it is not sound."""

    def around(
        self, times: Sequence[float], x: float, half_width: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the particles within ``half_width`` of the place ``x`` at all of the ``times``, as flat arrays.

        Which time (ascending), x, y and velocity along x of each: far less than whole states where that is enough.
        """


class Schedule(Protocol):
    """When an observer is told (``schedule.py`` has those that there are); times are those of the run's clock."""

    def begin(self, start: float, time: float, steps: int) -> None:
        """Take note that a run, whose clock starts at ``start``, is observed from ``time`` and ``steps`` on."""

    def due(self, time: float, steps: int) -> bool:
        """Tell whether something is due after ``steps`` steps, at ``time``."""

    def pending(self, time: float, steps: int) -> list[float]:
        """Return the times of what is due."""

    def mark(self, time: float, steps: int) -> None:
        """Count as done what is due."""


class Observer(Protocol):
    """Something that looks at a run while it goes on."""

    schedule: Schedule
    """When it is told. The start of the run counts as a step of no length for what is due then."""

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Take what is due: the states at ``times``, ascending, within the last ``step``.

        A scheme that does not interpolate has the end of the step in the place of all of them.
        """

    def flush(self) -> None:
        """Have on the disk whatever was observed by now: a checkpoint follows, from which a run may go on."""

    def close(self) -> None:
        """Finish: the run has ended, in whatever way."""


class StateObserver:
    """An observer of one state after the other: what derives from it says in ``observe`` what it does with each."""

    def tell(self, step, times):
        """Observe the states at ``times``."""
        for time in times:
            self.observe(step.at(time))

    def observe(self, snapshot):
        """Take one state, a ``Snapshot`` in the units and the frame of the config."""
        raise NotImplementedError

    def flush(self):
        """Do nothing, where what was observed is on the disk."""

    def close(self):
        """Do nothing, where nothing is left to do at the end."""
