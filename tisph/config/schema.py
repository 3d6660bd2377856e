"""Keys, types, ranges and defaults of every config. Units are any self-consistent system.

The sections of a scene are in its file in ``tisph/scenes``. Conditions between keys are in ``checks.py``;
parameters of wall treatments, rheologies and schemes are in the files of the members themselves.
"""

import re
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, model_validator

from tisph import registry
from tisph.config import checks, yaml_text
from tisph.config.base import LARGEST, SMALLEST, Model, Positive, Problem, Whole, refusal
from tisph.config.checks import LEAST_PARTICLES_ACROSS
from tisph.config.fields import Member, member_name, number_or

FrameWidth = Annotated[Whole, Field(ge=640, le=4096, multiple_of=2)]
FrameHeight = Annotated[Whole, Field(ge=320, le=4096, multiple_of=2)]


class Video(Model):
    """Movie: frames per second, number of frames, size in pixels (even, for H.264), and contents.

    ``color_by``: quantity that the colours show, between the ``limits`` [a, b], or the least and largest value of the
    run. Coloured by dye, the fluid keeps the colour of the pattern ``dye`` in the first frame. ``style`` auto: a
    continuous field in two-dimensional flow, else particles. ``overlay``: velocities as arrows, streamlines, or the
    paths of some particles.
    """

    fps: Annotated[Whole, Field(ge=1, le=120)] = 30
    frames: Annotated[Whole, Field(ge=2, le=10_000)] = 120
    width: FrameWidth = 1280
    height: FrameHeight = 640
    renderer: Literal["raster"] = "raster"
    color_by: str = "speed"
    limits: number_or(Annotated[tuple[float, float], Field(strict=False)], "auto") = "auto"
    style: Literal["auto", "field", "particles", "both"] = "auto"
    dye: Literal["stripes", "checkerboard", "blob"] = "stripes"
    overlay: Literal["none", "vectors", "streamlines", "tracks"] = "none"
    theme: Literal["light", "dark"] = "light"


Count = Annotated[Whole, Field(ge=LEAST_PARTICLES_ACROSS, le=10**12)]

FORMER_KEYS = {"tracers": "probes"}
"""Former name of a section -> present name. Both are accepted; resolved configs have the former, for older versions."""

Rheology = Member("rheology", usual="newtonian")
Scheme = Member("schemes", usual="auto", untyped="wcsph")


def _text(pattern: str, allowed: str) -> Any:
    """Return the type of a text that matches ``pattern`` from end to end; ``allowed``: its description in a message."""

    def check(value: str) -> str:
        if not re.fullmatch(pattern, value):
            raise refusal(f"must be {allowed}")
        return value

    return Annotated[str, AfterValidator(check)]


NOUNS = {"circle": ("cylinder", "cylinders"), "ellipse": ("ellipse", "ellipses"), "polygon": ("polygon", "polygons")}
NOUNS |= {"curve": ("body", "bodies")}
COUNTS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
"""Words for types and numbers of bodies in titles."""

FolderName = _text(
    r"(?!\.)[\w.-]{1,64}(?<!\.)",
    "a folder name: 1 to 64 letters, digits or . _ - without a dot at either end",
)
Title = _text(
    r"[^\W_](?:[^\n\r\t\v\f\x00-\x1f]{0,78}\S)?", "a line of 1 to 80 characters that begins with a letter or digit"
)
Label = _text(r"[A-Za-z0-9µ%^*/. -]{1,16}", "a unit label: 1 to 16 letters, digits or . % ^ * / -")


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
    rheology: Annotated[Model, Rheology] = Field(default_factory=Rheology.default)

    @property
    def polymer(self) -> Any:
        """The rheology where it has a polymer, else None."""
        rheology: Any = self.rheology
        return rheology if rheology.carries_stress else None


class Discretisation(Model):
    """Particle spacing [length] or number across (50), smoothing kernel, smoothing length over spacing."""

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


