"""The implicit step on particles: its start and end, the motion and the state within it, and the force of the walls.

Within the last step the velocities are cubic in time, so that output does not shorten the steps.

The force of a wall, for the balance of momentum along the channel, follows from the shear stress there, once layers are
resolved: with the distance d from a wall, per unit density, it is A + a d + B d^2, where a = U' - g follows from the
momentum equation; A and B are fitted to the stresses of the particles near the wall, and the wall pulls with -A. In the
first moments after a jump there is no such gradient yet: then the force follows from the ghosts' contribution to the
rows of particles, which is exact on a lattice, and for disordered particles off by some per cent, since least-squares
operators do not conserve momentum pair by pair. The force of a stress-controlled wall is known.
"""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real, ti, view
from tisph.schemes._channel.stages import B, C, FlowState, stages_of
from tisph.schemes._channel.wall_pair import apply_impulse

TOGETHER = 2**20
"""Positions of particles at various times that are looked at together."""


class PolymerState:
    """States C (components, fluid) of an extra stress that particles carry; a checkpoint keeps them.

    ``state`` at the start of a step, ``end`` after it, and before an earlier one: ``start``; ``start_rate``,
    ``end_rate``: their time derivatives; ``slope``: dC/dy; ``shear_rate`` (fluid): du/dy at the start.
    """

    def __init__(self, components, fluid):
        self.state, self.end, self.start, self.start_rate, self.end_rate, self.slope = np.zeros((6, components, fluid))
        self.shear_rate, self.end_shear_rate = np.zeros((2, fluid))


class ImplicitStep:
    """Advances the velocities, and with a ``model`` of an extra stress the states ``polymer`` that particles carry.

    ``velocity`` and ``end`` (fluid): velocities along the channel at the start and at the end of the step;
    ``start_rate``, ``end_rate``: their time derivatives there. The velocities across the channel are 0.
    """

    def __init__(self, operators, channel, walls):
        self.closed_operators, self.operators = operators, operators.operators
        self.channel, self.walls, self.model = channel, walls, walls.model
        self.points, self.ghosts = operators.points, operators.ghosts
        self.stages = stages_of(operators, channel, walls)
        self.velocity, self.end, self.start_rate, self.end_rate = (self.points.field(real()) for _ in range(4))
        self.polymer = None if self.model is None else PolymerState(self.model.components, self.points.fluid)

    def begin_with(self, heights):
        """Set the states of particles at ``heights`` (fluid,) when a run starts."""
        self.walls.reset()
        if self.polymer:
            self.polymer.state[...] = self.model.initial(self.channel, heights)
            self.polymer.shear_rate[...] = 0.0
            self.stages.initialise()

    def apply_impulse(self, time):
        """Let walls that change at once at ``time`` do so.

        Returns the velocity gained from the (bottom, top) wall, summed over the particles.
        """
        flow = self.flow()
        gains = apply_impulse(self.stages, flow, time)
        active(self.velocity)[...] = flow.velocity
        if self.polymer:
            self.polymer.state[...] = flow.state
        return gains

    def flow(self):
        """Return a copy of the velocities and of the state of the polymer, in double precision."""
        velocity = active(self.velocity).astype(float)
        if self.polymer:
            return FlowState(velocity, self.polymer.state.copy(), self.polymer.shear_rate.copy())
        return FlowState(velocity, np.empty((0, self.points.fluid)))

    def advance(self, time, dt, tolerance):
        """Compute the end of a step; return its estimated error."""
        self.closed_operators.assemble()
        start = self.flow()
        end, error = self.stages.advance(start, time, dt, tolerance)
        if end is None:
            return error
        active(self.end)[...], active(self.end_rate)[...] = end.velocity, end.velocity_rate
        active(self.start_rate)[...] = start.velocity_rate
        if self.polymer:
            polymer = self.polymer
            polymer.end[...], polymer.end_rate[...] = end.state, end.state_rate
            polymer.end_shear_rate[...], polymer.start_rate[...] = end.shear_rate, start.state_rate
        return error

    def accept(self):
        """Take up the end of the step as the start of the next, on the particles and at the walls."""
        active(self.velocity)[...] = active(self.end)
        self.walls.conclude()
        if not self.polymer:
            return
        polymer, operators = self.polymer, self.closed_operators
        polymer.start[...] = polymer.state
        polymer.state[...], polymer.shear_rate[...] = polymer.end, polymer.end_shear_rate
        for component, (slope, state) in enumerate(zip(polymer.slope, polymer.state, strict=True)):
            images = [operators.boundary_stress(wall.side, *wall.state_excess(component)) for wall in self.walls]
            slope[...] = operators.gradient(state, 1.0) + sum(images)

    def shift_fields(self, moved, across):
        """Transfer the states of the particles that were ``moved`` by ``across``."""
        if self.polymer:
            self.polymer.state[:, moved] += self.polymer.slope[:, moved] * across

    def indefinite(self):
        """Return the particles with an indefinite conformation tensor at the end of the step."""
        return self.model.indefinite(self.polymer.end) if self.polymer else np.zeros(0, dtype=int)

    def stress(self):
        """Return the stresses S_xx, S_xy, S_yy per unit density that particles carry, (3, fluid), or none, ()."""
        return self.model.stress(self.polymer.state) if self.polymer else ()

    def stress_at(self, theta, dt):
        """Return ``stress`` at the part ``theta`` of the last step, of ``dt``: cubic in the states."""
        if not self.polymer:
            return ()
        polymer = self.polymer
        ends = polymer.start, polymer.state, polymer.start_rate, polymer.end_rate
        return self.model.stress(hermite(theta, dt, *ends))


