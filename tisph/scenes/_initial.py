"""Sections of a config that scenes share: start, drive and contact; and the checks of start and periods."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from tisph.config.base import Model, NonNegative, Positive, Problem, Signed, Whole, findings, refusals, refuse
from tisph.config.motion import Amplitude, Times, Values, WallMotion, check_as_many, check_schedule
from tisph.config.schema import LEAST_IN_PERIOD, Config
from tisph.geometry import motion


class Drive(Model):
    """Drive of fluid and bodies.

    ``acceleration`` [length/time^2] along x, of either sign: -(dp/dx) / density of a pressure gradient, which acts on a
    free body as it does on the fluid that the body displaces. ``gravity`` [gx, gy] [length/time^2]: a hydrostatic
    pressure, which results leave out of ``pressure``, bears the weight of the fluid. A free body has its weight minus
    the weight of the displaced fluid: (density of the body - density of the fluid) * area * gravity.
    """

    unset_keys = ("gravity",)

    acceleration: Signed = 0.0
    gravity: Annotated[tuple[Signed, Signed], Field(strict=False)] | None = None


class PulsatingDrive(WallMotion):
    """Acceleration along walls or axis [length/time^2], -(dp/dx)/density, of either sign.

    ``acceleration`` + ``amplitude`` * cos or sin (``phase``) of ``angular_frequency`` [1/time] * t, each part 0 unless
    given; or ``accelerations`` at ``times``, linear in between and constant before and after, with a jump where two
    times are equal.
    """

    speed_key = "acceleration"
    other_keys = ("times", "accelerations")
    unset_keys = ("acceleration", "amplitude", "angular_frequency", "phase", *other_keys)

    acceleration: Signed | None = None
    amplitude: Amplitude | None = None
    angular_frequency: Positive | None = None
    phase: Literal["cos", "sin"] | None = None
    times: Times | None = None
    accelerations: Values | None = None

    acceleration_before: ClassVar[None] = None

    @model_validator(mode="after")
    def _check_times(self) -> "PulsatingDrive":
        if self.times is None and self.accelerations is None:
            return self
        others = [key for key in ("acceleration", "amplitude", "angular_frequency", "phase") if getattr(self, key)]
        refuse(findings(self, others, "must be left out beside accelerations at times"))
        if self.accelerations is None:
            raise refusals([(("times",), "is only for accelerations at these times", self.times)])
        check_as_many(self, "accelerations")
        check_schedule(self, "accelerations")
        return self

    @property
    def varies(self) -> str | None:
        """Key of the part that varies with time; None of a constant drive."""
        return "accelerations" if self.accelerations else "amplitude" if self.amplitude else None

    @property
    def parts(self) -> dict[str, Any]:
        """The constant part and the part that varies, by the names of members of a flow."""
        varying: Any = None
        if self.accelerations:
            varying = motion.Schedule(self.times or (), self.accelerations)
        elif self.amplitude:
            varying = motion.WallMotion.from_config(self)
        return {"acceleration": self.acceleration or 0.0, "pulsation": varying}

    def start_problems(self, config: Config) -> Iterator[Problem]:
        """Yield the errors in the start of a ``config`` with a drive that varies."""
        if self.accelerations and config.initial.state != "rest":
            yield "initial.state", "must be rest where the drive has accelerations at times"
        elif self.amplitude and config.initial.state == "developed" and not config.fluid.newtonian:
            text = f"no periodic flow is built in for {config.fluid.rheology.type} fluids"
            yield "initial.state", f"{text}: take rest, or a drive without amplitude"


class Contact(Model):
    """Near contact of free bodies: bodies nearer than ``distance`` [length] to each other or to a wall are repelled.

    No fluid is resolved between them. The default distance is two particle spacings.
    """

    distance: Positive


def still_problem(config: Config, key: str, remedy: str) -> Iterator[Problem]:
    """Yield an error at ``key`` of a ``config`` in which nothing moves.

    With a reference velocity, a temperature or a dissolved substance it is no error.
    """
    if not (config.reference or config.temperature or config.scalars):
        text = "nothing moves: " + remedy
        yield key, f"{text}; or a reference.velocity, where a Python function drives the fluid"


class RestInitial(Model):
    """The fluid is at rest at first.

    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y, after the particles
    have been spread evenly; the same ``seed`` gives the same displacements.
    """

    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0


class Initial(Model):
    """Start: at rest, developed, or ``exact``: the exact flow at ``time`` that started at t = 0.

    Motion starts, or changes, at t = 0. ``developed``: the steady flow of the velocities before t = 0, the
    periodic flow of walls that oscillate. ``exact`` started from rest, or from the developed flow where a wall
    has another velocity before t = 0.

    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y; the same
    ``seed`` gives the same displacements.
    """

    state: Literal["rest", "developed", "exact"] = "rest"
    time: NonNegative = 0.0
    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0


def start_problems(config: Config, walls: Sequence[str]) -> Iterator[Problem]:
    """Yield the errors in the start of the ``config`` of a scene with these ``walls``."""
    state = config.initial.state
    if state == "exact" and config.initial.time == 0:
        yield "initial.time", "must be greater than 0 with state exact (from rest: state rest)"
    if state != "exact" and config.initial.time != 0:
        yield "initial.time", f"is allowed only with state exact, not with state {state}"
    for side in walls:
        wall = getattr(config.walls, side)
        if state == "rest" and wall.speed_before is not None:
            text = "is not allowed with initial.state rest, in which nothing moves before t = 0"
            yield f"walls.{side}.{wall.speed_key}_before", f"{text}: take state developed, or exact with a time"


def incommensurate_periods(config: Config) -> Iterator[Problem]:
    """Yield an error for each period with too few particles."""
    for periodic, size, key in zip(config.periodic, config.extent, ("length", "height"), strict=True):
        if periodic and round(size / config.spacing) < LEAST_IN_PERIOD:
            text = f"must be at least {LEAST_IN_PERIOD * config.spacing:.6g}, {LEAST_IN_PERIOD} particle spacings"
            yield f"geometry.{key}", f"{text}: the neighbour search needs three cells around bodies"
