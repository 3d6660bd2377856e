"""The rows of scheme ``implicit``: its operators on the start lattice, its walls, its steps and their control.

On the lattice the modes sin(k pi y/gap) of the rows are those of the operators, with mirror images at the walls, so
that a step is a few products of numbers for each mode. Where the strain alone limits the steps many are taken at once.
"""

import math

import numpy as np

from tisph.schemes._forecast.images import mirrored
from tisph.schemes._forecast.linear import product
from tisph.schemes._forecast.stencils import least_squares
from tisph.schemes.implicit._esdirk import EMBEDDED, EMBEDDED_ORDER, GAMMA, STAGES, TIMES, WEIGHTS
from tisph.schemes.implicit._scheme import SOLVER_TOLERANCE
from tisph.schemes.implicit._walls import WallSeries

PARTS, DEFECT = np.array(STAGES), np.array(WEIGHTS) - np.array(EMBEDDED)

RESIDUALS = SOLVER_TOLERANCE * math.hypot(1.0, STAGES[3][1] / GAMMA, STAGES[3][2] / GAMMA)
"""Residuals of the linear systems of a step over its tolerance: of the last stage, and of those before by their rates.
"""

MANY = 0.1
"""Part of the time since the start, and of the period of a wall over 2 pi, in which steps limited by their strain are
taken at once: by so much the strain rate changes, and the number of the steps is wrong."""

PATIENCE = 300
"""Steps after which whole periods of an oscillating wall are left out, their steps being counted alone."""


