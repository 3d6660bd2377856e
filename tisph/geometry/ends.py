"""Open ends: straight parts of the boundary that fluid passes through.

An end is no wall, but the operators see it as one: it has points, a normal into the fluid, and the fluid on one side.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tisph.geometry.body import Body, BodyState
from tisph.geometry.line import Line

LEAST_DISTANCE = 0.3
"""Distance from an end, in particle spacings, within which there are no particles: operators of particles nearer to a
row of points have large entries."""


@dataclass(frozen=True)
class InletProfile:
    """Velocity through an inlet over the height y, for a mean velocity of 1: ``value`` and ``slope``, its dy.

    Around an axis y is the radius, and the mean velocity is the flow rate over the area of the inlet.
    """

    value: Callable[[np.ndarray], np.ndarray]
    slope: Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class OpenEnd(Body):
    """A line along y that the fluid passes through; if ``axisymmetric`` the surface that it sweeps around y = 0."""

    steady: ClassVar[bool] = False
    solid: ClassVar[bool] = False

    shape: Line
    axisymmetric: bool = False

    @property
    def area(self) -> float:
        """Area that the fluid passes through, per length across the plane if that is not ``axisymmetric``."""
        low, high = self.shape.extent[:, 1].tolist()
        return math.pi * (high - low) * (high + low) if self.axisymmetric else self.shape.length


@dataclass(frozen=True, kw_only=True)
class Inlet(OpenEnd):
    """An end with the velocity ``course`` (t) * ``profile`` (y) into the fluid, along its normal.

    ``changing``: None, or a further velocity (``exact/flow_rate.py``), of flow that changes in time.
    ``swirl`` (A, B): velocity A r + B/r around the axis.
    """

    profile: InletProfile
    course: Any
    changing: Any = None
    swirl: tuple[float, float] = (0.0, 0.0)

    def _inwards(self, part: str, points: np.ndarray, time: float, order: int = 0) -> np.ndarray:
        """Return the time derivative of an ``order`` 0 or 1 of a ``part`` of the profiles, along the normal."""
        course, y = (self.course.velocity, self.course.acceleration)[order], points[:, 1]
        values = float(course(time)) * getattr(self.profile, part)(y)
        if self.changing:
            values = values + getattr(self.changing, part)(y, time, order)
        return values[:, None] * self.shape.normal

    def point_velocity(self, points: np.ndarray, state: BodyState) -> np.ndarray:
        """Return the velocity of the fluid at ``points``."""
        return self._inwards("value", points, state.time)

    def point_acceleration(self, points: np.ndarray, state: BodyState) -> np.ndarray:
        """Return the acceleration of the fluid at ``points``, of a flow that has been parallel upstream."""
        return self._inwards("value", points, state.time, order=1)

    def load_name(self, centre: np.ndarray) -> tuple[str, str]:
        """See ``Body.load_name``."""
        return "pressure", "at the inlet"

    def turning(self, radius: np.ndarray) -> np.ndarray:
        """Return the angular velocity (n,) of the fluid around the axis at each ``radius`` (n,), constant in time."""
        rate, vortex = self.swirl
        return rate + vortex / radius**2

    def tangential_gradient(self, points: np.ndarray, tangents: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the derivative of the velocity along ``tangents`` (n, 2) at ``points``."""
        return self._inwards("slope", points, time) * tangents[:, 1:]


@dataclass(frozen=True, kw_only=True)
class Outlet(OpenEnd):
    """An end with nu du/dn = (p - ``pressure`` / density) n, and no condition on the profile.

    Fluid leaves there, or enters if the pressure drives it.
    """

    pressure: float = 0.0

    @property
    def moves_fluid(self) -> bool:
        """See ``Body.moves_fluid``: the velocity is unknown."""
        return False


@dataclass(frozen=True)
class Course:
    """A constant ``mean`` velocity and a ``wave`` [length/time], which is a ``WallMotion``."""

    mean: float
    wave: Any

    jump_times: ClassVar[tuple[float, ...]] = ()

    @property
    def largest_speed(self) -> float:
        """The largest speed of all times."""
        return abs(self.mean) + self.wave.amplitude

    def velocity(self, t: Any) -> np.ndarray:
        """Return the velocity at time(s) ``t``."""
        return self.mean + self.wave.velocity(t)

    def acceleration(self, t: Any) -> np.ndarray:
        """Return the time derivative of the velocity at time(s) ``t``."""
        return self.wave.acceleration(t)
