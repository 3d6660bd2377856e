"""Motions of walls and bodies.

* ``WallMotion``: each component of a velocity is constant, or oscillates, from t = 0 on.
* ``Schedule``: the velocity of a wall is given at some times, and is linear in between.
* ``SmoothSchedule``: the same with cubic splines in between, for a wall that slides along itself.
* ``StressControlledWall``: a shear stress drives a plane wall, a plate without inertia or with it.
* ``FreeMotion``: the flow carries a body, and the scheme solves for its motion step by step. Velocities of the centre
  and around it at the ends of the last steps define a polynomial in time; the displacement is its integral. Therefore
  the motion has the order of the particles' motion, and is defined within steps.

Functions of time take a time or an array of times ``t``, and return values of the same shape.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

import numpy as np

TimeLike: TypeAlias = float | np.ndarray
"""A time, or an array of times of any shape."""


@dataclass(frozen=True)
class Oscillation:
    """f(t) = ``cosine`` cos(w t) + ``sine`` sin(w t), w = ``angular_frequency``; a constant has w = 0."""

    cosine: float
    sine: float = 0.0
    angular_frequency: float = 0.0

    @property
    def oscillates(self) -> bool:
        """Whether it changes with time."""
        return self.angular_frequency != 0

    @property
    def amplitude(self) -> float:
        """Its largest size."""
        return float(np.hypot(self.cosine, self.sine))

    def value(self, t: TimeLike) -> np.ndarray:
        """Return f at time(s) ``t``."""
        angle = self.angular_frequency * np.asarray(t, dtype=float)
        return self.cosine * np.cos(angle) + self.sine * np.sin(angle)

    def slope(self, t: TimeLike) -> np.ndarray:
        """Return df/dt at time(s) ``t``."""
        angle = self.angular_frequency * np.asarray(t, dtype=float)
        return self.angular_frequency * (self.sine * np.cos(angle) - self.cosine * np.sin(angle))

    def penetration_depth(self, kinematic_viscosity: float) -> float:
        """Return the depth sqrt(2 nu / w) [length] in which the oscillation falls by a factor e; infinite for w = 0.

        Stokes' second problem: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.3.
        """
        return float(np.sqrt(2 * kinematic_viscosity / self.angular_frequency)) if self.oscillates else np.inf


@dataclass(frozen=True)
class WallMotion(Oscillation):
    """One component of a velocity [length/time], or an angular velocity [1/time], from t = 0 on.

    ``before`` is the constant velocity before t = 0 where it jumps then (0 for a wall that starts from rest), else
    None.
    """

    stress_controlled: ClassVar[bool] = False
    jump_times: ClassVar[tuple[float, ...]] = ()
    breakpoints: ClassVar[tuple[tuple[float, float, float], ...]] = ()

    before: float | None = None

    def after(self, time: float) -> "WallMotion":
        """Return the motion itself: it does not jump after t = 0."""
        return self

    @classmethod
    def from_config(cls, wall: Any) -> "WallMotion":
        """Return the motion that a ``config.motion.WallMotion`` describes."""
        if wall.amplitude is None:
            return cls(cosine=wall.speed, before=wall.speed_before)
        cosine, sine = (wall.amplitude, 0.0) if wall.phase == "cos" else (0.0, wall.amplitude)
        return cls(cosine=cosine, sine=sine, angular_frequency=wall.angular_frequency)

    @property
    def largest_speed(self) -> float:
        """The largest speed of all times, before t = 0 included."""
        return max(abs(self.before or 0.0), self.amplitude)

    def relative_to(self, velocity: float) -> "WallMotion":
        """Return the motion in a frame that moves along x with ``velocity``, which must be 0 for an oscillation."""
        before = None if self.before is None else self.before - velocity
        return replace(self, cosine=self.cosine - velocity, before=before)

    def scaled(self, factor: float) -> "WallMotion":
        """Return the motion with ``factor`` times the velocities."""
        before = None if self.before is None else self.before * factor
        return replace(self, cosine=self.cosine * factor, sine=self.sine * factor, before=before)

    def velocity(self, t: TimeLike) -> np.ndarray:
        """Return the velocity at time(s) ``t``."""
        return self._or_before(t, self.before, self.value(t))

    def acceleration(self, t: TimeLike) -> np.ndarray:
        """Return the time derivative of the velocity [length/time^2] at time(s) ``t``, without its jump."""
        return self._or_before(t, 0.0, self.slope(t))

    def jerk(self, t: TimeLike) -> np.ndarray:
        """Return the second time derivative of the velocity [length/time^3] at time(s) ``t``."""
        return self._or_before(t, 0.0, -(self.angular_frequency**2) * self.value(t))

    def displacement(self, t: TimeLike) -> np.ndarray:
        """Return the displacement [length] from t = 0 to time(s) ``t``, negative ones included."""
        t = np.asarray(t, dtype=float)
        if not self.oscillates:
            return self._or_before(t, (self.before or 0.0) * t, t * self.cosine)
        half = 0.5 * self.angular_frequency * t
        # sin(w t/2)/(w/2) = t sin(x)/x with x = w t/2
        way = t * np.sinc(half / np.pi) * (self.cosine * np.cos(half) + self.sine * np.sin(half))
        return self._or_before(t, (self.before or 0.0) * t, way)

    def _or_before(self, t: TimeLike, before: Any, value: np.ndarray) -> np.ndarray:
        """Return ``value``, or ``before`` at times before 0 where the velocity jumps at t = 0."""
        return value if self.before is None else np.where(np.asarray(t) < 0, before, value)[()]


class OfComponents:
    """Motion of a body from the motions of its parts: ``x`` and ``y`` of the centre, and ``rotation`` around it."""

    x: Any
    y: Any
    rotation: Any

    def velocity(self, t: float) -> np.ndarray:
        """Return the velocity (2,) of the centre at time ``t``."""
        return np.array([self.x.velocity(t), self.y.velocity(t)])

    def acceleration(self, t: float) -> np.ndarray:
        """Return the acceleration (2,) of the centre at time ``t``."""
        return np.array([self.x.acceleration(t), self.y.acceleration(t)])

    def displacement(self, t: float) -> np.ndarray:
        """Return the displacement (2,) of the centre from t = 0 on."""
        return np.array([self.x.displacement(t), self.y.displacement(t)])

    def travel(self, t: float) -> tuple[np.ndarray, float]:
        """Return the displacement (2,) of the centre and the angle turned around it, from t = 0 on."""
        return self.displacement(t), float(self.rotation.displacement(t))

    def rates(self, t: float) -> tuple[np.ndarray, Any]:
        """Return the velocity (2,) of the centre and the angular velocity at time ``t``."""
        return self.velocity(t), self.rotation.velocity(t)

    def largest_speed(self, radius: float) -> float:
        """Return a bound of the speed of points within ``radius`` [length] of the centre."""
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
    rotation: Any = WallMotion(0.0)


STILL = WallMotion(0.0)
"""A component that is 0."""


REST = RigidMotion()
"""No motion."""


@dataclass(frozen=True)
class Ramp:
    """Velocity ``speed`` + ``slope`` * (t - ``begin``) along a wall [length/time]."""

    oscillates: ClassVar[bool] = True
    stress_controlled: ClassVar[bool] = False

    begin: float
    speed: float
    slope: float

    def velocity(self, t: TimeLike) -> np.ndarray:
        """Return the velocity at time(s) ``t``."""
        return self.speed + self.slope * (np.asarray(t, dtype=float) - self.begin)

    def acceleration(self, t: TimeLike) -> np.ndarray:
        """Return the time derivative of the velocity [length/time^2] at time(s) ``t``."""
        return self.slope + 0.0 * np.asarray(t, dtype=float)

    def jerk(self, t: TimeLike) -> np.ndarray:
        """Return the second time derivative of the velocity, 0, at time(s) ``t``."""
        return 0.0 * np.asarray(t, dtype=float)


@dataclass(frozen=True)
class Schedule:
    """Velocity from t = 0 on: ``velocities`` [length/time] at ``times``, linear in between.

    It is constant before the first of the times and after the last. Two equal times are a jump. There the methods
    return the value before the jump, but at t = 0 the value after it.
    """

    oscillates: ClassVar[bool] = True
    stress_controlled: ClassVar[bool] = False
    before: ClassVar[None] = None
    sine: ClassVar[float] = 0.0
    angular_frequency: ClassVar[float] = 0.0

    times: tuple[float, ...]
    velocities: tuple[float, ...]

    @property
    def cosine(self) -> float:
        """The largest speed, in the place of the amplitude of an oscillation."""
        return self.largest_speed

    @property
    def largest_speed(self) -> float:
        """The largest speed of all times."""
        return max(map(abs, self.velocities))

    @cached_property
    def _pieces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Segments of the velocity: start time, velocity at the start, slope, displacement up to the start.

        The first segment ends at the first time.
        """
        begins = np.array([0.0, *self.times])
        speeds = np.array([self.velocities[0], *self.velocities])
        lengths, rises = np.diff(begins), np.diff(speeds)
        slopes = np.append(np.divide(rises, lengths, out=np.zeros(len(rises)), where=lengths > 0.0), 0.0)
        ways = np.concatenate([[0.0], np.cumsum(lengths * (speeds[:-1] + 0.5 * rises))])
        return begins, speeds, slopes, ways

    def _at(self, t: TimeLike) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return the time since the start of the segment at time(s) ``t``, and its velocity, slope and displacement."""
        t = np.asarray(t, dtype=float)
        piece = np.where(t > 0.0, np.searchsorted(self.times, t), np.searchsorted(self.times, t, side="right"))
        begin, speed, slope, way = (values[piece] for values in self._pieces)
        return t - begin, speed, slope, way

    def velocity(self, t: TimeLike) -> np.ndarray:
        """Return the velocity at time(s) ``t``."""
        since, speed, slope, _ = self._at(t)
        return speed + slope * since

    def acceleration(self, t: TimeLike) -> np.ndarray:
        """Return the time derivative of the velocity [length/time^2] at time(s) ``t``, without jumps."""
        return self._at(t)[2]

    def displacement(self, t: TimeLike) -> np.ndarray:
        """Return the displacement [length] from t = 0 to time(s) ``t``."""
        since, speed, slope, way = self._at(t)
        return way + since * (speed + 0.5 * slope * since)

    def after(self, time: float) -> Ramp:
        """Return the ``Ramp`` that starts at ``time``, continued beyond the next change of slope."""
        piece = int(np.searchsorted(self.times, time, side="right"))
        return Ramp(*(float(values[piece]) for values in self._pieces[:3]))

    @cached_property
    def breakpoints(self) -> list[tuple[float, float, float]]:
        """Time, and jumps of velocity and acceleration, of the start and of all later times at which one jumps."""
        start, slopes = self.after(0.0), self._pieces[2]
        found = [(0.0, float(start.velocity(0.0)), start.slope)]
        for time in sorted({time for time in self.times if time > 0.0}):
            first, after = np.searchsorted(self.times, time), np.searchsorted(self.times, time, side="right")
            jump, bend = self.velocities[after - 1] - self.velocities[first], float(slopes[after] - slopes[first])
            if jump or bend:
                found.append((time, jump, bend))
        return found

    @property
    def jump_times(self) -> tuple[float, ...]:
        """TimeLike above 0 at which velocity or acceleration jump."""
        return tuple(time for time, _, _ in self.breakpoints if time > 0.0)

    def age(self, t: float) -> float:
        """Return the time up to ``t`` since the velocity last jumped, or changed by half the largest speed.

        Infinite where it did neither. At t = 0 it jumps from rest. Kinks are no jumps: with the age of a sine a layer
        is half as thick as the penetration depth, to 1 %, since the age is 1/(2 w).
        """
        times, speeds = np.array([0.0, 0.0, *self.times]), np.array([0.0, self.velocities[0], *self.velocities])
        past = (times < t) | (times == 0.0)
        times, off = np.append(times[past], t), np.append(speeds[past] - self.velocity(t), 0.0)
        changes = times[:-1][(np.diff(times) == 0.0) & (np.diff(off) != 0.0)].tolist()
        half = 0.5 * self.largest_speed
        far = np.flatnonzero((np.abs(off) >= half) & (half > 0.0))
        if len(far):
            last = far[-1]
            part = (abs(off[last]) - half) / abs(off[last] - off[last + 1])
            changes.append(times[last] + part * (times[last + 1] - times[last]))
        return float(t - max(changes, default=-np.inf))

    def relative_to(self, velocity: float) -> "Schedule":
        """Return the schedule in a frame that moves along x with ``velocity``."""
        return replace(self, velocities=tuple(speed - velocity for speed in self.velocities))

    def scaled(self, factor: float) -> "Schedule":
        """Return the schedule with ``factor`` times the velocities."""
        return replace(self, velocities=tuple(speed * factor for speed in self.velocities))

    def penetration_depth(self, kinematic_viscosity: float) -> float:
        """Return infinity: nothing oscillates."""
        return np.inf


@dataclass(frozen=True)
class Drive:
    """Body acceleration g(t) [length/time^2]: ``constant``, plus ``pulsation``, in the place of a velocity.

    ``pulsation`` is an oscillating ``WallMotion``, a ``Schedule``, or None.
    """

    constant: float
    pulsation: Any = None

    @property
    def varies(self) -> bool:
        """Whether g depends on time."""
        return self.pulsation is not None

    @property
    def jump_times(self) -> tuple[float, ...]:
        """Times above 0 at which g, or its slope, jumps."""
        return self.pulsation.jump_times if self.pulsation else ()

    @property
    def largest(self) -> float:
        """The constant g, or a bound of the size of one that varies."""
        return abs(self.constant) + self.pulsation.largest_speed if self.pulsation else self.constant

    def value(self, t: float) -> float:
        """Return g at time ``t``."""
        return self.constant + float(self.pulsation.velocity(t)) if self.pulsation else self.constant

    def slope(self, t: float) -> float:
        """Return dg/dt at time ``t``, without jumps."""
        return float(self.pulsation.acceleration(t)) if self.pulsation else 0.0

    def gained(self, begin: float, end: float) -> float:
        """Return the integral of g [length/time] from the time ``begin`` to ``end``."""
        more = self.pulsation.displacement(end) - self.pulsation.displacement(begin) if self.pulsation else 0.0
        return self.constant * (end - begin) + float(more)

    def jump(self, time: float) -> float:
        """Return the jump of g at a ``time`` above 0."""
        points = self.pulsation.breakpoints if self.pulsation else ()
        return next((jump for when, jump, _ in points if when == time), 0.0)

    def after(self, time: float) -> "Drive":
        """Return g from ``time`` on, continued beyond its next jump."""
        return Drive(self.constant, self.pulsation.after(time)) if self.pulsation else self


@dataclass(frozen=True)
class SmoothSchedule:
    """Velocity from t = 0 on: ``velocities`` [length/time] at ``times``, a cubic spline in between.

    It is constant before the first of the times and after the last; the spline begins and ends without a slope.
    """

    oscillates: ClassVar[bool] = True
    jump_times: ClassVar[tuple[float, ...]] = ()

    times: tuple[float, ...]
    velocities: tuple[float, ...]

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline  # a fifth of a second to import, which only some runs need

        return CubicSpline(self.times, self.velocities, bc_type="clamped")

    def velocity(self, t: TimeLike) -> np.ndarray:
        """Return the velocity at time(s) ``t``."""
        return self._spline(np.clip(t, self.times[0], self.times[-1]))

    def acceleration(self, t: TimeLike) -> np.ndarray:
        """Return the time derivative of the velocity [length/time^2] at time(s) ``t``."""
        return self._spline(np.clip(t, self.times[0], self.times[-1]), 1)


@dataclass(frozen=True)
class StressControlledWall(Oscillation):
    """A wall that starts from rest at t = 0: mass_per_area dU/dt = stress(t) - shear stress of the fluid.

    The external stress on it along x oscillates or is constant. With ``steps``, pairs of a time and the stress from
    then on, it is constant in between, and 0 before the first.
    """

    stress_controlled: ClassVar[bool] = True
    friction: ClassVar[float] = 0.0
    before: ClassVar[None] = None

    mass_per_area: float = 0.0
    steps: tuple[tuple[float, float], ...] = ()

    @classmethod
    def from_config(cls, wall: Any) -> "StressControlledWall":
        """Return the plate that a wall of a channel's config describes."""
        mass = wall.mass_per_area or 0.0
        if wall.stresses is not None:
            return cls(0.0, mass_per_area=mass, steps=tuple(zip(wall.times, wall.stresses, strict=True)))
        if wall.stress_amplitude is None:
            return cls(wall.shear_stress, mass_per_area=mass)
        cosine, sine = (wall.stress_amplitude, 0.0) if wall.phase == "cos" else (0.0, wall.stress_amplitude)
        return cls(cosine, sine, wall.angular_frequency, mass)

    @property
    def jump_times(self) -> tuple[float, ...]:
        """TimeLike above 0 at which the stress jumps."""
        return tuple(time for time, _ in self.steps if time > 0)

    def after(self, time: float) -> "StressControlledWall":
        """Return the plate with the stress that begins at ``time``, continued beyond the next jump."""
        if not self.steps:
            return self
        passed = [stress for begin, stress in self.steps if begin <= time]
        return replace(self, cosine=passed[-1] if passed else 0.0, steps=())

    def stress(self, t: TimeLike) -> np.ndarray:
        """Return the stress at time(s) ``t``."""
        if self.steps:
            times, stresses = zip((-np.inf, 0.0), *self.steps, strict=True)
            return np.asarray(stresses)[np.searchsorted(times, t, side="right") - 1]
        return self.value(t)

    @property
    def largest_stress(self) -> float:
        """The largest size of the stress."""
        return max((abs(stress) for _, stress in self.steps), default=self.amplitude)

    def over(self, density: float) -> "StressControlledWall":
        """Return the plate with stress and mass divided by ``density``."""
        return replace(
            self,
            cosine=self.cosine / density,
            sine=self.sine / density,
            mass_per_area=self.mass_per_area / density,
            steps=tuple((time, stress / density) for time, stress in self.steps),
        )


