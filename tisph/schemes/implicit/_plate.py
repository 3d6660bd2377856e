"""A massless wall that a stress drives, for the mirror images of a liquid: ``_elastic_walls.py``, the slope known.

Its velocity is unknown, but the shear rate e = u_y there follows from the stress that the liquid has to take,

    s sigma(e, C) = stress,    sigma = nu_s e + S_xy(C),    s = 1 on the upper wall, -1 on the lower one,

stage by stage and by itself, C being the conformation of the liquid at the wall, which obeys the law for the shear rate
e. Mirror images have the Taylor series that the even terms cancel of,

    u_I = u_F - 2 d u_d - d^3/3 u_ddd,    S_I = 2 S - S_F + d^2 S_dd,

where the momentum equation, differentiated along y, ties nu_s u_yyy + S_yy = e', and C_yy follows as C_y does in
``_elastic_walls.py``.
The velocity of the wall is that of the even polynomial through the particles near it, whose odd terms are known.
"""

import math

import numpy as np

from tisph.errors import DivergedError
from tisph.schemes.implicit._driven_walls import DrivenWall, DrivenWalls
from tisph.schemes.implicit._elastic_stages import weighted
from tisph.schemes.implicit._elastic_walls import AtWall
from tisph.schemes.implicit._esdirk import GAMMA, STAGES

MOST_ITERATIONS = 60
ROUNDING = 1e-13
"""Of the stress, that a massless plate's balance is solved to."""


class PlateWalls(DrivenWalls):
    """Walls one of which is a ``Plate``: ``first`` and ``third`` are C and C_yy there."""

    def __init__(self, channel, treatment, memory):
        super().__init__(channel, treatment, memory, Plate(channel, memory))
        self.any_jump = True

    def begin(self, time, length, near):
        """Integrate the other wall over a step from ``time``, and set out with the plate."""
        self.plate.begin(time, length, self.first[self.plate.side], self.third[self.plate.side])
        super().begin(time, length, near)

    def _integrated(self, side, length, liquid):
        return self.plate.stages if side == self.plate.side else super()._integrated(side, length, liquid)

    def series(self, side, stage, time):
        """Return the series of one wall; of the plate, by its shear rate and the curvature of that."""
        if side != self.plate.side:
            return super().series(side, stage, time)
        return self.plate.series(*stage[2:4])

    def of_states(self, side, component):
        """Return what the images of a component of C have more than their sources, as of the stress."""
        if side != self.plate.side:
            return super().of_states(side, component)
        return self.first[side, component], self.third[side, component]


class Plate(DrivenWall):
    """The wall and the liquid there, over a step.

    ``rate``: shear rate e there, ``change`` its time derivative, at the start of the step. ``stages``: (C, C_yy, e,
    u_yyy, S, S_yy) at those that are done, and at the present one.
    """

    kept = "rate", "change", *DrivenWall.kept

    def forget(self):
        """Go back to before the first step."""
        super().forget()
        self.rate = self.change = 0.0

    def jump(self, time, state):
        """Take up the stress from ``time`` on, where it jumps; return by how much the shear rate does."""
        before, self.known, self.implicit = self.rate, state, 0.0
        self.drive = float(self.wall.during(time).stress(time))
        self.balance(self.rate)
        self.rate = self.now
        _, _, stress, instant = self.memory.slopes(state, self.rate)
        pulled = float(stress @ self.memory.rate(state[:, None], np.array([self.rate]))[:, 0])
        self.change = (-self.towards * float(self.wall.stress_rate(time)) - pulled) / (self.viscosity + instant)
        return self.rate - before

    def begin(self, time, length, state, second):
        """Set out on a step from ``time`` with the liquid's ``state`` C and C_yy there."""
        self.length, self.start_state, self.start_second = length, state, second
        self.stress_of = self.wall.during(time).stress
        self.implicit, self.known, self.now = 0.0, state, self.rate
        self.drive = float(self.stress_of(time))
        self.rates, self.state_rates, self.second_rates = [], [], []
        self.velocities, self.stresses = [self.velocity], []
        self.stages = []
        self.set(self.rate)
        law = self.law()
        _, second_rate, third = law.solve(second, self.change)
        self.stages.append((state, second, self.rate, third, self.own, law.stressed(second, third)))
        self.close(self.change, self.memory.rate(state[:, None], np.array([self.rate]))[:, 0], second_rate)

    def open(self, number, moment):
        """Find the shear rate of an implicit stage at ``moment``."""
        weights = STAGES[number]
        self.implicit = GAMMA * self.length
        self.drive = float(self.stress_of(moment))
        self.known = self.start_state + self.length * weighted(weights, self.state_rates)
        self.known_second = self.start_second + self.length * weighted(weights, self.second_rates)
        self.known_rate = self.rate + self.length * weighted(weights, self.rates)
        self.balance(self.known_rate + self.implicit * self.rates[-1])
        law = self.law()
        second, _, third = law.solve(self.known_second, (self.now - self.known_rate) / self.implicit)
        self.stages.append((self.state, second, self.now, third, self.own, law.stressed(second, third)))

    def set(self, rate):
        """Let the liquid at the wall have a shear ``rate``: sets ``state``, ``total`` stress and its ``slope``."""
        self.now = rate
        state, slope = self.memory.respond(self.known[:, None], self.implicit, np.array([rate]), self.known[:, None])
        self.state = state[:, 0]
        self.own = float(np.ravel(self.memory.shear_stress(state, np.array([rate])))[0])
        self.total, self.slope = self.viscosity * rate + self.own, self.viscosity + float(np.ravel(slope)[0])

    def law(self):
        """Return the equations of what changes across the channel, at the present state."""
        return AtWall(self.implicit, self.viscosity, *self.memory.slopes(self.state, self.now))

    def balance(self, guess):
        """Find the shear rate at which the stress of the liquid is that on the wall."""
        self.set(guess)
        for _ in range(MOST_ITERATIONS):
            missed = self.drive + self.towards * self.total
            if abs(missed) <= ROUNDING * (abs(self.drive) + abs(self.own)):
                return
            self.set(self.now - self.towards * missed / self.slope)
        raise DivergedError("u: no shear rate is found at the wall that the stress drives")

    def series(self, rate, third):
        """Return the series of the images for a shear rate and u_yyy."""
        return [-2.0 * self.towards * rate, -self.towards * third / 3.0, 0.0]

    def at_wall(self, fit, velocity, rate, third):
        """Return the velocity at the wall by the ``fit`` (particles, distance, weights) to ``velocity`` (fluid)."""
        near, distance, weights = fit
        odd = self.towards * (rate * distance + third * distance**3 / 6.0)
        return float(weights @ (velocity[near] - odd))

    def finish(self, velocity):
        """End an implicit stage in which the wall has a ``velocity``."""
        implicit = self.implicit
        self.velocities.append(velocity)
        self.close(
            (self.now - self.known_rate) / implicit,
            (self.state - self.known) / implicit,
            (self.stages[-1][1] - self.known_second) / implicit,
        )

    def close(self, rate, state_rate, second_rate):
        """Keep what a stage has found."""
        self.rates.append(rate)
        self.state_rates.append(state_rate)
        self.second_rates.append(second_rate)
        self.stresses.append(self.total)

    def conclude(self):
        """Take up the state at the end of the step."""
        super().conclude()
        self.rate, self.change = self.now, self.rates[-1]
        if not math.isfinite(self.rate):
            raise DivergedError("u: the shear rate at the wall that a stress drives is no number")
