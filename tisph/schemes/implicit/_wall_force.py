"""What the walls do to the liquid, for the balance of momentum along the channel.

By the velocity gradient at the wall, once layers are resolved: with the distance d from a wall, u_d = A + w_2 d + B d^2
there, where w_2 = (U' - g)/nu follows from the momentum equation; A and B are fitted to the gradients of the particles
near the wall, and the wall pulls with -nu A. In the first moments after a jump there is no such gradient yet: then by
what the ghosts do to the particles, which is exact on a lattice, and in disorder off by some per cent, since rows of
least-squares operators do not conserve momentum pair by pair.
"""

import numpy as np

from tisph.runtime import real, ti, view
from tisph.schemes.implicit._esdirk import TIMES, WEIGHTS


@ti.data_oriented
class WallForce:
    """Fits the mean velocities of a step."""

    def __init__(self, viscous, channel):
        self.viscous, self.rows, self.points, self.ghosts = viscous, viscous.rows, viscous.points, viscous.ghosts
        self.channel = channel
        self.walls = (channel.bottom, channel.top)
        self.sums = ti.field(real(), (2, 5))
        self.pull = ti.field(real(), 2)

    def impulse(self, time, length, resolved):
        """Return the velocity that the (bottom, top) wall gives in a step, summed over the particles.

        ``resolved``: whether there are gradients at the walls to go by.
        """
        viscous, channel = self.viscous, self.channel
        stages = [(weight, time + part * length) for part, weight in zip(TIMES, WEIGHTS, strict=True)]
        self.ghosts.prescribe(*sum(weight * np.array(viscous.wall_series(moment)) for weight, moment in stages))
        relative = [sum(weight * wall.acceleration(moment) for weight, moment in stages) for wall in self.walls]
        self.add_up(*((rate - channel.acceleration) / channel.kinematic_viscosity for rate in relative))
        if not resolved:
            return [channel.kinematic_viscosity * length * float(pull) for pull in view(self.pull)]
        area = channel.length / channel.spacing**2
        return [-channel.kinematic_viscosity * length * area * _intercept(*row) for row in view(self.sums).tolist()]

    @ti.kernel
    def add_up(self, bottom: float, top: float):
        """Sum what the ghosts of each wall do to the particles, and what the fits need; w_2: ``bottom``, ``top``."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.viscous.mean[self.points.most + k] = self.ghosts.given(k) - self.ghosts.value(self.viscous.mean, k)
        ti.loop_config(serialize=True)
        for _ in range(1):
            for side in range(2):
                self.pull[side] = 0.0
                for term in range(5):
                    self.sums[side, term] = 0.0
            for i in range(self.points.particles[None]):
                if self.ghosts.near(i):
                    below, slope = self.points.place[i].y, self.rows.apply(self.rows.across, self.viscous.mean, i)
                    above = self.points.domain.gap[None] - below
                    for side in range(2):
                        distance = ti.select(side == 0, below, above)
                        rise = ti.select(side == 0, slope - bottom * below, -slope - top * above)
                        self.add(side, distance, rise)
                    self.add_pull(i)

    @ti.func
    def add(self, side, distance, slope):
        """Add a particle to the sums of a wall if it is near that one."""
        if distance < self.ghosts.reach[None]:
            square = distance * distance
            self.sums[side, 0] += 1.0
            self.sums[side, 1] += square
            self.sums[side, 2] += square * square
            self.sums[side, 3] += slope
            self.sums[side, 4] += square * slope

    @ti.func
    def add_pull(self, i):
        """Add what the ghosts do to a particle."""
        for k in range(self.points.count[i]):
            j = self.points.table[i, k]
            if self.points.most <= j < self.points.slots:
                difference = self.viscous.mean[j] - self.viscous.mean[i]
                self.pull[self.ghosts.side[j - self.points.most]] += self.rows.laplacian[i, k] * difference


def _intercept(count, second, fourth, total, moment):
    """Return A of the least-squares fit A + B d^2; without particles, 0."""
    determinant = count * fourth - second * second
    return (total * fourth - moment * second) / determinant if determinant > 0.0 else 0.0
