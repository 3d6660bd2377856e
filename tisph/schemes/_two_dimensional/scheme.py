"""Steps of two-dimensional flows in the implicit scheme: predict the end, assemble the operators, solve, shift.

The points, operators and extra stress of a problem are planar or axisymmetric, with walls or without. The state at any
time within the last step follows from the time levels of the particles.
"""

import math
from functools import partial

import numpy as np

from tisph.domain import PeriodicDomain
from tisph.errors import DivergedError
from tisph.least_squares import SKIN
from tisph.least_squares.operators import AxisymmetricOperators, LeastSquaresOperators
from tisph.neighbours.point_cloud import PointCloud, active
from tisph.runtime import integer, real, ti, view
from tisph.schemes._controlled_scheme import ControlledScheme
from tisph.schemes._shifting import TRAVEL, FickianShifting
from tisph.schemes._two_dimensional import step_limits as limits
from tisph.schemes._two_dimensional.coupling import Coupling
from tisph.schemes._two_dimensional.free_bodies import RESIDUAL
from tisph.schemes._two_dimensional.generalised_newtonian_stress import GeneralisedNewtonianStress
from tisph.schemes._two_dimensional.splitting_step import SplittingStep
from tisph.schemes._two_dimensional.time_levels import PRESSURES, VELOCITIES, TimeLevels, TimeWeights
from tisph.schemes._two_dimensional.viscoelastic_stress import ViscoelasticStress
from tisph.schemes._two_dimensional.wall_boundary import WallBoundary
from tisph.schemes._two_dimensional.wall_points import MAX_WALLS, POINT_SUPPORT, WALL_SUPPORT
from tisph.snapshot import STRESSES, STRESSES_AROUND, Snapshot
from tisph.solvers.auxiliary_grid import PeriodicGrid, WalledGrid

SUPPORT = 2.9
"""Support radius of the operators in particle spacings. Below it a lattice that the flow stretches makes them singular
before it has broken up; above it the pressure has larger errors."""

SMALLEST_PIVOT = 1e-3
"""Of the operators: those of order 2, which would take over, are worse than any of order 4 that can be solved for."""

SMALLEST_PIVOT_AT_AXIS = 3e-3
"""The same where the fluid reaches an axis: those of even functions take over. Points on a sphere had 1.8e-3 and 2.6e-3
when their equations of the pressure became singular, and runs with a polymer diverged; others have 3.1e-3 and more."""

TOO_LONG = "u, v: no error of a step is small enough, however short it is: the flow needs a smaller spacing;"
"""Message of a run that stops."""

COURANT = 0.3
"""Longest step over the time in which the fastest particle goes one spacing."""

REORDER_INTERVAL = 100
"""Steps after which particles that have become neighbours are brought near one another in memory, too. Once a flow has
mixed 1e5 of them a step takes 1.7 times as long without."""


