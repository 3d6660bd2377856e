"""A channel with open ends: fluid enters at one of them and leaves at the other, past bodies and steps of the walls.

``Stream`` is the scene of a channel with ``ends``. It records forces on the bodies, what flows in and out, and the
pressures of both ends.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.ends import LEAST_DISTANCE, Course, Inlet, InletProfile, OpenEnd, Outlet
from tisph.geometry.line import Line
from tisph.geometry.motion import Schedule, WallMotion
from tisph.geometry.packing import pack
from tisph.geometry.region import Region
from tisph.scenes._cell import Cell
from tisph.scenes._scene import LEAST_JITTER


def course_of(given: Any) -> Any:
    """Return the mean velocity over time of an inlet of a config."""
    if given.velocities:
        return Schedule(given.times, given.velocities)
    wave = WallMotion(0.0)
    if given.amplitude is not None:
        parts = (given.amplitude, 0.0) if given.phase == "cos" else (0.0, given.amplitude)
        wave = WallMotion(*parts, angular_frequency=given.angular_frequency)
    return Course(given.velocity or 0.0, wave)


def parabola(low: float, high: float) -> InletProfile:
    """Return the parabola 6 s (1 - s), s = (y - low)/(high - low)."""
    width = high - low
    return InletProfile(
        lambda y: 6.0 * (y - low) * (high - y) / width**2, lambda y: 6.0 * (low + high - 2.0 * y) / width**2
    )


def profile_of(config: Any, low: float, high: float) -> InletProfile:
    """Return the profile of the inlet of a ``config`` between these heights, with a mean of 1."""
    given = config.ends.inlet.profile
    if given == "uniform":
        return InletProfile(np.ones_like, np.zeros_like)
    return parabola(low, high)


def heights_at(config: Any, side: str) -> tuple[float, float]:
    """Return the heights of the bottom and the top wall at the end ``side`` (left, right) of the channel."""
    walls, end = config.walls, 0 if side == "left" else -1
    low, high = (wall.outline and wall.outline[end][1] for wall in (walls.bottom, walls.top))
    return low or 0.0, config.geometry.gap if high is None else high


@dataclass(frozen=True, kw_only=True)
class Stream(Cell):
    """Flow through a channel from an inlet to an outlet; the ends are the last two bodies, the outlet after the inlet."""

    @classmethod
    def from_config(cls, config: Any) -> "Stream":
        """Return the scene that a validated config describes."""
        from tisph.scenes._cell import bodies_of, plane_walls, planes

        length, gap = config.geometry.length, config.geometry.gap
        walls = plane_walls(length, gap, config.walls)
        heights = {side: heights_at(config, side) for side in ("left", "right")}
        (low, high), (right_low, right_high) = heights.values()
        places = {
            "left": Line((0.0, high), (0.0, -1.0), high - low),
            "right": Line((length, right_low), (0.0, 1.0), right_high - right_low),
        }
        sides = sorted(places, key=lambda side: getattr(config.ends, side).type)
        profile, course = profile_of(config, *heights[sides[0]]), course_of(config.ends.inlet)
        ends = {
            sides[0]: Inlet(places[sides[0]], profile=profile, course=course),
            sides[1]: Outlet(places[sides[1]]),
        }
        bodies = bodies_of(config, walls)
        developed = (lambda x, y: np.stack([profile.value(y), 0.0 * y]) * course.velocity(0.0)) if config.initial.state == "developed" else None
        return cls.around(config, bodies, {**walls, **ends}, walls=planes(walls), initial_velocity=developed)

    @cached_property
    def _filled(self) -> Region:
        """The part of the region in which there are particles: the ends are moved into it."""
        clear = LEAST_DISTANCE * self.spacing
        moved = [
            replace(body, centre=tuple(clear * body.shape.normal)) if isinstance(body, OpenEnd) else body
            for body in self.bodies
        ]
        return replace(self.region, bodies=tuple(moved))

    @cached_property
    def particles(self) -> int:
        """Number of fluid particles."""
        return round(self._filled.area / self.spacing**2)

    def jittered(self, seed: int, jitter: float) -> tuple[np.ndarray, np.ndarray]:
        """Return x, y (particles,) of particles that fill the region."""
        x, y = pack(self._filled, self.spacing, max(jitter, LEAST_JITTER), seed).T
        return x, y

    @property
    def inlet(self) -> Inlet:
        """The inlet."""
        return self.bodies[-2]  # type: ignore[return-value]

    @property
    def driven_wall(self) -> float:
        """Speed of the fastest body or wall, or the largest mean velocity through the inlet."""
        return max(super().driven_wall, self.inlet.course.largest_speed)

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times at which the acceleration of the inflow jumps."""
        return self.inlet.course.jump_times
