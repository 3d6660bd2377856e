"""The lengths of time steps: by the estimated error, by a limit that the flow sets, and by the times to be met.

From the error of a step of length dt, over its tolerance, follows the next one, dt (error/tolerance)^(-1/(p+1)) for a
method of order p, with a margin and within bounds (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential
Equations I, Springer 1993, II.4).

Steps without an error estimate are equal, and end exactly on the wanted times.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

SAFETY = 0.9
SMALLEST_FACTOR = 0.2
LARGEST_FACTOR, LARGEST_MULTISTEP_FACTOR = 2.0, 1.5
"""By how much a step may be longer than the one before: of a one-step method, and of backward differences of third
order, which are stable up to 1.53, and whose accuracy suffers from every change of the step."""

REJECTED = 1.5
"""Estimated error over the tolerance above which a step is taken again."""

LAST_STEPS, LAST_MULTISTEPS = 2, 6
"""The steps before a target that share the time left to it evenly: of a one-step and of a multistep method."""

SHARE = 0.02
"""Part of the error of the spacing in the velocities, below which the error of a step is not reduced any further:
velocities of particles vary along their paths as errors in space do, and steps that resolve that are many and no more
accurate. With 0.05 the steady flow under a regular lid, 25 across, takes 1933 steps instead of 2688, and has an error
of 1.73e-3 instead of 1.61e-3; with 0.03 it scatters too much to count as steady."""

MOST_ATTEMPTS = 20
"""At one step, before a run is given up."""

LARGEST_SCATTER = 0.03
"""Tolerance by scatter at most: larger errors are a flow that runs away."""

SCATTERED, REMEMBERED = 8.0, 0.99
"""Steps over which the roughness of velocities in time is a mean, and part of their scatter that a later step keeps."""

ABOVE_SCATTER = 4.0
"""Tolerance over the scatter of velocities. Steps keep their length with an error of 0.66 of the tolerance: with this
number they grow by a quarter each while their error is scatter alone."""


class Kept:
    """An object whose attributes named in ``kept``, data that JSON can hold, are part of a checkpoint."""

    kept: tuple[str, ...] = ()

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {name: getattr(self, name) for name in self.kept}

    def make_room(self, state: Mapping[str, Any]) -> None:
        """Leave the fields as they are: they have the size of those of a ``host_state``."""

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``, which may be among others."""
        vars(self).update({name: state[name] for name in self.kept})


