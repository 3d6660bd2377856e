"""Explicit weakly compressible SPH: density carried by the particles, pressure from an equation of state.

Second-order midpoint steps with one evaluation of the rates f each: from the state y^n a predictor with the
previous rates, y^(n+1/2) = y^n + dt/2 f^(n-1/2) (positions with the new velocity), then
y^(n+1) = y^n + dt f(y^(n+1/2)). One loop over the particles evaluates, corrects and predicts the next middle,
reading one buffer and writing the other.
"""

import math
from typing import Literal

import numpy as np
from pydantic import Field

from tisph import families
from tisph.config.base import Model
from tisph.config.fields import member_name
from tisph.domain import Domain
from tisph.equation_of_state import Tait, pressure, sound_speed
from tisph.errors import DivergedError
from tisph.liquid import Liquid
from tisph.neighbours.cells import Cells
from tisph.neighbours.verlet import VerletLists, reach
from tisph.particles import Particles
from tisph.runtime import scalar, ti
from tisph.schemes._plan import StepPlan
from tisph.schemes._time_step import effective_viscosity, time_step_limits
from tisph.snapshot import Snapshot

CONTROL_INTERVAL = 50
"""Steps between two looks at speeds and accelerations for the time step."""

HOST_STATE = (
    "time",
    "middle",
    "end",
    "built",
    "steps",
    "rebuilds",
    "now",
    "length",
    "limit",
    "shortest",
    "longest",
)
"""Attributes of a Scheme that change while it runs."""


class Parameters(Model):
    """Choices of the explicit scheme.

    ``operators``: ``consistent`` (corrected, shifted, diffused density) or ``standard`` (the usual WCSPH, for
    comparison). ``artificial_viscosity``: Monaghan's linear coefficient alpha, 0 for none.
    """

    type: Literal["wcsph"] = "wcsph"
    operators: member_name("operators") = "consistent"
    equation_of_state: Tait = Tait()
    artificial_viscosity: float = Field(default=0.0, ge=0, le=10)


