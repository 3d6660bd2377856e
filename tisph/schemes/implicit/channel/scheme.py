"""The implicit scheme of a channel: its particles, the forces of the walls on them, and steps of controlled length.

``ImplicitStep`` (``step.py``) computes a step; ``ChannelScheme`` attempts, accepts or rejects it. Within the last step
velocities and states are cubic in time, so that output does not shorten the steps.

The force of a wall enters the momentum balance along the channel. Once layers are resolved it follows from the shear
stress at the wall: with the distance d from the wall the stress per unit density is A + a d + B d^2. The momentum
equation gives a = U' - g; A and B are fitted to the stresses of the particles near the wall, and the wall pulls with
-A. In the first moments after a jump the gradient is not resolved. Then the force follows from the contribution of the
ghosts to the rows of the particles. It is exact on a lattice, and has an error of some per cent for disordered
particles, since least-squares operators do not conserve momentum pair by pair. The force of a stress-controlled wall is
known.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tisph.config.schema import Config
from tisph.errors import DivergedError
from tisph.numerics import SKIN, SUPPORT
from tisph.numerics.domain import ChannelDomain
from tisph.numerics.least_squares import LeastSquaresOperators
from tisph.numerics.point_cloud import PointCloud
from tisph.numerics.shifting import OverlapShifting
from tisph.runtime import real, ti, view
from tisph.scenes._channel import Channel
from tisph.schemes._controlled_scheme import ControlledScheme
from tisph.schemes._momentum import momentum_terms
from tisph.schemes._step_control import StepControl
from tisph.schemes.implicit.channel.heat import NoSubstances
from tisph.schemes.implicit.channel.operators import (
    ClosedParticleOperators,
    FixedGhosts,
    Ghosts,
    MirrorGhosts,
    Reflection,
)
from tisph.schemes.implicit.channel.stages import EMBEDDED_ORDER, B, C, FlowState, hermite, weighted
from tisph.schemes.implicit.channel.step import SOLVER_TOLERANCE, WORST, ImplicitStep, NoExtraStress
from tisph.schemes.implicit.channel.stress_controlled import wall_pair_of
from tisph.schemes.implicit.channel.walls import WallPair
from tisph.snapshot import STRESSES, Snapshot

RESOLVED = 2.0
"""Thickness sqrt(nu t) of a layer, in particle spacings, from which on derivatives of the velocity are accurate."""

VOLUME_SMOOTHING = 0.5
"""Share of the difference between a particle's volume and the mean around it that a step removes."""


