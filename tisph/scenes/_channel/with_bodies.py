"""The channel with bodies in it: a cell between two walls, without a reference."""

from collections.abc import Iterator
from typing import Any

from tisph.config.base import Problem
from tisph.scenes._cell.scene import Cell
from tisph.scenes._cell.sections import bodies_of, cell_problems
from tisph.scenes._cell.walls import plane_walls, planes


def scene(config):
    """The scene that a validated config with bodies describes."""
    walls = _walls(config)
    return Cell.around(config, bodies_of(config), walls, planes=planes(walls))


def problems(config: Any) -> Iterator[Problem]:
    """What the channel with bodies has against the config."""
    driven = [side for side in ("bottom", "top") if getattr(config.walls, side).stress_controlled]
    if driven:
        yield f"walls.{driven[0]}", "must have a velocity: with bodies in the channel no stress can drive a wall"
        return
    for side in ("bottom", "top"):
        if getattr(config.walls, side).velocities:
            yield f"walls.{side}.velocities", "is not for a channel with bodies: give velocity, or an amplitude"
            return
    if config.initial.state != "rest":
        yield "initial.state", "must be rest: with bodies in the channel no other flow to start from is known"
    if config.initial.time:
        yield "initial.time", "must be 0: with bodies in the channel the run starts from rest"
    for side in ("bottom", "top"):
        if getattr(config.walls, side).speed_before is not None:
            yield f"walls.{side}.velocity_before", "is not allowed with bodies: the run starts from rest"
    if config.walls.treatment.type != "consistent_image":
        yield "walls.treatment.type", "must be left out: with bodies walls are points on them, without images"
    if config.probes != type(config.probes)():
        yield "probes", "are not for a channel with bodies: what is followed are the forces on these"
    named = {f"walls.{name}": wall for name, wall in _walls(config).items()}
    yield from cell_problems(config, bodies_of(config), named)


def _walls(config: Any):
    return plane_walls(config.geometry.length, config.geometry.gap, config.walls)
