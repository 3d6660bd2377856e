"""Length of the steps: from the estimated error, the Courant number, and the times to be met.

Backward differences of third order are stable for steps that grow by up to 1.53 each, and every change of the step
costs accuracy: steps grow by half at most, and the last ones before a target are of one length.
"""

import math

SAFETY = 0.9
SMALLEST_FACTOR, LARGEST_FACTOR = 0.2, 1.5
REJECTED = 1.5
"""Estimated error over the tolerance above which a step is taken again."""

SOON = 6
"""Steps before a target that share what is left of the time to it."""

FIRST = 0.02
"""The first step, which is of first order, over what the Courant number allows."""


class StepControl:
    """Proposes lengths: ``wish`` is the next one; ``targets`` are met exactly, ``led_to`` was the last to cut a step.

    ``tolerance``: of the error of a step, over the present velocity; None where the Courant number alone decides.
    """

    def __init__(self, start, targets, tolerance):
        self.targets = [target for target in targets if target > start]
        self.led_to = None
        self.wish = math.inf
        self.tolerance = tolerance
        self.refused = None

    @property
    def finished(self):
        """Whether all targets are met."""
        return not self.targets

    def begin(self, longest):
        """Choose the first step where the Courant number allows the ``longest``."""
        self.wish = FIRST * longest

    def length(self, time):
        """Return the length of the step to take from ``time``."""
        left = self.targets[0] - time
        count = math.ceil(0.999 * left / self.wish)
        if count > SOON:
            return self.wish
        self.led_to = self.targets[0]
        return left / count

    def end(self, time, length):
        """Return the time at the end of a step: exactly the target where it meets that."""
        target = self.targets[0]
        return target if length == target - time else time + length

    def accepts(self, error, order, length):
        """Judge a step of a method of ``order`` by its error; if refused, ``wish`` is what to try instead.

        An error that falls more slowly than this order from one attempt to the next is none of the step's: where layers
        are thinner than a spacing the velocities that follow a shift are uneven, whatever comes next.
        """
        factor = LARGEST_FACTOR
        if self.tolerance is not None:
            part = max(error / self.tolerance, 1e-12)
            factor = min(LARGEST_FACTOR, max(SMALLEST_FACTOR, SAFETY * part ** (-1 / (order + 1))))
            if part > REJECTED:
                before, self.refused = self.refused, (length, error)
                if before is None or error < before[1] * (length / before[0]) ** order:
                    self.wish = length * min(factor, 0.7)
                    return False
                factor = 1.0
        self.refused = None
        self.wish = length * factor
        return True

    def step_taken(self, time, longest):
        """Take note of a step that ended at ``time``, after which the Courant number allows the ``longest``."""
        if time == self.targets[0]:
            self.targets.pop(0)
        self.wish = min(self.wish, longest)

    def aim(self, targets, time):
        """Go on from ``time`` to other targets; return whether only those have cut steps so far."""
        self.targets = [target for target in targets if target > time]
        return self.led_to is None or self.led_to in targets
