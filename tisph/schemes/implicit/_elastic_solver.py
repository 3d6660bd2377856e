"""The linear systems of a viscoelastic step: (1 - c A - D t D) x = b, with D = d/dy and t the tangent of the stress.

A particle's stress follows the velocities of its neighbours, their gradient and the divergence of the stress each by a
row of the same least-squares operators, so that what the solver sees is the scheme's own discrete equation. The
mirror image of the gradient, and of the stress, is even where that of the velocities is odd.
"""

from tisph.least_squares.bicgstab import BiCGStab
from tisph.neighbours.points import LANES, used
from tisph.runtime import real, ti, view


class ElasticSolver(BiCGStab):
    """Solver of (1 - c A - D ``tangent`` D) x = b, ``tangent`` (fluid) >= 0; ``pull`` (slots + 1) is ``tangent`` D x."""

    def __init__(self, rows, ghosts):
        super().__init__(rows, ghosts, -1.0)
        self.tangent, self.found = self.points.field(real()), self.points.field(real())
        self.pull = ti.field(real(), self.points.slots + 1)
        for scratch in (self.tangent, self.found, self.pull):
            scratch.used = scratch.used if scratch is not self.pull else None

    @ti.func
    def spread(self, values: ti.template(), particles):
        """Mirror ``values``, and evaluate their ``pull`` on particles and mirror images."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect(values, k)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(particles):
            self.pull[i] = self.tangent[i] * self.rows.apply(self.rows.across, values, i)
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.pull[self.points.most + k] = self.ghosts.value(self.pull, k)

    @ti.func
    def product(self, values, i):
        """Return row ``i`` of the system times ``values``, whose ``pull`` is known."""
        own, pulled, total = values[i], self.pull[i], 0.0 * values[i]
        for group in range(self.points.count[i] // LANES):
            for lane in ti.static(range(LANES)):  # both sums at once: what they read is the same
                k = group * LANES + lane
                j = self.points.table[i, k]
                viscous = self.coefficient[None] * self.rows.laplacian[i, k] * (values[j] - own)
                total += viscous + self.rows.across[i, k] * (self.pull[j] - pulled)
        return self.own[None] * own - total

    def slopes(self, values, parity):
        """Return d/dy of ``values`` (fluid), whose mirror images have ``parity`` times their values; until the next."""
        everywhere = view(self.pull)
        everywhere[: self.points.fluid] = values
        ghosts = self.ghosts.part(everywhere)
        ghosts[...] = parity * self.ghosts.taken(everywhere)
        self.differentiate()
        return used(self.found)

    @ti.kernel
    def differentiate(self):
        """Compute d/dy of ``pull``."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(particles):
            self.found[i] = self.rows.apply(self.rows.across, self.pull, i)
