"""Estimates for ``tisph check`` before a run: its steps and time, and for the implicit scheme its errors.

In a plane flow on the lattice all particles of a layer have the same velocity. ``ImplicitLayers`` takes the steps of
the run with one velocity for each layer, at a thousandth of its cost: the step, walls, start and step control are the
same code, and the operators are matrices. The exact solution is known, so the error and the number of steps of every
sample are computed. Layers do not represent disordered particles and single precision. For such runs, for the explicit
scheme and for two-dimensional flows no error is stated before the run; ``tisph run --estimate-error`` states one.

The stability matrix (``tisph stability``) measured the limits of cell Reynolds numbers and stiffness.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from tisph.config.schema import Config
from tisph.measures.metrics import relative_error, rms_error
from tisph.numerics import SUPPORT
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.schemes._protocol import SampleEstimate, SchemeEstimates
from tisph.schemes._step_control import StepControl, steps_between
from tisph.schemes.implicit.channel.stages import EMBEDDED_ORDER, ClosedOperators, FlowState, Series
from tisph.schemes.implicit.channel.step import SOLVER_TOLERANCE, WORST, ImplicitStep
from tisph.schemes.implicit.channel.stress_controlled import wall_pair_of
from tisph.schemes.implicit.channel.walls import stress_excess
from tisph.schemes.wcsph._time_step import limits_of, sound_speed_of

EXPLICIT_COST = 150e-9
"""Rough cost of one particle and step of the explicit scheme on two threads [s]."""

IMPLICIT_COST, IMPLICIT_OVERHEAD = 2.5e-6, 2e-3
"""Rough cost of one particle and step of the implicit scheme, order 4, and of a step without particles [s]."""

COUPLED = 5.0
"""Factor of that cost with a viscosity that varies, a polymer or a wall of given stress: 4.9 to 6.4 in four runs."""

EXPLICIT_STEPS = 1.0, 1.01
"""Steps of a run of the explicit scheme over the counted ones, least and most: in the stability matrix 1 to 1.004."""

STABLE_CELL_RE = 60.0
"""Cell Reynolds number U spacing/nu up to which disordered runs of the explicit scheme vary little in density in the
stability matrix, and above which they mix."""

LOST_LAYERS = 4.0
"""Cell Reynolds number over ``STABLE_CELL_RE``, over the thickness of the layer at a wall in spacings, from which on
half of the profile is lost."""

DISORDERED_CELL_RE_OF_ORDER_2 = 1.0
"""Cell Reynolds number above which disordered runs of order 2 of the implicit scheme have any error, or stop."""

DISORDERED_SOLVENT_CELL_RE = 10.0
"""Cell Reynolds number by the viscosity of the solvent, with polymer, up to which disordered runs are stable. One
failed at 20; above it they take more steps and have larger errors than layers, or stop."""

STIFF_POLYMER = 4.0
"""Modulus of the polymer per unit density times (spacing over solvent viscosity) squared, up to which disordered
particles of the implicit scheme have the error of a lattice at an impulsively started wall: they had it at 3.5; at 14
it was eight times as large."""

MOST_LAYERS = {"newtonian": 128, "coupled": 50}
"""Most layers of a computation. On a finer lattice the estimate is the error of the steps alone."""

RESTS = 100.0
"""Reference velocity over the root mean square of the fluid's, above which it counts as at rest."""

LAYERS, DISORDERED, GUESSED = (0.97, 1.03), (0.9, 1.4), (0.3, 2.0)
"""Least and largest ratio of the steps of a run to the estimate: on a lattice; for disordered particles or in single
precision; where the arrangement may break up or steps are only counted. In the stability matrix the ratios are 0.99 to
1.01, 0.95 to 1.37 and 0.36 to 1.75."""

MOST_STEPS = 1000
"""Most steps that are computed, in some seconds. Later steps count as having the mean length of the second half."""

LATER = (np.arange(20) + 0.5) / 20
"""Parts of the remaining time at which the strain of the exact solution gives the length of steps."""

EXACT = 1e-12
"""Tolerance of a stage, whose systems are solved directly."""

STEADY = 1e-12
"""Change of the velocities in a step, over the largest velocity, below which the flow is steady."""


