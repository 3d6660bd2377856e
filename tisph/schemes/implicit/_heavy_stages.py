"""Stages of a step in which the velocity of a wall is unknown: ``_elastic_stages.py`` with one number more.

With the wall's velocity U the velocities of a stage are u_a + (U - U*) w, both by the same matrix: u_a those of the
present U*, w the response to one more. The wall's momentum balances at one U (``_heavy.py``). Laws that are linear need
one solution of each; others repeat both, as the stages between walls of given velocities do.
"""

import math

import numpy as np

from tisph.schemes.implicit._driven_stages import DrivenStages


class HeavyStages(DrivenStages):
    """Advances a ``Flow`` between ``HeavyWalls``."""

    def advance(self, start, time, length, tolerance):
        """Advance by a step; see ``ElasticStages.advance``."""
        self.response = np.zeros_like(start.velocity)
        return super().advance(start, time, length, tolerance)

    def prepare(self, start, time):
        """Find the wall's acceleration at the start of a step, by the stress of the liquid there."""
        plate, rate = self.plate, 0.0
        plate.open(0, time)
        plate.accelerate(plate.velocity, rate)
        total, pulls = [], (0.0, 1.0)  # all is linear in the acceleration
        for rate in pulls:
            plate.accelerate(plate.velocity, rate)
            shear_rate = self.sheared(start.velocity, time)
            stress = self.viscosity * shear_rate + self.memory.shear_stress(start.state, shear_rate)
            total.append(plate.at_wall(self.fit, stress, rate - self.acceleration))
        rate = (plate.drive + plate.towards * total[0]) / (plate.mass - plate.towards * (total[1] - total[0]))
        plate.accelerate(plate.velocity, rate)
        plate.finish(total[0] + rate * (total[1] - total[0]))

    def matched(self, velocity, shear_rate, stress, *system):
        """Let the wall have the velocity at which its momentum balances; see ``ElasticStages.matched``."""
        _, slope, _ = system
        sheared = self.responded(*system)
        if sheared is None:
            return None
        change, self.total = self.balanced(stress, shear_rate, slope, sheared)
        self.plate.set(self.plate.now + change)
        return velocity + change * self.response, shear_rate + change * sheared, stress + change * slope * sheared

    def at_plate(self, velocity):
        """Return the stress of the liquid at the wall."""
        return self.total

    def balanced(self, stress, shear_rate, slope, sheared):
        """Return by how much the wall's velocity is to change, and the stress of the liquid at the wall then.

        ``stress`` of the particles' memory, their ``shear_rate``, the ``slope`` of the first by the second, and by how
        much the shear rate changes with the wall's velocity.
        """
        plate = self.plate
        total = plate.at_wall(self.fit, self.viscosity * shear_rate + stress, plate.rate - self.acceleration)
        more = plate.at_wall(self.fit, (self.viscosity + slope) * sheared, 1.0 / plate.implicit)
        change = plate.correction(total, more)
        return change, total + change * more

    def responded(self, implicit, slope, tolerance):
        """Find the ``response`` of the velocities to that of the wall; return that of the shear rates, or None."""
        operators, side = self.operators, self.plate.side
        own, stress = self.plate.response()
        series = [[0.0] * 3, [0.0] * 3]
        series[side] = own
        given = operators.given("d_dy", series)
        right = self.viscosity * operators.given("laplacian", series)
        right += operators.slopes(slope * given, 1.0) + operators.images(side, *stress)
        found = operators.answer(
            implicit * self.viscosity, implicit * slope, implicit * right, self.response, tolerance
        )
        if found is None:
            return None
        self.response = found
        return operators.slopes(found, -1.0) + given

    def error(self, end, implicit, slope, defect, state_defect):
        """Return the estimated error, that of the plate's velocity included."""
        return math.hypot(super().error(end, implicit, slope, defect, state_defect), self.plate.defect)
