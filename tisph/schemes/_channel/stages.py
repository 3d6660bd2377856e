"""One implicit step of a parallel flow: of the velocities, and with them of an extra stress,

    u' = nu_s A u + D S_xy(C, D u) + s(t),    C' = F(C, D u),    D = d/dy.

A Newtonian fluid has no S and no C. Else C depends on the velocities in a stage through D u alone, point by point
(``models.py``): linearised, S_xy = S* + t (D u - shear rate*), so that the systems are those of the velocities,
(1 - g nu_s A - g D t D) u = ...; with a law that is linear there is nothing to repeat.

The stages are those of an L-stable Runge-Kutta method of third order with an error estimate, the implicit part of
ARK3(2)4L[2]SA: C. A. Kennedy and M. H. Carpenter, Appl. Numer. Math. 44 (2003) 139-181. One stage is explicit, and
three implicit ones have the same matrix 1 - gamma h nu A. The method damps the stiffest modes completely, so that an
impulsively started wall needs no other method for its first steps, as Crank-Nicolson does.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tisph.measures.metrics import root_mean_square

FIT_TERMS = 3
"""Of the polynomial in the wall distance that describes the fluid near a wall."""

EVEN_POWERS = (0, 2, 4)
"""Powers of the wall distance in the fit for a value at a stress-controlled wall."""

GAMMA = 1767732205903 / 4055673282236

A = (
    (0.0, 0.0, 0.0, 0.0),
    (GAMMA, GAMMA, 0.0, 0.0),
    (2746238789719 / 10658868560708, -640167445237 / 6845629431997, GAMMA, 0.0),
    (1471266399579 / 7840856788654, -4482444167858 / 7529755066697, 11266239266428 / 11593286722821, GAMMA),
)
B = A[3]
C = (0.0, 2.0 * GAMMA, 0.6, 1.0)

B_HAT = (
    2756255671327 / 12835298489170,
    -10771552573575 / 22201958757719,
    9247589265047 / 10645013368117,
    2193209047091 / 5459859503100,
)
"""Weights of the second-order result; the difference from ``B`` estimates the error."""

EMBEDDED_ORDER = 2

DEFECT = tuple(b - b_hat for b, b_hat in zip(B, B_HAT, strict=True))

SOLVER_TOLERANCE = 1e-3
"""Residual of a stage, over the tolerance of a step."""

WORST = 1e6
"""Error over the reference velocity in place of an infinite one: the step is rejected."""

MOST_REPETITIONS = 12
ROUND_OFF = 1e-11
"""Of the stress, which is left when a stage is solved."""

ERROR_RESIDUAL = 1e-2
"""Of the linear system by which the estimated error is filtered."""

NEAR, TERMS = 0.1, 8
"""Part of the gap, and terms of a polynomial in it, by which the slopes of the start at the walls are taken."""


def stress_excess(depth, side, even_reflection, slope, third):
    """Return S_xy of images at a ``depth`` beyond the lower (``side`` 0) or upper wall, less that of their sources.

    By its first and third derivatives along y at the wall; beyond one with even reflection by the stress there and its
    second derivative.
    """
    if even_reflection:
        return 2.0 * slope + depth**2 * third
    return (1.0 if side == 0 else -1.0) * (depth * (-2.0 * slope - depth**2 / 3.0 * third))


def polynomial_fit(distance, values, radius):
    """Return the coefficients (FIT_TERMS, quantities) of the polynomial in the wall ``distance`` (n,) near a wall.

    The polynomial is the least-squares fit to the ``values`` (n, quantities) at points nearer than ``radius``.
    """
    near = distance < radius
    powers = (distance[near, None] / radius) ** np.arange(FIT_TERMS)
    return np.linalg.lstsq(powers, values[near], rcond=None)[0] / radius ** np.arange(FIT_TERMS)[:, None]


def even_fit(distance, radius):
    """Return which points at a wall ``distance`` (n,) are within ``radius``, and their weights in the value there.

    That is the value of the even polynomial that fits best.
    """
    near = np.flatnonzero(distance < radius)
    return near, np.linalg.pinv((distance[near, None] / radius) ** np.array(EVEN_POWERS))[0]


def stage_predictors():
    """Weights (4, 4) of the rates before a stage in the predicted velocities: their polynomial, integrated."""
    weights = np.zeros((4, 4))
    for stage in range(1, 4):
        powers = np.arange(stage)
        nodes = np.array(C[:stage])[:, None] ** powers
        weights[stage, :stage] = np.linalg.solve(nodes.T, C[stage] ** (powers + 1) / (powers + 1))
    return weights


def weighted(weights, values):
    """Return the sum of the ``values`` so far, numbers or arrays, each with its weight."""
    total = weights[0] * values[0]
    for weight, value in zip(weights[1:], values[1:], strict=False):
        total = total + weight * value
    return total


PREDICTORS = stage_predictors()


class ClosedOperators(Protocol):
    """A and D on points between two walls, which images beyond the walls close; arrays are (points,)."""

    def laplacian(self, values):
        """Return A of velocities, without the part of walls."""

    def gradient(self, values, parity):
        """Return D of values whose images have ``parity`` times theirs."""

    def boundary_laplacian(self, series):
        """Return the part of A from the ``series`` of the images of velocities beyond both walls (2, 3)."""

    def boundary_gradient(self, series):
        """Return the part of D from the ``series`` of the images."""

    def boundary_stress(self, side, slope, third):
        """Return the part of D S from the first and third derivative of the stress at a wall."""

    def solve(self, coefficient, tangent, right, guess, tolerance):
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = ``right``; None where that fails.

        ``tangent``: None for no extra stress. ``tolerance``: of the residual, over the right side.
        """

    def wall_fits(self, values):
        """Return coefficients of polynomials in the distance from the (bottom, top) wall, of ``values`` (n, points)."""

    def even_fit(self, side):
        """Return points near a wall, their distances, and their weights in the even fit to the value there."""


