"""Shear stress on a plane wall, as the fluid particles near it show it: of the solvent and of the polymer.

With d the distance from the wall, u - u_wall = a d + b d^2 + c d^3 + e d^4 is fitted by weighted least squares to
the particles within R = 5 spacings, weight (1 - d/R)^2 (1 + 2 d/R); u_wall is the wall's velocity at that time. The
solvent's stress is +-mu_s a. The polymer's stress is S_xy at d = 0 in a parabola fitted in the same way to the same
particles. Nothing is assumed of the curvature at the wall, which a body acceleration, an accelerating wall and a
polymer give the profile. For exact fields the errors fall with the fourth (a) and third (S_xy) power of the spacing.

The quartic term is for thin layers: without it the error is of third order where u_yyyy differs from 0 at the wall,
and 0.7 % next to an oscillating wall with five spacings in its penetration depth; with it, less than 0.1 %. For S_xy
one term more would lower an error of 0.01 % that is not felt, and treble the weight of the row next to the wall, in
which an impulsive start leaves its largest error.
"""

import numpy as np

RADIUS = 5.0
"""Radius R in particle spacings: five rows of particles for four coefficients at most."""

SLIP_POWERS = np.array([1, 2, 3, 4])
STRESS_POWERS = np.array([0, 1, 2])
FREE_POWERS = np.array([0, 1, 2, 3, 4])


def wall_shear(channel, snapshot):
    """Shear stress (bottom, top) that the particles show, averaged along the walls [mass/(length time^2)].

    It is the total one, density * solvent viscosity * du/dy + S_xy.
    """
    t = snapshot.t
    bottom, top = snapshot.y, channel.gap - snapshot.y
    rate_bottom = _rate(channel, bottom, channel.bottom, snapshot.u, t)
    rate_top = -_rate(channel, top, channel.top, snapshot.u, t)
    solvent = channel.viscous_stress(rate_bottom), channel.viscous_stress(rate_top)
    if channel.polymer is None:
        return solvent
    return tuple(
        stress + _coefficients(channel, distance, snapshot.stress_xy, STRESS_POWERS)[0]
        for stress, distance in zip(solvent, (bottom, top), strict=True)
    )


def wall_shear_error(sample):
    """Error of the wall shear in a sample's numbers: the larger one of the two walls, relative; None without one.

    Both are taken relative to the larger of the two exact stresses. A wall that the flow has not reached yet has
    a stress of next to nothing, and a ratio to that would tell nothing about the forces on the channel.
    """
    names = ("wall_shear_bottom", "wall_shear_top")
    numbers = [sample[name + ending] for name in names for ending in ("", "_exact")]
    if None in numbers:
        return None
    bottom, bottom_exact, top, top_exact = numbers
    scale = max(abs(bottom_exact), abs(top_exact))
    return max(abs(bottom - bottom_exact), abs(top - top_exact)) / scale if scale > 0 else None


def wall_velocity(channel, side, snapshot):
    """Velocity of the bottom (``side`` 0) or top wall (1) that the particles show, where it is not given."""
    distance = channel.gap - snapshot.y if side else snapshot.y
    return _coefficients(channel, distance, snapshot.u, FREE_POWERS)[0]


def _rate(channel, distance, wall, velocity, t):
    """Velocity gradient away from a wall; at a stress-controlled wall its velocity is that of the particles."""
    if wall.stress_controlled:
        return _coefficients(channel, distance, velocity, FREE_POWERS)[1] / (RADIUS * channel.spacing)
    return _slope(channel, distance, velocity - wall.velocity(t))


def _slope(channel, distance, slip):
    """Slope a at distance 0 of ``slip``, the velocity relative to the wall."""
    return _coefficients(channel, distance, slip, SLIP_POWERS)[0] / (RADIUS * channel.spacing)


def _coefficients(channel, distance, values, powers):
    """Least-squares coefficients of the ``powers`` of distance/radius."""
    radius = RADIUS * channel.spacing
    near = distance < radius
    fraction = distance[near] / radius
    root_weight = (1 - fraction) * np.sqrt(1 + 2 * fraction)
    basis = root_weight[:, None] * fraction[:, None] ** powers
    return np.linalg.lstsq(basis, root_weight * values[near], rcond=None)[0]


def integral(times, velocities):
    """Return the integral from the first of ``times`` to each of them, by a smooth curve through ``velocities``."""
    from scipy.interpolate import PchipInterpolator  # of no use to most runs

    return PchipInterpolator(times, velocities).antiderivative()(times) if len(times) > 1 else np.zeros(len(times))
