"""One implicit step of the velocities, u' = nu A u + s(t), on a fixed arrangement of points (see ``_esdirk.py``)."""

import numpy as np

from tisph.runtime import real, scalar, ti
from tisph.schemes.implicit._esdirk import EMBEDDED, GAMMA, STAGES, TIMES, WEIGHTS, guesses


@ti.data_oriented
class ViscousStep:
    """Advances one component of the velocity at a time by ``solver``'s rows.

    ``velocity`` and ``end`` (2, fluid): at the start and at the end of the step, along and across the channel;
    ``start_rate``, ``end_rate`` their time derivatives there. ``wall_series(time)``: the ghosts' series of both walls.
    ``mean`` (slots + 1): the component's velocities over the step, the integral over its length. ``push``: what else is
    to be added to the sources of a component, None for nothing.
    """

    def __init__(self, solver, channel, wall_series):
        self.solver, self.rows, self.points, self.ghosts = solver, solver.rows, solver.points, solver.ghosts
        self.wall_series, self.steady = wall_series, wall_series.steady
        self.push = None
        self.fluid = solver.fluid
        shape = (2, self.fluid)
        self.velocity, self.end, self.start_rate, self.end_rate = (ti.field(real(), shape) for _ in range(4))
        self.rates = ti.field(real(), (4, self.fluid))
        self.known, self.source = (ti.field(real(), self.fluid) for _ in range(2))
        self.data, self.mean = (ti.field(real(), self.points.slots + 1) for _ in range(2))
        self.stages, self.weights, self.defect = ti.field(real(), (4, 4)), ti.field(real(), 4), ti.field(real(), 4)
        self.stages.from_numpy(np.array(STAGES))
        self.guesses = ti.field(real(), (4, 4))
        self.guesses.from_numpy(guesses())
        self.weights.from_numpy(np.array(WEIGHTS))
        self.defect.from_numpy(np.array(WEIGHTS) - np.array(EMBEDDED))
        self.viscosity = scalar(channel.kinematic_viscosity)
        self.acceleration = channel.acceleration
        self.error = scalar(0.0)

    def advance(self, component, time, length, tolerance):
        """Compute ``end`` of one component; return the estimated error (root mean square), NaN where none was found."""
        coefficient, sound = GAMMA * length * self.viscosity[None], True
        driven = component == 0
        self.set_source(component, time)
        self.begin(component)
        for stage in range(1, 4):
            if driven and not self.steady:
                self.set_source(component, time + TIMES[stage] * length)
            self.prepare(component, stage, length)
            sound = self.solver.solve(coefficient, tolerance) and sound
            self.finish(stage, length)
        self.conclude(component, length)
        sound = self.solver.solve(coefficient, 1e-2) and sound
        self.measure_error()
        return self.error[None] if sound else float("nan")

    def set_source(self, component, time):
        """Evaluate what drives a component at ``time``: the walls' part of the ghosts, body acceleration, pressure."""
        if component == 0:
            self.ghosts.lay(self.data, *self.wall_series(time))
        self.gather_source(float(component == 0), self.acceleration)
        if self.push:
            self.push(component)

    @ti.kernel
    def gather_source(self, driven: float, acceleration: float):
        """Sum the sources; ``driven`` is 0 across the channel, where nothing drives."""
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            walls = self.rows.apply(self.rows.laplacian, self.data, i)
            self.source[i] = driven * (self.viscosity[None] * walls + acceleration)

    @ti.kernel
    def begin(self, component: ti.i32):
        """The explicit stage: rates at the start of the step."""
        ti.loop_config(serialize=self.rows.serial_numbers)
        for i in range(self.fluid):
            self.solver.x[i] = self.velocity[component, i]
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.solver.reflect(self.solver.x, k)
        ti.loop_config(serialize=self.rows.serial_light)
        for i in range(self.fluid):
            viscous = self.viscosity[None] * self.rows.apply(self.rows.laplacian, self.solver.x, i)
            self.rates[0, i] = viscous + self.source[i]
            self.start_rate[component, i] = viscous + self.source[i]
            self.mean[i] = self.weights[0] * self.solver.x[i]

    @ti.kernel
    def prepare(self, component: ti.i32, stage: ti.i32, length: float):
        """Right side of an implicit stage; the guess is what the rates so far lead to."""
        ti.loop_config(serialize=self.rows.serial_numbers)
        for i in range(self.fluid):
            known = self.velocity[component, i]
            guess = known
            for before in range(stage):
                change = length * self.rates[before, i]
                known += self.stages[stage, before] * change
                guess += self.guesses[stage, before] * change
            self.known[i] = known
            self.solver.b[i] = known + GAMMA * length * self.source[i]
            self.solver.x[i] = guess

    @ti.kernel
    def finish(self, stage: ti.i32, length: float):
        """Rates of a stage from its solution."""
        ti.loop_config(serialize=self.rows.serial_numbers)
        for i in range(self.fluid):
            self.rates[stage, i] = (self.solver.x[i] - self.known[i]) / (GAMMA * length)
            self.mean[i] += self.weights[stage] * self.solver.x[i]

    @ti.kernel
    def conclude(self, component: ti.i32, length: float):
        """Keep the last stage, which is the end of the step; set up the filter of the error."""
        ti.loop_config(serialize=self.rows.serial_numbers)
        for i in range(self.fluid):
            self.end[component, i] = self.solver.x[i]
            self.end_rate[component, i] = self.rates[3, i]
            defect = 0.0
            for stage in range(4):
                defect += length * self.defect[stage] * self.rates[stage, i]
            self.solver.b[i] = defect
            self.solver.x[i] = 0.0

    @ti.kernel
    def measure_error(self):
        """Root mean square of the filtered error."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            total = 0.0
            for i in range(self.fluid):
                total += self.solver.x[i] * self.solver.x[i]
            self.error[None] = ti.sqrt(total / self.fluid)
