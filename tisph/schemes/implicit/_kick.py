"""Walls that start, or whose acceleration starts, at once: the impulse on the liquid through the ghosts' series.

A wall whose velocity jumps by J has U' = J delta(t) and U'' = J delta'(t); one whose acceleration relative to the
drive jumps by J_1 has U'' = J_1 delta(t). Put into the ghosts' series (``_ghosts.py``) and integrated over the jump,
they change the velocities once, at the start, by

    du = J (g_2 + A g_4) + J_1/nu g_4,    g_2k = sum of the row entries of the wall's ghosts, times 2 d^2k/(2k)!

which is what the layer that the particles cannot resolve yet has taken up (the fourth-order continuation of
``schemes/_impulse.py``).
"""

from tisph.runtime import ti


@ti.data_oriented
class Kick:
    """Applies the jumps of the walls to ``viscous.velocity``."""

    def __init__(self, viscous):
        self.viscous, self.rows, self.solver = viscous, viscous.rows, viscous.solver
        self.ghosts, self.fluid = viscous.ghosts, viscous.fluid

    def apply(self, velocity_jumps, acceleration_jumps):
        """Change the velocities; return the velocity gained from the (bottom, top) wall, summed over the particles."""
        gains = [0.0, 0.0]
        for side, (jump, rate) in enumerate(zip(velocity_jumps, acceleration_jumps, strict=True)):
            if jump == 0.0 and rate == 0.0:
                continue
            before = self.total()
            self.add([0.0, jump, rate / self.viscous.viscosity[None] / 12.0], side, True)
            self.add([0.0, 0.0, jump / 12.0], side, False)
            gains[side] = self.total() - before
        return gains

    def total(self):
        """Return the sum of the velocities along the channel."""
        return float(self.viscous.velocity.to_numpy()[0].sum(dtype=float))

    def add(self, series, side, direct):
        """Add what the series of one wall gives: at once, or through the Laplacian of it."""
        both = [[0.0] * 3, [0.0] * 3]
        both[side] = series
        self.ghosts.lay(self.viscous.data, *both)
        self.spread()
        if direct:
            self.add_spread()
        else:
            self.add_laplacian()

    @ti.kernel
    def spread(self):
        """Put the sums over the ghosts where the solver has its solution."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            self.solver.x[i] = self.rows.apply(self.rows.laplacian, self.viscous.data, i)

    @ti.kernel
    def add_spread(self):
        """Add these sums to the velocities."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            self.viscous.velocity[0, i] += self.solver.x[i]

    @ti.kernel
    def add_laplacian(self):
        """Add their Laplacian, with nothing on the walls, to the velocities."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.solver.reflect(self.solver.x, k)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            self.viscous.velocity[0, i] += self.rows.apply(self.rows.laplacian, self.solver.x, i)