class ChannelScheme(ControlledScheme):
    """Particles in a channel, advanced step by step; see ``_protocol.Scheme``.

    ``control``: the ``StepControl`` of the run. ``serial``: compile loops without threads. ``velocity_sum``: sum of the
    velocities over the particles at the start; ``wall_impulse``: velocity gained since from the (bottom, top) wall;
    ``pull_impulse``: from the acceleration by the temperature.
    """

    kept = (*ControlledScheme.kept, "velocity_sum", "wall_impulse", "pull_impulse")

    def __init__(self, config: Config, channel: Channel, control: StepControl, serial: bool) -> None:
        order = config.scheme.operators.order
        cutoff = (SUPPORT[order] + SKIN) * channel.spacing
        kind = FixedGhosts if config.walls.treatment.type == "virtual_image" else MirrorGhosts
        self.channel, self.domain, self.control = channel, ChannelDomain(channel), control
        self.reference_velocity, self.viscosity = channel.reference_velocity, channel.solvent_viscosity
        self.walls = wall_pair_of(config, channel)
        capacity = kind.ghost_capacity(channel, cutoff)
        self.points = PointCloud(channel, self.domain, cutoff, capacity, serial, kind.mirrors)
        self.ghosts = kind(self.points, channel, cutoff)
        self.operators = LeastSquaresOperators(self.points, SUPPORT[order] * channel.spacing, order)
        self.model = self.walls.model
        reflection = Reflection(self.ghosts, self.walls.even_reflection)
        self.closed = ClosedParticleOperators(
            self.operators, reflection, channel, self.walls.coupled, channel.solvent_viscosity
        )
        self.particles = Particles(self.operators, self.ghosts, self.closed, channel, self.model.components)
        self.step = ImplicitStep(self.particles, self.closed, self.walls, channel)
        self.extra_stress, self.substances = self.step.extra_stress, self.step.substances
        self.wall_force = WallForce(self.closed, self.walls, self.extra_stress, channel)
        self.stages: list[FlowState] = []
        self.reset()

    def reset(self) -> None:
        """Return to before the first step."""
        self.reset_steps(self.channel.start_time)
        self.velocity_sum, self.wall_impulse, self.pull_impulse = 0.0, [0.0, 0.0], 0.0
        self.walls.enter(self.time)
        self.substances.reset()

    def start(self, position: np.ndarray, velocity: np.ndarray, _stress: np.ndarray | None = None) -> None:
        """Place the particles: ``position`` and ``velocity`` (particles, 2); the channel gives the states C."""
        y = position[:, 1]
        self.particles.start(position, velocity[:, 0], self.model.initial(self.channel, y), self.substances.initial(y))
        self.velocity_sum = float(velocity[:, 0].sum())
        self.walls.start()
        if (self.walls.obeys_momentum and self.walls.any_jump) or self.substances.jumping:
            self.apply_impulse()

    def advance(self) -> None:
        """Take one step, in as many attempts as its error requires; raise DivergedError where none succeeds."""
        if self.time in self.control.jump_times:
            self.apply_impulse()
        dt, _ = self.control.take(self.time, self.attempt)
        if dt is None:
            raise self.diverged(f"{self.substances.involved}u: no step is short enough")
        self.accept(dt)
        if reason := self.substances.unbounded():
            raise self.diverged(reason)

    def apply_impulse(self) -> None:
        """Apply the impulses of walls whose velocity, acceleration or stress jumps at the present time."""
        self.particles.arrange(0.0)
        flow = self.particles.flow()
        self.substances.forget(self.time)
        self.substances.begin(flow, self.time, self.control.dt_next)
        self.walls.set_effects(self.substances.effects())
        self.add_impulse(self.walls.apply_impulse(flow, self.time, self.closed, self.extra_stress.wall_values(flow)))
        self.substances.apply_impulse(flow)
        self.particles.set_flow(flow)

    def add_impulse(self, impulse: Sequence[float]) -> None:
        """Add the ``impulse`` of the (bottom, top) wall to ``wall_impulse``."""
        self.wall_impulse = [float(total + more) for total, more in zip(self.wall_impulse, impulse, strict=True)]

    def attempt(self, dt: float) -> tuple[float, int]:
        """Compute the stages of a step; return its error over the reference velocity, and the order of the error.

        Particles are shifted in the first attempt, not while the layer at an impulsively started wall is unresolved.
        """
        shift = self.steps > 0 and self.layer_thickness >= 1.0 and self.control.last_rejected is None
        try:
            stages, error = self.step.advance(self.time, dt, SOLVER_TOLERANCE * self.control.tolerance, shift)
        except DivergedError as failure:
            raise self.diverged(str(failure)) from failure
        self.stages, error = stages or [], error / self.reference_velocity
        if self.control.fixed and not math.isfinite(error):
            raise self.diverged("u, v: the linear systems cannot be solved")
        # a stress that has no value after so long a step leaves no system either
        return WORST if math.isnan(error) else min(error, WORST), EMBEDDED_ORDER

    def accept(self, dt: float) -> None:
        """Accept the step: add the impulse of the walls, and move walls and particles to its end."""
        indefinite = self.extra_stress.indefinite(self.stages[-1].state)
        if indefinite.size:
            text = f"stress: the conformation tensor of particle {indefinite[0]} is not positive definite any more,"
            raise DivergedError(f"{text} {self.present_step} ({indefinite.size} particles are wrong)")
        resolved = self.layer_thickness >= RESOLVED
        self.add_impulse(self.wall_force.impulse(self.stages, self.time, dt, resolved))
        self.pull_impulse += self.substances.pull_impulse(self.stages)
        self.step.conclude()
        self.particles.accept(self.stages, self.walls, self.substances, self.time, dt, resolved)
        self.end_step(dt, self.particles.steepest)

    @property
    def layer_thickness(self) -> float:
        """Thickness sqrt(nu t) of layers since the last jump, in spacings; infinite without jumps."""
        diffusivities = [*([self.viscosity] if self.walls.any_jump else []), *self.substances.jumping]
        if not diffusivities:
            return math.inf
        since = self.time - max((change for change in self.control.jump_times if change <= self.time), default=0.0)
        return math.sqrt(min(diffusivities) * since) / self.channel.spacing

    def snapshot(self, time: float | None = None) -> Snapshot:
        """Return the state at ``time``, within the last step, or now."""
        particles = self.particles
        if time is None or time == self.time:
            time, state, carried = self.time, particles.state, particles.carried
            fields = (particles.position, particles.velocity, particles.log_volume)
            position, velocity, volume = (view(field)[particles.fluid].astype(float) for field in fields)
        else:
            position, velocity, volume, state, carried = particles.at(time)
        with np.errstate(over="ignore"):  # in a run that diverges, which is stopped afterwards
            density = self.channel.density * np.exp(-volume)
        stresses = self.channel.density * np.array(self.model.stress(state))
        return Snapshot(
            t=time,
            step=self.steps,
            x=position[:, 0] % self.channel.length,
            y=position[:, 1],
            u=velocity,
            v=np.zeros_like(velocity),
            density=density,
            pressure=np.zeros_like(velocity),
            **self.substances.seen(position[:, 1], carried, time),
            **dict(zip(STRESSES, stresses, strict=False)),
        )

    def momentum_balance(self) -> Mapping[str, Any]:
        """Return the balance of momentum along x up to ``time``, see ``momentum_terms``."""
        total = float(view(self.particles.velocity)[self.particles.fluid].sum(dtype=float))
        return momentum_terms(self.channel, self.time, total - self.velocity_sum, self.wall_impulse, self.pull_impulse)

    def numbers(self) -> dict[str, Any]:
        """Return the numbers of this scheme for ``summary.json``."""
        return {**super().numbers(), "particles_wall": int(view(self.ghosts.count))}

    def parts(self) -> dict[str, Any]:
        """Return everything whose fields a resumed run needs, by name."""
        return {"particles": self.particles}

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        parts = {"walls": self.walls.host_state(), "substances": self.substances.host_state()}
        return {**super().host_state(), **parts}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        super().restore_host_state(state)
        self.walls.enter(self.time)
        self.walls.restore_host_state(state["walls"])
        self.substances.restore_host_state(state["substances"])


