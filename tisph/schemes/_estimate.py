"""Estimates of a run before it runs: steps and time, and with the implicit scheme errors; for ``tisph check``.

In a plane flow on the lattice all particles of a layer do the same. With one velocity for each layer, the operators,
walls, start and step control of the implicit scheme are those of the run at a thousandth of its cost, and the exact
solution is known: so the error and the number of steps of every sample are computed, not guessed. The stages are those
of ``schemes/_channel``; the operators of the layers are matrices. Layers know nothing of disordered particles and of
single precision. Of such runs, of the explicit scheme and of two-dimensional flows no error is stated before the run;
``tisph run --estimate-error`` states one.

The limits of cell Reynolds numbers and stiffness are those that the stability matrix (``tisph stability``) found.
"""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from tisph.least_squares import SUPPORT
from tisph.measures.metrics import relative_error, rms_error
from tisph.schemes._channel.models import model_of
from tisph.schemes._channel.stages import (
    EMBEDDED_ORDER,
    SOLVER_TOLERANCE,
    WORST,
    FlowState,
    even_fit,
    polynomial_fit,
    stages_of,
    stress_excess,
)
from tisph.schemes._channel.wall_pair import WallPair, apply_impulse
from tisph.schemes._protocol import SampleEstimate
from tisph.schemes._step_control import steps_between
from tisph.schemes._time_step import limits_of, sound_speed_of

EXPLICIT_COST = 150e-9
"""Rough cost of one particle and step of the explicit scheme on two threads [s]."""

IMPLICIT_COST, IMPLICIT_OVERHEAD = 2.5e-6, 2e-3
"""Rough cost of one particle and step of the implicit scheme, order 4, and of a step without particles [s]."""

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
"""Cell Reynolds number by the viscosity of the solvent, where there is polymer, up to which disordered runs are stable:
one failed at 20, and above it they take more steps and have larger errors than layers, or stop."""

STIFF_POLYMER = 4.0
"""Modulus of the polymer per unit density times (spacing over solvent viscosity) squared, up to which disordered
particles of the implicit scheme have the error of a lattice at an impulsively started wall: at 3.5 they had, at 14 it
was eight times as large."""

MOST_LAYERS = {"newtonian": 128, "coupled": 50}
"""Most layers of a computation. On a finer lattice the estimate is the error of the steps alone."""

RESTS = 100.0
"""Reference velocity over the root mean square of the fluid's, above which it counts as at rest."""

LAYERS, DISORDERED, GUESSED = (0.97, 1.03), (0.9, 1.4), (0.3, 2.0)
"""Steps of runs over the estimated ones, least and most: on a lattice, of disordered particles or in single precision,
and where these break up or steps are only counted. In the stability matrix they are 0.99 to 1.01, 0.95 to 1.37 and 0.36
to 1.75."""

MOST_STEPS = 1000
"""Most steps whose errors are computed, in some seconds. Later ones count as long as the steps of the second half."""

LATER = (np.arange(20) + 0.5) / 20
"""Parts of the time left at which the exact solution tells their length."""

EXACT = 1e-12
"""Tolerance of a stage, whose systems are solved directly."""

STEADY = 1e-12
"""Change of the velocities in a step, over the largest of them, that is none."""


def explicit(config, channel):
    """Return the numbers of a run of scheme ``wcsph``."""
    sound, flow = (
        sound_speed_of(config, channel),
        {"speed": channel.peak_velocity, "elastic_speed": channel.elastic_speed},
    )
    limits = limits_of(config, channel, sound, acceleration=abs(channel.acceleration), **flow)
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
        "lost": channel.parallel and profile_lost(config, channel),
        "samples": [SampleEstimate(t, n, steps_factors=EXPLICIT_STEPS) for t, n in samples],
    }


