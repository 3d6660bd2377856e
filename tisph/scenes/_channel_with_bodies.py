"""The channel with bodies in it: a cell between two walls, without a reference."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.config.base import Problem
from tisph.scenes._body_scene import plane_walls, planes
from tisph.scenes._cell import Cell, bodies_of, cell_problems


def scene(config):
    """The scene that a validated config with bodies describes."""
    walls = _walls(config)
    developed = Developed.of(config) if config.initial.state == "developed" else None
    return Cell.around(config, bodies_of(config, walls), walls, planes=planes(walls), start=developed)


@dataclass(frozen=True)
class Developed:
    """Steady flow of a Newtonian fluid in the channel without bodies: velocities at places x, y."""

    gap: float
    bottom: float
    top: float
    curvature: float

    @classmethod
    def of(cls, config):
        """Of a ``config``, whose walls have constant velocities."""
        speeds = config.walls.bottom.velocity or 0.0, config.walls.top.velocity or 0.0
        return cls(config.geometry.gap, *speeds, config.drive.acceleration / (2.0 * config.kinematic_viscosity))

    def __call__(self, x, y):
        """Velocities along x and y."""
        along = self.bottom + (self.top - self.bottom) * y / self.gap + self.curvature * y * (self.gap - y)
        return np.stack([along + 0.0 * x, 0.0 * x])


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
    moving = any(getattr(config.walls, side).amplitude for side in ("bottom", "top"))
    if config.initial.state != "rest" and (moving or config.fluid.rheology.type != "newtonian"):
        text = "must be rest with bodies in the channel, unless a Newtonian fluid and steady walls make it developed"
        yield "initial.state", text
    elif config.initial.state == "exact":
        yield "initial.state", "must be rest or developed: with bodies in the channel no exact flow is known"
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
    yield from cell_problems(config, bodies_of(config, named), named)


def _walls(config: Any):
    return plane_walls(config.geometry.length, config.geometry.gap, config.walls)
