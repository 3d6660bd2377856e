"""BiCGStab for (1 - c A) x = b, A being least-squares rows closed by ghosts beyond the walls.

H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13 (1992) 631-644, with the diagonal as preconditioner. Sums run in a
fixed order, so that the result does not depend on the number of threads.
"""

from tisph.least_squares.operators import LANES
from tisph.runtime import real, scalar, ti, view

MOST_ITERATIONS = 200


@ti.data_oriented
class BiCGStab:
    """Solver with its vectors; ``x`` (slots + 1) holds the guess and then the solution, ``b`` (padded) the right side.

    ``parity``: what a ghost has of its source's value, -1 for velocities and 1 for pressure. ``iterations``: of the
    last solution.
    """

    def __init__(self, rows, ghosts, parity):
        self.operators, self.ghosts, self.points = rows, ghosts, rows.points
        self.parity = parity
        padded, slots = -(-self.points.capacity // LANES) * LANES, self.points.slots + 1
        self.x, self.search, self.half = (ti.field(real(), slots) for _ in range(3))
        self.b, self.residual, self.shadow, self.along, self.across = (ti.field(real(), padded) for _ in range(5))
        self.direction, self.inverse = (ti.field(real(), padded) for _ in range(2))
        self.coefficient, self.own = scalar(0.0), scalar(1.0)
        self.rho, self.alpha, self.omega, self.beta = (scalar(0.0) for _ in range(4))
        self.size, self.norm = scalar(0.0), scalar(0.0)
        self.iterations = 0

    def solve(self, coefficient, tolerance, own=1.0, most=MOST_ITERATIONS):
        """Solve (``own`` - ``coefficient`` A) x = b to a residual of ``tolerance`` |b|; return whether it did."""
        view(self.coefficient)[()], view(self.own)[()] = coefficient, own
        self.start()
        norm, limit, self.iterations = view(self.norm), tolerance * view(self.size), 0
        while norm > limit and self.iterations < most:
            self.iterate()
            self.iterations += 1
        return bool(norm <= limit)

    @ti.func
    def product(self, values, i):
        """Return row ``i`` of (own - coefficient A) times ``values``."""
        return self.own[None] * values[i] - self.coefficient[None] * self.operators.apply(
            self.operators.laplacian, values, i
        )

    @ti.func
    def reflect(self, values, k):
        """Give ghost ``k`` its value."""
        values[self.points.capacity + k] = self.parity * self.ghosts.value(values, k)

    @ti.func
    def spread(self, values: ti.template(), particles):
        """Give what a product of ``values`` needs beyond those of the particles."""
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.reflect(values, k)

    @ti.func
    def dot(self, left: ti.template(), right: ti.template()):
        """Return the sum of products, in a fixed order."""
        part = ti.Vector([0.0] * LANES)
        for group in range((self.points.particles[None] + LANES - 1) // LANES):
            for lane in ti.static(range(LANES)):
                part[lane] += left[group * LANES + lane] * right[group * LANES + lane]
        return part.sum()

    @ti.kernel
    def start(self):
        """Residual of the guess and its ``norm``, inverse diagonal, and the ``size`` |b|."""
        particles = self.points.particles[None]
        self.spread(self.x, particles)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.inverse[i] = 1.0 / (self.own[None] - self.coefficient[None] * self.operators.diagonal[i])
            residual = self.b[i] - self.product(self.x, i)
            self.residual[i] = residual
            self.shadow[i] = residual
            self.direction[i] = 0.0
            self.along[i] = 0.0
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.size[None] = ti.sqrt(self.dot(self.b, self.b))
            self.rho[None] = self.dot(self.shadow, self.residual)
            self.norm[None] = ti.sqrt(self.rho[None])
            self.beta[None] = 0.0
            self.omega[None] = 0.0
            self.alpha[None] = 1.0

    @ti.kernel
    def iterate(self):
        """One iteration: two products, five sums."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(particles):
            direction = self.residual[i] + self.beta[None] * (self.direction[i] - self.omega[None] * self.along[i])
            self.direction[i] = direction
            self.search[i] = self.inverse[i] * direction
        self.spread(self.search, particles)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.along[i] = self.product(self.search, i)
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.alpha[None] = self.rho[None] / self.dot(self.shadow, self.along)
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(particles):
            self.residual[i] -= self.alpha[None] * self.along[i]
            self.half[i] = self.inverse[i] * self.residual[i]
        self.spread(self.half, particles)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.across[i] = self.product(self.half, i)
        ti.loop_config(serialize=True)
        for _ in range(1):
            size = self.dot(self.across, self.across)
            # nothing is left where the first half of the iteration has met the solution
            self.omega[None] = self.dot(self.across, self.residual) / size if size > 0.0 else 0.0
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(particles):
            self.x[i] += self.alpha[None] * self.search[i] + self.omega[None] * self.half[i]
            self.residual[i] -= self.omega[None] * self.across[i]
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.norm[None] = ti.sqrt(self.dot(self.residual, self.residual))
            rho = self.dot(self.shadow, self.residual)
            ratio = rho / self.rho[None] * self.alpha[None] / self.omega[None]
            self.beta[None] = ratio if self.norm[None] > 0.0 else 0.0
            self.rho[None] = rho