class StepControl(Kept):
    """The lengths of the steps of an implicit scheme. All times are in the units of the config.

    ``dt_next``: the next step, if no target cuts it; the scheme sets the first one. ``targets``: times, ascending, that
    steps have still to end on exactly; ``cut_by``: the last one that cut a step. ``last_rejected``: length and error
    of the last attempt, if it was rejected; ``rejected``: number of the attempts that were.

    ``tolerance``: of the error of a step. ``limit``: function that returns the longest step for the number that the
    scheme measures after each step (a velocity gradient, a velocity). ``fixed``: whether steps are that long whatever
    their error. ``multistep``: whether the method uses values of earlier steps. ``jump_times``: times at which a wall
    velocity, a drive or a body force jumps; up to the last target they are targets as well. ``share``: least error of
    a step over the error of the spacing (``SHARE``). ``balanced``: function that returns the tolerance for the
    ``unresolved`` of ``accepts``, at most ``tolerance``; None where the tolerance is always the same.

    ``roughness``: mean logarithm of the last differences of velocities from extrapolated ones over those of one order
    less. Differences fall with the order if velocities are smooth in time at the length of a step, and grow if they
    scatter from step to step; then shorter steps are no more exact. ``scatter``: error that is due to scatter.
    """

    kept = "dt_next", "targets", "cut_by", "last_rejected", "rejected", "roughness", "scatter"

    def __init__(
        self,
        tolerance: float | None,
        limit: Callable[[float], float],
        *,
        fixed: bool = False,
        multistep: bool = False,
        jump_times: Iterable[float] = (),
        share: float = SHARE,
        balanced: Callable[[float], float] | None = None,
    ) -> None:
        self.tolerance = math.inf if tolerance is None else tolerance
        self.limit, self.fixed, self.jump_times, self.multistep = limit, fixed, sorted(jump_times), multistep
        self.share, self.balanced = share, balanced
        self.largest_factor = LARGEST_MULTISTEP_FACTOR if multistep else LARGEST_FACTOR
        self.last_steps = LAST_MULTISTEPS if multistep else LAST_STEPS
        self.dt_next = math.inf
        self.targets: list[float] = []
        self.cut_by: float | None = None
        self.last_rejected: tuple[float, float] | None = None
        self.rejected = 0
        self.roughness, self.scatter = -1.0, 0.0

    def set_targets(self, targets: Sequence[float], time: float) -> bool:
        """Go on from ``time`` to these targets; return whether no others have cut steps so far."""
        jump_times = [time for time in self.jump_times if time < max(targets)]
        self.targets = sorted(target for target in {*targets, *jump_times} if target > time)
        return self.cut_by is None or self.cut_by in {*targets, *self.jump_times}

    @property
    def finished(self) -> bool:
        """Whether all targets are met."""
        return not self.targets

    def take(
        self, time: float, attempt: Callable[[float], tuple[float, int]], unresolved: float | None = None
    ) -> tuple[float | None, float]:
        """Attempt steps from ``time`` until one is accepted; return its length and its error.

        ``attempt(dt)`` computes the end of a step and returns its error and the order of that; after an infinite error
        half the length is tried. ``unresolved``: see ``accepts``. The length is None where no step is short enough.
        """
        for _ in range(MOST_ATTEMPTS):
            dt = self.choose_dt(time)
            error, order = attempt(dt)
            if math.isinf(error):
                self.dt_next = 0.5 * dt
            elif self.accepts(error, order, dt, unresolved):
                return dt, error
            self.rejected += 1
        return None, error

    def choose_dt(self, time: float) -> float:
        """Return the step to take from ``time``: ``dt_next``, or an even share of the time left to a near target."""
        left = self.targets[0] - time
        count = math.ceil(0.999 * left / self.dt_next)
        if count > self.last_steps:
            return self.dt_next
        self.cut_by = self.targets[0]
        return left / count

    def end(self, time: float, dt: float) -> float:
        """Return the time at the end of a step: exactly the target where it meets that."""
        target = self.targets[0]
        return target if dt == target - time else time + dt

    def accepts(self, error: float, order: int, dt: float, unresolved: float | None = None) -> bool:
        """Return whether a step of a method of ``order`` is accepted; if not, ``dt_next`` is the step to try instead.

        ``unresolved``: error of the spacing in the velocities; the error of a step need not be a smaller part of it
        than ``share``. None where the estimated error has no part of it. With such a part an error that falls more
        slowly than this order from one attempt to the next is not caused by the step: where layers are thinner than a
        spacing velocities that are transferred with a shift are uneven, whatever comes next."""
        factor = self.largest_factor
        if not self.fixed:
            least = max(self.share * (unresolved or 0.0), min(ABOVE_SCATTER * self.scatter, LARGEST_SCATTER))
            ratio = max(error / max(self.tolerance_for(unresolved), least), 1e-12)
            factor = min(factor, max(SMALLEST_FACTOR, SAFETY * ratio ** (-1 / (order + 1))))
            if ratio > REJECTED:
                before, self.last_rejected = self.last_rejected, (dt, error)
                if before is None or unresolved is None or error < before[1] * (dt / before[0]) ** order:
                    self.dt_next = dt * min(factor, 0.7)
                    return False
                factor = 1.0
        self.last_rejected = None
        # that a step of a one-step method was cut short by a target is no reason against longer ones
        if self.multistep or dt >= 0.999 * self.dt_next or factor < 1.0:
            self.dt_next = dt * factor
        return True

    def tolerance_for(self, unresolved: float | None) -> float:
        """Return the tolerance of a step where the error of the spacing in the velocities is ``unresolved``."""
        return self.tolerance if self.balanced is None or unresolved is None else self.balanced(unresolved)

    def notice_scatter(self, error: float, roughness: float) -> None:
        """Take note of the ``error`` and the ``roughness``, of which -1 to 1 count, of a step that was accepted."""
        self.roughness += (min(1.0, max(-1.0, roughness)) - self.roughness) / SCATTERED
        self.scatter = max(REMEMBERED * self.scatter, error if self.roughness > 0.0 else 0.0)

    def step_taken(self, time: float, measured: float) -> None:
        """Count a step that ended at ``time``; the limit of the next one depends on the ``measured`` number."""
        if time == self.targets[0]:
            self.targets.pop(0)
        self.dt_next = min(self.dt_next, self.limit(measured))


class StepPlan:
    """Splits the way to each target time into equal steps no longer than a limit.

    The limit may change on the way; the step then changes for the rest of the way to the target. ``time`` is
    the time at the end of the last planned step.
    """

    def __init__(self, start: float, targets: Sequence[float]) -> None:
        self.time: float = start
        self.targets: list[float] = [target for target in targets if target > start]
        self.limit = math.inf
        self.step, self.left = 0.0, 0

    def next(self, limit: float) -> float:
        """Plan one more step and return its length: 0 when the last target is reached."""
        if not self.targets:
            return 0.0
        target = self.targets[0]
        if self.left == 0 or limit != self.limit:
            self.left = steps_between(self.time, target, limit)
            self.step = (target - self.time) / self.left
            self.limit = limit
        self.left -= 1
        self.time = self.time + self.step if self.left else self.targets.pop(0)
        return self.step

    def aim(self, targets: Sequence[float]) -> bool:
        """Go on to other targets; return whether all steps so far led to one of them."""
        cut_by = self.targets[0] if self.left else self.time
        ahead = [target for target in targets if target > self.time]
        if ahead[:1] != self.targets[:1]:
            self.left = 0
        self.targets = ahead
        return cut_by in targets


def steps_between(start: float, target: float, limit: float) -> int:
    """Return the number of equal steps no longer than ``limit`` from ``start`` to ``target``, at least 1.

    A remainder of rounding size does not cost a step of its own.
    """
    return max(1, math.ceil((target - start) / limit * (1.0 - 1e-12)))