def implicit(config, channel, control):
    """Return the numbers of a run of scheme ``implicit``, with the ``control`` of its steps."""
    samples, layers = layer_estimates(config, channel, control)
    return {
        "mach": 0.0,
        "sound_speed": None,
        "time_step": layers.longest,
        "binding_limit": "cfl" if control.fixed else "strain" if layers.strained else "accuracy",
        "steps": layers.steps,
        "run_time": layers.steps * (IMPLICIT_OVERHEAD + channel.rows * channel.columns * IMPLICIT_COST),
        "lost": False,
        "samples": samples,
    }


def step_counts(start, targets, longest):
    """Steps no longer than ``longest`` from ``start`` up to every target (ascending), each hit exactly."""
    pairs = itertools.pairwise([start, *targets])
    steps = (steps_between(before, after, longest) if after > before else 0 for before, after in pairs)
    return list(itertools.accumulate(steps))


def cell_reynolds(channel):
    """Reynolds number of a spacing, U spacing / nu."""
    return channel.reference_velocity * channel.spacing / channel.kinematic_viscosity


def profile_lost(config, channel):
    """Tell whether the explicit scheme mixes all fluid that a wall has moved up to the last sample."""
    fastest = max(channel.bottom.angular_frequency, channel.top.angular_frequency)
    time = min(config.time.samples[-1], 1 / fastest if fastest else math.inf)
    thickness = min(math.sqrt(channel.kinematic_viscosity * time), channel.gap) / channel.spacing
    ratio = cell_reynolds(channel) / STABLE_CELL_RE
    starts = any(channel.wall_jumps) or channel.bottom.oscillates or channel.top.oscillates
    return starts and ratio > 1.0 and ratio >= LOST_LAYERS * thickness


def polymer_stiffness(config, channel):
    """Return the number of ``STIFF_POLYMER``: how fast polymer responds, the solvent's layer being a spacing thick."""
    if not channel.polymer:
        return 0.0
    modulus = sum(law.modulus for law in config.fluid.rheology.laws(channel.kinematic_viscosity))
    return modulus * (channel.spacing / channel.solvent_viscosity) ** 2


def layer_estimates(config, channel, control):
    """Return the ``SampleEstimate`` of every sample of scheme ``implicit``, and the layers at the end of the run.

    ``control``: the step control of the run; its targets must be all times that steps meet.
    """
    channel = channel.in_flow_frame()
    coupled = config.fluid.rheology.type != "newtonian" or channel.driven_side is not None
    most = MOST_LAYERS["coupled" if coupled else "newtonian"]
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
        elif layers.unknown or off_layers(config):
            factors = GUESSED if layers.unknown or not reliable else DISORDERED
            samples.append(SampleEstimate(time, layers.steps, steps_reliable=reliable, steps_factors=factors))
        else:
            least = SOLVER_TOLERANCE * control.tolerance
            sample = _sample_estimate(channel, layers.heights, time, layers.steps, layers.velocity, least)
            samples.append(replace(sample, steps_factors=LAYERS))
    layers.run_to(config.time.end)
    return samples, layers


def off_layers(config):
    """Tell whether particles do not stay on layers, or have fewer digits than these."""
    return config.initial.jitter > 0 or config.discretisation.precision != "f64"


def _sample_estimate(channel, heights, time, steps, velocity, least):
    """Return the ``SampleEstimate`` from the velocities of layers.

    ``least``: error that residuals may have, over the reference velocity.
    """
    exact = channel.exact_velocity(heights, time)
    layers = lambda u: SimpleNamespace(t=time, u=u, reference={"u": exact})  # noqa: E731
    scale = relative_error(channel, layers(exact + channel.reference_velocity))  # L2 over rms
    error = rms_error(channel, layers(velocity))
    rms = max(error, least)
    return SampleEstimate(time, steps, rms * scale if scale and scale < RESTS else None, rms, error < least)


