"""The bodies that a config puts into a cell, and what speaks against them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.bodies._clearance import LEAST_GAP, size_problems
from tisph.bodies._clearance import problems as room_problems
from tisph.config.base import Problem
from tisph.config.checks import LEAST_IN_PERIOD
from tisph.geometry.body import Body
from tisph.geometry.region import Region
from tisph.scenes._cell.walls import largest_speed
from tisph.scenes._initial import still_problem

MOMENTS = 25
"""Times at which it is looked whether bodies that move keep apart."""


def cell_problems(config: Any, bodies: Sequence[Body], walls: dict[str, Body]) -> Iterator[Problem]:
    """What is wrong with the ``config`` of a cell with these ``bodies``, and ``walls`` by what messages call them."""
    if config.scheme.type == "wcsph":
        yield "scheme.type", "wcsph cannot serve bodies yet; take auto or implicit"
    moving = any(largest_speed(body) or body.spin.largest_speed for body in (*bodies, *walls.values()))
    free = [body for body in bodies if body.free]
    pulled = any(any(body.motion.inertia.load) for body in free) or (free and config.drive.gravity)
    if not moving and not pulled and not config.drive.acceleration:
        remedy = "give an acceleration, or let a body or a wall move"
        yield from still_problem(config, "drive.acceleration", remedy)
    if config.drive.gravity and not free:
        yield "drive.gravity", "moves free bodies alone: give one the motion free, or leave it out"
    given = config.bodies
    listed = isinstance(given, tuple)
    shapes = [(f"bodies.{index}", given[index] if listed else given, body) for index, body in enumerate(bodies)]
    shapes += [(key, config.walls.around, wall) for key, wall in walls.items() if wall.shape.area]
    found = [*size_problems(shapes, config.spacing, config.across)]
    found += room_problems(bodies, walls, config.spacing, _times(config, bodies))
    yield from found if listed else dict.fromkeys(_in_common(problem, config) for problem in found)


def _in_common(problem: Problem, config: Any) -> Problem:
    """A problem of one body of a suspension by the key that all have; where some come too close, by the cause."""
    key, text, *_ = problem
    if not key.startswith("bodies."):
        return key, text
    _, number, name = key.split(".")
    if name != "centre":
        return f"bodies.{name}", text
    close = config.bodies.least_gap < LEAST_GAP * config.spacing
    return "bodies.least_gap" if close else "bodies.motion", f"body {number} {text}"


def _times(config: Any, bodies: Sequence[Body]) -> Sequence[float]:
    """Times at which bodies are looked at: the first alone where none of them goes anywhere, or where is not known."""
    if any(body.free for body in bodies) or not any(largest_speed(body) for body in bodies):
        return (0.0,)
    return np.linspace(0.0, config.time.end, MOMENTS).tolist()


def incommensurate_periods(config: Any) -> Iterator[Problem]:
    """Too few particles in a period."""
    for periodic, size, key in zip(config.periodic, config.extent, ("length", "height"), strict=True):
        if periodic and round(size / config.spacing) < LEAST_IN_PERIOD:
            text = f"must be at least {LEAST_IN_PERIOD * config.spacing:.6g}, {LEAST_IN_PERIOD} particle spacings"
            yield f"geometry.{key}", f"{text}: the neighbour search needs three cells around bodies"


def bodies_of(config: Any, walls: dict[str, Body], origin: tuple[float, float] = (0.0, 0.0)) -> list[Body]:
    """The bodies in the fluid between these ``walls``, in a cell whose lowest corner is ``origin``.

    Its periods are infinite where there are walls. ValidationError where a suspension does not fit.
    """
    sizes = zip(config.extent, config.periodic, strict=True)
    periods = tuple(size if periodic else math.inf for size, periodic in sizes)
    given = config.bodies
    if not isinstance(given, tuple):
        high = (origin[0] + config.extent[0], origin[1] + config.extent[1])
        given = given.bodies(Region(tuple(walls.values()), origin, high, config.periodic))
    return [body.body(periods, surroundings(config)) for body in given]


@dataclass(frozen=True)
class Surroundings:
    """What moves free bodies: ``density`` of the fluid, its ``acceleration`` along x, and ``gravity`` (2,)."""

    density: float
    acceleration: float
    gravity: tuple[float, float]


def surroundings(config: Any) -> Surroundings:
    """Those of a ``config``."""
    return Surroundings(config.fluid.density, config.drive.acceleration, config.drive.gravity or (0.0, 0.0))
