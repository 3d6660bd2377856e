"""BiCGStab for (own - c A) x = b, A being Laplacian rows, in a bounded number of iterations.

H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13 (1992) 631-644. The preconditioner is one cycle of two levels: a
damped Jacobi sweep on the particles takes off what is rough, the fast solver of a ``Lattice`` what is smooth, and a
last sweep what the transfers between the two have left. Where c A is small beside ``own`` the diagonal alone does.

With ``floating`` own is 0: x is free by a constant, and there is a solution only if b has no part along the left null
vector of A, which for least-squares rows is not quite constant. Solved is A x = b - constant with whatever constant
that takes: all residuals lose their mean. Sums run block by block in a fixed order: the result does not depend on the
number of threads.
"""

from tisph.least_squares.operators import CHUNK
from tisph.runtime import real, scalar, threads, ti, view

MOST_ITERATIONS = 100

BLOCK = 256
"""Particles whose part of a sum is one number."""

DAMPING = 0.7
"""Of the Jacobi sweeps."""


@ti.data_oriented
class MultilevelSolver:
    """Solver of a system for ``width`` unknowns a particle; ``x`` (slots + 1): guess, then solution, ``b`` (most).

    ``lattice``: of a periodic box, or of a channel with ``ghosts`` beyond its walls, in which x mirrors oddly.
    ``iterations``: of the last solution, by halves.
    """

    def __init__(self, rows, lattice, width, floating=False, ghosts=None):
        self.operators, self.lattice, self.points, self.ghosts = rows, lattice, rows.points, ghosts
        self.floating, self.closed = floating, ghosts is not None
        self.number = self.points.particles if floating else self.points.n_fluid
        self.serial = rows.serial_light
        self.workers = 1 if self.serial else threads()
        kind, most = ti.types.vector(width, real()), self.points.capacity
        self.x, self.smooth, self.result = (ti.field(kind, self.points.slots + 1) for _ in range(3))
        self.b, self.residual, self.shadow, self.direction, self.along = (ti.field(kind, most) for _ in range(5))
        self.given, self.image = (ti.field(kind, most) for _ in range(2))
        self.nodes = lattice.nodes(width)
        self.inverse = ti.field(real(), most)
        self.parts = ti.field(ti.types.vector(3, real()), -(-most // BLOCK))
        self.totals = ti.field(kind, -(-most // BLOCK))
        self.own, self.coefficient = scalar(0.0), scalar(1.0)
        self.rho, self.alpha, self.omega, self.beta = (scalar(0.0) for _ in range(4))
        self.size, self.norm = scalar(0.0), scalar(0.0)
        self.mean = ti.field(kind, ())
        self.iterations = 0.0

    def solve(self, own, coefficient, tolerance, rough, most=MOST_ITERATIONS):
        """Solve (``own`` - ``coefficient`` A) x = b to a residual of ``tolerance`` |b|; return whether it did.

        ``rough``: whether the diagonal is preconditioner enough.
        """
        view(self.own)[()], view(self.coefficient)[()] = own, coefficient
        precondition = self.scale if rough else self.cycle
        norm, size = view(self.norm), view(self.size)
        self.start()
        self.iterations, limit = 0.0, tolerance * float(size)
        for _ in range(most):
            if norm <= limit:
                break
            precondition()
            self.step_half()
            self.iterations += 0.5
            if norm <= limit:
                break
            precondition()
            self.step()
            self.iterations += 0.5
        if self.floating:
            self.centre()
        return bool(norm <= limit)

    def cycle(self):
        """One cycle of two levels, and the image of the result."""
        self.restrict()
        self.lattice.invert(self.nodes, float(view(self.own)), float(view(self.coefficient)))
        self.prolong()

    @ti.func
    def close(self, values: ti.template()):
        """Give the ghosts their values."""
        if ti.static(self.closed):
            ti.loop_config(serialize=True)
            for k in range(self.ghosts.count[None]):
                values[self.points.capacity + k] = -self.ghosts.value(values, k)

    @ti.func
    def product(self, values: ti.template(), i):
        """Return row ``i`` of (own - coefficient A) times ``values``."""
        return self.own[None] * values[i] - self.coefficient[None] * self.operators.apply(
            self.operators.laplacian, values, i
        )

    @ti.func
    def blocks(self, turn, particles):
        """Return the first block, and that after the last, to sum in a turn: those of a thread in its first turn."""
        worker, blocks = turn // CHUNK, (particles + BLOCK - 1) // BLOCK
        first, last = worker * blocks // self.workers, (worker + 1) * blocks // self.workers
        return first, ti.select(turn % CHUNK == 0, last, first)

    @ti.func
    def end(self, block, particles):
        """Return the particle after the last one of a block."""
        return ti.min(particles, (block + 1) * BLOCK)

    @ti.func
    def sums(self, particles):
        """Return the sums over all blocks."""
        total = ti.Vector([0.0, 0.0, 0.0])
        for block in range((particles + BLOCK - 1) // BLOCK):
            total += self.parts[block]
        return total

    @ti.func
    def take_mean(self, particles):
        """Let ``mean`` be that over all blocks; return what it adds to a sum of squares."""
        total = 0.0 * self.totals[0]
        for block in range((particles + BLOCK - 1) // BLOCK):
            total += self.totals[block]
        self.mean[None] = total / particles
        return total.dot(total) / particles

    @ti.kernel
    def start(self):
        """Residual of the guess and its ``norm``, inverse diagonal, and the ``size`` |b|."""
        particles = self.number[None]
        self.close(self.x)
        ti.loop_config(serialize=self.serial)
        for turn in range(self.workers * CHUNK):
            first, last = self.blocks(turn, particles)
            for block in range(first, last):
                part, total = ti.Vector([0.0, 0.0, 0.0]), 0.0 * self.b[0]
                for i in range(block * BLOCK, self.end(block, particles)):
                    self.inverse[i] = 1.0 / (self.own[None] - self.coefficient[None] * self.operators.diagonal[i])
                    residual = self.b[i] - self.product(self.x, i)
                    self.residual[i] = residual
                    total += residual
                    part += ti.Vector([self.b[i].dot(self.b[i]), residual.dot(residual), 0.0])
                self.parts[block] = part
                self.totals[block] = total
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = self.sums(particles)
            square = self.take_mean(particles)
            self.size[None] = ti.sqrt(total[0])
            self.rho[None] = total[1]
            if ti.static(self.floating):
                self.rho[None] = total[1] - square
            self.norm[None] = ti.sqrt(self.rho[None])
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            residual = self.residual[i]
            if ti.static(self.floating):
                residual -= self.mean[None]
            self.residual[i] = residual
            self.shadow[i] = residual
            self.direction[i] = residual
            self.given[i] = residual

    @ti.kernel
    def restrict(self):
        """The first sweep, from 0, and what it leaves on the lattice."""
        particles = self.number[None]
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.smooth[i] = DAMPING * self.inverse[i] * self.given[i]
        self.close(self.smooth)
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.image[i] = self.given[i] - self.product(self.smooth, i)
        ti.loop_config(serialize=self.serial)
        for node in range(self.lattice.rows[None] * self.lattice.columns[None]):
            self.nodes[node] = self.lattice.deposit(self.image, node)

    @ti.kernel
    def prolong(self):
        """Add what the lattice has found, the last sweep, and the image of the ``result``."""
        particles = self.number[None]
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.smooth[i] += self.lattice.interpolate(self.nodes, i)
        self.close(self.smooth)
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            defect = self.given[i] - self.product(self.smooth, i)
            self.result[i] = self.smooth[i] + DAMPING * self.inverse[i] * defect
        self.map(particles)

    @ti.kernel
    def scale(self):
        """The diagonal alone as a preconditioner."""
        particles = self.number[None]
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.result[i] = self.inverse[i] * self.given[i]
        self.map(particles)

    @ti.func
    def map(self, particles):
        """Image of the ``result``, and its products with shadow, residual and itself."""
        self.close(self.result)
        ti.loop_config(serialize=self.serial)
        for turn in range(self.workers * CHUNK):
            first, last = self.blocks(turn, particles)
            for block in range(first, last):
                part, total = ti.Vector([0.0, 0.0, 0.0]), 0.0 * self.b[0]
                for i in range(block * BLOCK, self.end(block, particles)):
                    image = self.product(self.result, i)
                    self.image[i] = image
                    total += image
                    part += ti.Vector([self.shadow[i].dot(image), self.residual[i].dot(image), image.dot(image)])
                self.parts[block] = part
                self.totals[block] = total

    @ti.kernel
    def step_half(self):
        """Go along the first direction as far as the shadow says."""
        particles = self.number[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.take_mean(particles)
            self.alpha[None] = self.rho[None] / self.sums(particles)[0]
        ti.loop_config(serialize=self.serial)
        for turn in range(self.workers * CHUNK):
            first, last = self.blocks(turn, particles)
            for block in range(first, last):
                part = ti.Vector([0.0, 0.0, 0.0])
                for i in range(block * BLOCK, self.end(block, particles)):
                    along = self.image[i]
                    if ti.static(self.floating):
                        along -= self.mean[None]
                    self.along[i] = along
                    residual = self.residual[i] - self.alpha[None] * along
                    self.residual[i] = residual
                    self.given[i] = residual
                    self.x[i] += self.alpha[None] * self.result[i]
                    part[0] += residual.dot(residual)
                self.parts[block] = part
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.norm[None] = ti.sqrt(self.sums(particles)[0])

    @ti.kernel
    def step(self):
        """Go along the second direction to the smallest residual, and choose the next first one."""
        particles = self.number[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            square, total = self.take_mean(particles), self.sums(particles)
            if ti.static(self.floating):
                total[2] -= square
            self.omega[None] = total[1] / total[2] if total[2] > 0.0 else 0.0
        ti.loop_config(serialize=self.serial)
        for turn in range(self.workers * CHUNK):
            first, last = self.blocks(turn, particles)
            for block in range(first, last):
                part = ti.Vector([0.0, 0.0, 0.0])
                for i in range(block * BLOCK, self.end(block, particles)):
                    across = self.image[i]
                    if ti.static(self.floating):
                        across -= self.mean[None]
                    residual = self.residual[i] - self.omega[None] * across
                    self.residual[i] = residual
                    self.x[i] += self.omega[None] * self.result[i]
                    part += ti.Vector([residual.dot(residual), self.shadow[i].dot(residual), 0.0])
                self.parts[block] = part
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = self.sums(particles)
            self.norm[None] = ti.sqrt(total[0])
            ratio = total[1] / self.rho[None] * self.alpha[None] / self.omega[None]
            self.beta[None] = ratio if self.norm[None] > 0.0 else 0.0
            self.rho[None] = total[1]
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            back = self.direction[i] - self.omega[None] * self.along[i]
            direction = self.residual[i] + self.beta[None] * back
            self.direction[i] = direction
            self.given[i] = direction

    @ti.kernel
    def centre(self):
        """Take the mean off the solution, block by block."""
        particles = self.number[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            for block in range((particles + BLOCK - 1) // BLOCK):
                total = 0.0 * self.b[0]
                for i in range(block * BLOCK, self.end(block, particles)):
                    total += self.x[i]
                self.totals[block] = total
            self.take_mean(particles)
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.x[i] -= self.mean[None]
