"""How walls and bodies move: each component of a velocity is constant, or oscillates, from t = 0 on."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np


@dataclass(frozen=True)
class Oscillation:
    """cosine * cos(w t) + sine * sin(w t), w = ``angular_frequency``; a constant, which is ``cosine``, has w = 0."""

    cosine: float
    sine: float = 0.0
    angular_frequency: float = 0.0

    @property
    def oscillates(self):
        """Whether it changes with time."""
        return self.angular_frequency != 0

    @property
    def amplitude(self):
        """Its largest size."""
        return float(np.hypot(self.cosine, self.sine))

    def value(self, t):
        """Itself at time(s) ``t``, of the shape of ``t``."""
        angle = self.angular_frequency * np.asarray(t, dtype=float)
        return self.cosine * np.cos(angle) + self.sine * np.sin(angle)

    def slope(self, t):
        """Its time derivative."""
        angle = self.angular_frequency * np.asarray(t, dtype=float)
        return self.angular_frequency * (self.sine * np.cos(angle) - self.cosine * np.sin(angle))

    def penetration_depth(self, kinematic_viscosity):
        """Depth sqrt(2 nu / w) [length] in which the oscillation falls by a factor e; infinite without one.

        Stokes' second problem: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.3.
        """
        return float(np.sqrt(2 * kinematic_viscosity / self.angular_frequency)) if self.oscillates else np.inf


@dataclass(frozen=True)
class WallMotion(Oscillation):
    """One component of a velocity from t = 0 on.

    ``before`` is its constant velocity
    before t = 0, where that was another one (0 for one that starts from rest), else None. Velocities [length/time], or
    [1/time] of what turns, ``angular_frequency`` [1/time].
    """

    stress_controlled: ClassVar[bool] = False
    jump_times: ClassVar[tuple[float, ...]] = ()
    breakpoints: ClassVar[tuple[tuple[float, float, float], ...]] = ()

    before: float | None = None

    def after(self, time):
        """The motion itself: it does not change at once after t = 0."""
        return self

    @classmethod
    def from_config(cls, wall):
        """The motion that a ``config.motion.WallMotion`` describes."""
        if wall.amplitude is None:
            return cls(cosine=wall.speed, before=wall.speed_before)
        cosine, sine = (wall.amplitude, 0.0) if wall.phase == "cos" else (0.0, wall.amplitude)
        return cls(cosine=cosine, sine=sine, angular_frequency=wall.angular_frequency)

    @property
    def largest_speed(self):
        """The largest speed that the wall has or had before t = 0."""
        return max(abs(self.before or 0.0), self.amplitude)

    def relative_to(self, velocity):
        """The motion in a frame that moves along x with ``velocity``, which must be 0 where the wall oscillates."""
        before = None if self.before is None else self.before - velocity
        return replace(self, cosine=self.cosine - velocity, before=before)

    def scaled(self, factor):
        """The motion with ``factor`` times the velocities."""
        before = None if self.before is None else self.before * factor
        return replace(self, cosine=self.cosine * factor, sine=self.sine * factor, before=before)

    def velocity(self, t):
        """Velocity at time(s) ``t``, of the shape of ``t``."""
        return self._or_before(t, self.before, self.value(t))

    def acceleration(self, t):
        """Time derivative of the velocity [length/time^2] at time(s) ``t``, of the shape of ``t``; without its jump."""
        return self._or_before(t, 0.0, self.slope(t))

    def jerk(self, t):
        """Second time derivative of the velocity [length/time^3] at time(s) ``t``, of the shape of ``t``."""
        return self._or_before(t, 0.0, -(self.angular_frequency**2) * self.value(t))

    def displacement(self, t):
        """Way [length] from t = 0 on, negative times included, of the shape of ``t``."""
        t = np.asarray(t, dtype=float)
        if not self.oscillates:
            return self._or_before(t, (self.before or 0.0) * t, t * self.cosine)
        half = 0.5 * self.angular_frequency * t
        # sin(w t/2)/(w/2) = t sin(x)/x with x = w t/2
        way = t * np.sinc(half / np.pi) * (self.cosine * np.cos(half) + self.sine * np.sin(half))
        return self._or_before(t, (self.before or 0.0) * t, way)

    def _or_before(self, t, before, value):
        """Return ``value``, or ``before`` at times before 0 where the velocity was another one then."""
        return value if self.before is None else np.where(np.asarray(t) < 0, before, value)[()]


class OfComponents:
    """Motion of a whole body from those of its parts: ``x`` and ``y`` of the centre, and ``rotation`` around it."""

    def velocity(self, t):
        """Velocity (2,) of the centre at time ``t``."""
        return np.array([self.x.velocity(t), self.y.velocity(t)])

    def acceleration(self, t):
        """Acceleration (2,) of the centre at time ``t``."""
        return np.array([self.x.acceleration(t), self.y.acceleration(t)])

    def displacement(self, t):
        """Way (2,) of the centre from t = 0 on."""
        return np.array([self.x.displacement(t), self.y.displacement(t)])

    def largest_speed(self, radius):
        """Bound of the speed of what is within ``radius`` [length] of the centre."""
        around = radius * self.rotation.largest_speed if self.rotation.largest_speed else 0.0
        return float(np.hypot(self.x.largest_speed, self.y.largest_speed)) + around


@dataclass(frozen=True)
class RigidMotion(OfComponents):
    """Velocity (``x``, ``y``) [length/time] of the centre of a body, and its angular velocity ``rotation`` [1/time].

    Angles are counterclockwise.
    """

    free: ClassVar[bool] = False

    x: WallMotion = WallMotion(0.0)
    y: WallMotion = WallMotion(0.0)
    rotation: WallMotion = WallMotion(0.0)


STILL = WallMotion(0.0)
"""A component that is 0."""

REST = RigidMotion()
"""No motion at all."""
