"""Steps of the implicit scheme: predict the middle, assemble the operators there, solve, measure, move."""

import math

import numpy as np

from tisph.domain import ChannelDomain
from tisph.errors import DivergedError
from tisph.least_squares import SKIN, SUPPORT
from tisph.least_squares.operators import LeastSquaresOperators
from tisph.neighbours.point_cloud import PointCloud, active
from tisph.runtime import view
from tisph.schemes._momentum import MomentumBalance
from tisph.schemes._overflow import clustered
from tisph.schemes._step_control import StepControl
from tisph.schemes.implicit._dense import DenseOutput
from tisph.schemes.implicit._esdirk import EMBEDDED_ORDER
from tisph.schemes.implicit._field import VelocityField
from tisph.schemes.implicit._ghosts import MirrorGhosts
from tisph.schemes.implicit._motion import Motion
from tisph.schemes.implicit._pressure import Projection
from tisph.schemes.implicit._shift import Shift
from tisph.schemes.implicit._solver import ViscousSolver
from tisph.schemes.implicit._virtual import VirtualGhosts
from tisph.schemes.implicit._viscous import ViscousStep
from tisph.schemes.implicit._walls import WallSeries
from tisph.snapshot import STRESSES, Snapshot

SOLVER_TOLERANCE = 1e-3
"""Residual of a linear system, as a part of the tolerance of a step."""

LARGEST_DIVERGENCE = 2e-2
"""Of the velocities over their gradient, as root mean squares, that needs no pressure. Truncation errors of disordered
shear flow are below 5e-3 once the layers are resolved; a flow that needs a pressure soon has 1e-1."""

RESOLVED = 2.0
"""Depth sqrt(nu t) of a layer, in particle spacings, from which on derivatives of the velocities mean something."""

TOLERANCE = 3e-7
"""Of a step, where the config leaves it open."""

MOST_ATTEMPTS = 20
WORST = 1e6
"""What counts for an error that is infinite, over the reference velocity: the step is taken again."""

FIRST = 0.25
"""First step in spacing^2 / nu, the time in which a wall that starts moves the row next to it."""

HOST_STATE = ("time", "steps", "rejected", "shortest", "longest", "reduced", "dropped", "projections", "transverse")
"""Attributes of a Scheme that change while it runs."""


