"""What drives a flow of ``start_up``: walls, and the acceleration g."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np


class Steady:
    """What does not change in time."""

    oscillates = False
    angular_frequency = 0.0
    jump_times = ()

    def after(self, time):
        """The same: it does not change."""
        return self


@dataclass(frozen=True)
class Wall(Steady):
    """A wall of constant ``speed``."""

    stress_controlled: ClassVar[bool] = False

    speed: float = 0.0

    def velocity(self, t):
        """``speed``, of the shape of ``t``."""
        return self.speed + 0.0 * np.asarray(t)

    def acceleration(self, t):
        """0, of the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class Axis(Steady):
    """The axis r = 0 in the place of an inner wall, with methods of a wall of no mass and no stress."""

    stress_controlled: ClassVar[bool] = True
    mass_per_area: ClassVar[float] = 0.0

    def stress(self, t):
        """0, of the shape of ``t``."""
        return 0.0 * np.asarray(t)


@dataclass(frozen=True)
class Flow:
    """Walls y = 0 and y = ``gap``, and the acceleration g along planes or along the axis.

    Walls have ``velocity(t)`` and ``acceleration(t)``, or are a ``StressControlledWall`` per unit density; they change
    at once at the times ``jump_times``, and ``after(time)`` is what they are from then on. ``inner_radius``: that of
    the cylinder y = 0, None between planes; 0 where there is none and y = 0 is the axis, whatever ``bottom`` is.
    Cylinders have angular velocities, or, ``along`` the axis, velocities.

    g = ``acceleration`` + cosine cos(w t) + sine sin(w t), w = angular_frequency > 0, all attributes of ``pulsation``.
    """

    gap: float
    bottom: Any = Wall()
    top: Any = Wall()
    acceleration: float = 0.0
    inner_radius: float | None = None
    along: bool = False
    pulsation: Any = None

    @property
    def walls(self):
        """What is at y = 0 and y = ``gap``."""
        return Axis() if self.inner_radius == 0.0 else self.bottom, self.top

    def largest_drive(self, viscous_time):
        """A velocity that g reaches: g gap^2/(12 nu), or less where g oscillates fast."""
        part, found = self.pulsation, abs(self.acceleration) * viscous_time / 12
        if part is None:
            return found
        return found + np.hypot(part.cosine, part.sine) * min(viscous_time / 12, 1 / part.angular_frequency)

    def drive(self, times):
        """The acceleration g at ``times``."""
        part, steady = self.pulsation, self.acceleration + 0.0 * times
        if part is None:
            return steady
        angle = part.angular_frequency * times
        return steady + part.cosine * np.cos(angle) + part.sine * np.sin(angle)
