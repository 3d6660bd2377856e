"""One implicit step of velocity and stress together, in a parallel flow of a liquid with memory.

    u' = nu_s A u + D S_xy(C) + s(t),    C' = F(C, D u),    D = d/dy,

by the stages of ``_esdirk.py``. In a stage C depends on the velocities through D u alone, point by point
(``_memory.py``): linearised, S_xy = S* + t (D u - shear rate*), so that the systems are those of the velocities,
(1 - g nu_s A - g D t D) u = ...; with a law that is linear there is nothing to repeat.
"""

import math

import numpy as np

from tisph.errors import DivergedError
from tisph.neighbours.points import used
from tisph.runtime import real, view
from tisph.schemes.implicit._elastic_wall_force import ElasticWallForce
from tisph.schemes.implicit._elastic_walls import FIT, ElasticWalls
from tisph.schemes.implicit._dense import hermite
from tisph.schemes.implicit._elastic_kick import ElasticKick
from tisph.schemes.implicit._elastic_solver import ElasticSolver
from tisph.schemes.implicit._esdirk import EMBEDDED, GAMMA, STAGES, TIMES, WEIGHTS
from tisph.schemes.implicit._memory import Memory
from tisph.schemes.implicit._viscous import ViscousStep

MOST_REPETITIONS = 12


