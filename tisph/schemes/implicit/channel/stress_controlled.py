"""Stress-controlled walls with and without a mass: walls whose velocity U follows from a given external stress.

``walls.py`` explains notation and images; all quantities are per unit density. With a mass,

    mass U' = stress - s sigma,    s = 1 on the upper wall, -1 on the lower one.

sigma is the shear stress of the fluid at the wall, by an even polynomial through the stresses of the particles near it
less their odd part, whose slope sigma_y = U' - g is known. In a stage U' = (U - U_K)/(gamma dt), so the series are
linear in U and the velocities of the stage are u_a + (U - U*) w: u_a belongs to the present iterate U*, and w is the
response to a unit velocity, by the same matrix. U'' in the series of the images, of fourth order, is left out.

Without a mass the shear rate e = u_y at the wall follows in each stage from

    s sigma(e, C) = stress,    sigma = nu_s e + S_xy(C),

where C at the wall obeys the law of the fluid with the shear rate e. The series of the images then have the odd terms,
u_I = u_F - 2 d u_d - d^3/3 u_ddd and S_I = 2 S - S_F + d^2 S_dd. The derivative of the momentum equation along y gives
nu_s u_yyy + S_yy = e', and C_yy follows as C_y does above. The velocity of the wall is the value of an even polynomial
through the velocities of the particles near it less their odd part.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.config.schema import Config
from tisph.errors import DivergedError
from tisph.geometry.motion import StressControlledWall
from tisph.scenes._channel import Channel
from tisph.schemes.implicit.channel.models import StressModel, at_factor, model_of
from tisph.schemes.implicit.channel.stages import DEFECT, GAMMA, B, ClosedOperators, FlowState, explicit_part, weighted
from tisph.schemes.implicit.channel.step import ExtraStress
from tisph.schemes.implicit.channel.walls import (
    CoupledWall,
    PrescribedWall,
    WallPair,
    WallSystem,
    one_sided,
)

MOST_ITERATIONS = 60
ROUND_OFF = 1e-13
"""Newton iterations for the shear rate at a massless wall: largest number, and relative residual at which they end."""


class WallOfGivenStress(CoupledWall):
    """The common part of stress-controlled walls with and without a mass; ``control``: stress, mass and friction.

    ``velocity`` and ``displacement`` at the start of the step; ``velocities`` of the wall and ``stresses`` of the fluid
    at it in the stages so far.
    """

    prescribed = False

    def __init__(self, channel: Channel, side: int, obeys_momentum: bool, model: StressModel, control: Any) -> None:
        self.control, self.mass, self.friction = control, control.mass_per_area, control.friction
        super().__init__(channel, side, obeys_momentum, model)

    def forget(self) -> None:
        """Return to a wall at rest beside a fluid in which C is 0."""
        super().forget()
        self.velocity = self.displacement = 0.0

    def begin(self, time: float, dt: float, fluid: Any, operators: ClosedOperators) -> None:
        """Begin a step; see ``PrescribedWall.begin``."""
        self.dt, self.gamma_dt = dt, GAMMA * dt
        self.stress_of = self.control.after(time).stress
        self.near, self.distance, self.weights = operators.even_fit(self.side)
        self.velocities: list[float] = [self.velocity]
        self.stresses: list[float] = []
        self.rates: list[float] = []
        self.series, self.stress_series = [], []

    def acceleration(self, time: float) -> float:
        """Return 0: the stress on the fluid is known, and no fit to stresses uses the acceleration."""
        return 0.0

    def prepare(self, extra: ExtraStress, start: FlowState) -> None:
        """Adapt the wall to the flow at the ``start`` of a step."""

    @property
    def mean_stress(self) -> float:
        """Mean over the step of the shear stress of the fluid at the wall, per unit density."""
        return weighted(B, self.stresses)

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        self.displacement += self.dt * weighted(B, self.velocities)
        self.velocity = self.velocities[-1]


class InertialWall(WallOfGivenStress):
    """A stress-controlled wall with a mass per area; ``rates``: its acceleration in the stages."""

    kept = "slope", "third", "velocity", "displacement"

    def first_jumps(self) -> tuple[float, float]:
        """Return ``jumps``: at the start the whole stress accelerates the wall."""
        return self.channel.wall_jumps[self.side], self.later_jumps(0.0)[1]

    def later_jumps(self, time: float) -> tuple[float, float]:
        """Return the jumps at ``time``: the acceleration jumps with the stress."""
        schedule, density = self.schedule, self.channel.density
        before = 0.0 if time == 0.0 else float(schedule.after(np.nextafter(time, 0.0)).stress(time))
        return 0.0, (float(schedule.after(time).stress(time)) - before) / density / self.mass

    def begin(self, time: float, dt: float, fluid: Any, operators: ClosedOperators) -> None:
        """Begin a step; see ``PrescribedWall.begin``."""
        super().begin(time, dt, fluid, operators)
        self.fluid = fluid
        self.response: Any = 0.0
        self.slope_rates: list[np.ndarray] = []
        self.third_rates: list[np.ndarray] = []
        self.begin_stage(0, time)
        self.accelerate(self.velocity, 0.0)

    def begin_stage(self, stage: int, time: float) -> None:
        """Begin a stage at ``time``: compute its explicit parts from the rates of earlier stages."""
        self.stress, self.stage_time = float(self.stress_of(time)), time
        gamma_dt = self.gamma_dt if stage else 0.0
        self.system = WallSystem(gamma_dt, self.model, self.viscosity, self.fluid[stage], self.effects[stage])
        self.known = explicit_part(self.velocity, stage, self.dt, self.rates)
        self.known_slope = explicit_part(self.slope, stage, self.dt, self.slope_rates)
        self.known_third = explicit_part(self.third, stage, self.dt, self.third_rates)
        self.series.append(None)
        self.stress_series.append(None)

    def accelerate(self, velocity: float, rate: float) -> None:
        """Set ``velocity`` and acceleration ``rate`` of the wall in the present stage, and its series."""
        self.stage_velocity, self.rate = velocity, rate
        self.driving = rate - self.drive.value(self.stage_time) - self.system.effects.pull
        driving_rate = -self.drive.slope(self.stage_time)
        known = self.known_slope, self.known_third
        found, self.state_rates = self.system.derivatives(*known, self.driving, driving_rate)
        self.ends = found[:2]
        self.series[-1], self.stress_series[-1] = [2.0 * velocity, found[2], found[3] / 12.0], found[4:]

    def set_velocity(self, velocity: float) -> None:
        """Set the ``velocity`` of the wall in the present implicit stage."""
        self.accelerate(velocity, (velocity - self.known) / self.gamma_dt)

    def prepare(self, extra: ExtraStress, start: FlowState) -> None:
        """Compute the acceleration of the wall at the ``start`` of a step by the stress of the fluid at it."""
        totals = []
        for rate in (0.0, 1.0):  # the stress is linear in the acceleration
            self.accelerate(self.velocity, rate)
            shear_rate = extra.shear_rate(start.velocity, 0)
            model = at_factor(self.model, self.viscosity, start.factor)
            stress = self.viscosity * shear_rate + model.shear_stress(start.state, shear_rate)
            totals.append(self.fitted_stress(stress, self.driving))
        more = totals[1] - totals[0]
        force = self.stress - self.friction * self.velocity + self.normal_sign * totals[0]
        rate = force / (self.mass - self.normal_sign * more)
        self.accelerate(self.velocity, rate)
        self.total = totals[0] + rate * more
        self.velocities = []
        self.close(start.velocity)

    def open(self, stage: int, time: float) -> None:
        """Begin an implicit stage at ``time``, with the velocity by the acceleration of the stage before."""
        self.begin_stage(stage, time)
        self.set_velocity(self.known + self.gamma_dt * self.rates[-1])

    def respond(
        self, operators: ClosedOperators, gamma_dt: float, tangent: np.ndarray, tolerance: float
    ) -> np.ndarray | None:
        """Solve for w, the ``response`` of the fluid to a unit velocity of the wall; return D w, None on failure.

        ``gamma_dt``, ``tangent``, ``tolerance``: of the linear systems of the stage.
        """
        nothing = np.zeros_like(self.known_slope)
        found, _ = self.system.derivatives(nothing, nothing, 1.0 / gamma_dt, 0.0, thermal=0.0)
        series = one_sided(self.side, [2.0, found[2], found[3] / 12.0])
        boundary = operators.boundary_gradient(series)
        right = self.viscosity * operators.boundary_laplacian(series)
        right += operators.gradient(tangent * boundary, 1.0) + operators.boundary_stress(self.side, *found[4:])
        guess = self.response + np.zeros_like(right)
        response = operators.solve(gamma_dt, tangent, gamma_dt * right, guess, tolerance)
        if response is None:
            return None
        self.response = response
        return operators.gradient(response, -1.0) + boundary

    def fitted_stress(self, stress: np.ndarray, rate: float) -> float:
        """Return the value at the wall of the even fit to ``stress`` (n,), with its slope ``rate`` = U' - g - b."""
        return float(self.weights @ (stress[self.near] - self.normal_sign * rate * self.distance))

    def close(self, velocity: np.ndarray) -> None:
        """End a stage, in which the fluid has the stress ``total`` at the wall."""
        self.rates.append(self.rate)
        self.slope_rates.append(self.state_rates[0])
        self.third_rates.append(self.state_rates[1])
        self.velocities.append(self.stage_velocity)
        self.stresses.append(self.total)
        self.defect = self.dt * weighted(DEFECT, self.rates)

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        super().conclude()
        self.slope, self.third = self.ends


