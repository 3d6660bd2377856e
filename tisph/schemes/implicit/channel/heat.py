"""Temperature and dissolved substances of a channel in the implicit step: quantities T that particles carry.

    T' = kappa A T + r(t),    r = heating * power + source,    power = (nu_s D u + S_xy) D u per mass                (9)

A stage solves (1 - g kappa A) T = T_K + g r after the velocities, with their power, and both anew until T stays.
T acts on the velocities by the acceleration -expansion (T - T_0) gravity along x, and by the factor a(T) of viscosity
and relaxation times (``ThermalModel``). Since heat and viscosity may amplify one another, the next guess of T mixes
the last ones (D. G. Anderson, J. ACM 12 (1965) 547-560).
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tisph.errors import DivergedError
from tisph.scenes._channel import Channel
from tisph.schemes.implicit.channel.heat_walls import Equation, NearWall
from tisph.schemes.implicit.channel.stages import (
    DEFECT,
    GAMMA,
    PREDICTORS,
    B,
    C,
    ClosedOperators,
    FlowState,
    explicit_part,
    hermite,
    norm,
    weighted,
)
from tisph.schemes.implicit.channel.walls import ISOTHERMAL, WallEffects, WallPair

KEPT_ITERATES = 4
"""Iterates that are mixed."""

DIFFERENCE = 1e-5
"""Step of numerical derivatives of the viscosity's exponent, over the scale of T."""

ROUND_OFF = 4.0
"""Change of T in an iteration, over its scale and in units of round-off, that counts as none."""

RESOLVED = 4.0
"""Thickness of a layer at a wall, in spacings, from which on fits give the flow through the wall."""

RUNAWAY = 1e-3
"""Viscosity in a flow under given forces, over the smallest one at its start and its walls, below which it heats
without end: in steady flows of Newtonian fluids with an exponential law the ratio is above 0.3."""


class NoSubstances:
    """The substances of a flow: none. ``CarriedSubstances`` has the same methods.

    ``jumping``: diffusivities of substances whose condition at a wall differs from T there when the run starts.
    """

    jumping: Sequence[float] = ()
    involved = ""
    """Beginning of an error of the flow."""

    def initial(self, heights: np.ndarray) -> np.ndarray:
        """Return T (substances, n) at ``heights`` (n,) when the run starts."""
        return np.zeros((0, len(heights)))

    def reset(self) -> None:
        """Return to the start of a run."""

    def forget(self, time: float) -> None:
        """Extrapolate nothing from before a jump of the walls at this ``time``."""

    def begin(self, start: FlowState, time: float, dt: float) -> None:
        """Begin a step of length ``dt`` at ``time`` with the flow at its ``start``."""

    def effects(self) -> Sequence[Sequence[WallEffects]]:
        """Return the effects of T at the (bottom, top) wall in the stages of a step."""
        return ISOTHERMAL, ISOTHERMAL

    def attainable(self, tolerance: float) -> float:
        """Return the ``tolerance`` of stress and temperature in a stage, or the round-off of what acts on it."""
        return tolerance

    def begin_rates(self, start: FlowState) -> None:
        """Set the rates of T at the ``start`` of a step, whose shear rates and stresses are known."""

    def begin_stage(self, stage: int, flows: Sequence[FlowState], known: FlowState) -> None:
        """Predict T in an implicit ``stage`` from the ``flows`` before, and set the factor in ``known``."""

    def with_pull(self, source: np.ndarray) -> np.ndarray:
        """Return a ``source`` of velocity with the acceleration by T."""
        return source

    def solve(self, known: FlowState, velocity: np.ndarray, shear_rate: Any, stress: Any, tolerance: float) -> bool:
        """Solve (9) in a stage; return whether this T is the one with which the velocities were found."""
        return True

    def end_stage(self, flow: FlowState) -> None:
        """Set T and its rates in the ``flow`` at the end of a stage."""

    def with_errors(self, error: float, flows: Sequence[FlowState], residual: float) -> float:
        """Return the ``error`` of the velocities of a step with the largest error of T, as (5), over its scale."""
        return error

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""

    def measure(self, slope: np.ndarray, curvature: np.ndarray) -> None:
        """Set ``slope`` and ``curvature`` (substances, n, 2 and 3) of T on particles, at the end of a step."""

    def pull_impulse(self, flows: Sequence[FlowState]) -> float:
        """Return the velocity gained by T in a step with these stages, summed over the points."""
        return 0.0

    def apply_impulse(self, flow: FlowState) -> None:
        """Change T in ``flow`` by the jumps at walls when the run starts."""

    def unbounded(self) -> str:
        """Return a text if forces heat the fluid without end, else an empty one."""
        return ""

    def seen(self, heights: np.ndarray, values: np.ndarray, time: float) -> dict[str, Any]:
        """Return the fields of a ``Snapshot`` by T (substances, n) at ``heights`` and at ``time``."""
        return {}

    def host_state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        return {}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""


