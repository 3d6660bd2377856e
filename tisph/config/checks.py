"""Conditions between keys that hold in every scene: times inside the run, a movie that can be read, a size that fits.

A lattice of particles must fill the box of a scene, and be enough for the cells of its neighbour search; the fields of
the particles must fit into memory.
"""

import math
import os
from collections.abc import Iterator
from typing import Any

from tisph import registry
from tisph.config.base import Problem, refusals
from tisph.config.fields import nearest
from tisph.size_class import size_class

REALS = {False: 25, True: 280}
"""Numbers with fractions that a particle has in fields, by whether the scheme is implicit: the explicit one keeps two
copies of 11 and where the lists were made, the implicit one three rows of operators with 52 entries and vectors."""

WALLED_REALS = 200
"""What a particle has more than that in two-dimensional flow between walls: operators reach farther, and there are
points on the walls, ``WALL_POINTS`` times the root of the number of particles as around an annulus of ratio 1/2."""

WALL_POINTS = 6.0

STRESS_REALS = {False: 12, True: 110}
"""A particle's polymer stress: of the explicit scheme three numbers in two copies, at full and at half steps; of the
implicit one three, and their slopes, at the ends of three steps, and what solving for them takes."""

INTEGER_BYTES = {False: 24, True: 240}
"""A particle's places in lists and cells; those of its neighbours too in the implicit scheme."""

NEIGHBOUR_BYTES = 4 * 1.6
"""Bytes of the explicit scheme's lists for each particle within reach: an index, and room for disorder."""

REACH = 0.15
"""What lists reach beyond the kernel support, in particle spacings."""

HOST_BYTES = 165
"""What a particle takes outside the fields while a run is set up or output is written."""

MOST_PARTICLES = 20_000_000


def estimated_bytes(particles: float, config: Any, implicit: bool) -> float:
    """Estimated growth of a run's memory with its particles in bytes; ``implicit``: with which scheme.

    ``tisph bench throughput`` compares it with what a process takes.
    """
    reals = REALS[implicit] + STRESS_REALS[implicit] * config.fluid.rheology.carries_stress
    if implicit and not config.parallel and (getattr(config, "bodies", ()) or not all(config.periodic)):
        reals += WALLED_REALS
        particles += WALL_POINTS * math.sqrt(particles)
    fields = reals * (8 if config.discretisation.precision == "f64" else 4) + INTEGER_BYTES[implicit]
    lists = 0.0 if implicit else NEIGHBOUR_BYTES * math.pi * (config.support + REACH) ** 2
    return size_class(particles) * (fields + lists) + particles * HOST_BYTES


def physical_bytes() -> int | None:
    """Memory of this machine in bytes, None where the system does not tell (Windows)."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def format_bytes(count: float) -> str:
    """A byte count as text, such as ``3.1 GB``."""
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} PB"


LEAST_PARTICLES_ACROSS = 6
DIVISION_TOLERANCE = 1e-9
"""Relative; far above the rounding of decimal numbers, far below anything that a flow would notice."""

SKIN = 0.3
"""Room for a neighbour list's skin in units of the spacing, where the least length is worked out."""

LEAST_IN_PERIOD = 18
"""Particles in a period of a box with bodies: near walls operators reach up to 5.8 spacings, and the neighbour search
needs three cells."""

SMALLEST_F32 = 1e-6
"""Spacing whose fourth power, in the determinant of the moments, is well inside the range of single precision."""


def resolution_key(config: Any) -> str:
    """The dotted key by which the config gives its spacing."""
    return "discretisation." + ("particles_across" if config.discretisation.spacing is None else "spacing")


def across(config: Any) -> float:
    """Particles in the length ``config.across`` as given, perhaps not a whole number."""
    given = config.discretisation
    return given.particles_across or config.across / given.spacing


def least_across(config: Any) -> int:
    """The least number of particles across."""
    if config.periodic[1]:
        return least_in_period(config)
    return max(LEAST_PARTICLES_ACROSS, math.ceil(config.support + SKIN))


def least_in_period(config: Any) -> int:
    """With fewer than three cells in a period a particle would meet a neighbour and its periodic copy."""
    return math.ceil(3 * (config.support + SKIN))


def is_whole(number: float) -> bool:
    """Whether ``number`` is a whole one, but for rounding, and not 0."""
    return round(number) >= 1 and abs(number - round(number)) <= DIVISION_TOLERANCE * number


