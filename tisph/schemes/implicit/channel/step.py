"""The implicit step of a parallel flow, equations (4) to (8) of docs/theory/implicit.md, on particles and on layers.

    u' = nu_s A u + D S_xy(C, D u) + s(t),    C' = F(C, D u),    D = d/dy                                            (7)

u is the velocity along the channel, A the discrete Laplacian, nu_s the solvent viscosity, S the extra stress per unit
density and C the states of the extra stress. s(t) holds the body acceleration and the boundary terms of the walls. A
Newtonian fluid has neither S nor C (``NoExtraStress``).

The method is the implicit part of ARK3(2)4L[2]SA: C. A. Kennedy and M. H. Carpenter, Appl. Numer. Math. 44 (2003)
139-181. It has one explicit and three implicit stages with one matrix, is of third order and L-stable, and estimates
its error. It damps the stiffest modes completely, so an impulsively started wall needs no other method for its first
steps, as Crank-Nicolson does.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from tisph.config.schema import Config
from tisph.scenes._channel import Channel
from tisph.schemes._step_control import StepControl
from tisph.schemes.implicit.channel.heat import CarriedSubstances, NoSubstances
from tisph.schemes.implicit.channel.models import StressModel, at_factor
from tisph.schemes.implicit.channel.stages import (
    DEFECT,
    GAMMA,
    PREDICTORS,
    B,
    C,
    ClosedOperators,
    FlowState,
    Solution,
    explicit_part,
    norm,
    weighted,
)
from tisph.schemes.implicit.channel.walls import WallPair

SOLVER_TOLERANCE = 1e-3
"""Residual of a stage, over the tolerance of a step."""

WORST = 1e6
"""Error over the reference velocity in place of an infinite one: the step is rejected."""

MOST_ITERATIONS = 12
"""Largest number of outer iterations of a stage."""

ROUND_OFF = 1e-11
"""Residual of the stress, over the stress, at which a stage counts as solved."""

ERROR_RESIDUAL = 1e-2
"""Residual of the linear system (5) that filters the estimated error, over its right side."""

TOLERANCE = 3e-7
"""Tolerance of a step where the config leaves it open."""

FIRST_STEP = 0.25
"""First step in spacing^2 / nu, the time in which a wall that starts moves the layer next to it; or, where it is
larger, over a diffusivity."""


def step_control(config: Config, channel: Channel, targets: Sequence[float]) -> StepControl:
    """Return the ``StepControl`` of a run: it ends steps on the times ``targets`` and on jumps of walls and drive.

    Each step is limited by the strain between neighbouring layers, or with ``time.cfl`` it has a fixed length.
    """
    tolerance = TOLERANCE if config.time.tolerance == "auto" else config.time.tolerance
    jump_times = {time for part in (channel.bottom, channel.top, channel.drive) for time in part.jump_times}
    limit: Callable[[float], float]
    if config.time.cfl != "auto":
        first = config.time.cfl * channel.spacing / channel.reference_velocity
        limit = lambda _gradient: first  # noqa: E731
    else:
        fastest = max(channel.kinematic_viscosity, *(each.diffusivity for each in channel.substances), 0.0)
        first = FIRST_STEP * channel.spacing**2 / fastest
        strain = config.scheme.largest_strain
        limit = lambda gradient: strain / gradient if gradient > 0.0 else math.inf  # noqa: E731
    control = StepControl(tolerance, limit, fixed=config.time.cfl != "auto", jump_times=jump_times)
    control.dt_next = first
    control.set_targets(targets, channel.start_time)
    return control


class Points(Protocol):
    """The points whose velocities a step advances: particles, or layers of the start lattice."""

    def assemble(self, dt: float, shift: bool) -> FlowState:
        """Assemble the operators in the middle of a step of length ``dt``; return the flow at its start.

        ``shift``: first move points apart that are too close, and transfer the flow to their new positions.
        """


class ImplicitStep:
    """Advances the flow of ``points`` between the ``walls`` of a channel, with the derivatives of ``operators``."""

    def __init__(self, points: Points, operators: ClosedOperators, walls: WallPair, channel: Channel) -> None:
        self.points, self.operators, self.walls = points, operators, walls
        self.viscosity = channel.solvent_viscosity
        self.extra_stress: NoExtraStress = NoExtraStress(operators, walls, channel)
        if isinstance(walls.model, StressModel):
            self.extra_stress = ExtraStress(operators, walls, channel, walls.model)
        self.substances = NoSubstances()
        if channel.substances:
            self.substances = CarriedSubstances(channel, operators, walls)

    def advance(
        self, time: float, dt: float, tolerance: float, shift: bool = False
    ) -> tuple[list[FlowState] | None, float]:
        """Take one step of length ``dt`` from ``time``; return the flow in the four stages, and the estimated error.

        The first stage is the start of the step, the last one its end. With g = gamma dt and the rates k_j of stages:

            assemble A, D at x^n + dt/2 u^n, with particles that are too close shifted apart
            k_1 = nu_s A u^n + D S(C^n, D u^n) + s(t^n)                                                              (7)
            for the stages i = 2, 3, 4:
                u_K = u^n + dt sum_{j<i} a_ij k_j, and C_K likewise                                                 (4a)
                u_i = u^n + the integral of the polynomial through k_1 .. k_{i-1}                          (first guess)
                repeat: S* and T from C* = C_K + g F(C*, D u*), with the present iterate u* of u_i
                        (1 - g nu_s A - g D T D) u_i = u_K + g (D (S* - T D u*) + s(t^n + c_i dt))                   (8)
                        with the velocity of a stress-controlled wall by its own momentum balance
                    and then T_i of the substances that the fluid carries, by (9) in ``heat.py``
                until S(C_i, D u_i) is the stress in (8), and T_i acts in (8)
                k_i = (u_i - u_K) / g
            u^(n+1) = u_4, since b_j = a_4j                                                                         (4b)
            (1 - g nu_s A - g D T D) e = d + g D S_C (1 - g F_C)^-1 d_C,    d = dt sum_j (b_j - b^_j) k_j            (5)

        d_C is the same sum of the rates of C; S_C and F_C are the derivatives of S and F by C at the end.
        ``tolerance``: residual of the linear systems over their right side, and of the stress in (8) over its scale.
        Returns None and NaN where a linear system cannot be solved, None and infinity where (8) does not converge.
        """
        operators, walls, extra, gamma_dt = self.operators, self.walls, self.extra_stress, GAMMA * dt
        substances, start = self.substances, self.points.assemble(dt, shift)
        substances.begin(start, time, dt)
        walls.set_effects(substances.effects())
        walls.begin(time, dt, extra.wall_values(start), operators)
        extra.begin(start)
        source = substances.with_pull(extra.source(start.stress, 0))
        start.velocity_rate = self.viscosity * operators.laplacian(start.velocity) + source
        substances.begin_rates(start)
        flows = [start]
        for stage in range(1, len(C)):
            velocity_rates, state_rates = [flow.velocity_rate for flow in flows], [flow.state_rate for flow in flows]
            known = FlowState(
                explicit_part(start.velocity, stage, dt, velocity_rates),
                explicit_part(start.state, stage, dt, state_rates),
            )
            velocity = start.velocity + dt * weighted(PREDICTORS[stage], velocity_rates)
            substances.begin_stage(stage, flows, known)
            shear_rate = extra.begin_stage(stage, time + C[stage] * dt, velocity)
            flow = extra.respond(velocity, shear_rate, known, flows[-1].state, gamma_dt)
            for _ in range(MOST_ITERATIONS):
                stress, boundary = extra.linearise(flow, stage)
                right = known.velocity + gamma_dt * substances.with_pull(extra.source(stress, stage))
                velocity = operators.solve(gamma_dt, flow.tangent, right, flow.velocity, tolerance)  # (8)
                solution = extra.solution(velocity, flow, boundary, gamma_dt, tolerance)
                if solution is None:
                    return None, math.nan
                velocity, shear_rate, stress = solution
                settled = substances.solve(known, velocity, shear_rate, stress, tolerance)
                flow = extra.respond(velocity, shear_rate, known, flow.state, gamma_dt)
                if settled and extra.converged(flow, stress, substances.attainable(tolerance)):
                    break
            else:
                return None, math.inf
            extra.end_stage(flow)
            substances.end_stage(flow)
            flow.velocity_rate = (flow.velocity - known.velocity) / gamma_dt
            flow.state_rate = (flow.state - known.state) / gamma_dt
            flows.append(flow)
        defect = dt * weighted(DEFECT, [flow.velocity_rate for flow in flows])
        state_defect = dt * weighted(DEFECT, [flow.state_rate for flow in flows])
        error = extra.filtered_error(flows[-1], gamma_dt, defect, state_defect)
        return flows, substances.with_errors(error, flows, ERROR_RESIDUAL)

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        self.walls.conclude()
        self.substances.conclude()


class NoExtraStress:
    """The extra stress of a Newtonian fluid: none. ``ExtraStress`` has the same methods."""

    def __init__(self, operators: ClosedOperators, walls: WallPair, channel: Channel) -> None:
        self.operators, self.walls, self.channel = operators, walls, channel
        self.viscosity = channel.solvent_viscosity
        self.steady_source: np.ndarray | None = None

    def wall_values(self, flow: FlowState) -> np.ndarray | None:
        """Return C and the shear rate of the fluid at each wall, (2, components + 1); None without C."""
        return None

    def begin(self, start: FlowState) -> None:
        """Set shear rate, stress and rate of the states at the ``start`` of a step."""
        self.steady_source, start.state_rate = None, start.state

    def begin_stage(self, stage: int, time: float, velocity: np.ndarray) -> Any:
        """Begin an implicit ``stage`` at ``time``; return D u of the predicted ``velocity`` (n,)."""

    def end_stage(self, flow: FlowState) -> None:
        """End an implicit stage with this ``flow``."""

    def respond(
        self, velocity: np.ndarray, shear_rate: Any, known: FlowState, state: np.ndarray, gamma_dt: float
    ) -> FlowState:
        """Return the flow of a stage with this velocity and shear rate, with C = C_K + g F(C, D u).

        ``known``: the explicit part C_K; ``state``: first guess of C.
        """
        return FlowState(velocity, known.state)

    def linearise(self, flow: FlowState, stage: int) -> tuple[Any, Any]:
        """Return S* - T D u* about a ``flow`` without the boundary values of D u, and these boundary values."""
        return None, None

    def source(self, stress: Any, stage: int) -> np.ndarray:
        """Return D ``stress`` + s(t) in a ``stage``: s is nu_s times the boundary part of A u + body acceleration."""
        if self.steady_source is not None:
            return self.steady_source
        source = self.viscosity * self.operators.boundary_laplacian(self.walls.series(stage))
        source += self.walls.body_acceleration[stage]
        self.steady_source = source if self.walls.steady else None
        return source

    def solution(
        self, velocity: np.ndarray | None, flow: FlowState, boundary: Any, gamma_dt: float, tolerance: float
    ) -> Solution | None:
        """Return the solution of (8) by its ``velocity`` for walls as in the iterate ``flow``; None if that is None.

        ``boundary``: boundary values of D u. Walls with their own equation of motion change the solution.
        """
        return None if velocity is None else (velocity, None, None)

    def converged(self, flow: FlowState, stress: Any, tolerance: float) -> bool:
        """Tell whether the stress of a ``flow`` is the ``stress`` in (8)."""
        return True

    def filtered_error(self, end: FlowState, gamma_dt: float, defect: np.ndarray, state_defect: np.ndarray) -> float:
        """Return the norm of e in (5), in the unit of velocity; NaN where the system cannot be solved."""
        error = self.operators.solve(gamma_dt, None, defect, np.zeros_like(defect), ERROR_RESIDUAL)
        return math.nan if error is None else norm(error)

    def indefinite(self, state: np.ndarray) -> np.ndarray:
        """Return the indices of particles whose conformation tensor is not positive definite."""
        return np.zeros(0, dtype=int)

    def mean_stress(self, flows: list[FlowState]) -> np.ndarray | None:
        """Return the mean of S_xy over a step (n,) with these stages; None without an extra stress."""
        return None


class ExtraStress(NoExtraStress):
    """An extra stress S that depends on D u alone, point by point, as the ``model`` of the fluid says.

    Linearised about u* it is S = S* + T D (u - u*): only the velocities are unknowns of the linear systems. Where S is
    linear in D u, as for Oldroyd-B fluids, the first iteration solves a stage.
    """

    def __init__(self, operators: ClosedOperators, walls: WallPair, channel: Channel, model: StressModel) -> None:
        super().__init__(operators, walls, channel)
        self.model = model
        self.speed, self.stress_of_speed = channel.reference_velocity, channel.kinematic_viscosity / channel.gap

    def wall_values(self, flow: FlowState) -> np.ndarray:
        """Return C and D u at each wall (2, components + 1), by polynomials in the wall distance."""
        return self.operators.wall_values(np.vstack([flow.state, flow.shear_rate]))

    def begin(self, start: FlowState) -> None:
        """Set shear rate, stress and rate of the states at the ``start`` of a step."""
        for wall in self.walls.stress_controlled:
            wall.prepare(self, start)
        start.shear_rate = self.shear_rate(start.velocity, 0)
        model = at_factor(self.model, self.viscosity, start.factor)
        start.stress = model.shear_stress(start.state, start.shear_rate)
        start.state_rate = model.rate(start.state, start.shear_rate)

    def begin_stage(self, stage: int, time: float, velocity: np.ndarray) -> np.ndarray:
        """Begin an implicit ``stage`` at ``time``, on the walls too; return D u of the predicted ``velocity`` (n,)."""
        for wall in self.walls.stress_controlled:
            wall.open(stage, time)
        return self.shear_rate(velocity, stage)

    def end_stage(self, flow: FlowState) -> None:
        """End an implicit stage with this ``flow``, on the walls too."""
        for wall in self.walls.stress_controlled:
            wall.close(flow.velocity)

    def shear_rate(self, velocity: np.ndarray, stage: int) -> np.ndarray:
        """Return D u of a ``velocity`` (n,) in a ``stage``."""
        boundary = self.operators.boundary_gradient(self.walls.series(stage))
        return self.operators.gradient(velocity, -1.0) + boundary

    def respond(
        self, velocity: np.ndarray, shear_rate: Any, known: FlowState, state: np.ndarray, gamma_dt: float
    ) -> FlowState:
        """Return the flow of a stage; see ``NoExtraStress.respond``."""
        model = at_factor(self.model, self.viscosity, known.factor)
        state, tangent = model.update(known.state, gamma_dt, shear_rate, state)
        stress = model.shear_stress(state, shear_rate)
        return FlowState(velocity, state, shear_rate, stress, tangent=tangent, factor=known.factor)

    def linearise(self, flow: FlowState, stage: int) -> tuple[np.ndarray, np.ndarray]:
        """Return S* - T D u* without the boundary values of D u, and these; see ``NoExtraStress.linearise``."""
        boundary = self.operators.boundary_gradient(self.walls.series(stage))
        return flow.stress + flow.tangent * (boundary - flow.shear_rate), boundary

    def source(self, stress: Any, stage: int) -> np.ndarray:
        """Return D ``stress`` + s(t) in a ``stage``, with the stress of the images."""
        source = super().source(stress, stage) + self.operators.gradient(stress, 1.0)
        for side, series in enumerate(self.walls.stress_series(stage)):
            source += self.operators.boundary_stress(side, *series)
        return source

    def solution(
        self, velocity: np.ndarray | None, flow: FlowState, boundary: Any, gamma_dt: float, tolerance: float
    ) -> Solution | None:
        """Return velocity, D u and S* + T (D u - D u*); see ``NoExtraStress.solution``."""
        if velocity is None:
            return None
        shear_rate = self.operators.gradient(velocity, -1.0) + boundary
        stress = flow.stress + flow.tangent * (shear_rate - flow.shear_rate)
        return self.walls.match(self.operators, (velocity, shear_rate, stress), gamma_dt, flow.tangent, tolerance)

    def converged(self, flow: FlowState, stress: Any, tolerance: float) -> bool:
        """Tell whether the stress of a ``flow`` is the ``stress`` in (8)."""
        round_off = ROUND_OFF * norm(flow.stress)
        return norm(flow.stress - stress) <= tolerance * self.speed * self.stress_of_speed + round_off

    def filtered_error(self, end: FlowState, gamma_dt: float, defect: np.ndarray, state_defect: np.ndarray) -> float:
        """Return the root sum of squares of the errors of u, of S_xy gap/nu and of the walls' velocities."""
        model = at_factor(self.model, self.viscosity, end.factor)
        relaxed = model.linear(end.state, gamma_dt, end.shear_rate, state_defect)
        right = defect + gamma_dt * self.operators.gradient(relaxed, 1.0)
        velocity = self.operators.solve(gamma_dt, end.tangent, right, np.zeros_like(right), ERROR_RESIDUAL)
        if velocity is None:
            return math.nan
        stress = relaxed + end.tangent * self.operators.gradient(velocity, -1.0)
        errors = norm(velocity), norm(stress) / self.stress_of_speed
        return math.hypot(*errors, *(wall.defect for wall in self.walls))

    def indefinite(self, state: np.ndarray) -> np.ndarray:
        """Return the indices of particles whose conformation tensor is not positive definite."""
        return self.model.indefinite(state)

    def mean_stress(self, flows: list[FlowState]) -> np.ndarray:
        """Return the mean of S_xy over a step (n,) with these stages."""
        return weighted(B, [flow.stress for flow in flows])
