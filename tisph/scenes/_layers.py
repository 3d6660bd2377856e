"""How deep what starts at a wall has come by a time, in any fluid."""

import math

from tisph.exact._sheared import STEP
from tisph.exact.start_up import fluid_of
from tisph.geometry.motion import Schedule

FIXED_POINT = 20
"""Iterations for a depth; each reduces its error to a third or less."""


def age(wall, t):
    """Time since a ``wall`` that starts at t = 0 changed last before ``t``; infinite where it has only kinks."""
    if isinstance(wall, Schedule):
        return wall.age(t)
    return t - max((change for change in wall.jump_times if change < t), default=0.0)


def spreading_viscosity(scene, t):
    """Kinematic viscosity nu by which a wall's motion has spread to a depth sqrt(nu t) in the time ``t``.

    Of an inelastic fluid it is the slope of the shear stress at the rate that is the largest speed over that depth.
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