def explicit(config: Config, channel: Scene) -> SchemeEstimates:
    """Return the estimates of a run of scheme ``wcsph`` in a scene ``channel``."""
    sound = sound_speed_of(config, channel)
    limits = limits_of(
        config,
        channel,
        sound,
        speed=channel.peak_velocity,
        acceleration=abs(channel.acceleration) + (channel.pulsation.largest_speed if channel.pulsation else 0.0),
        elastic_speed=channel.elastic_speed,
    )
    binding = min(limits, key=lambda name: limits[name])
    *counts, steps = step_counts(config.start_time, [*config.time.samples, config.time.end], limits[binding])
    samples = zip(config.time.samples, counts, strict=True)
    return {
        "mach": channel.peak_velocity / sound,
        "sound_speed": sound,
        "time_step": limits[binding],
        "binding_limit": binding,
        "steps": steps,
        "run_time": channel.particles * steps * EXPLICIT_COST,
        "lost": isinstance(channel, Channel) and profile_lost(config, channel),
        "samples": [SampleEstimate(t, n, steps_factors=EXPLICIT_STEPS) for t, n in samples],
    }


def implicit(config: Config, channel: Channel, control: StepControl) -> SchemeEstimates:
    """Return the estimates of a run of scheme ``implicit``, with the ``control`` of its steps."""
    samples, layers = layer_estimates(config, channel, control)
    cost = IMPLICIT_OVERHEAD + channel.rows * channel.columns * IMPLICIT_COST
    return {
        "mach": 0.0,
        "sound_speed": None,
        "time_step": layers.longest,
        "binding_limit": "cfl" if control.fixed else "strain" if layers.strained else "accuracy",
        "steps": layers.steps,
        "run_time": layers.steps * cost * (COUPLED if is_coupled(config, channel) else 1.0),
        "lost": False,
        "samples": samples,
    }


def step_counts(start: float, targets: Sequence[float], longest: float) -> list[int]:
    """Return the numbers of steps no longer than ``longest`` from ``start`` to each target (ascending), hit exactly."""
    pairs = itertools.pairwise([start, *targets])
    steps = (steps_between(before, after, longest) if after > before else 0 for before, after in pairs)
    return list(itertools.accumulate(steps))


def cell_reynolds(channel: Scene) -> float:
    """Return the Reynolds number of a spacing, U spacing / nu."""
    return channel.reference_velocity * channel.spacing / channel.kinematic_viscosity


def profile_lost(config: Config, channel: Channel) -> bool:
    """Tell whether the explicit scheme mixes all fluid that a wall has moved up to the last sample."""
    fastest = max(channel.bottom.angular_frequency, channel.top.angular_frequency)
    time = min(config.time.samples[-1], 1 / fastest if fastest else math.inf)
    thickness = min(math.sqrt(channel.kinematic_viscosity * time), channel.gap) / channel.spacing
    ratio = cell_reynolds(channel) / STABLE_CELL_RE
    starts = any(channel.wall_jumps) or channel.bottom.oscillates or channel.top.oscillates
    return starts and ratio > 1.0 and ratio >= LOST_LAYERS * thickness


def polymer_stiffness(config: Config, channel: Scene) -> float:
    """Return the number that ``STIFF_POLYMER`` limits: modulus times (spacing over solvent viscosity) squared."""
    if not channel.polymer:
        return 0.0
    modulus = sum(law.modulus for law in config.fluid.rheology.laws(channel.kinematic_viscosity))
    return modulus * (channel.spacing / channel.solvent_viscosity) ** 2


