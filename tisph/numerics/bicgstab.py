"""BiCGStab for (sigma - c A) x = b, A being the Laplacian of least-squares operators, preconditioned from the right.

H. A. van der Vorst, SIAM J. Sci. Stat. Comput. 13 (1992) 631-644. The preconditioner is the diagonal (Jacobi), which
suffices where c A is small beside sigma, or ``TwoLevel``.

In a pure Neumann problem sigma is 0: x is determined up to a constant, and there is a solution only if b has no part
along the left null vector of A, which for least-squares operators is not quite constant. The equation solved is
A x = b - constant, where the constant is such that a solution exists: the mean is subtracted from all residuals. Sums
run block by block in a fixed order: the result does not depend on the number of threads.
"""

from typing import Any, Protocol

from tisph.numerics.least_squares import LeastSquaresOperators
from tisph.runtime import CHUNK, real, scalar, threads, ti, view

MAX_ITERATIONS = 200

BLOCK = 256
"""Particles whose part of a sum is one number."""


class Preconditioner(Protocol):
    """Preconditioner of a ``BiCGStab``."""

    def apply(self) -> None:
        """Set the solver's ``correction`` from its ``input``, then call ``multiply``, which sets its ``product``."""


@ti.data_oriented
class BiCGStab:
    """Solver for one number, or a vector of ``width`` numbers, at each particle.

    ``x`` (slots + 1): guess, then solution; ``b`` (capacity): right side. ``ghosts``: points beyond walls, with minus
    the value of their source in the fluid: number ``count``, value of the source ``value(values, k)``. ``iterations``:
    number for the last solution, in halves. ``hoop``: all components but the first are v/r and w/r of axisymmetric
    flow, whose Laplacian has a further term. ``number``: field with the number of unknowns, which come first of all
    points; by default all of a pure Neumann problem, else the fluid.

    ``outlet``: field with the first of the last points, at an open end. These are unknowns as well, with the rows
    -sigma * ``outlet_area`` * A, in which A is a normal derivative. The points between the fluid and them are not.

    Rows of the pressure, a single number, are weighted by the areas of particles where the spacing varies.
    """

    def __init__(
        self,
        operators: LeastSquaresOperators,
        ghosts: Any = None,
        width: int | None = None,
        pure_neumann: bool = False,
        hoop: bool = False,
        number: Any = None,
        outlet: Any = None,
        outlet_area: float = 0.0,
    ):
        self.operators, self.ghosts, self.points, self.hoop = operators, ghosts, operators.points, hoop
        self.is_scalar, self.pure_neumann, self.has_ghosts = width is None, pure_neumann, ghosts is not None
        self.weighted = self.is_scalar and operators.points.graded
        self.number = number or (self.points.particles if pure_neumann else self.points.n_fluid)
        self.outlet, self.outlet_area, self.has_outlet = outlet, scalar(outlet_area), outlet is not None
        self.serial = operators.serial_light
        self.workers = 1 if self.serial else threads()
        self.kind = real() if width is None else ti.types.vector(width, real())
        capacity, blocks = self.points.capacity, -(-self.points.capacity // BLOCK)
        self.x, self.correction = (ti.field(self.kind, self.points.slots + 1) for _ in range(2))
        self.b, self.residual, self.shadow, self.direction, self.v, self.input, self.product = (
            ti.field(self.kind, capacity) for _ in range(7)
        )
        self.inverse = ti.field(real(), capacity)
        self.parts = ti.field(ti.types.vector(3, real()), blocks)
        self.totals, self.mean = ti.field(self.kind, blocks), ti.field(self.kind, ())
        self.sigma, self.coefficient = scalar(1.0), scalar(0.0)
        self.rho, self.alpha, self.omega, self.beta = (scalar(0.0) for _ in range(4))
        self.size, self.norm = scalar(0.0), scalar(0.0)
        self.iterations = 0.0

    def solve(
        self,
        coefficient: float,
        tolerance: float,
        sigma: float = 1.0,
        preconditioner: Preconditioner | None = None,
        max_iterations: int = MAX_ITERATIONS,
        least: float = 0.0,
    ) -> bool:
        """Solve (``sigma`` - ``coefficient`` A) x = b to a residual of ``tolerance`` |b|; return whether it converged.

        ``least``: residual that counts as zero, whatever |b|. ``preconditioner``: None for the diagonal.
        """
        view(self.sigma)[()], view(self.coefficient)[()] = sigma, coefficient
        precondition = preconditioner.apply if preconditioner else self.apply_jacobi
        self.start()
        norm, limit, self.iterations = view(self.norm), max(least, tolerance * float(view(self.size))), 0.0
        while norm > limit and self.iterations < max_iterations:
            precondition()
            self.step_half()
            self.iterations += 0.5
            if not norm > limit:
                break
            precondition()
            self.step()
            self.iterations += 0.5
        if self.pure_neumann:
            self.remove_mean()
        return bool(norm <= limit)

    def forget(self) -> None:
        """Take note that points have other numbers: those without unknowns have 0 in all that others read."""
        view(self.b)[...] = view(self.correction)[...] = view(self.input)[...] = 0.0

    @ti.func
    def update_ghosts(self, values: ti.template(), particles):
        """Set the ``values`` of the ghosts from the values of the particles."""
        if ti.static(self.has_ghosts):
            ti.loop_config(serialize=True)
            for k in range(self.ghosts.count[None]):
                values[self.points.capacity + k] = -self.ghosts.value(values, k)

    @ti.func
    def row(self, values: ti.template(), i):
        """Return row ``i`` of the matrix times ``values``."""
        derivative = self.operators.apply(self.operators.laplacian, values, i)
        laplacian = derivative
        if ti.static(self.hoop):
            laplacian += self.operators.hoop(values, i)
        result = self.sigma[None] * values[i] - self.coefficient[None] * laplacian
        if ti.static(self.has_outlet):
            result = ti.select(i < self.points.n_fluid[None], result, -self.outlet_part(i) * derivative)
        return self.weight(i) * result

    @ti.func
    def weight(self, i):
        """Return the weight of a row: the area of a particle where these differ, so that the rows add up to 0."""
        result = 1.0
        if ti.static(self.weighted):
            result = ti.select(i < self.points.n_fluid[None], self.points.relative(i) ** 2, 1.0)
        return result

    @ti.func
    def outlet_part(self, i):
        """Return the factor of the normal derivative at a point that is not in the fluid, 0 away from the outlet."""
        return ti.select(i >= self.outlet[None], self.sigma[None] * self.outlet_area[None], 0.0)

    @ti.func
    def diagonal(self, i):
        """Return the diagonal entry of row ``i``, 1 where there is no unknown."""
        result = self.sigma[None] - self.coefficient[None] * self.operators.diagonal[i]
        if ti.static(self.has_outlet):
            part = self.outlet_part(i)
            own = ti.select(part > 0.0, -part * self.operators.diagonal[i], 1.0)
            result = ti.select(i < self.points.n_fluid[None], result, own)
        return self.weight(i) * result

    @ti.func
    def dot(self, left, right):
        """Return the product of the numbers, or the scalar product of the vectors, of two particles."""
        result = 0.0
        if ti.static(self.is_scalar):
            result += left * right
        else:
            result += left.dot(right)
        return result

    @ti.func
    def blocks(self, task, particles):
        """Return the first block of a task and the end of its blocks; the first task of a thread has all blocks."""
        worker, blocks = task // CHUNK, (particles + BLOCK - 1) // BLOCK
        first, last = worker * blocks // self.workers, (worker + 1) * blocks // self.workers
        return first, ti.select(task % CHUNK == 0, last, first)

    @ti.func
    def end(self, block, particles):
        """Return the end of the particles of a block."""
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
        """Set ``mean`` to the mean over all blocks; return its part of the sum of squares, particles * mean^2."""
        total = 0.0 * self.totals[0]
        for block in range((particles + BLOCK - 1) // BLOCK):
            total += self.totals[block]
        self.mean[None] = total / particles
        return self.dot(total, total) / particles

    @ti.kernel
    def start(self):
        """Compute the residual of the guess, its ``norm``, the inverse diagonal, and the ``size`` |b|."""
        particles = self.number[None]
        self.update_ghosts(self.x, particles)
        ti.loop_config(serialize=self.serial)
        for task in range(self.workers * CHUNK):
            first, last = self.blocks(task, particles)
            for block in range(first, last):
                part, total = ti.Vector([0.0, 0.0, 0.0]), 0.0 * self.b[0]
                for i in range(block * BLOCK, self.end(block, particles)):
                    self.inverse[i] = 1.0 / self.diagonal(i)
                    right = self.weight(i) * self.b[i]
                    residual = right - self.row(self.x, i)
                    self.residual[i] = residual
                    total += residual
                    part += ti.Vector([self.dot(right, right), self.dot(residual, residual), 0.0])
                self.parts[block] = part
                self.totals[block] = total
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = self.sums(particles)
            square = self.take_mean(particles)
            self.size[None] = ti.sqrt(total[0])
            self.rho[None] = total[1]
            if ti.static(self.pure_neumann):
                self.rho[None] = total[1] - square
            self.norm[None] = ti.sqrt(self.rho[None])
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            residual = self.residual[i]
            if ti.static(self.pure_neumann):
                residual -= self.mean[None]
            self.residual[i] = residual
            self.shadow[i] = residual
            self.direction[i] = residual
            self.input[i] = residual

    @ti.kernel
    def apply_jacobi(self):
        """Apply the inverse of the diagonal as the preconditioner."""
        particles = self.number[None]
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.correction[i] = self.inverse[i] * self.input[i]
        if ti.static(self.has_outlet):
            self.sweep(self.outlet[None], particles)
        self.multiply(particles)

    @ti.func
    def sweep(self, first, particles):
        """Change the ``correction`` of the ``first`` to the last point by one Jacobi sweep over their rows.

        Those of walls and of an outlet, one-sided derivatives, are not dominated by the diagonal.
        """
        ti.loop_config(serialize=self.serial)
        for i in range(first, particles):
            residual = self.input[i] - self.row(self.correction, i)
            self.product[i] = self.correction[i] + self.inverse[i] * residual
        ti.loop_config(serialize=self.serial)
        for i in range(first, particles):
            self.correction[i] = self.product[i]

    @ti.func
    def multiply(self, particles):
        """Compute the matrix times the ``correction``, and its products with shadow, residual and itself."""
        self.update_ghosts(self.correction, particles)
        ti.loop_config(serialize=self.serial)
        for task in range(self.workers * CHUNK):
            first, last = self.blocks(task, particles)
            for block in range(first, last):
                part, total = ti.Vector([0.0, 0.0, 0.0]), 0.0 * self.b[0]
                for i in range(block * BLOCK, self.end(block, particles)):
                    product = self.row(self.correction, i)
                    self.product[i] = product
                    total += product
                    residual = self.residual[i]
                    squares = self.dot(residual, product), self.dot(product, product)
                    part += ti.Vector([self.dot(self.shadow[i], product), squares[0], squares[1]])
                self.parts[block] = part
                self.totals[block] = total

    @ti.kernel
    def step_half(self):
        """Take the step along the BiCG direction, x += alpha correction."""
        particles = self.number[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.take_mean(particles)
            self.alpha[None] = self.rho[None] / self.sums(particles)[0]
        ti.loop_config(serialize=self.serial)
        for task in range(self.workers * CHUNK):
            first, last = self.blocks(task, particles)
            for block in range(first, last):
                part = ti.Vector([0.0, 0.0, 0.0])
                for i in range(block * BLOCK, self.end(block, particles)):
                    v = self.product[i]
                    if ti.static(self.pure_neumann):
                        v -= self.mean[None]
                    self.v[i] = v
                    residual = self.residual[i] - self.alpha[None] * v
                    self.residual[i] = residual
                    self.input[i] = residual
                    self.x[i] += self.alpha[None] * self.correction[i]
                    part[0] += self.dot(residual, residual)
                self.parts[block] = part
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.norm[None] = ti.sqrt(self.sums(particles)[0])

    @ti.kernel
    def step(self):
        """Take the step that minimises the residual, x += omega correction, and compute the next BiCG direction."""
        particles = self.number[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            square, total = self.take_mean(particles), self.sums(particles)
            if ti.static(self.pure_neumann):
                total[2] -= square
            self.omega[None] = total[1] / total[2] if total[2] > 0.0 else 0.0
        ti.loop_config(serialize=self.serial)
        for task in range(self.workers * CHUNK):
            first, last = self.blocks(task, particles)
            for block in range(first, last):
                part = ti.Vector([0.0, 0.0, 0.0])
                for i in range(block * BLOCK, self.end(block, particles)):
                    t = self.product[i]
                    if ti.static(self.pure_neumann):
                        t -= self.mean[None]
                    residual = self.residual[i] - self.omega[None] * t
                    self.residual[i] = residual
                    self.x[i] += self.omega[None] * self.correction[i]
                    part += ti.Vector([self.dot(residual, residual), self.dot(self.shadow[i], residual), 0.0])
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
            back = self.direction[i] - self.omega[None] * self.v[i]
            direction = self.residual[i] + self.beta[None] * back
            self.direction[i] = direction
            self.input[i] = direction

    @ti.kernel
    def remove_mean(self):
        """Subtract the mean of the solution, summed block by block."""
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