class SlipWall(InertialWall):
    """The fluid at a wall of given velocity along which it slips: without mass, under the stress friction * (U - u).

    ``velocity`` is the velocity u of this fluid, which a jump of U does not change.
    """

    first_jumps, later_jumps = PrescribedWall.first_jumps, PrescribedWall.later_jumps

    def start(self) -> None:
        """Return to the start of the run."""
        super().start()
        height = self.channel.gap * self.side
        self.velocity = float(self.channel.exact_velocity(height, self.channel.start_time))

    def apply_jump(self, flow: FlowState, *jump: Any) -> np.ndarray:
        """Return no change of the velocities: the stress of the wall is finite."""
        return np.zeros_like(flow.velocity)

    def close(self, velocity: np.ndarray) -> None:
        """End a stage; the error of a wall velocity without mass is an error of the velocities of the fluid."""
        super().close(velocity)
        self.defect = 0.0


class MasslessWall(WallOfGivenStress):
    """A stress-controlled wall without a mass.

    ``state`` and ``second`` (components,): C and C_yy of the fluid at the wall. ``rate`` and ``change``: the shear rate
    e there and its time derivative.
    """

    even_reflection = True
    kept = "state", "second", "rate", "change", "velocity", "displacement"

    def forget(self) -> None:
        """Return to a wall at rest beside a fluid in which C is 0."""
        super().forget()
        self.state, self.second = np.zeros((2, self.model.components))
        self.rate = self.change = 0.0

    def initialise(self, derivatives: Sequence[np.ndarray]) -> None:
        """Set the derivatives of orders 0 to 3 of C along y at the wall (4, components)."""
        self.state, self.second = derivatives[0], derivatives[2]

    def first_jumps(self) -> tuple[float, float]:
        """Return ``jumps``: the stress jumps, not the velocity or the acceleration."""
        return self.channel.wall_jumps[self.side], 0.0

    def later_jumps(self, time: float) -> tuple[float, float]:
        """Return the jumps of velocity and acceleration at ``time``: none."""
        return 0.0, 0.0

    def jump(self, time: float) -> float:
        """Set shear rate and e' for the stress from ``time`` on; return the jump of the shear rate."""
        before, self.known, self.gamma_dt = self.rate, self.state, 0.0
        self.stress = float(self.control.after(time).stress(time))
        self.heed(0)
        self.balance(self.rate)
        self.rate = self.shear_rate
        _, _, by_state, tangent = self.local.jacobian(self.state, self.rate)
        relaxation = float(by_state @ self.state_rate(self.state, self.rate))
        stress_rate = float(self.control.slope(time))
        self.change = (-self.normal_sign * stress_rate - relaxation) / (self.viscosity + tangent)
        return self.rate - before

    def apply_stress_jump(self, operators: ClosedOperators, time: float) -> np.ndarray:
        """Return the change of the fluid's velocities by the jump of the stress at ``time``.

        It is the momentum of the layer that the particles do not resolve yet. A shear rate that jumps by J has e' = J
        delta(t) and e'' = J delta'(t) in the series -d^3/3 e'/nu - d^5/60 e''/nu^2 of the images.
        """
        jump = self.normal_sign * self.jump(time)
        third, fifth = ([0.0, -jump / 3.0, 0.0], [0.0, 0.0, -jump / 60.0])
        change, fourth = (operators.boundary_laplacian(one_sided(self.side, each)) for each in (third, fifth))
        return change + operators.laplacian(fourth)

    def begin(self, time: float, dt: float, fluid: Any, operators: ClosedOperators) -> None:
        """Begin a step; see ``PrescribedWall.begin``."""
        super().begin(time, dt, fluid, operators)
        self.gamma_dt, self.known, self.stress = 0.0, self.state, float(self.stress_of(time))
        self.state_rates: list[np.ndarray] = []
        self.second_rates: list[np.ndarray] = []
        self.heed(0)
        self.set_shear_rate(self.rate)
        system = self.system()
        second, second_rate, third = system.solve(self.second, *self.driving(self.change))
        self.append_series(system, second, third)
        self.append_rates(self.change, self.state_rate(self.state, self.rate), second_rate)
        self.gamma_dt = GAMMA * dt

    def open(self, stage: int, time: float) -> None:
        """Begin an implicit stage at ``time``: solve for its shear rate."""
        self.stress = float(self.stress_of(time))
        self.known = explicit_part(self.state, stage, self.dt, self.state_rates)
        known_second = explicit_part(self.second, stage, self.dt, self.second_rates)
        known_rate = explicit_part(self.rate, stage, self.dt, self.rates)
        self.heed(stage)
        self.balance(known_rate + self.gamma_dt * self.rates[-1])
        system = self.system()
        rate = (self.shear_rate - known_rate) / self.gamma_dt
        self.stage_second, second_rate, third = system.solve(known_second, *self.driving(rate))
        self.append_series(system, self.stage_second, third)
        self.stage_rates = rate, (self.stage_state - self.known) / self.gamma_dt, second_rate

    def append_series(self, system: WallSystem, second: np.ndarray, third: float) -> None:
        """Append the series of a stage with the present shear rate, by C_yy and u_yyy."""
        self.third_derivative = third
        self.series.append([-2.0 * self.normal_sign * self.shear_rate, -self.normal_sign * third / 3.0, 0.0])
        thermal = system.stress_by_factor * self.effect.factor_curvature + self.mixed_term
        stress = system.stress_slope(second, third) + thermal
        self.stress_series.append((self.extra_stress, stress))

    def driving(self, rate: float) -> tuple[float, float]:
        """Return nu_s u_yyy + S_yy by e' = ``rate``, less the products of a_y and u_yy in it, and a_yy."""
        return rate - self.effect.pull_slope - self.mixed_term, self.effect.factor_curvature

    def heed(self, stage: int) -> None:
        """Take the effects of the temperature on the fluid at the wall in a ``stage``."""
        self.effect = self.effects[stage]
        self.local = at_factor(self.model, self.viscosity, self.effect.factor)

    def state_rate(self, state: np.ndarray, shear_rate: float) -> np.ndarray:
        """Return dC/dt (components,) of the fluid at the wall."""
        return self.local.rate(state[:, None], np.array([shear_rate]))[:, 0]

    def set_shear_rate(self, shear_rate: float) -> None:
        """Set the ``shear_rate`` of the fluid at the wall, and by it C, the stresses and the tangent there."""
        rate, known = np.array([shear_rate]), self.known[:, None]
        state, tangent = self.local.update(known, self.gamma_dt, rate, known)
        self.shear_rate, self.stage_state = shear_rate, state[:, 0]
        self.extra_stress = float(np.ravel(self.local.shear_stress(state, rate))[0])
        self.total = self.viscosity * shear_rate + self.extra_stress
        self.tangent = self.viscosity + float(np.ravel(tangent)[0])

    def system(self) -> WallSystem:
        """Return the equations of the derivatives along y, about the present C and shear rate."""
        fluid = np.append(self.stage_state, self.shear_rate)
        system = WallSystem(self.gamma_dt, self.model, self.viscosity, fluid, self.effect)
        by_both = system.viscosity / (self.effect.factor or 1.0)  # of the stress by shear rate and factor
        thermal = self.effect.pull + system.stress_by_factor * self.effect.factor_slope
        curvature = -(self.channel.acceleration + thermal) / system.viscosity  # without U', which is not known
        self.mixed_term = 2.0 * by_both * self.effect.factor_slope * curvature
        return system

    def balance(self, guess: float) -> None:
        """Solve s sigma(e, C) = stress for the shear rate e by Newton's method, from a ``guess``."""
        self.set_shear_rate(guess)
        for _ in range(MOST_ITERATIONS):
            residual = self.stress + self.normal_sign * self.total
            if abs(residual) <= ROUND_OFF * (abs(self.stress) + abs(self.extra_stress)):
                return
            self.set_shear_rate(self.shear_rate - self.normal_sign * residual / self.tangent)
        raise DivergedError("u: no shear rate is found at the stress-controlled wall")

    def close(self, velocity: np.ndarray) -> None:
        """End an implicit stage with these velocities of the fluid (n,)."""
        self.velocities.append(self.fitted_velocity(velocity, self.shear_rate, self.third_derivative))
        self.append_rates(*self.stage_rates)

    def fitted_velocity(self, velocity: np.ndarray, shear_rate: float, third: float) -> float:
        """Return the velocity of the wall by the even fit to ``velocity`` (n,), with its u_y and u_yyy."""
        odd = self.normal_sign * (shear_rate * self.distance + third * self.distance**3 / 6.0)
        return float(self.weights @ (velocity[self.near] - odd))

    def append_rates(self, rate: float, state_rate: np.ndarray, second_rate: np.ndarray) -> None:
        """Append e', C' and C_yy' of a stage, and the stress of the fluid at the wall."""
        self.rates.append(rate)
        self.state_rates.append(state_rate)
        self.second_rates.append(second_rate)
        self.stresses.append(self.total)

    def state_excess(self, component: int) -> tuple[float, float]:
        """Return C and C_yy of a component for its images, arguments of ``stress_excess``."""
        return self.state[component], self.second[component]

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        super().conclude()
        self.state, self.second = self.stage_state, self.stage_second
        self.rate, self.change = self.shear_rate, self.rates[-1]
        if not math.isfinite(self.rate):
            raise DivergedError("u: the shear rate at the stress-controlled wall is not finite")


def wall_pair_of(config: Config, channel: Channel) -> WallPair:
    """Return the walls of a ``channel`` with the wall treatment and the fluid of a ``config``."""
    model, obeys_momentum = model_of(config.fluid.rheology, channel), config.walls.treatment.obeys_momentum
    walls: list[PrescribedWall] = []
    for side, schedule in enumerate((channel.bottom, channel.top)):
        if not isinstance(model, StressModel):
            walls.append(PrescribedWall(channel, side, obeys_momentum))
        elif channel.slip_lengths[side]:
            walls.append(SlipWall(channel, side, obeys_momentum, model, channel.reference_walls[side]))
        elif isinstance(schedule, StressControlledWall):
            kind = MasslessWall if schedule.mass_per_area == 0.0 else InertialWall
            walls.append(kind(channel, side, obeys_momentum, model, channel.reference_walls[side]))
        else:
            walls.append(CoupledWall(channel, side, obeys_momentum, model))
    return WallPair(channel, walls, model)
