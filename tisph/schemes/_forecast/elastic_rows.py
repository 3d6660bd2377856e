"""The rows of scheme ``implicit`` in a liquid with memory: stages of its steps, on the rows of the start lattice."""

import math

import numpy as np

from tisph.schemes._forecast.images import mirrored
from tisph.schemes._forecast.implicit_rows import RESIDUALS
from tisph.schemes._forecast.linear import product
from tisph.schemes._forecast.stencils import least_squares
from tisph.schemes.implicit._driven import slides_freely, stages
from tisph.schemes.implicit._elastic_stages import Flow, even_fit, image_of_stress, polynomial
from tisph.schemes.implicit._esdirk import EMBEDDED_ORDER, GAMMA
from tisph.schemes.implicit._instant import material
from tisph.schemes.implicit._scheme import MOST_ATTEMPTS, WORST

MOST_STEPS = 1000
"""Of which errors are computed, in some seconds."""

EXACT = 1e-12
"""Tolerance of a stage, whose systems are solved directly."""


class ElasticRows:
    """Velocities of the rows of a channel, step by step; attributes as of ``implicit_rows.Rows``.

    ``beyond``: whether it has given up, after ``MOST_STEPS`` or where none is short enough.
    """

    beyond = False

    def __init__(self, config, channel, control):
        self.channel, self.control = channel, control
        memory = material(config.fluid.rheology, channel)
        self.operators = _Operators(channel, config.scheme.operators.order)
        self.heights = self.operators.heights
        self.stages = stages(self.operators, channel, config.walls.treatment.type, memory)
        self.walls = self.stages.walls
        self.time, self.steps, self.longest, self.steepest = channel.start_time, 0, 0.0, 0.0
        self.length = 0.0
        self.flow = self._start(memory)

    def _start(self, memory):
        channel, heights = self.channel, self.heights
        velocity = channel.initial_velocity(heights).astype(float)
        flow = Flow(velocity, memory.start(channel, heights), np.zeros_like(heights))
        self.stages.settle(channel)
        if self.walls.obeys_momentum and self.walls.any_jump:
            self.stages.turn(flow, self.time)
        return flow

    @property
    def velocity(self):
        """Velocities of the rows."""
        return self.flow.velocity

    @property
    def residual(self):
        """As of ``implicit_rows.Rows``: of the systems of particles, here taken for those of a Newtonian liquid."""
        velocity, coefficient = self.velocity, GAMMA * self.length * self.channel.kinematic_viscosity
        size = float(np.linalg.norm(velocity)) * (1.0 + coefficient * (math.pi / self.channel.gap) ** 2)
        right_side = float(np.linalg.norm(velocity - coefficient * self.operators.laplacian(velocity)))
        return RESIDUALS * self.control.tolerance * right_side / size if size > 0.0 else 0.0

    @property
    def strained(self):
        """Whether the strain limits the steps."""
        return self.control.is_limited(self.steepest)

    def run_to(self, target):
        """Take steps to the time ``target``, one of those that the control meets; after many only count them."""
        while self.time < target and self.steps < MOST_STEPS and not self.beyond:
            self._advance()
        if self.time < target:
            self.beyond = True
            self.steps += math.ceil((target - self.time) / self.length)
            self.time = target

    def _advance(self):
        control = self.control
        if self.time in control.changes:
            self.stages.turn(self.flow, self.time)
        for _ in range(MOST_ATTEMPTS):
            length = self.length = control.choose_dt(self.time)
            end, error = self.stages.advance(self.flow, self.time, length, EXACT)
            error = WORST if end is None else error / self.channel.reference_velocity
            if control.accepts(error, EMBEDDED_ORDER, length) and end is not None:
                break
        else:
            self.beyond = True
            return
        self.flow = end
        self.walls.conclude()
        self.time = control.end(self.time, length)
        self.steps += 1
        self.longest = max(self.longest, length)
        self.steepest = float(np.max(np.abs(end.shear_rate)))
        control.step_taken(self.time, self.steepest)