def layer_estimates(
    config: Config, channel: Channel, control: StepControl
) -> tuple[list[SampleEstimate], "ImplicitLayers"]:
    """Return the ``SampleEstimate`` of every sample of scheme ``implicit``, and the layers at the end of the run.

    ``control``: the step control of the run; its targets must be all times on which steps end.
    """
    channel = channel.in_flow_frame()
    most = MOST_LAYERS["coupled" if is_coupled(config, channel) else "newtonian"]
    coarse = replace(channel, rows=most, spacing=channel.gap / most) if channel.rows > most else channel
    layers = ImplicitLayers(config, coarse, control)
    solvent_cell_re = channel.reference_velocity * channel.spacing / channel.solvent_viscosity
    # disordered particles may leave the flow that layers have
    breaks_up = channel.polymer and config.initial.jitter > 0 and solvent_cell_re > DISORDERED_SOLVENT_CELL_RE
    samples, reliable = [], not breaks_up
    for time in config.time.samples:
        layers.run_to(time)
        if time == channel.start_time:
            exact = channel.initial_velocity(layers.heights)
            samples.append(_sample_estimate(channel, layers.heights, time, 0, exact, 0.0))
        elif layers.unknown or off_layers(config) or not channel.isothermal:
            factors = GUESSED if layers.unknown or not reliable else DISORDERED
            samples.append(SampleEstimate(time, layers.steps, steps_reliable=reliable, steps_factors=factors))
        else:
            least = SOLVER_TOLERANCE * control.tolerance
            sample = _sample_estimate(channel, layers.heights, time, layers.steps, layers.velocity, least)
            samples.append(replace(sample, steps_factors=LAYERS))
    layers.run_to(config.time.end)
    return samples, layers


def is_coupled(config: Config, channel: Channel) -> bool:
    """Tell whether a stage is solved for the stress, a wall, or an acting temperature as well."""
    return not config.fluid.newtonian or channel.seeks_wall_velocity or not channel.isothermal


def off_layers(config: Config) -> bool:
    """Tell whether particles leave their layers, or have a lower precision than layers."""
    return config.initial.jitter > 0 or config.discretisation.precision != "f64"


def _sample_estimate(
    channel: Channel, heights: np.ndarray, time: float, steps: int, velocity: np.ndarray, least: float
) -> SampleEstimate:
    """Return the ``SampleEstimate`` from the velocities (layers,) at ``heights``.

    ``least``: error that residuals may have, over the reference velocity.
    """
    exact = channel.exact_velocity(heights, time)
    layers: Any = lambda u: SimpleNamespace(t=time, u=u, reference={"u": exact}, weight=1.0)  # noqa: E731
    scale = relative_error(channel, layers(exact + channel.reference_velocity))  # L2 over rms
    error: Any = rms_error(channel, layers(velocity))
    rms = max(error, least)
    return SampleEstimate(time, steps, rms * scale if scale and scale < RESTS else None, rms, error < least)


