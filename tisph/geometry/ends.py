"""Open ends: straight parts of the boundary that fluid passes through.

An end is no wall, but the operators see it as one: it has points, a normal into the fluid, and the fluid on one side.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.line import Line

LEAST_DISTANCE = 0.3
"""Distance from an end, in particle spacings, within which there are no particles: operators of particles nearer to a
row of points have large entries."""


@dataclass(frozen=True)
class InletProfile:
    """Velocity through an inlet over the height y, for a mean velocity of 1: ``value`` and ``slope``, its dy."""

    value: Callable[[np.ndarray], np.ndarray]
    slope: Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class OpenEnd(Body):
    """A line along y that the fluid passes through."""

    shape: Line


@dataclass(frozen=True, kw_only=True)
class Inlet(OpenEnd):
    """An end with the velocity ``course`` (t) * ``profile`` (y) into the fluid, along its normal."""

    profile: InletProfile
    course: Any

    def _inwards(self, values: np.ndarray) -> np.ndarray:
        return values[:, None] * self.shape.normal

    def velocity(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the velocity of the fluid at ``points``."""
        return float(self.course.velocity(time)) * self._inwards(self.profile.value(points[:, 1]))

    def acceleration(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the acceleration of the fluid at ``points``, of a flow that has been parallel upstream."""
        return float(self.course.acceleration(time)) * self._inwards(self.profile.value(points[:, 1]))

    def tangential_gradient(self, points: np.ndarray, tangents: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return the derivative of the velocity along ``tangents`` (n, 2) at ``points``."""
        slopes = self.profile.slope(points[:, 1]) * tangents[:, 1]
        return float(self.course.velocity(time)) * self._inwards(slopes)


@dataclass(frozen=True, kw_only=True)
class Outlet(OpenEnd):
    """An end with nu du/dn = p n, and no condition on the profile."""


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
