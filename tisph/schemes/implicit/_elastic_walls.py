"""What walls prescribe for the mirror images in a liquid with memory.

At a wall the momentum equation ties the solvent's share to the slope of the stress, nu_s u_yy + S_y = a = U' - g, and
the slopes of the conformation obey the law's derivative there,

    C_y' = F_C C_y + F_u' u_yy,    S_y = S_C C_y,    u_yy = (a - S_y) / nu_s,

and so, but for products of slopes, do the third derivatives, with u_yyyy and (u_yy)' in the places of u_yy and a. They
are integrated beside the particles, by the same method; the matrices are those of the liquid at the wall at the
stages, by what it was at the last two steps. The stress has an image of its own, S_I = S_F - 2 d S_d - d^3/3 S_ddd.
"""

import numpy as np

from tisph.schemes.implicit._elastic_stages import weighted
from tisph.schemes.implicit._esdirk import GAMMA, STAGES, TIMES
from tisph.schemes.implicit._walls import WallSeries


class ElasticWalls(WallSeries):
    """Series of both walls; ``first`` and ``third`` (2, components) are C_y and C_yyy at (bottom, top) wall."""

    def __init__(self, channel, treatment, memory):
        super().__init__(channel, treatment)
        self.memory, self.viscosity = memory, channel.solvent_viscosity
        self.first, self.third = (np.zeros((2, memory.components)) for _ in range(2))
        self.steady = False
        self.forget()

    def forget(self):
        """Go back to before the first step."""
        self.moments, self.stages, self.near, self.past = [], [], None, None

    def enter(self, time):
        """Go by the motions from ``time`` on; what the liquid near walls was before says nothing any more."""
        super().enter(time)
        self.past = None

    def begin(self, time, length, near):
        """Integrate over a step from ``time``; ``near`` (2, components + 1): C and shear rate of the liquid there."""
        self.moments = [time + part * length for part in TIMES]
        self.near = time, near
        change = 0.0
        if self.past is not None:
            before, values = self.past
            change = (near - values) / (time - before)
        liquid = [near + (moment - time) * change for moment in self.moments]
        self.stages = [self._integrated(side, length, [values[side] for values in liquid]) for side in range(2)]

    def conclude(self):
        """Take up the state at the end of the step."""
        self.past = self.near
        self.first = np.array([stages[-1][0] for stages in self.stages])
        self.third = np.array([stages[-1][1] for stages in self.stages])

    def host_state(self):
        """Return the numbers that a resumed run needs."""
        past = self.past and (self.past[0], self.past[1].tolist())
        return {"first": self.first.tolist(), "third": self.third.tolist(), "past": past}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        self.first, self.third = np.array(state["first"]), np.array(state["third"])
        self.past = state["past"] and (state["past"][0], np.array(state["past"][1]))

    def _integrated(self, side, length, liquid):
        """Return (C_y, C_yyy, u_yy, u_yyyy, S_y, S_yyy) of one wall at the stages of a step.

        ``liquid``: C and shear rate there at each of them.
        """
        wall, found, rates, third_rates = self.walls[side], [], [], []
        for stage, (moment, values) in enumerate(zip(self.moments, liquid, strict=True)):
            implicit = GAMMA * length if stage else 0.0
            law = AtWall(implicit, self.viscosity, *self.memory.slopes(values[:-1], values[-1]))
            weights = length * np.array(STAGES[stage])
            first, rate, second = law.solve(
                self.first[side] + weighted(weights, rates), wall.acceleration(moment) - self.channel.acceleration
            )
            third, third_rate, fourth = law.solve(
                self.third[side] + weighted(weights, third_rates), law.changed(wall.jerk(moment), rate)
            )
            rates.append(rate)
            third_rates.append(third_rate)
            found.append((first, third, second, fourth, law.stressed(first, second), law.stressed(third, fourth)))
        return found

    def __call__(self, time):
        """Return the series of the (bottom, top) wall at ``time``, one of the stages of the step."""
        if not self.obeys_momentum:
            return [[2.0 * wall.velocity(time), 0.0, 0.0] for wall in self.walls]
        return [self.series(side, stage, time) for side, stage in enumerate(self._at(time))]

    def series(self, side, stage, time):
        """Return the series of one wall, by what there is at the ``stage`` of ``time``."""
        return [2.0 * self.walls[side].velocity(time), stage[2], stage[3] / 12.0]

    def stress_series(self, time):
        """Return the first and third derivatives of S_xy along y at the (bottom, top) wall."""
        if not self.obeys_momentum:
            return [(0.0, 0.0), (0.0, 0.0)]
        return [stage[4:] for stage in self._at(time)]

    def of_states(self, side, component):
        """Return what the images of a component of C have more than their sources, as of the stress."""
        return self.first[side, component], 0.0

    def _at(self, time):
        number = int(np.argmin(np.abs(np.array(self.moments) - time)))
        return [stages[number] for stages in self.stages]


class AtWall:
    """The equations of C_y and u_yy, and of C_yyy and u_yyyy, in a stage, with the law's derivatives at the wall."""

    def __init__(self, implicit, viscosity, decay, pull, stress, instant):
        self.implicit, self.pull, self.stress, self.instant = implicit, pull, stress, instant
        self.viscosity = viscosity + instant
        self.matrix = decay - np.outer(pull, stress) / self.viscosity

    def solve(self, known, driving):
        """Return C_y, its rate, and u_yy, where nu_s u_yy + S_y is ``driving``."""
        source = self.pull * driving / self.viscosity
        slope = np.linalg.solve(np.eye(len(source)) - self.implicit * self.matrix, known + self.implicit * source)
        return slope, self.matrix @ slope + source, (driving - self.stress @ slope) / self.viscosity

    def changed(self, driving_rate, slope_rate):
        """Return (u_yy)', by those of what drives and of C_y: what nu_s u_yyyy + S_yyy is."""
        return (driving_rate - self.stress @ slope_rate) / self.viscosity

    def stressed(self, slope, curvature):
        """Return S_y."""
        return float(self.stress @ slope) + self.instant * curvature
