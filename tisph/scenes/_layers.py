"""How deep the motion of a wall that starts has spread by a time, in any fluid."""

import math
from dataclasses import dataclass

from tisph.exact._sheared import STEP
from tisph.exact.start_up import fluid_of
from tisph.geometry.motion import Schedule

FAINT = 0.015
"""Part of a jump that counts no more: velocities of a resolved sample may have this error (measures/resolution.py)."""


@dataclass(frozen=True)
class PolymerParameters:
    """Of a polymer: relaxation time [time], and the share of the solvent in the total viscosity."""

    relaxation_time: float
    solvent_fraction: float

    @classmethod
    def of(cls, rheology):
        """Return the parameters of the first relaxation mode of a ``rheology``; None without polymer."""
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


FIXED_POINT = 20
"""Iterations for a depth; each reduces its error to a third or less."""


def age(wall, t):
    """Time since a ``wall`` that starts at t = 0 changed last before ``t``; infinite where it has only kinks."""
    if isinstance(wall, Schedule):
        return wall.age(t)
    return t - max((change for change in wall.jump_times if change < t), default=0.0)


def spreading_viscosity(scene, t):
    """Kinematic viscosity nu by which a wall's motion has spread to a depth sqrt(nu t) in the time ``t``.

    In an inelastic fluid it is d(stress)/d(shear rate) divided by the density, at the shear rate U/sqrt(nu t).
    """
    viscosity = scene.kinematic_viscosity
    if scene.polymer:
        return viscosity * scene.polymer.diffusive_fraction(t)
    if scene.rheology and t > 0.0:
        fluid, speed = fluid_of(scene.rheology, viscosity, scene.density), scene.reference_velocity
        for _ in range(FIXED_POINT):
            rate = speed / math.sqrt(viscosity * t)
            viscosity = (fluid.flux(rate + 1j * STEP) / STEP).imag
    return viscosity


def depth(scene, t):
    """Depth [length] of the layer at what started a time ``t`` ago."""
    return math.sqrt(spreading_viscosity(scene, t) * t)
