"""A body force that somebody gives as a function, in a box without walls: evaluated on the host in each step."""

import numpy as np

from tisph.runtime import view


class BodyForce:
    """Accelerations ``function(x, y, t)`` of the ``particles`` in the middle of each step."""

    def __init__(self, function, particles, extent):
        self.function, self.particles, self.extent = function, particles, extent
        self.values, self.largest = None, 0.0

    def evaluate(self, now, middle):
        """Take the accelerations (fluid, 2) at the time ``middle`` of the pending step, whose buffer is ``now``."""
        x, y = (view(self.particles.mid_position)[now, : self.particles.fluid] % self.extent).T
        self.values = np.stack(self.function(x, y, middle), axis=1)
        self.largest = float(np.hypot(*self.values.T).max())

    def apply(self, now, length, half):
        """Add them to the step of ``length`` that is in the buffer ``now``, and to the ``half`` step after it."""
        fluid, given = self.particles.fluid, self.values
        view(self.particles.velocity)[now, :fluid] += length * given
        view(self.particles.mid_velocity)[now, :fluid] += (length + half) * given
        view(self.particles.mid_position)[now, :fluid] += half * length * given
