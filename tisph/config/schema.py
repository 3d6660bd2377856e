"""What a config may say: keys, types, ranges and defaults. Units are any self-consistent system.

Conditions between keys are in ``checks.py``; parameters of wall treatments, rheologies and schemes are in the
files of the members themselves.
"""

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tisph import families
from tisph.config import checks, yaml_text
from tisph.config.base import LARGEST, SMALLEST, Model, Positive, Signed, refusal, refusals
from tisph.config.fields import Member, member_name, number_or

FrameWidth = Annotated[int, Field(ge=640, le=4096, multiple_of=2)]
FrameHeight = Annotated[int, Field(ge=320, le=4096, multiple_of=2)]
Count = Annotated[int, Field(ge=checks.LEAST_PARTICLES_ACROSS, le=10**12)]

WallTreatment = Member("walls", usual="consistent_image")
Rheology = Member("rheology", usual="newtonian")
Scheme = Member("schemes", usual="auto", untyped="wcsph")


def _text(pattern: str, allowed: str) -> Any:
    """The type of a text that matches ``pattern`` from end to end; ``allowed`` says in words what that is."""

    def check(value: str) -> str:
        if not re.fullmatch(pattern, value):
            raise refusal(f"must be {allowed}")
        return value

    return Annotated[str, AfterValidator(check)]


def _not_zero(value: float) -> float:
    if value == 0:
        raise refusal("must not be 0: for a wall at rest give velocity: 0")
    return value


FolderName = _text(
    r"(?!\.)[A-Za-z0-9._-]{1,64}(?<!\.)",
    "a folder name: 1 to 64 of the characters A-Z a-z 0-9 . _ - without a dot at either end",
)
Label = _text(r"[A-Za-z0-9µ%^*/. -]{1,16}", "a unit label: 1 to 16 letters, digits or . % ^ * / -")


class Units(Model):
    """Labels of the units of length, mass and time, for plots and tables; nothing is converted."""

    length: Label = "m"
    mass: Label = "kg"
    time: Label = "s"


class Fluid(Model):
    """Density [mass/length^3] and viscosity: dynamic [mass/(length time)] or kinematic [length^2/time]."""

    exclusive_keys = ("dynamic_viscosity", "kinematic_viscosity")

    density: Positive
    dynamic_viscosity: Positive | None = None
    kinematic_viscosity: Positive | None = None
    rheology: Annotated[Model, Rheology] = Field(default_factory=Rheology.default)


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


class Discretisation(Model):
    """Particle spacing [length] or number across the gap (50), smoothing kernel, smoothing length over spacing."""

    exclusive_keys = ("particles_across", "spacing")

    particles_across: Count | None = None
    spacing: Positive | None = None
    kernel: member_name("kernels") = "quintic_spline"
    smoothing_ratio: Annotated[float, Field(ge=0.8, le=3)] = 1.0
    precision: Literal["f64", "f32"] = "f64"

    @model_validator(mode="before")
    @classmethod
    def _fill_in_resolution(cls, data: Any) -> Any:
        if isinstance(data, dict) and all(data.get(key) is None for key in cls.exclusive_keys):
            return {**data, "particles_across": 50}
        return data


class Time(Model):
    """End of the run, times at which samples are written [time], and what sets the steps.

    ``tolerance``: of the error of a step over the reference velocity, for schemes that estimate it. ``cfl``: Courant
    number of the explicit scheme; a number for the implicit one means steps of cfl * spacing / reference velocity.
    """

    end: Positive
    samples: Annotated[tuple[float, ...], Field(strict=False, min_length=1, max_length=1000)] = ()
    cfl: number_or(Annotated[float, Field(gt=0, le=1)], "auto") = "auto"
    tolerance: number_or(Annotated[float, Field(ge=1e-10, le=1e-1)], "auto") = "auto"

    @model_validator(mode="before")
    @classmethod
    def _fill_in_samples(cls, data: Any) -> Any:
        end = data.get("end") if isinstance(data, dict) else None
        is_number = isinstance(end, (int, float)) and not isinstance(end, bool)
        # a bad end is reported once, at its own key
        if is_number and SMALLEST <= end <= LARGEST and data.get("samples") is None:
            return {**data, "samples": [end]}
        return data


class Tracers(Model):
    """Probes on a vertical line at ``x`` [length], whose velocities go to history.csv."""

    count: Annotated[int, Field(ge=2, le=1000)] = 10
    x: number_or(Annotated[float, Field(ge=0)], "centre") = "centre"


class Video(Model):
    """Movie: frames a second, number of frames, size in pixels (even, as H.264 wants it), what colours show."""

    fps: Annotated[int, Field(ge=1, le=120)] = 30
    frames: Annotated[int, Field(ge=2, le=10_000)] = 120
    width: FrameWidth = 1280
    height: FrameHeight = 640
    renderer: Literal["raster"] = "raster"
    color_by: Literal["speed", "shear_stress"] = "speed"


class Output(Model):
    """Movie (null or false for none) and simulated time between checkpoints [time] (null for none)."""

    video: Annotated[Video | None, BeforeValidator(lambda value: None if value is False else value)] = Video()
    checkpoint_every: Positive | None = None


class Runtime(Model):
    """Where the loops run, and on how many threads."""

    arch: Literal["cpu"] = "cpu"
    threads: number_or(Annotated[int, Field(ge=1, le=256)], "auto") = "auto"


class Config(Model):
    """A whole run, checked; every key as in the YAML file, every default filled in."""

    name: FolderName
    scene: member_name("scenes")
    units: Units = Units()
    fluid: Fluid
    geometry: Geometry
    walls: Walls
    drive: Drive = Drive()
    initial: Initial = Initial()
    discretisation: Discretisation = Discretisation.model_validate({})
    scheme: Annotated[Model, Scheme] = Field(default_factory=Scheme.default)
    time: Time
    tracers: Tracers = Tracers()
    output: Output = Output()
    runtime: Runtime = Runtime()

    @model_validator(mode="after")
    def _check_between_keys(self) -> "Config":
        checks.raise_problems(self)
        return self

    @property
    def kinematic_viscosity(self) -> float:
        """Kinematic viscosity [length^2/time], whichever of the two was given."""
        return self.fluid.kinematic_viscosity or self.fluid.dynamic_viscosity / self.fluid.density

    @property
    def dynamic_viscosity(self) -> float:
        """Dynamic viscosity [mass/(length time)], whichever of the two was given."""
        return self.fluid.dynamic_viscosity or self.fluid.kinematic_viscosity * self.fluid.density

    @property
    def particles_across(self) -> int:
        """Rows of particles between the walls."""
        return self.discretisation.particles_across or round(self.geometry.gap / self.discretisation.spacing)

    @property
    def spacing(self) -> float:
        """Particle spacing [length], exactly gap / particles_across."""
        return self.geometry.gap / self.particles_across

    @property
    def columns(self) -> int:
        """Particles along x in one period."""
        return round(self.geometry.length / self.spacing)

    @property
    def support(self) -> float:
        """Radius of the kernel support in particle spacings."""
        radius = families.constant("kernels", self.discretisation.kernel, "SUPPORT")
        return radius * self.discretisation.smoothing_ratio

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]: ``initial.time`` for state ``exact``, else 0."""
        return self.initial.time

    def resolved_yaml(self) -> str:
        """The config as YAML with every default filled in; loading it gives an equal config."""
        return yaml_text.dump(self.model_dump())
