"""A wall whose velocity is given at some times, and is linear in between."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np


@dataclass(frozen=True)
class Ramp:
    """Velocity ``speed`` + ``slope`` * (t - ``begin``) along a wall [length/time]."""

    oscillates: ClassVar[bool] = True
    stress_controlled: ClassVar[bool] = False

    begin: float
    speed: float
    slope: float

    def velocity(self, t):
        """Velocity at time(s) ``t``, of the shape of ``t``."""
        return self.speed + self.slope * (np.asarray(t, dtype=float) - self.begin)

    def acceleration(self, t):
        """Its time derivative [length/time^2], of the shape of ``t``."""
        return self.slope + 0.0 * np.asarray(t, dtype=float)

    def jerk(self, t):
        """Its second time derivative, 0, of the shape of ``t``."""
        return 0.0 * np.asarray(t, dtype=float)


@dataclass(frozen=True)
class Schedule:
    """Velocity from t = 0 on: ``velocities`` [length/time] at ``times``, linear in between.

    Constant before the first of the times and after the last. Two equal times are a jump: there the methods return
    what was before it, but at t = 0 the wall has started already; ``during`` is what is after it.
    """

    oscillates: ClassVar[bool] = True
    stress_controlled: ClassVar[bool] = False
    before: ClassVar[None] = None
    sine: ClassVar[float] = 0.0
    angular_frequency: ClassVar[float] = 0.0

    times: tuple[float, ...]
    velocities: tuple[float, ...]

    @property
    def cosine(self):
        """The largest speed, as of a wall that oscillates."""
        return self.largest_speed

    @property
    def largest_speed(self):
        """The largest speed that the wall ever has."""
        return max(map(abs, self.velocities))

    @cached_property
    def _pieces(self):
        """Begin, speed then, slope, and way up to then, of what is before the first time and after each."""
        begins = np.array([0.0, *self.times])
        speeds = np.array([self.velocities[0], *self.velocities])
        lengths, rises = np.diff(begins), np.diff(speeds)
        slopes = np.append(np.divide(rises, lengths, out=np.zeros(len(rises)), where=lengths > 0.0), 0.0)
        ways = np.concatenate([[0.0], np.cumsum(lengths * (speeds[:-1] + 0.5 * rises))])
        return begins, speeds, slopes, ways

    def _at(self, t):
        """Number of the piece at times ``t``, and its begin, speed, slope and way."""
        t = np.asarray(t, dtype=float)
        piece = np.where(t > 0.0, np.searchsorted(self.times, t), np.searchsorted(self.times, t, side="right"))
        return t, *(values[piece] for values in self._pieces)

    def velocity(self, t):
        """Velocity at time(s) ``t``, of the shape of ``t``."""
        t, begin, speed, slope, _ = self._at(t)
        return speed + slope * (t - begin)

    def acceleration(self, t):
        """Its time derivative [length/time^2] at time(s) ``t``, of the shape of ``t``; without jumps."""
        return self._at(t)[3]

    def displacement(self, t):
        """Way [length] from t = 0 on, of the shape of ``t``."""
        t, begin, speed, slope, way = self._at(t)
        return way + (t - begin) * (speed + 0.5 * slope * (t - begin))

    def after(self, time):
        """The ``Ramp`` from ``time`` on, which goes on beyond the next change as it was."""
        piece = int(np.searchsorted(self.times, time, side="right"))
        return Ramp(*(float(values[piece]) for values in self._pieces[:3]))

    @cached_property
    def breakpoints(self):
        """Time, and jumps of velocity and acceleration, of the start and of all later times at which one jumps."""
        start, slopes = self.after(0.0), self._pieces[2]
        found = [(0.0, float(start.velocity(0.0)), start.slope)]
        for time in sorted({time for time in self.times if time > 0.0}):
            first, after = (int(np.searchsorted(self.times, time, side=side)) for side in ("left", "right"))
            jump, bend = self.velocities[after - 1] - self.velocities[first], float(slopes[after] - slopes[first])
            if jump or bend:
                found.append((time, jump, bend))
        return found

    @property
    def jump_times(self):
        """Times above 0 at which velocity or acceleration jump."""
        return tuple(time for time, _, _ in self.breakpoints if time > 0.0)

    def age(self, t):
        """Time up to ``t`` since the velocity last jumped, or changed by half the largest speed; else infinite.

        It jumps at t = 0 from that of a wall at rest. Kinks are no jumps: of a sine the age is what makes the layer
        half a penetration depth, 1/(2 w) to 1 %.
        """
        times, speeds = np.array([0.0, 0.0, *self.times]), np.array([0.0, self.velocities[0], *self.velocities])
        past = (times < t) | (times == 0.0)
        times, off = np.append(times[past], t), np.append(speeds[past] - self.velocity(t), 0.0)
        changes = times[:-1][(np.diff(times) == 0.0) & (np.diff(off) != 0.0)].tolist()
        half = 0.5 * self.largest_speed
        far = np.flatnonzero(np.abs(off) >= half) if half else []
        if len(far):
            last = far[-1]
            part = (abs(off[last]) - half) / abs(off[last] - off[last + 1])
            changes.append(times[last] + part * (times[last + 1] - times[last]))
        return float(t - max(changes, default=-np.inf))

    def relative_to(self, velocity):
        """The schedule in a frame that moves along x with ``velocity``."""
        return replace(self, velocities=tuple(speed - velocity for speed in self.velocities))

    def scaled(self, factor):
        """The schedule with ``factor`` times the velocities."""
        return replace(self, velocities=tuple(speed * factor for speed in self.velocities))

    def penetration_depth(self, kinematic_viscosity):
        """Infinite: nothing oscillates."""
        return np.inf