class Rows:
    """Velocities of the rows of a channel, step by step; ``control`` is the ``StepControl`` of the run.

    ``time``, ``steps`` up to it and the ``longest`` of them; ``velocity`` (rows,); ``steepest`` gradient of it.
    """

    beyond = False  # of the others it may be

    def __init__(self, config, channel, control):
        self.channel, self.control = channel, control
        self.rows, self.viscosity = channel.rows, channel.kinematic_viscosity
        self.walls = WallSeries(channel, config.walls.treatment.type)
        laplacian, across = least_squares(config.scheme.operators.order)
        self.layers = len(laplacian) // 2
        self.slope_weights = across[self.layers + 1 :] / channel.spacing
        self.heights = (np.arange(self.rows) + 0.5) * channel.spacing
        self.depths = self.heights[0] + channel.spacing * np.arange(self.layers)
        self._set_modes(laplacian / channel.spacing**2)
        self.time, self.steps = channel.start_time, 0
        self.amplitudes = product(self.modes, self._start())
        self.marked, self.given = (self.time, 0), None
        self.steepest = self.longest = self.last = 0.0

    def _set_modes(self, weights):
        number = np.arange(1, self.rows + 1)
        self.modes = math.sqrt(2 / self.rows) * np.sin(np.outer(number, np.pi / self.channel.gap * self.heights))
        self.modes[-1] /= math.sqrt(2)
        offsets = np.arange(-self.layers, self.layers + 1)
        self.laplacian = (np.cos(np.outer(number, np.pi / self.rows * offsets)) - 1.0) @ weights
        self.rates = self.viscosity * self.laplacian
        bottom = np.zeros((self.rows, self.layers))
        for row in range(min(self.rows, self.layers)):
            bottom[row, : self.layers - row] = weights[self.layers - 1 - row :: -1]
        powers = self.depths[:, None] ** np.array([0, 2, 4])
        self.series = [product(self.modes, product(side, powers)) for side in (bottom, bottom[::-1])]
        self.drive = self.channel.acceleration * self.modes.sum(axis=1)
        self._set_slope(powers)

    def _set_slope(self, powers):
        """Prepare the velocity gradients of the rows: by the amplitudes of the modes, and by the walls' series."""
        rows, layers = self.rows, self.layers
        extended = np.zeros((rows, rows + 2 * layers))
        for row in range(rows):
            extended[row, row + layers + 1 : row + 2 * layers + 1] = self.slope_weights
            extended[row, row : row + layers] = -self.slope_weights[::-1]
        below, inside, above = np.split(extended, [layers, layers + rows], axis=1)
        shares, _ = mirrored(layers, rows)
        closed = inside - product(below[:, ::-1], shares) - product(above, shares[:, ::-1])
        self.slope = product(closed, self.modes.T)
        self.wall_slope = [product(below[:, ::-1], powers), product(above, powers)]

    def _start(self):
        """Return the velocities at the start, with the impulse of walls that obey the momentum equation."""
        velocity = self.channel.initial_velocity(self.heights).astype(float)
        return velocity + product(self.modes.T, self._turned())

    def _turned(self):
        """Let walls that change at once do so; return the amplitudes that their impulse gives."""
        self.walls.enter(self.time)
        gained = np.zeros(self.rows)
        if self.walls.obeys_momentum:
            for series, jump, rate in zip(self.series, *self.walls.jumps_at(self.time), strict=True):
                gained += jump * series[:, 1] + (rate / self.viscosity + jump * self.laplacian) * series[:, 2] / 12.0
        return gained

    @property
    def strained(self):
        """Whether the strain limits the steps."""
        return self.control.is_limited(self.steepest)

    @property
    def residual(self):
        """What residuals of the linear systems of a step may do to the slowest mode, over the velocities."""
        damping = 1.0 - GAMMA * self.last * self.rates
        size = float(np.linalg.norm(self.amplitudes))
        right_side = float(np.linalg.norm(damping * self.amplitudes))
        return RESIDUALS * self.control.tolerance * right_side / (size * damping[0]) if size > 0.0 else 0.0

    @property
    def velocity(self):
        """Velocities of the rows."""
        return product(self.modes.T, self.amplitudes)

    def run_to(self, target):
        """Take steps to the time ``target``, one of those that the control meets."""
        while self.time < target:
            if self.time in self.control.changes:
                self.amplitudes = self.amplitudes + self._turned()
            self._leap()
            self._advance()

    def _advance(self):
        """Take one step, in as many attempts as its error asks for."""
        while True:
            length = self.control.choose_dt(self.time)
            moments = [self.time] if self.walls.steady else [self.time + part * length for part in TIMES]
            sources = [self._source(moment) for moment in moments]
            end, defect = self._step(self.amplitudes, sources * (4 if self.walls.steady else 1), length)
            error = np.linalg.norm(defect) / math.sqrt(self.rows) / self.channel.reference_velocity
            if self.control.accepts(error, EMBEDDED_ORDER, length):
                break
        self.amplitudes = end
        self.time = self.control.end(self.time, length)
        self.steps += 1
        self.last, self.longest = length, max(self.longest, length)
        self.steepest = self._steepest()
        self.control.step_taken(self.time, self.steepest)

    def _step(self, start, sources, length):
        """Return amplitudes at the end of a step, and its estimated error; ``sources`` at its stages."""
        inverse = 1.0 / (1.0 - (GAMMA * length) * self.rates)
        rates = np.empty((4, *start.shape))
        rates[0] = self.rates * start + sources[0]
        for stage in range(1, 4):
            known = start + np.dot(length * PARTS[stage, :stage], rates[:stage])
            end = (known + GAMMA * length * sources[stage]) * inverse
            rates[stage] = (end - known) / (GAMMA * length)
        return end, np.dot(length * DEFECT, rates) * inverse

    def _source(self, time):
        """Return what walls and drive add to the rates at ``time``."""
        if self.walls.steady and self.given is not None:
            return self.given
        bottom, top = (np.dot(series, given) for given, series in zip(self.walls(time), self.series, strict=True))
        self.given = self.viscosity * (bottom + top) + self.drive
        return self.given

    def _steepest(self):
        """Return the largest velocity gradient."""
        slope = product(self.slope, self.amplitudes)
        for given, series in zip(self.walls(self.time), self.wall_slope, strict=True):
            slope += np.dot(series, given)
        return float(np.max(np.abs(slope)))

    def _leap(self):
        """Take many steps at once where that can be: of a length that does not change, or in whole periods."""
        control = self.control
        left = control.targets[0] - self.time
        if control.fixed or self.strained:
            least = max(self.channel.spacing**2 / self.viscosity, self.time - self.channel.start_time)
            reach = min(MANY * least, left, MANY / self._frequency if self._frequency else math.inf)
            many = int(reach / control.dt_next) - 1
            if many > 1:
                self._take(many, control.dt_next)
                left -= many * control.dt_next
        if self._frequency and self.steps - self.marked[1] >= PATIENCE:
            since, before = self.marked
            period = 2.0 * math.pi / self._frequency
            whole = max(0, math.floor(left / period) - 1) * period
            self.steps += round(whole * (self.steps - before) / (self.time - since))
            self.time += whole
            self.marked = (self.time, self.steps)

    @property
    def _frequency(self):
        return max(self.channel.bottom.angular_frequency, self.channel.top.angular_frequency)

    def _take(self, many, length):
        """Take ``many`` equal steps: the same linear map each time, or with moving walls without the steps' error."""
        if self.walls.steady:
            nothing = [np.zeros(self.rows)] * 4
            factor, _ = self._step(np.ones(self.rows), nothing, length)
            added, _ = self._step(np.zeros(self.rows), [self._source(self.time)] * 4, length)
            power = factor**many
            self.amplitudes = power * self.amplitudes + added * (1.0 - power) / (1.0 - factor)
        else:
            end = self.time + many * length
            decay = np.exp(self.rates * many * length)
            self.amplitudes = self._settled(end) + decay * (self.amplitudes - self._settled(self.time))
        self.time += many * length
        self.steps += many

    def _settled(self, time):
        """Return the amplitudes that are left a long time after the start."""
        rest = -self._source(time) / self.rates
        for side, wall in enumerate((self.channel.bottom, self.channel.top)):
            if wall.angular_frequency:
                quarter = 0.5 * math.pi / wall.angular_frequency
                # what the other wall and the drive give does not change, or drops out
                now, later = (np.array(self.walls(moment)[side]) for moment in (time, time + quarter))
                still = self._still(side)
                wave = self.viscosity * (self.series[side] @ ((now - still) - 1j * (later - still)))
                rest = rest + (wave / (1j * wall.angular_frequency - self.rates) + wave / self.rates).real
            elif wall.oscillates:  # a ramp: what it gives rises steadily, and the amplitudes follow it late
                rises = 2.0 * self.viscosity * self.walls.walls[side].acceleration(time)
                rest = rest - rises * self.series[side][:, 0] / self.rates**2
        return rest

    def _still(self, side):
        """Return the series of a wall without its motion."""
        if not self.walls.obeys_momentum:
            return np.zeros(3)
        return np.array([0.0, -self.channel.acceleration / self.viscosity, 0.0])
