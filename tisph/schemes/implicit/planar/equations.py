"""The equations of pressure and velocities in a step: right-hand sides, and the solvers of their linear systems.

``Equations`` has what all steps need, and the equations of the start. A step is solved by ``Splitting``, one system for
the pressure and one for the velocities, or, in slow flow, by ``Coupled``, one system for all (``numerics/stokes.py``).
With the forcing f, which is u^ of ``scheme.PlanarScheme.attempt`` and all explicit forces times dt, splitting solves

    L p = (D f - k gamma_0 d^n) / dt,      (gamma_0 - dt nu L) u^(n+1) = f - dt (G p - g),

equations (2) and (3) of docs/theory/two-dimensional.md. All operators belong to the arrangement at the end of the step.
L p is the Laplacian itself, not D G p, which on particles has spurious modes; so the divergence d of the
velocities is not quite 0, and where steps are short asking for 0 anew in each would let pressures grow like 1/dt. Hence
k: divergence decays at a rate of its own instead.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.numerics.auxiliary_grid import TwoLevel
from tisph.numerics.bicgstab import BiCGStab
from tisph.numerics.stokes import StokesSolver, Unknowns
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes.implicit.planar.parts import MOST_ITERATIONS, Boundary, Coupling, ExtraStress
from tisph.schemes.implicit.planar.time_levels import PRESSURES, VELOCITIES, TimeWeights, gradients

ROUGH = 1.0
"""Viscous number dt nu/(gamma_0 spacing^2) up to which Jacobi suffices as a preconditioner. Between walls, where it is
2.7 at most (``MOST_VISCOUS``), it always does: there are twice as many iterations, in half the time."""

FIRST_OUTER = 1e-3, 1e-6
"""Residuals of the first of two outer iterations, from which only the curl at walls is used: with 1e-4 and 1e-8 errors
between cylinders are the same to four digits. With couplings, which use the loads as well, none are less exact."""

SETTLED = 0.1
"""Largest change of the velocities of a fluid without inertia whose viscosity varies, over the tolerance of a step:
errors that are left would grow, as extrapolation multiplies them by up to 15."""

LEFT = 1 / 30
"""Largest error that outer iterations of a polymer without inertia leave, over the first change of the velocities: the
next extrapolation multiplies it by up to 15. In a contraction 4:1 (24 across, De = 0.5, a solvent fraction of 1/9) half
of the steps take two iterations, the others three or four, and velocities scatter by 6e-4 after 2.7 relaxation times.
With two in every step it is 1.4e-2, and grows."""


@dataclass(frozen=True)
class Step:
    """A step ``dt`` up to ``end``: ``gamma0``, ``viscosity`` of its implicit part, and error ``allowed`` of velocities.

    ``retained``: k gamma_0, by which divergence stays, where the spacing is the largest one. ``decay``: dt times the
    two terms of its decay there, ``step_limits.decay_rates``.
    """

    dt: float
    end: float
    gamma0: float
    viscosity: float
    retained: float
    decay: tuple[float, float]
    allowed: float


@ti.data_oriented
class Equations:
    """The ``forcing`` (points,) of a step, its solvers of ``pressure`` and ``velocity``, and the body ``acceleration``.

    ``extrapolated`` (points,): velocities extrapolated to the end of the step, from which the solvers start and from
    which the error is estimated. ``sources`` (fluid,) of the pressure equation, None without any. ``iterations``: of
    both solvers in the present step. ``may_scatter``: whether velocities follow the places of particles or bodies at
    once, and scatter from step to step as those do; then differences of lower order are known. ``least_iterations``:
    outer iterations of a step. ``residuals``: relative ones of pressure and velocities.
    """

    least_iterations = 1

    def __init__(self, grid: Any, boundary: Boundary, extra_stress: ExtraStress, residuals: Sequence[float]) -> None:
        problem, levels, self.residuals = boundary.problem, boundary.levels, residuals
        self.levels, self.operators, self.points = levels, levels.operators, levels.points
        self.coordinates, self.boundary, self.extra_stress = levels.coordinates, boundary, extra_stress
        self.spacing, components = problem.spacing, levels.components
        vector = ti.types.vector(components, real())
        self.has_inertia = problem.inertia
        self.has_body_force = any(problem.acceleration) or problem.kept_mean_velocity is not None
        self.acceleration = holding(ti.field(vector, ()), (*problem.acceleration, 0.0)[:components])
        closed = boundary.outlet is None
        outlet = {} if closed else {"number": self.points.particles, "outlet": boundary.outlet}
        self.pressure = BiCGStab(self.operators, pure_neumann=closed, number=boundary.outlet)
        self.velocity = BiCGStab(
            extra_stress.operators,
            width=components,
            hoop=self.coordinates.axisymmetric,
            outlet_area=problem.spacing**2,
            **outlet,
        )
        self.for_pressure = TwoLevel(self.pressure, grid, boundary.bounded)
        self.forcing, self.extrapolated = (ti.field(vector, self.points.slots + 1) for _ in range(2))
        self.alpha, self.beta = (holding(ti.field(real(), VELOCITIES), 0.0) for _ in range(2))
        self.beta_pressure = holding(ti.field(real(), PRESSURES), 0.0)
        self.may_scatter = problem.contact is not None or not problem.inertia
        self.beta_lower = holding(ti.field(real(), VELOCITIES), 0.0)
        self.difference_squared, self.lower_squared = scalar(0.0), scalar(0.0)
        self.iterations = [0.0, 0.0]
        self.sources: np.ndarray | None = None
        self.forcing_varies = extra_stress.nonlinear or self.coordinates.axisymmetric
        self.explicit = np.empty(0)

    def assemble(self) -> None:
        """Set the matrices of the present operators."""

    def forget(self) -> None:
        """Take note that points have other numbers."""
        for solver in (self.pressure, self.velocity, self.for_pressure):
            solver.forget()

    def solve(self, step: Step, outer: int, couplings: Sequence[Coupling]) -> bool:
        """Solve for velocity and pressure in outer iteration number ``outer``; return whether it was possible."""
        raise NotImplementedError

    def settled(self, step: Step) -> bool:
        """Return whether outer iterations may end."""
        return True

    def begin_step(self, weights: TimeWeights, alpha: np.ndarray) -> None:
        """Sum the time levels, equation (1): the forcing by ``alpha``, and the extrapolated velocity and pressure."""
        view(self.alpha)[...] = alpha
        view(self.beta)[...] = weights.extrapolation(VELOCITIES)
        view(self.beta_pressure)[...] = weights.extrapolation(PRESSURES)
        view(self.beta_lower)[...] = weights.lower_extrapolation()
        self.iterations, self.sources = [0.0, 0.0], None
        self.sum_levels()

    def form_forcing(self, dt: float, outer: int) -> None:
        """Add the forces of the present velocity to the explicit part of the ``forcing``: stress, centripetal force.

        The explicit part is the ``forcing`` before the first outer iteration, number 0.
        """
        if outer == 0 and self.forcing_varies:
            self.explicit = view(self.forcing).copy()
        elif self.forcing_varies:
            view(self.forcing)[...] = self.explicit
        else:
            return
        self.extra_stress.add_stress(self.velocity.x, self.forcing, dt)
        if self.has_inertia:
            self.coordinates.add_centripetal(self.velocity.x, self.forcing, dt)

    def accelerate(self, acceleration: float) -> None:
        """Change the body force along x."""
        view(self.acceleration)[0] = acceleration

    def set_wall_velocity(self, velocity: np.ndarray) -> None:
        """Prescribe the velocities (count, components) at the points on walls."""
        view(self.velocity.x)[self.boundary.slots] = velocity

    def solve_pressure(self, tolerance: float, rounding: float = 0.0) -> bool:
        """Solve -L p = b; return whether it was solved. Residuals below ``rounding`` count as zero."""
        # with pressures given at both ends b may be 0 where p is not: the size that b has for their gradient counts
        scale = self.boundary.pressure_gradient * math.sqrt(self.points.in_fluid) / self.spacing
        least = max(rounding, tolerance * scale)
        solved = self.pressure.solve(1.0, tolerance, 0.0, self.for_pressure, least=least)
        self.iterations[0] += self.pressure.iterations
        return solved

    def error(self) -> tuple[float, float]:
        """Return the root mean square difference of the new from the extrapolated velocities, and of lower order."""
        self.sum_difference()
        area = self.points.area
        difference, lower = (float(view(each)) / area for each in (self.difference_squared, self.lower_squared))
        return math.sqrt(difference), math.sqrt(lower)

    def begin(self, viscosity: float, tolerance: float, forced: bool, couplings: Sequence[Coupling]) -> bool:
        """Solve L p = div f - grad u : grad u for the pressure of the first velocities; return whether it was solved.

        ``forced``: whether the ``forcing`` holds a body force f. ``couplings`` find accelerations by this pressure.
        """
        self.set_first_divergence(forced)
        for _ in range(MOST_ITERATIONS):
            self.boundary.add_normal_momentum(self, 1.0, 0.0, viscosity)
            solved = self.solve_pressure(tolerance)
            if all([coupling.correct_start(self, tolerance) for coupling in couplings]):
                break
        self.levels.store_pressure(self.pressure.x)
        return solved

    def find_impulse(self, tolerance: float, diverges: bool = False) -> bool:
        """Solve for the impulse of walls that start to move at ``velocity`` U against the fluid; return whether it is.

        A pressure, phi per unit density, changes u to u - grad phi, with L phi = 0 and n . grad phi = -n . U. Where the
        velocities u before the start have a divergence (``diverges``), as measured, L phi = div u.
        """
        self.set_impulse_divergence(diverges)
        self.boundary.add_impulse_momentum(self.pressure.b, self.velocity.x)
        return self.solve_pressure(tolerance)

    @ti.kernel
    def sum_levels(self):
        """Sum the time levels: backward differences, and extrapolation to the end of the step."""
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(self.points.particles[None]):
            history, extrapolated = 0.0 * self.velocity.x[i], 0.0 * self.velocity.x[i]
            for level in ti.static(range(VELOCITIES)):
                velocity = self.levels.carried(level, i)
                history += self.alpha[level] * velocity
                extrapolated += self.beta[level] * velocity
            self.forcing[i], self.extrapolated[i] = history, extrapolated
            self.velocity.x[i] = extrapolated
            pressure = 0.0
            for level in ti.static(range(PRESSURES)):
                pressure += self.beta_pressure[level] * self.levels.fields[i][self.levels.first_pressure + level]
            self.pressure.x[i] = pressure

    @ti.func
    def divergence_of_forcing(self, i):
        """Return the divergence of the forcing at a particle."""
        own, metric = self.forcing[i], self.coordinates.radius(i) ** 2
        divergence = self.coordinates.hoop(own.y)
        for k in range(self.points.begin[i], self.points.end[i]):
            difference = self.forcing[self.points.neighbours[k]] - own
            d_dy = metric * self.operators.d_dy[k]
            divergence += self.operators.d_dx[k] * difference.x + d_dy * difference.y
        return divergence

    @ti.kernel
    def set_first_divergence(self, forced: bool):
        """Set the right-hand side of the pressure at the start."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            d_dx, d_dy = self.levels.d_dx[i], self.levels.d_dy[i]
            self.pressure.b[i] = self.coordinates.gradient_product(i, self.levels.fields, d_dx, d_dy)
            self.pressure.x[i] = 0.0
            if forced:
                self.pressure.b[i] -= self.divergence_of_forcing(i)

    @ti.kernel
    def set_impulse_divergence(self, diverges: bool):
        """Set the right-hand side of the impulse at all points."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.particles[None]):
            self.pressure.x[i] = 0.0
            self.pressure.b[i] = -self.levels.divergence[i] if diverges else 0.0

    @ti.kernel
    def sum_difference(self):
        """Sum the squares of the differences from the extrapolated velocities, in a fixed order."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            total, lower = 0.0, 0.0
            for i in range(self.points.n_fluid[None]):
                square = self.coordinates.squared(i, self.velocity.x[i] - self.extrapolated[i])
                weight = self.boundary.error_weight(i) * self.points.relative(i) ** 2
                total += weight * square
                if ti.static(self.may_scatter):
                    rest = self.velocity.x[i]
                    for level in ti.static(range(VELOCITIES - 1)):
                        rest -= self.beta_lower[level] * self.levels.carried(level, i)
                    lower += weight * self.coordinates.squared(i, rest)
            self.difference_squared[None], self.lower_squared[None] = total, lower


