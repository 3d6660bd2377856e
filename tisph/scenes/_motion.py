"""How a wall moves, and what a polymer adds to a fluid: small parts of a scene."""

import math
from dataclasses import dataclass

from tisph.geometry.motion import WallMotion

__all__ = ["PolymerParameters", "WallMotion"]

FAINT = 0.015
"""Part of a jump that counts no more: velocities of a resolved sample may have this error (measures/resolution.py)."""


@dataclass(frozen=True)
class PolymerParameters:
    """Of a polymer: relaxation time [time], and the share of the solvent in the total viscosity."""

    relaxation_time: float
    solvent_fraction: float

    @classmethod
    def of(cls, rheology):
        """What stands first of it for a ``rheology`` with polymer; None for others."""
        if rheology and rheology.carries_stress:
            return cls(rheology.relaxation_time, rheology.solvent_fraction)
        return None

    def diffusive_fraction(self, t):
        """Share of the total viscosity by which what starts at t = 0 has spread at time ``t``.

        At first there is the front of a shear wave, of which exp(-t/(2 relaxation_time)) is left (Maxwell's fluid: the
        damped wave equation u_tt + u_t/relaxation_time = modulus u_yy), and which the solvent alone spreads: until less
        than ``FAINT`` is left.
        """
        return self.solvent_fraction if math.exp(-0.5 * t / self.relaxation_time) >= FAINT else 1.0
