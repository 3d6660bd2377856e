"""Steps of the implicit scheme: predict the middle, assemble the operators there, solve, measure, move."""

import math

import numpy as np

from tisph.domain import ChannelDomain
from tisph.errors import DivergedError
from tisph.least_squares import SKIN, SUPPORT
from tisph.least_squares.operators import LeastSquaresOperators
from tisph.neighbours.point_cloud import PointCloud, active
from tisph.runtime import view
from tisph.schemes._channel.field import VelocityField
from tisph.schemes._channel.ghosts import FixedGhosts, MirrorGhosts
from tisph.schemes._channel.models import model_of
from tisph.schemes._channel.operators import ClosedParticleOperators
from tisph.schemes._channel.stages import EMBEDDED_ORDER, SOLVER_TOLERANCE, WORST
from tisph.schemes._channel.step import DenseOutput, ImplicitStep, Motion, WallForce
from tisph.schemes._channel.wall_pair import WallPair
from tisph.schemes._controlled_scheme import ControlledScheme
from tisph.schemes._momentum import MomentumBalance
from tisph.schemes._shifting import OverlapShifting
from tisph.snapshot import STRESSES, Snapshot

RESOLVED = 2.0
"""Thickness sqrt(nu t) of a layer, in particle spacings, from which on derivatives of the velocities mean something."""


