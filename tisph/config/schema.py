"""Keys of every config, and the conditions between them that hold in every scene.

Units are any self-consistent system. Sections that all scenes share are in ``sections.py``, those of a scene in its
file in ``tisph/scenes``; parameters of wall treatments, rheologies and schemes are in the files of the members
themselves. Conditions: times inside the run, a legible movie, and a size that fits. A lattice of particles must fill
the box of a scene, and have enough columns and rows for the cells of the neighbour search; the fields of the particles
must fit into memory.
"""

import math
import os
from collections.abc import Callable, Iterator
from functools import reduce
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from tisph import registry
from tisph.config import yaml_text
from tisph.config.base import Model, Problem, refusal, refusals
from tisph.config.fields import Member, member_name, nearest
from tisph.config.goals import goals
from tisph.config.heat import Scalar, Temperature
from tisph.config.sections import (
    LEAST_PARTICLES_ACROSS,
    Discretisation,
    Fluid,
    Output,
    Reference,
    Runtime,
    Time,
    Units,
    text_type,
)
from tisph.size_class import size_class

FORMER_KEYS = {"tracers": "probes"}
"""Former name of a section -> present name. Both are accepted; resolved configs have the former, for older versions."""

Scheme = Member("schemes", usual="auto", untyped="wcsph")

NOUNS = {"circle": ("cylinder", "cylinders"), "ellipse": ("ellipse", "ellipses"), "polygon": ("polygon", "polygons")}
NOUNS |= {"curve": ("body", "bodies")}
MOST_SCALARS = 20

COUNTS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
"""Words for types and numbers of bodies in titles."""

FolderName = text_type(
    r"(?!\.)[\w.-]{1,64}(?<!\.)",
    "a folder name: 1 to 64 letters, digits or . _ - without a dot at either end",
)
Title = text_type(
    r"[^\W_](?:[^\n\r\t\v\f\x00-\x1f]{0,78}\S)?", "a line of 1 to 80 characters that begins with a letter or digit"
)


def _checked_goals(given: dict[str, Any]) -> dict[str, Any]:
    try:
        goals(given)
    except ValueError as error:
        raise refusal(str(error)) from None
    return given


Goals = Annotated[dict[str, Any], AfterValidator(_checked_goals)]
"""Name of a number -> largest error, as ``tisph/config/goals.py`` reads it."""


class Config(Model):
    """A whole run, checked; every key as in the YAML file, every default filled in.

    This is the part that all scenes share. The class ``Config`` of a scene's file adds its sections, and the
    properties on which resolution, lattice and movie depend. Validation by this class returns an object of the scene's.
    """

    if TYPE_CHECKING:  # sections of a scene

        def __getattr__(self, name: str) -> Any: ...

    model_config = ConfigDict(defer_build=True)  # half of the time of reading a config, for the model of all scenes

    name: FolderName
    title: Title | None = None
    scene: member_name("scenes")
    units: Units = Units()
    fluid: Fluid
    discretisation: Discretisation = Discretisation.model_validate({})
    scheme: Annotated[Any, Scheme] = Field(default_factory=Scheme.default)
    temperature: Temperature | None = None
    scalars: Annotated[tuple[Scalar, ...], Field(strict=False, max_length=MOST_SCALARS)] = ()
    reference: Reference | None = None
    time: Time
    accuracy: Goals | None = None
    output: Output = Output()
    runtime: Runtime = Runtime()

    unset_keys: ClassVar[tuple[str, ...]] = ("title", "temperature", "scalars", "reference", "accuracy")
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
        raise_problems(whole)
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

    def at_walls(self, name: str) -> dict[str, Any]:
        """Return the values of the key ``name`` of walls and bodies that have one, by the dotted keys of these."""
        walls, bodies = getattr(self, "walls", None), getattr(self, "bodies", ())
        parts = {f"walls.{each}": getattr(walls, each) for each in type(walls).model_fields} if walls else {}
        listed = isinstance(bodies, tuple)
        parts |= {f"bodies.{index}": body for index, body in enumerate(bodies)} if listed else {"bodies": bodies}
        parts["sphere"] = getattr(self, "sphere", None)
        found = {key: getattr(part, name, None) for key, part in parts.items()}
        return {key: value for key, value in found.items() if value is not None}

    @property
    def spacings(self) -> dict[str, float]:
        """The spacings [length] of walls, bodies and places with one of their own, by dotted key."""
        found = {f"{key}.spacing": spacing for key, spacing in self.at_walls("spacing").items()}
        places = enumerate(self.discretisation.places)
        return found | {f"discretisation.refine.{index}.spacing": place.spacing for index, place in places}

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
    def isothermal(self) -> bool:
        """Whether the temperature has no effect on the flow, or there is none."""
        return not (self.temperature and (self.temperature.viscosity or self.temperature.expansion))

    @property
    def flows_through(self) -> bool:
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
    def members(self) -> dict[str, Any]:
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
    "name", "title", "scene", "units", "fluid", "geometry", "walls", "ends", "drive", "initial", "temperature",
    "scalars", "reference", "discretisation", "scheme", "time", "accuracy", "probes", "output", "runtime",
)  # fmt: skip
"""Order of the keys in a resolved config; other keys come with ``geometry``."""


