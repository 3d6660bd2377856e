"""One step of the velocities by velocity correction: history, then pressure, then viscous forces.

G. E. Karniadakis, M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991) 414-443, along the paths of the particles, where
there is no convective term: with backward differences gamma_0 u - sum_q alpha_q u^(n+1-q) of variable steps dt,

    u^ = sum_q alpha_q u^(n+1-q),
    L p = (D u^ - k gamma_0 d^n) / dt,
    (gamma_0 - dt nu L) u^(n+1) = u^ - dt G p,

all operators being those of the arrangement at the end of the step. L p is the Laplacian itself, not D G p, which on
particles has spurious modes; so the divergence d of the velocities is not quite 0, and where steps are short asking for
0 anew in each would let pressures grow like 1/dt. Hence k: divergence decays at a rate of its own instead.
"""

import math

import numpy as np

from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes._two_dimensional.free_bodies import MOST_ITERATIONS
from tisph.schemes._two_dimensional.time_levels import PRESSURES, VELOCITIES, gradients
from tisph.solvers.bicgstab import BiCGStab, TwoLevel

ROUGH = 1.0
"""Viscous number dt nu/(gamma_0 spacing^2) up to which Jacobi suffices as a preconditioner. Between walls, where it is
2.7 at most (``MOST_VISCOUS``), it always does: there are twice as many iterations, in half the time."""

FIRST_OUTER = 1e-3, 1e-6
"""Residuals of the first of two outer iterations, of which only the curl at walls is used: with 1e-4 and 1e-8 errors
between cylinders are the same to four digits. With free bodies, whose loads are used as well, none are less exact."""


