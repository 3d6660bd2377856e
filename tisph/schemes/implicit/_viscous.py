"""One implicit step of the velocities, u' = nu A u + s(t), on a fixed arrangement of points (see ``_esdirk.py``)."""

import math

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import holding, real, scalar, ti, view
from tisph.schemes.implicit._esdirk import EMBEDDED, GAMMA, STAGES, TIMES, WEIGHTS, guesses
from tisph.schemes.implicit._kick import Kick
from tisph.schemes.implicit._wall_force import WallForce


@ti.data_oriented
class ViscousStep:
    """Advances one component of the velocity at a time by ``solver``'s rows.

    ``velocity`` and ``end`` (2, fluid): at the start and at the end of the step, along and across the channel;
    ``start_rate``, ``end_rate`` their time derivatives there. ``wall_series(time)``: the ghosts' series of both walls.
    ``mean`` (slots + 1): the component's velocities over the step, the integral over its length. ``push``: what else is
    to be added to the sources of a component, None for nothing.
    """

    def __init__(self, solver, channel, wall_series):
        self.solver, self.operators, self.points, self.ghosts = solver, solver.operators, solver.points, solver.ghosts
        self.wall_series, self.steady = wall_series, wall_series.steady
        self.channel, self.push = channel, None
        self.velocity, self.end, self.start_rate, self.end_rate = (self.points.field(real(), 2) for _ in range(4))
        self.rates = self.points.field(real(), 4)
        self.known, self.source = self.points.field(real()), self.points.field(real())
        self.mean = ti.field(real(), self.points.slots + 1)
        for scratch in (self.rates, self.known, self.mean):
            scratch.used = None  # for checkpoints
        self.tableau, self.guesses = (
            holding(ti.field(real(), (4, 4)), STAGES),
            holding(ti.field(real(), (4, 4)), guesses()),
        )
        self.weights = holding(ti.field(real(), 4), WEIGHTS)
        self.defect = holding(ti.field(real(), 4), np.subtract(WEIGHTS, EMBEDDED))
        self.viscosity = scalar(channel.solvent_viscosity)
        self.acceleration = channel.acceleration

    def advance(self, component, time, length, tolerance):
        """Compute ``end`` of one component; return the estimated error (root mean square), NaN where none was found."""
        coefficient, sound = GAMMA * length * float(view(self.viscosity)), True
        driven = component == 0
        if driven:
            self.solver.assemble()
        self.set_source(component, time)
        self.begin(component)
        for stage in range(1, 4):
            if driven and not self.steady:
                self.set_source(component, time + TIMES[stage] * length)
            self.prepare(component, stage, length)
            sound = self.solver.solve(coefficient, tolerance) and sound
        self.conclude(component, length)
        sound = self.solver.solve(coefficient, 1e-2) and sound
        error = view(self.solver.x)[: self.points.fluid]
        return math.sqrt(np.einsum("i,i", error, error, dtype=float) / error.size) if sound else float("nan")

    def accept(self):
        """Take up the end of the step as the start of the next."""
        active(self.velocity)[...] = active(self.end)

    def turn(self, time):
        """Let walls that change at once at ``time`` give their impulse; return what is gained from each: ``Kick``."""
        series = self.wall_series
        series.enter(time)
        return Kick(self).apply(*series.jumps_at(time)) if series.obeys_momentum else [0.0, 0.0]

    def begin_with(self, heights):
        """Take up what else particles at ``heights`` (fluid,) carry when a run starts: nothing here."""

    def wall_force(self):
        """Return what measures the impulses of the walls."""
        return WallForce(self, self.channel)

    def stress(self):
        """Return the stresses over the density that particles carry, (3, fluid), or none, ()."""
        return ()

    def stress_at(self, part, length):
        """Return ``stress`` at a ``part`` of the last step, of ``length``."""
        return ()

    def lost(self):
        """Return the particles whose conformation is not positive definite at the end of the step."""
        return np.zeros(0, dtype=int)

    def parts(self):
        """Return by name what a checkpoint keeps beside the fields here."""
        return {}

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``, among others."""

    def follow(self, moved, across):
        """Let what else particles carry follow those that were ``moved`` by ``across``: nothing here."""

    def set_source(self, component, time):
        """Evaluate what drives a component at ``time``: the walls' part of the ghosts, body acceleration, pressure."""
        source = active(self.source)
        source[...] = 0.0  # across the channel nothing drives
        if component == 0:
            self.ghosts.prescribe(*self.wall_series(time))
            source[...] = self.acceleration
            source[self.ghosts.near] += view(self.viscosity) * self.from_walls()
        if self.push:
            self.push(component)

    def from_walls(self):
        """Return the Laplacian of what the series prescribes for the ghosts, for the particles near walls."""
        return self.ghosts.sums(self.operators.laplacian, self.ghosts.given()[self.ghosts.listed])[0]

    @ti.kernel
    def begin(self, component: ti.i32):
        """The explicit stage: rates at the start of the step."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(particles):
            self.solver.x[i] = self.velocity[component, i]
        ti.loop_config(serialize=True)
        for k in range(self.ghosts.count[None]):
            self.solver.reflect(self.solver.x, k)
        ti.loop_config(serialize=self.operators.serial_light)
        for i in range(particles):
            viscous = self.viscosity[None] * self.operators.apply(self.operators.laplacian, self.solver.x, i)
            self.rates[0, i] = viscous + self.source[i]
            self.start_rate[component, i] = viscous + self.source[i]
            self.mean[i] = self.weights[0] * self.solver.x[i]

    @ti.kernel
    def prepare(self, component: ti.i32, stage: ti.i32, length: float):
        """Right side of an implicit stage; the guess is what the rates so far lead to."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(particles):
            if stage > 1:
                self.finish(i, stage - 1, length)
            known = self.velocity[component, i]
            guess = known
            for before in range(stage):
                change = length * self.rates[before, i]
                known += self.tableau[stage, before] * change
                guess += self.guesses[stage, before] * change
            self.known[i] = known
            self.solver.b[i] = known + GAMMA * length * self.source[i]
            self.solver.x[i] = guess

    @ti.func
    def finish(self, i, stage, length):
        """Rate of particle ``i`` in a stage, from its solution."""
        self.rates[stage, i] = (self.solver.x[i] - self.known[i]) / (GAMMA * length)
        self.mean[i] += self.weights[stage] * self.solver.x[i]

    @ti.kernel
    def conclude(self, component: ti.i32, length: float):
        """Keep the last stage, which is the end of the step; set up the filter of the error."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.operators.serial_numbers)
        for i in range(particles):
            self.finish(i, 3, length)
            self.end[component, i] = self.solver.x[i]
            self.end_rate[component, i] = self.rates[3, i]
            defect = 0.0
            for stage in range(4):
                defect += length * self.defect[stage] * self.rates[stage, i]
            self.solver.b[i] = defect
            self.solver.x[i] = 0.0