@ti.data_oriented
class Splitting(Equations):
    """The pressure from the divergence of the forcing, then the velocities with its gradient: equations (2) and (3).

    ``for_velocity``: preconditioner of the velocities where steps are viscous.
    """

    def __init__(self, grid: Any, boundary: Boundary, extra_stress: ExtraStress, residuals: Sequence[float]) -> None:
        super().__init__(grid, boundary, extra_stress, residuals)
        self.for_velocity = None if boundary.bounded or self.points.graded else TwoLevel(self.velocity, grid)
        self.least_iterations = 2 if boundary.bounded or extra_stress.nonlinear else 1

    def solve(self, step: Step, outer: int, couplings: Sequence[Coupling]) -> bool:
        """Solve for the pressure, and with its gradient for the velocities; return whether both were possible."""
        if outer == 0 or self.forcing_varies or self.sources is not None:
            self.set_divergence(step)
        if outer > 0 and not any(coupling.sets_curls for coupling in couplings):
            self.boundary.update_normal_curls(self.velocity.x)
        self.boundary.add_normal_momentum(self, step.dt, step.gamma0, step.viscosity)
        exact = couplings or outer >= self.least_iterations - 1
        residuals = self.residuals if exact else np.maximum(self.residuals, FIRST_OUTER)
        solved = self.solve_pressure(residuals[0], max((each.rounding for each in couplings), default=0.0))
        self.set_momentum(step.dt)
        diffusion = step.dt * step.viscosity
        preconditioner = self.for_velocity if diffusion > ROUGH * step.gamma0 * self.spacing**2 else None
        found = self.velocity.solve(diffusion, residuals[1], step.gamma0, preconditioner)
        self.iterations[1] += self.velocity.iterations
        return solved and found

    def set_divergence(self, step: Step) -> None:
        """Set the right-hand side of the pressure, equation (2), and add the sources."""
        self.set_divergence_of_forcing(step.dt, step.retained, step.gamma0, *step.decay)
        if self.sources is not None:
            view(self.pressure.b)[: len(self.sources)] += self.sources

    @ti.kernel
    def set_divergence_of_forcing(self, dt: float, retained: float, gamma0: float, viscous: float, convective: float):
        """Set the right-hand side of the pressure, equation (2), with ``retained`` = k gamma_0.

        Where the spacing varies k follows from the decay by its two terms.
        """
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            kept = retained
            if ti.static(self.points.graded):
                relative = self.points.relative(i)
                kept = ti.max(0.0, gamma0 - viscous / relative**2 - convective / relative)
            divergence = self.extra_stress.with_viscous_divergence(i, self.divergence_of_forcing(i))
            self.pressure.b[i] = (self.boundary.divergence_to_keep(i, kept, gamma0) - divergence) / dt

    @ti.kernel
    def set_momentum(self, dt: float):
        """Set the right-hand side of the velocities, equation (3)."""
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(self.points.n_fluid[None]):
            known = self.forcing[i]
            d_dx, d_dy = gradients(self.operators, self.pressure.x, i)
            gradient = ti.Vector([d_dx, d_dy])
            if ti.static(self.has_body_force):
                gradient -= ti.Vector([self.acceleration[None].x, self.acceleration[None].y])
            known.x -= dt * gradient.x
            known.y -= dt * gradient.y
            self.velocity.b[i] = known