class CarriedSubstances(NoSubstances):
    """The substances of a ``channel``; ``walls`` and ``operators`` of the velocities.

    ``present`` (substances, n): T of the present iterate; ``rates``: r. ``fitted``: a time, and for each wall the slope
    at given T, or T at a given flux, and r there; ``past``: these numbers at the end of the step before.
    ``received`` (4, substances): amounts that the fluid has received since the start of the run, at both ends of the
    ``last_step`` (its start and length), and their rates there.
    """

    def __init__(self, channel: Channel, operators: ClosedOperators, walls: WallPair) -> None:
        self.channel, self.operators, self.walls = channel, operators, walls
        self.viscosity = channel.solvent_viscosity
        self.equations = [Equation(each, operators, channel) for each in channel.substances]
        self.heated = any(each.heating for each in channel.substances)
        self.acts, self.first = not channel.isothermal, channel.substances[0]
        self.buoyancy = float(self.first.buoyancy[0])
        self.jumping = [each.substance.diffusivity for each in self.equations if each.jumps]
        self.involved = "temperature, " if self.acts else ""
        self.forced = channel.driven_side is not None or channel.acceleration != 0.0 or channel.drive.varies
        self.least = self.first.factor(self.initial(np.linspace(0.0, channel.gap, channel.rows))[0]).min()
        self.reset()

    def initial(self, heights: np.ndarray) -> np.ndarray:
        """Return T (substances, n) when the run starts."""
        start = self.channel.start_time
        return np.stack([each.initial(np.zeros_like(heights), heights, start) for each in self.channel.substances])

    def reset(self) -> None:
        """Return to the start of a run."""
        self.forget(self.channel.start_time)
        self.received, self.last_step = np.zeros((4, len(self.equations))), (self.channel.start_time, 0.0)

    def forget(self, time: float) -> None:
        """Extrapolate nothing from before a jump."""
        self.jump_time = time
        self.fitted: Any = None
        self.past: Any = None

    def begin(self, start: FlowState, time: float, dt: float) -> None:
        """Begin a step; see ``NoSubstances.begin``."""
        self.time, self.dt, self.gamma_dt, self.stage = time, dt, GAMMA * dt, 0
        self.present = start.substances
        self.near = [NearWall(*self.operators.near_wall(side)) for side in range(2)]
        self.heights = self.operators.point_heights()
        for each in self.equations:
            each.closed.prepare()
            each.begin(time, dt)
        start.factor = self.factor()
        if start.factor is not None and not np.all(np.isfinite(start.factor)):
            low, high = self.present[0].min(), self.present[0].max()
            raise DivergedError(f"temperature: the viscosity has no value at all of {low:.6g} to {high:.6g},")
        self.rates = np.zeros_like(self.present)
        if self.fitted is None:
            self.fitted = time, self.fit(0)

    def factor(self) -> np.ndarray | None:
        """Return the factor (n,) of viscosity and relaxation times, NaN without a value; None without an effect."""
        if not self.first.law:
            return None
        with np.errstate(all="ignore"):
            found = self.first.factor(self.present[0])
        return np.where((found > 0.0) & (found < np.inf), found, np.nan)

    def fit(self, stage: int) -> np.ndarray:
        """Return the unknown number at each wall in a ``stage``, and r there, of the present temperature (2, 2)."""
        pairs = enumerate(zip(self.near, self.equations[0].even, strict=True))
        return np.array(
            [self.equations[0].fit(side, stage, near, self.present[0], self.rates[0]) for side, (near, _) in pairs]
        )

    def effects(self) -> Sequence[Sequence[WallEffects]]:
        """Return the effects of T at the (bottom, top) wall in the stages of the step."""
        if not self.acts:
            return super().effects()
        time, values = self.fitted
        change = np.zeros_like(values) if self.past is None else (values - self.past[1]) / (time - self.past[0])
        return [
            [
                self.effect(side, stage, values[side] + c * self.dt * change[side], change[side, 0])
                for stage, c in enumerate(C)
            ]
            for side in range(2)
        ]

    def effect(self, side: int, stage: int, fitted: np.ndarray, change: float) -> WallEffects:
        """Return the effect of T at a wall in a stage, with the ``fitted`` number, which has this ``change`` a time."""
        equation, (unknown, r) = self.equations[0], fitted
        given, given_rate, _ = equation.given[side][stage]
        value, rate, slope = (unknown, change, given) if equation.even[side] else (given, given_rate, unknown)
        slope, curvature = (slope if side == 0 else -slope), (rate - r) / equation.substance.diffusivity
        b = self.buoyancy
        pull = b * (value - self.first.reference), b * rate, b * slope, b * curvature
        if not self.first.law:
            return WallEffects(*pull)
        step = DIFFERENCE * self.first.scale
        with np.errstate(all="ignore"):
            below, here, above = self.first.law.exponent(
                value + step * np.array([-1.0, 0.0, 1.0]), self.first.reference
            )
            first, second = (above - below) / (2.0 * step), (above - 2.0 * here + below) / step**2
            a = float(np.exp(here))
        return WallEffects(*pull, a, a * first * slope, a * ((first**2 + second) * slope**2 + first * curvature))

    def attainable(self, tolerance: float) -> float:
        """Return the ``tolerance`` of a stage, at least round-off where T acts on the flow."""
        return max(tolerance, ROUND_OFF * self.operators.round_off) if self.acts else tolerance

    def begin_rates(self, start: FlowState) -> None:
        """Set the rates of T at the ``start`` of a step."""
        self.find_rates(start.velocity, start.shear_rate, start.stress)
        parts = zip(self.equations, self.present, self.rates, strict=True)
        start.substance_rates = np.stack([each.rate(values, r, self.near) for each, values, r in parts])
        self.gains: list[np.ndarray] = []
        self.add_gains(start.substance_rates)

    def add_gains(self, rates: np.ndarray) -> None:
        """Append the amounts that the fluid receives in a time in the present stage, where T has these ``rates``.

        While the layers that jumps have left at walls are thin, the amount is the one by which T rises.
        """
        age, gains, channel = self.time + C[self.stage] * self.dt - self.jump_time, [], self.channel
        for each, values, r, rate in zip(self.equations, self.present, self.rates, rates, strict=True):
            starts = each.jumps or (each.substance.heating and self.walls.any_jump)
            thickness = math.sqrt(min(each.diffusivity, channel.kinematic_viscosity) * age)
            if starts and thickness < RESOLVED * channel.spacing:
                gains.append(each.substance.capacity * channel.length * channel.gap * float(rate.mean()))
            else:
                gains.append(each.gain(self.stage, self.near, values, r))
        self.gains.append(np.array(gains))

    def find_rates(self, velocity: np.ndarray, shear_rate: Any, stress: Any) -> None:
        """Set r in the present stage by the velocity, and the shear rate and extra stress that belong to it."""
        power: Any = 0.0
        if self.heated:
            if stress is None:
                boundary = self.operators.boundary_gradient(self.walls.series(self.stage))
                shear_rate, stress = self.operators.gradient(velocity, -1.0) + boundary, 0.0
            power = (self.viscosity * shear_rate + stress) * shear_rate
        time, x = self.time + C[self.stage] * self.dt, np.zeros_like(self.heights)
        for rate, each in zip(self.rates, self.channel.substances, strict=True):
            rate[...] = each.heating * power + (each.source(x, self.heights, time) if each.has_source else 0.0)

    def begin_stage(self, stage: int, flows: Sequence[FlowState], known: FlowState) -> None:
        """Begin an implicit ``stage``; see ``NoSubstances.begin_stage``."""
        rates, start = [flow.substance_rates for flow in flows], flows[0].substances
        self.stage, self.known = stage, explicit_part(start, stage, self.dt, rates)
        self.present = start + self.dt * weighted(PREDICTORS[stage], rates)
        self.iterates: list[tuple[np.ndarray, np.ndarray]] = []
        known.factor = self.factor()

    def with_pull(self, source: np.ndarray) -> np.ndarray:
        """Return a ``source`` of velocity with the acceleration by T."""
        return source + self.buoyancy * (self.present[0] - self.first.reference) if self.buoyancy else source

    def solve(self, known: FlowState, velocity: np.ndarray, shear_rate: Any, stress: Any, tolerance: float) -> bool:
        """Solve (9) in a stage; see ``NoSubstances.solve``."""
        self.find_rates(velocity, shear_rate, stress)
        found = np.empty_like(self.present)
        for each, values, *part in zip(self.equations, found, self.known, self.rates, self.present, strict=True):
            values[...] = each.solve(part, self.stage, self.near, self.gamma_dt, tolerance)
        change = found[0] - self.present[0]
        settled = not self.acts or norm(change) <= self.attainable(tolerance) * self.first.scale
        if not settled:
            self.iterates = [*self.iterates, (self.present[0], change)][-KEPT_ITERATES:]
            found[0] = mixed(self.iterates)
        self.present = found
        known.factor = self.factor()
        return settled

    def end_stage(self, flow: FlowState) -> None:
        """Set T and its rates in the ``flow`` at the end of a stage."""
        flow.substances, flow.substance_rates = self.present, (self.present - self.known) / self.gamma_dt
        self.add_gains(flow.substance_rates)

    def with_errors(self, error: float, flows: Sequence[FlowState], residual: float) -> float:
        """Return the error with the errors of T; see ``NoSubstances.with_errors``."""
        defects, errors = self.dt * weighted(DEFECT, [flow.substance_rates for flow in flows]), [0.0]
        for each, defect in zip(self.equations, defects, strict=True):
            found = each.closed.solve(self.gamma_dt, None, defect, np.zeros_like(defect), residual)
            errors.append(math.nan if found is None else norm(found) / each.substance.scale)
        return math.hypot(error, self.channel.reference_velocity * float(np.max(errors)))

    def conclude(self) -> None:
        """Accept the step: its end is the start of the next."""
        self.past, self.fitted = self.fitted, (self.time + self.dt, self.fit(-1))
        end = self.received[1] + self.dt * weighted(B, self.gains)
        self.received = np.stack([self.received[1], end, self.gains[0], self.gains[-1]])
        self.last_step = self.time, self.dt

    def measure(self, slope: np.ndarray, curvature: np.ndarray) -> None:
        """Set the derivatives of T on particles at the end of a step."""
        for each, values, r, *found in zip(self.equations, self.present, self.rates, slope, curvature, strict=True):
            each.closed.derivatives(values, each.series(-1, r, self.near), *found)  # type: ignore[attr-defined]

    def pull_impulse(self, flows: Sequence[FlowState]) -> float:
        """Return the velocity gained by T in a step; see ``NoSubstances.pull_impulse``."""
        sums = [float(np.sum(flow.substances[0] - self.first.reference)) for flow in flows] if self.buoyancy else [0.0]
        return self.dt * self.buoyancy * float(weighted(B, sums))

    def apply_impulse(self, flow: FlowState) -> None:
        """Change T by the jumps at walls when the run starts."""
        if self.time == self.channel.start_time:
            changes = np.stack([each.impulse() for each in self.equations])
            flow.substances = flow.substances + changes
            capacities = np.array([each.capacity for each in self.channel.substances])
            self.received[:2] += self.channel.gap * self.channel.length * capacities * changes.mean(axis=1)

    def unbounded(self) -> str:
        """Return a text if forces heat the fluid without end; see ``NoSubstances.unbounded``."""
        if not (self.heated and self.first.law and self.forced):
            return ""
        temperature = self.equations[0]
        given = [temperature.given[side][-1][0] for side in range(2) if not temperature.even[side]]
        usual = min([self.least, *self.first.factor(np.array(given))])
        if not self.factor().min() < RUNAWAY * usual:  # type: ignore[union-attr]
            return ""
        highest = f"{self.present[0].max():.4g} {self.first.unit}".rstrip()
        return f"u: the temperature has risen to {highest}, and heat is made faster than walls take it; no steady flow,"

    def seen(self, heights: np.ndarray, values: np.ndarray, time: float) -> dict[str, Any]:
        """Return the fields of a ``Snapshot``."""
        names = [each.name for each in self.channel.substances]
        parts = zip(self.equations, values, strict=True)
        flows = np.array([[each.flow(side, heights, one, time) for side in range(2)] for each, one in parts])
        start, dt = self.last_step
        received = hermite((time - start) / dt, dt, *self.received) if dt else self.received[1]
        return {"substances": dict(zip(names, values.copy(), strict=True)), "flows": flows, "received": received}

    def host_state(self) -> dict[str, Any]:
        """Return the numbers that a resumed run needs."""
        pairs = {
            "fitted": self.fitted,
            "past": self.past,
            "last_step": ((*self.last_step, self.jump_time), self.received),
        }
        return {name: pair and [pair[0], pair[1].tolist()] for name, pair in pairs.items()}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        pairs = {name: pair and (pair[0], np.array(pair[1])) for name, pair in state.items()}
        self.fitted, self.past, ((*self.last_step, self.jump_time), self.received) = pairs.values()


def mixed(iterates: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return the next guess x by the last pairs of a guess x (n,) and its change f(x), whose zero is sought."""
    guess, change = iterates[-1]
    if len(iterates) == 1:
        return guess + change
    steps, falls = (np.diff(np.stack(each), axis=0) for each in zip(*iterates, strict=True))
    gram, right = np.einsum("in,jn->ij", falls, falls), np.einsum("in,n->i", falls, change)
    parts = np.linalg.lstsq(gram, right, rcond=None)[0]
    return guess + change - np.einsum("i,in->n", parts, steps + falls)
