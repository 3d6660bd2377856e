"""A simulation stepped from Python: it can be read between steps, and writes files only on request."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from types import new_class
from typing import Any, TypeAlias, cast

import numpy as np

from tisph import runtime, scenes, schemes
from tisph.config.fields import nearest
from tisph.config.loader import Asked, loaded
from tisph.config.schema import Config
from tisph.errors import ConfigError, DivergedError, TisphError
from tisph.geometry import motion
from tisph.observers.guard import Guard
from tisph.observers.protocol import Observer, Schedule, every
from tisph.observers.samples import Description
from tisph.scenes._scene import Scene
from tisph.schemes._protocol import Scheme
from tisph.simulation import checkpoint, process
from tisph.simulation.checkpoint import OTHER_STEPS
from tisph.simulation.first_run import FirstRun, restored
from tisph.simulation.process import Costs, interrupts_after, log, warn
from tisph.simulation.recording import Recording
from tisph.simulation.state import Callback, LastStep, State, start_snapshot, start_values, useful_threads
from tisph.snapshot import Snapshot

Field: TypeAlias = Callable[[np.ndarray, np.ndarray, float], Sequence[Any]]
"""Function of places x, y and a time that returns physical components of a field, one array (or number) each."""

REMOVED = 1e-3
"""Change of an initial velocity by removing its divergence, over the largest velocity, above which a user is warned."""


class Simulation:
    """A run that advances step by step in this process; ``config`` is a YAML file, a dict or a ``Config``.

    ``overrides`` are values by dotted key, as for ``tisph.run``. Nothing is written, unless ``save`` or ``results`` is
    called. ``initial_velocity``, ``body_force`` (an acceleration), ``velocity`` and ``conformation_source`` are
    functions of (x, y, t), arrays of places and a time, that return physical components. The first three have
    components along x and y, in axisymmetric flow along the axis, along the radius and around the axis. ``velocity`` is
    the velocity at all times: it takes the place of the equations for velocity and pressure, and may return du/dx,
    du/dy, dv/dx, dv/dy after u and v. The source of the conformation tensor [1/time] has xx, xy, yy, in axisymmetric
    flow xx, xr, rr, tt, xt, rt. With a function there is no reference; where functions alone move the fluid, give
    ``reference.velocity``. In two-dimensional flow the divergence of an initial velocity is removed, with a warning.

    With ``discretisation.refine: auto`` the first run goes on at once, and ``config`` has the places that it found.

    Its steps equal the steps of ``tisph run`` bitwise. After Ctrl-C, which takes effect after the present step, it can
    continue. ``close`` or ``with`` ends it; a process can have one. DivergedError where a state is not sound.
    """

    def __init__(
        self,
        config: Asked,
        /,
        *,
        initial_velocity: "Field | None" = None,
        body_force: "Field | None" = None,
        velocity: "Field | None" = None,
        conformation_source: "Field | None" = None,
        **overrides: Any,
    ):
        functions = initial_velocity, body_force, velocity, conformation_source
        config = loaded(config, overrides)
        if config.discretisation.refine == "auto":
            first = FirstRun(config)
            self._set_up(first.config, None, *functions)
            self.observe(first)
            while not self.finished:
                self.step()
            config = first.refined(self.scene)
            self.release()
        self._set_up(config, None, *functions)

    @classmethod
    def restore(
        cls,
        path: "str | PathLike[str]",
        config: "Asked | None" = None,
        /,
        *,
        body_force: "Field | None" = None,
        velocity: "Field | None" = None,
        conformation_source: "Field | None" = None,
        **overrides: Any,
    ) -> "Simulation":
        """Return the simulation that was saved in ``path``; it continues bitwise as the saved one would have.

        Without a ``config`` it has the config of the checkpoint. A given config may differ in a later ``time.end``,
        with samples after the old end. Functions must be given again. ConfigError where the checkpoint does not fit.
        """
        simulation = cls.__new__(cls)
        config = loaded(checkpoint.config_of(Path(path)) if config is None else config, overrides)
        if config.discretisation.refine == "auto":
            config = restored(config, Path(path))
        simulation._set_up(config, Path(path), None, body_force, velocity, conformation_source)
        return simulation

    def _set_up(self, config: Config, restored_from: Path | None, *functions: Any) -> None:
        self.config = config
        self._functions = functions
        self.resolved, self.reason = schemes.resolve(config)
        self.scene = with_functions(scenes.of(config), self.resolved.scheme.type, *functions)
        self.functions = any(function is not None for function in functions)
        self.threads = useful_threads(config, self.scene)
        self.costs = Costs()
        self.about = Description(config, self.scene)
        self.guard = Guard(self.scene)
        self.observers: list[Observer] = [self.guard]
        self.callbacks: list[Callback] = []
        self.recording: Recording | None = None
        self.restored = restored_from is not None
        self.scheme: Scheme | None = None
        self._last: State | None = None
        self._start: Snapshot | None = None
        self._stepped_from = math.inf
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
        scheme = schemes.build(config, self.scene.in_flow_frame(), targets, serial=self.threads == 1)
        log.info("scheme %s", self.reason)
        if restored_from and not checkpoint.restore(restored_from, scheme, self.about.resolved, targets):
            warn(OTHER_STEPS)
        self.scheme, self.first_step = scheme, scheme.steps
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
        return self.state.t if self.scheme is None else self.scheme.time

    @property
    def steps(self) -> int:
        """Steps of the run so far."""
        return self.state.step if self.scheme is None else self.scheme.steps

    @property
    def finished(self) -> bool:
        """Whether the end of the run is reached."""
        return self.scheme is None or self.scheme.finished

    @property
    def state(self) -> State:
        """The particles at the end of the last step; before the first one the start of the config."""
        if self.scheme is not None and (self._last is None or self._last.step != self.scheme.steps):
            self.begin()
            self._last = State(self._start or self._last_step().at(self.scheme.time), self.scene)
        if self._last is None:
            raise TisphError("the simulation is closed, and its last state was not stored")
        return self._last

    def step(self) -> None:
        """Take one step and call the observers and callbacks that are due; TisphError where the run has ended."""
        self.begin()
        scheme = self._open_scheme()
        if scheme.finished:
            raise TisphError(f"the run has ended, at t = {self.time:g}: there is no further step")
        self._call_back()  # callbacks that an interrupt has prevented
        with interrupts_after(), self._ending_on_failure():
            self._start = None
            self._stepped_from = scheme.time
            try:
                with self.costs.timed("loop"):
                    scheme.advance()
            except DivergedError:
                self._last_step().check()  # the guard may name the cause more plainly
                raise
            self._tell()
        self._call_back()
        if scheme.finished and self.recording:
            self.recording.finish("done")

    def run_until(self, time: float) -> State:
        """Step until ``time`` is reached and return the state then.

        It is interpolated within the last step, or is the end of that step (``state.t``) if the scheme cannot do so.
        ConfigError where ``time`` is before the last step, or after the end of the run.
        """
        if time > self.config.time.end:
            raise ConfigError(
                f"run_until: t = {time:g} is after the end of the run, time.end = {self.config.time.end:g}"
            )
        while self.time < time:
            self.step()
        if time == self.time:
            return self.state
        if not self._stepped_from < time:
            raise ConfigError(f"run_until: t = {time:g} is over, the run is at t = {self.time:g}")
        return self._state_at(time)

    def every(self, interval: float) -> Iterator[State]:
        """Step to the end, and yield states at multiples of ``interval`` on the run's clock; ConfigError if <= 0."""
        schedule = every(time=interval)
        schedule.begin(self.scene.start_time, self.time, self.steps)
        while not self.finished:
            self.step()
            due = self._open_scheme().output_times(schedule.take(self.time, self.steps) or [])
            yield from [self._state_at(each) for each in due]

    def on(self, schedule: Schedule, function: Callable[[State], Any]) -> None:
        """Call ``function`` with the state whenever ``schedule``, from ``tisph.every``, has a time due."""
        own = copy(schedule)  # one schedule may be given for several functions
        own.begin(self.scene.start_time, self.time, self.steps)
        self.callbacks.append(Callback(own, function, self.scene))

    def save(self, path: "str | PathLike[str]") -> None:
        """Write the whole state into the file ``path``, from which ``restore`` continues bitwise."""
        self.begin()
        checkpoint.save(Path(path), self._open_scheme(), self.about.resolved)

    def results(self, folder: "str | PathLike[str]", *, overwrite: bool = False, video: bool = True) -> None:
        """Write the files of ``tisph run`` into ``folder``; ``tisph.open`` reads them.

        Call it before the first step; after ``restore``, with the folder that has the record up to then. The folder is
        complete once the run has ended or was closed. ``overwrite`` as for ``tisph.run``.
        """
        self._open_scheme()
        if self.functions:
            raise ConfigError("results: cannot be written for a run with Python functions, which no config can contain")
        if self.recording or (self.steps > self.first_step):
            raise TisphError("results: is to be called once, before the first step, as results begin with the start")
        self.recording = Recording.of(self, Path(folder), overwrite=overwrite, video=video)

    def set(self, key: str, value: "float | Field", over: float = 0.0) -> None:
        """Change a wall, drive, inflow or ``body_force`` to ``value``, from ``time`` on, within a time ``over``.

        ``key``: ``walls.top.velocity``, ``drive.acceleration``, ``ends.left.velocity``. The ``config``, the reference,
        checkpoints and the folder of ``results`` include the change. ConfigError where the flow takes no such change.
        """
        self.begin()
        scheme, recording = self._open_scheme(), self.recording
        if self.finished or not self.steps:
            raise ConfigError(f"set: {key} can be changed after the first step and before the end of the run")
        config, functions = self.config, self._functions
        if key == "body_force":
            if recording or over or not callable(value):
                raise ConfigError("set: body_force needs a function, without over, and no results, as no config has it")
            functions = (functions[0], value, *functions[2:])
            with_functions(scenes.of(config), self.resolved.scheme.type, *functions)
        elif callable(value):
            raise ConfigError(f"set: {key} must be a number; a function is for body_force")
        else:
            config = changed(config, key, value, self.time, over)
        own = [each for each in self.observers if each not in (self.guard, *(recording.added if recording else ()))]
        # the new config has the values at ``times``; the run goes on from a checkpoint, as after Ctrl-C
        callbacks, costs, first_step = self.callbacks, self.costs, self.first_step
        if recording:
            recording.finish("interrupted")
        with TemporaryDirectory() as folder:
            checkpoint.save(path := Path(folder) / "checkpoint.h5", scheme, config.resolved_yaml())
            self.release()
            self._set_up(config, path, *functions)
        # steps are to end where the change ends
        self._open_scheme().set_targets(sorted({*self.config.time.samples, self.config.time.end}))
        self.costs, self.first_step, self._begun = costs, first_step, True
        self.observers += own
        self.callbacks = callbacks
        for callback in callbacks:
            callback.scene = self.scene
        if recording:
            root, video = recording.folder.root, recording.movie is not None
            self.recording = Recording.of(self, root, overwrite=False, video=video)
            self.recording.save()  # the one in the folder has the old config
        log.info("%s = %r from t = %r on", key, value, self.time)

    def observe(self, *observers: Observer) -> None:
        """Add ``observers`` (``observers/protocol.py``), to be called after the present ones."""
        for observer in observers:
            observer.schedule.begin(self.scene.start_time, self.time, self.steps)
            self.observers.append(observer)

    def close(self) -> None:
        """End the simulation and release Taichi's memory; the last state can still be read."""
        if self.scheme is None:
            return
        try:
            if runtime.program() is self.program:
                self.state  # noqa: B018 (the property stores the last state)
                if self.recording:
                    self.recording.finish("done" if self.finished else "interrupted")
        finally:
            self.release()

    def release(self) -> None:
        """Release Taichi's memory, and leave everything else as it is."""
        self.scheme = None
        process.release(self)

    def begin(self) -> None:
        """Place the particles, which compiles kernels, and call the observers due at the start; once."""
        self._open_scheme()
        if self._begun:
            return
        with interrupts_after(), self._ending_on_failure():
            self.place()
            self._begun = True
            if self.restored:
                self._last_step().check()
            else:
                self._tell()

    def _open_scheme(self) -> Scheme:
        """Return the scheme; TisphError where the simulation is closed or its fields are destroyed."""
        if self.scheme is None:
            raise TisphError("the simulation is closed; its last state is all that is left of it")
        if runtime.program() is not self.program:
            raise TisphError("the fields of this simulation are gone: ti.init or ti.reset was called since it began")
        return self.scheme

    def place(self) -> None:
        """Place the particles where they start, unless they are restored."""
        if self.restored or self._start is not None:
            return
        scheme, config = self._open_scheme(), self.config
        with self.costs.timed("compile"):
            values = start_values(self.scene.in_flow_frame(), config.initial)
            scheme.start(*values)
        removed = getattr(scheme, "removed_divergence", 0.0)
        if self.scene.has_own_start and removed > REMOVED:
            warn(
                "the divergence of the initial velocity, and the flow through walls, was removed: it changes by up to "
                f"{100 * removed:.2g} % of the largest velocity"
            )
        self._start = start_snapshot(self.scene, values, config.discretisation.precision)

    def _tell(self) -> None:
        """Call the observers that are due, and store the states of the callbacks."""
        scheme = self._open_scheme()
        time_, steps = scheme.time, scheme.steps
        taken = [(each, each.schedule.take(time_, steps)) for each in (*self.observers, *self.callbacks)]
        due = [(observer, times) for observer, times in taken if times is not None]
        if not due:
            return
        with self.costs.timed("output"):
            pending = [scheme.output_times(times) for _, times in due]
            step = self._last_step(pending)
            for (observer, _), times in zip(due, pending, strict=True):
                observer.tell(step, times)

    def _call_back(self) -> None:
        for callback in self.callbacks:
            callback.call()

    def _last_step(self, due: Any = ()) -> LastStep:
        return LastStep(self._open_scheme(), self.scene, self.guard, due, self._start)

    def _state_at(self, time: float) -> State:
        return State(self._last_step([[time]]).at(time), self.scene)

    @contextmanager
    def _ending_on_failure(self) -> Iterator[None]:
        """End the recording where an exception ends the block."""
        try:
            yield
        except Exception as error:
            if self.recording:
                self.recording.fail(error)
            raise