def model_of(data: Any) -> type[Config]:
    """Return the model of the scene that the raw ``data`` of a config names; ``Config`` for an unknown scene."""
    name = data.get("scene") if isinstance(data, dict) else None
    return registry.load("scenes", name).Config if name in registry.names("scenes") else Config


REALS = {False: 25, True: 280}
"""Real numbers of a particle in fields, by whether the scheme is implicit. Explicit: two buffers of 11, and positions
when the lists were built. Implicit: three operators of 52 entries each, and vectors."""

WALLED_REALS = 200
"""Further real numbers of a particle in two-dimensional flow between walls, where supports are larger. There are also
points on the walls: ``WALL_POINTS`` times the root of the number of particles, as around an annulus of ratio 1/2."""

WALL_POINTS = 6.0

STRESS_REALS = {False: 12, True: 110}
"""Real numbers of a particle's polymer stress. Explicit: three in two buffers, at full and at half steps. Implicit:
three, and their slopes, at the ends of three steps, and fields of the solver."""

INTEGER_BYTES = {False: 24, True: 240}
"""Bytes of a particle's indices in lists and cells, with the implicit scheme also of its neighbours."""

NEIGHBOUR_BYTES = 4 * 1.6
"""Bytes in the explicit scheme's lists for each neighbour: an index, and room for disorder."""

REACH = 0.15
"""Radius of the explicit scheme's lists beyond the kernel support, in particle spacings."""

HOST_BYTES = 165
"""Bytes of a particle outside the fields while a run is set up or output is written."""

MOST_PARTICLES = 20_000_000

DIVISION_TOLERANCE = 1e-9
"""Relative tolerance of whole numbers: far above the rounding of decimal numbers, far below any effect on a flow."""

SKIN = 0.3
"""Width of a neighbour list's skin for the smallest possible box, in particle spacings."""

LEAST_IN_PERIOD = 18
"""Particles in a period of a box with bodies: near walls the radius of operators is up to 5.8 spacings, and the
neighbour search needs three cells."""

SMALLEST_F32 = 1e-6
"""Spacing whose fourth power, in the determinant of the moments, is well inside the range of single precision."""


def problems(config: Config) -> Iterator[Problem]:
    """Yield every condition between keys that the config breaks, the conditions of its scene among them."""
    yield from config.problems()
    yield from _times(config)
    yield from _video(config)
    for family, parameters in config.members.items():
        yield from _problems_of_member(family, parameters.type, config)
    yield from _scheme(config)
    # a size that fits, then whole numbers of particles, then the precision
    yield from list(_size(config)) or list(_across(config)) or list(config.incommensurate()) or _precision(config)


def _item(data: Any, part: Any) -> Any:
    """Return the value of a key of a model or map, or an item of a list."""
    return data[part] if isinstance(data, tuple | dict) else getattr(data, part)


def raise_problems(config: Config) -> None:
    """Raise one ValidationError with all problems of the validated config, if there are any."""
    found: list[tuple[Any, ...]] = []
    whole: Any = config
    for key, text, *others in problems(config):
        place, *other_places = (
            tuple(int(part) if part.isdigit() else part for part in each.split(".")) for each in (key, *others)
        )
        value = reduce(_item, place, whole)
        found.append((place, text, value, *other_places))
    if found:
        raise refusals(found)


