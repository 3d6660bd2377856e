"""Checks of the resolution: whether a lattice of particles fills the box of a scene, and is enough for its cells."""

import math
from collections.abc import Iterator
from typing import Any

from tisph.config.base import Problem

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


def problems(config: Any) -> Iterator[Problem]:
    """What is wrong with the spacing of the validated ``config``, or with the box that it has to fill."""
    yield from list(_across(config)) or list(config.incommensurate()) or _precision(config)


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
