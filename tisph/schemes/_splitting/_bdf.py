"""Variable-step weights of values at earlier times: backward differences (BDF), integrals, interpolation."""

import numpy as np

VELOCITIES, PRESSURES = 4, 2
"""Number of time levels: at the end of the last step, and of those before."""

ORDER = 3
"""Of the backward differences. Those of order 4 are unstable for oscillations, and measured no better."""


class TimeWeights:
    """Weights by the polynomials through the values at the ends of some steps.

    ``steps`` are the times between now, the newest value, the one before and so on, newest first: with a first one of
    0 the newest value is that of now. ``unit`` is the unit of time of the polynomials, ``offsets`` are the times before
    now in it. Weights come for as many values as are stored; of those that are not known yet they are 0.
    """

    def __init__(self, steps, unit):
        self.steps, self.unit = steps, unit
        self.offsets = np.cumsum(steps) / unit

    def _weights(self, count, functional, offsets=None):
        """Return the weights of the newest values that give a functional, known by its values for 1, t, t^2 ..."""
        offsets = self.offsets[:count] if offsets is None else offsets
        powers = np.arange(len(offsets))
        found = np.linalg.solve((-offsets) ** powers[:, None], np.array([functional(power) for power in powers]))
        return np.concatenate([found, np.zeros((count - len(offsets), *found.shape[1:]))])

    def interpolation(self, offset, count):
        """Return the weights of ``count`` values that give the value at the time ``offset`` before now.

        For offsets (n,) weights are (count, n).
        """
        return self._weights(count, lambda power: (-offset / self.unit) ** power)

    def extrapolation(self, count):
        """Return the weights of ``count`` values that extrapolate them to now."""
        return self.interpolation(0.0, count)

    def integral(self, offset):
        """Return the weights of the velocities in the displacement since the time ``offset`` before now."""
        begin = -offset / self.unit
        return self.unit * self._weights(VELOCITIES, lambda power: -(begin ** (power + 1)) / (power + 1))

    def step_integral(self):
        """Return the weights of the velocities in the displacement of the step from the newest of them to now."""
        return self.integral(self.steps[0])

    def bdf(self):
        """Return gamma_0 and the alpha_q of unit du/dt = gamma_0 u(now) - sum alpha_q u_q, by backward differences."""
        offsets = np.concatenate([[0.0], self.offsets[:ORDER]])
        gamma0, *alpha = self._weights(ORDER + 1, lambda power: float(power == 1), offsets)
        weights = np.zeros(VELOCITIES)
        weights[: len(alpha)] = np.negative(alpha)
        return float(gamma0), weights

    def step_error(self, difference, gamma0, speed):
        """Return the error of a step, and of which order it is, from the ``difference`` to extrapolated velocities.

        That is u^(m) prod offsets / m! for m values, and the error of backward differences of order m - 1 is the same
        derivative times prod offsets / (m! oldest offset gamma_0). Of a very first step only the relative change of
        the velocities is known, difference / speed: the error is taken to be half the square of that.
        """
        known = min(len(self.offsets), VELOCITIES)
        if known == 1:
            return 0.5 * difference**2 / speed, 1
        return difference / (float(self.offsets[known - 1]) * gamma0), known - 1
