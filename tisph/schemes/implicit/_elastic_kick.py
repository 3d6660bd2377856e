"""What a wall that starts at once does to a liquid with memory: ``_kick.py`` with the stress beside the velocity.

With y the velocities, the states of the particles, and those at the walls (``_elastic_walls.py``), the discrete
equations are y' = M y + B_1 U' + B_2 U'' + ...: a velocity that jumps by J changes y by (B_1 + M B_2) J, an
acceleration relative to the drive that jumps by J_1 by B_2 J_1. All is linearised about the liquid at the wall.
"""

import numpy as np

from tisph.neighbours.points import used
from tisph.schemes.implicit._kick import Kick


class ElasticKick(Kick):
    """Applies the jumps of the walls to the velocities and states of a ``ViscoelasticStep``."""

    def apply(self, velocity_jumps, acceleration_jumps):
        """Change velocities and states; return the velocity gained from the (bottom, top) wall, summed."""
        step, gains = self.viscous, [0.0, 0.0]
        places = step.near_walls()
        for side, (jump, rate) in enumerate(zip(velocity_jumps, acceleration_jumps, strict=True)):
            if jump != 0.0 or rate != 0.0:
                gained, strain, more, first, third = self.changes(side, jump, rate, *places[side])
                used(step.velocity)[0] += gained
                step.memory.strain(used(step.state), strain)
                used(step.state)[...] += more
                step.walls.first[side] += first
                step.walls.third[side] += third
                gains[side] = float(gained.sum(dtype=float))
        return gains

    def changes(self, side, jump, rate, state, shear_rate):
        """Return the velocities gained, the strain of the liquid in that moment, what relaxes of the states meanwhile,
        and the changes of first and third slopes of C at a wall."""
        step, nu, rows = self.viscous, self.viscosity, self.viscous.rows
        decay, pull, stress = step.memory.slopes(state, shear_rate)
        modulus = float(stress @ pull)
        fourth = [0.0, 0.0, 1.0 / (12.0 * nu**2)]  # of the series, for U'' = 1
        back = -modulus / (12.0 * nu**3)  # what it becomes by the stress in the next moment, twice
        velocity_2 = nu * self.spread(fourth, side, rows.laplacian)
        sheared_2 = self.spread(fourth, side, rows.across)
        third_2 = pull / nu**2
        direct = [0.0, 1.0 / nu, 2.0 * back]
        velocity = nu * (self.spread(direct, side, rows.laplacian) + self.laplacian(velocity_2))
        velocity += step.solver.slopes(modulus * sheared_2, 1.0) + step.from_images(side, 0.0, stress @ third_2)
        sheared = self.spread(direct, side, rows.across) + step.solver.slopes(velocity_2, -1.0)
        relaxing = np.multiply.outer(decay @ pull, jump * sheared_2)
        first = jump * pull / nu
        third = jump * (-modulus / nu * third_2 + (decay - np.outer(pull, stress) / nu) @ third_2) + rate * third_2
        return jump * velocity + rate * velocity_2, jump * sheared + rate * sheared_2, relaxing, first, third

    def spread(self, series, side, rows):
        """Return the sums over the images of one wall, with the values that the series gives them, (fluid)."""
        both = [[0.0] * 3, [0.0] * 3]
        both[side] = series
        self.ghosts.prescribe(*both)
        sums = np.zeros(self.viscous.points.fluid)
        sums[self.ghosts.near] = self.ghosts.sums(rows, self.ghosts.given()[self.ghosts.listed])[0]
        return sums