VALUES_AT_TIMES = {
    "velocity": "velocities",
    "angular_velocity": "angular_velocities",
    "shear_stress": "stresses",
    "acceleration": "accelerations",
}
"""Key of a constant value of a wall, an inlet or the drive -> key of its values at ``times``."""


def changed(config: Config, key: str, value: float, time: float, over: float = 0.0) -> Any:
    """Return ``config`` whose value under the dotted ``key`` changes to ``value`` from ``time`` to ``time + over``.

    ConfigError where the value cannot be changed in a run, and where the scene refuses the config.
    """
    sections = {f"{name}.{side}": part for name in ("walls", "ends") for side, part in _parts(config, name)}
    sections["drive"] = getattr(config, "drive", None)
    keys = {
        f"{place}.{name}": (place, name, many)
        for place, part in sections.items()
        for name, many in VALUES_AT_TIMES.items()
        if hasattr(part, many) and (getattr(part, name) is not None or getattr(part, many) is not None)
        if not getattr(part, "amplitude", None)
    }
    if key not in keys:
        found = f"must be one of {', '.join(keys)}{nearest(key, keys)}" if keys else "nothing of this flow can be"
        raise ConfigError(f"set: {key} cannot be changed in a run; {found}")
    place, name, many = keys[key]
    part = sections[place]
    times, values = part.times or (0.0,), getattr(part, many) or (getattr(part, name),)
    if many == "stresses":  # each from its time on
        if over:
            raise ConfigError(f"set: {key} jumps: leave out over")
        changes, past = [(time, value)], [(0.0, 0.0)]
    else:
        before = float(motion.Schedule(times, values).velocity(time))
        changes, past = [(time, before), (time + over, value)], [(0.0, values[0])]
    past = [pair for pair in zip(times, values, strict=True) if pair[0] < time] or past
    table = [*past, *changes]
    constant = {key: 0.0 if place == "drive" else None}
    given = {f"{place}.times": [when for when, _ in table], f"{place}.{many}": [each for _, each in table]}
    return loaded(config, {**constant, **given})


