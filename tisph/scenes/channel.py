"""Plane channel 0 <= y <= gap, periodic in x: flow driven by its walls (steady or oscillating) and an acceleration.

The walls are the planes y = 0 and y = gap; fluid particles start at cell centres, (i + 1/2) spacing. Motion
starts, or changes, at t = 0. The run's clock starts at ``start_time``: at the initial time of the config for the
state ``exact``, else at 0.

Here is what a config says of it; the flow itself is in ``_channel``.
"""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, model_validator

from tisph.config import lattice, schema
from tisph.config.base import LARGEST, Model, Positive, Problem, Signed, refusal, refusals
from tisph.config.fields import Member, number_or
from tisph.scenes._channel.scene import Channel

__all__ = ["Channel", "Config", "Scene"]

Scene = Channel
"""The name under which a run asks a module of this folder for its scene."""

WallTreatment = Member("walls", usual="consistent_image")


def _not_zero(value: float) -> float:
    if value == 0:
        raise refusal("must not be 0: for a wall at rest give velocity: 0")
    return value


class Geometry(Model):
    """Distance between the walls and period along them [length]."""

    gap: Positive
    length: Positive


class Wall(Model):
    """Velocity of a wall along x from t = 0 on, of either sign: constant, or oscillating.

    ``velocity`` [length/time], with ``velocity_before`` for a wall that had another velocity before t = 0; or
    ``amplitude`` [length/time] * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t.
    """

    exclusive_keys = ("velocity", "amplitude")
    unset_keys = ("velocity_before", "angular_frequency", "phase")

    velocity: Signed | None = None
    velocity_before: Signed | None = None
    amplitude: Annotated[Signed, AfterValidator(_not_zero)] | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None

    @model_validator(mode="before")
    @classmethod
    def _fill_in_velocity_or_phase(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        if all(data.get(key) is None for key in ("velocity", "amplitude", "angular_frequency", "phase")):
            return {**data, "velocity": 0.0}
        if data.get("amplitude") is not None and data.get("phase") is None:
            return {**data, "phase": "cos"}
        return data

    @model_validator(mode="after")
    def _check_forms(self) -> "Wall":
        oscillates = self.amplitude is not None
        alien = ("velocity_before",) if oscillates else ("angular_frequency", "phase")
        form = "of constant velocity; this one oscillates" if oscillates else "that oscillates, which has an amplitude"
        values = {key: getattr(self, key) for key in alien}
        found = [((key,), f"is only for a wall {form}", value) for key, value in values.items() if value is not None]
        if oscillates and self.angular_frequency is None:
            found.append((("angular_frequency",), "is missing: a wall with an amplitude oscillates", {}))
        if found:
            raise refusals(found)
        return self


class Walls(Model):
    """Wall treatment, and the walls at y = 0 (``bottom``) and y = gap (``top``)."""

    treatment: Annotated[Model, WallTreatment] = Field(default_factory=WallTreatment.default)
    bottom: Wall = Wall()
    top: Wall = Wall()


class Drive(Model):
    """Body acceleration along x [length/time^2], of either sign: -(dp/dx) / density of a pressure gradient."""

    acceleration: Signed = 0.0


class Initial(Model):
    """Start: at rest, developed, or ``exact``: the exact flow at ``time`` that started at t = 0.

    Motion starts, or changes, at t = 0. ``developed``: the steady flow of the velocities before t = 0, the
    periodic flow of walls that oscillate. ``exact`` started from rest, or from the developed flow where a wall
    has a ``velocity_before``.

    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y; the same
    ``seed`` gives the same displacements.
    """

    state: Literal["rest", "developed", "exact"] = "rest"
    time: Annotated[float, Field(ge=0, le=LARGEST)] = 0.0
    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0


class Tracers(Model):
    """Probes on a vertical line at ``x`` [length], whose velocities go to history.csv."""

    count: Annotated[int, Field(ge=2, le=1000)] = 10
    x: number_or(Annotated[float, Field(ge=0)], "centre") = "centre"


class Config(schema.Config):
    """A whole run in the channel."""

    geometry: Geometry
    walls: Walls
    drive: Drive = Drive()
    initial: Initial = Initial()
    tracers: Tracers = Tracers()

    periodic = (True, False)
    across_name = "the gap"
    colours = ("speed", "shear_stress")

    @property
    def across(self) -> float:
        """The gap."""
        return self.geometry.gap

    @property
    def extent(self) -> tuple[float, float]:
        """Length and gap."""
        return self.geometry.length, self.geometry.gap

    @property
    def aspect(self) -> float:
        """Length over gap."""
        return self.geometry.length / self.geometry.gap

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]: ``initial.time`` for state ``exact``, else 0."""
        return self.initial.time

    @property
    def members(self) -> dict[str, Model]:
        """Those of every scene, and the wall treatment."""
        return {"walls": self.walls.treatment, **super().members}

    @property
    def followed(self) -> dict[str, Any]:
        """The tracers."""
        return {"count": self.tracers.count, "x": self.tracers.x}

    def problems(self) -> Iterator[Problem]:
        """What the channel has against the config."""
        yield from _motion(self)
        yield from _start(self)
        yield from _polymer(self)
        video, rheology = self.output.video, self.fluid.rheology
        if video and video.color_by == "shear_stress" and not rheology.carries_stress:
            text = f"needs a rheology with a stress of its own, such as oldroyd_b; {rheology.type} has none"
            yield "output.video.color_by", f"{text}: take speed"
        if self.tracers.x != "centre" and self.tracers.x > self.geometry.length:
            yield "tracers.x", f"must be inside the channel: centre, or 0 to {self.geometry.length:g}"

    def misfits(self) -> Iterator[Problem]:
        """A length that the spacing does not divide, or that is too short."""
        rows, gap, length = lattice.across(self), self.geometry.gap, self.geometry.length
        columns, least = rows * length / gap, lattice.least_in_period(self)
        if not lattice.is_whole(columns):
            wholes = sorted({max(whole, least) for whole in (math.floor(columns), math.ceil(columns))})
            lengths = " or ".join(f"{whole * gap / rows:.12g}" for whole in wholes)
            text = f"{round(rows)} particles across make {columns:.6g} columns in the length {length:g}"
            nearest = lattice.nearest_valid(self)
            text = f"{text}, no whole number; nearest valid geometry.length: {lengths}{nearest and f'; {nearest}'}"
            yield lattice.resolution_key(self), text, "geometry.length"
        elif round(columns) < least:
            text = f"must be at least {least * self.spacing:.6g}, {least} particle spacings"
            yield "geometry.length", f"{text}: the periodic neighbour search needs three cells along x"


def _motion(config: Config) -> Iterator[Problem]:
    walls = (config.walls.bottom, config.walls.top)
    if config.drive.acceleration or any(wall.amplitude for wall in walls):
        return
    velocities = {velocity for wall in walls for velocity in (wall.velocity, wall.velocity_before)} - {None}
    settled = config.initial.state == "developed" or any(wall.velocity_before is not None for wall in walls)
    if len(velocities | (set() if settled else {0.0})) == 1:
        text = "nothing moves: give walls.bottom or walls.top a velocity other than 0, or drive.acceleration"
        together = f"{text}; walls and liquid move together at {walls[0].velocity:g}"
        yield "walls", together if walls[0].velocity else text


def _start(config: Config) -> Iterator[Problem]:
    state = config.initial.state
    if state == "exact" and config.initial.time == 0:
        yield "initial.time", "must be greater than 0 with state exact (from rest: state rest)"
    if state != "exact" and config.initial.time != 0:
        yield "initial.time", f"is allowed only with state exact, not with state {state}"
    for side in ("bottom", "top"):
        if state == "rest" and getattr(config.walls, side).velocity_before is not None:
            text = "is not allowed with initial.state rest, in which nothing moves before t = 0"
            yield f"walls.{side}.velocity_before", f"{text}: take state developed, or exact with a time"


def _polymer(config: Config) -> Iterator[Problem]:
    for side in ("bottom", "top"):
        if config.fluid.rheology.carries_stress and getattr(config.walls, side).amplitude is not None:
            text = "no exact solution is built in for walls that oscillate in an Oldroyd-B liquid"
            yield f"walls.{side}.amplitude", f"{text}: give a constant velocity, or fluid.rheology {{type: newtonian}}"