@dataclass(frozen=True)
class StressControlledMotion:
    """Motion of a ``plate`` in the reference: ``velocity``, a function of time, with ``cosine`` its typical size."""

    oscillates: ClassVar[bool] = True
    stress_controlled: ClassVar[bool] = True
    before: ClassVar[None] = None
    sine: ClassVar[float] = 0.0

    plate: StressControlledWall
    cosine: float
    velocity: Callable[[TimeLike], np.ndarray]

    @property
    def angular_frequency(self) -> float:
        """Angular frequency of the stress."""
        return self.plate.angular_frequency

    def penetration_depth(self, kinematic_viscosity: float) -> float:
        """Return the depth [length] in which the oscillation falls by a factor e."""
        return self.plate.penetration_depth(kinematic_viscosity)


LEVELS = 4
"""Number of stored velocities of a free body, as many as of the particles."""


FREEDOMS = ("x", "y", "angle")
"""Degrees of freedom of a body: its place along both axes, and its angle."""


@dataclass(frozen=True)
class Inertia:
    """``mass`` (3,): mass, mass and moment of inertia around the centre, per length across the plane.

    ``load`` (3,): external force along x and y and torque, weight less buoyancy included. ``velocity`` (3,) before the
    start; ``held`` (3,): whether each of ``FREEDOMS`` stays at that velocity; ``carried`` (3,): whether a body that
    enters has the velocity of the fluid in its place instead. ``displaced``: volume of the displaced fluid, where a
    mean velocity is kept.
    """

    mass: tuple[float, float, float]
    load: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    held: tuple[bool, bool, bool] = (False, False, False)
    carried: tuple[bool, bool, bool] = (False, False, False)
    displaced: float = 0.0