@ti.data_oriented
class Particles:
    """The particles of a channel and their flow, the ``Points`` of an ``ImplicitStep``.

    At the end of the last step: ``position`` (fluid, 2), ``velocity`` (fluid) along the channel, ``state`` (components,
    fluid) C of the extra stress, ``shear_rate`` (fluid) du/dy, None without an extra stress. ``log_volume`` (fluid):
    logarithm of the volume over the volume at the start. ``slope`` (fluid, 2): gradient of the velocity;
    ``curvature`` (fluid, 3): its xx, xy, yy derivatives; ``state_slope``: dC/dy; ``steepest``: largest magnitude of
    the gradient. Names with ``start`` and ``end``: values and time derivatives at both ends of the last step, which
    began at ``began`` and has the length ``dt``. ``carried`` (substances, fluid): temperature and dissolved substances,
    with their gradients ``carried_slope`` and second derivatives ``carried_curvature``. The velocities across the
    channel are 0.
    """

    def __init__(
        self,
        operators: LeastSquaresOperators,
        ghosts: Ghosts,
        closed: ClosedParticleOperators,
        channel: Channel,
        components: int,
    ) -> None:
        self.operators, self.ghosts, self.closed, self.points = operators, ghosts, closed, operators.points
        self.shifting = OverlapShifting(self.points, ghosts, channel.spacing)
        self.period, self.fluid = channel.length, slice(self.points.fluid)
        vector = ti.types.vector(2, real())
        self.position, self.start_position = (self.points.field(vector) for _ in range(2))
        self.velocity, self.start_velocity, self.end_velocity, self.start_rate, self.end_rate = (
            self.points.field(real()) for _ in range(5)
        )
        self.slope, self.curvature = self.points.field(vector), self.points.field(ti.types.vector(3, real()))
        self.log_volume, self.volumes = self.points.field(real()), ti.field(real(), self.points.capacity)
        self.volumes.used = None
        self.state, self.start_state, self.start_state_rate, self.end_state_rate, self.state_slope = np.zeros(
            (5, components, self.points.fluid)
        )
        count = len(channel.substances)
        self.carried, self.start_carried, self.start_carried_rate, self.end_carried_rate = np.zeros(
            (4, count, self.points.fluid)
        )
        self.carried_slope, self.carried_curvature = (np.zeros((count, self.points.fluid, each)) for each in (2, 3))
        self.shear_rate = np.zeros(self.points.fluid) if closed.coupled else None
        self.steepest = self.began = self.dt = 0.0
        self.read: Any = None

    def start(self, position: np.ndarray, velocity: np.ndarray, state: np.ndarray, carried: np.ndarray) -> None:
        """Set ``position`` (fluid, 2), ``velocity`` (fluid,), ``state`` and ``carried`` when a run starts."""
        view(self.position)[self.fluid], view(self.velocity)[self.fluid] = position, velocity
        view(self.log_volume)[self.fluid] = 0.0
        self.state[...], self.carried[...] = state, carried
        if self.shear_rate is not None:
            self.shear_rate[...] = 0.0

    def flow(self) -> FlowState:
        """Return a copy of the velocities and states, in double precision."""
        velocity, carried = view(self.velocity)[self.fluid].astype(float), self.carried.copy()
        return FlowState(velocity, self.state.copy(), self.shear_rate, substances=carried)

    def set_flow(self, flow: FlowState) -> None:
        """Set velocities and states to the values of a ``flow``."""
        view(self.velocity)[self.fluid] = flow.velocity
        self.state[...], self.carried[...] = flow.state, flow.substances

    # --- the arrangement in the middle of a step

    def assemble(self, dt: float, shift: bool) -> FlowState:
        """Assemble operators and linear systems in the middle of a step of length ``dt``; return the flow at its start.

        ``shift``: first shift particles apart that are too close.
        """
        self.arrange(dt, shift)
        self.closed.prepare()
        return self.flow()

    def arrange(self, dt: float, shift: bool = False) -> None:
        """Predict the points at x^n + dt/2 u^n, list neighbours, shift the points apart, and assemble the operators."""
        self.predict(0.5 * dt)
        self.ghosts.find()
        self.require_space("images of particles", self.ghosts.overflow())
        self.points.find_neighbours()
        self.require_space("neighbours of a particle", self.points.overflow())
        if shift and self.shifting.shift():
            self.transfer(0.5 * dt)
        self.ghosts.prepare()
        self.operators.assemble()

    def predict(self, half: float) -> None:
        """Move the points to the positions of the particles after the time ``half``."""
        position = view(self.position)[self.fluid].copy()
        position[:, 0] = self.wrapped(position[:, 0] + half * view(self.velocity)[self.fluid])
        view(self.points.position)[self.fluid] = position

    def require_space(self, name: str, needed: int) -> None:
        """Raise DivergedError unless ``needed`` is 0: the number of ghosts or neighbours that have no space."""
        if needed:
            raise DivergedError(f"x, y: too many {name} ({needed}), the particles have clustered")

    def transfer(self, half: float) -> None:
        """Transfer positions and flow to the shifted points, by the Taylor series of the velocities.

        A shift D in the middle of the step is a shift D_x - ``half`` u_y D_y along the channel at its start.
        """
        shift = view(self.shifting.moved)[self.fluid]
        moved = np.flatnonzero(shift.any(axis=1))
        x, y = shift[moved].T
        slope, curvature = view(self.slope)[moved], view(self.curvature)[moved]
        x = x - half * slope[:, 1] * y
        squares = np.stack([0.5 * x * x, x * y, 0.5 * y * y], axis=1)
        change = slope[:, 0] * x + slope[:, 1] * y + np.einsum("nk,nk->n", curvature, squares)
        for values, first, second in zip(self.carried, self.carried_slope, self.carried_curvature, strict=True):
            by_curvature = np.einsum("nk,nk->n", second[moved], squares)
            values[moved] += first[moved, 0] * x + first[moved, 1] * y + by_curvature
        self.state[:, moved] += self.state_slope[:, moved] * y
        velocity = view(self.velocity)
        velocity[moved] += change
        position = view(self.points.position)[moved]
        position[:, 0] -= half * velocity[moved]
        view(self.position)[moved] = position

    # --- the end of a step

    def accept(
        self, flows: list[FlowState], walls: WallPair, substances: NoSubstances, time: float, dt: float, resolved: bool
    ) -> None:
        """Accept a step of length ``dt`` from ``time`` with the stages ``flows``, and move the particles.

        ``resolved``: whether derivatives near the walls are accurate enough to integrate volumes. Walls are at the end
        of the step already.
        """
        start, end = flows[0], flows[-1]
        velocity, end_velocity = view(self.velocity)[self.fluid], view(self.end_velocity)[self.fluid]
        end_velocity[...], view(self.end_rate)[self.fluid] = end.velocity, end.velocity_rate
        view(self.start_rate)[self.fluid] = start.velocity_rate
        self.measure(end_velocity, walls)
        if resolved:
            self.advance_volumes(dt)
        position = view(self.position)[self.fluid]
        view(self.start_position)[self.fluid], view(self.start_velocity)[self.fluid] = position, velocity
        position[:, 0] = self.wrapped(position[:, 0] + (0.5 * dt) * (velocity + end_velocity))
        velocity[...] = end_velocity
        self.start_state[...], self.state[...] = self.state, end.state
        self.start_state_rate[...], self.end_state_rate[...] = start.state_rate, end.state_rate
        if len(self.carried):
            self.start_carried[...], self.carried[...] = start.substances, end.substances
            self.start_carried_rate[...], self.end_carried_rate[...] = start.substance_rates, end.substance_rates
            substances.measure(self.carried_slope, self.carried_curvature)
        if self.shear_rate is not None:
            self.shear_rate[...] = end.shear_rate
        for component, (slope, state) in enumerate(zip(self.state_slope, self.state, strict=True)):
            images = [self.closed.boundary_stress(wall.side, *wall.state_excess(component)) for wall in walls]
            slope[...] = self.closed.gradient(state, 1.0) + sum(images)
        self.began, self.dt, self.read = time, dt, None

    def measure(self, velocity: np.ndarray, walls: WallPair) -> None:
        """Compute the derivatives of a ``velocity`` (fluid,) at the end of the step."""
        slope, curvature = view(self.slope)[self.fluid], view(self.curvature)[self.fluid]
        self.closed.derivatives(velocity, walls.series(-1), slope, curvature)
        self.steepest = math.sqrt(np.einsum("nk,nk->n", slope, slope).max())

    @ti.kernel
    def advance_volumes(self, dt: float):
        """Integrate the divergence over a step, and smooth the logarithms of the volumes among neighbours.

        The divergence of disordered particles has a truncation error that differs from one particle to the next.
        Smoothing removes it, as the explicit scheme does with diffusion of the density, and retains changes over more
        than a neighbourhood.
        """
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            self.volumes[i] = self.log_volume[i] + dt * self.slope[i].x
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            total, number = 0.0, 0
            for k in range(self.points.begin[i], self.points.end[i]):
                j = self.points.neighbours[k]
                if j < self.points.capacity:
                    total += self.volumes[j]
                    number += 1
            mean = total / ti.max(number, 1)
            self.log_volume[i] = self.volumes[i] + VOLUME_SMOOTHING * (mean - self.volumes[i])

    def wrapped(self, x: np.ndarray) -> np.ndarray:
        """Return ``x`` moved by whole periods into [0, period)."""
        inside = x - np.floor(x / self.period) * self.period
        return np.where(inside < self.period, inside, 0.0)

    # --- output

    def at(self, time: float) -> tuple[np.ndarray, ...]:
        """Return position (fluid, 2), velocity, ``log_volume`` (fluid,), state and T at a ``time`` of the last step."""
        start, end, start_rate, end_rate, position, log_volume = self.last_step()
        position, theta = position.copy(), (time - self.began) / self.dt
        position[:, 0] += self.dt * (theta * start + 0.5 * theta**2 * (end - start))  # velocities linear in time
        velocity = hermite(theta, self.dt, start, end, start_rate, end_rate)
        states = self.start_state, self.state, self.start_state_rate, self.end_state_rate
        carried = self.start_carried, self.carried, self.start_carried_rate, self.end_carried_rate
        return position, velocity, log_volume, *(hermite(theta, self.dt, *each) for each in (states, carried))

    def last_step(self) -> list[np.ndarray]:
        """Return velocities and rates of the last step, first positions and ``log_volume``, read once for a step."""
        if self.read is None:
            velocities = self.start_velocity, self.end_velocity, self.start_rate, self.end_rate
            fields = *velocities, self.start_position, self.log_volume
            self.read = [view(field)[self.fluid].astype(float) for field in fields]
        return self.read


