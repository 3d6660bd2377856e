"""What the walls do to the liquid, for the balance of momentum along the channel.

By the velocity gradient at the wall, once layers are resolved: with the distance d from a wall, u_d = A + w_2 d + B d^2
there, where w_2 = (U' - g)/nu follows from the momentum equation; A and B are fitted to the gradients of the particles
near the wall, and the wall pulls with -nu A. In the first moments after a jump there is no such gradient yet: then by
what the ghosts do to the particles, which is exact on a lattice, and in disorder off by some per cent, since rows of
least-squares operators do not conserve momentum pair by pair.
"""

import numpy as np

from tisph.runtime import view
from tisph.schemes.implicit._esdirk import TIMES, WEIGHTS


class WallForce:
    """Fits the mean velocities of a step."""

    def __init__(self, viscous, channel):
        self.viscous, self.rows, self.ghosts = viscous, viscous.rows, viscous.ghosts
        self.channel = channel
        self.walls = (channel.bottom, channel.top)

    def impulse(self, time, length, resolved):
        """Return the velocity that the (bottom, top) wall gives in a step, summed over the particles.

        ``resolved``: whether there are gradients at the walls to go by.
        """
        viscous, channel, ghosts = self.viscous, self.channel, self.ghosts
        stages = [(weight, time + part * length) for part, weight in zip(TIMES, WEIGHTS, strict=True)]
        ghosts.prescribe(*sum(weight * np.array(viscous.wall_series(moment)) for weight, moment in stages))
        mean = view(viscous.mean)
        beyond = ghosts.part(mean)
        beyond[...] = ghosts.given() - ghosts.taken(mean)
        if not resolved:
            differences = beyond[ghosts.listed] - mean[ghosts.near[ghosts.row]]
            pulls = ghosts.sums(self.rows.laplacian, differences)[1]
            return [channel.kinematic_viscosity * length * float(pull) for pull in pulls]
        relative = [sum(weight * wall.acceleration(moment) for weight, moment in stages) for wall in self.walls]
        second = [(rate - channel.acceleration) / channel.kinematic_viscosity for rate in relative]
        slope = self.rows.apply_to(ghosts.near, self.rows.across, mean)
        rises = np.stack([slope, -slope]) - np.array(second)[:, None] * ghosts.offset
        area = channel.length / channel.spacing**2
        slopes = [_intercept(*fit, ghosts.reach) for fit in zip(ghosts.offset, rises, strict=True)]
        return [-channel.kinematic_viscosity * length * area * slope for slope in slopes]


def _intercept(distance, slope, reach):
    """Return A of the least-squares fit A + B d^2 to slopes within ``reach`` of a wall; without particles, 0."""
    near = distance < reach
    square, slope = distance[near] ** 2, slope[near]
    second, fourth = square.sum(), (square * square).sum()
    determinant = square.size * fourth - second * second
    return float(slope.sum() * fourth - (square * slope).sum() * second) / determinant if determinant > 0.0 else 0.0