def _times(config: Config) -> Iterator[Problem]:
    start, end, samples = config.start_time, config.time.end, config.time.samples
    if config.singular and config.time.tolerance != "auto":
        text = "is not allowed where velocities jump in a corner: the error of a step is not finite there"
        yield "time.tolerance", f"{text}; give time.cfl, or scheme.accuracy"
    if not end > start:
        yield "time.end", f"must be after the start of the run at {start:g}"
        return
    for index, sample in enumerate(samples):
        if not start <= sample <= end:
            yield f"time.samples.{index}", f"must be inside the run, {start:g} to {end:g}"
        elif index and not sample > samples[index - 1]:
            yield f"time.samples.{index}", f"must be greater than the sample before it, {samples[index - 1]:g}"


def _video(config: Config) -> Iterator[Problem]:
    video = config.output.video
    if not video:
        return
    if not 0.5 <= video.width / video.height <= 5:
        text = f"{video.width} x {video.height} leaves no room for words that can be read"
        yield "output.video", f"{text}: width must be 0.5 to 5 times the height"
    names = colours(config)
    if video.color_by not in names:
        *others, last = map(repr, names)
        yield "output.video.color_by", f"must be {', '.join(others)} or {last}{nearest(video.color_by, names)}"
    if not isinstance(video.limits, str) and not video.limits[0] < video.limits[1]:
        yield "output.video.limits", "must be auto or frame, or the lower limit and then the higher one"


def colours(config: Config) -> list[str]:
    """Return the names that ``output.video.color_by`` of the validated ``config`` may have."""
    rheology, names = config.fluid.rheology, ["speed", "u"]
    if not config.parallel:
        names += ["v", "vorticity", "pressure"]
    if config.axisymmetric:
        names += ["swirl", "stream_function"]
    names += ["shear_rate", "shear_stress", "viscosity"]
    if rheology.carries_stress:
        names += ["normal_stress_difference"]
        names += ["conformation_trace"] if getattr(rheology, "linear_stress", False) else []
    names += ["temperature"] if config.temperature else []
    names += [scalar.name for scalar in config.scalars if scalar.name != "dye"]
    return [*names, *(["error"] if config.has_exact_velocity and config.isothermal else []), "dye"]


def _problems_of_member(family: str, name: str, config: Config) -> Iterator[Problem]:
    """Yield the problems of a member of the registry, which may have a function ``problems(config)``."""
    find = getattr(registry.load(family, name), "problems", None)
    return find(config) if find else iter(())


def _scheme(config: Config) -> Iterator[Problem]:
    """Yield the problems of the scheme, or one problem where it does not support the periodic axes of the scene."""
    chosen = config.scheme.type
    if config.periodic in _boxes(chosen):
        yield from _problems_of_member("schemes", chosen, config)
        return
    able = [name for name in registry.names("schemes") if config.periodic in _boxes(name)]
    if able:
        yield "scheme.type", f"does not support the periodic axes of {config.scene}; take {' or '.join(able)}"
    else:
        yield "scene", "no scheme can run it yet: they all need walls"


def _boxes(scheme: str) -> list[tuple[bool, bool]]:
    """Return the boxes that a scheme supports, each by whether it is periodic in x and y."""
    return registry.constant("schemes", scheme, "PERIODIC")


def estimated_bytes(particles: float, config: Config, implicit: bool) -> float:
    """Return the estimated memory [bytes] of the fields of a run with this number of ``particles``.

    ``implicit``: whether its scheme is implicit.
    """
    reals = REALS[implicit] + STRESS_REALS[implicit] * config.fluid.rheology.carries_stress
    if implicit and not config.parallel and (getattr(config, "bodies", None) or not all(config.periodic)):
        reals += WALLED_REALS
        particles += WALL_POINTS * math.sqrt(particles)
    fields = reals * (8 if config.discretisation.precision == "f64" else 4) + INTEGER_BYTES[implicit]
    lists = 0.0 if implicit else NEIGHBOUR_BYTES * math.pi * (config.support + REACH) ** 2
    return size_class(particles) * (fields + lists) + particles * HOST_BYTES


def physical_bytes() -> int | None:
    """Return the memory of this machine [bytes], None where the system does not say (Windows)."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def format_bytes(count: float) -> str:
    """Return a byte count as text, such as ``3.1 GB``."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} PB"


def _size(config: Config) -> Iterator[Problem]:
    rows = across(config)
    particles = rows * (rows * (config.area / config.across / config.across))
    yield from too_many(config, particles, resolution_key(config))


