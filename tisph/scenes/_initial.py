"""Sections of a config that scenes share: how a flow starts, what drives it, and the bodies in a cell.

A flow starts at rest, or, where walls have a history, developed, or on the way.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from tisph.bodies._clearance import LEAST_GAP, size_problems
from tisph.bodies._clearance import problems as room_problems
from tisph.config.base import Model, NonNegative, Positive, Problem, Signed
from tisph.config.checks import LEAST_IN_PERIOD
from tisph.geometry.body import Body
from tisph.geometry.region import Region
from tisph.scenes._body_scene import largest_speed


class Drive(Model):
    """What drives fluid and bodies.

    ``acceleration`` [length/time^2] along x, of either sign: -(dp/dx) / density of a pressure gradient, which acts on a
    free body as it does on the fluid that the body takes the place of. ``gravity`` [gx, gy] [length/time^2]: the weight
    of the fluid is held by a pressure of its own, which is no part of ``pressure`` in results, and a free body has its
    weight less that of the fluid it displaces: (density - that of the fluid) * area * gravity.
    """

    unset_keys = ("gravity",)

    acceleration: Signed = 0.0
    gravity: Annotated[tuple[Signed, Signed], Field(strict=False)] | None = None


class Contact(Model):
    """Near contact of free bodies: nearer than ``distance`` [length] they push each other off, and walls.

    No fluid is resolved between them there; two particle spacings where left out.
    """

    distance: Positive


def still_problem(config: Any, key: str, remedy: str) -> Iterator[Problem]:
    """Problem of a ``config`` in which nothing moves, at ``key``: none where a velocity is given for other causes."""
    if not config.reference:
        text = "nothing moves: " + remedy
        yield key, f"{text}; or a reference.velocity, for a fluid that functions given from Python move"


class RestInitial(Model):
    """The fluid is at rest at first. ``jitter``: uniform random displacement of every particle, +- that many spacings
    in x and y, after they have been spread evenly; the same ``seed`` gives the same displacements."""

    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0


class Initial(Model):
    """Start: at rest, developed, or ``exact``: the exact flow at ``time`` that started at t = 0.

    Motion starts, or changes, at t = 0. ``developed``: the steady flow of the velocities before t = 0, the
    periodic flow of walls that oscillate. ``exact`` started from rest, or from the developed flow where a wall
    has another velocity before t = 0.

    ``jitter``: uniform random displacement of every particle, +- that many spacings in x and y; the same
    ``seed`` gives the same displacements.
    """

    state: Literal["rest", "developed", "exact"] = "rest"
    time: NonNegative = 0.0
    jitter: Annotated[float, Field(ge=0, lt=0.5)] = 0.0
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = 0


def start_problems(config: Any, walls: Sequence[str]) -> Iterator[Problem]:
    """What is wrong with the start of the ``config`` of a scene with these ``walls``."""
    state = config.initial.state
    if state == "exact" and config.initial.time == 0:
        yield "initial.time", "must be greater than 0 with state exact (from rest: state rest)"
    if state != "exact" and config.initial.time != 0:
        yield "initial.time", f"is allowed only with state exact, not with state {state}"
    for side in walls:
        wall = getattr(config.walls, side)
        if state == "rest" and wall.speed_before is not None:
            text = "is not allowed with initial.state rest, in which nothing moves before t = 0"
            yield f"walls.{side}.{wall.speed_key}_before", f"{text}: take state developed, or exact with a time"


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
