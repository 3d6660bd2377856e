"""One implicit step of velocity and stress together, in a parallel flow of a liquid with memory.

    u' = nu_s A u + D S_xy(C) + s(t),    C' = F(C, D u),    D = d/dy,

by the stages of ``_esdirk.py``. In a stage C depends on the velocities through D u alone, point by point
(``_memory.py``): linearised, S_xy = S* + t (D u - shear rate*), so that the systems are those of the velocities,
(1 - g nu_s A - g D t D) u = ...; with a law that is linear there is nothing to repeat.

What A and D are is left to ``operators``: rows of particles (``_elastic_solver.py``), or of the start lattice
(``schemes/_forecast/elastic_rows.py``). They have

    laplacian(values), slopes(values, parity)  A and D, of values whose mirror images have ``parity`` times theirs
    given(name, series)                        what the walls' series of velocities add to "laplacian" or "d_dy"
    images(side, slope, third)                 what D S has more by the derivatives of the stress at a wall
    solve(coefficient, tangent, right, guess, tolerance)  (1 - coefficient A - D tangent D) x = right; None if it fails
    at_walls(values)                           coefficients of polynomials in the distance from the (bottom, top) wall
"""

import math
from dataclasses import dataclass

import numpy as np

from tisph.schemes.implicit._elastic_kick import kick
from tisph.schemes.implicit._esdirk import EMBEDDED, GAMMA, STAGES, TIMES, WEIGHTS, guesses

FIT = 3
"""Terms of the polynomial in the distance that the liquid near a wall is described by."""

EVEN = (0, 2, 4)
"""Powers of the distance in what is fitted for a value at a driven wall."""

MOST_REPETITIONS = 12
ROUNDING = 1e-11
"""Of the stress, which is left when a stage is solved."""

NEAR, TERMS = 0.1, 8
"""Part of the gap, and terms of a polynomial in it, by which the slopes of the start at the walls are taken."""

DEFECT = np.subtract(WEIGHTS, EMBEDDED)
GUESSES = guesses()


@dataclass
class Flow:
    """Velocities (n), states C (components, n) and shear rates (n), with the rates of the first two."""

    velocity: np.ndarray
    state: np.ndarray
    shear_rate: np.ndarray
    velocity_rate: np.ndarray | None = None
    state_rate: np.ndarray | None = None


