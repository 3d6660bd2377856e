"""The operators of a liquid with memory on particles, and the linear systems (1 - c A - D t D) x = b of its stages.

A particle's stress follows the velocities of its neighbours, their gradient and the divergence of the stress each by a
row of the same least-squares operators, so that what the solver sees is the scheme's own discrete equation. The
mirror image of the gradient, and of the stress, is even where that of the velocities is odd.
"""

import numpy as np

from tisph.neighbours.point_cloud import LANES
from tisph.runtime import real, ti, view
from tisph.schemes.implicit._across import ElasticAcross
from tisph.schemes.implicit._elastic_stages import even_fit, image_of_stress, polynomial
from tisph.solvers.bicgstab import BiCGStab


class ElasticSolver(BiCGStab):
    """Operators as ``_elastic_stages.py`` wants them; ``pull`` (slots + 1) is ``tangent`` D x of the solver."""

    def __init__(self, rows, ghosts, channel):
        super().__init__(rows, ghosts, -1.0)
        self.coarse = None if ghosts.mirrors else ElasticAcross(rows, ghosts, channel)
        self.tangent, self.found = self.points.field(real()), self.points.field(real())
        self.pull = ti.field(real(), self.points.slots + 1)
        self.tangent.used = self.found.used = self.pull.used = None  # for checkpoints
        self.fluid = slice(self.points.fluid)

    @ti.func
    def update_ghosts(self, values: ti.template(), particles):
        """Mirror ``values``, and evaluate their ``pull`` on particles and mirror images."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect(values, k)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.pull[i] = self.tangent[i] * self.operators.apply(self.operators.d_dy, values, i)
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect_pull(k)

    @ti.func
    def reflect_pull(self, k):
        """Give ghost ``k`` its ``pull``."""
        self.pull[self.points.capacity + k] = self.ghosts.value(self.pull, k)

    @ti.func
    def row(self, values: ti.template(), i):
        """Return row ``i`` of the system times ``values``, whose ``pull`` is known."""
        own, pulled, total = values[i], self.pull[i], 0.0 * values[i]
        for group in range(self.points.count[i] // LANES):
            for lane in ti.static(range(LANES)):  # both sums at once: what they read is the same
                k = group * LANES + lane
                j = self.points.neighbours[i, k]
                viscous = self.coefficient[None] * self.operators.laplacian[i, k] * (values[j] - own)
                total += viscous + self.operators.d_dy[i, k] * (self.pull[j] - pulled)
        return self.sigma[None] * own - total

    def solve(self, coefficient, tolerance):
        """Solve (1 - ``coefficient`` A) x = b, of velocities across the channel; return whether it did."""
        view(self.tangent)[self.fluid] = 0.0
        return super().solve(coefficient, tolerance)

    def answer(self, coefficient, tangent, right, guess, tolerance):
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = ``right``; return x, or None where that fails."""
        found = view(self.x)[self.fluid]
        found[...], view(self.b)[self.fluid], view(self.tangent)[self.fluid] = guess, right, tangent
        if self.coarse:
            view(self.coefficient)[()], view(self.sigma)[()] = coefficient, 1.0
            self.start()
            residual = view(self.residual)[self.fluid].astype(float)
            found += self.coarse.correction(residual, coefficient, np.broadcast_to(tangent, residual.shape))
        return found.copy() if super().solve(coefficient, tolerance) else None

    def assemble(self):
        """Get ready for systems with the rows as they are now."""
        if self.coarse:
            self.coarse.assemble()

    def laplacian(self, values):
        """Return A of velocities (fluid)."""
        self.lay(values, -1.0)
        self.curve()
        return view(self.found)[self.fluid].copy()

    def slopes(self, values, parity):
        """Return d/dy of ``values`` (fluid), whose mirror images have ``parity`` times theirs."""
        self.lay(values, parity)
        self.differentiate()
        return view(self.found)[self.fluid].copy()

    def lay(self, values, parity):
        """Put values and their mirror images where derivatives are taken from; return the images, in place."""
        everywhere = view(self.pull)
        everywhere[self.fluid] = values
        ghosts = self.ghosts.part(everywhere)
        ghosts[...] = parity * self.ghosts.sign() * self.ghosts.taken(everywhere)
        return ghosts

    @ti.kernel
    def curve(self):
        """Compute the Laplacian of what has been laid out."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.found[i] = self.operators.apply(self.operators.laplacian, self.pull, i)

    @ti.kernel
    def differentiate(self):
        """Compute d/dy of what has been laid out."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.found[i] = self.operators.apply(self.operators.d_dy, self.pull, i)

    def given(self, name, series):
        """Return what the ``series`` of the images beyond both walls add to "laplacian" or "d_dy" (fluid)."""
        self.ghosts.prescribe(*series)
        return self.from_images(getattr(self.operators, name), self.ghosts.given())

    def images(self, side, slope, third):
        """Return what D S has more by the first and third derivative of the stress at a wall (fluid)."""
        return self.from_images(self.operators.d_dy, self.more(side, slope, third))

    def more(self, side, slope, third):
        """Return what each image beyond one wall has of the stress more than its source (ghosts)."""
        sign = 1.0 if side == 0 else -1.0
        return np.where(self.ghosts.side == side, sign * image_of_stress(self.ghosts.depth, slope, third), 0.0)

    def from_images(self, rows, values):
        """Return the sums over the images with such ``values`` (fluid)."""
        sums = np.zeros(self.points.fluid)
        sums[self.ghosts.near] = self.ghosts.sums(rows, values[self.ghosts.listed])[0]
        return sums

    def even_fit(self, side):
        """Return particles near a wall, their distance from it, and their weights in ``even_fit``."""
        close, weights = even_fit(self.ghosts.offset[side], self.ghosts.reach)
        return self.ghosts.near[close], self.ghosts.offset[side, close], weights

    def at_walls(self, values):
        """Return the ``polynomial`` at each wall through ``values`` (quantities, fluid)."""
        near = np.asarray(values)[:, self.ghosts.near].T.astype(float)
        return [polynomial(offset, near, self.ghosts.reach) for offset in self.ghosts.offset]
