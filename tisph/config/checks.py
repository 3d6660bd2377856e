"""Conditions between keys: a spacing that divides gap and length, samples inside the run, a size to fit."""

import math
from collections.abc import Iterator
from typing import Any

from tisph import families
from tisph.config import memory
from tisph.config.base import refusals

LEAST_PARTICLES_ACROSS = 6
DIVISION_TOLERANCE = 1e-9
"""Relative; far above the rounding of decimal numbers, far below anything that a flow would notice."""

SKIN = 0.3
"""Room for a neighbour list's skin in units of the spacing, where the least length is worked out."""

SMALLEST_F32 = 1e-6
"""Spacing whose fourth power, in the determinant of the moments, is well inside the range of single precision."""

Problem = tuple[str, str] | tuple[str, str, str]
"""Dotted key and what is wrong with its value; a second key where it is as much the other one's fault."""


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
    """Every condition between keys that the config breaks."""
    yield from _motion(config)
    yield from _start(config)
    yield from _times(config)
    yield from _video(config)
    yield from _members(config)
    yield from _tracers(config)
    too_large = list(_size(config))
    yield from too_large or _lattice(config)


def _value(config: Any, location: tuple[str | int, ...]) -> Any:
    for part in location:
        config = config[part] if isinstance(part, int) else getattr(config, part)
    return config


def _motion(config: Any) -> Iterator[Problem]:
    walls = (config.walls.bottom, config.walls.top)
    if config.drive.acceleration or any(wall.amplitude for wall in walls):
        return
    velocities = {velocity for wall in walls for velocity in (wall.velocity, wall.velocity_before)} - {None}
    settled = config.initial.state == "developed" or any(wall.velocity_before is not None for wall in walls)
    if len(velocities | (set() if settled else {0.0})) == 1:
        text = "nothing moves: give walls.bottom or walls.top a velocity other than 0, or drive.acceleration"
        together = f"{text}; walls and liquid move together at {walls[0].velocity:g}"
        yield "walls", together if walls[0].velocity else text


def _start(config: Any) -> Iterator[Problem]:
    state = config.initial.state
    if state == "exact" and config.initial.time == 0:
        yield "initial.time", "must be greater than 0 with state exact (from rest: state rest)"
    if state != "exact" and config.initial.time != 0:
        yield "initial.time", f"is allowed only with state exact, not with state {state}"
    for side in ("bottom", "top"):
        if state == "rest" and getattr(config.walls, side).velocity_before is not None:
            text = "is not allowed with initial.state rest, in which nothing moves before t = 0"
            yield f"walls.{side}.velocity_before", f"{text}: take state developed, or exact with a time"


def _times(config: Any) -> Iterator[Problem]:
    start, end, samples = config.start_time, config.time.end, config.time.samples
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


def _tracers(config: Any) -> Iterator[Problem]:
    if config.tracers.x != "centre" and config.tracers.x > config.geometry.length:
        yield "tracers.x", f"must be inside the channel: centre, or 0 to {config.geometry.length:g}"


def _video(config: Any) -> Iterator[Problem]:
    video, rheology = config.output.video, config.fluid.rheology
    if video and not 0.5 <= video.width / video.height <= 5:
        text = f"{video.width} x {video.height} leaves no room for words that can be read"
        yield "output.video", f"{text}: width must be 0.5 to 5 times the height"
    if video and video.color_by == "shear_stress" and not rheology.carries_stress:
        text = f"needs a rheology with a stress of its own, such as oldroyd_b; {rheology.type} has none"
        yield "output.video.color_by", f"{text}: take speed"


def _members(config: Any) -> Iterator[Problem]:
    """What the chosen members of families say: each may have a function ``problems(config)``."""
    chosen = {"walls": config.walls.treatment, "rheology": config.fluid.rheology, "schemes": config.scheme}
    for family, parameters in chosen.items():
        find = getattr(families.load(family, parameters.type), "problems", None)
        yield from find(config) if find else ()


def _resolution_key(config: Any) -> str:
    return "discretisation." + ("particles_across" if config.discretisation.spacing is None else "spacing")


def _across(config: Any) -> float:
    """Particles across the gap as given, perhaps not a whole number."""
    given = config.discretisation
    return given.particles_across or config.geometry.gap / given.spacing