class ChannelScheme(ControlledScheme):
    """Particles in a channel, advanced step by step; ``time`` and ``steps`` tell how far.

    ``control`` is the ``StepControl`` of the run. ``serial`` compiles loops without threads.
    """

    def __init__(self, config, channel, control, serial):
        order = config.scheme.operators.order
        cutoff = (SUPPORT[order] + SKIN) * channel.spacing
        self.channel = channel
        self.domain = ChannelDomain(channel)
        treatment = config.walls.treatment.type
        kind = FixedGhosts if treatment == "virtual_image" else MirrorGhosts
        ghosts = kind.ghost_capacity(channel, cutoff)
        self.points = PointCloud(channel, self.domain, cutoff, ghosts, serial, kind.mirrors)
        self.ghosts = kind(self.points, channel, cutoff)
        self.operators = LeastSquaresOperators(self.points, SUPPORT[order] * channel.spacing, order)
        walls = WallPair(channel, treatment, model_of(config.fluid.rheology, channel))
        self.ghosts.even_reflection = walls.even_reflection
        closed = ClosedParticleOperators(self.operators, self.ghosts, channel, coupled=walls.model is not None)
        self.stepper, self.walls, self.solver = ImplicitStep(closed, channel, walls), walls, closed.solver
        self.wall_force, self.field = WallForce(self.stepper, channel), VelocityField(self.stepper)
        self.shift = OverlapShifting(self.points, self.ghosts, channel.spacing)
        self.motion = Motion(self.field, self.shift, channel.length)
        self.dense = DenseOutput(self.stepper, self.motion)
        self.control = control
        self.reset()

    def reset(self):
        """Go back to before the first step."""
        self.reset_steps(self.channel.start_time)
        self.momentum = MomentumBalance(self.time)
        active(self.field.log_volume)[...] = 0.0
        self.walls.enter(self.time)

    def start(self, position, velocity, _stress=None):
        """Place the particles, (particles, 2) arrays; the channel knows the states that they carry."""
        active(self.motion.position)[...] = position
        active(self.stepper.velocity)[...] = velocity[:, 0]
        self.momentum.initial = float(velocity[:, 0].sum())
        self.stepper.begin_with(position[:, 1])
        if self.walls.obeys_momentum and self.walls.any_jump:
            self.apply_impulse()

    def advance(self):
        """Take one step, in as many attempts as its error asks for; raise DivergedError where none succeeds."""
        if self.time in self.control.jump_times:
            self.apply_impulse()
        dt, _ = self.control.take(self.time, self.attempt)
        if dt is None:
            raise self.diverged("u: no step is short enough")
        self.conclude(dt)

    def attempt(self, dt):
        """Compute the velocities at the end of a step; return their error over the velocity scale, and its order."""
        first = self.control.last_rejected is None
        self.assemble(dt, shift=self.steps > 0 and self.layer_thickness >= 1.0 and first)
        error = self.stepper.advance(self.time, dt, SOLVER_TOLERANCE * self.control.tolerance)
        error /= self.channel.reference_velocity
        if math.isnan(error) or (math.isinf(error) and self.control.fixed):
            raise self.diverged("u, v: the linear systems cannot be solved")
        return min(error, WORST), EMBEDDED_ORDER

    def apply_impulse(self):
        """Let walls that change at once now give their impulse."""
        self.assemble(0.0)
        self.momentum.add_impulse(self.stepper.apply_impulse(self.time))

    def assemble(self, dt, shift=False):
        """Put the points where they are in the middle of a step, shift them apart, and compute the operators there."""
        self.motion.predict(0.5 * dt)
        self.ghosts.find()
        self.require_room("images of particles", self.ghosts.overflow())
        self.points.find_neighbours()
        self.require_room("neighbours of a particle", self.points.overflow())
        if shift and self.shift.shift():
            self.motion.shift_fields(0.5 * dt)
        self.ghosts.prepare()
        self.operators.assemble()

    @property
    def layer_thickness(self):
        """Thickness sqrt(nu t) of layers at walls that have changed at once, in spacings; infinite without."""
        if not self.walls.any_jump:
            return math.inf
        since = self.time - max((change for change in self.control.jump_times if change <= self.time), default=0.0)
        return math.sqrt(self.channel.solvent_viscosity * since) / self.channel.spacing

    def conclude(self, dt):
        """Measure the new velocities and move the particles."""
        wrong = self.stepper.indefinite()
        if wrong.size:
            text = f"stress: the conformation tensor of particle {wrong[0]} is not positive definite any more,"
            raise DivergedError(f"{text} {self.present_step} ({wrong.size} particles are wrong)")
        resolved = self.layer_thickness >= RESOLVED
        self.momentum.add_impulse(self.wall_force.impulse(self.time, dt, resolved))
        self.field.measure()
        if resolved:
            self.field.advance_volumes(dt)
        self.dense.keep(self.time, dt)
        self.motion.move(dt)
        self.end_step(dt, self.field.steepest)

    def snapshot(self, time=None):
        """Return the state at ``time``, within the last step, or now, as a Snapshot."""
        if time is None or time == self.time:
            time = self.time
            fields = (self.motion.position, self.stepper.velocity, self.field.log_volume)
            position, velocity, volume = (active(field).astype(float) for field in fields)
            stresses = self.stepper.stress()
        else:
            position, velocity, volume = self.dense.at(time)
            stresses = self.stepper.stress_at((time - self.dense.began) / self.dense.dt, self.dense.dt)
        with np.errstate(over="ignore"):  # of a run that diverges; the guard finds it
            density = self.channel.density * np.exp(-volume)
        return Snapshot(
            t=time,
            step=self.steps,
            x=position[:, 0] % self.channel.length,
            y=position[:, 1],
            u=velocity,
            v=np.zeros_like(velocity),
            density=density,
            pressure=np.zeros_like(velocity),
            **dict(zip(STRESSES, self.channel.density * np.array(stresses), strict=False)),
        )

    def around(self, times, x, half_width):
        """Return the particles within ``half_width`` of ``x`` (times,) at ``times`` of the last step, as flat arrays.

        Which time (ascending), x, y and u of each; only x less its period counts.
        """
        return self.dense.around(times, x, half_width, self.channel.length)

    def momentum_balance(self):
        """Return the balance of momentum along x up to ``time``, see ``MomentumBalance.report``."""
        total = active(self.stepper.velocity).sum(dtype=float)
        return self.momentum.report(self.channel, self.time, float(total))

    def numbers(self):
        """Return the numbers of this scheme for ``summary.json``."""
        return {
            **super().numbers(),
            "particles_wall": int(view(self.ghosts.count)),
        }

    def parts(self):
        """Return everything whose fields a resumed run needs, by name."""
        parts = {"motion": self.motion, "stepper": self.stepper, "field": self.field}
        return {**parts, **({"polymer": self.stepper.polymer} if self.stepper.polymer else {})}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {**super().host_state(), "momentum": vars(self.momentum), "walls": self.walls.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        super().restore_host_state(state)
        vars(self.momentum).update(state["momentum"])
        self.walls.enter(self.time)
        self.walls.restore_host_state(state["walls"])
