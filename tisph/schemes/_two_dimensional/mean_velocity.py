"""The pressure gradient that keeps a mean velocity, such as that of a tube which is closed at its ends.

Velocity and pressure of a step depend linearly on its acceleration g along x, and with them the mean velocity m over a
cross-section: g comes from what the last steps extrapolate to, and changes by minus (m - the one wanted)/(dm/dg) with
the outer iterations of the step, dm/dg being that of the last two of them.
"""

import numpy as np

from tisph.measures.fits import section_weights
from tisph.runtime import view

SETTLED = 0.3
"""Part of the tolerance of a step, times the velocity, that m may be off by."""


class MeanVelocityControl:
    """Finds the ``acceleration`` g along x with which a ``scene`` keeps its ``kept_mean_velocity``.

    ``response``: dm/dg over dt/gamma_0, 1 but for what pressure and viscosity take. ``levels``: pairs of a time and g
    of the last two steps, newest first.
    """

    def __init__(self, scene, boundary, splitting):
        self.scene, self.boundary, self.splitting = scene, boundary, splitting
        self.acceleration, self.response, self.levels = 0.0, 1.0, []

    def start(self, time, tolerance):
        """Give the fluid the impulse of a pressure with which it has its mean velocity at once; return whether it can.

        It is that of flow past bodies at rest, as much of it as it takes.
        """
        splitting = self.splitting
        self._take_positions(time)
        fluid, newest = slice(self.boundary.problem.n_fluid), self.boundary.regular_velocities[:, 0]
        view(splitting.velocity.x)[: len(newest)] = newest
        wanted = self.scene.kept_mean_velocity - self._mean()
        if wanted == 0.0:
            return True
        against = np.zeros_like(self.boundary.velocity)
        against[:, 0] = -1.0
        view(splitting.velocity.x)[self.boundary.slots] = against
        found, before = splitting.find_impulse(tolerance), newest[fluid].copy()
        splitting.apply_impulse()
        unit = newest[fluid] - before
        unit[:, 0] += 1.0
        newest[fluid] = before
        view(splitting.velocity.x)[fluid] = unit
        view(splitting.velocity.x)[self.boundary.slots] = 0.0
        self.response = self._mean()
        newest[fluid] += wanted / self.response * unit
        return found

    def _take_positions(self, time):
        """Let the mean velocity be that of the present positions, those of ``time``."""
        positions = self.boundary.positions + self.boundary.problem.origin
        self.time, self.weights = time, section_weights(self.scene, positions, time)

    def _mean(self):
        """Return the mean velocity by what is solved for."""
        return float(self.weights @ view(self.splitting.velocity.x)[: len(self.weights), 0].astype(float))

    def prepare(self, dt, gamma0, time, error):
        """Take up a step ``dt`` that ends at ``time``, whose velocities may have an ``error``."""
        self._take_positions(time)
        self.scale, self.tried, self.least = dt / gamma0, None, SETTLED * error
        guess = self.levels[0][1] if self.levels else 0.0
        if len(self.levels) > 1:
            (newest, g), (before, other) = self.levels
            guess += (g - other) * (time - newest) / (newest - before)
        self._accelerate(guess)

    def _accelerate(self, acceleration):
        self.acceleration = acceleration
        self.splitting.accelerate(acceleration)

    def correct(self):
        """Change the acceleration by the mean velocity that comes of it; return whether there is no need to."""
        mean, wanted = self._mean(), self.scene.kept_mean_velocity
        if self.tried and self.acceleration != self.tried[0]:
            slope = (mean - self.tried[1]) / (self.acceleration - self.tried[0]) / self.scale
            self.response = slope if slope > 0.0 else self.response
        if not abs(mean - wanted) > self.least:
            return True
        self.tried = self.acceleration, mean
        self._accelerate(self.acceleration + (wanted - mean) / (self.response * self.scale))
        return False

    def accept(self):
        """Let the acceleration of a step be the newest."""
        self.levels = [(self.time, self.acceleration), *self.levels][:2]

    def state(self):
        """Return what a resumed run needs."""
        return self.acceleration, self.response, self.levels

    def restore(self, state):
        """Take up what ``state`` returned."""
        self.acceleration, self.response, self.levels = state
