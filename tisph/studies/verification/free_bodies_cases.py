"""Runs of bodies that the flow carries, as configs in plain dicts: at rest, released, driven, turned by shear.

Every fluid has a density of 1. What a slow flow is compared with was computed by spectral least squares and by finite
elements, which agree to 1e-6, if no other source is named.
"""

import math

import numpy as np

from tisph.studies.flows import across, at_times, merged, state, walls
from tisph.studies.verification.bodies import CELL, FREE_ROTATION, FREE_STRESS, RESISTANCES

VISCOSITY = 10.0
"""Of slow flows, of velocities and lengths of about 1: the Reynolds number of a body is at most 0.05."""

MOST_VISCOUS = 1000.0
"""Where places or angles matter: a flow sets up before its bodies move by more than 1e-4."""

SETTLED = 0.3 / MOST_VISCOUS
"""Time in which it does, where only what is around the bodies has to."""

DENSITIES = (0.0, 0.1, 0.5, 2.0, 1000.0)

FIRST, EARLY = 1e-5, 0.01
"""Times at which a released body is looked at: after the first steps, and while it still has hardly moved."""

IN_SHEAR = {
    "free_shear": (0.1, 1.0, 50, FREE_ROTATION, FREE_STRESS),
    "free_shear_long": (0.1, 2.0, 50, -0.488806, 1.033948),
    "free_shear_large": (0.125, 2.0, 50, -0.482223, 1.055395),
    "free_shear_large_25": (0.125, 2.0, 25, -0.482223, 1.055395),
}
"""Radius, length of the cell, particles across the gap of 1; angular velocity over shear rate, stress of the walls over
dynamic viscosity and shear rate."""

SETTLING = {"settling": (0.0, 0.1334535, 0.0604568), "settling_without_flux": (-7.271605, 0.0455299, 0.0)}
"""Acceleration that drives the fluid; velocity of a circle of radius 0.125 and flow rate between walls 1 apart, 2 long,
for a force equal to dynamic viscosity: with a periodic pressure the fluid is dragged along, by walls alone held; what
lets no fluid through on the whole slows the circle to a third."""

PAIR_VELOCITY, PAIR_ROTATION, PAIR_STRESS = (0.0895720, 0.00106243), -0.461254, 1.071856
"""Of the first of a pair of circles in shear of rate 1; the second has the opposite velocity."""

ANGLES = (0, 45, 90)
"""Degrees from the walls to the long axis of an ellipse."""

DRAWN = (1.0, 3.0)
"""Densities of bodies that are drawn apart."""

REYNOLDS = {1: (32, 48), 5: (32, 48), 20: (48, 64)}
"""Particles across the gap by shear rate * radius^2 / kinematic viscosity: 32 do not resolve the layer at 20."""


def free_circle(x, y, radius, **keys):
    """A circle that the flow carries, with other ``keys`` of it."""
    return {"type": "circle", "centre": [x, y], "radius": radius, "motion": "free", **keys}


def fluid(viscosity):
    """A fluid with particles off an even arrangement by up to a fifth of a spacing."""
    return {"fluid": {"density": 1.0, "kinematic_viscosity": viscosity}, "initial": {"jitter": 0.2, "seed": 0}}


def in_shear(viscosity, length, number, *bodies):
    """Bodies in a gap of 1 with shear of rate 1, which starts with the linear profile, ``number`` particles across."""
    cell = {"scene": "channel", "geometry": {"gap": 1.0, "length": length}, "bodies": [*bodies]}
    return merged(fluid(viscosity), cell, walls(-0.5, 0.5), state("developed"), across(number))


def _in_lattice(viscosity, number, drive, *bodies):
    return merged(fluid(viscosity), {"scene": "lattice"}, CELL, {"bodies": [*bodies], "drive": drive}, across(number))


def _at_rest(drive):
    return merged(_in_lattice(0.01, 20, drive, free_circle(0.5, 0.5, 0.2)), at_times([0.1, 1.0]))