@dataclass
class FlowState:
    """Velocities (n), states C (components, n), shear rates (n) and extra stress (n) of a stage.

    And the time derivatives of the first two, and the ``tangent`` dS_xy/d shear rate. States are (0, n) without any.
    """

    velocity: np.ndarray
    state: np.ndarray
    shear_rate: np.ndarray | None = None
    stress: np.ndarray | None = None
    velocity_rate: np.ndarray | None = None
    state_rate: np.ndarray | None = None
    tangent: np.ndarray | None = None


class ViscousStages:
    """Advances a ``FlowState`` of a Newtonian fluid between ``walls``, a ``WallPair``.

    ``mean_velocity`` and ``mean_stress`` (n), the latter None here: means over the last step.
    """

    model = mean_stress = None

    def __init__(self, operators, channel, walls):
        self.operators, self.walls, self.channel = operators, walls, channel
        self.viscosity, self.acceleration = channel.solvent_viscosity, channel.acceleration
        self.mean_velocity, self.steady_source = None, None

    def advance(self, start, time, dt, tolerance):
        """Return the ``FlowState`` after a step, and the estimated error.

        None and NaN where a linear system cannot be solved, infinite where the stress does not follow the shear rate.

        The rates of ``start`` are set. The error is the root mean square of those of u, and of S_xy over the viscosity
        per gap.
        """
        gamma_dt = GAMMA * dt
        self.begin(start, time, dt)
        flows = [start]
        for stage in range(1, 4):
            velocity_rates, state_rates = [flow.velocity_rate for flow in flows], [flow.state_rate for flow in flows]
            known = FlowState(
                start.velocity + dt * weighted(A[stage], velocity_rates),
                start.state + dt * weighted(A[stage], state_rates),
            )
            guess = FlowState(start.velocity + dt * weighted(PREDICTORS[stage], velocity_rates), flows[-1].state)
            flow, residual = self.solve_stage(stage, time + C[stage] * dt, known, guess, gamma_dt, tolerance)
            if flow is None:
                return None, residual
            flow.velocity_rate = (flow.velocity - known.velocity) / gamma_dt
            flow.state_rate = (flow.state - known.state) / gamma_dt
            flows.append(flow)
        self.average(flows)
        defect, state_defect = (
            dt * weighted(DEFECT, [getattr(flow, name) for flow in flows]) for name in ("velocity_rate", "state_rate")
        )
        return flow, self.error(flow, gamma_dt, defect, state_defect)

    def begin(self, start, time, dt):
        """Begin a step: set the rates at its ``start``."""
        self.walls.begin(time, dt, None, self.operators)
        self.steady_source = None
        start.velocity_rate = self.viscosity * self.operators.laplacian(start.velocity) + self.source(0)
        start.state_rate = start.state

    def solve_stage(self, stage, time, known, guess, gamma_dt, tolerance):
        """Solve a stage at ``time``, u = ``known`` + g h u', and so for C; return its ``FlowState``, or None.

        And, then, the error to be stated.
        """
        right = known.velocity + gamma_dt * self.source(stage)
        velocity = self.operators.solve(gamma_dt * self.viscosity, None, right, guess.velocity, tolerance)
        return (None, math.nan) if velocity is None else (FlowState(velocity, known.state), 0.0)

    def source(self, stage):
        """Return the acceleration in a stage by the body force and the motion of the walls."""
        if self.steady_source is not None:
            return self.steady_source
        source = self.viscosity * self.operators.boundary_laplacian(self.walls.series(stage))
        source += self.acceleration
        self.steady_source = source if self.walls.steady else None
        return source

    def average(self, flows):
        """Take up what the stages of a step are on the mean."""
        self.mean_velocity = weighted(B, [flow.velocity for flow in flows])

    def error(self, end, gamma_dt, defect, state_defect):
        """Return the estimated error: the difference of second and third order, filtered as a stage is."""
        nothing = np.zeros_like(defect)
        error = self.operators.solve(gamma_dt * self.viscosity, None, defect, nothing, ERROR_RESIDUAL)
        return math.nan if error is None else root_mean_square(error)

    def wall_values(self, flow):
        """Return C and shear rate at each wall: of no use for a Newtonian fluid."""
        return [None, None]