def _parts(config: Config, name: str) -> list[tuple[str, Any]]:
    """Return the parts of the section ``name`` of a ``config``; none without the section."""
    section = getattr(config, name, None)
    return list(vars(section).items()) if section else []


def with_functions(
    scene: Scene,
    scheme: str,
    initial_velocity: Field | None = None,
    body_force: Field | None = None,
    velocity: Field | None = None,
    conformation_source: Field | None = None,
) -> Scene:
    """Return ``scene`` with initial velocity, acceleration, velocity and source given as functions of (x, y, t).

    Each function takes arrays (particles,) of places, and a time. It returns physical components, which broadcast to
    the places: velocity and acceleration along x and y, and around the axis as a third one in axisymmetric flow; the
    source as xx, xy, yy, in axisymmetric flow xx, xr, rr, tt, xt, rt of the conformation tensor per time. After u and v
    a ``velocity`` may have du/dx, du/dy, dv/dx, dv/dy. A drive of the config is added to the body force. Such a flow
    has no reference. ConfigError where the scene, or the ``scheme`` (its type), cannot take one of them.
    """
    free = scene.periodic == (True, True) and not scene.bodies and not scene.parallel
    planar = scheme == "implicit" and not scene.parallel
    if initial_velocity is not None and not (free or planar):
        raise ConfigError(
            f"initial_velocity: with scheme {scheme} this scene starts from rest or from its own solution; a function "
            "can be given in the scenes taylor_green and shear_layer, and with scheme implicit in all two-dimensional "
            "flows"
        )
    if body_force is not None and scheme == "implicit" and scene.parallel:
        raise ConfigError(
            f"body_force: scheme {scheme} knows no acceleration but a constant drive.acceleration in a channel without "
            "bodies; a function can be given with scheme wcsph, and with implicit in all two-dimensional flows"
        )
    if conformation_source is not None and not (
        planar and scene.polymer and scene.rheology and len(scene.rheology.laws(1.0)) == 1
    ):
        raise ConfigError(
            "conformation_source: must be left out here; it is for two-dimensional flow of a fluid whose polymer has "
            "one relaxation time, with scheme implicit"
        )
    if velocity is not None and not (planar and not scene.has_free_bodies and not scene.flows_through):
        raise ConfigError(
            "velocity: must be left out here; it is for two-dimensional flow with scheme implicit, without bodies that "
            "the flow carries and without open ends"
        )
    if velocity is not None and (initial_velocity or body_force):
        raise ConfigError("velocity: leave out initial_velocity and body_force, which have no effect beside it")
    if initial_velocity is None and body_force is None and velocity is None and conformation_source is None:
        return scene
    given: dict[str, Any] = {"fields": (), "initial": lambda _self, x, y: scene.initial(x, y)}
    if scene.axisymmetric:
        given["swirls"] = True
    if body_force is not None:
        force, drive = _on_places(body_force, scene.components), cast(Any, scene.body_force)

        def both(x: np.ndarray, y: np.ndarray, t: float) -> list[np.ndarray]:
            return [a + b for a, b in zip(force(x, y, t), drive(x, y, t), strict=True)]

        given["body_force"] = staticmethod(force if drive is None else both)
        if scene.frame_velocity:

            def moved(x: np.ndarray, y: np.ndarray, t: float) -> list[np.ndarray]:
                return force((x + scene.frame_velocity * (t - scene.start_time)) % scene.extent[0], y, t)

            frame = with_functions(scene.in_flow_frame(), scheme, body_force=moved)
            given["in_flow_frame"] = lambda _self: frame
    if conformation_source is not None:
        given["conformation_source"] = staticmethod(_on_places(conformation_source, 6 if scene.axisymmetric else 3))
    if velocity is not None:
        middle = [np.array([begin + 0.5 * size]) for begin, size in zip(scene.origin, scene.extent, strict=True)]
        has_gradient = not scene.axisymmetric and len(velocity(middle[0], middle[1], scene.start_time)) > 2
        everything = _on_places(velocity, 6 if has_gradient else scene.components)
        given["kinematics"] = staticmethod(lambda x, y, t: everything(x, y, t)[: scene.components])
        if has_gradient:
            given["kinematics_gradient"] = staticmethod(lambda x, y, t: everything(x, y, t)[2:])
    if own_start := velocity or initial_velocity:
        at_start = _on_places(lambda *place: own_start(*place)[: scene.components], scene.components)

        def initial(_self: Any, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
            return {**scene.initial(x, y), **dict(zip("uvw", at_start(x, y, scene.start_time), strict=False))}

        given |= {"initial": initial, "has_own_start": planar and velocity is None}
        given["initial_velocity"] = staticmethod(lambda x, y: np.stack(at_start(x, y, scene.start_time)))
        if free:
            x, y = scene.lattice()
            u, v = at_start(x, y, scene.start_time)
            given["peak_velocity"] = max(scene.peak_velocity, float(np.hypot(u, v).max()))
    kind: Any = new_class(type(scene).__name__, (type(scene),), exec_body=lambda members: members.update(given))
    changed = kind.__new__(kind)
    vars(changed).update({name: value for name, value in vars(scene).items() if name not in given})
    return changed


def _on_places(function: Field, count: int) -> Callable[[np.ndarray, np.ndarray, float], list[np.ndarray]]:
    """Return ``function`` with ``count`` components as arrays of finite numbers, of the shape of the places.

    Where three components are due it may return two: the one around the axis is then 0.
    """

    def on_places(x: np.ndarray, y: np.ndarray, t: float) -> list[np.ndarray]:
        values = [np.broadcast_to(np.asarray(each, dtype=float), x.shape) for each in function(x, y, t)]
        if count == 3 and len(values) == 2:
            values.append(np.zeros(x.shape))
        if len(values) != count or not np.isfinite(values).all():
            raise ConfigError(f"{function}: must return {count} components of finite numbers, at t = {t:g}")
        return values

    return on_places