@ti.data_oriented
class SplittingStep:
    """Computes velocities and pressure at the end of a step from the time levels, with weights set beforehand.

    ``alpha``: of the backward differences; ``beta``, ``beta_pressure``: of the extrapolated values, from which solvers
    start and from which the error is estimated. ``boundary``: the ``PressureBoundaryCondition`` where there are walls.
    ``coupling``: with bodies that the flow carries, ``mean_velocity``: the ``MeanVelocityControl``; None without.
    ``extra_stress``: of a fluid that is not Newtonian; one whose viscosity is ``varying`` has operators of its own.
    """

    def __init__(self, levels, grid, problem, boundary=None, extra_stress=None):
        self.levels, self.operators, self.points = levels, levels.operators, levels.points
        self.coordinates = levels.coordinates
        vector = ti.types.vector(levels.components, real())
        self.spacing, self.pressure_boundary, self.bounded = problem.spacing, boundary, boundary is not None
        self.closing = self.bounded and boundary.closing
        self.coupling, self.mean_velocity, self.rounding = None, None, 0.0
        self.extra_stress, self.varying = extra_stress, extra_stress is not None and extra_stress.varying
        self.has_body_force = any(problem.acceleration) or problem.keeps_mean_velocity
        self.acceleration = holding(ti.field(vector, ()), (*problem.acceleration, 0.0)[: levels.components])
        self.pressure = BiCGStab(self.operators, pure_neumann=True)
        self.velocity = BiCGStab(
            extra_stress.operators if self.varying else self.operators,
            width=levels.components,
            hoop=self.coordinates.axisymmetric,
        )
        self.for_pressure = TwoLevel(self.pressure, grid, self.bounded)
        self.for_velocity = None if self.bounded else TwoLevel(self.velocity, grid)
        self.u_history, self.u_extrapolated = (ti.field(vector, self.points.slots + 1) for _ in range(2))
        self.alpha, self.beta = (holding(ti.field(real(), VELOCITIES), 0.0) for _ in range(2))
        self.beta_pressure = holding(ti.field(real(), PRESSURES), 0.0)
        self.difference_squared = scalar(0.0)
        self.swirls = self.coordinates.axisymmetric
        if self.swirls:
            self.centripetal = ti.field(real(), self.points.capacity)

    def solve(self, gamma0, dt, viscosity, retained, tolerances):
        """Solve for pressure and velocities; return whether both could be.

        ``retained`` is k gamma_0, ``tolerances`` are those of the pressure and of the velocities.
        """
        solved, self.iterations = True, [0.0, 0.0]
        least = 2 if self.bounded or self.extra_stress else 1
        coupled = self.coupling or self.mean_velocity
        for outer in range(MOST_ITERATIONS if coupled else least):
            if self.extra_stress:
                self.extra_stress.add_stress(self.velocity.x, self.u_history, dt)
            if self.swirls:
                self.add_centripetal(dt, outer > 0)
            if self.extra_stress or self.swirls or outer == 0:
                self.poisson_rhs(dt, retained, gamma0)
            if self.bounded:
                if outer > 0 and not self.coupling:
                    self.find_normal_curls()
                self.wall_rhs(dt, gamma0, viscosity)
            wanted = tolerances if coupled or outer >= least - 1 else np.maximum(tolerances, FIRST_OUTER)
            solved = self.solve_pressure(wanted[0]) and solved
            self.momentum_rhs(dt)
            diffusion = dt * viscosity
            preconditioner = self.for_velocity if diffusion > ROUGH * gamma0 * self.spacing**2 else None
            solved = self.velocity.solve(diffusion, wanted[1], gamma0, preconditioner) and solved
            self.iterations[0] += self.pressure.iterations
            self.iterations[1] += self.velocity.iterations
            if coupled and self._settled() and outer >= least - 1:
                break
        self.sum_difference()
        return solved

    def _settled(self):
        """Change what is coupled with the fluid by what this does; return whether there is no need to."""
        settled = not self.coupling or self.coupling.correct()
        return (not self.mean_velocity or self.mean_velocity.correct()) and settled

    def solve_pressure(self, tolerance):
        """Solve -L p = b; return whether it was solved. Residuals below ``rounding`` count as zero."""
        return self.pressure.solve(1.0, tolerance, 0.0, self.for_pressure, least=self.rounding)

    def accelerate(self, acceleration):
        """Let the body force along x be another one, and that part of it on free bodies which is their buoyancy."""
        view(self.acceleration)[0] = acceleration
        if self.coupling:
            self.coupling.bodies.accelerate(acceleration)

    def error(self):
        """Return the root mean square of the difference of the new from the extrapolated velocities."""
        return math.sqrt(float(view(self.difference_squared)) / int(view(self.points.n_fluid)))

    def begin(self, viscosity, tolerance, forced=False):
        """Solve L p = div f - grad u : grad u for the pressure of the present velocities; return whether it could be.

        ``forced``: whether ``u_history`` holds a body force f.
        """
        self.initial_pressure_rhs(forced)
        for _ in range(MOST_ITERATIONS if self.coupling else 1):
            if self.bounded:
                self.wall_rhs(1.0, 0.0, viscosity)
            solved = self.solve_pressure(tolerance)
            if self.coupling and self.coupling.correct_start(tolerance):
                break
        self.store_pressure()
        return solved

    def find_impulse(self, tolerance, diverges=False):
        """Solve for the impulse of walls that start to move at ``velocity`` U against the fluid; return whether it is.

        The impulse is that of a pressure, phi per unit density: u - grad phi, with L phi = 0 and n . grad phi = -n . U.
        Where the velocities u before the start have a divergence (``diverges``), as measured, L phi = div u.
        """
        self.impulse_rhs(diverges)
        return self.solve_pressure(tolerance)

    @ti.kernel
    def wall_gradients(self):
        """Take the gradients at walls of the velocities that were solved for, where ``levels`` has those."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            d_dx, d_dy = gradients(self.operators, self.velocity.x, i)
            for component in ti.static(range(self.levels.components)):
                self.levels.d_dx[i][component] = d_dx[component]
                self.levels.d_dy[i][component] = d_dy[component]

    @ti.kernel
    def find_normal_curls(self):
        """Find the normal part of the curl of the vorticity at walls, of the velocities that were solved for."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            own, total = self.velocity.x[i], 0.0
            for k in range(self.points.count[i]):
                apart = self.velocity.x[self.points.neighbours[i, k]] - own
                total += self.operators.d_dx[i, k] * apart.y - self.operators.d_dy[i, k] * apart.x
            self.pressure_boundary.vorticity[i] = total
        self.pressure_boundary.find_normal_curls()

    @ti.kernel
    def measured_normal_curls(self):
        """Find the same of the newest time level, whose gradients are measured."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.pressure_boundary.vorticity[i] = self.levels.d_dx[i][1] - self.levels.d_dy[i][0]
        self.pressure_boundary.find_normal_curls()

    @ti.kernel
    def impulse_rhs(self, diverges: bool):
        """Right side of the equation for the impulse."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            self.pressure.x[i] = 0.0
            self.pressure.b[i] = -self.levels.divergence[i] if diverges else 0.0
        if ti.static(self.bounded):
            ti.loop_config(serialize=self.operators.serial_light)
            for i in range(self.points.n_fluid[None], self.points.particles[None]):
                self.pressure.b[i] = self.pressure_boundary.right_side(i, -self.velocity.x[i], 0.0)

    @ti.kernel
    def apply_impulse(self):
        """Let the impulse change the newest velocities."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            gradient = self.pressure_gradient(i)
            self.levels.fields[i][0] -= gradient.x
            self.levels.fields[i][1] -= gradient.y

    @ti.func
    def pressure_gradient(self, i):
        """Return the gradient of the pressure, or of the impulse, at a particle."""
        own, gradient = self.pressure.x[i], ti.Vector([0.0, 0.0])
        for k in range(self.points.count[i]):
            difference = self.pressure.x[self.points.neighbours[i, k]] - own
            gradient += difference * ti.Vector([self.operators.d_dx[i, k], self.operators.d_dy[i, k]])
        return gradient

    @ti.kernel
    def initial_pressure_rhs(self, forced: bool):
        """Right side of the pressure's equation at the start."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = self.levels.d_dx[i], self.levels.d_dy[i]
            self.pressure.b[i] = self.coordinates.gradient_product(i, self.levels.fields, d_dx, d_dy)
            self.pressure.x[i] = 0.0
            if forced:
                self.pressure.b[i] -= self.history_divergence(i)

    @ti.kernel
    def add_centripetal(self, dt: float, again: bool):
        """Add the centripetal term dt W^2 to the radial right-hand side.

        In later outer iterations it replaces the term of the previous iterate.
        """
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            square = self.velocity.x[i].z ** 2
            self.u_history[i].y += dt * (square - (self.centripetal[i] if again else 0.0))
            self.centripetal[i] = square

    @ti.kernel
    def store_pressure(self):
        """Store the pressure as the newest."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.levels.fields[i][self.levels.first_pressure] = self.pressure.x[i]

    @ti.kernel
    def sum_history(self):
        """Sum the time levels: backward differences and extrapolation."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            history, extrapolated = 0.0 * self.velocity.x[i], 0.0 * self.velocity.x[i]
            for level in ti.static(range(VELOCITIES)):
                velocity = self.levels.carried(level, i)
                history += self.alpha[level] * velocity
                extrapolated += self.beta[level] * velocity
            self.u_history[i], self.u_extrapolated[i] = history, extrapolated
            self.velocity.x[i] = extrapolated
            pressure = 0.0
            for level in ti.static(range(PRESSURES)):
                pressure += self.beta_pressure[level] * self.levels.fields[i][self.levels.first_pressure + level]
            self.pressure.x[i] = pressure

    @ti.kernel
    def poisson_rhs(self, dt: float, retained: float, gamma0: float):
        """Right side of the pressure's equation."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            divergence = self.history_divergence(i)
            if ti.static(self.varying):
                divergence += self.extra_stress.implicit_divergence[i]
            kept = retained
            if ti.static(self.closing):
                kept = ti.select(self.pressure_boundary.narrow[i] > 0, gamma0, retained)
            self.pressure.b[i] = (kept * self.levels.divergence[i] - divergence) / dt

    @ti.func
    def history_divergence(self, i):
        """Return the divergence of ``u_history`` at a particle."""
        own, metric = self.u_history[i], self.coordinates.radius(i) ** 2
        divergence = self.coordinates.hoop(own.y)
        for k in range(self.points.count[i]):
            difference = self.u_history[self.points.neighbours[i, k]] - own
            d_dy = metric * self.operators.d_dy[i, k]
            divergence += self.operators.d_dx[i, k] * difference.x + d_dy * difference.y
        return divergence

    @ti.kernel
    def wall_rhs(self, dt: float, gamma0: float, viscosity: float):
        """Right side of the pressure's equation at walls, where the velocities at the end are prescribed."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None], self.points.particles[None]):
            acceleration = (self.u_history[i] - gamma0 * self.velocity.x[i]) / dt + self.acceleration[None]
            local = viscosity
            if ti.static(self.varying):
                local = self.extra_stress.implicit_viscosity(i)
            self.pressure.b[i] = self.pressure_boundary.right_side(i, acceleration, local)

    @ti.kernel
    def momentum_rhs(self, dt: float):
        """Right side of the velocities' equation."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            gradient, known = self.pressure_gradient(i), self.u_history[i]
            if ti.static(self.has_body_force):
                gradient -= ti.Vector([self.acceleration[None].x, self.acceleration[None].y])
            known.x -= dt * gradient.x
            known.y -= dt * gradient.y
            self.velocity.b[i] = known

    @ti.kernel
    def sum_difference(self):
        """Sum the squares of the differences from the extrapolated velocities, in a fixed order."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = 0.0
            for i in range(self.points.n_fluid[None]):
                total += self.coordinates.squared(i, self.velocity.x[i] - self.u_extrapolated[i])
            self.difference_squared[None] = total

    @ti.kernel
    def store(self):
        """Store the solution as the newest time level."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            self.levels.advance_levels(i, self.velocity.x[i], self.pressure.x[i])