class DenseOutput:
    """Positions and velocities at any time of the step that was taken last (Hermite interpolation).

    The values of the fields are read once a step: many outputs may fall into one.
    """

    def __init__(self, step, motion):
        self.step, self.motion = step, motion
        self.began = self.dt = 0.0
        self.state = None

    def keep(self, time, dt):
        """Take note of a step that has been taken, from ``time`` on."""
        self.began, self.dt, self.state = time, dt, None

    def at(self, time):
        """Return positions (fluid, 2), velocities (fluid) and the logarithms of volumes (fluid) at ``time``."""
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position, log_volume = self.state
        position = position.copy()
        theta = (time - self.began) / self.dt
        position[:, 0] += self._displacement(theta, start, end)
        return position, hermite(theta, self.dt, start, end, start_rate, end_rate), log_volume

    def around(self, times, x, half_width, period):
        """Return the particles within ``half_width`` of ``x`` (times,), of this ``period``, at each of the ``times``.

        Flat arrays: which time (ascending), and x, y and velocity along the channel of a particle.
        """
        if self.state is None:
            self.state = self._read()
        start, end, start_rate, end_rate, position = self.state[:5]
        thetas = (np.asarray(times) - self.began)[:, None] / self.dt
        found = []
        for some in np.split(np.arange(len(times)), range(0, len(times), max(1, TOGETHER // position.shape[0]))[1:]):
            apart = position[:, 0] + self._displacement(thetas[some], start, end) - x[some, None]
            apart -= period * np.round(apart / period)
            when, particle = np.nonzero(np.abs(apart) < half_width)
            theta, when = thetas[some[when], 0], some[when]
            y = position[particle, 1]
            u = hermite(theta, self.dt, *(values[particle] for values in (start, end, start_rate, end_rate)))
            found.append((when, x[when] + apart[np.searchsorted(some, when), particle], y, u))
        return [np.concatenate(column) for column in zip(*found, strict=True)]

    def _displacement(self, theta, start, end):
        return self.dt * (theta * start + 0.5 * theta**2 * (end - start))

    def _read(self):
        step, motion = self.step, self.motion
        velocities = (motion.start_velocity, step.end, step.start_rate, step.end_rate)
        fields = (*velocities, motion.start_position, motion.field.log_volume)
        return [active(field).astype(float) for field in fields]


def hermite(theta, dt, start, end, start_rate, end_rate):
    """Return at the part ``theta`` of a step of ``dt`` the cubic with these values and time derivatives at its ends."""
    late = theta * theta * (3.0 - 2.0 * theta)
    change = dt * theta * (1.0 - theta) * ((1.0 - theta) * start_rate - theta * end_rate)
    return (1.0 - late) * start + late * end + change


class WallForce:
    """Fits the mean velocities and extra stresses of the last step of an ``ImplicitStep``."""

    def __init__(self, step, channel):
        self.step, self.operators, self.ghosts, self.channel = step, step.operators, step.ghosts, channel
        self.viscosity, self.area = channel.solvent_viscosity, channel.length / channel.spacing**2

    def impulse(self, time, dt, resolved):
        """Return the velocity that the (bottom, top) wall gives in a step, summed over the particles.

        ``resolved``: whether there are gradients at the walls to go by.
        """
        walls, ghosts = self.step.walls, self.ghosts
        ghosts.prescribe(*self.mean(walls.series))
        mean = np.zeros(ghosts.points.slots + 1)
        mean[: ghosts.points.fluid] = self.step.stages.mean_velocity
        beyond = ghosts.part(mean)
        beyond[...] = ghosts.boundary_values() - ghosts.source_values(mean)
        if resolved:
            fitted = zip(walls, self.fitted_stresses(mean, time, dt), strict=True)
            forces = [-wall.normal_sign * self.area * stress for wall, stress in fitted]
        else:
            forces = self.from_images(beyond[ghosts.listed] - mean[ghosts.near[ghosts.row]])
        wall = walls.stress_controlled
        if wall:
            forces[wall.side] = -wall.normal_sign * self.area * wall.mean_stress
        return [dt * float(force) for force in forces]

    def mean(self, of_stage):
        """Return the mean over the step of the values ``of_stage`` at each stage."""
        return sum(weight * np.array(of_stage(stage)) for stage, weight in enumerate(B))

    def fitted_stresses(self, mean, time, dt):
        """Return the shear stress at the (bottom, top) wall."""
        ghosts = self.ghosts
        stress = self.viscosity * self.operators.apply_to(ghosts.near, self.operators.d_dy, mean)
        if self.step.stages.mean_stress is not None:
            stress = stress + self.step.stages.mean_stress[ghosts.near]
        found = []
        for wall, distance in zip(self.step.walls, ghosts.offset, strict=True):
            slope = sum(weight * wall.acceleration(time + c * dt) for c, weight in zip(C, B, strict=True))
            rise = wall.normal_sign * (slope - self.channel.acceleration) * distance
            found.append(_intercept(distance, stress - rise, ghosts.cutoff))
        return found

    def from_images(self, differences):
        """Return the forces of images beyond the (bottom, top) wall by ``differences`` of the mean velocities."""
        step, ghosts, stress = self.step, self.ghosts, self.step.stages.mean_stress
        viscous = self.viscosity * ghosts.sums(self.operators.laplacian, differences)[1]
        if stress is None:
            return viscous
        series = self.mean(step.walls.stress_series)
        more = sum(step.closed_operators.image_stress(side, *series[side]) for side in range(2))
        images = step.closed_operators.close(stress, 1.0) + more
        # first derivatives are odd: what pairs of particles leave of each other is the sum over the images
        both = images[ghosts.listed] + stress[ghosts.near[ghosts.row]]
        return viscous + ghosts.sums(self.operators.d_dy, both)[1]


def _intercept(distance, stress, radius):
    """Return A of the least-squares fit A + B d^2 to values within a ``radius`` of a wall; without particles, 0."""
    near = distance < radius
    square, stress = distance[near] ** 2, stress[near]
    second, fourth = square.sum(), (square * square).sum()
    determinant = square.size * fourth - second * second
    return float(stress.sum() * fourth - (square * stress).sum() * second) / determinant if determinant > 0.0 else 0.0


class Motion:
    """Positions (fluid) and their motion, and positions and velocities (fluid) before the last step."""

    def __init__(self, field, shift, period):
        step = field.step
        self.field, self.step, self.points, self.shift = field, step, step.points, shift
        self.period = period
        self.position, self.start_position = (self.points.field(ti.types.vector(2, real())) for _ in range(2))
        self.start_velocity = self.points.field(real())

    def predict(self, half):
        """Put the points where the particles are in the middle of a step twice as long as ``half``."""
        place = active(self.position).copy()
        place[:, 0] = self.wrapped(place[:, 0] + half * active(self.step.velocity))
        view(self.points.position)[: self.points.fluid] = place

    def shift_fields(self, half):
        """Transfer positions and velocities to the shifted points: by the Taylor series of the velocities.

        A shift D in the middle of the step is one by D_x - ``half`` u_y D_y along the channel at its start.
        """
        shift = view(self.shift.moved)[: self.points.fluid]
        moved = np.flatnonzero(shift.any(axis=1))
        x, y = shift[moved].T
        slope, curvature = active(self.field.slope)[moved], active(self.field.curvature)[moved]
        x = x - half * slope[:, 1] * y
        squares = np.stack([0.5 * x * x, x * y, 0.5 * y * y], axis=1)
        change = slope[:, 0] * x + slope[:, 1] * y + np.einsum("nk,nk->n", curvature, squares)
        self.step.shift_fields(moved, y)
        velocity = active(self.step.velocity)
        velocity[moved] += change
        place = view(self.points.position)[moved]
        place[:, 0] -= half * velocity[moved]
        active(self.position)[moved] = place

    def move(self, dt):
        """Move the particles over the step and take up the velocities at its end."""
        position, velocity, end = (active(field) for field in (self.position, self.step.velocity, self.step.end))
        active(self.start_position)[...] = position
        active(self.start_velocity)[...] = velocity
        position[:, 0] = self.wrapped(position[:, 0] + (0.5 * dt) * (velocity + end))
        self.step.accept()

    def wrapped(self, x):
        """Return ``x`` moved by whole periods into [0, period)."""
        inside = x - np.floor(x / self.period) * self.period
        return np.where(inside < self.period, inside, 0.0)