class GivenFlow(Equations):
    """Velocities that are a function of places and time: nothing is solved for, and the pressure is 0."""

    def begin(self, viscosity: float, tolerance: float, forced: bool, couplings: Sequence[Coupling]) -> bool:
        """Leave the pressure at 0."""
        return True

    def form_forcing(self, dt: float, outer: int) -> None:
        """Form no forcing: it has no effect."""

    def solve(self, step: Step, outer: int, couplings: Sequence[Coupling]) -> bool:
        """Set the velocities of the particles; points on walls have those of their walls."""
        problem, fluid = self.boundary.problem, self.points.in_fluid
        assert problem.kinematics is not None
        x, y = problem.places(view(self.points.position)[:fluid].astype(float))
        view(self.velocity.x)[:fluid] = problem.unknowns_given(problem.kinematics, x, y, step.end)
        return True


class Coupled(Equations):
    """Velocities, pressure and the unknowns of couplings at once, equations (9) to (12), by the ``stokes`` solver.

    ``velocity_changes``: root mean square changes of the velocities by the solutions of the present step.
    """

    def __init__(
        self, grid: Any, boundary: Boundary, extra_stress: ExtraStress, residuals: Sequence[float], residual: float
    ) -> None:
        super().__init__(grid, boundary, extra_stress, residuals)
        self.stokes = StokesSolver(self.operators, grid, self.levels.components, self.spacing)
        self.residual, self.velocity_changes = residual, [0.0]
        self.least_iterations = 2 if extra_stress.nonlinear else 1
        self.must_settle = extra_stress.nonlinear and not self.has_inertia
        self.carries_stress = boundary.problem.carries_stress

    def assemble(self) -> None:
        """Set the matrices of the present operators."""
        self.stokes.assemble(self.boundary.stokes_rows())

    def solve(self, step: Step, outer: int, couplings: Sequence[Coupling]) -> bool:
        """Solve for everything, to ``residual`` of the allowed error; return whether it was possible."""
        n, fluid, stokes = self.points.fluid, self.points.in_fluid, self.stokes
        sigma = step.gamma0 / step.dt if self.has_inertia else 0.0
        stokes.set_step(sigma, self.extra_stress.local_viscosities(step.viscosity, n))
        velocity, pressure = view(self.velocity.x)[:n].astype(float), view(self.pressure.x)[:n].astype(float)
        force = view(self.forcing)[:n] / step.dt + view(self.acceleration)
        blocks = [coupling.unknowns(step.dt) for coupling in couplings]
        others = Unknowns.joined(blocks, (n - fluid) * self.levels.components, n)
        divergence = view(self.levels.divergence)[:fluid]
        allowed = self.residual * step.allowed
        at_outlets = self.boundary.outlet_pressure(velocity)
        solved, found = stokes.solve(velocity, pressure, force, divergence, others, allowed, at_outlets)
        change = math.sqrt(np.square(velocity[:fluid] - view(self.velocity.x)[:fluid]).sum() / fluid)
        self.velocity_changes = [*self.velocity_changes, change] if outer else [change]
        view(self.velocity.x)[:n], view(self.pressure.x)[:n] = velocity, pressure
        self.iterations[0] += stokes.iterations
        for coupling, block in zip(couplings, blocks, strict=True):
            coupling.take(self, found[: len(block.load)])
            found = found[len(block.load) :]
        return solved

    def settled(self, step: Step) -> bool:
        """Return whether the velocities hardly change, where the stress is not linear in a fluid without inertia.

        Of a polymer the error that is left is estimated, too, from the last two changes: they fall by a factor.
        """
        if not self.must_settle or self.velocity_changes[-1] <= SETTLED * step.allowed:
            return True
        if not self.carries_stress or len(self.velocity_changes) < 2:
            return False
        factor = self.velocity_changes[-1] / self.velocity_changes[-2]
        return factor < 1.0 and self.velocity_changes[-1] * factor / (1.0 - factor) <= LEFT * self.velocity_changes[0]