class ElasticStages:
    """Advances a ``Flow`` of a ``channel``; ``walls`` are ``ElasticWalls``.

    ``mean_velocity`` and ``mean_stress`` (n): integrals over the last step, over its length.
    """

    def __init__(self, operators, channel, walls, memory):
        self.operators, self.walls, self.memory = operators, walls, memory
        self.viscosity, self.acceleration = channel.solvent_viscosity, channel.acceleration
        self.speed = channel.reference_velocity
        self.stress_of_speed = channel.kinematic_viscosity / channel.gap
        self.mean_velocity = self.mean_stress = None

    def advance(self, start, time, length, tolerance):
        """Return the ``Flow`` after a step and the estimated error.

        None and NaN where a linear system cannot be solved, infinite where the stress does not follow the shear rate.

        The rates of ``start`` are set. The error is the root mean square of those of u, and of S_xy over the viscosity
        per gap.
        """
        memory, implicit = self.memory, GAMMA * length
        self.walls.begin(time, length, self.near_walls(start))
        self.prepare(start, time)
        shear_rate = self.sheared(start.velocity, time)
        stress = memory.shear_stress(start.state, shear_rate)
        viscous = self.viscosity * self.operators.laplacian(start.velocity)
        rates = [viscous + self.drive(time, stress)]
        state_rates = [memory.rate(start.state, shear_rate)]
        start.velocity_rate, start.state_rate = rates[0], state_rates[0]
        velocity, state, slope = start.velocity, start.state, None
        mean_velocity, mean_stress = WEIGHTS[0] * velocity, WEIGHTS[0] * stress
        for stage in range(1, 4):
            known = start.velocity + length * weighted(STAGES[stage], rates)
            known_state = start.state + length * weighted(STAGES[stage], state_rates)
            guess = start.velocity + length * weighted(GUESSES[stage], rates)
            moment = time + TIMES[stage] * length
            found, missed = self.solved(known, known_state, guess, state, moment, implicit, tolerance)
            if found is None:
                return None, missed
            velocity, state, shear_rate, stress, slope = found
            rates.append((velocity - known) / implicit)
            state_rates.append((state - known_state) / implicit)
            mean_velocity, mean_stress = (
                mean_velocity + WEIGHTS[stage] * velocity,
                mean_stress + WEIGHTS[stage] * stress,
            )
        self.mean_velocity, self.mean_stress = mean_velocity, mean_stress
        end = Flow(velocity, state, shear_rate, rates[-1], state_rates[-1])
        return end, self.error(
            end, implicit, slope, length * weighted(DEFECT, rates), length * weighted(DEFECT, state_rates)
        )

    def turn(self, flow, time):
        """Let walls that change at once at ``time`` give their impulse to a ``flow``.

        Returns the velocity gained from the (bottom, top) wall, summed over the particles.
        """
        self.walls.enter(time)
        return kick(self, flow, *self.walls.jumps_at(time)) if self.walls.obeys_momentum else [0.0, 0.0]

    def prepare(self, start, time):
        """Do what else is to be done at the start of a step: nothing between walls of given velocities."""

    def solved(self, known, known_state, guess, state, moment, implicit, tolerance):
        """Solve a stage, u = ``known`` + implicit u' and C = ``known_state`` + implicit C' at ``moment``.

        Returns velocity, state, shear rate, shear stress and its slope over the shear rate, or None; and, then, the
        error to be stated.
        """
        memory, velocity = self.memory, guess
        shear_rate = self.sheared(guess, moment)
        for _ in range(MOST_REPETITIONS):
            state, slope = memory.respond(known_state, implicit, shear_rate, state)
            stress = memory.shear_stress(state, shear_rate)
            given = self.operators.given("d_dy", self.walls(moment))
            right = known + implicit * self.drive(moment, stress + slope * (given - shear_rate))
            velocity = self.operators.answer(implicit * self.viscosity, implicit * slope, right, velocity, tolerance)
            if velocity is None:
                return None, math.nan
            found = self.operators.slopes(velocity, -1.0) + given
            matched = self.matched(velocity, found, stress + slope * (found - shear_rate), implicit, slope, tolerance)
            if matched is None:
                return None, math.nan
            velocity, shear_rate, expected = matched
            state, slope = memory.respond(known_state, implicit, shear_rate, state)
            stress = memory.shear_stress(state, shear_rate)
            missed = root_mean_square(stress - expected) / self.stress_of_speed
            if missed <= tolerance * self.speed + ROUNDING * root_mean_square(stress) / self.stress_of_speed:
                return (velocity, state, shear_rate, stress, slope), missed
        return None, math.inf

    def matched(self, velocity, shear_rate, stress, *system):
        """Return velocities, shear rates and stresses with walls that move as they must, or None.

        As they are between walls of given velocities. ``system``: the other arguments of ``operators.answer``.
        """
        return velocity, shear_rate, stress

    def error(self, end, implicit, slope, defect, state_defect):
        """Return the estimated error from what second and third order differ by, filtered as a stage is."""
        pull = self.memory.linear(end.state, implicit, end.shear_rate, state_defect)
        right = defect + implicit * self.operators.slopes(pull, 1.0)
        velocity = self.operators.answer(implicit * self.viscosity, implicit * slope, right, np.zeros_like(right), 1e-2)
        if velocity is None:
            return math.nan
        stress = pull + slope * self.operators.slopes(velocity, -1.0)
        return math.hypot(root_mean_square(velocity), root_mean_square(stress) / self.stress_of_speed)

    def drive(self, time, stress):
        """Return what drives the velocities: acceleration, walls, and the divergence of ``stress`` and its images."""
        source = self.acceleration + self.viscosity * self.operators.given("laplacian", self.walls(time))
        source += self.operators.slopes(stress, 1.0)
        for side, series in enumerate(self.walls.stress_series(time)):
            source += self.operators.images(side, *series)
        return source

    def sheared(self, velocity, time):
        """Return du/dy of ``velocity`` at ``time``."""
        return self.operators.slopes(velocity, -1.0) + self.operators.given("d_dy", self.walls(time))

    def near_walls(self, flow):
        """Return C and du/dy of the liquid at each wall (2, components + 1), by polynomials through what is near."""
        return np.array([fit[0] for fit in self.operators.at_walls(np.vstack([flow.state, flow.shear_rate]))])

    def settle(self, channel):
        """Take the slopes at the walls from the flow of the ``channel`` that a run starts with."""
        reach = NEAR * channel.gap
        distance = np.polynomial.chebyshev.chebpts1(TERMS) + 1.0
        for side, height in enumerate((0.5 * reach * distance, channel.gap - 0.5 * reach * distance)):
            state = self.memory.start(channel, height)
            fit = np.polynomial.polynomial.polyfit(distance, state.T, TERMS - 1)
            towards = (1.0 if side == 0 else -1.0) * 2.0 / reach
            self.walls.first[side], self.walls.third[side] = towards * fit[1], 6.0 * towards**3 * fit[3]


def image_of_stress(depth, slope, third):
    """Return what images at ``depth`` beyond the lower wall have of S_xy more than their sources.

    By its first and third derivatives along y at the wall; beyond the upper one it is that with the other sign.
    """
    return depth * (-2.0 * slope - depth**2 / 3.0 * third)


def polynomial(distance, values, reach):
    """Return coefficients (FIT, quantities) in the ``distance`` (n,) from a wall of what is nearer than ``reach``.

    Of the least-squares fit to ``values`` (n, quantities).
    """
    close = distance < reach
    powers = (distance[close, None] / reach) ** np.arange(FIT)
    return np.linalg.lstsq(powers, values[close], rcond=None)[0] / reach ** np.arange(FIT)[:, None]


def even_fit(distance, reach):
    """Return which of points at a ``distance`` (n) from a wall are within ``reach``, and the weights of what is there
    in its value at the wall: by the even polynomial that fits best."""
    close = np.flatnonzero(distance < reach)
    return close, np.linalg.pinv((distance[close, None] / reach) ** np.array(EVEN))[0]


def root_mean_square(values):
    return math.sqrt(np.mean(values * values))


def weighted(weights, rates):
    """Return the sum of the ``rates`` so far, each with its weight."""
    return sum(weight * rate for weight, rate in zip(weights, rates, strict=False))
