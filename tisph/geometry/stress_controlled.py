"""A plane wall that is driven by a shear stress, not by a velocity: a plate, without inertia or with it."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tisph.geometry.motion import Oscillation


@dataclass(frozen=True)
class StressControlledWall(Oscillation):
    """A wall that starts from rest at t = 0: mass_per_area dU/dt = stress(t) - what the fluid takes of it.

    The stress on it from outside, along x, oscillates or is constant; with ``steps``, pairs of a time and the stress
    from then on, it is constant in between (0 before the first).
    """

    stress_controlled: ClassVar[bool] = True
    before: ClassVar[None] = None

    mass_per_area: float = 0.0
    steps: tuple[tuple[float, float], ...] = ()

    @classmethod
    def from_config(cls, wall):
        """The plate that a wall of a channel's config describes."""
        mass = wall.mass_per_area or 0.0
        if wall.stresses is not None:
            return cls(0.0, mass_per_area=mass, steps=tuple(zip(wall.times, wall.stresses, strict=True)))
        if wall.stress_amplitude is None:
            return cls(wall.shear_stress, mass_per_area=mass)
        cosine, sine = (wall.stress_amplitude, 0.0) if wall.phase == "cos" else (0.0, wall.stress_amplitude)
        return cls(cosine, sine, wall.angular_frequency, mass)

    @property
    def jump_times(self):
        """Times above 0 at which the stress jumps."""
        return tuple(time for time, _ in self.steps if time > 0)

    def after(self, time):
        """The plate with the stress from ``time`` to the next change, which goes on beyond that as it was."""
        if not self.steps:
            return self
        passed = [stress for begin, stress in self.steps if begin <= time]
        return replace(self, cosine=passed[-1] if passed else 0.0, steps=())

    def stress(self, t):
        """Stress at time(s) ``t``, of the shape of ``t``."""
        if self.steps:
            times, stresses = zip((-np.inf, 0.0), *self.steps, strict=True)
            return np.asarray(stresses)[np.searchsorted(times, t, side="right") - 1]
        return self.value(t)

    def stress_rate(self, t):
        """Time derivative of the stress at time(s) ``t``, without its jumps, of the shape of ``t``."""
        return self.slope(t)

    @property
    def largest_stress(self):
        """The largest size of the stress."""
        return max((abs(stress) for _, stress in self.steps), default=self.amplitude)

    def over(self, density):
        """The plate with stress and mass over a ``density``."""
        return replace(
            self,
            cosine=self.cosine / density,
            sine=self.sine / density,
            mass_per_area=self.mass_per_area / density,
            steps=tuple((time, stress / density) for time, stress in self.steps),
        )


@dataclass(frozen=True)
class StressControlledMotion:
    """How a ``plate`` is seen to move: ``velocity_at``, a function of time, at most about ``cosine``."""

    oscillates: ClassVar[bool] = True
    before: ClassVar[None] = None
    sine: ClassVar[float] = 0.0

    plate: StressControlledWall
    cosine: float
    velocity_at: Any

    @property
    def angular_frequency(self):
        """Of the stress."""
        return self.plate.angular_frequency

    @property
    def stress_controlled(self):
        """It is a stress that is given."""
        return True

    def velocity(self, t):
        """Velocity at time(s) ``t``, of the shape of ``t``."""
        return self.velocity_at(t)

    def penetration_depth(self, kinematic_viscosity):
        """Depth [length] in which the oscillation falls by a factor e."""
        return self.plate.penetration_depth(kinematic_viscosity)
