"""Walls that start, or whose acceleration starts, at once: the impulse on the liquid through the ghosts' series.

A wall whose velocity jumps by J has U' = J delta(t) and U'' = J delta'(t); one whose acceleration relative to the
drive jumps by J_1 has U'' = J_1 delta(t). Put into the ghosts' series (``_ghosts.py``) and integrated over the jump,
they change the velocities once, at the start, by

    du = J (g_2 + A g_4) + J_1/nu g_4,    g_2k = sum of the row entries of the wall's ghosts, times 2 d^2k/(2k)!

which is what the layer that the particles cannot resolve yet has taken up (the fourth-order continuation of
``schemes/wcsph/_impulse.py``).
"""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import view


class Kick:
    """Applies the jumps of the walls to ``viscous.velocity``."""

    def __init__(self, viscous):
        self.viscous, self.ghosts = viscous, viscous.ghosts
        self.viscosity = float(view(viscous.viscosity))

    def apply(self, velocity_jumps, acceleration_jumps):
        """Change the velocities; return the velocity gained from the (bottom, top) wall, summed over the particles."""
        gains, nu = [0.0, 0.0], self.viscosity
        for side, (jump, rate) in enumerate(zip(velocity_jumps, acceleration_jumps, strict=True)):
            if jump != 0.0 or rate != 0.0:
                gained = self.spread([0.0, jump, rate / nu / 12.0], side)
                gained += self.laplacian(self.spread([0.0, 0.0, jump / 12.0], side))
                active(self.viscous.velocity)[0] += gained
                gains[side] = float(gained.sum(dtype=float))
        return gains

    def spread(self, series, side):
        """Return the sums over the ghosts of one wall, with the values that the series gives them."""
        both = [[0.0] * 3, [0.0] * 3]
        both[side] = series
        self.ghosts.prescribe(*both)
        sums = np.zeros(self.viscous.points.fluid)
        sums[self.ghosts.near] = self.viscous.from_walls()
        return sums

    def laplacian(self, values):
        """Return the Laplacian of values that mirror oddly in the walls."""
        velocity, source = active(self.viscous.velocity)[0], active(self.viscous.source)
        before = velocity.copy()
        velocity[:], source[:] = values, 0.0
        self.viscous.begin(0)
        velocity[:] = before
        return active(self.viscous.start_rate)[0] / self.viscosity