@ti.data_oriented
class Scheme:
    """Particles in a channel, advanced step by step; ``time`` and ``steps`` tell how far.

    ``targets`` are times that steps end on exactly. ``serial`` compiles loops without threads.
    """

    def __init__(self, config, channel, targets, serial):
        kernel = families.load("kernels", config.discretisation.kernel)
        walls = families.load("walls", config.walls.treatment.type).Treatment
        operators = families.load("operators", config.scheme.operators).Operators
        self.channel = channel
        self.serial = serial
        self.equation_of_state = config.scheme.equation_of_state
        self.sound_speed = sound_speed(
            self.equation_of_state,
            reference_velocity=channel.reference_velocity,
            kinematic_viscosity=channel.kinematic_viscosity,
            gap=channel.gap,
            density=channel.density,
        )
        self.cfl = config.time.cfl
        self.artificial_viscosity = config.scheme.artificial_viscosity
        self.smoothing_length = config.discretisation.smoothing_ratio * channel.spacing
        cutoff = kernel.SUPPORT * self.smoothing_length
        radius = reach(cutoff, channel.spacing)

        self.domain = Domain(channel)
        self.liquid = Liquid(channel, self.equation_of_state, self.sound_speed)
        self.particles = Particles(channel.rows * channel.columns, *walls.wall_slots(channel, radius))
        self.cells = Cells(self.particles, self.domain, channel, radius)
        self.lists = VerletLists(self.cells, cutoff, channel.spacing, serial)
        self.walls = walls(self.particles, self.cells, self.lists, kernel)
        self.operators = operators(self.particles, self.lists, self.liquid, kernel, self.artificial_viscosity)
        self.drift_squared = scalar(0.0)
        self.speed_squared = scalar(0.0)
        self.acceleration_squared = scalar(0.0)
        self.plan = StepPlan(channel.start_time, targets)
        self.time = self.middle = self.end = self.built = channel.start_time
        self.steps = self.rebuilds = self.now = 0
        self.length, self.limit = 0.0, math.inf
        self.shortest, self.longest = math.inf, 0.0

    def start(self, position, velocity):
        """Place the particles, (particles, 2) arrays, and evaluate their first rates."""
        self.limit = self.time_step_limit()
        self.particles.load(position, velocity, 1e3 * (self.channel.gap + self.channel.length))
        self.walls.load(self.channel)
        self.rebuild()
        self.proceed()
        self.limit = self.time_step_limit()

    @property
    def finished(self):
        """Whether the last target is reached."""
        return self.length == 0.0

    def advance(self):
        """Take one step; raise DivergedError where a capacity overflows."""
        self.steps += 1
        self.shortest = min(self.shortest, self.length)
        self.longest = max(self.longest, self.length)
        self.proceed()
        if self.steps % CONTROL_INTERVAL == 0:
            self.limit = self.time_step_limit()

    def proceed(self):
        """Evaluate the rates in the middle of the pending step, finish it, and predict the next middle."""
        if self.lists.outdated(self.drift_squared[None], self.middle - self.built):
            self.rebuild()
        length, time = self.length, self.end
        self.length = self.plan.next(self.limit)
        self.end = self.plan.time
        middle = time + 0.5 * self.length
        self.step(self.now, length, self.length, middle - self.built, middle - self.middle)
        self.now = 1 - self.now
        self.time, self.middle = time, middle

    def time_step_limit(self):
        """Return the longest step that the present speeds and accelerations allow.

        Where they are not finite the step stays as it is: the guard, which looks as often, names the fault.
        """
        limits = time_step_limits(
            self.cfl,
            smoothing_length=self.smoothing_length,
            sound_speed=self.sound_speed,
            reference_velocity=max(self.channel.reference_velocity, math.sqrt(self.speed_squared[None])),
            kinematic_viscosity=effective_viscosity(
                self.channel.kinematic_viscosity, self.artificial_viscosity, self.smoothing_length, self.sound_speed
            ),
            acceleration=math.sqrt(self.acceleration_squared[None]),
        )
        limit = min(limits.values())
        return limit if limit > 0.0 else self.limit

    def rebuild(self):
        """Sort the particles into cells and list their neighbours anew."""
        self.cells.sort(self.now)
        self.particles.reorder(self.now, self.cells.order, self.serial)
        self.now = 1 - self.now
        self.walls.lay_out(self.now)
        self.require_room("images of particles", self.walls.overflow())
        self.lists.build(self.now)
        self.require_room("neighbours of a particle", self.lists.overflow())
        self.walls.refresh(self.now)
        self.built = self.middle
        self.rebuilds += 1

    def require_room(self, what, needed):
        """Raise DivergedError if ``needed`` (0 where all fits) tells of an overflow."""
        if needed:
            raise DivergedError(
                f"x, y: too many {what} ({needed}) around particle {self.most_crowded()}, "
                f"at step {self.steps}, t = {self.time:.6g}: the particles have clustered"
            )

    def most_crowded(self):
        """Return the number of the particle with the longest list of neighbours."""
        count = self.lists.count.to_numpy()[: self.particles.fluid]
        return int(self.particles.identity.to_numpy()[self.now, np.argmax(count)])

    def snapshot(self):
        """Return the state at ``time`` as a Snapshot."""
        position, velocity, compression = self.particles.state(self.now)
        compression = compression.astype(float)
        return Snapshot(
            t=self.time,
            step=self.steps,
            x=position[:, 0] % self.channel.length,
            y=position[:, 1],
            u=velocity[:, 0],
            v=velocity[:, 1],
            density=self.channel.density * (1.0 + compression),
            pressure=pressure(
                self.equation_of_state,
                compression,
                density=self.channel.density,
                sound_speed=self.sound_speed,
            ),
        )

    def parts(self):
        """Return everything that holds fields, by name: what a checkpoint saves."""
        return {
            "scheme": self,
            "particles": self.particles,
            "cells": self.cells,
            "lists": self.lists,
            "walls": self.walls,
        }

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {**{name: getattr(self, name) for name in HOST_STATE}, "plan": vars(self.plan)}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        for name in HOST_STATE:
            setattr(self, name, state[name])
        vars(self.plan).update(state["plan"])

    def wall_particles(self):
        """Return the number of wall particles, images or dummies, at present."""
        return self.particles.mobile - self.particles.fluid + self.walls.present_images()

    @ti.kernel
    def step(self, now: ti.i32, length: float, next_length: float, elapsed: float, between: float):
        """Finish the pending step of ``length`` and predict the middle of the one after it.

        ``elapsed``: time from the build of the lists to the new middle; ``between``: from middle to middle.
        """
        self.drift_squared[None] = 0.0
        self.speed_squared[None] = 0.0
        self.acceleration_squared[None] = 0.0
        ti.loop_config(serialize=self.serial)
        for i in range(self.particles.fluid):
            rates = self.operators.rates(now, i)
            middle_velocity = self.particles.mid_velocity[now, i]
            position = self.particles.position[now, i] + length * (middle_velocity + rates.transport)
            velocity = self.particles.velocity[now, i] + length * rates.acceleration
            compression = self.particles.compression[now, i] + length * rates.compression
            self.particles.position[1 - now, i] = position
            self.particles.velocity[1 - now, i] = velocity
            self.particles.compression[1 - now, i] = compression
            self.particles.identity[1 - now, i] = self.particles.identity[now, i]

            half = 0.5 * next_length
            position += half * (velocity + rates.transport)
            compression += half * rates.compression
            self.particles.mid_compression[1 - now, i] = compression
            self.walls.publish(
                1 - now, i, position, velocity + half * rates.acceleration, self.liquid.pressure(compression)
            )
            drift = position - self.lists.built_position[i]
            drift.x -= self.lists.reference_velocity[i] * elapsed
            ti.atomic_max(self.drift_squared[None], drift.dot(drift))
            ti.atomic_max(self.speed_squared[None], velocity.dot(velocity))
            ti.atomic_max(self.acceleration_squared[None], rates.acceleration.dot(rates.acceleration))
        if ti.static(self.walls.gathers):
            ti.loop_config(serialize=self.serial)
            for k in range(self.particles.fluid, self.particles.mobile):
                self.walls.advance(now, k, between)
                self.walls.extrapolate(1 - now, k)
