"""The step of a liquid between walls one of which a stress drives; see ``_plate.py`` and ``_heavy.py``."""

import numpy as np

from tisph.runtime import holding, real, scalar, ti
from tisph.schemes.implicit._elastic_solver import ElasticSolver
from tisph.schemes.implicit._elastic_wall_force import ElasticWallForce
from tisph.schemes.implicit._viscoelastic import ViscoelasticStep


class PlateSolver(ElasticSolver):
    """``ElasticSolver`` whose mirror images are even beyond the driven wall."""

    def __init__(self, rows, ghosts, channel):
        ghosts.turned = tuple(side == channel.driven_side for side in range(2))
        self.turned = holding(ti.field(real(), 2), [-1.0 if turned else 1.0 for turned in ghosts.turned])
        self.turned.used = None  # for checkpoints
        self.middle = scalar(channel.gap / 2.0)
        super().__init__(rows, ghosts, channel)

    @ti.func
    def own_sign(self, k):
        """Return 1, or -1 for a ghost beyond the driven wall."""
        upper = ti.cast(self.points.position[self.points.capacity + k].y > self.middle[None], ti.i32)
        return self.turned[upper]

    @ti.func
    def reflect(self, values, k):
        """Give ghost ``k`` its value."""
        values[self.points.capacity + k] = self.parity * self.own_sign(k) * self.ghosts.value(values, k)

    @ti.func
    def reflect_pull(self, k):
        """Give ghost ``k`` its ``pull``."""
        self.pull[self.points.capacity + k] = self.own_sign(k) * self.ghosts.value(self.pull, k)

    def more(self, side, slope, third):
        """Return what each image beyond one wall has of the stress more than its source (ghosts).

        Beyond the driven wall ``slope`` is the stress there, and ``third`` its second derivative.
        """
        if not self.ghosts.turned[side]:
            return super().more(side, slope, third)
        return np.where(self.ghosts.side == side, 2.0 * slope + self.ghosts.depth**2 * third, 0.0)


class DrivenWallForce(ElasticWallForce):
    """``ElasticWallForce`` that knows what the driven wall does."""

    def acceleration(self, wall, time):
        """Return the acceleration of a wall; that of the driven one does not count."""
        return 0.0 if wall.driven else super().acceleration(wall, time)

    def impulse(self, time, length, resolved):
        """Return the velocity that the (bottom, top) wall gives in a step, summed over the particles."""
        pulls, plate = super().impulse(time, length, resolved), self.viscous.walls.plate
        area = self.channel.length / self.channel.spacing**2
        pulls[plate.side] = -plate.towards * length * area * plate.mean_stress
        return pulls


class DrivenStep(ViscoelasticStep):
    """``ViscoelasticStep`` with a wall that a stress drives."""

    def begin_with(self, heights):
        """Take up the states of particles at ``heights`` (fluid,) at the start."""
        super().begin_with(heights)
        self.walls.plate.forget()

    def wall_force(self):
        """Return what measures the impulses of the walls."""
        return DrivenWallForce(self, self.channel)
