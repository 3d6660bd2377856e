"""States of a run: the first one, those within the last step, and what a function of the user sees.

A run may go in the frame of the flow, whatever frame the config sees it from.
"""

import math
from collections import Counter
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph import runtime
from tisph.measures.metrics import relative_error, velocities, with_reference
from tisph.observers.protocol import StateObserver
from tisph.snapshot import STRESSES, STRESSES_AROUND, Bodies, Snapshot

PARTICLES_PER_THREAD = 512
"""Taichi does not split a loop into shorter pieces than this."""

PARTICLES_PER_THREAD_WITH_PRESSURE = 2048
"""The same in two-dimensional flow with a pressure equation: loops of its linear solvers, most of all that there are,
run on one thread anyway."""


def useful_threads(config, scene):
    """Return the number of threads that ``runtime.threads`` means for this many particles."""
    if config.runtime.threads != "auto":
        return config.runtime.threads
    least = PARTICLES_PER_THREAD
    if config.scheme.type != "wcsph" and not config.parallel:
        least = PARTICLES_PER_THREAD_WITH_PRESSURE
    return min(runtime.available_threads(), math.ceil(scene.particles / least))


def start_values(scene, initial):
    """Return positions (particles, 2), velocities (particles, components) and polymer stresses or None at the start.

    Stresses have shape (particles, numbers), with those around the axis of axisymmetric flow after the three others.
    """
    x, y = scene.jittered(initial.seed, initial.jitter)
    fields = scene.initial(x, y)
    stresses = [fields[name] for name in (*STRESSES, *STRESSES_AROUND) if name in fields]
    stress = np.stack(stresses, 1) if scene.polymer else None
    return np.stack([x, y], 1), np.stack([fields[name] for name in ("u", "v", "w")[: scene.components]], 1), stress


def start_snapshot(scene, values, precision):
    """Return the ``start_values`` of ``scene.in_flow_frame()`` as a Snapshot in the frame of ``scene``.

    It is the start as the config says, before walls give their impulse. ``precision``: ``f64`` or ``f32``, in which a
    scheme holds positions and velocities.
    """
    position, velocity, stress = values
    kind = np.float32 if precision == "f32" else np.float64
    x, y, *velocities = (column.astype(kind) for column in (*position.T, *velocity.T))
    nothing = np.zeros(len(x))
    stresses = {} if stress is None else dict(zip((*STRESSES, *STRESSES_AROUND), stress.T, strict=False))
    x, y = (
        place % size if periodic else place
        for place, size, periodic in zip((x, y), scene.extent, scene.periodic, strict=True)
    )
    state = {
        "x": x,
        "y": y,
        **dict(zip(("u", "v", "w"), velocities, strict=False)),
        "density": nothing + scene.density,
        "pressure": nothing,
    }
    if "pressure" in scene.fields:
        state["pressure"] = scene.exact("pressure", x, y, scene.start_time)
    if scene.bodies:
        state["bodies"] = Bodies.at(scene.start_time, scene.in_flow_frame().bodies)
    return seen_from_config(Snapshot(t=scene.start_time, step=0, **state, **stresses), scene)


def seen_from_config(snapshot, scene):
    """Return ``snapshot`` of a run in the frame of ``scene.in_flow_frame()`` as the config's ``scene`` sees it."""
    velocity = scene.frame_velocity
    if velocity == 0.0:
        return snapshot
    travelled = velocity * (snapshot.t - scene.start_time)
    x = (snapshot.x.astype(float) + travelled) % scene.extent[0]
    bodies, along = snapshot.bodies, np.array([1.0, 0.0])
    if bodies is not None:
        bodies = replace(bodies, centre=bodies.centre + travelled * along, velocity=bodies.velocity + velocity * along)
    return replace(snapshot, x=x, u=snapshot.u.astype(float) + velocity, bodies=bodies)


