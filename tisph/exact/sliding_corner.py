"""Slow flow in the corner between a wall that slides in its own direction and one at rest.

G. I. Taylor, "On scraping viscous fluid from a plane surface" (1962): the stream function r f(theta), with
f = a cos theta + b sin theta + c theta cos theta + d theta sin theta, theta from the sliding wall. Velocities do not
depend on the distance r from the corner, the pressure goes like 1/r. Near the corner all flow is like that, whatever it
is elsewhere: without it no field of finite spacing resolves such a corner (O. Botella, R. Peyret, Comput. Fluids 27
(1998) 421-433, who subtract it in a cavity).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class SlidingCorner:
    """Corner at ``place`` (2,): a wall that slides away from it along ``along`` (2,), with ``speed``, meets another.

    ``inward`` (2,): normal of the sliding wall into the liquid; both directions are of length 1. ``angle`` between the
    walls, in radians.
    """

    place: tuple[float, float]
    along: tuple[float, float]
    inward: tuple[float, float]
    angle: float
    speed: float

    @cached_property
    def _coefficients(self):
        """a, b, c, d: no flow through the walls, the speed at theta = 0 and rest at the other wall."""
        sine, cosine, angle = np.sin(self.angle), np.cos(self.angle), self.angle
        conditions = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 1.0, 0.0],
            [cosine, sine, angle * cosine, angle * sine],
            [-sine, cosine, cosine - angle * sine, sine + angle * cosine],
        ]
        return np.linalg.solve(conditions, [0.0, self.speed, 0.0, 0.0])

    def _polar(self, points):
        """Distance from the corner and angle from the sliding wall of ``points`` (n, 2)."""
        away = np.asarray(points, dtype=float) - self.place
        along, inward = away @ np.array(self.along), away @ np.array(self.inward)
        return np.hypot(along, inward), np.arctan2(inward, along)

    def velocity(self, points):
        """Velocity (n, 2) at ``points`` (n, 2)."""
        a, b, c, d = self._coefficients
        theta = self._polar(points)[1]
        sine, cosine = np.sin(theta), np.cos(theta)
        radial = -a * sine + b * cosine + c * (cosine - theta * sine) + d * (sine + theta * cosine)
        turning = -(a * cosine + b * sine + c * theta * cosine + d * theta * sine)
        along, inward = radial * cosine - turning * sine, radial * sine + turning * cosine
        return along[:, None] * np.array(self.along) + inward[:, None] * np.array(self.inward)

    def pressure(self, points):
        """Pressure (n,) over the dynamic viscosity at ``points`` (n, 2); infinite in the corner."""
        _, _, c, d = self._coefficients
        distance, theta = self._polar(points)
        with np.errstate(divide="ignore", invalid="ignore"):
            return 2.0 * (c * np.cos(theta) + d * np.sin(theta)) / distance
