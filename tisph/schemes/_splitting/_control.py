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

SHARE = 0.02
"""Of what the spacing leaves of the velocities, down to which the error of a step is held, and no further: velocities
of particles vary on their way as errors in space do, and steps that follow that are many and no better. With 0.05 the
error under a regular lid, 25 across, grows by a tenth."""

RUNAWAY = 1e3
"""Largest velocity over the reference velocity. Bodies that close a gap press some tens of times theirs out of it."""

FIRST = 0.02
"""The first step, which is of first order, over what the Courant number allows."""

MOST_VISCOUS = 5.0
"""Viscous number nu h/spacing^2 of the longest step between walls. Up to 6 divergence decays at the rate above whatever
the step, beyond it the divergence that there is grows with the step: every change of the step would change velocities
by more than the tolerance, and be refused. Steps are stable to 400 and more; flow rates of cylinders in slow flow, 20
spacings across, err by 3e-4 with 10 and by 1e-3 with 400."""

LEADING = 11 / 6
"""What backward differences of third order multiply the newest value with, over steps of one length."""


def viscous_step(spacing, viscosity, rheology=None):
    """Return the step at which ``MOST_VISCOUS`` is reached; ``viscosity`` is the total one.

    Of a polymer as much of it counts as answers within the step h: h times the moduli over the density and over g.
    """
    most = MOST_VISCOUS * spacing**2
    if rheology is None:
        return most / viscosity
    stiffness = sum(law.modulus for law in rheology.laws(viscosity)) / LEADING
    solvent = rheology.solvent_fraction * viscosity
    return 2.0 * most / (solvent + math.sqrt(solvent**2 + 4.0 * stiffness * most))


class StepControl:
    """Proposes lengths: ``wish`` is the next one; ``targets`` are met exactly, ``led_to`` was the last to cut a step.

    ``tolerance``: of the error of a step, over the present velocity; None where the Courant number alone decides.
    ``changes``: times at which what drives the flow jumps; up to the last target they are targets as well.
    """

    def __init__(self, start, targets, tolerance, changes=()):
        self.changes = list(changes)
        self.targets = self.ahead(targets, start)
        self.led_to = None
        self.wish = math.inf
        self.tolerance = tolerance
        self.refused = None

    def ahead(self, targets, time):
        """Return the times after ``time`` that steps end on."""
        changes = [change for change in self.changes if change < max(targets)]
        return sorted(target for target in {*targets, *changes} if target > time)

    @property
    def finished(self):
        """Whether all targets are met."""
        return not self.targets

    def begin(self, longest):
        """Choose the first step, or the first one after a change, where the Courant number allows the ``longest``."""
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

    def accepts(self, error, order, length, unresolved):
        """Judge a step of a method of ``order`` by its error; if refused, ``wish`` is what to try instead.

        ``unresolved`` is what the spacing leaves of the velocities, of which a step need not be a smaller part.

        An error that falls more slowly than this order from one attempt to the next is none of the step's: where layers
        are thinner than a spacing the velocities that follow a shift are uneven, whatever comes next.
        """
        factor = LARGEST_FACTOR
        if self.tolerance is not None:
            part = max(error / max(self.tolerance, SHARE * unresolved), 1e-12)
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
        self.targets = self.ahead(targets, time)
        return self.led_to is None or self.led_to in {*targets, *self.changes}