class WallForce:
    """Forces of the ``walls`` on the particles, by the mean velocities and extra stresses of a step."""

    def __init__(
        self, closed: ClosedParticleOperators, walls: WallPair, extra: NoExtraStress, channel: Channel
    ) -> None:
        self.closed, self.operators, self.ghosts = closed, closed.operators, closed.ghosts
        self.walls, self.extra = walls, extra
        self.viscosity, self.area = channel.solvent_viscosity, channel.length / channel.spacing**2

    def impulse(self, flows: list[FlowState], time: float, dt: float, resolved: bool) -> list[float]:
        """Return the velocity that the (bottom, top) wall gives in a step from ``time``, summed over the particles.

        ``flows``: the stages of the step; ``resolved``: whether gradients near the walls are accurate.
        """
        ghosts, stress = self.ghosts, self.extra.mean_stress(flows)
        series, stress_series = self.walls.mean_series()
        reflection = self.closed.reflection
        mean = np.zeros(ghosts.points.slots + 1)
        mean[: ghosts.points.fluid] = weighted(B, [flow.velocity for flow in flows])
        beyond = ghosts.part(mean)
        beyond[...] = reflection.boundary_values(series) - ghosts.source_values(mean)
        if resolved:
            fitted = zip(self.walls, self.fitted_stresses(mean, stress, time, dt), strict=True)
            forces = [-wall.normal_sign * self.area * at_wall for wall, at_wall in fitted]
        else:
            differences = beyond[ghosts.listed] - mean[ghosts.near[ghosts.row]]
            forces = self.from_images(differences, stress, stress_series)
        for wall in self.walls.stress_controlled:
            forces[wall.side] = -wall.normal_sign * self.area * wall.mean_stress
        return [dt * float(force) for force in forces]

    def fitted_stresses(
        self, velocity: np.ndarray, extra_stress: np.ndarray | None, time: float, dt: float
    ) -> list[float]:
        """Return the shear stress per unit density at the (bottom, top) wall, by the fit A + a d + B d^2."""
        ghosts = self.ghosts
        stress = self.viscosity * self.operators.apply_to(ghosts.near, self.operators.d_dy, velocity)
        if extra_stress is not None:
            stress = stress + extra_stress[ghosts.near]
        found, drive = [], self.walls.drive
        more = weighted(B, self.walls.body_acceleration) - drive.constant if drive.varies else 0.0
        for wall, distance in zip(self.walls, ghosts.offset, strict=True):
            slope = sum(weight * wall.acceleration(time + c * dt) for c, weight in zip(C, B, strict=True))
            slope = slope - wall.mean_pull - more
            near = distance < ghosts.cutoff
            rise = wall.normal_sign * (slope - drive.constant) * distance
            square, rest = distance[near] ** 2, (stress - rise)[near]
            second, fourth = square.sum(), (square * square).sum()
            determinant = square.size * fourth - second * second
            value = float(rest.sum() * fourth - (square * rest).sum() * second)
            found.append(value / determinant if determinant > 0.0 else 0.0)
        return found

    def from_images(self, differences: np.ndarray, stress: np.ndarray | None, stress_series: np.ndarray) -> Any:
        """Return the forces of the images beyond the (bottom, top) wall, by means over the step.

        ``differences`` (listed,): see ``Ghosts.sums``, of the velocities; ``stress`` (fluid,): extra stress.
        """
        ghosts = self.ghosts
        viscous = self.viscosity * ghosts.sums(self.operators.laplacian, differences)[1]
        if stress is None:
            return viscous
        more = sum(self.closed.image_stress(side, *stress_series[side]) for side in range(2))
        images = self.closed.close(stress, self.closed.reflection.sign()) + more
        # first derivatives are odd: pairs of particles cancel except for the sum over the images
        both = images[ghosts.listed] + stress[ghosts.near[ghosts.row]]
        return viscous + ghosts.sums(self.operators.d_dy, both)[1]
