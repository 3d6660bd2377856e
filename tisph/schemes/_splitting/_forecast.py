"""Steps of a run before it runs: their control, with velocities of the reference or of the start."""

import math

import numpy as np

from tisph.schemes._splitting._bdf import VELOCITIES, TimeWeights
from tisph.schemes._splitting._step_limits import FIRST, MAX_ATTEMPTS, courant_speed, error_speed, step_control

N_POSITIONS = 400
"""Number of positions in the box that are looked at, about; they are evenly distributed."""

MAX_STEPS = 1000
"""Steps that are taken; later ones are taken to be as long as the last of them."""


class Walk:
    """Takes the steps of a run of a ``scene``; ``longest`` is the longest one.

    Without a reference particles move in the velocity field of the start.

    ``bounded``: whether it was as long as Courant or viscous number allow.

    ``tolerance`` and ``courant`` are those of the ``Scheme``.
    """

    def __init__(self, scene, targets, tolerance, courant):
        self.scene = scene
        self.time, self.steps, self.longest, self.bounded = scene.start_time, 0, 0.0, True
        self.positions = _positions(scene)
        self.dts, self.velocities = [], [self._velocities(self.positions, self.time)]
        self.control = step_control(scene, targets, tolerance, courant)
        self.control.dt_next = FIRST * self.longest_step

    @property
    def speed(self):
        """As of the ``Scheme``."""
        return courant_speed(self._fastest(2), self.scene)

    @property
    def error_speed(self):
        """As of the ``Scheme``."""
        return error_speed(self._fastest(3), self.scene)

    @property
    def longest_step(self):
        """As of the ``Scheme``."""
        return self.control.limit(self.speed)

    def run_to(self, target):
        """Return the steps to the time ``target``, one of those that the control meets; after many only count them."""
        while self.time < target and self.steps < MAX_STEPS:
            self._advance()
        if self.time < target:
            self.steps += math.ceil((target - self.time) / self.dts[0])
            self.time = target
        return self.steps

    def _advance(self):
        if self.time in self.scene.jump_times:
            self.dts, self.velocities = [], self.velocities[:1]
            self.control.dt_next = FIRST * self.longest_step
        for _ in range(MAX_ATTEMPTS):
            dt = self.control.choose_dt(self.time)
            times = TimeWeights([dt, *self.dts], dt)
            positions = self.positions + self._summed(times.step_integral())[:, :2]
            velocities = self._velocities(positions, self.time + dt)
            away = velocities - self._summed(times.extrapolation(VELOCITIES))
            difference = math.sqrt(np.mean(np.sum(away**2, axis=1)))
            error, order = times.step_error(difference, times.bdf()[0], self.error_speed)
            if self.control.accepts(error / self.error_speed, order, dt, unresolved=0.0):
                break
        if dt > self.longest:
            self.longest, self.bounded = dt, dt >= 0.99 * self.longest_step
        self.positions, self.time = positions, self.control.end(self.time, dt)
        self.velocities = [velocities, *self.velocities][:VELOCITIES]
        self.dts = [dt, *self.dts][: VELOCITIES - 1]
        self.steps += 1
        self.control.step_taken(self.time, self.speed)

    def _fastest(self, components):
        newest = self.velocities[0][:, :components]
        mean = newest[:, :2].mean(axis=0)
        mean = [mean[0], 0.0, 0.0] if self.scene.axisymmetric else mean  # as of the ``TimeLevels``
        return np.linalg.norm(newest - mean[: newest.shape[1]], axis=1).max()

    def _velocities(self, positions, time):
        """Velocities (n, 2), around an axis (n, 3)."""
        names = ("u", "v", "w") if self.scene.axisymmetric else ("u", "v")
        start = self.scene.initial(*positions.T)
        known = set(names) & set(self.scene.fields)
        exact = {name: self.scene.exact(name, *positions.T, time) for name in known}
        return np.stack([(start | exact)[name] for name in names], axis=-1)

    def _summed(self, weights):
        return sum(weight * each for weight, each in zip(weights, self.velocities, strict=False))


def _positions(scene):
    """Return positions (n, 2) in the fluid, no nearer to walls than particles are."""
    pitch = math.sqrt(math.prod(scene.extent) / N_POSITIONS)
    axes = [pitch * (np.arange(round(side / pitch)) + 0.5) for side in scene.extent]
    positions = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2) + scene.origin
    return positions[scene.distance(positions, scene.start_time) >= 0.5 * scene.spacing] if scene.bodies else positions
