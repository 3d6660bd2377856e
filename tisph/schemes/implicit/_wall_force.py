"""What the walls do to the liquid, for the balance of momentum along the channel.

By the shear stress at the wall, once layers are resolved: with the distance d from a wall, over the density, it is
A + a d + B d^2 there, where a = U' - g follows from the momentum equation; A and B are fitted to the stresses of the
particles near the wall, and the wall pulls with -A. In the first moments after a jump there is no such gradient yet:
then by what the ghosts do to the particles, which is exact on a lattice, and in disorder off by some per cent, since
rows of least-squares operators do not conserve momentum pair by pair.
"""

import numpy as np

from tisph.runtime import view
from tisph.schemes.implicit._esdirk import TIMES, WEIGHTS


class WallForce:
    """Fits the mean velocities of a step."""

    def __init__(self, viscous, channel):
        self.viscous, self.operators, self.ghosts = viscous, viscous.operators, viscous.ghosts
        self.channel = channel

    def impulse(self, time, length, resolved):
        """Return the velocity that the (bottom, top) wall gives in a step, summed over the particles.

        ``resolved``: whether there are gradients at the walls to go by.
        """
        viscous, channel, ghosts = self.viscous, self.channel, self.ghosts
        walls = viscous.wall_series.walls
        stages = [(weight, time + part * length) for part, weight in zip(TIMES, WEIGHTS, strict=True)]
        ghosts.prescribe(*sum(weight * np.array(viscous.wall_series(moment)) for weight, moment in stages))
        mean = view(viscous.mean)
        beyond = ghosts.part(mean)
        beyond[...] = ghosts.given() - ghosts.taken(mean)
        if not resolved:
            differences = beyond[ghosts.listed] - mean[ghosts.near[ghosts.row]]
            return [length * float(pull) for pull in self.pulls(differences, stages)]
        relative = [sum(weight * self.acceleration(wall, moment) for weight, moment in stages) for wall in walls]
        rise = [rate - channel.acceleration for rate in relative]
        stress = self.stress(self.operators.apply_to(ghosts.near, self.operators.d_dy, mean))
        rises = np.stack([stress, -stress]) - np.array(rise)[:, None] * ghosts.offset
        area = channel.length / channel.spacing**2
        stresses = [_intercept(*fit, ghosts.reach) for fit in zip(ghosts.offset, rises, strict=True)]
        return [-length * area * stress for stress in stresses]

    def acceleration(self, wall, time):
        """Return the acceleration of a wall."""
        return wall.acceleration(time)

    def stress(self, shear_rate):
        """Return the mean shear stress over the density of the particles near walls, by their mean ``shear_rate``."""
        return self.channel.kinematic_viscosity * shear_rate

    def pulls(self, differences, stages):
        """Return what images beyond the (bottom, top) wall do, ``differences`` being those of the mean velocities.

        ``stages``: weights and times of the stages of the step.
        """
        return self.channel.kinematic_viscosity * self.ghosts.sums(self.operators.laplacian, differences)[1]


def _intercept(distance, slope, reach):
    """Return A of the least-squares fit A + B d^2 to values within ``reach`` of a wall; without particles, 0."""
    near = distance < reach
    square, slope = distance[near] ** 2, slope[near]
    second, fourth = square.sum(), (square * square).sum()
    determinant = square.size * fourth - second * second
    return float(slope.sum() * fourth - (square * slope).sum() * second) / determinant if determinant > 0.0 else 0.0