class _Operators:
    """Operators as ``_elastic_stages.py`` wants them, as matrices of the rows."""

    def __init__(self, channel, order):
        rows, spacing = channel.rows, channel.spacing
        laplacian, across = least_squares(order)
        self.turned = [-1.0 if slides_freely(channel, side) else 1.0 for side in range(2)]
        self.layers = len(laplacian) // 2
        self.gap, self.spacing = channel.gap, spacing
        self.heights = (np.arange(rows) + 0.5) * spacing
        self.depths = (np.arange(self.layers) + 0.5) * spacing
        self.extended = {"laplacian": self._banded(laplacian / spacing**2, rows)}
        self.extended["d_dy"] = self._banded(across / spacing, rows)
        self.odd_laplacian = self._closed("laplacian", -1.0)
        self.across = {parity: self._closed("d_dy", parity) for parity in (-1.0, 1.0)}

    def _banded(self, weights, rows):
        """Return the rows of an operator (rows, rows and the layers beyond both walls)."""
        matrix = np.zeros((rows, rows + 2 * self.layers))
        for row in range(rows):
            matrix[row, row : row + len(weights)] = weights
        matrix[np.arange(rows), np.arange(rows) + self.layers] -= weights.sum()
        return matrix

    def _closed(self, name, parity):
        shares, _ = mirrored(self.layers, len(self.heights))
        below, inside, above = self._parts(name)
        lower, upper = product(below[:, ::-1], shares), product(above, shares[:, ::-1])
        return inside + parity * (self.turned[0] * lower + self.turned[1] * upper)

    def _parts(self, name):
        return np.split(self.extended[name], [self.layers, -self.layers], axis=1)

    def laplacian(self, values):
        """Return A of velocities."""
        return product(self.odd_laplacian, values)

    def slopes(self, values, parity):
        """Return d/dy of ``values``."""
        return product(self.across[parity], values)

    def given(self, name, series):
        """Return what the ``series`` of the images beyond both walls add to an operator."""
        below, _, above = self._parts(name)
        bottom, top = np.asarray(series) @ self.depths ** np.array([[0], [2], [4]])
        bottom, top = (
            self.depths * values if sign < 0.0 else values
            for sign, values in zip(self.turned, (bottom, top), strict=True)
        )
        return product(below[:, ::-1], bottom) + product(above, top)

    def images(self, side, slope, third):
        """Return what D S has more by the first and third derivative of the stress at a wall."""
        below, _, above = self._parts("d_dy")
        if self.turned[side] < 0.0:
            more = 2.0 * slope + self.depths**2 * third
            return product(below[:, ::-1], more) if side == 0 else product(above, more)
        more = image_of_stress(self.depths, slope, third)
        return product(below[:, ::-1], more) if side == 0 else product(above, -more)

    def answer(self, coefficient, tangent, right, guess, tolerance):
        """Solve (1 - ``coefficient`` A - D ``tangent`` D) x = ``right``; None where numbers are no numbers."""
        elastic = product(self.across[1.0], tangent[:, None] * self.across[-1.0])
        found = np.linalg.solve(np.eye(len(right)) - coefficient * self.odd_laplacian - elastic, right)
        return found if math.isfinite(found.sum()) else None

    def even_fit(self, side):
        """Return rows near a wall, their distance from it, and their weights in ``even_fit``."""
        distance = self.gap - self.heights if side else self.heights
        close, weights = even_fit(distance, (self.layers + 1) * self.spacing)
        return close, distance[close], weights

    def at_walls(self, values):
        """Return the ``polynomial`` at each wall through ``values`` (quantities, rows)."""
        reach = (self.layers + 1) * self.spacing
        return [polynomial(offset, values.T, reach) for offset in (self.heights, self.gap - self.heights)]
