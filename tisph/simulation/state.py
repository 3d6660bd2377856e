"""States of a run: its start, the states within the last step, and the ``State`` that a user's function receives.

A run may be computed in the frame of the flow, while its states are given in the frame of the config.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from tisph import runtime
from tisph.config.schema import Config
from tisph.measures.metrics import relative_error, velocities, with_reference
from tisph.observers.guard import Guard
from tisph.observers.protocol import Schedule, StateObserver
from tisph.scenes._scene import Scene
from tisph.schemes._protocol import Scheme
from tisph.snapshot import STRESSES, STRESSES_AROUND, Bodies, Snapshot

PARTICLES_PER_THREAD = 512
"""Taichi does not split a loop into shorter pieces than this."""

PARTICLES_PER_THREAD_WITH_PRESSURE = 2048
"""Particles per thread in flow with a pressure equation, whose linear solvers run on one thread anyway."""


def useful_threads(config: Config, scene: Scene) -> int:
    """Return the number of threads: ``runtime.threads``, or the useful number for the particles of ``scene``."""
    if config.runtime.threads != "auto":
        return config.runtime.threads
    least = PARTICLES_PER_THREAD
    if config.scheme.type != "wcsph" and not config.parallel:
        least = PARTICLES_PER_THREAD_WITH_PRESSURE
    return min(runtime.available_threads(), math.ceil(scene.particles / least))


def start_values(scene: Scene, initial: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Return positions (particles, 2), velocities (particles, components) and polymer stresses or None at the start.

    Stresses (particles, numbers) have the components xx, xy, yy, and tt, xt, yt in axisymmetric flow. ``initial`` is
    the section of the config.
    """
    x, y = scene.jittered(initial.seed, initial.jitter)
    fields = scene.initial(x, y)
    stresses = [fields[name] for name in (*STRESSES, *STRESSES_AROUND) if name in fields]
    stress = np.stack(stresses, 1) if scene.polymer else None
    return np.stack([x, y], 1), np.stack([fields[name] for name in ("u", "v", "w")[: scene.components]], 1), stress


def start_snapshot(scene: Scene, values: tuple[np.ndarray, np.ndarray, np.ndarray | None], precision: str) -> Snapshot:
    """Return the ``start_values`` of ``scene.in_flow_frame()`` as a Snapshot in the frame of ``scene``.

    It is the start of the config, before the impulse of walls. ``precision`` of the positions and velocities of the
    scheme: ``f64`` or ``f32``.
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
    state: dict[str, Any] = {
        "x": x,
        "y": y,
        **dict(zip(("u", "v", "w"), velocities, strict=False)),
        "density": nothing + scene.density,
        "pressure": nothing,
    }
    if "pressure" in scene.fields:
        state["pressure"] = scene.exact("pressure", x, y, scene.start_time)
    if scene.bodies:
        bodies = scene.in_flow_frame().bodies
        present = [number for number, body in enumerate(bodies) if body.enters <= scene.start_time]
        found = Bodies.at(scene.start_time, [bodies[number] for number in present])
        state["bodies"] = found if len(present) == len(bodies) else found.among(present, len(bodies))
    if scene.substances:
        state["substances"] = {each.name: each.initial(x, y, scene.start_time) for each in scene.substances}
    if scene.flows_through:
        state["passages"] = np.zeros(len(x), dtype=int)
    return seen_from_config(Snapshot(t=scene.start_time, step=0, **state, **stresses), scene)


def seen_from_config(snapshot: Snapshot, scene: Scene) -> Snapshot:
    """Return ``snapshot``, given in the frame of ``scene.in_flow_frame()``, in the frame of ``scene``."""
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
    """The last step as observers see it (``observers/protocol.py``); ``due`` has the times due of each observer.

    ``start`` is the state at the start of the run, where no step has been taken yet, else None. A state that several
    observers need, and the latest one, is computed once.
    """

    def __init__(
        self,
        scheme: Scheme,
        scene: Scene,
        guard: Guard,
        due: Sequence[Sequence[float]] = (),
        start: Snapshot | None = None,
    ):
        self.scheme, self.scene, self.guard = scheme, scene, guard
        self.time, self.steps = scheme.time, scheme.steps
        counts = Counter(time for times in due for time in set(times))
        self.latest = max(counts, default=self.time)
        self.kept_times = {time for time, count in counts.items() if count > 1} | {self.latest}
        self.kept = {} if start is None else {self.latest: start}
        self.sound = False

    def at(self, time: float) -> Snapshot:
        """Return the state at ``time``; DivergedError where the latest state is not sound.

        Earlier states lie between the latest one and a sound one, and are not checked.
        """
        self.check()
        return self._state(time)

    def check(self) -> None:
        """Let the guard check the latest state that is due, once."""
        if not self.sound:
            self.guard.check(self._state(self.latest))
            self.sound = True

    def end(self) -> Snapshot:
        """Return the state at the end of the step; a full check would cost more than many a line of the history."""
        state = self._state(self.time)
        stress = 0.0 if state.stress_xy is None else state.stress_xy
        if not np.isfinite(state.x + state.y + state.u + state.v + stress).all():
            self.check()
        return state

    def _state(self, time: float) -> Snapshot:
        if time not in self.kept:
            state = seen_from_config(self.scheme.snapshot(time), self.scene)
            if time not in self.kept_times:
                return state
            self.kept[time] = state
        return self.kept[time]


def _read_only(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return read-only views of the arrays among ``values``."""
    views = {name: value.view() for name, value in values.items() if isinstance(value, np.ndarray)}
    for each in views.values():
        each.flags.writeable = False
    return views


