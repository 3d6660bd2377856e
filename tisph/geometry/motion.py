"""How walls and bodies move.

* ``WallMotion``: each component of a velocity is constant, or oscillates, from t = 0 on.
* ``Schedule``: the velocity of a wall is given at some times, and is linear in between.
* ``StressControlledWall``: a shear stress drives a plane wall, a plate without inertia or with it.
* ``FreeMotion``: the flow carries a body; its motion is solved for step by step. Velocities of the centre and around it
  at the ends of the last steps are the values of a polynomial in time; the displacement is its integral. So the body
  moves as the particles do, with the same order, and between steps it is where the polynomial says.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

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
        """Segments of a piecewise linear velocity: start time, velocity there, slope, displacement up to the start.

        The first segment ends at the first time.
        """
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


LEVELS = 4
"""Velocities kept: those of the particles are as many."""


FREEDOMS = ("x", "y", "angle")
"""What a body may be free in: its place along both axes, and how it is turned."""


@dataclass(frozen=True)
class Inertia:
    """``mass`` (3,): mass, mass and moment of inertia around the centre, per length across the plane.

    ``load`` (3,): force along x and y and torque from outside, weight less buoyancy included. ``velocity`` (3,) before
    the start, ``held`` (3,) whether each of ``FREEDOMS`` stays at that velocity. ``displaced``: volume of fluid that it
    takes the place of, where a mean velocity is kept.
    """

    mass: tuple[float, float, float]
    load: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    held: tuple[bool, bool, bool] = (False, False, False)
    displaced: float = 0.0


class FreeMotion(OfComponents):
    """Motion like a ``RigidMotion``, of a body with an ``inertia``, at times up to the end of the present step.

    Its largest speed is that before the start: later ones are not known.
    ``times`` and ``velocities`` (3,) of the last levels, newest first: along x and y, and angular. ``way`` (3,) from
    the start to the newest.
    """

    free = True

    def __init__(self, inertia):
        self.inertia = inertia
        self.x, self.y, self.rotation = (_Component(self, index) for index in range(3))
        self.start(0.0, inertia.velocity)

    def start(self, time, velocity):
        """Begin at ``time`` with a ``velocity`` (3,), from where the body is placed."""
        self.way, self.change = np.zeros(3), np.zeros(3)
        self.times, self.velocities = [float(time)], [np.array(velocity, dtype=float)]
        self._fit()

    def restart(self):
        """Go on from the newest velocity where all earlier ones are no part of a smooth function any more."""
        self.times, self.velocities = self.times[:1], self.velocities[:1]
        self._fit()

    def attempt(self, velocity):
        """Take the ``velocity`` (3,) to be that at the end of the present step, for now."""
        self.tried = np.array(velocity, dtype=float)

    def accept(self, time):
        """Let the last ``attempt`` be the newest level, at ``time``."""
        self.way = self.way_at(time)
        self.times = [float(time), *self.times][:LEVELS]
        self.velocities = [self.tried, *self.velocities][:LEVELS]
        self._fit()

    def state(self):
        """What a resumed run needs."""
        velocities = [velocity.tolist() for velocity in self.velocities]
        return {"times": self.times, "velocities": velocities, "way": self.way.tolist(), "change": self.change.tolist()}

    def restore(self, state):
        """Take up what ``state`` returned."""
        self.times, self.velocities = list(state["times"]), [np.array(each) for each in state["velocities"]]
        self.way, self.change = np.array(state["way"]), np.array(state["change"])
        self._fit()

    def _fit(self):
        """Find the coefficients of the polynomial in (t - newest) / unit."""
        self.tried, self.unit = None, (self.times[0] - self.times[1]) if len(self.times) > 1 else 1.0
        places = (np.array(self.times) - self.times[0]) / self.unit
        self.coefficients = np.linalg.solve(np.vander(places, increasing=True), np.array(self.velocities))

    def _powers(self, time):
        return (time - self.times[0]) / self.unit, np.arange(len(self.coefficients))

    def velocity_at(self, time):
        """Velocities (3,) at ``time``; what is tried at the end of a step is later than all levels."""
        if self.tried is not None and time > self.times[0]:
            return self.tried
        place, power = self._powers(time)
        return place**power @ self.coefficients

    def extrapolated(self, time):
        """Velocities (3,) at ``time``, later than all levels; in the first step by the acceleration at the start."""
        self.tried = None
        first = (time - self.times[0]) * self.change if len(self.times) == 1 else 0.0
        return self.velocity_at(time) + first

    def way_at(self, time):
        """Displacement and angle (3,) from the start to ``time``."""
        place, power = self._powers(time)
        return self.way + self.unit * place * (place**power / (power + 1)) @ self.coefficients

    def change_at(self, time):
        """Accelerations (3,) at ``time``; at the start they are those that belong to the first pressure."""
        if len(self.times) == 1:
            return self.change
        place, power = self._powers(time)
        return power[1:] * place ** power[:-1] @ self.coefficients[1:] / self.unit


class _Component:
    """One component of a ``FreeMotion``, like a ``WallMotion``."""

    oscillates = False

    def __init__(self, motion, index):
        self._motion, self._index = motion, index

    @property
    def largest_speed(self):
        """Its speed before the start."""
        return abs(self._motion.inertia.velocity[self._index])

    def velocity(self, t):
        """Velocity at time ``t``."""
        return self._motion.velocity_at(t)[self._index]

    def acceleration(self, t):
        """Its derivative."""
        return self._motion.change_at(t)[self._index]

    def displacement(self, t):
        """Way from the start on."""
        return self._motion.way_at(t)[self._index]