def too_many(config: Config, particles: float, key: str) -> Iterator[Problem]:
    """Yield an error at ``key`` if a number of ``particles`` is too large for the program, or for this machine."""
    needed = estimated_bytes(particles, config, config.scheme.type != "wcsph")
    available = physical_bytes()
    text = f"makes {particles:.3g} particles, which would need about {format_bytes(needed)} of memory"
    if particles > MOST_PARTICLES:
        yield key, f"{text}; at most {MOST_PARTICLES} particles are allowed"
    elif available and needed > available:
        yield key, f"{text}; this machine has {format_bytes(available)}"


def resolution_key(config: Config) -> str:
    """Return the dotted key that sets the particle spacing of the config."""
    return "discretisation." + ("particles_across" if config.discretisation.spacing is None else "spacing")


def across(config: Config) -> float:
    """Return the number of particles in the length ``config.across``, which may not be whole."""
    given: Any = config.discretisation
    return given.particles_across or config.across / given.spacing


def least_across(config: Config) -> int:
    """Return the least number of particles across."""
    if config.periodic[1]:
        return least_in_period(config)
    return max(LEAST_PARTICLES_ACROSS, math.ceil(config.support + SKIN))


def least_in_period(config: Config) -> int:
    """Return the least number of particles in a period: with three cells no pair is also listed as a periodic copy."""
    return math.ceil(3 * (config.support + SKIN))


def is_whole(number: float) -> bool:
    """Return whether ``number`` is a whole number, within round-off, and not 0."""
    return round(number) >= 1 and abs(number - round(number)) <= DIVISION_TOLERANCE * number


def nearest_valid(config: Config) -> str:
    """Return the words of a message for the nearest resolutions, within a factor of 2, that fill the box.

    Where there is none, the nearest resolutions that divide ``config.across``, if the given one does not.
    """
    given, whole, least = across(config), config.across, least_across(config)
    start = math.floor(given)
    below = range(start, max(least, math.ceil(given / 2)) - 1, -1)
    above = range(max(least, start + 1), math.floor(2 * given) + 1)
    found = [next((rows for rows in side if is_whole(rows * config.aspect)), None) for side in (below, above)]
    rest = ""
    if not any(found) and not is_whole(given):
        found, rest = [max(start, least), max(start, least) + 1], ", and geometry.length to suit"
    by_spacing = config.discretisation.spacing is not None
    choices = [f"{whole / rows:.12g}" if by_spacing else str(rows) for rows in found if rows]
    name = "spacing" if by_spacing else "particles_across"
    return f"nearest valid {name}: {' or '.join(choices)}{rest}" if choices else ""


def incommensurate_columns(config: Config) -> list[Problem]:
    """Return the problem of a ``geometry.length`` that is not a whole number of particle spacings."""
    rows, whole, length = across(config), config.across, config.geometry.length
    columns, least = rows * length / whole, least_in_period(config)
    if is_whole(columns):
        return []
    wholes = sorted({max(number, least) for number in (math.floor(columns), math.ceil(columns))})
    lengths = " or ".join(f"{number * whole / rows:.12g}" for number in wholes)
    text = f"{round(rows)} particles across make {columns:.6g} columns in the length {length:g}"
    nearest = nearest_valid(config)
    text = f"{text}, no whole number; nearest valid geometry.length: {lengths}{nearest and f'; {nearest}'}"
    return [(resolution_key(config), text, "geometry.length")]


def _across(config: Config) -> Iterator[Problem]:
    given, least, key = across(config), least_across(config), resolution_key(config)
    if given < least * (1 - DIVISION_TOLERANCE):
        limit = f" (spacing at most {config.across / least:.6g})" if config.discretisation.spacing else ""
        yield key, f"at least {least} particles must fit across {config.across_name}{limit}"
    elif not is_whole(given):
        yield key, f"must divide {config.across_name} {config.across:g}; {nearest_valid(config)}"


def _precision(config: Config) -> Iterator[Problem]:
    size = config.spacing
    if config.discretisation.precision == "f32" and not SMALLEST_F32 <= size <= 1 / SMALLEST_F32:
        text = f"needs a particle spacing from {SMALLEST_F32:g} to {1 / SMALLEST_F32:g}, which is {size:.3g}"
        yield "discretisation.precision", f"{text}: take other units of length, or f64"