class LastStep:
    """What ``observers/protocol.py`` calls the last step; ``due`` has the times that each observer waits for.

    ``start`` is the state at the start of the run, where no step has been taken yet, else None.
    """

    def __init__(self, scheme, scene, guard, due=(), start=None):
        self.scheme, self.scene, self.guard = scheme, scene, guard
        self.time, self.steps = scheme.time, scheme.steps
        counts = Counter(time for times in due for time in set(times))
        self.latest = max(counts, default=self.time)
        self.kept_times = {time for time, count in counts.items() if count > 1} | {self.latest}
        self.kept = {} if start is None else {self.latest: start}
        self.sound = False

    def at(self, time):
        """Return the state at ``time``; DivergedError where the guard finds that the latest one is not sound.

        Those before it lie between that one and a state that was sound.
        """
        self.check()
        return self._state(time)

    def check(self):
        """Let the guard see the latest state that is asked for, once."""
        if not self.sound:
            self.guard.check(self._state(self.latest))
            self.sound = True

    def around(self, times, x, half_width):
        """Return the particles within ``half_width`` of the place ``x`` at ``times``: which time, x, y and u of each.

        The guard looks first where they are within a step, as such steps are long and few. Where they are the ends of
        short steps it looks at one in ``guard.INTERVAL``: whole states cost much more than what is asked for here.
        """
        if any(time != self.time for time in times):
            self.check()
        velocity = self.scene.frame_velocity
        travelled = velocity * (np.array(times) - self.scene.start_time)
        when, places, y, u = self.scheme.around(times, x - travelled, half_width)
        return when, places + travelled[when], y, u + velocity

    def _state(self, time):
        if time not in self.kept:
            state = seen_from_config(self.scheme.snapshot(time), self.scene)
            if time not in self.kept_times:
                return state
            self.kept[time] = state
        return self.kept[time]


class State:
    """The fluid particles at time ``t``, after ``step`` steps: arrays (particles,) in the order of their creation.

    All numbers are in the units of the config. The arrays belong to this state and do not change with the run.
    """

    def __init__(self, snapshot: Snapshot, scene: Any):
        self.snapshot = snapshot
        self._scene = scene

    def __repr__(self) -> str:
        return f"<State t={self.t:g}, step {self.step}, {len(self.x)} particles>"

    @property
    def t(self) -> float:
        """Time on the clock of the run."""
        return self.snapshot.t

    @property
    def step(self) -> int:
        """Steps of the run so far."""
        return self.snapshot.step

    @property
    def x(self) -> np.ndarray:
        """Positions along x, within the box of the scene."""
        return self.snapshot.x

    @property
    def y(self) -> np.ndarray:
        """Positions along y."""
        return self.snapshot.y

    @property
    def u(self) -> np.ndarray:
        """Velocities along x."""
        return self.snapshot.u

    @property
    def v(self) -> np.ndarray:
        """Velocities along y."""
        return self.snapshot.v

    @property
    def pressure(self) -> np.ndarray:
        """Pressure; NaN where the scheme has none."""
        return self.snapshot.pressure

    @property
    def stress(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Polymer stresses xx, xy, yy; None where the fluid has none."""
        parts = self.snapshot.stress_xx, self.snapshot.stress_xy, self.snapshot.stress_yy
        return None if parts[0] is None else parts

    @cached_property
    def reference(self) -> dict[str, np.ndarray]:
        """The reference solution at the particles by field (``u``, ``v``, ...); empty where the scene has none."""
        return with_reference(self._scene, self.snapshot).reference or {}

    @cached_property
    def error(self) -> np.ndarray | None:
        """Size of the difference between velocity and reference at each particle; None without a reference.

        Of the components that have a reference, one or both.
        """
        values, exact = velocities(self._scene, self.snapshot)
        return np.linalg.norm(values - exact, axis=0) if len(exact) else None

    @cached_property
    def l2(self) -> float | None:
        """Relative error sqrt(sum error^2 / sum reference^2), as in ``summary.json``; None where there is none."""
        return relative_error(self._scene, self.snapshot)


class Callback(StateObserver):
    """Calls ``function`` with each state that is due; ``call`` does it, once the step is done with all its files.

    So an interrupt, which may come while the function runs, finds the simulation between two steps.
    """

    def __init__(self, schedule, function, scene):
        self.schedule, self.function, self.scene = schedule, function, scene
        self.waiting = []

    def observe(self, snapshot):
        """Keep a state until ``call``."""
        self.waiting.append(State(snapshot, self.scene))

    def call(self):
        """Call the function; a state that it fails with does not come again."""
        while self.waiting:
            self.function(self.waiting.pop(0))