class ViscoelasticStep(ViscousStep):
    """``ViscousStep`` with the states C of the ``memory`` (components, fluid) and their rates at both ends of a step.

    ``shear_rate`` (fluid): du/dy at the start. ``stress_scale``: what errors of S_xy over the density are counted in.
    """

    def __init__(self, solver, channel, walls, memory):
        super().__init__(solver, channel, walls)
        self.channel, self.memory, self.walls = channel, memory, walls
        fields = (self.points.field(real(), memory.components) for _ in range(6))
        self.state, self.state_end, self.state_rate, self.state_end_rate, self.state_start, self.state_slope = fields
        self.shear_rate, self.mean_stress = (self.points.field(real()) for _ in range(2))
        self.speed_to_stress = channel.kinematic_viscosity / channel.gap
        self.speed = channel.reference_velocity

    def begin_with(self, stress):
        """Take up the stress (3, fluid) at the start, and the slopes at the walls from the liquid near them."""
        used(self.state)[...] = self.memory.state_of(stress)
        used(self.shear_rate)[...] = 0.0
        fits = [fit[:, :-1] for fit in self.fitted(used(self.state), used(self.shear_rate))]
        slopes = [sign * fit[1] / self.ghosts.reach for sign, fit in zip((1.0, -1.0), fits, strict=True)]
        self.walls.first, self.walls.third = np.array(slopes), np.zeros_like(slopes)

    def advance(self, component, time, length, tolerance):
        """Compute the ends of one component, and with the first those of C; return the estimated error."""
        if component == 1:
            return super().advance(component, time, length, tolerance)
        solver, memory, start = self.solver, self.memory, used(self.state)
        implicit = GAMMA * length
        coefficient, sound = implicit * float(view(self.viscosity)), True
        self.walls.begin(time, length, self.near_walls())
        view(solver.x)[: self.points.fluid] = used(self.velocity)[0]
        shear_rate = self.sheared(time)
        self.drive(time, memory.shear_stress(start))
        self.begin(0)
        rates, state = [memory.rate(start, shear_rate)], start
        mean = WEIGHTS[0] * memory.shear_stress(start)
        for stage in range(1, 4):
            moment = time + TIMES[stage] * length
            known = start + length * weighted(STAGES[stage], rates)
            used(self.source)[...] = 0.0
            self.prepare(0, stage, length)
            before = view(solver.b)[: self.points.fluid].copy()
            shear_rate = self.sheared(moment)
            for _ in range(MOST_REPETITIONS):
                state, slope = memory.respond(known, implicit, shear_rate, state)
                stress = memory.shear_stress(state)
                given = self.from_rows(self.rows.across, moment)
                apart = -slope * shear_rate
                apart[self.ghosts.near] += slope[self.ghosts.near] * given
                used(solver.tangent)[...] = implicit * slope
                self.drive(moment, stress + apart)
                view(solver.b)[: self.points.fluid] = before + implicit * used(self.source)
                sound = solver.solve(coefficient, tolerance) and sound
                found = self.sheared(moment)
                expected, shear_rate = stress + slope * (found - shear_rate), found
                state, slope = memory.respond(known, implicit, shear_rate, state)
                stress = memory.shear_stress(state)
                missed = math.sqrt(np.mean((stress - expected) ** 2)) / self.speed_to_stress
                if not missed > tolerance * self.speed:
                    break
            rates.append((state - known) / implicit)
            mean += WEIGHTS[stage] * stress
        self.conclude(0, length)
        used(self.state_end)[...], used(self.state_end_rate)[...] = state, rates[-1]
        used(self.state_rate)[...], used(self.shear_rate)[...] = rates[0], shear_rate
        used(self.mean_stress)[...] = mean
        return (
            self.error(implicit, length * weighted(np.subtract(WEIGHTS, EMBEDDED), rates), slope)
            if sound
            else float("nan")
        )

    def accept(self):
        """Take up the end of the step as the start of the next, on the particles and at the walls.

        Raises DivergedError where a polymer has lost the positive conformation that it has in nature.
        """
        super().accept()
        lost = self.memory.lost(used(self.state_end))
        if lost.size:
            raise DivergedError(
                f"stress: the conformation tensor of particle {lost[0]} is not positive definite any more "
                f"({lost.size} particles are wrong)"
            )
        used(self.state_start)[...] = used(self.state)
        used(self.state)[...] = used(self.state_end)
        self.walls.conclude()
        slopes = self.walls.first_images(self.ghosts)
        for slope, state, more in zip(used(self.state_slope), used(self.state), slopes, strict=True):
            slope[...] = self.solver.slopes(state, 1.0)
            slope[self.ghosts.near] += self.ghosts.sums(self.rows.across, more[self.ghosts.listed])[0]

    def kick(self):
        """Return what gives the impulse of walls that start at once."""
        return ElasticKick(self)

    def follow(self, moved, across):
        """Let the states follow, by their slopes across the channel."""
        used(self.state)[:, moved] += used(self.state_slope)[:, moved] * across

    def stress(self):
        """Return S_xx, S_xy, S_yy over the density, (3, fluid)."""
        return self.memory.stress(used(self.state).astype(float))

    def stress_at(self, part, length):
        """Return ``stress`` at a ``part`` of the last step, of ``length``: cubic in the states."""
        start, end, start_rate, end_rate = (
            used(field).astype(float) for field in (self.state_start, self.state, self.state_rate, self.state_end_rate)
        )
        return self.memory.stress(hermite(part, length, start, end, start_rate, end_rate))

    def error(self, implicit, defect, slope):
        """Return the root mean square of the estimated errors of u and of S_xy in units of the velocity."""
        solver, state = self.solver, used(self.state_end)
        pull = self.memory.linear(state, implicit, used(self.shear_rate), defect)
        view(solver.b)[: self.points.fluid] += implicit * self.solver.slopes(pull, 1.0)
        used(solver.tangent)[...] = implicit * slope
        if not solver.solve(implicit * float(view(self.viscosity)), 1e-2):
            return float("nan")
        velocity = view(solver.x)[: self.points.fluid].copy()
        stress = pull + slope * solver.slopes(velocity, -1.0)
        return math.sqrt(np.mean(velocity**2) + np.mean(stress**2) / self.speed_to_stress**2)

    def drive(self, time, stress):
        """Evaluate what drives the velocities: walls, acceleration, and the divergence of ``stress`` and its images."""
        self.set_source(0, time)
        source, ghosts = used(self.source), self.ghosts
        source += self.solver.slopes(stress, 1.0)
        for side, series in enumerate(self.walls.stress_series(time)):
            source += self.from_images(side, *series)

    def from_images(self, side, slope, third):
        """Return what images of S_xy beyond one wall have more, by its first and third derivatives there, in D S."""
        sums = np.zeros(self.points.fluid)
        more = self.images(side, slope, third)
        sums[self.ghosts.near] = self.ghosts.sums(self.rows.across, more[self.ghosts.listed])[0]
        return sums

    def images(self, side, slope, third):
        """Return what each image beyond one wall has of S_xy more than its source, (ghosts)."""
        ghosts, sign = self.ghosts, 1.0 if side == 0 else -1.0
        return sign * np.where(ghosts.side == side, ghosts.depth * (-2.0 * slope - ghosts.depth**2 / 3.0 * third), 0.0)

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {"first": self.walls.first.tolist(), "third": self.walls.third.tolist()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        self.walls.first, self.walls.third = np.array(state["first"]), np.array(state["third"])

    def wall_force(self):
        """Return what measures the impulses of the walls."""
        return ElasticWallForce(self, self.channel)

    def sheared(self, time):
        """Return du/dy of the velocities in ``solver.x`` at ``time``."""
        rate = self.solver.slopes(view(self.solver.x)[: self.points.fluid], -1.0).copy()
        rate[self.ghosts.near] += self.from_rows(self.rows.across, time)
        return rate

    def from_rows(self, rows, time):
        """Return what the walls' series at ``time`` give a derivative of the velocities, for the near particles."""
        self.ghosts.prescribe(*self.wall_series(time))
        return self.ghosts.sums(rows, self.ghosts.given()[self.ghosts.listed])[0]

    def near_walls(self):
        """Return (C, du/dy) of the liquid at each wall, by polynomials through what is near."""
        return [(fit[0, :-1], fit[0, -1]) for fit in self.fitted(used(self.state), used(self.shear_rate))]

    def fitted(self, state, shear_rate):
        """Return the coefficients (power, quantity) of polynomials in the distance from the (bottom, top) wall."""
        ghosts, values = self.ghosts, np.vstack([state, shear_rate])[:, self.ghosts.near].T
        for offset in ghosts.offset:
            close = offset < ghosts.reach
            powers = (offset[close, None] / ghosts.reach) ** np.arange(FIT)
            yield np.linalg.lstsq(powers, values[close], rcond=None)[0]


def weighted(weights, rates):
    """Return the sum of the ``rates`` so far, each with its weight."""
    return sum(weight * rate for weight, rate in zip(weights, rates, strict=False))


def step(config, channel, rows, ghosts):
    """Return the step of a liquid whose rheology carries a stress."""
    memory = Memory(config.fluid.rheology, channel.kinematic_viscosity)
    walls = ElasticWalls(channel, config.walls.treatment.type, memory)
    return ViscoelasticStep(ElasticSolver(rows, ghosts), channel, walls, memory)
