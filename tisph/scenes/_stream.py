"""A channel with open ends: fluid enters at one of them and leaves at the other, past bodies and steps of the walls.

``Stream`` is the scene of a channel with ``ends``. It records forces on the bodies, what flows in and out, and the
pressures of both ends.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph.config.base import Problem
from tisph.config.ends import Table
from tisph.exact._fluids import fluid_of
from tisph.exact.uniform_shear import UniformShear
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


def end_lines(length: float, gap: float) -> dict[str, Line]:
    """Return the lines of the ``left`` and ``right`` end of a channel, whose normals are into the fluid."""
    return {"left": Line((0.0, gap), (0.0, -1.0), gap), "right": Line((length, 0.0), (0.0, 1.0), gap)}


def depends_on_flow_rate(config: Any) -> bool:
    """Return whether the profile of the inlet changes with its mean velocity: developed flow of a non-linear fluid."""
    return config.ends.inlet.profile == "developed" and config.fluid.rheology.type not in ("newtonian", "oldroyd_b")


def profile_of(config: Any, low: float, high: float) -> InletProfile:
    """Return the profile of the inlet of a ``config`` between these heights, with a mean of 1."""
    from scipy.interpolate import CubicSpline

    given, width = config.ends.inlet.profile, high - low
    if given == "uniform":
        return InletProfile(np.ones_like, np.zeros_like)
    if depends_on_flow_rate(config):
        fluid = fluid_of(config.fluid.rheology, config.kinematic_viscosity, config.fluid.density)
        flow = UniformShear(fluid.flux, fluid.laws)
        distances, rates = flow.developed(config.ends.inlet.velocity, width)
        heights = 0.5 * (low + high) + np.concatenate([-distances[:0:-1], distances])
        profile = CubicSpline(heights, np.concatenate([rates[:0:-1], -rates])).antiderivative()
    elif given in ("developed", "parabolic"):
        return parabola(low, high)
    else:
        profile = CubicSpline(low + np.array(given.heights), given.velocities)
    profile.c *= width / profile.integrate(low, high)
    return InletProfile(profile, profile.derivative())


def profile_problems(config: Any, low: float, high: float) -> Iterator[Problem]:
    """Yield the error in the profile of the inlet of a ``config`` between these heights, if there is one."""
    given, width = config.ends.inlet.profile, high - low
    key = f"ends.{'left' if config.ends.inlet is config.ends.left else 'right'}.profile"
    if depends_on_flow_rate(config) and (config.ends.inlet.velocities or config.ends.inlet.amplitude):
        text = "must be parabolic, uniform or a table where the mean velocity changes"
        yield key, f"{text}: a developed {config.fluid.rheology.type} flow has another profile at each velocity"
    if not isinstance(given, Table):
        return
    if abs(given.heights[-1] - width) > 1e-9 * width:
        yield f"{key}.heights", f"must end at the width of the inlet, {width:.12g}"
        return
    if profile_of(config, low, high).value(np.linspace(low, high, 1000)).min() < -1e-9:
        yield f"{key}.velocities", "must be more points: the cubic spline through these is negative in between"


@dataclass(frozen=True, kw_only=True)
class Stream(Cell):
    """Flow through a channel from an inlet to an outlet; the ends are the last two bodies, the outlet after the inlet."""

    @classmethod
    def from_config(cls, config: Any) -> "Stream":
        """Return the scene that a validated config describes."""
        from tisph.scenes._cell import bodies_of, plane_walls, planes

        length, gap = config.geometry.length, config.geometry.gap
        walls = plane_walls(length, gap, config.walls)
        places = end_lines(length, gap)
        profile, course = profile_of(config, 0.0, gap), course_of(config.ends.inlet)
        sides = sorted(places, key=lambda side: getattr(config.ends, side).type)
        ends = {
            sides[0]: Inlet(places[sides[0]], profile=profile, course=course),
            sides[1]: Outlet(places[sides[1]]),
        }
        bodies = bodies_of(config, {**walls, **ends})
        developed = (
            (lambda x, y: np.stack([profile.value(y), 0.0 * y]) * course.velocity(0.0))
            if config.initial.state == "developed"
            else None
        )
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
