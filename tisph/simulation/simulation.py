"""A simulation in your hand: it steps when it is told to, can be looked at in between, and writes nothing unasked."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from tisph import runtime, scenes, schemes
from tisph.config import Config
from tisph.config.loader import Asked, loaded
from tisph.errors import ConfigError, DivergedError, TisphError
from tisph.observers._storage import Description
from tisph.observers.guard import Guard
from tisph.observers.protocol import Observer, Schedule
from tisph.observers.schedule import EveryTime
from tisph.simulation import checkpoint, process
from tisph.simulation.checkpoint import OTHER_STEPS
from tisph.simulation.functions import with_functions
from tisph.simulation.process import Costs, interrupts_after, log, warn
from tisph.simulation.recording import Recording
from tisph.simulation.state import Callback, LastStep, State, start_snapshot, start_values, useful_threads

Field: TypeAlias = "Callable[[np.ndarray, np.ndarray, float], tuple[Any, ...]]"
"""A field of places x, y and a time: its physical components, one array (or number) each."""

REMOVED = 1e-3
"""Part of the largest velocity from which on a user is told that the divergence of an initial velocity was removed."""


class Simulation:
    """A run that goes on step by step, in this process; ``config`` is a YAML file, a dict or a ``Config``.

    ``overrides`` are values by dotted key, as for ``tisph.run``. Nothing is written, unless ``save`` or ``results``
    asks for it. ``initial_velocity``, ``body_force`` (an acceleration) and ``conformation_source`` are functions of
    (x, y, t), arrays of places and a time, that return physical components. The first two have them along x and y, in
    axisymmetric flow along the axis, along the radius and around the axis; the source of the conformation tensor
    [1/time] has xx, xy, yy, in axisymmetric flow xx, xr, rr, tt, xt, rt. There is no reference then; where functions
    alone move the fluid, give ``reference.velocity``. Scheme ``implicit`` removes the divergence of an initial velocity
    in two-dimensional flow; a warning says so where that changes it.

    Its steps are those of ``tisph run``, bitwise: whoever looks does not change them. Ctrl-C takes effect after the
    step that is being taken, and the simulation can go on from there. There can be one open simulation in a process;
    ``close`` ends it, as does a ``with`` block. DivergedError where a state is not sound.
    """

    def __init__(
        self,
        config: Asked,
        /,
        *,
        initial_velocity: "Field | None" = None,
        body_force: "Field | None" = None,
        conformation_source: "Field | None" = None,
        **overrides: Any,
    ):
        self._set_up(loaded(config, overrides), None, initial_velocity, body_force, conformation_source)

    @classmethod
    def restore(
        cls,
        path: "str | PathLike[str]",
        config: "Asked | None" = None,
        /,
        *,
        body_force: "Field | None" = None,
        conformation_source: "Field | None" = None,
        **overrides: Any,
    ) -> "Simulation":
        """Return the simulation that was saved in ``path``; it goes on bitwise as it would have.

        ``config`` is the one that it was made with if none is given; ``time.end`` may be later, with samples after the
        old end. Functions are to be given again. ConfigError where the checkpoint does not fit.
        """
        simulation = cls.__new__(cls)
        if config is None:
            config = checkpoint.config_of(Path(path))
        simulation._set_up(loaded(config, overrides), Path(path), None, body_force, conformation_source)
        return simulation

    def _set_up(self, config: Config, restored_from: Path | None, *functions: Any) -> None:
        self.config = config
        self.resolved, self.reason = schemes.resolve(config)
        self.scene = with_functions(scenes.of(config), self.resolved.scheme.type, *functions)
        self.functions = any(function is not None for function in functions)
        self.threads = useful_threads(config, self.scene)
        self.costs = Costs()
        self.about = Description(config, self.scene)
        self.guard = Guard(self.scene)
        self.observers: list[Observer] = [self.guard]
        self.callbacks: list[Callback] = []
        self.recording = None
        self.restored = restored_from is not None
        self.scheme = self._last = self._start = None
        self._begun = False
        process.claim(self)
        try:
            with self.costs.timed("compile"):
                self._build(restored_from)
        except BaseException:
            process.release(self)
            raise

    def _build(self, restored_from: Path | None) -> None:
        runtime.start(self.config.discretisation.precision, self.threads)
        config = self.resolved
        targets = sorted({*config.time.samples, config.time.end})
        self.program = runtime.program()
        self.scheme = schemes.build(config, self.scene.in_flow_frame(), targets, serial=self.threads == 1)
        log.info("scheme %s", self.reason)
        if restored_from and not checkpoint.restore(restored_from, self.scheme, self.about.resolved, targets):
            warn(OTHER_STEPS)
        self.first_step = self.scheme.steps
        log.info("%s: %d particles, %d threads", self.config.name, self.scene.particles, self.threads)

    def __repr__(self) -> str:
        return f"<Simulation {self.config.name}: t={self.time:g} of {self.config.time.end:g}, step {self.steps}>"

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def time(self) -> float:
        """Time at the end of the last step."""
        return self._last.t if self.scheme is None else self.scheme.time

    @property
    def steps(self) -> int:
        """Steps of the run so far."""
        return self._last.step if self.scheme is None else self.scheme.steps

    @property
    def finished(self) -> bool:
        """Whether the end of the run is reached."""
        return self.scheme is None or self.scheme.finished

    @property
    def state(self) -> State:
        """The particles at the end of the last step; at the start, as the config says, before the first one."""
        if self.scheme is not None and (self._last is None or self._last.step != self.scheme.steps):
            self.begin()
            self._last = State(self._start or self._last_step().at(self.scheme.time), self.scene)
        return self._last

    def step(self) -> None:
        """Take one step and tell observers and callbacks what is due; TisphError where the run has ended."""
        self.begin()
        if self.scheme.finished:
            raise TisphError(f"the run has ended, at t = {self.time:g}: there is no further step")
        self._call_back()  # what an interrupt has left
        with interrupts_after(), self._ending_on_failure():
            self._advance()
            self._tell()
        self._call_back()
        if self.scheme.finished and self.recording:
            self.recording.finish("done")

    def run_until(self, time: float) -> State:
        """Step until ``time`` is reached and return the state then.

        Steps go on to where they would have ended: the state is interpolated within the last one where the scheme
        does that, else it is that at the end of the step (``state.t`` tells).
        """
        if time > self.config.time.end:
            raise ConfigError(
                f"run_until: t = {time:g} is after the end of the run, time.end = {self.config.time.end:g}"
            )
        before = math.inf
        while self.time < time:
            before = self.time
            self.step()
        return self._state_at(time) if before < time < self.time else self.state

    def every(self, interval: float) -> Iterator[State]:
        """Step to the end of the run, and yield the states at the multiples of ``interval`` on the way.

        Multiples count from the start of the run's clock, and those after the present time are yielded.
        """
        schedule = EveryTime(interval)
        schedule.begin(self.scene.start_time, self.time, self.steps)
        while not self.finished:
            self.step()
            due = self.scheme.output_times(schedule.pending(self.time, self.steps))
            schedule.mark(self.time, self.steps)
            yield from [self._state_at(each) for each in due]

    def on(self, schedule: Schedule, function: Callable[[State], Any]) -> None:
        """Let ``function`` be called with the state whenever ``schedule``, of ``tisph.every``, says that it is due."""
        schedule.begin(self.scene.start_time, self.time, self.steps)
        self.callbacks.append(Callback(schedule, function, self.scene))

    def save(self, path: "str | PathLike[str]") -> None:
        """Write the whole state into the file ``path``, from which ``restore`` goes on bitwise as it would have."""
        self.begin()
        checkpoint.save(Path(path), self.scheme, self.about.resolved)

    def results(self, folder: "str | PathLike[str]", *, overwrite: bool = False, video: bool = True) -> None:
        """Leave in ``folder`` what ``tisph run`` leaves there; ``tisph.open`` reads it.

        It is to be called before the first step, as the record begins with the start of the run; after ``restore``, of
        the folder in which the run has been recorded up to then. The folder is complete once the run is finished, or
        has diverged, or was closed: then it can be gone on from as after Ctrl-C. ``overwrite`` as for ``tisph.run``.
        """
        process.require(self)
        if self.functions:
            raise ConfigError("results: a folder holds what its config says, and that cannot say what a function is")
        if self.recording or (self.steps > self.first_step):
            raise TisphError("results: is to be called once, before the first step, as results begin with the start")
        self.recording = Recording.of(self, Path(folder), overwrite=overwrite, video=video)

    def observe(self, *observers: Observer) -> None:
        """Let ``observers`` (``observers/protocol.py``) be told of the run, after those that there are."""
        for observer in observers:
            observer.schedule.begin(self.scene.start_time, self.time, self.steps)
            self.observers.append(observer)

    def close(self) -> None:
        """End the simulation and give Taichi's memory back; the last state can still be looked at."""
        if self.scheme is None:
            return
        try:
            if runtime.program() is self.program:
                self.state  # noqa: B018 (it is kept)
                if self.recording:
                    self.recording.finish("done" if self.finished else "interrupted")
        finally:
            self.release()

    def release(self) -> None:
        """Give Taichi's memory back, and leave everything else as it is."""
        self.scheme = None
        process.release(self)

    def begin(self) -> None:
        """Place the particles, which compiles kernels, and tell what is due at the start; once, before the rest."""
        process.require(self)
        if self._begun:
            return
        with interrupts_after(), self._ending_on_failure():
            self.place()
            self._begun = True
            if self.restored:
                self._last_step().check()
            else:
                self._tell()

    def place(self) -> None:
        """Place the particles where they start, unless they are restored."""
        if self.restored or self._start is not None:
            return
        with self.costs.timed("compile"):
            values = start_values(self.scene.in_flow_frame(), self.config.initial)
            self.scheme.start(*values)
        if self.scene.has_own_start and self.scheme.removed_divergence > REMOVED:
            warn(
                "the divergence of the initial velocity, and the flow through walls, was removed: it changes by up to "
                f"{100 * self.scheme.removed_divergence:.2g} % of the largest velocity"
            )
        self._start = start_snapshot(self.scene, values, self.config.discretisation.precision)

    def _advance(self) -> None:
        self._start = None
        try:
            with self.costs.timed("loop"):
                self.scheme.advance()
        except DivergedError:
            self._last_step().check()  # what has gone wrong may have a plainer name
            raise

    def _tell(self) -> None:
        """Tell the observers what is due, and let the callbacks have theirs ready."""
        time_, steps = self.scheme.time, self.scheme.steps
        due = [each for each in (*self.observers, *self.callbacks) if each.schedule.due(time_, steps)]
        if not due:
            return
        with self.costs.timed("output"):
            pending = [self.scheme.output_times(each.schedule.pending(time_, steps)) for each in due]
            step = self._last_step(pending)
            for observer, times in zip(due, pending, strict=True):
                observer.schedule.mark(time_, steps)
                observer.tell(step, times)

    def _call_back(self) -> None:
        for callback in self.callbacks:
            callback.call()

    def _last_step(self, due: Any = ()) -> LastStep:
        return LastStep(self.scheme, self.scene, self.guard, due, self._start)

    def _state_at(self, time: float) -> State:
        return State(self._last_step([[time]]).at(time), self.scene)

    @contextmanager
    def _ending_on_failure(self) -> Iterator[None]:
        """Let a failure end what is recorded."""
        try:
            yield
        except Exception as error:
            if self.recording:
                self.recording.fail(error)
            raise
