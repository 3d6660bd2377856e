"""Sections of a config that all scenes share, but the scheme: keys, types, ranges and defaults."""

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tisph.config.base import LARGEST, SMALLEST, Model, NonNegative, Positive, Signed, Whole, refusal
from tisph.config.fields import Member, either, member_name, number_or

LEAST_PARTICLES_ACROSS = 6

MOST_PLACES = 100

LARGEST_GROWTH = 0.3
"""Largest growth of the spacing over the distance: with 0.2 a prototype was stable, neighbours differ by a fifth."""

FrameWidth = Annotated[Whole, Field(ge=640, le=4096, multiple_of=2)]
FrameHeight = Annotated[Whole, Field(ge=320, le=4096, multiple_of=2)]


Limits = Annotated[tuple[float, float], Field(strict=False)]


class Video(Model):
    """Movie: frames per second, number of frames, size in pixels (even, for H.264), and contents.

    ``color_by``: quantity that the colours show, between the ``limits`` [a, b], or those of the values of the run, or
    of each frame: then the numbers at the colour bar change. Coloured by dye, the fluid keeps the colour of the pattern
    ``dye`` in the first frame. ``style`` auto: a continuous field in two-dimensional flow, else particles. ``overlay``:
    velocities as arrows, streamlines, or the paths of some particles.
    """

    fps: Annotated[Whole, Field(ge=1, le=120)] = 30
    frames: Annotated[Whole, Field(ge=2, le=10_000)] = 120
    width: FrameWidth = 1280
    height: FrameHeight = 640
    renderer: Literal["raster"] = "raster"
    color_by: str = "speed"
    limits: either(Limits, Literal["auto", "frame"], lambda value: value in ("auto", "frame"), "auto or frame") = "auto"
    style: Literal["auto", "field", "particles", "both"] = "auto"
    dye: Literal["stripes", "checkerboard", "blob"] = "stripes"
    overlay: Literal["none", "vectors", "streamlines", "tracks"] = "none"
    theme: Literal["light", "dark"] = "light"


Count = Annotated[Whole, Field(ge=LEAST_PARTICLES_ACROSS, le=10**12)]

Rheology = Member("rheology", usual="newtonian")


def text_type(pattern: str, allowed: str) -> Any:
    """Return the type of a text that matches ``pattern`` from end to end; ``allowed``: its description in a message."""

    def check(value: str) -> str:
        if not re.fullmatch(pattern, value):
            raise refusal(f"must be {allowed}")
        return value

    return Annotated[str, AfterValidator(check)]


Label = text_type(r"[A-Za-z0-9µ%^*/. -]{1,16}", "a unit label: 1 to 16 letters, digits or . % ^ * / -")


class Units(Model):
    """Labels of the units of length, mass and time, for plots and tables; nothing is converted."""

    length: Label = "m"
    mass: Label = "kg"
    time: Label = "s"


class Fluid(Model):
    """Density [mass/length^3] and viscosity: dynamic [mass/(length time)] or kinematic [length^2/time].

    ``inertia``: whether fluid and bodies have any; without it the flow is Stokes flow at every time.
    """

    exclusive_keys = ("dynamic_viscosity", "kinematic_viscosity")

    density: Positive
    dynamic_viscosity: Positive | None = None
    kinematic_viscosity: Positive | None = None
    inertia: bool = True
    rheology: Annotated[Any, Rheology] = Field(default_factory=Rheology.default)

    @property
    def newtonian(self) -> bool:
        """Whether the stress is proportional to the rate of deformation."""
        return self.rheology.type == "newtonian"

    @property
    def linear(self) -> bool:
        """Whether flows of the fluid in a channel add up."""
        return self.rheology.type in ("newtonian", "oldroyd_b")

    @property
    def polymer(self) -> Any:
        """The rheology where it has a polymer, else None."""
        return self.rheology if self.rheology.carries_stress else None


Place = Annotated[tuple[Signed, Signed], Field(strict=False)]


GAPS = "gaps"
"""Name of all gaps between bodies and walls."""


class Refinement(Model):
    """A smaller ``spacing`` [length] of particles up to the distance ``within`` [length] from a place.

    The place is a body or a wall, ``near`` it by its key, a ``box`` from its lowest to its highest corner, or a point;
    or ``near: gaps``, where ``spacing`` is the smallest one in narrow gaps between bodies and walls.
    """

    exclusive_keys = ("near", "box", "at")

    near: str | None = None
    box: Annotated[tuple[Place, Place], Field(strict=False)] | None = None
    at: Place | None = None
    spacing: Positive
    within: NonNegative = 0.0


class Discretisation(Model):
    """Particle spacing [length] or number across (50), smoothing kernel, smoothing length over spacing.

    ``refine``: places with a smaller spacing, which grows by ``growth`` (0.1) times the distance from them; or auto,
    for the places that a first run finds.
    """

    exclusive_keys = ("particles_across", "spacing")
    unset_keys = ("refine", "growth")

    particles_across: Count | None = None
    spacing: Positive | None = None
    refine: number_or(Annotated[tuple[Refinement, ...], Field(strict=False, max_length=MOST_PLACES)], "auto") = ()
    growth: Annotated[float, Field(gt=0, le=LARGEST_GROWTH)] | None = None
    kernel: member_name("kernels") = "quintic_spline"
    smoothing_ratio: Annotated[float, Field(ge=0.8, le=3)] = 1.0
    precision: Literal["f64", "f32"] = "f64"

    @property
    def places(self) -> tuple[Refinement, ...]:
        """The places to refine; none before the first run of auto."""
        return () if self.refine == "auto" else self.refine

    @model_validator(mode="before")
    @classmethod
    def _fill_in_resolution(cls, data: Any) -> Any:
        if isinstance(data, dict) and all(data.get(key) is None for key in cls.exclusive_keys):
            return {**data, "particles_across": 50}
        return data


class Time(Model):
    """End of the run, times at which samples are written [time], and tolerance or Courant number of the steps.

    ``tolerance``: largest error of a step over the reference velocity, for schemes that estimate it. ``cfl``: Courant
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
        # an invalid end is reported once, at its own key
        if not isinstance(end, int | float) or isinstance(end, bool) or not SMALLEST <= end <= LARGEST:
            return data
        return data if data.get("samples") is not None else {**data, "samples": [end]}


class Reference(Model):
    """Velocity [length/time] of dimensionless numbers and errors, in place of the one from walls, bodies and drive."""

    velocity: Positive


class Output(Model):
    """Movie (null or false for none), simulated time between checkpoints [time] (null for none), and ``vtk``: whether
    samples are also written for ParaView during the run."""

    video: Annotated[Video | None, BeforeValidator(lambda value: None if value is False else value)] = Video()
    checkpoint_every: Positive | None = None
    vtk: bool = False


class Runtime(Model):
    """Processor and number of threads of the loops."""

    arch: Literal["cpu"] = "cpu"
    threads: number_or(Annotated[Whole, Field(ge=1, le=256)], "auto") = "auto"
