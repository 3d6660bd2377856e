"""Weights of values at earlier times, by interpolation: derivatives, integrals and values for steps of any length."""

import numpy as np

VELOCITIES = 4
"""Times at which velocities are kept: at the end of the last step, and of those before."""

PRESSURES = 2


ORDER = 3
"""Of the backward differences. Those of order 4 are unstable for oscillations, and measured no better."""


class Times:
    """What the polynomials through the values at the ends of some steps say.

    ``steps`` are the times between now, the newest value, the one before and so on, newest first: with a first one of
    0 the newest value is that of now. ``unit`` is the time in which the polynomials are written. Weights come for
    as many values as are kept; of those that are not known yet they are 0.
    """

    def __init__(self, steps, unit):
        self.steps, self.unit = steps, unit
        self.ages = np.cumsum(steps) / unit

    def _weights(self, count, functional, ages=None):
        """Return the weights of the newest values that give a functional, known by its values for 1, t, t^2 ..."""
        ages = self.ages[:count] if ages is None else ages
        powers = np.arange(len(ages))
        weights = np.zeros(max(count, len(ages)))
        weights[: len(ages)] = np.linalg.solve((-ages) ** powers[:, None], [functional(power) for power in powers])
        return weights

    def at(self, age, count):
        """Return the weights of ``count`` values that give the value at ``age``."""
        return self._weights(count, lambda power: (-age / self.unit) ** power)

    def ahead(self, count):
        """Return the weights of ``count`` values that extrapolate them to now."""
        return self.at(0.0, count)

    def since(self, age):
        """Return the weights of the velocities in the way from ``age`` to now."""
        begin = -age / self.unit
        return self.unit * self._weights(VELOCITIES, lambda power: -(begin ** (power + 1)) / (power + 1))

    def path(self):
        """Return the weights of the velocities in the way of the step from the newest of them to now."""
        return self.since(self.steps[0])

    def backwards(self):
        """Return g and weights a such that unit du/dt = g u(now) - sum a u, by backward differences."""
        ages = np.concatenate([[0.0], self.ages[:ORDER]])
        leading, *back = self._weights(ORDER + 1, lambda power: float(power == 1), ages)
        weights = np.zeros(VELOCITIES)
        weights[: len(back)] = np.negative(back)
        return float(leading), weights

    def error(self, difference, leading, speed):
        """Return the error of a step, and of which order it is, from the ``difference`` to extrapolated velocities.

        That is u^(m) prod ages / m! for m values, and the error of backward differences of order m - 1 is the same
        derivative times prod ages / (m! oldest age g). The change in a very first step says no more than how fast
        velocities change by the part (difference / speed): the error is taken to be half the square of that.
        """
        known = min(len(self.ages), VELOCITIES)
        if known == 1:
            return 0.5 * difference**2 / speed, 1
        return difference / (float(self.ages[known - 1]) * leading), known - 1