def _released(density):
    """In a fluid of almost no viscosity, whose layer is 1e-3 of a radius thin at the end, by 4 sqrt(nu t/pi)."""
    body = free_circle(0.5, 0.5, 0.25, density=density)
    return merged(_in_lattice(1e-8, 48, {"gravity": [0.0, -1.0]}, body), at_times([FIRST, EARLY]))


def _driven(fraction, number, end):
    """A body against a fluid of opposite momentum, as fast as that of an array with a velocity of 1."""
    force, radius = VISCOSITY * RESISTANCES[fraction], round(math.sqrt(fraction / math.pi), 8)
    body = free_circle(0.5, 0.5, radius, force=[force, 0.0])
    return merged(_in_lattice(VISCOSITY, number, {"acceleration": -force}, body), at_times([end]))


def _sheared(name):
    radius, length, number, *_ = IN_SHEAR[name]
    return merged(in_shear(VISCOSITY, length, number, free_circle(0.5 * length, 0.5, radius)), at_times([0.02]))


def _settling(acceleration):
    body = free_circle(1.0, 0.5, 0.125, force=[VISCOSITY, 0.0])
    changes = walls(0.0, 0.0), {"drive": {"acceleration": acceleration}}, at_times([1.0 / VISCOSITY])
    return merged(in_shear(VISCOSITY, 2.0, 40, body), *changes)


def _ellipse(degrees):
    angle = round(math.radians(degrees), 10)
    body = {"type": "ellipse", "centre": [1.0, 0.5], "angle": angle, "half_axes": [0.15, 0.075], "motion": "free"}
    return merged(in_shear(MOST_VISCOUS, 2.0, 80, body), at_times([SETTLED]))


def _apart(density):
    """Two circles that equal forces draw in opposite directions, past one another again and again."""
    ways = ((0.3, 0.02), (0.7, -0.02))
    bodies = [free_circle(at, at, 0.1, density=density, force=[force, 0.0]) for at, force in ways]
    return merged(_in_lattice(0.01, 32, {}, *bodies), at_times(np.linspace(0.06, 6.0, 100)))


def _at_reynolds(reynolds, number):
    return merged(in_shear(0.04 / reynolds, 1.0, number, free_circle(0.5, 0.5, 0.2)), at_times([8.0]))


UNIFORM = merged(
    in_shear(0.01, 1.0, 20, free_circle(0.5, 0.5, 0.2, velocity=[1.0, 0.0])), walls(1.0, 1.0), at_times([0.1, 1.0])
)

QUICK = {
    "free_at_rest": _at_rest({"gravity": [0.0, -1.0]}),
    "free_falling": _at_rest({"acceleration": 1.0}),
    "free_uniform": UNIFORM,
    "released_0.1": _released(0.1),
    "free_shear": _sheared("free_shear"),
}

FULL = {
    **QUICK,
    **{f"released_{density:g}": _released(density) for density in DENSITIES},
    "driven_0.05": _driven(0.05, 80, 0.05),
    "driven_0.2": _driven(0.2, 40, 0.03),
    "driven_0.4": _driven(0.4, 28, 0.03),
    **{name: _sheared(name) for name in IN_SHEAR},
    "held_from_turning": merged(
        in_shear(VISCOSITY, 1.0, 50, free_circle(0.5, 0.5, 0.1, hold=["x", "y", "angle"])), at_times([0.02])
    ),
    **{name: _settling(acceleration) for name, (acceleration, *_) in SETTLING.items()},
    "pair": merged(
        in_shear(MOST_VISCOUS, 2.0, 50, free_circle(1.2, 0.6, 0.1), free_circle(0.8, 0.4, 0.1)), at_times([SETTLED])
    ),
    **{f"ellipse_{degrees}": _ellipse(degrees) for degrees in ANGLES},
    **{f"drawn_apart_{density:g}": _apart(density) for density in DRAWN},
    **{
        f"free_re_{reynolds}_{number}": _at_reynolds(reynolds, number)
        for reynolds in REYNOLDS
        for number in REYNOLDS[reynolds]
    },
}
