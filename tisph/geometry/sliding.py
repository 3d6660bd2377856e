"""Wall that stays where it is and slides along itself, with a speed that varies from place to place."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from tisph.geometry.body import Body


@dataclass(frozen=True, kw_only=True)
class SlidingWall(Body):
    """A body, a line along x, that slides along x with ``speed`` times ``profile``, a polynomial in x/``width``."""

    speed: float
    width: float
    profile: Polynomial

    def _along(self, points, polynomial):
        values = polynomial(np.asarray(points, dtype=float)[:, 0] / self.width)
        return np.stack([values, np.zeros(len(values))], axis=1)

    def velocity(self, points, time=0.0):
        """Velocity (n, 2) of the wall at ``points`` (n, 2)."""
        return self.speed * self._along(points, self.profile)

    def departure_point(self, points, elapsed):
        """Where (n, 2) the wall's material at ``points`` (n, 2) was a time ``elapsed`` ago: a step of Runge-Kutta."""
        start = np.asarray(points, dtype=float)
        first = -elapsed * self.velocity(start)
        second = -elapsed * self.velocity(start + 0.5 * first)
        third = -elapsed * self.velocity(start + 0.5 * second)
        return start + (first + 2.0 * (second + third) - elapsed * self.velocity(start + third)) / 6.0

    def tangential_gradient(self, points, tangents, time=0.0):
        """Derivatives (n, 2) of the wall's velocity along ``tangents`` (n, 2) at ``points`` (n, 2)."""
        return self.speed / self.width * self._along(points, self.profile.deriv()) * tangents[:, :1]

    def acceleration(self, points, time=0.0):
        """Acceleration (n, 2) of its material at ``points`` (n, 2), which is carried along it."""
        return self.speed**2 / self.width * self._along(points, self.profile * self.profile.deriv())
