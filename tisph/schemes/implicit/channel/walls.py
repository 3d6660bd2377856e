"""The walls of a channel in the implicit step: the Taylor series of velocity and stress at them, and their impulses.

Images beyond a wall continue the flow. With the distance d from the wall, an image I of a fluid particle F has

    u_I = 2 (U + d^2/2 u_yy + d^4/24 u_yyyy) - u_F,    S_I = S_F - 2 d S_d - d^3/3 S_ddd,

with the wall velocity U, the extra stress S and the derivatives S_d along d. By the momentum equation at the wall,
with the body acceleration g,

    u_yy = (U' - g - S_y)/nu_s,    u_yyyy = (U'' - g' - S_yyy')/nu_s .

The slopes of the states C obey the derivative of the law of the fluid at the wall,

    C_y' = F_C C_y + F_u' u_yy,    S_y = S_C C_y.

Except for products of slopes the third derivatives obey the same equations, with u_yyyy and (u_yy)' in the places of
u_yy and U' - g. ``CoupledWall`` integrates both with the method of the step. The matrices are F_C, F_u' and S_C of the
fluid at the wall in the stages, extrapolated from the last two steps.

**Impulses.** A wall whose velocity jumps by J has U' = J delta(t) and U'' = J delta'(t). A wall whose acceleration
relative to the body acceleration jumps by J_1 has U'' = J_1 delta(t). The series of the images, integrated over the
jump, change the velocities once by

    du = J (g_2 + A g_4) + J_1/nu g_4,    g_2k = sum over the images of the entries of A times 2 d^2k/(2k)!

That is the momentum of the layer that the particles do not resolve yet (``schemes/wcsph/_boundaries.py`` has the terms
of lower order). With an extra stress and y = (u, C, C_y and C_yyy at the walls) the discrete equations are
y' = M y + B_1 U' + B_2 U'' + ...: J changes y by (B_1 + M B_2) J, and J_1 by B_2 J_1, linearised about the fluid at the
wall. These are the first terms of a series in s = modulus * spacing^2/nu_s^2. Where the term of the polymer is larger
than the term of the solvent, the series diverges and would move fluid faster than the wall. The momentum that the wall
gives to the solvent spreads to the whole fluid in the time lambda nu_s/nu, which is nu_p/(nu_s s) times the time in
which a layer becomes one spacing thick. The wall then gives the impulse of an inelastic fluid with the total viscosity,
and the polymer stays at rest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.scenes._channel import Channel
from tisph.schemes.implicit.channel.models import FluidModel, StressModel, at_factor
from tisph.schemes.implicit.channel.stages import (
    GAMMA,
    B,
    C,
    ClosedOperators,
    FlowState,
    Series,
    Solution,
    explicit_part,
    weighted,
)

TREATMENTS = "comoving_image", "consistent_image", "virtual_image"
"""Wall treatments of the implicit scheme."""

NEAR, TERMS = 0.1, 8
"""The derivatives of C at a wall when a run starts: width of the layer over the gap, terms of the polynomial in it."""


@dataclass(frozen=True)
class WallEffects:
    """Effects of the temperature on the fluid at a wall: a body acceleration b along x, and the factor a of viscosity.

    ``pull``, ``pull_rate``, ``pull_slope`` and ``pull_curvature``: b, b_t, b_y and b_yy. ``factor``, ``factor_slope``
    and ``factor_curvature``: a, a_y and a_yy; the first None without an effect.
    """

    pull: float = 0.0
    pull_rate: float = 0.0
    pull_slope: float = 0.0
    pull_curvature: float = 0.0
    factor: float | None = None
    factor_slope: float = 0.0
    factor_curvature: float = 0.0


ISOTHERMAL = (WallEffects(),) * len(C)
"""The effects at a wall in the stages of a step where there are none."""


class WallPair:
    """The (bottom, top) wall of a ``channel``; ``model``: response of the extra stress of the fluid.

    ``obeys_momentum``: whether the series of the images follow from the momentum equation. ``any_jump``: whether a
    velocity, an acceleration or a stress jumps, at the start or later. ``even_reflection``: whether images of
    velocities beyond the (bottom, top) wall have the sign of their sources. ``coupled``: whether there is an extra
    stress. ``steady``: whether the series never change between jumps. ``stress_controlled``: walls whose velocity is
    not given, or along which the fluid slips.
    """

    def __init__(self, channel: Channel, walls: "Sequence[PrescribedWall]", model: FluidModel) -> None:
        self.channel, self.walls, self.model = channel, walls, model
        self.obeys_momentum = walls[0].obeys_momentum
        self.coupled = isinstance(model, StressModel)
        self.steady = not self.coupled and not any(wall.oscillates for wall in walls)
        self.any_jump = any(any(wall.jumps) or wall.schedule.jump_times or wall.even_reflection for wall in walls)
        self.any_jump = self.any_jump or bool(channel.drive.jump_times)
        self.drive, self.body_acceleration = channel.drive.after(channel.start_time), [channel.acceleration] * len(C)
        self.even_reflection = tuple(wall.even_reflection for wall in walls)
        self.stress_controlled: list[Any] = [wall for wall in walls if not wall.prescribed]
        self.past: Any = None
        self.present: Any = None

    def __iter__(self) -> Iterator["PrescribedWall"]:
        return iter(self.walls)

    def start(self) -> None:
        """Return to the start of the run, and take the derivatives of C at the walls from its initial flow."""
        self.past = self.present = None
        for wall in self.walls:
            wall.start()

    def enter(self, time: float) -> None:
        """Use wall motions and drive from ``time`` on, and extrapolate nothing from before a jump."""
        self.past = None
        self.drive = self.channel.drive.after(time)
        for wall in self.walls:
            wall.enter(time)

    def set_effects(self, effects: Sequence[Sequence[WallEffects]]) -> None:
        """Set the ``effects`` of the temperature at the (bottom, top) wall in the stages of the next step."""
        for wall, own in zip(self.walls, effects, strict=True):
            wall.effects = own

    def begin(self, time: float, dt: float, near: np.ndarray | None, operators: ClosedOperators) -> None:
        """Begin a step of length ``dt`` at ``time``.

        ``near`` (2, components + 1): C and shear rate of the fluid at the walls, which are extrapolated linearly to the
        stages; None without an extra stress.
        """
        stages: Any = None
        if self.drive.varies:
            self.body_acceleration = [self.drive.value(time + c * dt) for c in C]
        if near is not None:
            self.present, change = (time, near), 0.0
            if self.past is not None:
                before, values = self.past
                change = (near - values) / (time - before)
            stages = np.array([near + c * dt * change for c in C])
        for side, wall in enumerate(self.walls):
            wall.begin(time, dt, None if stages is None else stages[:, side], operators)

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        self.past = self.present
        for wall in self.walls:
            wall.conclude()

    def series(self, stage: int) -> list[Series]:
        """Return the ``Series`` of the (bottom, top) wall in a ``stage`` of the step."""
        return [wall.series[stage] for wall in self.walls]

    def mean_series(self) -> tuple[Any, Any]:
        """Return the means of ``series`` (2, 3) and of ``stress_series`` (2, 2) over the step."""
        stages = list(enumerate(B))
        return (
            sum(weight * np.array(self.series(stage)) for stage, weight in stages),
            sum(weight * np.array(self.stress_series(stage)) for stage, weight in stages),
        )

    def stress_series(self, stage: int) -> list[tuple[float, float]]:
        """Return the arguments of ``stress_excess`` for the (bottom, top) wall in a ``stage`` of the step."""
        return [wall.stress_series[stage] for wall in self.walls]

    def apply_impulse(
        self, flow: FlowState, time: float, operators: ClosedOperators, near: np.ndarray | None
    ) -> list[float]:
        """Change the ``flow`` by the jumps of the walls at ``time``; ``near`` as in ``begin``.

        Returns the velocity gained from the (bottom, top) wall, summed over the particles.
        """
        gains = [0.0, 0.0]
        self.enter(time)
        for wall in self.walls:
            jumps = wall.jumps if time == self.channel.start_time else wall.later_jumps(time)
            if self.obeys_momentum and any(jumps):
                gained = wall.apply_jump(flow, operators, *jumps, None if near is None else near[wall.side])
                flow.velocity += gained
                gains[wall.side] += float(gained.sum(dtype=float))
        for wall in self.walls:
            change = wall.apply_stress_jump(operators, time)
            if change is not None:
                flow.velocity += change
                gains[wall.side] += float(change.sum(dtype=float))
        return gains

    def match(self, operators: ClosedOperators, solution: Solution, *system: Any) -> Solution | None:
        """Return the ``solution`` of a stage with the wall velocities at which stresses balance; None on failure.

        ``system``: gamma dt, the tangent and the tolerance of the linear systems of the stage. The velocities U of the
        walls change by dU, with the stress sigma_ij at wall i by a unit velocity of wall j:

            (mass_i/(gamma dt) + friction_i) dU_i - s_i sum_j sigma_ij dU_j = -residual_i
        """
        walls = [wall for wall in self.stress_controlled if not wall.even_reflection]
        sheared = [wall.respond(operators, *system) for wall in walls]
        if not walls or any(one is None for one in sheared):
            return None if walls else solution
        (gamma_dt, tangent, _), (velocity, shear_rate, stress) = system, solution
        viscosity, count = walls[0].viscosity, len(walls)
        right, (matrix, more) = np.zeros(count), np.zeros((2, count, count))
        for i, wall in enumerate(walls):
            wall.total = wall.fitted_stress(viscosity * shear_rate + stress, wall.driving)
            for j, rate in enumerate(sheared):
                more[i, j] = wall.fitted_stress((viscosity + tangent) * rate, (i == j) / gamma_dt)
            matrix[i] = -wall.normal_sign * more[i]
            matrix[i, i] += wall.mass / gamma_dt + wall.friction
            residual = wall.mass * wall.rate - wall.stress - wall.normal_sign * wall.total
            right[i] = -residual - wall.friction * wall.stage_velocity
        changes = np.linalg.solve(matrix, right)
        for wall, change, rate, more_of in zip(walls, changes.tolist(), sheared, more, strict=True):
            wall.total += float(more_of @ changes)
            wall.set_velocity(wall.stage_velocity + change)
            velocity, shear_rate = velocity + change * wall.response, shear_rate + change * rate
            stress = stress + change * tangent * rate
        return velocity, shear_rate, stress

    def host_state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        past = self.past and (self.past[0], self.past[1].tolist())
        return {"walls": [wall.host_state() for wall in self.walls], "past": past}

    def restore_host_state(self, state: dict[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        self.past = state["past"] and (state["past"][0], np.array(state["past"][1]))
        for wall, own in zip(self.walls, state["walls"], strict=True):
            wall.restore_host_state(own)


class PrescribedWall:
    """A wall of given velocity beside a Newtonian fluid, and the interface of the other walls.

    ``side``: 0 bottom, 1 top. ``normal_sign``: sign of the normal into the fluid. ``prescribed``: whether the fluid at
    the wall has a given velocity. ``even_reflection``: whether images
    of velocities have the sign of their sources. ``series`` and ``stress_series``: for each stage of the step its
    ``Series``, and the derivatives of S_xy for ``stress_excess``. ``jumps``: jump of the velocity, and jump of the
    acceleration relative to the body acceleration, when the run starts. ``defect``: difference of third and second
    order in the velocity of the wall over the step. ``kept``: names of the numbers that a resumed run needs.
    """

    prescribed = True
    even_reflection = False
    defect = 0.0
    kept: tuple[str, ...] = ()

    def __init__(self, channel: Channel, side: int, obeys_momentum: bool) -> None:
        self.channel, self.side, self.obeys_momentum = channel, side, obeys_momentum
        self.viscosity = channel.solvent_viscosity
        self.normal_sign = 1.0 if side == 0 else -1.0
        self.schedule: Any = (channel.bottom, channel.top)[side]
        self.oscillates = self.schedule.oscillates or channel.drive.varies or not channel.isothermal
        self.effects: Sequence[WallEffects] = ISOTHERMAL
        self.jumps = self.first_jumps()
        self.series: list[Any] = []
        self.stress_series: list[Any] = []
        self.enter(channel.start_time)

    def first_jumps(self) -> tuple[float, float]:
        """Return ``jumps``."""
        channel, acceleration = self.channel, self.schedule.acceleration(0.0)
        if channel.start_time > 0.0:
            return 0.0, 0.0
        if not channel.starts_developed:
            return channel.wall_jumps[self.side], acceleration - channel.drive.value(0.0)
        before = 0.0 if self.schedule.before is not None else acceleration
        return channel.wall_jumps[self.side], acceleration - before

    def later_jumps(self, time: float) -> tuple[float, float]:
        """Return the jumps of velocity and acceleration at a ``time`` after the start."""
        points = self.schedule.breakpoints
        jump, bend = next((tuple(both) for when, *both in points if when == time), (0.0, 0.0))
        return jump, bend - self.channel.drive.jump(time)

    def start(self) -> None:
        """Return to the start of the run."""

    def enter(self, time: float) -> None:
        """Use the motion of the wall from ``time`` to its next jump."""
        self.motion, self.drive = self.schedule.after(time), self.channel.drive.after(time)
        self.steady_series: list[Series] | None = None

    def begin(self, time: float, dt: float, fluid: Any, operators: ClosedOperators) -> None:
        """Begin a step of length ``dt`` at ``time``, see ``WallPair.begin``.

        ``fluid`` (stages, components + 1): C and shear rate of the fluid at the wall in the stages.
        """
        if self.steady_series is None or self.oscillates:
            pairs = zip(C, self.effects, strict=True)
            self.steady_series = [self.series_at(time + c * dt, effects) for c, effects in pairs]
        self.series, self.stress_series = self.steady_series, [(0.0, 0.0)] * len(C)

    def series_at(self, time: float, effects: WallEffects) -> Series:
        """Return the ``Series`` 2 (U + d^2/2 u_yy + d^4/24 u_yyyy) at ``time``, with the ``effects`` then."""
        velocity = 2.0 * self.motion.velocity(time)
        if not self.obeys_momentum:
            return [velocity, 0.0, 0.0]
        nu = self.channel.kinematic_viscosity
        second = (self.motion.acceleration(time) - self.drive.value(time) - effects.pull) / nu
        driving_rate = self.motion.jerk(time) - self.drive.slope(time) - effects.pull_rate
        driving_rate -= nu * effects.pull_curvature
        return [velocity, second, driving_rate / nu**2 / 12.0]

    @property
    def mean_pull(self) -> float:
        """Mean over the step of the acceleration by the temperature at the wall."""
        return float(weighted(B, [effects.pull for effects in self.effects]))

    def acceleration(self, time: float) -> float:
        """Return the acceleration of the wall where the momentum equation at the wall contains it, else 0."""
        return self.motion.acceleration(time)

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""

    def state_excess(self, component: int) -> tuple[float, float]:
        """Return the derivatives of a component of C at the wall for its images, arguments of ``stress_excess``."""
        return 0.0, 0.0

    def acceleration_response(self, operators: ClosedOperators) -> np.ndarray:
        """Return g_4/nu, the change of the velocities by a unit jump J_1 of the acceleration."""
        nu = self.viscosity
        return nu * operators.boundary_laplacian(one_sided(self.side, (0.0, 0.0, 1.0 / (12.0 * nu**2))))

    def velocity_response(self, operators: ClosedOperators, fourth: float, by_acceleration: np.ndarray) -> np.ndarray:
        """Return the change of the velocities by a unit jump J of the velocity, whose series has u_yy = 1/nu.

        ``fourth``: coefficient of d^4 in that series; ``by_acceleration``: the ``acceleration_response``.
        """
        nu, series = self.viscosity, one_sided(self.side, (0.0, 1.0 / self.viscosity, fourth))
        return nu * (operators.boundary_laplacian(series) + operators.laplacian(by_acceleration))

    def apply_jump(
        self, flow: FlowState, operators: ClosedOperators, jump: float, rate: float, fluid: Any
    ) -> np.ndarray:
        """Return the change of the fluid's velocities by a ``jump`` of the wall's velocity and ``rate`` of U'.

        With an extra stress this also changes the states of ``flow`` and their derivatives at the wall.
        ``fluid`` (components + 1): C and shear rate of the fluid at the wall.
        """
        second = self.acceleration_response(operators)
        return jump * self.velocity_response(operators, 0.0, second) + rate * second

    def apply_stress_jump(self, operators: ClosedOperators, time: float) -> np.ndarray | None:
        """Return the change of the fluid's velocities by a jump of the stress on the wall; None without one."""
        return None

    def host_state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        return {name: np.asarray(getattr(self, name)).tolist() for name in self.kept}

    def restore_host_state(self, state: dict[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        for name in self.kept:
            setattr(self, name, np.array(state[name]) if isinstance(state[name], list) else state[name])


class CoupledWall(PrescribedWall):
    """A wall of given velocity beside a fluid with an extra stress; ``model``: the response of the stress.

    ``slope`` and ``third`` (components,): C_y and C_yyy of the fluid at the wall.
    """

    kept: tuple[str, ...] = ("slope", "third")

    def __init__(self, channel: Channel, side: int, obeys_momentum: bool, model: StressModel) -> None:
        super().__init__(channel, side, obeys_momentum)
        self.model = model
        self.forget()

    def forget(self) -> None:
        """Return to a fluid in which C is 0 near the wall."""
        self.slope, self.third = np.zeros((2, self.model.components))

    def start(self) -> None:
        """Take the derivatives of C along y at the wall from the initial flow of the channel."""
        self.forget()
        gap, radius = self.channel.gap, NEAR * self.channel.gap
        distance = np.polynomial.chebyshev.chebpts1(TERMS) + 1.0
        height = 0.5 * radius * distance if self.side == 0 else gap - 0.5 * radius * distance
        fit = np.polynomial.polynomial.polyfit(distance, self.model.initial(self.channel, height).T, TERMS - 1)
        scale = self.normal_sign * 2.0 / radius
        self.initialise([fit[0], scale * fit[1], 2.0 * scale**2 * fit[2], 6.0 * scale**3 * fit[3]])

    def initialise(self, derivatives: Sequence[np.ndarray]) -> None:
        """Set the derivatives of orders 0 to 3 of C along y at the wall (4, components)."""
        self.slope, self.third = derivatives[1], derivatives[3]

    def begin(self, time: float, dt: float, fluid: Any, operators: ClosedOperators) -> None:
        """Begin a step: integrate C_y and C_yyy over it; see ``PrescribedWall.begin``."""
        self.series, self.stress_series = [], []
        rates: list[np.ndarray] = []
        third_rates: list[np.ndarray] = []
        for stage, (c, values, effects) in enumerate(zip(C, fluid, self.effects, strict=True)):
            system = WallSystem(GAMMA * dt if stage else 0.0, self.model, self.viscosity, values, effects)
            known = explicit_part(self.slope, stage, dt, rates), explicit_part(self.third, stage, dt, third_rates)
            motion, when = self.motion, time + c * dt
            driving = motion.acceleration(when) - self.drive.value(when) - effects.pull
            driving_rate = motion.jerk(when) - self.drive.slope(when)
            derivatives, (rate, third_rate) = system.derivatives(*known, driving, driving_rate)
            rates.append(rate)
            third_rates.append(third_rate)
            self.prescribe(motion.velocity(when), *derivatives)
        self.ends = derivatives[:2]

    def prescribe(
        self, velocity: float, _slope: Any, _third: Any, second: float, fourth: float, *stress: float
    ) -> None:
        """Append the series of a stage by the wall velocity, u_yy, u_yyyy, and S_y and S_yyy."""
        if not self.obeys_momentum:
            second = fourth = 0.0
            stress = 0.0, 0.0
        self.series.append([2.0 * velocity, second, fourth / 12.0])
        self.stress_series.append(stress)

    def state_excess(self, component: int) -> tuple[float, float]:
        """Return the derivatives of a component of C at the wall for its images, arguments of ``stress_excess``."""
        return self.slope[component], 0.0

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        self.slope, self.third = self.ends

    def apply_jump(
        self, flow: FlowState, operators: ClosedOperators, jump: float, rate: float, fluid: Any
    ) -> np.ndarray:
        """Apply a jump of velocity and acceleration; see ``PrescribedWall.apply_jump``."""
        nu, velocity_2 = self.viscosity, self.acceleration_response(operators)
        alone = self.velocity_response(operators, 0.0, velocity_2)  # the solvent alone
        model = at_factor(self.model, nu, self.effects[0].factor)
        decay, stretching, stress, _ = model.jacobian(fluid[:-1], fluid[-1])
        modulus, third_2 = float(stress @ stretching), stretching / nu**2
        fourth = -modulus / (6.0 * nu**3)  # by S_yyy, and by C_y in S_y
        sheared_2 = operators.boundary_gradient(one_sided(self.side, (0.0, 0.0, 1.0 / (12.0 * nu**2))))
        velocity = self.velocity_response(operators, fourth, velocity_2)
        images = operators.boundary_stress(self.side, 0.0, stress @ third_2)
        velocity += operators.gradient(modulus * sheared_2, 1.0) + images
        if jump != 0.0 and np.abs(velocity - alone).max() > np.abs(alone).max():
            total = nu - stress @ np.linalg.solve(decay, stretching)
            return jump * alone + rate * nu / total * velocity_2
        sheared = operators.boundary_gradient(one_sided(self.side, (0.0, 1.0 / nu, fourth)))
        sheared = sheared + operators.gradient(velocity_2, -1.0)
        self.slope = self.slope + jump * stretching / nu
        falling = (decay - np.outer(stretching, stress) / nu) @ third_2 - modulus / nu * third_2
        self.third = self.third + jump * falling + rate * third_2
        self.model.apply_shear(flow.state, jump * sheared + rate * sheared_2)
        flow.state += np.multiply.outer(decay @ stretching, jump * sheared_2)
        return jump * velocity + rate * velocity_2


class WallSystem:
    """The equations of C_y and u_yy, and of C_yyy and u_yyyy, in a stage, with the law's derivatives at the wall.

    ``fluid`` (components + 1): C and shear rate of the fluid at the wall. By the factor a of the temperature

        C_y' = F_C C_y + F_u' u_yy + F_a a_y,    S_y = S_C C_y + S_u' u_yy + S_a a_y .
    """

    def __init__(
        self, gamma_dt: float, model: StressModel, viscosity: float, fluid: np.ndarray, effects: WallEffects
    ) -> None:
        local = at_factor(model, viscosity, effects.factor)
        decay, self.stretching, self.stress, self.tangent = local.jacobian(fluid[:-1], fluid[-1])
        self.gamma_dt, self.viscosity, self.effects = gamma_dt, viscosity + self.tangent, effects
        self.matrix = decay - np.outer(self.stretching, self.stress) / self.viscosity
        self.state_by_factor, self.stress_by_factor = local.by_factor(fluid[:-1], fluid[-1])

    def solve(self, known: np.ndarray, driving: float, factor_slope: float) -> tuple[np.ndarray, np.ndarray, float]:
        """Solve C_y = ``known`` + g C_y' for given ``driving`` = nu_s u_yy + S_y and a_y; return C_y, C_y', u_yy."""
        driving = driving - self.stress_by_factor * factor_slope
        source = self.stretching * driving / self.viscosity + self.state_by_factor * factor_slope
        slope = np.linalg.solve(np.eye(len(source)) - self.gamma_dt * self.matrix, known + self.gamma_dt * source)
        return slope, self.matrix @ slope + source, (driving - self.stress @ slope) / self.viscosity

    def derivatives(
        self, known: np.ndarray, known_third: np.ndarray, driving: float, driving_rate: float, thermal: float = 1.0
    ) -> tuple[tuple[Any, ...], tuple[np.ndarray, np.ndarray]]:
        """Return (C_y, C_yyy, u_yy, u_yyyy, S_y, S_yyy) and (C_y', C_yyy').

        ``driving``: nu_s u_yy + S_y = U' - g - b, and U'' - g', the ``driving_rate`` without b_t. ``thermal``: part
        of the effects of the temperature.
        """
        effects, factor_slope = self.effects, thermal * self.effects.factor_slope
        slope, rate, second = self.solve(known, driving, factor_slope)
        driving = (driving_rate - thermal * effects.pull_rate - self.stress @ rate) / self.viscosity
        third, third_rate, fourth = self.solve(known_third, driving - thermal * effects.pull_curvature, 0.0)
        stress_slope = self.stress_slope(slope, second) + self.stress_by_factor * factor_slope
        stress = stress_slope, self.stress_slope(third, fourth)
        return (slope, third, second, fourth, *stress), (rate, third_rate)

    def stress_slope(self, slope: np.ndarray, curvature: float) -> float:
        """Return S_y = S_C C_y + (dS/d shear rate) u_yy, without the effect of the temperature."""
        return float(self.stress @ slope) + self.tangent * curvature


def one_sided(side: int, series: Series) -> list[Series]:
    """Return the series of both walls, with 0 for the other wall."""
    both: list[Series] = [[0.0] * 3, [0.0] * 3]
    both[side] = series
    return both


def stress_excess(depth: np.ndarray, side: int, even_reflection: bool, slope: float, third: float) -> np.ndarray:
    """Return S_xy of images at a ``depth`` beyond the lower (``side`` 0) or upper wall, less S_xy of their sources.

    ``slope`` and ``third``: first and third derivative of S_xy along y at the wall; beyond a wall with even reflection
    S_xy at the wall and its second derivative.
    """
    if even_reflection:
        return 2.0 * slope + depth**2 * third
    return (1.0 if side == 0 else -1.0) * (depth * (-2.0 * slope - depth**2 / 3.0 * third))
