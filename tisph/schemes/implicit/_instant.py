"""A liquid whose viscosity depends on the shear rate of the moment: what a stage asks of it, beside ``_memory.py``.

The stress beyond that of the constant viscosity nu in ``fluid`` takes the part of a polymer's, S_xy = (viscosity(u_y^2)
- nu) u_y, with nothing to remember: so the systems are solvable where the viscosity varies by orders of magnitude.
"""

import numpy as np

from tisph.schemes._pointwise import SMALL
from tisph.schemes.implicit._memory import Memory


class Instant:
    """A law without memory, with the methods of ``Memory``; its states have no numbers, (0, ...)."""

    components = 0

    def __init__(self, law, kinematic_viscosity):
        self.law, self.constant = law, kinematic_viscosity

    def start(self, channel, heights):
        """Return the states at ``heights``."""
        return np.zeros((0, np.size(heights)))

    def stress(self, state):
        """Return no stress that particles carry."""
        return ()

    def shear_stress(self, state, shear_rate):
        """Return S_xy."""
        return (self.law.viscosity(shear_rate * shear_rate) - self.constant) * shear_rate

    def rate(self, state, shear_rate):
        """Return the time derivatives of no states."""
        return state

    def respond(self, known, duration, shear_rate, guess):
        """Return no states, and dS_xy/d shear_rate."""
        return known, self._slope(shear_rate)

    def linear(self, state, duration, shear_rate, defect):
        """Return the stress that no states leave."""
        return np.zeros_like(shear_rate)

    def slopes(self, state, shear_rate):
        """Return derivatives as ``Memory.slopes``."""
        nothing = np.zeros(0)
        return np.zeros((0, 0)), nothing, nothing, float(self._slope(shear_rate))

    def strain(self, state, strain):
        """Shear no states at once."""

    def lost(self, state):
        """Return the particles without a positive conformation: none."""
        return np.zeros(0, dtype=int)

    def _slope(self, shear_rate):
        return np.imag(self.shear_stress(None, shear_rate + 1j * SMALL)) / SMALL


def material(rheology, channel):
    """Return what a liquid other than a Newtonian one answers with: ``Memory``, or ``Instant``."""
    if rheology.carries_stress:
        return Memory(rheology, channel.kinematic_viscosity)
    return Instant(rheology.law(channel.kinematic_viscosity, channel.density), channel.kinematic_viscosity)