class SplittingScheme(ControlledScheme):
    """Particles in a periodic box, advanced step by step; ``time`` and ``steps`` tell how far.

    ``problem`` is a ``PeriodicProblem`` or ``BoundedProblem``; ``targets`` are times that steps end on exactly.
    ``serial`` compiles loops without threads. ``tolerance`` is that of a step's error over the velocity, None for steps
    of the Courant number alone.
    """

    kept = (*ControlledScheme.kept, "dts", "iterations", "initial_momentum", "stress_resolution")

    def __init__(self, problem, targets, serial, tolerance=limits.TOLERANCE, courant=COURANT):
        self.problem, self.initial_momentum, bounded = problem, 0.0, problem.walls is not None
        self.points = points_of(problem, serial)
        self.operators = operators_of(problem, self.points)
        periodic = not bounded
        self.grid = PeriodicGrid(self.points, problem, problem.height) if periodic else WalledGrid(self.points, problem)
        near = (MAX_WALLS, problem.contact is not None, problem.walls.across_axis) if bounded else ()
        self.shift = FickianShifting(self.points, problem.spacing, *near)
        self.levels = TimeLevels(self.operators, self.shift)
        self.wall_boundary = None
        if bounded:
            self.points.n_fluid = integer(problem.n_fluid)
            self.wall_boundary = WallBoundary(problem, self.levels, self.shift, self.grid, SUPPORT, SKIN)
        boundary = self.wall_boundary.pressure_boundary if bounded else None
        self.polymer = ViscoelasticStress(self.levels, problem) if problem.carries_stress else None
        varying = problem.rheology and not problem.carries_stress
        self.extra_stress = GeneralisedNewtonianStress(self.levels, problem) if varying else self.polymer
        self.splitting = SplittingStep(self.levels, self.grid, problem, boundary, self.extra_stress)
        self.control = limits.step_control(problem, targets, tolerance, courant)
        least = limits.ROUNDING * float(np.finfo(np.float64 if real() == ti.f64 else np.float32).eps)
        self.tolerance = limits.TOLERANCE if tolerance is None else tolerance
        if bounded and self.wall_boundary.free:
            self.splitting.coupling = Coupling(self.wall_boundary, self.splitting, least)
        self.residuals = limits.residuals(self.tolerance, least)
        self.reset()

    def reset(self):
        """Go back to before the first step."""
        self.reset_steps(self.problem.start_time)
        self.dts, self.iterations = [], [0.0, 0.0]
        self.output_cache = self.stress_resolution = None
        if self.wall_boundary:
            self.wall_boundary.reset()

    def start(self, position, velocity, stress=None):
        """Place the particles, at (particles, 2), and find the pressure of their velocities (particles, components).

        Polymers start without ``stress``.
        """
        self.initial_momentum = float(velocity[:, 0].sum())
        fluid = self.problem.n_fluid
        active(self.levels.position)[:fluid] = position - np.array(self.problem.origin)
        active(self.levels.fields)[...] = 0.0
        unknowns = self.problem.unknowns(velocity, position[:, 1])
        active(self.levels.fields)[:fluid, : self.levels.components] = unknowns
        active(self.levels.number)[:fluid] = np.arange(len(position))
        view(self.levels.step_weights)[...] = 0.0
        self.levels.predict()
        self.assemble(self.time)
        if self.problem.has_own_start:
            if self.wall_boundary:
                self.wall_boundary.regular_velocities[self.wall_boundary.slots, 0] = self.wall_boundary.fluid_velocity
            self.levels.measure()
        if self.wall_boundary:
            more = partial(self.mean_velocity.start, self.time, self.residuals[0]) if self.mean_velocity else None
            self.require_solution(self.wall_boundary.begin(self.splitting, self.residuals[0], more))
        elif self.problem.has_own_start:
            self.require_solution(self.splitting.find_impulse(self.residuals[0], diverges=True))
            self.splitting.apply_impulse()
        if self.problem.has_own_start:
            change = np.abs(active(self.levels.fields)[:fluid, : self.levels.components] - unknowns).max()
            self.removed_divergence = float(change / (np.abs(unknowns).max() or 1.0))
        self.levels.measure()
        if self.extra_stress:
            self.extra_stress.begin()
        forced = self.problem.body_force is not None
        if forced:
            view(self.splitting.u_history)[:fluid] = self.body_force(self.time)[:fluid]
        self.require_solution(self.splitting.begin(self.problem.solvent_viscosity, self.residuals[0], forced))
        if self.wall_boundary:
            self.wall_boundary.measure(self.time, self.extra_stress)
            self.wall_boundary.find_fastest()
        self.begin_steps()

    @property
    def mean_velocity(self):
        """``MeanVelocityControl`` where a pressure gradient keeps the mean velocity; None without."""
        return self.splitting.mean_velocity

    @property
    def speed(self):
        """Largest velocity relative to the mean: what steps refer to."""
        return limits.courant_speed(float(view(self.levels.fastest)), self.problem)

    @property
    def error_speed(self):
        """The same that errors of steps are divided by."""
        return limits.error_speed(float(view(self.levels.largest)), self.problem)

    @property
    def residual(self):
        """Divergence of the velocities over their gradient, where that is not too small to tell."""
        return self.levels.residual(limits.LEAST_GRADIENT * self.error_speed / self.problem.spacing)

    def begin_steps(self):
        """Choose the first step, or the first one after a change."""
        self.control.dt_next = limits.FIRST * self.control.limit(self.speed)

    def advance(self):
        """Take one step, in as many attempts as its error asks for; raise DivergedError where it runs away."""
        if self.time in self.problem.jump_times:
            self.dts = []  # no polynomial in time continues past a jump
            self.wall_boundary.jump(self.time)
            self.begin_steps()
        unresolved = self.levels.divergence_scale * self.problem.spacing / self.error_speed
        dt, error = self.control.take(self.time, self.attempt, unresolved)
        if dt is None and math.isinf(error):
            raise self.diverged("bodies overlap, or no velocities are found for them, whatever the step,")
        if dt is None:
            raise self.diverged(TOO_LONG)
        self.accept_step(dt)

    def attempt(self, dt):
        """Compute the velocities at the end of a step; return their error over the largest one, and its order."""
        if self.time + 0.1 * dt == self.time:
            raise self.diverged(TOO_LONG)
        times = TimeWeights([dt, *self.dts], dt)
        view(self.levels.step_weights)[...] = times.step_integral()
        self.levels.predict()
        if self.wall_boundary:
            self.wall_boundary.predict(times, dt)
        coupling = self.splitting.coupling
        if coupling:
            coupling.prepare(times, dt, self.time + dt)
            coupling.least = RESIDUAL * self.tolerance * self.error_speed
            if coupling.bodies.overlap:
                return math.inf, 1
        self.assemble(self.time + dt)
        gamma0, alpha = times.bdf()
        if self.mean_velocity:
            self.mean_velocity.prepare(dt, gamma0, self.time + dt, self.tolerance * self.error_speed)
        view(self.splitting.alpha)[...] = alpha
        view(self.splitting.beta)[...] = times.extrapolation(VELOCITIES)
        view(self.splitting.beta_pressure)[...] = times.extrapolation(PRESSURES)
        nu = self.problem.solvent_viscosity
        if self.extra_stress:
            self.extra_stress.prepare(times, dt, self.time + dt)
            nu += self.extra_stress.viscosity
        decay = limits.DECAY[0] * nu / self.problem.spacing**2 + limits.DECAY[1] * self.speed / self.problem.spacing
        retained = max(0.0, gamma0 - decay * dt)
        self.splitting.sum_history()
        if not self.dts:  # what is carried along as a whole is right from the first guess on, but for rounding errors
            view(self.splitting.velocity.x)[: self.problem.n_fluid, :2] += dt * np.array(self.problem.acceleration)
        if self.problem.body_force:
            force = self.body_force(self.time + dt)
            view(self.splitting.u_history)[: len(force)] += dt * force
        if self.wall_boundary:
            self.wall_boundary.set_wall_velocities(self.splitting, times)
            self.wall_boundary.add_corner_force(self.splitting, times, dt)
        self.require_solution(self.splitting.solve(gamma0, dt, nu, retained, self.residuals))
        error = max(self.splitting.error(), coupling.error() if coupling else 0.0)
        if math.isnan(error):
            self.require_solution(False)
        error, order = times.step_error(error, gamma0, self.error_speed)
        return error / self.error_speed, order

    def body_force(self, time):
        """Return the body force (points, components) at ``time`` at the points, divided as the unknowns are."""
        x, y = self.problem.places(view(self.points.position)[: int(view(self.points.particles))].astype(float))
        return self.problem.unknowns_given(self.problem.body_force, x, y, time)

    def assemble(self, time):
        """Set the positions of the points at the end of a step, at ``time``, and compute the operators there."""
        if self.wall_boundary:
            self.wall_boundary.update_positions(time)
        self.points.find_neighbours()
        self.require_room("neighbours of a particle", self.points.overflow())
        self.operators.assemble()
        self.grid.sort()
        if self.wall_boundary:
            self.wall_boundary.impose_neumann_rows()

    def require_solution(self, found):
        """Raise DivergedError where the linear systems have none."""
        if not found:
            raise self.diverged("u, v, pressure: the linear systems cannot be solved")

    def accept_step(self, dt):
        """Store the new velocities, measure them, and shift the particles."""
        self.splitting.store()
        self.levels.measure()
        if self.wall_boundary:
            self.splitting.measured_normal_curls()
            self.wall_boundary.store_normal_curls()
        if self.extra_stress:
            self.stress_resolution = self.extra_stress.take_up(self.splitting.velocity.x, self.steps + 1)
        if self.wall_boundary:
            self.wall_boundary.measure(self.time + dt, self.extra_stress)
        if self.mean_velocity:
            self.mean_velocity.accept()
        if self.wall_boundary and self.wall_boundary.free:
            self.wall_boundary.free.accept(self.control.end(self.time, dt))
        travelled = dt * self.speed / self.problem.spacing
        self.shift.shift(self.steps == 0 and not self.wall_boundary, min(1.0, travelled / TRAVEL))
        self.levels.remap()
        if self.polymer:
            self.polymer.remap()
        if self.wall_boundary:
            self.wall_boundary.find_fastest()
        if self.speed > limits.RUNAWAY * self.problem.reference_velocity:
            text = f"{limits.RUNAWAY:g} times the reference velocity {self.present_step}"
            cure = "a reference.velocity, if the body force drives it, else " if self.problem.body_force else ""
            raise DivergedError(f"u, v: above {text}: the flow needs {cure}a smaller spacing")
        if (self.steps + 1) % REORDER_INTERVAL == 0:
            self.levels.reorder([self.polymer.tensors] if self.polymer else [])
        self.dts = [dt, *self.dts][: VELOCITIES - 1]
        self.end_step(dt, self.speed)
        self.iterations = [sum(pair) for pair in zip(self.iterations, self.splitting.iterations, strict=True)]

    def snapshot(self, time=None):
        """Return the state at ``time``, within the last step, or now, as a Snapshot.

        It lies on the polynomial through the time levels, in the order of creation; ``output_cache`` holds those of the
        last step, since many outputs may fall into one.
        """
        time = self.time if time is None else time
        if self.output_cache is None or self.output_cache[0] != self.time:
            fluid = self.problem.n_fluid
            created = np.argsort(active(self.levels.number)[:fluid])
            stored = [self.levels.fields, self.levels.position, *([self.polymer.tensors] if self.polymer else [])]
            fields = (active(field)[:fluid][created].astype(float) for field in stored)
            self.output_cache = self.time, created, *fields
        problem, walls, offset = self.problem, self.wall_boundary, self.time - time
        _, created, fields, position, *tensors = self.output_cache
        dts = self.dts or [1.0]
        times = TimeWeights([0.0, *dts], dts[0])
        first, components = self.levels.first_pressure, self.levels.components
        velocities = fields[:, :first].reshape(len(fields), VELOCITIES, components)
        axis = position[:, 1] + problem.origin[1]
        velocities = np.stack([problem.velocities(velocities[:, level], axis) for level in range(VELOCITIES)], axis=1)
        pressure, velocity = fields[:, first], velocities[:, 0]
        if offset:
            velocity = np.einsum("a,iac->ic", times.interpolation(offset, VELOCITIES), velocities)
            position = position - np.einsum("a,iac->ic", times.integral(offset), velocities[..., :2])
            pressure = fields[:, first:] @ times.interpolation(offset, PRESSURES)
            if problem.axisymmetric:  # what is interpolated around the axis is the circulation
                velocity[:, 2] *= axis / (position[:, 1] + problem.origin[1])
        if walls and walls.corners:
            if offset:
                at = lambda part: times.interpolation(part * offset, VELOCITIES)  # noqa: E731
                position = walls.corners.paths.find(at, -offset)[created]
            velocity = velocity + walls.corners.velocity(position)
            pressure = pressure + walls.corners.pressure(position)
        stress = [problem.density * part for part in self.polymer.at(times, offset, *tensors, axis)] if tensors else []
        return Snapshot(
            t=time,
            step=self.steps,
            **dict(zip("xy", problem.places(position), strict=True)),
            u=velocity[:, 0].copy(),
            v=velocity[:, 1].copy(),
            w=velocity[:, 2].copy() if problem.axisymmetric else None,
            density=np.full(len(position), problem.density),
            pressure=problem.density * (pressure - pressure.mean()),
            bodies=walls.bodies(time, times, offset) if walls else None,
            steepest=self.stress_resolution if self.polymer else None,
            added_power=None if self.polymer else self.stress_resolution,
            load_scatter=walls.load_scatter if walls else None,
            divergence=self.residual,
            acceleration=self.mean_velocity.acceleration if self.mean_velocity else None,
            **dict(zip((*STRESSES, *STRESSES_AROUND), stress, strict=False)),
        )

    def momentum_balance(self):
        """Return the ``change`` of momentum along x up to ``time`` [mass * velocity per length], which has no cause."""
        if self.wall_boundary:  # forces of walls are in the samples
            return {}
        gained = float(active(self.levels.fields)[:, 0].sum(dtype=float)) - self.initial_momentum
        return {"change": self.problem.density * self.problem.spacing**2 * gained}

    def numbers(self):
        """Return the numbers of this scheme for ``summary.json``."""
        return {
            **super().numbers(),
            "particles_wall": 0,
            "divergence": self.residual,
            "iterations_pressure": self.iterations[0] / max(self.steps, 1),
            "iterations_velocity": self.iterations[1] / max(self.steps, 1),
            **(self.wall_boundary.contacts() if self.wall_boundary else {}),
        }

    def parts(self):
        """Return everything whose fields a resumed run needs, by name."""
        return {"levels": self.levels, **({"polymer": self.polymer} if self.polymer else {})}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        walls = self.wall_boundary.host_state() if self.wall_boundary else None
        mean = self.mean_velocity.state() if self.mean_velocity else None
        return {**super().host_state(), "walls": walls, "mean_velocity": mean}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        super().restore_host_state(state)
        if self.wall_boundary:
            self.wall_boundary.restore_host_state(state["walls"])
        if self.mean_velocity:
            self.mean_velocity.restore(state["mean_velocity"])


def points_of(problem, serial):
    """Return the ``PointCloud``, whose points near walls have wider supports; ``serial``: without threads."""
    cutoff = (SUPPORT + SKIN) * problem.spacing
    if problem.walls is not None:
        cutoff = cutoff, cutoff + (MAX_WALLS * WALL_SUPPORT + POINT_SUPPORT) * problem.spacing
    return PointCloud(problem, PeriodicDomain(problem.length, problem.height), cutoff, 0, serial)


def operators_of(problem, points):
    """Return the operators of ``points`` (``PointCloud``), planar or axisymmetric."""
    bounded = problem.walls is not None
    # in polar coordinates points lie in layers: near walls operators then have 70 times the rounding errors
    curved = bounded and problem.walls.curved and real() == ti.f64
    pivot = SMALLEST_PIVOT_AT_AXIS if problem.axisymmetric and not problem.annular else SMALLEST_PIVOT
    chosen = points, SUPPORT * problem.spacing, 4, pivot, bounded, curved
    if problem.axisymmetric:
        return AxisymmetricOperators(*chosen, lowest_radius=problem.origin[1], annular=problem.annular)
    return LeastSquaresOperators(*chosen)
