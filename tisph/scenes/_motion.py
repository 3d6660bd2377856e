"""How a wall moves, and what a polymer adds to a liquid: small parts of a scene."""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class WallMotion:
    """Velocity of a wall along x from t = 0 on: cosine * cos(w t) + sine * sin(w t), w = ``angular_frequency``.

    A wall of constant velocity has w = 0 and its velocity as ``cosine``. ``before`` is its constant velocity
    before t = 0, where that was another one, else None. Velocities [length/time], ``angular_frequency`` [1/time].
    """

    cosine: float
    sine: float = 0.0
    angular_frequency: float = 0.0
    before: float | None = None

    @classmethod
    def from_config(cls, wall):
        """The motion that ``walls.bottom`` or ``walls.top`` of a validated config describes."""
        if wall.amplitude is None:
            return cls(cosine=wall.velocity, before=wall.velocity_before)
        cosine, sine = (wall.amplitude, 0.0) if wall.phase == "cos" else (0.0, wall.amplitude)
        return cls(cosine=cosine, sine=sine, angular_frequency=wall.angular_frequency)

    @property
    def oscillates(self):
        """Whether the velocity changes with time."""
        return self.angular_frequency != 0

    @property
    def largest_speed(self):
        """The largest speed that the wall has or had before t = 0."""
        return max(abs(self.before or 0.0), float(np.hypot(self.cosine, self.sine)))

    def seen_from(self, velocity):
        """The motion in a frame that moves along x with ``velocity``, which must be 0 where the wall oscillates."""
        before = None if self.before is None else self.before - velocity
        return replace(self, cosine=self.cosine - velocity, before=before)

    def velocity(self, t):
        """Velocity at time(s) ``t``, of the shape of ``t``."""
        angle = self.angular_frequency * np.asarray(t, dtype=float)
        return self.cosine * np.cos(angle) + self.sine * np.sin(angle)

    def acceleration(self, t):
        """Time derivative of the velocity [length/time^2] at time(s) ``t``, of the shape of ``t``."""
        angle = self.angular_frequency * np.asarray(t, dtype=float)
        return self.angular_frequency * (self.sine * np.cos(angle) - self.cosine * np.sin(angle))

    def jerk(self, t):
        """Second time derivative of the velocity [length/time^3] at time(s) ``t``, of the shape of ``t``."""
        return -(self.angular_frequency**2) * self.velocity(t)

    def penetration_depth(self, kinematic_viscosity):
        """Depth sqrt(2 nu / w) [length] in which the oscillation falls by a factor e; infinite without one.

        Stokes' second problem: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.3.
        """
        return float(np.sqrt(2 * kinematic_viscosity / self.angular_frequency)) if self.oscillates else np.inf


@dataclass(frozen=True)
class Polymer:
    """Polymer in an Oldroyd-B liquid: relaxation time [time], and the solvent's share of the total viscosity."""

    relaxation_time: float
    solvent_fraction: float
