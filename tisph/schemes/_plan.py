"""Equal time steps that end exactly on the wanted times."""

import math


class StepPlan:
    """Splits the way to each target time into equal steps no longer than a limit.

    The limit may change on the way; the step then changes for the rest of the way to the target. ``time`` is
    the time at the end of the last planned step.
    """

    def __init__(self, start, targets):
        self.time = start
        self.targets = [target for target in targets if target > start]
        self.limit = math.inf
        self.step = 0.0
        self.left = 0

    def next(self, limit):
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

    def aim(self, targets):
        """Go on to other targets; return whether all steps so far led to one of them."""
        cut_by = self.targets[0] if self.left else self.time
        ahead = [target for target in targets if target > self.time]
        if ahead[:1] != self.targets[:1]:
            self.left = 0
        self.targets = ahead
        return cut_by in targets


def steps_between(start, target, limit):
    """Return the number of equal steps no longer than ``limit`` from ``start`` to ``target``, at least 1.

    A remainder of rounding size does not cost a step of its own.
    """
    return max(1, math.ceil((target - start) / limit * (1.0 - 1e-12)))
