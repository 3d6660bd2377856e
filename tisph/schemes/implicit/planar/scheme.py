"""The implicit scheme of two-dimensional flow: its start, its step, and the state within the last step.

The method is the velocity correction of G. E. Karniadakis, M. Israeli, S. A. Orszag, J. Comput. Phys. 97 (1991)
414-443, along the paths of the particles, where there is no convective term. ``PlanarScheme.attempt`` is the step.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tisph.errors import DivergedError
from tisph.numerics import SKIN
from tisph.numerics.auxiliary_grid import PeriodicGrid, WalledGrid
from tisph.numerics.domain import PeriodicDomain
from tisph.numerics.graded_grid import GradedGrid
from tisph.numerics.least_squares import AxisymmetricOperators, LeastSquaresOperators
from tisph.numerics.point_cloud import PointCloud, active
from tisph.numerics.shifting import FickianShifting
from tisph.runtime import real, ti, view
from tisph.schemes._controlled_scheme import ControlledScheme
from tisph.schemes.implicit.planar import step_limits as limits
from tisph.schemes.implicit.planar.body_exchange import BodyExchange, Particles
from tisph.schemes.implicit.planar.equations import Coupled, Equations, GivenFlow, Splitting, Step
from tisph.schemes.implicit.planar.free_bodies import FreeBodyPart
from tisph.schemes.implicit.planar.generalised_newtonian_stress import GeneralisedNewtonianStress
from tisph.schemes.implicit.planar.insertion import Insertion
from tisph.schemes.implicit.planar.mean_velocity import MeanVelocityControl
from tisph.schemes.implicit.planar.open_ends import OpenEnds
from tisph.schemes.implicit.planar.parts import (
    COARSE_SIDE,
    MOST_ITERATIONS,
    Boundary,
    Coupling,
    ExtraStress,
)
from tisph.schemes.implicit.planar.problem import Problem
from tisph.schemes.implicit.planar.slip import SlippingWalls
from tisph.schemes.implicit.planar.time_levels import PRESSURES, VELOCITIES, TimeLevels, TimeWeights
from tisph.schemes.implicit.planar.transport import CarriedSubstances, Transport
from tisph.schemes.implicit.planar.viscoelastic_stress import ViscoelasticStress
from tisph.schemes.implicit.planar.wall_boundary import WallBoundary
from tisph.schemes.implicit.planar.wall_points import MAX_WALLS, POINT_SUPPORT, WALL_SUPPORT
from tisph.snapshot import STRESSES, STRESSES_AROUND, Snapshot

SUPPORT = 2.9
"""Support radius of the operators in particle spacings. Below it a lattice that the flow stretches makes them singular
before it has broken up; above it the pressure has larger errors."""

SMALLEST_PIVOT = 1e-3
"""Smallest pivot of the operators: operators of order 2 instead are worse than any of order 4 that can be solved
for."""

SMALLEST_PIVOT_GRADED = 1e-4
"""The same where the spacing varies, in double precision. Where particles beside a cylinder came to lie in layers, 18
operators of 24 steps had pivots below 1e-3. Of order 2, each let the divergence there rise to four times its value, and
the lift jump by twice its scatter."""

SMALLEST_PIVOT_AT_AXIS = 3e-3
"""Smallest pivot where the fluid reaches an axis: operators of even functions take over. Points on a sphere had 1.8e-3
and 2.6e-3 when their pressure equations became singular, and runs with a polymer diverged; others have 3.1e-3 or
more."""

TOO_LONG = "u, v: no error of a step is small enough, however short it is,"
"""Message of a run that stops."""

COURANT = 0.3
"""Longest step over the time in which the fastest particle goes one spacing."""

TINY = 1e-30
"""Least difference of velocities, over the velocity of reference, that has a logarithm."""

INSTANT = 1e-6
"""Length of a step that finds the flow of one time, over the longest step."""

REORDER_INTERVAL = 100
"""Steps after which particles that have become neighbours are brought near one another in memory, too. Once a flow has
mixed 1e5 of them a step takes 1.7 times as long without."""


class PlanarScheme(ControlledScheme):
    """Particles in a box, with walls or without, advanced step by step.

    ``targets`` are times that steps end on exactly.
    ``serial`` compiles loops without threads. ``tolerance``: error of a step over the velocity, None for steps of the
    Courant number alone. ``error_ratio``: see ``step_limits.step_control``. The parts of a step are ``levels``,
    ``boundary``, ``extra_stress`` and ``couplings`` (``parts.py``); ``equations`` has the linear systems.
    """

    kept = (*ControlledScheme.kept, "dts", "iterations", "initial_momentum", "stress_resolution")

    def __init__(
        self,
        problem: Problem,
        targets: Sequence[float],
        serial: bool,
        tolerance: float | None = limits.TOLERANCE,
        courant: float = COURANT,
        error_ratio: float | None = None,
    ) -> None:
        self.serial, self.initial_momentum = serial, 0.0
        self.coupled = limits.is_slow(problem, courant)
        self.control = limits.step_control(problem, targets, tolerance, courant, error_ratio)
        self.tolerance: float = limits.TOLERANCE if tolerance is None else tolerance
        self.exchange, self.insertion = BodyExchange(problem), Insertion(problem)
        self.build(problem)
        self.reset()

    def build(self, problem: Problem) -> None:
        """Make the parts of a step of a ``problem``, and their fields."""
        self.problem, walls, coupled = problem, problem.walls, self.coupled
        self.points = self.insertion.points = points_of(problem, self.serial)
        self.operators = operators_of(problem, self.points)
        self.grid: WalledGrid | PeriodicGrid | GradedGrid
        if self.points.graded:
            self.grid = GradedGrid(self.points, problem, velocities=coupled)
        elif walls:
            self.grid = WalledGrid(self.points, problem, velocities=coupled)
        else:
            self.grid = PeriodicGrid(self.points, problem, problem.height)
        near_walls: tuple[Any, ...] = (MAX_WALLS, bool(problem.contact), walls.across_axis) if walls else ()
        self.shift = FickianShifting(self.points, problem.spacing, *near_walls, ends=problem.open_ends)  # type: ignore[misc]
        self.levels = TimeLevels(self.operators, self.shift, carried_along=not problem.open_ends)
        self.extra_stress = extra_stress_of(problem, self.levels, coupled)
        rounding = self.rounding
        self.boundary, self.couplings = boundary_of(
            problem, self.levels, self.shift, self.grid, self.extra_stress, rounding, coupled
        )
        self.grid.outlet = self.boundary.outlet
        self.transport = Transport()
        if problem.substances:
            self.transport = CarriedSubstances(self.boundary, self.levels, self.extra_stress)
        self.levels.others = (*self.extra_stress.fields, *self.transport.fields)
        parts = self.grid, self.boundary, self.extra_stress
        self.equations: Equations
        if problem.kinematics:
            self.equations = GivenFlow(*parts, self.residuals)
        elif coupled:
            self.equations = Coupled(*parts, self.residuals, max(limits.TOGETHER, rounding / self.tolerance))
        else:
            self.equations = Splitting(*parts, self.residuals)

    def reset(self) -> None:
        """Return to the state before the first step."""
        self.reset_steps(self.problem.start_time)
        self.dts: list[float] = []
        self.iterations = [0.0, 0.0]
        self.output_cache: Any = None
        self.stress_resolution: Any = None
        self.boundary.reset()
        self.insertion.reset()
        self.levels.passages[...] = 0

    def start(self, position: np.ndarray, velocity: np.ndarray, stress: np.ndarray | None = None) -> None:
        """Place the particles, at (particles, 2), and find the pressure of their velocities (particles, components).

        Polymers start without ``stress``.
        """
        self.insertion.begin(position, self.time)
        self.initial_momentum = self.momentum(tuple(position.T), velocity[:, 0])
        self.place(position, self.problem.unknowns(velocity, position[:, 1]), np.arange(len(position)))
        if self.problem.inertia:
            self.find_start()
        else:
            self.start_without_inertia()

    def place(self, position: np.ndarray, unknowns: np.ndarray, number: np.ndarray) -> None:
        """Place the particles with these newest velocities (particles, components) and numbers (particles,)."""
        fluid, levels = self.points.in_fluid, self.levels
        active(levels.position)[:fluid] = position - np.array(self.problem.origin)
        active(levels.fields)[...] = 0.0
        active(levels.fields)[:fluid, : levels.components] = unknowns
        active(levels.number)[:fluid] = number
        view(levels.step_weights)[...] = 0.0
        levels.move_points()

    def find_start(self, stress: Sequence[np.ndarray] = ()) -> None:
        """Find impulse, pressure and loads for the velocities of the particles; ``stress``: see ``ExtraStress.begin``.

        With inertia they determine the flow at the start.
        """
        fluid, levels, residual = self.points.in_fluid, self.levels, self.equations.residuals[0]
        unknowns = active(levels.fields)[:fluid, : levels.components].copy()
        self.assemble(self.time)
        solved = self.boundary.apply_impulse(self.equations, residual)
        solved = all([solved, *(coupling.start(self.equations, residual) for coupling in self.couplings)])
        self.boundary.begin(self.equations)
        self.require_solution(solved)
        if self.problem.has_own_start:
            change = np.abs(active(levels.fields)[:fluid, : levels.components] - unknowns).max()
            self.removed_divergence = float(change / (np.abs(unknowns).max() or 1.0))
        levels.measure()
        own = len(self.extra_stress.fields)
        self.transport.begin(stress[own:], self.time)
        extra_stress = self.extra_stress
        extra_stress.set_factor(self.transport.factor)
        extra_stress.begin(stress[:own])
        force = self.body_force(self.time)
        forced = force is not None
        if force is not None:
            forcing = view(self.equations.forcing)
            forcing[:fluid] = force[:fluid]
            forcing[self.points.on_walls] += force[fluid:]
        viscosity = self.problem.solvent_viscosity
        self.require_solution(self.equations.begin(viscosity, residual, forced, self.couplings))
        self.boundary.measure_loads(self.time)
        self.boundary.corners.find_fastest()
        self.begin_steps()

    @property
    def rounding(self) -> float:
        """Least residual of the linear systems that rounding allows."""
        return limits.ROUNDING * float(np.finfo(np.float64 if real() == ti.f64 else np.float32).eps)

    @property
    def residuals(self) -> list[float]:
        """Residuals of pressure and velocities for the present ``tolerance``."""
        return limits.residuals(self.tolerance, self.rounding, bool(self.problem.open_ends))

    @property
    def speed(self) -> float:
        """Velocity that the Courant number of a step refers to, in the largest spacing."""
        return limits.courant_speed(float(view(self.levels.fastest_relative)), self.problem)

    @property
    def error_speed(self) -> float:
        """Velocity that the errors of steps are divided by."""
        return limits.error_speed(float(view(self.levels.largest)), self.problem)

    @property
    def residual(self) -> float:
        """Divergence of the velocities over their gradient, where that is not too small to tell."""
        return self.boundary.residual(limits.LEAST_GRADIENT * self.error_speed / self.problem.spacing)

    def begin_steps(self) -> None:
        """Choose the first step, or the first one after a change."""
        self.control.dt_next = limits.first_step(self.control.limit(self.speed), self.problem)

    def advance(self) -> None:
        """Take one step, in as many attempts as its error asks for; raise DivergedError where it runs away."""
        if self.exchange.leaving(self.time) or self.exchange.entering(self.time):
            self.exchange_bodies()
        if self.time in self.problem.jump_times:
            self.dts = []  # no polynomial in time continues past a jump
            self.boundary.jump(self.time)
            self.begin_steps()
            if not self.problem.inertia:
                self.settle()
        unresolved = None  # given velocities have no error of the spacing
        if not self.problem.kinematics:
            unresolved = self.levels.divergence_scale * self.problem.spacing / self.error_speed
        if self.control.balanced:  # residuals of the linear systems are parts of the tolerance
            self.tolerance = self.control.tolerance_for(unresolved)
            self.equations.residuals = self.residuals
        dt, error = self.control.take(self.time, self.attempt, unresolved)
        if dt is None and math.isinf(error):
            raise self.diverged("bodies overlap, or no velocities are found for them, whatever the step,")
        if dt is None:
            raise self.diverged(TOO_LONG)
        if self.equations.may_scatter:
            self.control.notice_scatter(error, self.roughness)
        self.accept_step(dt)

    def particles_with(self, fields: Sequence[np.ndarray]) -> tuple[Particles, list[np.ndarray]]:
        """Return the particles with ``fields`` (points, ...), and the values of these at the points on walls."""
        fluid, levels = slice(self.points.in_fluid), self.levels
        place = active(levels.position)[fluid].astype(float) + np.array(self.problem.origin)
        values = [field.astype(float) for field in fields]
        number = active(levels.number)[fluid].copy()
        particles = Particles(place, [value[fluid] for value in values], number, levels.passages)
        return particles, [value[self.boundary.slots] for value in values]

    def renew_particles(self, time: float) -> None:
        """Remove particles where they crowd at ``time``, and insert others where they are sparse.

        Points on walls are placed anew where another spacing is wanted.
        """
        levels, boundary, position = self.levels, self.boundary, active(self.levels.position).astype(float)
        crowded, places = self.insertion.choose(position, time)
        splines = boundary.renew_points(time)
        if splines is None and not len(crowded) + len(places):
            return
        carried = [levels.fields, levels.divergence, *levels.others]
        fields = [active(field).reshape(self.points.fluid, -1) for field in carried]
        particles, on_walls = self.particles_with(fields)
        values = self.insertion.values(position, fields, places)
        walls = position[boundary.slots]
        if splines is not None:
            on_walls, walls = [splines @ each for each in on_walls], boundary.places_on_walls(time)
        self.insertion.change(particles, crowded, places + self.problem.origin, values)
        room = self.points.capacity - len(walls)
        if len(particles.number) > room:
            text = f"x, y: {len(particles.number)} particles, and room for {room}, {self.present_step}"
            raise DivergedError(f"{text}: {self.insertion.excess(particles.position, time)}")
        self.points.resize(len(particles.number), len(walls))
        for field, of_particles, others in zip(carried, particles.fields, on_walls, strict=True):
            active(field)[...] = np.concatenate([of_particles, others]).reshape(active(field).shape)
        active(levels.position)[...] = np.concatenate([particles.position - self.problem.origin, walls])
        active(levels.number)[: self.points.in_fluid] = particles.number
        levels.passages = particles.passages
        self.equations.forget()

    def exchange_bodies(self) -> None:
        """Let bodies leave and enter; begin anew with the others, and as many particles as there is room for."""
        problem, levels, state = self.problem, self.levels, self.boundary.host_state()
        fields = [active(levels.fields)[:, : levels.components], *map(active, levels.others)]
        particles, walls_before = self.particles_with(fields)
        new, on_walls = self.exchange.exchange(problem, particles, walls_before, self.time)
        self.build(new)
        boundary = self.boundary
        assert isinstance(boundary, WallBoundary)
        self.exchange.restore_parts(boundary.parts, state)
        self.levels.passages = particles.passages
        self.dts, self.output_cache = [], None
        self.place(particles.position, particles.fields[0], particles.number)
        boundary.newest_velocities[boundary.slots] = on_walls[0]
        stress = [np.concatenate(pair) for pair in zip(particles.fields[1:], on_walls[1:], strict=True)]
        if problem.inertia:
            self.find_start(stress)
        else:
            boundary.move(self.time)
            boundary.store_normal_curls()
            own = len(self.extra_stress.fields)
            self.transport.begin(stress[own:], self.time)
            self.extra_stress.begin(stress[:own])
            self.settle()

    def settle(self) -> None:
        """Without inertia: find the flow of the present time by a step in which next to nothing moves."""
        dt = INSTANT * self.control.limit(self.speed)
        error, _ = self.attempt(dt)
        if math.isinf(error):
            raise self.diverged("no velocities are found for the walls")
        self.accept_step(dt)
        self.dts = []
        self.boundary.forget()
        self.begin_steps()

    def start_without_inertia(self) -> None:
        """Find the first flow, which has no past, by a step that ends at the start."""
        start = self.time
        self.time -= INSTANT * self.control.limit(self.speed)
        self.transport.begin((), self.time)
        self.extra_stress.begin()
        self.boundary.begin_without_inertia(self.time)
        self.settle()
        self.reset_steps(start)
        self.iterations = [0.0, 0.0]

    def attempt(self, dt: float) -> tuple[float, int]:
        """Compute velocity and pressure at the end of a step; return the error, over the velocity, and its order.

        With the weights gamma_0 and alpha_q of backward differences over variable steps (equations of
        docs/theory/two-dimensional.md):

        1. particles move along the polynomial through their velocities, and walls and bodies to the end of the step;
        2. the operators are assembled there;
        3. u^ = sum_q alpha_q u^(n+1-q), and velocity and pressure are extrapolated (1);
        4. outer iterations: the forcing f is u^ and dt times the divergence of the extra stress, the centripetal term
           and body forces;

               L p = (D f - k gamma_0 d^n) / dt   (2, 4),   with n . grad p at walls by the momentum there (8),
               (gamma_0 - dt nu L) u^(n+1) = f - dt (G p - g)   (3);

           a second one uses the stress, and the curl of the vorticity at walls, of the velocities that the first has
           found; with couplings (free bodies, a kept mean velocity) they go on until these have converged. In slow
           flow each solves (9) to (12) instead, for the couplings' unknowns as well;
        5. the difference from the extrapolated velocities gives the error (5).
        """
        if self.time + 0.1 * dt == self.time:
            raise self.diverged(TOO_LONG)
        levels, boundary, extra_stress, equations = self.levels, self.boundary, self.extra_stress, self.equations
        end, weights = self.time + dt, TimeWeights([dt, *self.dts], dt)
        gamma0, alpha = weights.bdf()

        boundary.reject()
        levels.predict(weights)
        if not boundary.predict(weights, dt, end):
            return math.inf, 1
        self.assemble(end)

        error_speed = self.error_speed
        allowed = self.tolerance * error_speed
        for coupling in self.couplings:
            coupling.prepare(equations, dt, gamma0, end, allowed)
        extra_stress.prepare(weights, dt, end)
        viscosity = self.problem.solvent_viscosity + extra_stress.viscosity
        speed = limits.courant_speed(float(view(levels.fastest)), self.problem)
        viscous, convective = limits.decay_rates(viscosity, speed, self.problem)
        retained = max(0.0, gamma0 - (viscous + convective) * dt)
        step = Step(dt, end, gamma0, viscosity, retained, (viscous * dt, convective * dt), allowed)
        equations.begin_step(weights, alpha if self.problem.inertia else 0.0 * alpha)
        equations.set_wall_velocity(boundary.solver_velocity())
        solved = self.transport.prepare(weights, dt, end, self.tolerance, equations.velocity.x)
        extra_stress.set_factor(self.transport.factor)
        self.add_body_force(dt, end)
        boundary.begin_step(weights)
        boundary.corners.add_force(equations.forcing, weights, dt)

        for outer in range(MOST_ITERATIONS):
            equations.form_forcing(dt, outer)
            solved = equations.solve(step, outer, self.couplings) and solved
            settled = all([coupling.correct(equations) for coupling in self.couplings])
            solved = self.transport.correct(equations.velocity.x) and solved
            extra_stress.set_factor(self.transport.factor)
            if settled and outer >= equations.least_iterations - 1 and equations.settled(step):
                break

        of_transport = self.transport.error(error_speed)
        difference, lower = max([equations.error(), of_transport, *(coupling.error() for coupling in self.couplings)])
        tiny, known = TINY * self.problem.reference_velocity, len(self.dts) >= VELOCITIES - 1
        self.roughness = math.log(max(difference, tiny) / max(lower, tiny)) if known else -1.0
        self.require_solution(solved and not math.isnan(difference))
        error, order = weights.step_error(difference, gamma0, error_speed)
        return error / error_speed, order

    def add_body_force(self, dt: float, time: float) -> None:
        """Add the body forces to the forcing of a step, and a uniform one to the guess of the very first step."""
        if not self.dts:  # a flow that is carried along as a whole is exact from the first guess on
            fluid = slice(self.points.in_fluid)
            view(self.equations.velocity.x)[fluid, :2] += dt * np.array(self.problem.acceleration)
        force = self.body_force(time)
        if force is not None:
            view(self.equations.forcing)[: len(force)] += dt * force

    def body_force(self, time: float) -> np.ndarray | None:
        """Return given body force and buoyancy (points, components) at ``time`` as unknowns; None without any."""
        found: Any = None
        buoyancy = self.transport.body_force()
        if self.problem.body_force is None and buoyancy is None:
            return None
        x, y = self.problem.places(view(self.points.position)[: self.points.fluid].astype(float))
        if self.problem.body_force is not None:
            found = self.problem.unknowns_given(self.problem.body_force, x, y, time)
        if buoyancy is not None:
            whole = np.zeros((len(x), self.levels.components))
            whole[:, :2] = buoyancy
            buoyancy = self.problem.unknowns(whole, y)
            found = buoyancy if found is None else found + buoyancy
        return found

    def assemble(self, time: float) -> None:
        """Set the positions of the points at the end of a step, at ``time``, and compute the operators there."""
        self.boundary.move(time)
        self.points.find_neighbours()
        self.require_room("neighbours of a particle", self.points.overflow())
        self.operators.assemble()
        self.grid.sort()
        self.boundary.set_rows()
        self.equations.assemble()

    def require_solution(self, solved: bool) -> None:
        """Raise DivergedError where the linear systems have none."""
        if not solved:
            raise self.diverged("u, v, pressure: the linear systems cannot be solved")

    def accept_step(self, dt: float) -> None:
        """Store the new velocities, measure them, and shift the particles."""
        levels, end = self.levels, self.control.end(self.time, dt)
        levels.store(self.equations.velocity.x, self.equations.pressure.x)
        levels.measure()
        self.stress_resolution = self.extra_stress.store(self.equations.velocity.x, self.steps + 1)
        self.boundary.accept(self.time + dt)
        self.transport.store(end, [dt, *self.dts])
        for coupling in self.couplings:
            coupling.store(end)
        travelled = dt * limits.courant_speed(float(view(levels.fastest)), self.problem) / self.problem.spacing
        if not self.problem.kinematics_gradient:  # operators, for which particles have to lie evenly, have no effect
            self.shift.shift(self.steps == 0 and not self.boundary.bounded, travelled)
        levels.remap()
        self.extra_stress.remap()
        self.transport.remap()
        self.boundary.corners.find_fastest()
        speed = self.speed
        if view(levels.fastest) > limits.RUNAWAY * self.problem.reference_velocity:
            text = f"{limits.RUNAWAY:g} times the reference velocity {self.present_step}"
            cure = ": give reference.velocity, if the body force drives this flow" if self.problem.body_force else ""
            raise DivergedError(f"u, v: above {text}{cure}{self.transport.cause_of_speed}")
        if (self.steps + 1) % REORDER_INTERVAL == 0:
            levels.reorder()
        elif self.points.graded:
            self.renew_particles(end)
        self.boundary.set_spacing(active(levels.position), end)
        self.dts = [dt, *self.dts][: VELOCITIES - 1]
        self.end_step(dt, speed)
        self.iterations = [sum(pair) for pair in zip(self.iterations, self.equations.iterations, strict=True)]

    def snapshot(self, time: float | None = None) -> Snapshot:
        """Return the state at ``time``, within the last step, or now.

        It lies on the polynomial through the time levels, in the order of creation. ``output_cache`` holds the levels
        that it needs, since many outputs may fall into one step: the newest ones at its end, which cost less.
        """
        problem, boundary, levels = self.problem, self.boundary, self.levels
        time = self.time if time is None else time
        offset, first, components = self.time - time, levels.first_pressure, levels.components
        case = self.time, offset == 0.0
        if self.output_cache is None or self.output_cache[0] != case:
            fluid, fields = self.points.in_fluid, active(levels.fields)
            created = np.argsort(active(levels.number)[:fluid])
            parts = (fields[:, :first], fields[:, first:]) if offset else (fields[:, :components], fields[:, first])
            stored = [*parts, *(active(field) for field in (levels.position, *levels.others))]
            values = [field[:fluid][created].astype(float, copy=False) for field in stored]
            self.output_cache = case, created, *values
        _, created, velocity, pressure, position, *stress_levels = self.output_cache
        substances = stress_levels[len(self.extra_stress.fields) :]
        dts = self.dts or [1.0]
        weights, axis = TimeWeights([0.0, *dts], dts[0]), position[:, 1] + problem.origin[1]
        if not offset:
            velocity = problem.velocities(velocity, axis)
        else:
            each = velocity.reshape(len(velocity), VELOCITIES, components)
            velocities = np.stack([problem.velocities(each[:, level], axis) for level in range(VELOCITIES)], axis=1)
            velocity = np.einsum("a,iac->ic", weights.interpolation(offset, VELOCITIES), velocities)
            position = position - np.einsum("a,iac->ic", weights.integral(offset), velocities[..., :2])
            pressure = pressure @ weights.interpolation(offset, PRESSURES)
            position = boundary.entered(position)
            if problem.axisymmetric:  # around the axis the circulation is interpolated
                velocity[:, 2] *= axis / (position[:, 1] + problem.origin[1])
        position, velocity, pressure = boundary.corners.whole_flow(
            weights, offset, position, velocity, pressure, created
        )
        stress = (problem.density * part for part in self.extra_stress.at(weights, offset, stress_levels, axis))
        x, y = problem.places(position)
        area = self.insertion.areas((x, y), time)
        return Snapshot(
            t=time,
            step=self.steps,
            x=x,
            y=y,
            u=velocity[:, 0].copy(),
            v=velocity[:, 1].copy(),
            w=velocity[:, 2].copy() if problem.axisymmetric else None,
            density=np.full(len(position), problem.density),
            pressure=problem.density
            * (pressure if problem.open_ends else pressure - np.average(pressure, weights=area)),
            area=area,
            passages=levels.passages.copy() if problem.open_ends or self.points.graded else None,
            **self.exchange.seen(boundary.seen(time, weights, offset)),
            velocity_scatter=self.control.scatter if self.equations.may_scatter else None,
            divergence=self.residual,
            **self.transport.seen(weights, offset, substances),
            acceleration=next((each.drive for each in self.couplings if each.drive is not None), None),
            **{self.extra_stress.resolution_name: self.stress_resolution},
            **dict(zip((*STRESSES, *STRESSES_AROUND), stress, strict=False)),
        )

    def momentum_balance(self) -> dict[str, float]:
        """Return the ``change`` of momentum along x up to ``time`` [mass * velocity per length], which has no cause."""
        if self.boundary.bounded:  # forces of walls are in the samples
            return {}
        places = self.problem.places(active(self.levels.position).astype(float))
        gained = self.momentum(places, active(self.levels.fields)[:, 0]) - self.initial_momentum
        return {"change": self.problem.density * self.problem.spacing**2 * gained}

    def momentum(self, places: Sequence[np.ndarray], velocity: np.ndarray) -> float:
        """Return the sum of the ``velocity`` (n,) of particles at ``places`` x, y (n,), times areas where these vary.

        Areas are over that of a particle of the largest spacing.
        """
        areas = self.insertion.areas(places, self.time)
        return float((velocity if areas is None else velocity * areas / self.problem.spacing**2).sum(dtype=float))

    def numbers(self) -> dict[str, Any]:
        """Return the numbers of this scheme for ``summary.json``."""
        return {
            **super().numbers(),
            "particles_wall": 0,
            "divergence": self.residual,
            "iterations_pressure": self.iterations[0] / max(self.steps, 1),
            "iterations_velocity": self.iterations[1] / max(self.steps, 1),
            **self.boundary.numbers(),
            **self.exchange.numbers(),
            **self.insertion.numbers(),
        }

    def parts(self) -> dict[str, Any]:
        """Return everything whose fields a resumed run needs, by name."""
        return {"levels": self.levels, **self.extra_stress.parts, **self.transport.parts}

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        couplings = [coupling.host_state() for coupling in self.couplings]
        walls, bodies = self.boundary.host_state(), {**self.exchange.state(), "particles": self.points.in_fluid}
        others = {**self.insertion.state(), **self.transport.host_state()}
        return {**super().host_state(), "walls": walls, "couplings": couplings, "bodies": bodies, **others}

    def make_room(self, state: Mapping[str, Any]) -> None:
        """Make as many particles and points on walls as a ``host_state`` has."""
        if self.exchange.restore(state["bodies"]):
            problem = self.problem
            assert problem.walls is not None
            walls = problem.walls.of_bodies(self.exchange.in_fluid)
            self.build(replace(problem, walls=walls, n_fluid=state["bodies"]["particles"]))
        walls = self.problem.walls
        if walls:
            walls.restore(state["walls"]["points"])
        self.points.resize(state["bodies"]["particles"], walls.count if walls else 0)
        self.levels.passages = np.zeros(self.points.in_fluid, dtype=int)

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        super().restore_host_state(state)
        self.insertion.restore(state)
        self.transport.restore_host_state(state)
        self.boundary.restore_host_state(state["walls"])
        self.boundary.set_spacing(active(self.levels.position), self.time)
        for coupling, its in zip(self.couplings, state["couplings"], strict=True):
            coupling.restore_host_state(its)


def extra_stress_of(problem: Problem, levels: TimeLevels, coupled: bool) -> ExtraStress:
    """Return the extra stress of a fluid; ``coupled``: whether velocities and pressure are solved for together."""
    if problem.rheology is None and not problem.varies_with_temperature:
        return ExtraStress(levels)
    if problem.carries_stress:
        return ViscoelasticStress(levels, problem, local=coupled)
    return GeneralisedNewtonianStress(levels, problem)


def boundary_of(
    problem: Problem, levels: TimeLevels, shift: Any, grid: Any, extra_stress: ExtraStress, rounding: float, slow: bool
) -> tuple[Boundary, list[Coupling]]:
    """Return the boundary of a flow and its couplings, with bodies that it carries and open ends where there are.

    ``rounding``, ``slow``: see ``BoundaryPart.couplings``.
    """
    if problem.walls is None:
        return Boundary(problem, levels, SUPPORT), []
    boundary = WallBoundary(problem, levels, shift, grid, extra_stress, SUPPORT)
    if any(body.free for body in problem.bodies):
        boundary.add(FreeBodyPart(boundary))
    if problem.open_ends:
        boundary.add(OpenEnds(boundary))
    if any(body.slip_length for body in problem.bodies):
        boundary.add(SlippingWalls(boundary))
    couplings = [coupling for part in boundary.parts for coupling in part.couplings(rounding, slow)]
    if problem.kept_mean_velocity is not None:
        couplings.append(MeanVelocityControl(problem, boundary))
    return boundary, couplings


def points_of(problem: Problem, serial: bool) -> PointCloud:
    """Return the ``PointCloud``, whose points near walls have wider supports; ``serial``: without threads."""
    reach = (SUPPORT + SKIN) * problem.spacing
    cutoff: float | tuple[float, float] = reach
    if problem.walls is not None:
        cutoff = reach, reach + (MAX_WALLS * WALL_SUPPORT + POINT_SUPPORT) * problem.spacing
    domain, on_walls = PeriodicDomain(problem.length, problem.height), problem.particles - problem.n_fluid
    finest = problem.wanted_spacing.smallest / problem.spacing
    if finest < 1.0:
        largest = cutoff[1] if isinstance(cutoff, tuple) else reach
        cutoff = reach, largest * (1.0 + COARSE_SIDE * SUPPORT * problem.growth)
    return PointCloud(problem, domain, cutoff, 0, serial, on_walls=on_walls, finest=finest)


def operators_of(problem: Problem, points: PointCloud) -> LeastSquaresOperators:
    """Return the operators of ``points`` (``PointCloud``), planar or axisymmetric."""
    # in polar coordinates points lie in layers: near walls operators then have 70 times the rounding errors
    curved = problem.walls is not None and problem.walls.curved and real() == ti.f64
    pivot = SMALLEST_PIVOT_GRADED if points.graded and real() == ti.f64 else SMALLEST_PIVOT
    pivot = SMALLEST_PIVOT_AT_AXIS if problem.reaches_axis else pivot
    chosen = points, SUPPORT * problem.spacing, 4, pivot, points.varying, curved
    if problem.axisymmetric:
        return AxisymmetricOperators(*chosen, lowest_radius=problem.origin[1], annular=problem.annular)
    return LeastSquaresOperators(*chosen)