class ImplicitLayers:
    """The flow of the layers of a channel, step by step; ``control`` is the step control of the run.

    ``time``, the number of ``steps`` up to it, and the length of the ``longest`` of them. ``unknown``: whether the
    velocities are unknown: after ``MOST_STEPS`` steps that changed them, or where no step is short enough.
    """

    def __init__(self, config: Config, channel: Channel, control: StepControl) -> None:
        self.channel, self.control = channel, control
        self.walls = wall_pair_of(config, channel)
        self.operators = LayerOperators(
            channel, config.scheme.operators.order, self.walls.even_reflection, channel.solvent_viscosity
        )
        self.heights = self.operators.heights
        self.step = ImplicitStep(self, self.operators, self.walls, channel)
        self.time, self.steps, self.longest, self.steepest = channel.start_time, 0, 0.0, 0.0
        self.half_way = self.time
        self.dt, self.last_dt, self.unknown, self.steady = 0.0, 0.0, False, False
        velocity, state = channel.initial_velocity(self.heights), self.walls.model.initial(channel, self.heights)
        carried = self.step.substances.initial(self.heights)
        self.flow = FlowState(velocity.astype(float), state, np.zeros_like(self.heights), substances=carried)
        self.end: FlowState | None = None
        self.walls.start()
        if (self.walls.obeys_momentum and self.walls.any_jump) or self.step.substances.jumping:
            self._apply_impulse()

    def assemble(self, dt: float, shift: bool) -> FlowState:
        """Return the flow at the start of a step: the operators of layers are always the same."""
        return self.flow

    @property
    def velocity(self) -> np.ndarray:
        """Velocities of the layers."""
        return self.flow.velocity

    @property
    def strained(self) -> bool:
        """Whether the strain limits the steps."""
        return self.control.dt_next == self.control.limit(self.steepest)

    def run_to(self, target: float) -> None:
        """Take steps to the time ``target``, one of those that the control meets; after many only count them."""
        while self.time < target and not (self.unknown or self.steady or self.steps >= MOST_STEPS):
            self._advance()
        if self.time < target:
            self.unknown = not self.steady
            self.steps += self._steps_left(target)
            self.time = target

    def _steps_left(self, target: float) -> int:
        """Return the number of steps to ``target``, which the strain of the exact solution may limit."""
        dt, left = self.dt, target - self.time
        if self.steps >= MOST_STEPS and not self.steady:
            dt = (self.time - self.half_way) / (MOST_STEPS - MOST_STEPS // 2)
        if self.steady or not self.strained:
            return math.ceil(left / dt)
        velocities = [self.channel.exact_velocity(self.heights, self.time + left * part) for part in LATER]
        steepest = [np.abs(np.diff(velocity)).max() / self.operators.spacing for velocity in velocities]
        return math.ceil(np.mean([left / min(dt, self.control.limit(gradient)) for gradient in steepest]))

    def _apply_impulse(self) -> None:
        near, substances = self.step.extra_stress.wall_values(self.flow), self.step.substances
        substances.forget(self.time)
        substances.begin(self.flow, self.time, self.control.dt_next)
        self.walls.set_effects(substances.effects())
        self.walls.apply_impulse(self.flow, self.time, self.operators, near)
        substances.apply_impulse(self.flow)

    def _advance(self) -> None:
        control = self.control
        if self.time in control.jump_times:
            self._apply_impulse()
        dt, _ = control.take(self.time, self._attempt)
        end = self.end
        if dt is None or end is None:
            self.unknown = True
            return
        change = np.abs(end.velocity - self.flow.velocity).max()
        last_change = not any(time > self.time for time in control.jump_times)
        unchanged = last_change and change <= STEADY * np.abs(end.velocity).max()
        self.steady = self.walls.steady and not self.channel.substances and unchanged and dt <= 1.01 * self.last_dt
        self.last_dt = dt
        self.flow = end
        self.step.conclude()
        self.unknown = bool(self.step.substances.unbounded())
        self.time = control.end(self.time, dt)
        self.steps += 1
        if self.steps == MOST_STEPS // 2:
            self.half_way = self.time
        self.longest = max(self.longest, dt)
        shear_rate = end.shear_rate
        if shear_rate is None:
            boundary = self.operators.boundary_gradient(self.walls.series(-1))
            shear_rate = self.operators.gradient(end.velocity, -1.0) + boundary
        self.steepest = float(np.max(np.abs(shear_rate)))
        control.step_taken(self.time, self.steepest)

    def _attempt(self, dt: float) -> tuple[float, int]:
        self.dt = dt
        stages, error = self.step.advance(self.time, dt, EXACT)
        self.end = stages[-1] if stages else None
        return error / self.channel.reference_velocity if stages else WORST, EMBEDDED_ORDER


class LayerOperators(ClosedOperators):
    """``ClosedOperators`` of an ``order`` on layers at ``heights``."""

    def __init__(self, channel: Channel, order: int, even_reflection: Sequence[bool], diffusivity: float) -> None:
        self.channel, self.order, self.diffusivity = channel, order, diffusivity
        rows, spacing = channel.rows, channel.spacing
        laplacian, gradient = least_squares(order)
        self.even_reflection = even_reflection
        self.signs = [-1.0 if even else 1.0 for even in even_reflection]
        self.images = len(laplacian) // 2
        self.gap, self.spacing = channel.gap, spacing
        self.heights = (np.arange(rows) + 0.5) * spacing
        self.depths = (np.arange(self.images) + 0.5) * spacing
        self.radius = (self.images + 1) * spacing
        self.parts = {"laplacian": self._parts(laplacian / spacing**2), "d_dy": self._parts(gradient / spacing)}
        self.closed = {
            (operator, parity): self._closed(operator, parity) for operator in self.parts for parity in (-1.0, 1.0)
        }
        self.inverted: float | None = None

    def of_field(self, even: Sequence[bool], diffusivity: float) -> "LayerOperators":
        """Return the operators of another field; see ``ClosedOperators.of_field``."""
        return LayerOperators(self.channel, self.order, even, diffusivity)

    def point_heights(self) -> np.ndarray:
        """Return the heights of the layers."""
        return self.heights

    def _parts(self, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the matrices of an operator on the images below, on the layers, and on the images above.

        Images are numbered from the wall. Each row has the same ``weights`` of differences from the row itself.
        """
        rows, images = len(self.heights), self.images
        matrix = np.zeros((rows, rows + 2 * images))
        for row in range(rows):
            matrix[row, row : row + len(weights)] = weights
            matrix[row, row + images] -= weights.sum()
        return matrix[:, :images][:, ::-1], matrix[:, images:-images], matrix[:, -images:]

    def _closed(self, name: str, parity: float) -> np.ndarray:
        below, inside, above = self.parts[name]
        mirrored = np.eye(self.images, len(self.heights))
        lower, upper = product(below, mirrored), product(above, mirrored[:, ::-1])
        return inside + parity * (self.signs[0] * lower + self.signs[1] * upper)

    def derivative(self, operator: str, values: np.ndarray, parity: float) -> np.ndarray:
        """Return an operator of ``values``, see ``ClosedOperators.derivative``."""
        return product(self.closed[operator, parity], values)

    def boundary(self, operator: str, series: Sequence[Series]) -> np.ndarray:
        """Return the part of an operator from the ``series`` of the images beyond both walls."""
        below, _, above = self.parts[operator]
        values = np.asarray(series) @ self.depths ** np.array([[0], [2], [4]])
        bottom, top = (
            side * (self.depths if even else 1.0) for side, even in zip(values, self.even_reflection, strict=True)
        )
        return product(below, bottom) + product(above, top)

    def boundary_stress(self, side: int, slope: float, third: float) -> np.ndarray:
        """Return the part of d/dy of the stress from its derivatives at a wall."""
        below, _, above = self.parts["d_dy"]
        excess = stress_excess(self.depths, side, self.even_reflection[side], slope, third)
        return product(above if side else below, excess)

    def solve(
        self, gamma_dt: float, tangent: np.ndarray | None, right: np.ndarray, guess: np.ndarray, tolerance: float
    ) -> np.ndarray | None:
        """Solve (1 - g nu_s A - g D T D) x = ``right`` directly; None where numbers are not finite."""
        coefficient = gamma_dt * self.diffusivity
        matrix = np.eye(len(right)) - coefficient * self.closed["laplacian", -1.0]
        if tangent is None:
            if coefficient != self.inverted:  # all stages of a step have the same
                self.inverse, self.inverted = np.linalg.inv(matrix), coefficient
            return product(self.inverse, right)
        coupling = product(self.closed["d_dy", 1.0], (gamma_dt * tangent)[:, None] * self.closed["d_dy", -1.0])
        found = np.linalg.solve(matrix - coupling, right)
        return found if math.isfinite(found.sum()) else None

    def near_wall(self, side: int) -> tuple[np.ndarray, np.ndarray, float]:
        """Return all layers, their distances from the wall ``side``, and the radius of fits."""
        return np.arange(self.heights.size), self.gap - self.heights if side else self.heights, self.radius


def least_squares(order: int) -> tuple[np.ndarray, ...]:
    """Return the weights of the Laplacian and of d/dy in the least-squares operators of ``order`` on the lattice.

    Each has one weight for every row of the lattice around a row, -reach .. reach; lengths are in spacings.
    """
    support, reach = SUPPORT[order], int(SUPPORT[order])
    y, x = (axis.ravel() for axis in np.mgrid[-reach : reach + 1.0, -reach : reach + 1.0])
    near = ((y != 0) | (x != 0)) & (x * x + y * y < support * support)
    y, x = y[near], x[near]
    powers = [(a, degree - a) for degree in range(1, order + 1) for a in range(degree + 1)]
    basis = np.stack([(x / support) ** a * (y / support) ** b for a, b in powers], 1)
    weights = (1.0 - (x * x + y * y) / support**2) ** 4
    wanted = np.zeros((len(powers), 2))
    wanted[powers.index((2, 0)), 0] = wanted[powers.index((0, 2)), 0] = 2.0 / support**2
    wanted[powers.index((0, 1)), 1] = 1.0 / support
    entries = weights[:, None] * (basis @ np.linalg.solve(basis.T @ (weights[:, None] * basis), wanted))
    rows = (y + reach).astype(int)
    return tuple(np.bincount(rows, weights=one, minlength=2 * reach + 1) for one in entries.T)


def product(matrix: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return matrix times matrix or vector. BLAS would split even small ones over threads, which is slow."""
    return np.einsum("ij,j...->i...", matrix, other)
