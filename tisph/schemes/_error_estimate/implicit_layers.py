"""The implicit scheme on the layers of its start lattice: its operators, its walls, its steps and their control.

The steps are those of ``schemes/_stages``; what is here are the operators of the layers, as matrices.
"""

import math

import numpy as np

from tisph.least_squares import SUPPORT
from tisph.schemes._stages.models import model_of
from tisph.schemes._stages.stages import (
    EMBEDDED_ORDER,
    MOST_ATTEMPTS,
    WORST,
    FlowState,
    even_fit,
    polynomial_fit,
    stages_of,
    stress_excess,
)
from tisph.schemes._stages.wall_pair import WallPair, apply_impulse

MOST_STEPS = 1000
"""Of which errors are computed, in some seconds. Later ones are taken to be as long as those of the second half."""

LATER = (np.arange(20) + 0.5) / 20
"""Parts of the time left at which the exact solution tells their length."""

EXACT = 1e-12
"""Tolerance of a stage, whose systems are solved directly."""

STEADY = 1e-12
"""Change of the velocities in a step, over the largest of them, that is none."""


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
        return self.control.is_limited(self.steepest)

    def run_to(self, target):
        """Take steps to the time ``target``, one of those that the control meets; after many only count them."""
        while self.time < target and not self._counted_alone:
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

    @property
    def _counted_alone(self):
        return self.unknown or self.steady or self.steps >= MOST_STEPS

    def _advance(self):
        control = self.control
        if self.time in control.jump_times:
            apply_impulse(self.stages, self.flow, self.time)
        for _ in range(MOST_ATTEMPTS):
            dt = self.dt = control.choose_dt(self.time)
            end, error = self.stages.advance(self.flow, self.time, dt, EXACT)
            error = WORST if end is None else error / self.channel.reference_velocity
            if control.accepts(error, EMBEDDED_ORDER, dt) and end is not None:
                break
        else:
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

    def _shear_rate(self):
        if self.flow.shear_rate is not None:
            return self.flow.shear_rate
        boundary = self.operators.boundary_gradient(self.walls.series(-1))
        return self.operators.gradient(self.flow.velocity, -1.0) + boundary


class LayerOperators:
    """``ClosedOperators`` of ``schemes/_stages/stages.py``, of an ``order``, on layers at ``heights``."""

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
        """Return an operator on the images below, from the wall on, on the layers, and on the images above."""
        matrix, images = banded(weights, len(self.heights)), self.images
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
        """Return what the ``series`` of the images beyond both walls (2, 3) add to A."""
        return self._boundary("laplacian", series)

    def boundary_gradient(self, series):
        """Return what they add to d/dy."""
        return self._boundary("gradient", series)

    def _boundary(self, name, series):
        below, _, above = self.parts[name]
        bottom, top = (
            values * (self.depths if even else 1.0)
            for values, even in zip(
                np.asarray(series) @ self.depths ** np.array([[0], [2], [4]]), self.even_reflection, strict=True
            )
        )
        return product(below, bottom) + product(above, top)

    def boundary_stress(self, side, slope, third):
        """Return what d/dy of the stress has more by its derivatives at a wall."""
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


def banded(weights, rows):
    """Return the operator (rows, images + rows + images) of a row's ``weights``, as many images as these reach.

    It takes differences from the row itself.
    """
    images = len(weights) // 2
    matrix = np.zeros((rows, rows + 2 * images))
    for row in range(rows):
        matrix[row, row : row + len(weights)] = weights
        matrix[row, row + images] -= weights.sum()
    return matrix


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
