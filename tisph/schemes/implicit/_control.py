"""Length of the implicit scheme's steps: from the estimated error, the shear of a step, and the times to be met."""

SAFETY = 0.9
SMALLEST_FACTOR, LARGEST_FACTOR = 0.2, 2.0
REJECTED = 1.5
"""Estimated error over the tolerance above which a step is taken again."""

FIRST = 0.25
"""First step in spacing^2 / nu, the time in which a wall that starts moves the row next to it."""


class StepControl:
    """Proposes lengths: ``wish`` is the next one; ``targets`` are met exactly, ``led_to`` was the last to cut a step.

    ``tolerance``: of the error of a step, over the reference velocity. ``largest_strain``: of a step. ``fixed``:
    length of every step (less to meet a target), None for control by the error. ``changes``: times at which what
    drives the flow jumps, targets as well.
    """

    def __init__(self, start, targets, first, tolerance, largest_strain, fixed=None, changes=()):
        self.changes = sorted(changes)
        self.targets = self.ahead(targets, start)
        self.led_to = None
        self.wish = fixed or first
        self.tolerance, self.largest_strain, self.fixed = tolerance, largest_strain, fixed

    def ahead(self, targets, time):
        """Return the times after ``time`` that steps end on."""
        return sorted(target for target in {*targets, *self.changes} if target > time)

    @property
    def finished(self):
        """Whether all targets are met."""
        return not self.targets

    def length(self, time):
        """Return the length of the step to take from ``time``: all, half, or none of what is left to the target."""
        left = self.targets[0] - time
        if self.wish <= 0.5 * left:
            return self.wish
        self.led_to = self.targets[0]
        return left if self.wish >= 0.999 * left else 0.5 * left

    def end(self, time, length):
        """Return the time at the end of a step: exactly the target where it meets that."""
        target = self.targets[0]
        return target if length == target - time else time + length

    def accepts(self, error, length):
        """Judge a step by its error over the tolerance; if refused, ``wish`` is what to try instead."""
        if self.fixed:
            return True
        factor = SAFETY * max(error, 1e-12) ** (-1 / 3)
        factor = min(LARGEST_FACTOR, max(SMALLEST_FACTOR, factor))
        if error > REJECTED:
            self.wish = length * min(factor, 0.7)
            return False
        # a step cut short to meet a target says nothing against longer ones
        if length >= 0.999 * self.wish or factor < 1.0:
            self.wish = length * factor
        return True

    def strained(self, steepest):
        """Tell whether the strain limits the steps, ``steepest`` being the largest velocity gradient."""
        return steepest > 0.0 and self.wish == self.largest_strain / steepest

    def aim(self, targets, time):
        """Go on from ``time`` to other targets; return whether only those have cut steps so far."""
        self.targets = self.ahead(targets, time)
        return self.led_to is None or self.led_to in {*targets, *self.changes}

    def step_taken(self, time, steepest):
        """Take note of a step that ended at ``time`` with the largest velocity gradient ``steepest``."""
        if time == self.targets[0]:
            self.targets.pop(0)
        if not self.fixed and steepest > 0.0:
            self.wish = min(self.wish, self.largest_strain / steepest)
