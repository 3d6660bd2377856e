"""Predictions of measurements by a config, for ``tisph fit``: from the fluid's law, an exact solution, or runs.

Material functions over a rate or a frequency need the law of the fluid alone: steady uniform shear, or small
oscillations, both without inertia. The flow of the config, with its inertia, predicts values over time and velocities:
by its exact solution, if that is known at all times and places, else by a run for each set of values. Runs are kept.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tisph import scenes
from tisph.assessment.measurements import RELATIVE, Measurements
from tisph.config import load
from tisph.config.loader import override_texts
from tisph.config.schema import Config
from tisph.errors import ConfigError, TisphError, UnsolvedError
from tisph.measures.fits import interpolated, with_walls
from tisph.results import open_run
from tisph.rheometry.rheometers import spectrum, uniform_shear
from tisph.scenes._channel import SIDES, Channel
from tisph.scenes._scene import Scene
from tisph.scenes.annulus import Annulus
from tisph.snapshot import Snapshot
from tisph.studies import error_estimate
from tisph.studies.processes import Result
from tisph.studies.store import Store

Values = Mapping[str, float]
Predicted = dict[str, np.ndarray]

LADDER = 64
"""Rates from which steady states are sought, from a thousandth of the least measured rate to the largest."""


def history_columns(config: Config, scene: Scene) -> list[str]:
    """Return the names of the columns of the history that a flow over time may be measured by."""
    found = scene.time_series(**config.time_series).columns
    walls = [f"{name}_{side}" for name in ("wall_shear", "wall_velocity") for side in SIDES]
    return [*found, *(walls if isinstance(scene, Channel) else [])]


def history_column(config: Config, scene: Scene, quantity: str) -> tuple[str, float]:
    """Return the column of the history, and the factor, that a rheometer shows as ``quantity``.

    Stress and torque are those that move the one moving wall. ConfigError where the flow has no such quantity.
    """
    known = history_columns(config, scene)
    if quantity in known:
        return quantity, 1.0
    if isinstance(scene, Channel) and scene.driven_side is not None and quantity == "speed":
        return f"wall_velocity_{SIDES[scene.driven_side]}", 1.0
    if isinstance(scene, Channel) and scene.driven_side is None and quantity == "stress":
        moving = [side for side, wall in zip(SIDES, scene.pair, strict=True) if wall.largest_speed]
        if len(moving) == 1:
            return f"wall_shear_{moving[0]}", 1.0 if moving == ["top"] else -1.0
    turning = [name for name in ("inner", "outer") if getattr(getattr(scene, name, None), "largest_speed", 0.0)]
    if isinstance(scene, Annulus) and len(turning) == 1 and quantity in ("stress", "torque"):
        area = 2 * math.pi * getattr(scene, f"{turning[0]}_radius") ** 2
        return f"torque_{turning[0]}", -1.0 / area if quantity == "stress" else -1.0
    similar = {"torque": ("torque_inner", "torque_outer"), "force": ("force_outer",), "speed": ("velocity",)}
    for name in similar.get(quantity, ()):
        if name in known:
            return name, -1.0 if quantity == "torque" else 1.0
    raise ConfigError(f"{quantity}: the flow of {config.name} has no such reading; it has {', '.join(known) or 'none'}")


class Predictor:
    """Predictions of ``measurements`` by the config in ``path`` with ``overrides`` and values of further keys.

    Runs are kept in ``folder``, ``processes`` at a time; their spacing is ``factor`` times that of the config.
    """

    def __init__(
        self, path: str, overrides: Sequence[str], measurements: Measurements, folder: Path, processes: int
    ) -> None:
        self.path, self.overrides, self.measurements = path, list(overrides), measurements
        self.folder, self.processes, self.factor = folder, processes, 1.0
        self.config = load(path, overrides)
        self.known: dict[tuple[float, tuple[tuple[str, float], ...]], Predicted | None] = {}
        scene = scenes.of(self.config)
        exact = self.config.has_exact_velocity and bool({"u", "v", "w"} & set(scene.fields))
        self.exact = exact or measurements.kind in RELATIVE
        if measurements.kind in ("time", "speed"):
            for name in measurements.measured:
                history_column(self.config, scene, name)

    @property
    def error(self) -> float:
        """Error of a prediction, over its largest value, by steps in time and round-off."""
        return 1e-6 if self.exact else 1e-4

    def config_at(self, values: Values) -> Config:
        """Return the config with ``values`` by key; shares of polymer modes that are not among them take the rest."""
        return load(self.path, [*self.overrides, *override_texts({**values, **self._rest(values)})])

    def _rest(self, values: Values) -> dict[str, float]:
        """Return the share of the solvent, or of the last mode, that shares in ``values`` leave of the viscosity."""
        modes = getattr(self.config.fluid.rheology, "modes", None)
        if modes is None:
            return {}
        prefix = "fluid.rheology."
        own = {f"{prefix}modes.{k}.fraction": mode.fraction for k, mode in reversed(list(enumerate(modes)))}
        own = {f"{prefix}solvent_fraction": self.config.fluid.rheology.solvent_fraction, **own}
        free = [key for key in own if key not in values]
        if len(free) == len(own) or not free:
            return {}
        return {free[0]: 1.0 - sum(values.get(key, share) for key, share in own.items() if key != free[0])}

    def __call__(self, points: Sequence[Values]) -> list[Predicted | None]:
        """Return the prediction at each of ``points``, None where config or solution do not exist."""
        keys = [(self.factor, tuple(values.items())) for values in points]
        missing = {key: values for key, values in zip(keys, points, strict=True) if key not in self.known}
        configs: dict[Any, list[Config]] = {}
        for key, values in missing.items():
            try:
                configs[key] = self._flows(values)
            except ConfigError:
                self.known[key] = None
        results = {} if self.exact else self._run([config for flows in configs.values() for config in flows])
        for key, flows in configs.items():
            try:
                parts = [self._predicted(config, results.get(_name(config))) for config in flows]
                self.known[key] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
            except (ConfigError, UnsolvedError):
                self.known[key] = None
        return [self.known[key] for key in keys]

    def _flows(self, values: Values) -> list[Config]:
        """Return the configs whose flows predict the measurements: one, or one for each measured angular velocity."""
        data = self.measurements
        if data.kind != "speed":
            return [self._prepared(self.config_at(values))]
        scene = scenes.of(self.config)
        name = history_column(self.config, scene, "torque")[0].removeprefix("torque_")
        speeds = data.at["angular_velocity"]
        return [self._prepared(self.config_at({**values, f"walls.{name}.angular_velocity": w})) for w in speeds]

    def _prepared(self, config: Config) -> Config:
        """Return the config of a run: without movie, up to the last measured time, with samples at all of them."""
        if self.exact:
            return config
        data = error_estimate.respaced(config, self.factor) if self.factor != 1.0 else config.resolved()
        data.pop("name", None)
        data["output"] = {**data["output"], "video": None}
        data["runtime"] = {**data["runtime"], "threads": 1}
        if self.measurements.kind == "velocity":
            times = np.unique(self.measurements.at["t"]).tolist()
            data["time"] = {**data["time"], "end": times[-1], "samples": times}
        elif self.measurements.kind == "time":
            end = float(self.measurements.at["time"].max())
            data["time"] = {**data["time"], "end": end, "samples": [end]}
        return error_estimate.validated(config, data)

    def _run(self, configs: Sequence[Config]) -> dict[str, Result]:
        """Return the results of runs by name, kept or new; TisphError where one does not end."""
        self.folder.mkdir(parents=True, exist_ok=True)
        wanted = {_name(config): {k: v for k, v in config.resolved().items() if k != "name"} for config in configs}
        found = {}
        for name, result, message in Store(self.folder).outcomes(wanted, self.processes):
            if message:
                raise TisphError(f"the run {self.folder / name} did not finish: {message}")
            found[name] = result
        return found

    def _predicted(self, config: Config, result: Result | None) -> Predicted:
        data, scene = self.measurements, scenes.of(config)
        if data.kind == "rate":
            return _steady_shear(config, scene, data.at["shear_rate"])
        if data.kind == "frequency":
            omega = data.at["angular_frequency"]
            moduli = 1j * omega * spectrum(config.fluid.rheology, scene).complex_viscosity(1j * omega)
            return {"storage_modulus": moduli.real, "loss_modulus": moduli.imag}
        if data.kind == "velocity":
            return _velocities(scene, data, result)
        times = data.at["time"] if data.kind == "time" else np.array([config.time.end])
        return {name: _over_time(config, scene, name, times, result) for name in data.measured}


def _name(config: Config) -> str:
    return hashlib.sha256(json.dumps(config.resolved(), sort_keys=True).encode()).hexdigest()[:16]


def _steady_shear(config: Config, scene: Scene, rates: np.ndarray) -> Predicted:
    """Return viscosity, stress and N1 in steady uniform shear."""
    law = uniform_shear(config.fluid.rheology, scene)
    ladder = np.union1d(np.geomspace(1e-3 * rates.min(), rates.max(), LADDER), rates)
    stress, normal = (values[np.searchsorted(ladder, rates)] for values in law.steady_stresses(ladder))
    return {"stress": stress, "viscosity": stress / rates, "n1": normal}


def _velocities(scene: Scene, data: Measurements, result: Result | None) -> Predicted:
    """Return the velocities at times and places of the data, exact or from the samples of a run."""
    t, *places = data.at.values()
    low, high = scene.origin, np.add(scene.origin, scene.extent)
    x, y = (
        place if periodic else np.clip(place, start, end)
        for place, start, end, periodic in zip(places, low, high, scene.periodic, strict=True)
    )
    if result is None:
        return {name: np.asarray(scene.exact(name, x, y, t)) for name in data.measured}
    found = {name: np.full(len(t), np.nan) for name in data.measured}
    for snapshot in open_run(result.folder).snapshots():
        here = np.isclose(t, snapshot.t, rtol=1e-9)
        points = np.stack([x[here], y[here]], axis=1)
        for name, values in _fields(scene, snapshot, points).items():
            if name in found:
                found[name][here] = values
    return found


def _fields(scene: Scene, snapshot: Snapshot, points: np.ndarray) -> Predicted:
    """Return u and v at ``points``, between the particles and the walls, and w between the particles."""
    found = dict(zip("uv", interpolated(scene, *with_walls(scene, snapshot), points).T, strict=True))
    if snapshot.w is not None:
        particles = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
        found["w"] = interpolated(scene, particles, np.asarray(snapshot.w, dtype=float)[:, None], points)[:, 0]
    return found


def _over_time(config: Config, scene: Scene, name: str, times: np.ndarray, result: Result | None) -> np.ndarray:
    """Return a reading (times,) of the flow, exact or from the history of a run."""
    column, factor = history_column(config, scene, name)
    if result is not None:
        history = open_run(result.folder).history
        return factor * np.interp(times, history["t"], history[column])
    if isinstance(scene, Channel) and column.startswith("wall_"):
        side = column.endswith("top")
        shear = column.startswith("wall_shear")
        return factor * (
            scene.exact_wall_shear(times)[side] if shear else scene.exact_velocity(scene.gap * side, times)
        )
    series = scene.time_series(**config.time_series)
    return factor * np.asarray(series.exact(times))[:, series.columns.index(column)]