class CoupledStages(ViscousStages):
    """Advances a ``FlowState`` of a fluid with an extra stress, by the ``model`` of the walls."""

    def __init__(self, operators, channel, walls):
        super().__init__(operators, channel, walls)
        self.model, self.speed = walls.model, channel.reference_velocity
        self.stress_of_speed = channel.kinematic_viscosity / channel.gap

    def begin(self, start, time, dt):
        """Begin a step: set shear rates, stresses, and the rates at its ``start``."""
        self.walls.begin(time, dt, self.wall_values(start), self.operators)
        for wall in self.walls:
            wall.prepare(self, start)
        start.shear_rate = self.shear_rate(start.velocity, 0)
        start.stress = self.model.shear_stress(start.state, start.shear_rate)
        viscous = self.viscosity * self.operators.laplacian(start.velocity)
        start.velocity_rate = viscous + self.coupled_source(0, start.stress)
        start.state_rate = self.model.rate(start.state, start.shear_rate)

    def solve_stage(self, stage, time, known, guess, gamma_dt, tolerance):
        """Solve a stage; see ``ViscousStages.solve_stage``."""
        for wall in self.walls:
            wall.open(stage, time)
        flow = self.at_shear_rate(guess.velocity, self.shear_rate(guess.velocity, stage), known, guess.state, gamma_dt)
        for _ in range(MOST_REPETITIONS):
            solution = self.linear_solution(stage, flow, known.velocity, gamma_dt, tolerance)
            if solution is None:
                return None, math.nan
            velocity, shear_rate, expected = solution
            flow = self.at_shear_rate(velocity, shear_rate, known, flow.state, gamma_dt)
            residual = root_mean_square(flow.stress - expected)
            if residual <= tolerance * self.speed * self.stress_of_speed + ROUND_OFF * root_mean_square(flow.stress):
                for wall in self.walls:
                    wall.close(velocity)
                return flow, 0.0
        return None, math.inf

    def at_shear_rate(self, velocity, shear_rate, known, state, gamma_dt):
        """Return the ``FlowState`` of a stage with this shear rate, from a guess of its ``state``."""
        state, tangent = self.model.update(known.state, gamma_dt, shear_rate, state)
        stress = self.model.shear_stress(state, shear_rate)
        return FlowState(velocity, state, shear_rate, stress, tangent=tangent)

    def linear_solution(self, stage, flow, known, gamma_dt, tolerance):
        """Return velocity, shear rate and stress of the stage linearised about ``flow``; None where that fails."""
        system = gamma_dt, flow.tangent, tolerance
        boundary = self.operators.boundary_gradient(self.walls.series(stage))
        stress = flow.stress + flow.tangent * (boundary - flow.shear_rate)
        right = known + gamma_dt * self.coupled_source(stage, stress)
        coefficient = gamma_dt * self.viscosity
        velocity = self.operators.solve(coefficient, gamma_dt * flow.tangent, right, flow.velocity, tolerance)
        if velocity is None:
            return None
        shear_rate = self.operators.gradient(velocity, -1.0) + boundary
        solution = velocity, shear_rate, flow.stress + flow.tangent * (shear_rate - flow.shear_rate)
        for wall in self.walls:
            solution = solution and wall.match(self, solution, *system)
        return solution

    def coupled_source(self, stage, stress):
        """Return the source of the velocities with the divergence of ``stress`` and its images."""
        source = self.source(stage) + self.operators.gradient(stress, 1.0)
        for side, series in enumerate(self.walls.stress_series(stage)):
            source += self.operators.boundary_stress(side, *series)
        return source

    def average(self, flows):
        """Take up what the stages of a step are on the mean."""
        super().average(flows)
        self.mean_stress = weighted(B, [flow.stress for flow in flows])

    def error(self, end, gamma_dt, defect, state_defect):
        """Return the estimated error of velocities, stress and the velocities of walls."""
        relaxed = self.model.linear(end.state, gamma_dt, end.shear_rate, state_defect)
        right = defect + gamma_dt * self.operators.gradient(relaxed, 1.0)
        coefficient, tangent = gamma_dt * self.viscosity, gamma_dt * end.tangent
        velocity = self.operators.solve(coefficient, tangent, right, np.zeros_like(right), ERROR_RESIDUAL)
        if velocity is None:
            return math.nan
        stress = relaxed + end.tangent * self.operators.gradient(velocity, -1.0)
        errors = root_mean_square(velocity), root_mean_square(stress) / self.stress_of_speed
        return math.hypot(*errors, *(wall.defect for wall in self.walls))

    def shear_rate(self, velocity, stage):
        """Return du/dy of ``velocity`` in a stage."""
        boundary = self.operators.boundary_gradient(self.walls.series(stage))
        return self.operators.gradient(velocity, -1.0) + boundary

    def wall_values(self, flow):
        """Return C and du/dy of the fluid at each wall (2, components + 1), by polynomials in the distance."""
        return np.array([fit[0] for fit in self.operators.wall_fits(np.vstack([flow.state, flow.shear_rate]))])

    def initialise(self):
        """Take the derivatives at the walls from the flow of the channel that a run starts with."""
        gap, radius = self.channel.gap, NEAR * self.channel.gap
        distance = np.polynomial.chebyshev.chebpts1(TERMS) + 1.0
        heights = 0.5 * radius * distance, gap - 0.5 * radius * distance
        for wall, height in zip(self.walls, heights, strict=True):
            fit = np.polynomial.polynomial.polyfit(distance, self.model.initial(self.channel, height).T, TERMS - 1)
            scale = wall.normal_sign * 2.0 / radius
            wall.initialise([fit[0], scale * fit[1], 2.0 * scale**2 * fit[2], 6.0 * scale**3 * fit[3]])


def stages_of(operators, channel, walls):
    """Return the stages of the flow of a ``channel`` between its ``walls``, a ``WallPair``."""
    return (ViscousStages if walls.model is None else CoupledStages)(operators, channel, walls)