class ImplicitLayers:
    """Velocities of the layers of a channel, step by step; ``control`` is the step control of the run.

    ``time``, ``steps`` up to it and the ``longest`` of them. ``unknown``: whether the velocities are not known any
    more: after ``MOST_STEPS`` steps that changed them, or where no step is short enough.
    """

    def __init__(self, config, channel, control):
        self.channel, self.control = channel, control
        self.walls = WallPair(channel, config.walls.treatment.type, model_of(config.fluid.rheology, channel))
        self.operators = LayerOperators(channel, config.scheme.operators.order, self.walls.even_reflection)
        self.heights = self.operators.heights
        self.stages = stages_of(self.operators, channel, self.walls)
        self.time, self.steps, self.longest, self.steepest = channel.start_time, 0, 0.0, 0.0
        self.half_way = self.time
        self.dt, self.last_dt, self.unknown, self.steady = 0.0, 0.0, False, False
        self.flow = self._start()

    def _start(self):
        channel, heights, model = self.channel, self.heights, self.walls.model
        velocity = channel.initial_velocity(heights).astype(float)
        flow = FlowState(velocity, np.empty((0, heights.size)))
        if model is not None:
            flow = FlowState(velocity, model.initial(channel, heights), np.zeros_like(heights))
            self.stages.initialise()
        if self.walls.obeys_momentum and self.walls.any_jump:
            apply_impulse(self.stages, flow, self.time)
        return flow

    @property
    def velocity(self):
        """Velocities of the layers."""
        return self.flow.velocity

    @property
    def strained(self):
        """Whether the strain limits the steps."""
        return self.control.dt_next == self.control.limit(self.steepest)

    def run_to(self, target):
        """Take steps to the time ``target``, one of those that the control meets; after many only count them."""
        while self.time < target and not (self.unknown or self.steady or self.steps >= MOST_STEPS):
            self._advance()
        if self.time < target:
            self.unknown = not self.steady
            self.steps += self._steps_left(target)
            self.time = target

    def _steps_left(self, target):
        """Return how many steps there are to ``target``, which the exact solution may limit by its strain."""
        dt, left = self.dt, target - self.time
        if self.steps >= MOST_STEPS and not self.steady:
            dt = (self.time - self.half_way) / (MOST_STEPS - MOST_STEPS // 2)
        if self.steady or not self.strained:
            return math.ceil(left / dt)
        velocities = [self.channel.exact_velocity(self.heights, self.time + left * part) for part in LATER]
        steepest = [np.abs(np.diff(velocity)).max() / self.operators.spacing for velocity in velocities]
        return math.ceil(np.mean([left / min(dt, self.control.limit(gradient)) for gradient in steepest]))

    def _advance(self):
        control = self.control
        if self.time in control.jump_times:
            apply_impulse(self.stages, self.flow, self.time)
        dt, _ = control.take(self.time, self._attempt)
        end = self.end
        if dt is None or end is None:
            self.unknown = True
            return
        change = np.abs(end.velocity - self.flow.velocity).max()
        last_change = not any(time > self.time for time in control.jump_times)
        unchanged = last_change and change <= STEADY * np.abs(end.velocity).max()
        self.steady = self.walls.steady and unchanged and dt <= 1.01 * self.last_dt
        self.last_dt = dt
        self.flow = end
        self.walls.conclude()
        self.time = control.end(self.time, dt)
        self.steps += 1
        if self.steps == MOST_STEPS // 2:
            self.half_way = self.time
        self.longest = max(self.longest, dt)
        self.steepest = float(np.max(np.abs(self._shear_rate())))
        control.step_taken(self.time, self.steepest)

    def _attempt(self, dt):
        self.dt = dt
        self.end, error = self.stages.advance(self.flow, self.time, dt, EXACT)
        return WORST if self.end is None else error / self.channel.reference_velocity, EMBEDDED_ORDER

    def _shear_rate(self):
        if self.flow.shear_rate is not None:
            return self.flow.shear_rate
        boundary = self.operators.boundary_gradient(self.walls.series(-1))
        return self.operators.gradient(self.flow.velocity, -1.0) + boundary


class LayerOperators:
    """``ClosedOperators`` of ``schemes/_channel/stages.py``, of an ``order``, on layers at ``heights``."""

    def __init__(self, channel, order, even_reflection):
        rows, spacing = channel.rows, channel.spacing
        laplacian, gradient = least_squares(order)
        self.even_reflection = even_reflection
        self.signs = [-1.0 if even else 1.0 for even in even_reflection]
        self.images = len(laplacian) // 2
        self.gap, self.spacing = channel.gap, spacing
        self.heights = (np.arange(rows) + 0.5) * spacing
        self.depths = (np.arange(self.images) + 0.5) * spacing
        self.radius = (self.images + 1) * spacing
        self.parts = {"laplacian": self._parts(laplacian / spacing**2), "gradient": self._parts(gradient / spacing)}
        self.odd_laplacian = self._closed("laplacian", -1.0)
        self.gradients = {parity: self._closed("gradient", parity) for parity in (-1.0, 1.0)}
        self.inverted = None

    def _parts(self, weights):
        """Return an operator on the images below, from the wall on, on the layers, and on the images above.

        It takes differences from the row itself, each row with the same ``weights``.
        """
        rows, images = len(self.heights), self.images
        matrix = np.zeros((rows, rows + 2 * images))
        for row in range(rows):
            matrix[row, row : row + len(weights)] = weights
            matrix[row, row + images] -= weights.sum()
        return matrix[:, :images][:, ::-1], matrix[:, images:-images], matrix[:, -images:]

    def _closed(self, name, parity):
        below, inside, above = self.parts[name]
        mirrored = np.eye(self.images, len(self.heights))
        lower, upper = product(below, mirrored), product(above, mirrored[:, ::-1])
        return inside + parity * (self.signs[0] * lower + self.signs[1] * upper)

    def laplacian(self, values):
        """Return A of velocities."""
        return product(self.odd_laplacian, values)

    def gradient(self, values, parity):
        """Return d/dy of ``values``."""
        return product(self.gradients[parity], values)

    def boundary_laplacian(self, series):
        """Return the part of A from the ``series`` of the images beyond both walls (2, 3)."""
        return self.boundary("laplacian", series)

    def boundary_gradient(self, series):
        """Return the part of d/dy from the ``series`` of the images."""
        return self.boundary("gradient", series)

    def boundary(self, name, series):
        """Return the part of an operator from the ``series`` of the images."""
        below, _, above = self.parts[name]
        bottom, top = (
            values * (self.depths if even else 1.0)
            for values, even in zip(
                np.asarray(series) @ self.depths ** np.array([[0], [2], [4]]), self.even_reflection, strict=True
            )
        )
        return product(below, bottom) + product(above, top)

    def boundary_stress(self, side, slope, third):
        """Return the part of d/dy of the stress from its derivatives at a wall."""
        below, _, above = self.parts["gradient"]
        excess = stress_excess(self.depths, side, self.even_reflection[side], slope, third)
        return product(above if side else below, excess)

    def solve(self, coefficient, tangent, right, guess, tolerance):
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = ``right``; None where numbers are not finite."""
        matrix = np.eye(len(right)) - coefficient * self.odd_laplacian
        if tangent is None:
            if coefficient != self.inverted:  # all stages of a step have the same
                self.inverse, self.inverted = np.linalg.inv(matrix), coefficient
            return product(self.inverse, right)
        coupling = product(self.gradients[1.0], tangent[:, None] * self.gradients[-1.0])
        found = np.linalg.solve(matrix - coupling, right)
        return found if math.isfinite(found.sum()) else None

    def even_fit(self, side):
        """Return layers near a wall, their distance from it, and their weights in the even fit to the value there."""
        distance = self.gap - self.heights if side else self.heights
        near, weights = even_fit(distance, self.radius)
        return near, distance[near], weights

    def wall_fits(self, values):
        """Return the polynomial fit at each wall to ``values`` (quantities, layers)."""
        return [polynomial_fit(distance, values.T, self.radius) for distance in (self.heights, self.gap - self.heights)]


def least_squares(order):
    """Weights of the Laplacian and of the derivative across, of the least-squares rows of ``order``.

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


def product(matrix, other):
    """Matrix times matrix or vector, not by BLAS, which splits even small ones over threads: slow where it is busy."""
    return np.einsum("ij,j...->i...", matrix, other)