class Config(Model):
    """A whole run, checked; every key as in the YAML file, every default filled in.

    This is the part that all scenes share. The class ``Config`` of a scene's file adds its sections, and the
    properties on which resolution, lattice and movie depend. Validation by this class returns an object of the scene's.
    """

    model_config = ConfigDict(defer_build=True)  # half of the time of reading a config, for the model of all scenes

    name: FolderName
    title: Title | None = None
    scene: member_name("scenes")
    units: Units = Units()
    fluid: Fluid
    discretisation: Discretisation = Discretisation.model_validate({})
    scheme: Annotated[Model, Scheme] = Field(default_factory=Scheme.default)
    reference: Reference | None = None
    time: Time
    output: Output = Output()
    runtime: Runtime = Runtime()

    unset_keys: ClassVar[tuple[str, ...]] = ("title", "reference")
    parallel: ClassVar[bool] = False
    """Whether all flow is along x."""
    axisymmetric: ClassVar[bool] = False
    """Whether x is along an axis of symmetry and y the distance from it."""
    periodic: ClassVar[tuple[bool, bool]]
    """Whether the box is periodic in x and y."""
    across_name: ClassVar[str]
    """Description of ``across`` in messages."""
    has_exact_velocity: ClassVar[bool] = False
    """Whether the exact velocity is known at all times and places."""

    @property
    def flow(self) -> str:
        """The flow in words, for titles."""
        return registry.summary("scenes", self.scene).partition(":")[0]

    @property
    def heading(self) -> str:
        """The title of pictures: ``title``, or flow and fluid in words."""
        return self.title or f"{self.flow}, {registry.summary('rheology', self.fluid.rheology.type).partition(':')[0]}"

    @model_validator(mode="wrap")
    @classmethod
    def _take_sections_of_scene(cls, data: Any, handler: Callable[[Any], "Config"]) -> "Config":
        if isinstance(data, dict):
            data = {FORMER_KEYS.get(key, key): value for key, value in data.items()}
        if cls is not Config or not isinstance(data, dict):
            return handler(data)
        own = model_of(data)
        if own is Config:  # there is no such scene: its sections are not checked
            return handler({key: value for key, value in data.items() if key in cls.model_fields})
        return own.model_validate(data)

    @model_validator(mode="after")
    def _check_between_keys(self) -> "Config":
        sections = {key: value for key, value in vars(self).items() if hasattr(value, "for_spacing")}
        complete = {key: section.for_spacing(self.spacing) for key, section in sections.items()}
        whole = self.model_copy(update=complete) if complete else self
        checks.raise_problems(whole)
        return whole

    @classmethod
    def keys(cls) -> list[str]:
        """Return all keys in the order of a resolved config."""
        return sorted(cls.model_fields, key=lambda key: ORDER.index(key if key in ORDER else "geometry"))

    @property
    def kinematic_viscosity(self) -> float:
        """Kinematic viscosity [length^2/time], whichever of the two was given."""
        fluid: Any = self.fluid
        return fluid.kinematic_viscosity or fluid.dynamic_viscosity / fluid.density

    @property
    def dynamic_viscosity(self) -> float:
        """Dynamic viscosity [mass/(length time)], whichever of the two was given."""
        fluid: Any = self.fluid
        return fluid.dynamic_viscosity or fluid.kinematic_viscosity * fluid.density

    @property
    def across(self) -> float:
        """The length that ``discretisation.particles_across`` counts [length]: the height of the box."""
        return self.extent[1]

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the box [length]."""
        raise NotImplementedError

    @property
    def area(self) -> float:
        """Area that the fluid fills [length^2]."""
        width, height = self.extent
        return width * height

    @property
    def aspect(self) -> float:
        """The side of the box over ``across`` that ``across`` may not divide; 1 where it divides both."""
        return 1.0

    @property
    def particles_across(self) -> int:
        """Particles in the length ``across``."""
        given: Any = self.discretisation
        return given.particles_across or max(1, round(self.across / given.spacing))

    @property
    def spacing(self) -> float:
        """Particle spacing [length], exactly across / particles_across."""
        return self.across / self.particles_across

    @property
    def singular(self) -> bool:
        """Whether the flow is singular somewhere: then a step has no finite error, and no tolerance sets it."""
        return False

    @property
    def has_free_bodies(self) -> bool:
        """Whether there is a freely moving body."""
        bodies = getattr(self, "bodies", ())
        return any(body.motion == "free" for body in (bodies if isinstance(bodies, tuple) else (bodies,)))

    @property
    def named_bodies(self) -> str:
        """The bodies in words that begin a title, such as Two free cylinders; empty without bodies."""
        bodies = getattr(self, "bodies", ())
        if not isinstance(bodies, tuple):
            return "Suspension"
        nouns = {NOUNS.get(body.type, NOUNS["curve"]) for body in bodies}
        noun, plural = nouns.pop() if len(nouns) == 1 else NOUNS["curve"]
        kind, count = "free " * self.has_free_bodies, len(bodies)
        text = f"{kind}{noun}" if count == 1 else f"{COUNTS.get(count, count)} {kind}{plural}"
        return text[0].upper() + text[1:] if bodies else ""

    @property
    def has_open_ends(self) -> bool:
        """Whether fluid flows in and out."""
        return getattr(self, "ends", None) is not None

    @property
    def columns(self) -> int:
        """Particles along x."""
        return round(self.extent[0] / self.spacing)

    @property
    def rows(self) -> int:
        """Particles along y."""
        return round(self.extent[1] / self.spacing)

    @property
    def support(self) -> float:
        """Radius of the kernel support in particle spacings."""
        radius = registry.constant("kernels", self.discretisation.kernel, "SUPPORT")
        return radius * self.discretisation.smoothing_ratio

    @property
    def start_time(self) -> float:
        """Time at which the run's clock starts [time]."""
        return 0.0

    @property
    def members(self) -> dict[str, Model]:
        """Parameters of the chosen members of families, except the scheme, by family."""
        return {"rheology": self.fluid.rheology}

    @property
    def time_series(self) -> dict[str, Any]:
        """Settings of the time series of the scene, as plain values."""
        return {}

    def problems(self) -> Iterator[Problem]:
        """Yield the conditions of the scene that the config breaks."""
        return iter(())

    def incommensurate(self) -> Iterator[Problem]:
        """Yield the problem of a lattice whose spacing divides ``across`` but that does not fill the box."""
        return iter(())

    def resolved(self) -> dict[str, Any]:
        """Return the config as plain data with every default filled in; loading it returns an equal config."""
        data, former = self.model_dump(), {new: old for old, new in FORMER_KEYS.items()}
        return {former.get(key, key): data[key] for key in self.keys() if key in data}

    def resolved_yaml(self) -> str:
        """Return ``resolved()`` as YAML."""
        return yaml_text.dump(self.resolved())


ORDER = (
    "name", "title", "scene", "units", "fluid", "geometry", "walls", "ends", "drive", "initial", "reference",
    "discretisation", "scheme", "time", "probes", "output", "runtime",
)  # fmt: skip
"""Order of the keys in a resolved config; other keys come with ``geometry``."""


def model_of(data: Any) -> type[Config]:
    """Return the model of the scene that the raw ``data`` of a config names; ``Config`` for an unknown scene."""
    name = data.get("scene") if isinstance(data, dict) else None
    return registry.load("scenes", name).Config if name in registry.names("scenes") else Config