class FreeMotion(OfComponents):
    """Motion like a ``RigidMotion``, of a body with an ``inertia``, at times up to the end of the present step.

    ``times`` and ``velocities`` (3,) of the last levels, newest first: along x and y, and angular. ``way`` (3,):
    displacement from the start to the newest level. ``change`` (3,): acceleration at the start. The largest speed is
    the speed before the start, as later ones are unknown.
    """

    free = True
    tried: Any
    """Velocities (3,) of the last attempt, or None."""

    def __init__(self, inertia: Inertia):
        self.inertia = inertia
        self.x, self.y, self.rotation = (_Component(self, index) for index in range(3))
        self.reset(0.0)

    def reset(self, time: float) -> None:
        """Return to the given place of the body and its velocity before the start, at ``time``."""
        self.way = np.zeros(3)
        self.start(time, self.inertia.velocity)

    def start(self, time: float, velocity: Sequence[float] | np.ndarray) -> None:
        """Begin at ``time`` with a ``velocity`` (3,), from the present place of the body."""
        self.change = np.zeros(3)
        self.times, self.velocities = [float(time)], [np.array(velocity, dtype=float)]
        self._fit()

    def restart(self) -> None:
        """Drop all levels but the newest, after an event at which the motion is not smooth."""
        self.times, self.velocities = self.times[:1], self.velocities[:1]
        self._fit()

    def attempt(self, velocity: np.ndarray) -> None:
        """Store ``velocity`` (3,) as an iterate of the velocity at the end of the present step."""
        self.tried = np.array(velocity, dtype=float)

    def accept(self, time: float) -> None:
        """Append the last ``attempt`` as the newest level, at ``time``."""
        self.way = self.way_at(time)
        self.times = [float(time), *self.times][:LEVELS]
        self.velocities = [self.tried, *self.velocities][:LEVELS]
        self._fit()

    def state(self) -> dict[str, Any]:
        """Return the data that a resumed run needs, as plain numbers."""
        velocities = [velocity.tolist() for velocity in self.velocities]
        return {"times": self.times, "velocities": velocities, "way": self.way.tolist(), "change": self.change.tolist()}

    def restore(self, state: dict[str, Any]) -> None:
        """Set the data that ``state`` returned."""
        self.times, self.velocities = list(state["times"]), [np.array(each) for each in state["velocities"]]
        self.way, self.change = np.array(state["way"]), np.array(state["change"])
        self._fit()

    def _fit(self) -> None:
        """Compute the coefficients (levels, 3) of the polynomial in (t - newest time) / unit, and drop the attempt."""
        self.tried = None
        self.unit = (self.times[0] - self.times[1]) if len(self.times) > 1 else 1.0
        places = (np.array(self.times) - self.times[0]) / self.unit
        self.coefficients = np.linalg.solve(np.vander(places, increasing=True), np.array(self.velocities))

    def _powers(self, time: float) -> tuple[float, np.ndarray]:
        return (time - self.times[0]) / self.unit, np.arange(len(self.coefficients))

    def travel(self, t: float) -> tuple[np.ndarray, float]:
        """Return the displacement (2,) of the centre and the angle turned around it, from t = 0 on."""
        found = self.way_at(t)
        return found[:2], float(found[2])

    def rates(self, t: float) -> tuple[np.ndarray, Any]:
        """Return the velocity (2,) of the centre and the angular velocity at time ``t``."""
        found = self.velocity_at(t)
        return found[:2], found[2]

    def velocity_at(self, time: float) -> np.ndarray:
        """Return the velocities (3,) at ``time``; after the newest level they are the ``attempt``, if there is one."""
        if self.tried is not None and time > self.times[0]:
            return self.tried
        place, power = self._powers(time)
        return place**power @ self.coefficients

    def extrapolated(self, time: float) -> np.ndarray:
        """Return the extrapolated velocities (3,) at ``time``; in the first step by the acceleration at the start."""
        self.tried = None
        first = (time - self.times[0]) * self.change if len(self.times) == 1 else 0.0
        return self.velocity_at(time) + first

    def way_at(self, time: float) -> np.ndarray:
        """Return displacement and angle (3,) from the start to ``time``."""
        place, power = self._powers(time)
        return self.way + self.unit * place * (place**power / (power + 1)) @ self.coefficients

    def change_at(self, time: float) -> np.ndarray:
        """Return the accelerations (3,) at ``time``; at the start those that belong to the first pressure."""
        if len(self.times) == 1:
            return self.change
        place, power = self._powers(time)
        return power[1:] * place ** power[:-1] @ self.coefficients[1:] / self.unit


class _Component:
    """One component of a ``FreeMotion``, with the methods of a ``WallMotion``."""

    oscillates = False

    def __init__(self, motion: FreeMotion, index: int):
        self._motion, self._index = motion, index
        self.largest_speed = abs(motion.inertia.velocity[index])
        """Speed before the start."""

    def velocity(self, t: float) -> float:
        """Return the velocity at time ``t``."""
        return self._motion.velocity_at(t)[self._index]

    def acceleration(self, t: float) -> float:
        """Return the acceleration at time ``t``."""
        return self._motion.change_at(t)[self._index]

    def displacement(self, t: float) -> float:
        """Return the displacement from the start to time ``t``."""
        return self._motion.way_at(t)[self._index]
