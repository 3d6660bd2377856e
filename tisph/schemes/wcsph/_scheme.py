"""Steps of the explicit scheme: second-order midpoint steps with one evaluation of the rates f each.

From the state y^n a predictor with the previous rates, y^(n+1/2) = y^n + dt/2 f^(n-1/2) (positions with the new
velocity), then y^(n+1) = y^n + dt f(y^(n+1/2)). One kernel with one loop over the particles evaluates the rates,
finishes the pending step and predicts the next middle; it reads one buffer and writes the other. A body force that a
user gives as a function is evaluated on the host in each step.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tisph import registry
from tisph.config.schema import Config
from tisph.errors import ConfigError, DivergedError
from tisph.runtime import scalar, ti, view
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.schemes._step_control import Kept, StepPlan
from tisph.schemes.wcsph._boundaries import Boundary, PeriodicBoundaries, PlaneWalls
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph._time_step import limits_of, shift_speed, sound_speed_of
from tisph.schemes.wcsph.cells import Cells, Particles
from tisph.schemes.wcsph.equation_of_state import compression, pressure
from tisph.schemes.wcsph.kernels import list_radius
from tisph.schemes.wcsph.operators._pairs import PairOperators
from tisph.schemes.wcsph.verlet import VerletLists
from tisph.schemes.wcsph.walls._treatment import WallTreatment
from tisph.snapshot import STRESSES, Snapshot

AT_WALLS = 1e-9
"""Acceleration on walls, over the largest in the fluid, that counts as zero."""

CONTROL_INTERVAL = 50
"""Steps between two updates of the time-step limit."""


class BodyForce:
    """Accelerations of the ``particles`` in the middle of each step, by the ``body_force`` of a ``scene``.

    Positions of particles count from ``origin`` [length]. Wall treatments continue pressure and velocity as without a
    body force, so that a force at a wall is refused: ``evaluate`` raises ConfigError.
    """

    def __init__(self, scene: Scene, particles: Particles, origin: Sequence[float]):
        self.particles, self.origin = particles, np.array(origin)
        self.scene: Scene = scene
        assert scene.body_force
        self.force = scene.body_force
        self.values, self.largest = np.zeros((particles.fluid, 2)), 0.0
        self.outlines = [(body, body.shape.boundary_points(scene.spacing).point) for body in scene.bodies]
        x = np.arange(scene.columns) * scene.spacing
        self.planes = [np.stack([x, np.full_like(x, y)]) for y in (0.0, scene.extent[1]) if scene.walls]

    def evaluate(self, now: int, middle: float) -> None:
        """Store the accelerations (fluid, 2) at the time ``middle`` of the pending step, whose buffer is ``now``."""
        place = self.origin + view(self.particles.mid_position)[now, : self.particles.fluid].astype(float)
        place = np.where(self.scene.periodic, place % self.scene.extent, place)
        self.values = np.stack(self.force(*place.T, middle), axis=1)
        self.largest = float(np.hypot(*self.values.T).max())
        walls = [body.at(middle).to_lab_frame(points).T for body, points in self.outlines]
        if any(np.abs(self.force(*wall, middle)).max() > AT_WALLS * self.largest for wall in (*self.planes, *walls)):
            raise ConfigError("body_force: must be 0 on walls with scheme wcsph; scheme implicit has no such limit")

    def apply(self, now: int, length: float, half: float) -> None:
        """Add the accelerations to the step of ``length`` in the buffer ``now``, and to the ``half`` step after it."""
        fluid, given = self.particles.fluid, self.values
        view(self.particles.velocity)[now, :fluid] += length * given
        view(self.particles.mid_velocity)[now, :fluid] += (length + half) * given
        view(self.particles.mid_position)[now, :fluid] += half * length * given


@ti.data_oriented
class Stepper:
    """The kernel that advances the particles, and the largest values over all particles for limits of the steps.

    ``drift_squared``: distance from the position that the lists predict, squared; ``speed_squared``;
    ``acceleration_squared``; ``stress_trace`` (where particles carry stress): polymer stress xx + yy.
    """

    def __init__(self, operators: PairOperators, walls: WallTreatment, serial: bool):
        self.operators, self.walls, self.serial = operators, walls, serial
        self.particles, self.lists, self.domain = operators.particles, operators.lists, operators.domain
        self.fluid = operators.fluid
        self.drift_squared = scalar(0.0)
        self.speed_squared = scalar(0.0)
        self.acceleration_squared = scalar(0.0)
        if self.fluid.carries_stress:
            self.stress_trace = scalar(0.0)

    @ti.kernel
    def step(self, now: ti.i32, dt: float, next_dt: float, elapsed: float, between: float):
        """Finish the pending step of ``dt`` and predict the middle of the next step, of ``next_dt``.

        ``elapsed``: time from the build of the lists to the new middle; ``between``: from middle to middle.
        """
        self.drift_squared[None] = 0.0
        self.speed_squared[None] = 0.0
        self.acceleration_squared[None] = 0.0
        half = 0.5 * next_dt
        if ti.static(self.fluid.carries_stress):
            self.stress_trace[None] = 0.0
        if ti.static(self.walls.tracks_walls):
            ti.loop_config(serialize=self.serial)
            for k in range(self.walls.track.count[None]):
                for top in ti.static(range(2)):
                    self.walls.track.follow(now, k, top, dt, half)
        ti.loop_config(serialize=self.serial)
        for i in range(self.particles.fluid_number[None]):
            self.advance(now, i, dt, half, elapsed)
        if ti.static(self.walls.has_dummies):
            ti.loop_config(serialize=self.serial)
            for number in range(self.particles.fluid_number[None], self.particles.mobile_number[None]):
                k = self.particles.slot(number)
                self.walls.advance(now, k, between)
                self.walls.extrapolate(1 - now, k)
        if ti.static(self.walls.tracks_walls):
            for top in ti.static(range(2)):
                self.walls.track.move(top, between)

    @ti.func
    def advance(self, now, i, dt, half, elapsed):
        """Finish the pending step of particle ``i``, write its next middle, and update the largest values."""
        rates = self.operators.rates(now, i)
        acceleration = rates.acceleration
        if ti.static(self.domain.has_body_force):
            acceleration.x += self.domain.acceleration[None]
        middle_velocity = self.particles.mid_velocity[now, i]
        position = self.particles.position[now, i] + dt * (middle_velocity + rates.transport)
        velocity = self.particles.velocity[now, i] + dt * acceleration
        compression = self.particles.compression[now, i] + dt * rates.compression
        self.particles.position[1 - now, i] = position
        self.particles.velocity[1 - now, i] = velocity
        self.particles.compression[1 - now, i] = compression
        self.particles.identity[1 - now, i] = self.particles.identity[now, i]

        position += half * (velocity + rates.transport)
        compression += half * rates.compression
        self.particles.mid_compression[1 - now, i] = compression
        next_velocity, pressure = velocity + half * acceleration, self.fluid.pressure(compression)
        if ti.static(self.fluid.carries_stress):
            stress = self.particles.stress[now, i] + dt * rates.stress
            self.particles.stress[1 - now, i] = stress
            self.walls.publish(1 - now, i, position, next_velocity, pressure, stress + half * rates.stress)
            ti.atomic_max(self.stress_trace[None], stress[0] + stress[2])
        else:
            self.walls.publish(1 - now, i, position, next_velocity, pressure, 0.0)
        drift = position - self.lists.built_position[i]
        if ti.static(self.lists.follows_shear):
            drift.x -= self.lists.reference_velocity[i] * elapsed
        ti.atomic_max(self.drift_squared[None], drift.dot(drift))
        ti.atomic_max(self.speed_squared[None], velocity.dot(velocity))
        ti.atomic_max(self.acceleration_squared[None], acceleration.dot(acceleration))


class ExplicitScheme(Kept):
    """Particles in the box of a scene, advanced step by step: the ``Scheme`` of ``wcsph``.

    ``targets``: times on which steps end exactly [time]. ``serial`` compiles loops without threads. ``length``,
    ``middle`` and ``end`` belong to the pending step; ``built``: time when the lists were built; ``now``: buffer.
    """

    kept = "time", "middle", "end", "built", "steps", "rebuilds", "now", "length", "limit", "shortest", "longest"

    def __init__(self, config: Config, scene: Scene, targets: Sequence[float], serial: bool):
        kernel = registry.load("kernels", config.discretisation.kernel)
        operators = registry.load("operators", config.scheme.operators).Operators
        rheology = config.fluid.rheology
        stress = registry.compiled("rheology", rheology.type).Stress(scene) if rheology.carries_stress else None
        self.scene = scene
        self.serial = serial
        self.config, self.equation_of_state = config, config.scheme.equation_of_state
        self.sound_speed = sound_speed_of(config, scene)
        length = config.discretisation.smoothing_ratio * scene.spacing
        cutoff = kernel.SUPPORT * length
        radius = list_radius(cutoff, scene.spacing)

        self.boundaries = boundaries(config, scene, radius)
        self.domain, treatment = self.boundaries.domain, self.boundaries.treatment
        self.fluid = Fluid(scene, self.equation_of_state, self.sound_speed, stress)
        self.particles = Particles(scene.particles, *self.boundaries.slots, rheology.carries_stress)
        self.cells = Cells(self.particles, self.domain, self.boundaries.box, radius)
        self.lists = VerletLists(self.cells, cutoff, scene.spacing, serial, treatment.uses_mirror_points)
        speeds = self.sound_speed, config.time.cfl, scene.solvent_viscosity / length
        shift = shift_speed(kernel, config.discretisation.smoothing_ratio, *speeds)
        artificial = config.scheme.artificial_viscosity
        self.operators = operators(self.lists, self.fluid, kernel, artificial, shift)
        self.walls = self.boundaries.create_walls(self.operators, kernel)
        self.stepper = Stepper(self.operators, self.walls, serial)
        self.body_force = BodyForce(scene, self.particles, self.boundaries.origin) if scene.body_force else None
        self.plan = StepPlan(scene.start_time, targets)
        self.time = self.middle = self.end = self.built = scene.start_time
        self.steps = self.rebuilds = self.now = 0
        self.length, self.limit, self.shortest, self.longest = 0.0, math.inf, math.inf, 0.0

    def start(self, position: np.ndarray, velocity: np.ndarray, stress: np.ndarray | None = None) -> None:
        """Place the particles at ``position`` with ``velocity``, (particles, 2), and evaluate their first rates.

        ``stress``: polymer stress xx, xy, yy [mass/(length time^2)], (particles, 3), where particles carry it.
        """
        self.limit = self.time_step_limit()
        scaled = None if stress is None else stress / self.scene.density
        self.particles.load(position - np.array(self.boundaries.origin), velocity, scaled)
        self.initialise_pressure(position)
        self.boundaries.begin(float(velocity[:, 0].sum()))
        self.rebuild()
        self.boundaries.jump(self.stepper, self.now)
        self.proceed()
        self.limit = self.time_step_limit()

    def initialise_pressure(self, position: np.ndarray) -> None:
        """Set the initial pressure of the particles where it is known: without it there would be sound waves."""
        scene, fluid = self.scene, self.particles.fluid
        if "pressure" not in scene.fields:
            return
        x, y = position.T
        values = scene.exact("pressure", x, y, scene.start_time)
        scales = {"density": scene.density, "sound_speed": self.sound_speed}
        compressed = compression(self.equation_of_state, values, **scales)
        view(self.particles.compression)[:, :fluid] = view(self.particles.mid_compression)[0, :fluid] = compressed
        view(self.particles.mid_pressure)[0, :fluid] = values / scene.density

    @property
    def finished(self) -> bool:
        """Whether the last target is reached."""
        return self.length == 0.0

    def advance(self) -> None:
        """Take one step; raise DivergedError where a capacity overflows."""
        self.steps += 1
        self.shortest = min(self.shortest, self.length)
        self.longest = max(self.longest, self.length)
        self.proceed()
        if self.steps % CONTROL_INTERVAL == 0:
            self.limit = self.time_step_limit()

    def proceed(self) -> None:
        """Evaluate the rates in the middle of the pending step, finish it, and predict the next middle."""
        drifts = (drift * drift for drift in self.boundaries.drifts())
        of_fluid = float(view(self.stepper.drift_squared)) * self.boundaries.displacement_factor**2
        drift_squared = max(of_fluid, *drifts)
        if self.lists.outdated(drift_squared, self.middle - self.built):
            self.rebuild()
        if self.length > 0.0:
            self.boundaries.account(self.now, self.steps, self.middle)
        length, time = self.length, self.end
        self.length = self.plan.next(self.limit)
        self.end = self.plan.time
        middle = time + 0.5 * self.length
        self.boundaries.move_on(self.middle, middle)
        if self.body_force:
            self.body_force.evaluate(self.now, self.middle)
        self.stepper.step(self.now, length, self.length, middle - self.built, middle - self.middle)
        self.now = 1 - self.now
        if self.body_force:
            self.body_force.apply(self.now, length, 0.5 * self.length)
        self.time, self.middle = time, middle

    def time_step_limit(self) -> float:
        """Return the longest step that the present speeds, accelerations and stresses allow.

        Where they are not finite the limit is not changed: the guard, called as often, raises the error.
        """
        scene, stepper = self.scene, self.stepper
        tension = max(0.0, float(view(stepper.stress_trace))) if self.particles.carries_stress else 0.0
        limits = limits_of(
            self.config,
            scene,
            self.sound_speed,
            speed=max(scene.peak_velocity, math.sqrt(view(stepper.speed_squared))),
            acceleration=math.sqrt(view(stepper.acceleration_squared))
            + (self.body_force.largest if self.body_force else 0.0),
            elastic_speed=math.sqrt(scene.elastic_speed**2 + tension),
        )
        limit = min(limits.values())
        return limit if limit > 0.0 else self.limit

    def rebuild(self) -> None:
        """Sort the particles into cells and list their neighbours anew."""
        self.cells.sort(self.now)
        self.particles.reorder(self.now, self.cells.order, self.serial)
        self.now = 1 - self.now
        self.walls.lay_out(self.now)
        self.require_room("images of particles", self.walls.overflow())
        self.lists.build(self.now)
        self.require_room("neighbours of a particle", self.lists.overflow())
        self.boundaries.rebuilt(self.now, self.middle)
        self.built = self.middle
        self.rebuilds += 1

    def require_room(self, what: str, needed: int) -> None:
        """Raise DivergedError for an overflow: ``needed`` is the number of entries, 0 without an overflow."""
        if needed:
            crowded = np.argmax(view(self.lists.count)[: self.particles.fluid])
            particle = int(view(self.particles.identity)[self.now, crowded])
            where = f"around particle {particle}, at step {self.steps}, t = {self.time:.6g}"
            raise DivergedError(f"x, y: too many {what} ({needed}) {where}: the particles have clustered")

    def output_times(self, due: Sequence[float]) -> Sequence[float]:
        """Return the time of the snapshot for the times that are ``due``: the end of the last step."""
        return [self.time] if due else []

    def snapshot(self, time: float | None = None) -> Snapshot:
        """Return the state at the end of the last step as a Snapshot; ``time`` is that time."""
        position, velocity, compression, stress = self.particles.state(self.now)
        compression = compression.astype(float)
        sides = zip(position.T, self.scene.extent, self.scene.periodic, self.boundaries.origin, strict=True)
        x, y = (first + (place % size if periodic else place) for place, size, periodic, first in sides)
        stresses = {}
        if stress is not None:
            parts = zip(STRESSES, stress.T, strict=True)
            stresses = {name: self.scene.density * values.astype(float) for name, values in parts}
        snapshot = Snapshot(
            t=self.time,
            step=self.steps,
            x=x,
            y=y,
            u=velocity[:, 0],
            v=velocity[:, 1],
            density=self.scene.density * (1.0 + compression),
            pressure=pressure(
                self.equation_of_state,
                compression,
                density=self.scene.density,
                sound_speed=self.sound_speed,
            ),
            **stresses,
        )
        return self.boundaries.described(snapshot)

    def momentum_balance(self) -> Mapping[str, Any]:
        """Return the balance of momentum along x up to ``time``."""
        if self.body_force and self.scene.walls:  # the impulse of a given function is not known
            return {}
        return self.boundaries.momentum_balance(self.time, self.particles.momentum(self.now))

    def parts(self) -> Mapping[str, Any]:
        """Return all objects that hold fields, by name, for a checkpoint."""
        return {
            "stepper": self.stepper,
            "domain": self.domain,
            "particles": self.particles,
            "cells": self.cells,
            "lists": self.lists,
            "walls": self.walls,
            **self.walls.parts(),
        }

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {**super().host_state(), "plan": vars(self.plan), "surroundings": self.boundaries.host_state()}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        super().restore_host_state(state)
        vars(self.plan).update(state["plan"])
        self.boundaries.restore_host_state(state["surroundings"])

    def set_targets(self, targets: Sequence[float]) -> bool:
        """Continue to other targets; return whether a run that had them from the start would have the same steps."""
        same = self.plan.aim(targets)
        if self.finished:  # the rates of the last step are gone; a run with later targets would predict with them
            self.proceed()
            return False
        return same

    def numbers(self) -> Mapping[str, Any]:
        """Return the numbers of this scheme for ``summary.json``."""
        return {
            "mach": self.scene.peak_velocity / self.sound_speed,
            "sound_speed": self.sound_speed,
            "particles_wall": self.particles.dummies + self.walls.present_images(),
            "neighbours_mean": self.lists.mean_length(),
            "neighbour_rebuilds": self.rebuilds,
        }


def boundaries(config: Config, scene: Scene, radius: float) -> Boundary:
    """Return the boundary of the fluid of a ``scene``, for lists of this ``radius`` [length]."""
    if isinstance(scene, Channel):
        return PlaneWalls(config, scene, radius)
    if scene.bodies:
        from tisph.schemes.wcsph._bodies import SolidBodies  # it imports scipy.spatial

        return SolidBodies(config, scene, radius)
    return PeriodicBoundaries(scene)
