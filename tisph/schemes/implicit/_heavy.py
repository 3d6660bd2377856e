"""A wall with a mass that a stress drives: ``_elastic_walls.py`` with a velocity that is found with the liquid's.

    mass U' = stress - s sigma,    s = 1 on the upper wall, -1 on the lower one,

sigma being the shear stress of the liquid at the wall: that of the even polynomial through the stresses of the
particles near it, whose slope there the momentum equation gives, sigma_y = U' - g. In a stage U' = (U - known)/(gamma
h), so that all that the wall prescribes is linear in U. What the images have of U'' is left out: it is of fourth order.
"""

import numpy as np

from tisph.schemes.implicit._driven_walls import DrivenWall, DrivenWalls
from tisph.schemes.implicit._elastic_stages import DEFECT, weighted
from tisph.schemes.implicit._elastic_walls import AtWall
from tisph.schemes.implicit._esdirk import GAMMA, STAGES


class HeavyWalls(DrivenWalls):
    """Walls one of which is a ``HeavyPlate``."""

    def __init__(self, channel, treatment, memory):
        super().__init__(channel, treatment, memory, HeavyPlate(channel, memory))

    def _jumps(self):
        """Jumps at the start: at first the stress has only the wall to accelerate."""
        velocities, rates = super()._jumps()
        rates[self.plate.side] = self.plate.jump(0.0)
        return velocities, rates

    def _later_jumps(self, time):
        velocities, rates = super()._later_jumps(time)
        rates[self.plate.side] = self.plate.jump(time)
        return velocities, rates

    def begin(self, time, length, near):
        """Integrate the other wall over a step from ``time``, and set out with the plate."""
        self.plate.begin(time, length)
        super().begin(time, length, near)

    def _integrated(self, side, length, liquid):
        if side != self.plate.side:
            return super()._integrated(side, length, liquid)
        return self.plate.set_out(self.first[side], self.third[side], liquid)

    def series(self, side, stage, time):
        """Return the series of one wall, by what there is at the ``stage`` of ``time``."""
        if side != self.plate.side:
            return super().series(side, stage, time)
        return [2.0 * stage[-1], stage[2], stage[3] / 12.0]

    def stress_series(self, time):
        """Return the first and third derivatives of S_xy along y at the (bottom, top) wall."""
        return [stage[4:6] for stage in self._at(time)]


class HeavyPlate(DrivenWall):
    """The wall over a step.

    ``stages``: (C_y, C_yyy, u_yy, u_yyyy, S_y, S_yyy, U) at those that are done, and at the present one.
    """

    def __init__(self, channel, memory):
        super().__init__(channel, memory)
        self.mass, self.body = self.wall.mass_per_area, channel.acceleration

    def jump(self, time):
        """Return by how much the acceleration jumps with the stress at ``time``."""
        before = 0.0 if time == 0.0 else float(self.wall.during(np.nextafter(time, 0.0)).stress(time))
        return (float(self.wall.during(time).stress(time)) - before) / self.mass

    def begin(self, time, length):
        """Set out on a step from ``time``."""
        self.length, self.stress_of = length, self.wall.during(time).stress

    def set_out(self, first, third, liquid):
        """Take up C_y and C_yyy at the wall, and C and shear rate of the ``liquid`` there at each stage."""
        self.first, self.third, self.liquid = first, third, liquid
        self.rates, self.first_rates, self.third_rates, self.velocities, self.stresses = [], [], [], [], []
        self.stages = []
        return self.stages

    def open(self, number, moment):
        """Begin a stage at ``moment``, with the velocity that the rates so far lead to."""
        weights, values = STAGES[number], self.liquid[number]
        self.implicit = GAMMA * self.length if number else 0.0
        self.drive = float(self.stress_of(moment))
        self.law = AtWall(self.implicit, self.viscosity, *self.memory.slopes(values[:-1], values[-1]))
        self.known = self.velocity + self.length * weighted(weights, self.rates)
        self.known_first = self.first + self.length * weighted(weights, self.first_rates)
        self.known_third = self.third + self.length * weighted(weights, self.third_rates)
        self.stages.append(None)
        if number:
            self.set(self.known + self.implicit * self.rates[-1])

    def accelerate(self, velocity, rate):
        """Let the wall have a ``velocity`` and its time derivative ``rate`` in the present stage."""
        law, self.now, self.rate = self.law, velocity, rate
        first, self.first_rate, second = law.solve(self.known_first, rate - self.body)
        third, self.third_rate, fourth = law.solve(self.known_third, law.changed(0.0, self.first_rate))
        stressed = law.stressed(first, second), law.stressed(third, fourth)
        self.stages[-1] = (first, third, second, fourth, *stressed, velocity)

    def set(self, velocity):
        """Let the wall have a ``velocity`` in the present implicit stage."""
        self.accelerate(velocity, (velocity - self.known) / self.implicit)

    def response(self):
        """Return the series of the images, and S_y and S_yyy, for one more of the velocity."""
        law, nothing = self.law, np.zeros_like(self.known_first)
        first, rate, second = law.solve(nothing, 1.0 / self.implicit)
        third, _, fourth = law.solve(nothing, law.changed(0.0, rate))
        return [2.0, second, fourth / 12.0], (law.stressed(first, second), law.stressed(third, fourth))

    def at_wall(self, fit, stress, rate):
        """Return the stress at the wall by the ``fit`` (particles, distance, weights) to ``stress`` (fluid).

        ``rate``: of the wall's velocity, less the body acceleration.
        """
        near, distance, weights = fit
        return float(weights @ (stress[near] - self.towards * rate * distance))

    def correction(self, total, slope):
        """Return by how much the velocity is to change for the momentum to balance.

        ``total`` is the stress of the liquid at the wall, ``slope`` its derivative by the velocity.
        """
        missed = self.mass * self.rate - self.drive - self.towards * total
        return -missed / (self.mass / self.implicit - self.towards * slope)

    def finish(self, total):
        """End a stage in which the liquid has the ``total`` stress at the wall."""
        self.rates.append(self.rate)
        self.first_rates.append(self.first_rate)
        self.third_rates.append(self.third_rate)
        self.velocities.append(self.now)
        self.stresses.append(total)

    @property
    def defect(self):
        """What second and third order differ by in the velocity."""
        return self.length * weighted(DEFECT, self.rates)
