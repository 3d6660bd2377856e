"""Conditions between keys that hold in every scene: times inside the run, a legible movie, a size that fits.

A lattice of particles must fill the box of a scene, and have enough columns and rows for the cells of the neighbour
search; the fields of the particles must fit into memory.
"""

import math
import os
from collections.abc import Iterator
from functools import reduce
from typing import Any

from tisph import registry
from tisph.config.base import Problem, refusals
from tisph.config.fields import nearest
from tisph.size_class import size_class

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

LEAST_PARTICLES_ACROSS = 6

DIVISION_TOLERANCE = 1e-9
"""Relative tolerance of whole numbers: far above the rounding of decimal numbers, far below any effect on a flow."""

SKIN = 0.3
"""Width of a neighbour list's skin for the smallest possible box, in particle spacings."""

LEAST_IN_PERIOD = 18
"""Particles in a period of a box with bodies: near walls the radius of operators is up to 5.8 spacings, and the
neighbour search needs three cells."""

SMALLEST_F32 = 1e-6
"""Spacing whose fourth power, in the determinant of the moments, is well inside the range of single precision."""


def problems(config: Any) -> Iterator[Problem]:
    """Yield every condition between keys that the config breaks, the conditions of its scene among them."""
    yield from config.problems()
    yield from _times(config)
    yield from _video(config)
    for family, parameters in config.members.items():
        yield from _problems_of_member(family, parameters.type, config)
    yield from _scheme(config)
    # a size that fits, then whole numbers of particles, then the precision
    yield from list(_size(config)) or list(_across(config)) or list(config.incommensurate()) or _precision(config)


def raise_problems(config: Any) -> None:
    """Raise one ValidationError with all problems of the validated config, if there are any."""
    found = []
    for key, text, *others in problems(config):
        place, *other_places = (
            tuple(int(part) if part.isdigit() else part for part in each.split(".")) for each in (key, *others)
        )
        value = reduce(lambda data, part: data[part] if isinstance(part, int) else getattr(data, part), place, config)
        found.append((place, text, value, *other_places))
    if found:
        raise refusals(found)


def _times(config: Any) -> Iterator[Problem]:
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


def _video(config: Any) -> Iterator[Problem]:
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
    if video.limits != "auto" and not video.limits[0] < video.limits[1]:
        yield "output.video.limits", "must be auto, or the lower limit and then the higher one"


def colours(config: Any) -> list[str]:
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
    return [*names, *(["error"] if config.has_exact_velocity else []), "dye"]


def _problems_of_member(family: str, name: str, config: Any) -> Iterator[Problem]:
    """Yield the problems of a member of the registry, which may have a function ``problems(config)``."""
    find = getattr(registry.load(family, name), "problems", None)
    return find(config) if find else iter(())


def _scheme(config: Any) -> Iterator[Problem]:
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


def estimated_bytes(particles: float, config: Any, implicit: bool) -> float:
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


def resolution_key(config: Any) -> str:
    """Return the dotted key that sets the particle spacing of the config."""
    return "discretisation." + ("particles_across" if config.discretisation.spacing is None else "spacing")


def across(config: Any) -> float:
    """Return the number of particles in the length ``config.across``, which may not be whole."""
    given = config.discretisation
    return given.particles_across or config.across / given.spacing


def least_across(config: Any) -> int:
    """Return the least number of particles across."""
    if config.periodic[1]:
        return least_in_period(config)
    return max(LEAST_PARTICLES_ACROSS, math.ceil(config.support + SKIN))


def least_in_period(config: Any) -> int:
    """Return the least number of particles in a period: with three cells no pair is also listed as a periodic copy."""
    return math.ceil(3 * (config.support + SKIN))


def is_whole(number: float) -> bool:
    """Return whether ``number`` is a whole number, within round-off, and not 0."""
    return round(number) >= 1 and abs(number - round(number)) <= DIVISION_TOLERANCE * number


def nearest_valid(config: Any) -> str:
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


def incommensurate_columns(config: Any) -> list[Problem]:
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
