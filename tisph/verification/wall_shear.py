"""Shear stress on a plane wall, as the fluid particles near it show it.

With d the distance from the wall, u - u_wall = a d + b d^2 + c d^3 is fitted by weighted least squares to
the particles within R = 4 spacings, weight (1 - d/R)^2 (1 + 2 d/R); the stress is mu du/dy = +-mu a. For
exact velocities the error falls with the fourth power of the spacing where u is odd about the wall, as next
to a wall that moves steadily, and with the third elsewhere; without c it would fall with the second only.
"""

import numpy as np

RADIUS = 4.0
"""Radius R in particle spacings: four rows of particles for three coefficients."""


def wall_shear(channel, snapshot):
    """Shear stress mu du/dy (bottom, top) from the velocities of the particles, averaged along the walls."""
    bottom = _slope(channel, snapshot.y, snapshot.u - channel.bottom_velocity)
    top = -_slope(channel, channel.gap - snapshot.y, snapshot.u - channel.top_velocity)
    return channel.dynamic_viscosity * bottom, channel.dynamic_viscosity * top


def _slope(channel, distance, slip):
    """Slope a at distance 0 of ``slip``, the velocity relative to the wall."""
    radius = RADIUS * channel.spacing
    near = distance < radius
    fraction = distance[near] / radius
    root_weight = (1 - fraction) * np.sqrt(1 + 2 * fraction)
    basis = root_weight[:, None] * fraction[:, None] ** np.array([1, 2, 3])
    return np.linalg.lstsq(basis, root_weight * slip[near], rcond=None)[0][0] / radius
