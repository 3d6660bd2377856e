"""What the walls do to the fluid, for the balance of momentum along the channel.

By the shear stress at the wall, once layers are resolved: with the distance d from a wall, per unit density, it is
A + a d + B d^2 there, where a = U' - g follows from the momentum equation; A and B are fitted to the stresses of the
particles near the wall, and the wall pulls with -A. In the first moments after a jump there is no such gradient yet:
then by what the ghosts do to the particles, which is exact on a lattice, and for disordered particles off by some per
cent, since least-squares operators do not conserve momentum pair by pair. The force of a stress-controlled wall is
known.
"""

import numpy as np

from tisph.schemes._stages.esdirk import B, C


class WallForce:
    """Fits the mean velocities and extra stresses of the last step of an ``ImplicitStep``."""

    def __init__(self, step, channel):
        self.step, self.operators, self.ghosts, self.channel = step, step.operators, step.ghosts, channel
        self.viscosity, self.area = channel.solvent_viscosity, channel.length / channel.spacing**2

    def impulse(self, time, dt, resolved):
        """Return the velocity that the (bottom, top) wall gives in a step, summed over the particles.

        ``resolved``: whether there are gradients at the walls to go by.
        """
        walls, ghosts = self.step.walls, self.ghosts
        ghosts.prescribe(*self.mean(walls.series))
        mean = np.zeros(ghosts.points.slots + 1)
        mean[: ghosts.points.fluid] = self.step.stages.mean_velocity
        beyond = ghosts.part(mean)
        beyond[...] = ghosts.boundary_values() - ghosts.source_values(mean)
        if resolved:
            fitted = zip(walls, self.fitted_stresses(mean, time, dt), strict=True)
            forces = [-wall.normal_sign * self.area * stress for wall, stress in fitted]
        else:
            forces = self.from_images(beyond[ghosts.listed] - mean[ghosts.near[ghosts.row]])
        wall = walls.stress_controlled
        if wall:
            forces[wall.side] = -wall.normal_sign * self.area * wall.mean_stress
        return [dt * float(force) for force in forces]

    def mean(self, of_stage):
        """Return the mean over the step of what ``of_stage`` gives at each stage."""
        return sum(weight * np.array(of_stage(stage)) for stage, weight in enumerate(B))

    def fitted_stresses(self, mean, time, dt):
        """Return the shear stress at the (bottom, top) wall."""
        ghosts = self.ghosts
        stress = self.viscosity * self.operators.apply_to(ghosts.near, self.operators.d_dy, mean)
        if self.step.stages.mean_stress is not None:
            stress = stress + self.step.stages.mean_stress[ghosts.near]
        found = []
        for wall, distance in zip(self.step.walls, ghosts.offset, strict=True):
            slope = sum(weight * wall.acceleration(time + c * dt) for c, weight in zip(C, B, strict=True))
            rise = wall.normal_sign * (slope - self.channel.acceleration) * distance
            found.append(_intercept(distance, stress - rise, ghosts.cutoff))
        return found

    def from_images(self, differences):
        """Return what images beyond the (bottom, top) wall do, ``differences`` being those of the mean velocities."""
        step, ghosts, stress = self.step, self.ghosts, self.step.stages.mean_stress
        viscous = self.viscosity * ghosts.sums(self.operators.laplacian, differences)[1]
        if stress is None:
            return viscous
        series = self.mean(step.walls.stress_series)
        more = sum(step.closed_operators.image_stress(side, *series[side]) for side in range(2))
        images = step.closed_operators.close(stress, 1.0) + more
        # first derivatives are odd: what pairs of particles leave of each other is the sum over the images
        both = images[ghosts.listed] + stress[ghosts.near[ghosts.row]]
        return viscous + ghosts.sums(self.operators.d_dy, both)[1]


def _intercept(distance, stress, radius):
    """Return A of the least-squares fit A + B d^2 to values within a ``radius`` of a wall; without particles, 0."""
    near = distance < radius
    square, stress = distance[near] ** 2, stress[near]
    second, fourth = square.sum(), (square * square).sum()
    determinant = square.size * fourth - second * second
    return float(stress.sum() * fourth - (square * stress).sum() * second) / determinant if determinant > 0.0 else 0.0