def _size(config: Any) -> Iterator[Problem]:
    across = _across(config)
    particles = across * (across * config.geometry.length / config.geometry.gap)
    stress = config.fluid.rheology.carries_stress
    needed = memory.estimated_bytes(particles, config, config.scheme.type != "wcsph" and not stress)
    available = memory.physical_bytes()
    text = f"makes {particles:.3g} particles, which would need about {memory.format_bytes(needed)} of memory"
    if particles > memory.MOST_PARTICLES:
        yield _resolution_key(config), f"{text}; at most {memory.MOST_PARTICLES} particles are allowed"
    elif available and needed > available:
        yield _resolution_key(config), f"{text}; this machine has {memory.format_bytes(available)}"


def _lattice(config: Any) -> Iterator[Problem]:
    across, gap, length = _across(config), config.geometry.gap, config.geometry.length
    columns = across * length / gap
    least_rows = max(LEAST_PARTICLES_ACROSS, math.ceil(config.support + SKIN))
    key = _resolution_key(config)
    if across < least_rows * (1 - DIVISION_TOLERANCE):
        limit = f" (spacing at most {gap / least_rows:.6g})" if config.discretisation.spacing else ""
        yield key, f"at least {least_rows} particles must fit across the gap{limit}"
    elif not _is_whole(across):
        yield key, f"must divide the gap {gap:g}; {_nearest_valid(config, least_rows)}"
    elif not _is_whole(columns):
        wholes = sorted({max(whole, _least_columns(config)) for whole in (math.floor(columns), math.ceil(columns))})
        lengths = " or ".join(f"{whole * gap / across:.12g}" for whole in wholes)
        text = f"{round(across)} particles across make {columns:.6g} columns in the length {length:g}, no whole number"
        rows = _nearest_valid(config, least_rows)
        yield key, f"{text}; nearest valid geometry.length: {lengths}{rows and f'; {rows}'}", "geometry.length"
    else:
        yield from _least_length(config, round(columns))
        yield from _precision(config)


def _precision(config: Any) -> Iterator[Problem]:
    size = config.spacing
    if config.discretisation.precision == "f32" and not SMALLEST_F32 <= size <= 1 / SMALLEST_F32:
        text = f"needs a particle spacing from {SMALLEST_F32:g} to {1 / SMALLEST_F32:g}, which is {size:.3g}"
        yield "discretisation.precision", f"{text}: take other units of length, or f64"


def _least_columns(config: Any) -> int:
    """With fewer than three cells along x a particle would meet a neighbour and its periodic copy."""
    return math.ceil(3 * (config.support + SKIN))


def _least_length(config: Any, columns: int) -> Iterator[Problem]:
    least = _least_columns(config)
    if columns < least:
        text = f"must be at least {least * config.spacing:.6g}, {least} particle spacings"
        yield "geometry.length", f"{text}: the periodic neighbour search needs three cells along x"


def _is_whole(number: float) -> bool:
    return round(number) >= 1 and abs(number - round(number)) <= DIVISION_TOLERANCE * number


def _nearest_valid(config: Any, least_rows: int) -> str:
    """The resolutions around the given one, up to a factor of 2, that divide gap and length, in the words of a message.

    Where there is none, those that divide the gap, which must not be whole then.
    """
    across, gap = _across(config), config.geometry.gap
    aspect = config.geometry.length / gap
    start = math.floor(across)
    below = range(start, max(least_rows, math.ceil(across / 2)) - 1, -1)
    above = range(max(least_rows, start + 1), math.floor(2 * across) + 1)
    found = [next((rows for rows in side if _is_whole(rows * aspect)), None) for side in (below, above)]
    rest = ""
    if not any(found) and not _is_whole(across):
        found, rest = [max(start, least_rows), max(start, least_rows) + 1], ", and geometry.length to suit"
    by_spacing = config.discretisation.spacing is not None
    choices = [f"{gap / rows:.12g}" if by_spacing else str(rows) for rows in found if rows]
    name = "spacing" if by_spacing else "particles_across"
    return f"nearest valid {name}: {' or '.join(choices)}{rest}" if choices else ""
