"""Motion of a body that the flow carries: found step by step, by whoever solves for it.

Velocities of the centre and around it at the ends of the last steps are the values of a polynomial in time; the
displacement is its integral. So the body moves as the particles do, with the same order, and between steps it is where
the polynomial says.
"""

from dataclasses import dataclass

import numpy as np

from tisph.geometry.motion import OfComponents

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