class Scheme:
    """Particles in a channel, advanced step by step; ``time`` and ``steps`` tell how far.

    ``targets`` are times that steps end on exactly. ``serial`` compiles loops without threads.
    """

    def __init__(self, config, channel, targets, serial):
        order = config.scheme.operators.order
        reach = (SUPPORT[order] + SKIN) * channel.spacing
        self.channel = channel
        self.domain = ChannelDomain(channel)
        treatment = config.walls.treatment.type
        kind = VirtualGhosts if treatment == "virtual_image" else MirrorGhosts
        self.points = PointCloud(channel, self.domain, reach, kind.room(channel, reach), serial, kind.mirrors)
        self.ghosts = kind(self.points, channel, reach)
        self.operators = LeastSquaresOperators(self.points, SUPPORT[order] * channel.spacing, order)
        if config.fluid.rheology.type == "newtonian" and channel.driven_side is None:
            solver = ViscousSolver(self.operators, self.ghosts, channel)
            self.viscous = ViscousStep(solver, channel, WallSeries(channel, treatment))
        else:
            from tisph.schemes.implicit import _viscoelastic  # of no use to most runs

            self.viscous = _viscoelastic.step(config, channel, self.operators, self.ghosts)
        self.wall_force = self.viscous.wall_force()
        self.solver, self.walls = self.viscous.solver, self.viscous.wall_series
        self.field = VelocityField(self.viscous)
        self.shift = Shift(self.points, self.ghosts, channel.spacing)
        self.projection = Projection(self.viscous, self.field, channel.gap)
        self.motion = Motion(self.field, self.shift, channel.length)
        self.dense = DenseOutput(self.viscous, self.motion, (self.field.volume, self.projection.pressure))
        self.control = control(config, channel, targets)
        self.reset()

    def reset(self):
        """Go back to before the first step."""
        self.time = self.channel.start_time
        self.steps = self.rejected = self.reduced = self.dropped = self.projections = 0
        self.transverse = False
        self.shortest, self.longest = math.inf, 0.0
        self.momentum = MomentumBalance(self.time)
        active(self.field.volume)[...] = 0.0
        active(self.projection.pressure)[...] = 0.0
        self.viscous.push = None
        self.walls.enter(self.time)

    def start(self, position, velocity, _stress=None):
        """Place the particles, (particles, 2) arrays; what they remember, more than a stress, the channel knows."""
        active(self.motion.position)[...] = position
        active(self.viscous.velocity)[...] = velocity.T
        self.momentum.initial = float(velocity[:, 0].sum())
        self.transverse = bool(np.any(velocity[:, 1] != 0.0))
        self.viscous.begin_with(position[:, 1])
        if self.walls.obeys_momentum and self.walls.any_jump:
            self.turn()

    @property
    def finished(self):
        """Whether the last target is reached."""
        return self.control.finished

    def advance(self):
        """Take one step, in as many attempts as its error asks for; raise DivergedError where none succeeds."""
        if self.time in self.control.changes:
            self.turn()
        for attempt in range(MOST_ATTEMPTS):
            length = self.control.choose_dt(self.time)
            self.assemble(length, shift=self.steps > 0 and self.smooth and attempt == 0)
            error = self.solve(length)
            if math.isnan(error) or (math.isinf(error) and self.control.fixed):
                raise DivergedError(
                    f"u, v: the linear systems cannot be solved at step {self.steps + 1}, t = {self.time:.6g}"
                )
            if self.control.accepts(min(error, WORST), EMBEDDED_ORDER, length):
                break
            self.rejected += 1
        else:
            raise DivergedError(f"u: no step is short enough at step {self.steps + 1}, t = {self.time:.6g}")
        self.conclude(length)

    def turn(self):
        """Let walls that change at once now give their impulse."""
        self.assemble(0.0)
        self.momentum.add_impulse(self.viscous.turn(self.time))

    def assemble(self, length, shift=False):
        """Put the points where they are in the middle of a step, push them apart, and compute the operators there."""
        self.motion.predict(0.5 * length)
        self.ghosts.find()
        self.require_room("images of particles", self.ghosts.overflow())
        self.points.find_neighbours()
        self.require_room("neighbours of a particle", self.points.overflow())
        if shift and self.shift.spread():
            self.motion.take_along(0.5 * length)
        self.ghosts.weigh()
        self.operators.assemble()
        if self.projections:
            self.projection.lay()

    def require_room(self, what, needed):
        """Raise DivergedError if ``needed`` (0 where all fits) tells of an overflow."""
        if needed:
            raise clustered(f"{what} ({needed})", self.steps + 1, self.time)

    @property
    def smooth(self):
        """Whether a Taylor series describes the velocities: not before layers of a jump are as deep as a spacing."""
        return self.depth >= 1.0

    @property
    def depth(self):
        """Depth sqrt(nu t) of the layers that walls have made by changing at once, in spacings; infinite without."""
        if not self.walls.any_jump:
            return math.inf
        since = self.time - max((change for change in self.control.changes if change <= self.time), default=0.0)
        return math.sqrt(self.channel.solvent_viscosity * since) / self.channel.spacing

    def solve(self, length):
        """Compute the velocities at the end of a step; return the estimated error over the reference velocity."""
        tolerance = SOLVER_TOLERANCE * self.control.tolerance
        components = range(1 + self.transverse)
        errors = [self.viscous.advance(component, self.time, length, tolerance) for component in components]
        return math.hypot(*errors) / self.channel.reference_velocity

    def require_positive(self):
        """Raise DivergedError where a polymer has lost the positive conformation that it has in nature."""
        lost = self.viscous.lost()
        if lost.size:
            raise DivergedError(
                f"stress: the conformation tensor of particle {lost[0]} is not positive definite any more, at step "
                f"{self.steps + 1}, t = {self.time:.6g} ({lost.size} particles are wrong)"
            )

    def conclude(self, length):
        """Measure the new velocities and move the particles."""
        self.require_positive()
        resolved = self.depth >= RESOLVED
        self.momentum.add_impulse(self.wall_force.impulse(self.time, length, resolved))
        end = self.control.end(self.time, length)
        self.field.measure(end, self.transverse)
        if resolved and (self.projections or self.field.residual > LARGEST_DIVERGENCE):
            self.project(end, length)
        if resolved:
            self.field.stretch(length)
        self.dense.keep(self.time, length)
        self.motion.move(length)
        self.time = end
        self.control.step_taken(end, self.field.steepest)
        self.steps += 1
        self.shortest, self.longest = min(self.shortest, length), max(self.longest, length)
        self.reduced += int(view(self.operators.order_reduced))
        self.dropped += int(view(self.operators.singular))

    def project(self, end, length):
        """Project the velocities at the end of a step, at time ``end``; from then on there is a pressure."""
        self.transverse = True
        if not self.projection.project(length):
            raise DivergedError(f"pressure: cannot be solved for at step {self.steps + 1}, t = {self.time:.6g}")
        self.field.measure(end, self.transverse)
        self.projections += 1
        self.viscous.push = self.projection.push

    def output_times(self, due):
        """Return the times at which there is a snapshot, of those that are ``due``: all, since steps are dense."""
        return due

    def snapshot(self, time=None):
        """Return the state at ``time``, within the last step, or now, as a Snapshot."""
        if time is None or time == self.time:
            time = self.time
            fields = (self.motion.position, self.viscous.velocity, self.field.volume, self.projection.pressure)
            position, velocity, volume, pressure = (active(field).astype(float) for field in fields)
            stresses = self.viscous.stress()
        else:
            position, velocity, volume, pressure = self.dense.at(time)
            stresses = self.viscous.stress_at(*self.dense.within(time))
        with np.errstate(over="ignore"):  # of a run that diverges; the guard finds it
            density = self.channel.density * np.exp(-volume)
        return Snapshot(
            t=time,
            step=self.steps,
            x=position[:, 0] % self.channel.length,
            y=position[:, 1],
            u=velocity[0],
            v=velocity[1],
            density=density,
            pressure=self.channel.density * pressure,
            **dict(zip(STRESSES, self.channel.density * np.array(stresses), strict=False)),
        )

    def around(self, times, x, half_width):
        """Return the particles within ``half_width`` of ``x`` (times,) at ``times`` of the last step, as flat arrays.

        Which time (ascending), x, y and u of each; only x less its period counts.
        """
        return self.dense.around(times, x, half_width, self.channel.length)

    def momentum_balance(self):
        """Return the balance of momentum along x up to ``time``, see ``MomentumBalance.report``."""
        total = active(self.viscous.velocity)[0].sum(dtype=float)
        return self.momentum.report(self.channel, self.time, float(total))

    def numbers(self):
        """Return what ``summary.json`` says about this scheme."""
        return {
            "mach": 0.0,
            "sound_speed": None,
            "particles_wall": int(view(self.ghosts.count)),
            "neighbours_mean": self.points.mean_length(),
            "projections": self.projections,
            "steps_rejected": self.rejected,
            "order_reduced": self.reduced,
            "neighbourhoods_dropped": self.dropped,
        }

    def parts(self):
        """Return everything whose fields a resumed run needs, by name."""
        parts = {"motion": self.motion, "viscous": self.viscous, "field": self.field, "projection": self.projection}
        return {**parts, **self.viscous.parts()}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        state = {name: getattr(self, name) for name in HOST_STATE}
        parts = {"momentum": vars(self.momentum), **self.control.host_state()}
        return {**state, **parts, **self.viscous.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in HOST_STATE:
            setattr(self, name, state[name])
        self.control.restore_host_state(state)
        vars(self.momentum).update(state["momentum"])
        self.walls.enter(self.time)
        self.viscous.restore_host_state(state)
        if self.projections:
            self.viscous.push = self.projection.push

    def set_targets(self, targets):
        """Go on to other targets; return whether the steps so far are those of a run that had them from the start."""
        return self.control.set_targets(targets, self.time)


def control(config, channel, targets):
    """Return the control of the steps that a config asks for."""
    tolerance = TOLERANCE if config.time.tolerance == "auto" else config.time.tolerance
    changes = {time for wall in (channel.bottom, channel.top) for time in wall.changes}
    if config.time.cfl != "auto":
        first = config.time.cfl * channel.spacing / channel.reference_velocity
        chosen = StepControl(tolerance, lambda _gradient: first, fixed=True, changes=changes)
    else:
        first = FIRST * channel.spacing**2 / channel.kinematic_viscosity
        strain = config.scheme.largest_strain
        limit = lambda gradient: strain / gradient if gradient > 0.0 else math.inf  # noqa: E731
        chosen = StepControl(tolerance, limit, changes=changes)
    chosen.dt_next = first
    chosen.set_targets(targets, channel.start_time)
    return chosen