def nearest_valid(config: Any) -> str:
    """The resolutions around the given one, up to a factor of 2, that fill the box, in the words of a message.

    Where there is none, those that divide ``config.across``, which must not be whole then.
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


def incommensurate_columns(config: Any) -> list[Problem]:
    """What is wrong with a ``geometry.length`` in which there is no whole number of particles."""
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


def _across(config: Any) -> Iterator[Problem]:
    given, least, key = across(config), least_across(config), resolution_key(config)
    if given < least * (1 - DIVISION_TOLERANCE):
        limit = f" (spacing at most {config.across / least:.6g})" if config.discretisation.spacing else ""
        yield key, f"at least {least} particles must fit across {config.across_name}{limit}"
    elif not is_whole(given):
        yield key, f"must divide {config.across_name} {config.across:g}; {nearest_valid(config)}"


def _precision(config: Any) -> Iterator[Problem]:
    size = config.spacing
    if config.discretisation.precision == "f32" and not SMALLEST_F32 <= size <= 1 / SMALLEST_F32:
        text = f"needs a particle spacing from {SMALLEST_F32:g} to {1 / SMALLEST_F32:g}, which is {size:.3g}"
        yield "discretisation.precision", f"{text}: take other units of length, or f64"


def raise_problems(config: Any) -> None:
    """Raise one ValidationError with all problems of the validated config, if there are any."""
    found = []
    for key, text, *others in problems(config):
        place, *blamed = map(_place, (key, *others))
        found.append((place, text, _value(config, place), *blamed))
    if found:
        raise refusals(found)


def _place(key: str) -> tuple[str | int, ...]:
    return tuple(int(part) if part.isdigit() else part for part in key.split("."))


def problems(config: Any) -> Iterator[Problem]:
    """Every condition between keys that the config breaks, those of its scene among them."""
    yield from config.problems()
    yield from _times(config)
    yield from _video(config)
    yield from _members(config)
    yield from _scheme(config)
    # a size that fits, then whole numbers of particles, then the precision
    yield from list(_size(config)) or list(_across(config)) or list(config.incommensurate()) or _precision(config)


def _value(config: Any, location: tuple[str | int, ...]) -> Any:
    for part in location:
        config = config[part] if isinstance(part, int) else getattr(config, part)
    return config


def _times(config: Any) -> Iterator[Problem]:
    start, end, samples = config.start_time, config.time.end, config.time.samples
    if config.singular and config.time.tolerance != "auto":
        text = "is not allowed where walls meet that slide past each other: what passes there has no error to speak of"
        yield "time.tolerance", f"{text}; give time.cfl, or scheme.accuracy"
    if not end > start:
        yield "time.end", f"must be after the start of the run at {start:g}"
        return
    for index, sample in enumerate(samples):
        if not start <= sample <= end:
            yield f"time.samples.{index}", f"must be inside the run, {start:g} to {end:g}"
        elif index and not sample > samples[index - 1]:
            yield (
                f"time.samples.{index}",
                f"must be greater than the sample before it, {samples[index - 1]:g}",
            )


def _video(config: Any) -> Iterator[Problem]:
    video = config.output.video
    if video and not 0.5 <= video.width / video.height <= 5:
        text = f"{video.width} x {video.height} leaves no room for words that can be read"
        yield "output.video", f"{text}: width must be 0.5 to 5 times the height"
    names = colours(config)
    if video and video.color_by not in names:
        *others, last = map(repr, names)
        yield "output.video.color_by", f"must be {', '.join(others)} or {last}{nearest(video.color_by, names)}"
    if video and video.limits != "auto" and not video.limits[0] < video.limits[1]:
        yield "output.video.limits", "must be auto, or the lower limit and then the higher one"


def colours(config: Any) -> list[str]:
    """What a movie of the validated ``config`` may be coloured by."""
    rheology, names = config.fluid.rheology, ["speed", "u"]
    if not config.parallel:
        names += ["v", "vorticity", "pressure"]
    if config.axisymmetric:
        names += ["swirl", "stream_function"]
    if rheology.carries_stress:
        names += ["shear_stress", "normal_stress_difference"]
        names += ["conformation_trace"] if getattr(rheology, "linear_stress", False) else []
    elif rheology.type == "newtonian" and not config.parallel and not config.axisymmetric:
        names.append("shear_stress")
    return [*names, *(["error"] if config.has_exact_velocity else []), "dye"]


def _members(config: Any) -> Iterator[Problem]:
    """What the chosen members of the registry say: each may have a function ``problems(config)``."""
    for family, parameters in config.members.items():
        yield from _said_by(family, parameters.type, config)


def _said_by(family: str, name: str, config: Any) -> Iterator[Problem]:
    find = getattr(registry.load(family, name), "problems", None)
    return find(config) if find else iter(())


def _scheme(config: Any) -> Iterator[Problem]:
    """What the scheme says, where it can have a box that is periodic as that of the scene is.

    Which boxes a scheme can have is its literal ``PERIODIC``, pairs for x and y as in ``Config.periodic``.
    """
    chosen = config.scheme.type
    if config.periodic in _boxes(chosen):
        yield from _said_by("schemes", chosen, config)
        return
    able = [name for name in registry.names("schemes") if config.periodic in _boxes(name)]
    if able:
        yield "scheme.type", f"has no box as that of {config.scene}; take {' or '.join(able)}"
    else:
        yield "scene", "no scheme can run it yet: they all need walls"


def _boxes(scheme: str) -> list[tuple[bool, bool]]:
    return registry.constant("schemes", scheme, "PERIODIC")


def _size(config: Any) -> Iterator[Problem]:
    rows = across(config)
    particles = rows * (rows * (config.area / config.across / config.across))
    needed = estimated_bytes(particles, config, config.scheme.type != "wcsph")
    available = physical_bytes()
    key = resolution_key(config)
    text = f"makes {particles:.3g} particles, which would need about {format_bytes(needed)} of memory"
    if particles > MOST_PARTICLES:
        yield key, f"{text}; at most {MOST_PARTICLES} particles are allowed"
    elif available and needed > available:
        yield key, f"{text}; this machine has {format_bytes(available)}"