class State:
    """The fluid particles at time ``t``, after ``step`` steps: arrays (particles,) in the order of their creation.

    All numbers are in the units of the config. The arrays are read-only, and do not change when the run continues.
    """

    def __init__(self, snapshot: Snapshot, scene: Scene):
        bodies = snapshot.bodies and replace(snapshot.bodies, **_read_only(vars(snapshot.bodies)))
        substances = snapshot.substances and _read_only(snapshot.substances)
        self.snapshot = snapshot = replace(snapshot, **_read_only(vars(snapshot)), bodies=bodies, substances=substances)
        self._scene = scene
        self.t: float = snapshot.t
        """Time on the clock of the run."""
        self.step: int = snapshot.step
        """Steps of the run so far."""
        self.x: np.ndarray = snapshot.x
        """Positions along x, within the box of the scene."""
        self.y: np.ndarray = snapshot.y
        """Positions along y."""
        self.u: np.ndarray = snapshot.u
        """Velocities along x."""
        self.v: np.ndarray = snapshot.v
        """Velocities along y."""
        self.pressure: np.ndarray = snapshot.pressure
        """Pressure; NaN where the scheme has none."""
        self.substances: Mapping[str, np.ndarray] = snapshot.substances or {}
        """Temperature and dissolved substances by name."""

    def __repr__(self) -> str:
        return f"<State t={self.t:g}, step {self.step}, {len(self.x)} particles>"

    @property
    def stress(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Polymer stresses xx, xy, yy; None where the fluid has none."""
        xx, xy, yy = self.snapshot.stress_xx, self.snapshot.stress_xy, self.snapshot.stress_yy
        return None if xx is None or xy is None or yy is None else (xx, xy, yy)

    @cached_property
    def reference(self) -> dict[str, np.ndarray]:
        """The reference solution at the particles by field (``u``, ``v``, ...); empty where the scene has none."""
        return _read_only(with_reference(self._scene, self.snapshot).reference or {})

    @cached_property
    def error(self) -> np.ndarray | None:
        """Size of the difference between velocity and reference at each particle; None without a reference.

        Only components with a reference are included.
        """
        values, exact = velocities(self._scene, self.snapshot)
        return np.linalg.norm(values - exact, axis=0) if len(exact) else None

    @cached_property
    def l2(self) -> float | None:
        """Relative error sqrt(sum error^2 / sum reference^2), as in ``summary.json``; None without a reference."""
        return relative_error(self._scene, self.snapshot)


class Callback(StateObserver):
    """Calls ``function`` with each state that is due, but only in ``call``, when the step and its files are complete.

    Therefore an interrupt while the function runs finds the simulation between two steps.
    """

    def __init__(self, schedule: Schedule, function: Callable[[State], Any], scene: Scene):
        self.schedule, self.function, self.scene = schedule, function, scene
        self.waiting: list[State] = []

    def observe(self, snapshot: Snapshot) -> None:
        """Store a state until ``call``."""
        self.waiting.append(State(snapshot, self.scene))

    def call(self) -> None:
        """Call the function with each stored state; a state for which it fails is not repeated."""
        while self.waiting:
            self.function(self.waiting.pop(0))
