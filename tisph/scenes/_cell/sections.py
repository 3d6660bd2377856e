"""The bodies that a config puts into a cell, and what speaks against them."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.bodies._clearance import problems as room_problems
from tisph.bodies._clearance import size_problems
from tisph.config.base import Problem
from tisph.config.resolution import LEAST_IN_PERIOD
from tisph.geometry.body import Body
from tisph.scenes._cell.walls import largest_speed

MOMENTS = 25
"""Times at which it is looked whether bodies that move keep apart."""


def cell_problems(config: Any, bodies: Sequence[Body], walls: dict[str, Body]) -> Iterator[Problem]:
    """What is wrong with the ``config`` of a cell with these ``bodies``, and ``walls`` by what messages call them."""
    if config.scheme.type == "wcsph":
        yield "scheme.type", "wcsph cannot serve bodies yet; take auto or implicit"
    moving = any(largest_speed(body) for body in (*bodies, *walls.values()))
    free = [body for body in bodies if body.free]
    pulled = any(any(body.motion.inertia.load) for body in free) or (free and config.drive.gravity)
    if not moving and not pulled and not config.drive.acceleration:
        yield "drive.acceleration", "nothing moves: give an acceleration, or let a body or a wall move"
    if config.drive.gravity and not free:
        yield "drive.gravity", "moves free bodies alone: give one the motion free, or leave it out"
    shapes = [(f"bodies.{index}", config.bodies[index], body) for index, body in enumerate(bodies)]
    shapes += [(key, config.walls.around, wall) for key, wall in walls.items() if wall.shape.area]
    yield from size_problems(shapes, config.spacing, config.across)
    yield from room_problems(bodies, walls, config.spacing, _times(config, bodies))


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


def bodies_of(config: Any) -> list[Body]:
    """The bodies in the fluid, in a cell whose periods are infinite where there are walls."""
    sizes = zip(config.extent, config.periodic, strict=True)
    periods = tuple(size if periodic else math.inf for size, periodic in sizes)
    return [body.body(periods, surroundings(config)) for body in config.bodies]


@dataclass(frozen=True)
class Surroundings:
    """What moves free bodies: ``density`` of the fluid, its ``acceleration`` along x, and ``gravity`` (2,)."""

    density: float
    acceleration: float
    gravity: tuple[float, float]


def surroundings(config: Any) -> Surroundings:
    """Those of a ``config``."""
    return Surroundings(config.fluid.density, config.drive.acceleration, config.drive.gravity or (0.0, 0.0))
