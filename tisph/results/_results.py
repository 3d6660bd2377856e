"""The one reader of a run's folder: samples, history, bodies, movie and summary, each read when it is first used.

The keys of ``summary.json`` mean the same as in ``docs/reference/files.md``.
"""

import json
from collections.abc import Iterable, Iterator, KeysView, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import h5py
import numpy as np

from tisph.config.fields import nearest
from tisph.errors import ConfigError
from tisph.folder import Folder, readable
from tisph.observers.history import read_history, read_resolved, read_rows
from tisph.observers.samples import FIELDS, FRAME_FIELDS, read_snapshots
from tisph.snapshot import Snapshot

Value = float | int | bool | str | None
"""None where there is no such number, such as an error without a reference."""

T = TypeVar("T")


def unknown(name: object, names: Iterable[str]) -> KeyError:
    """Return the error for a ``name`` that is none of the ``names``."""
    names = list(names)
    return KeyError(f"{name!r}; there are {', '.join(names)}{nearest(name, names)}")


class ByName:
    """Base of mappings whose values are attributes, too: ``sample["NAME"]`` is ``sample.NAME``."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):  # of Python itself, such as copy and pickle
            raise AttributeError(name)
        try:
            return self[name]  # type: ignore[index]
        except KeyError as error:
            raise AttributeError(f"{type(self).__name__} has no {error.args[0]}") from None


@dataclass(frozen=True)
class SampleErrors(ByName):
    """One sample at time ``t``; ``sample["NAME"]`` or ``sample.NAME`` is any of its numbers, also the scene's measures.

    ``l2`` is relative, ``rms`` and ``linf`` are over the reference velocity, ``t_star`` is ``t`` over the time scale.
    ``measures`` has all numbers by name, in the units of the config, as has ``dict(sample)``.
    """

    t: float
    t_star: float
    step: int
    resolved: bool
    reason: str | None
    l2: float | None
    rms: float | None
    linf: float | None
    measures: Mapping[str, Value] = field(repr=False)

    def keys(self) -> KeysView[str]:
        """Return the names of all numbers."""
        return self.measures.keys()

    def __getitem__(self, name: str) -> Value:
        if name not in self.measures:
            raise unknown(name, self.measures)
        return self.measures[name]


@dataclass(frozen=True)
class Cost:
    """Steps, seconds of the clock (``wall_``) and of processor time, and the largest memory [MB] of a run."""

    steps: int | None
    wall_total_s: float | None
    wall_import_s: float | None
    wall_compile_s: float | None
    wall_loop_s: float | None
    wall_output_s: float | None
    processor_loop_s: float | None
    processor_output_s: float | None
    particle_steps_per_s: float | None
    peak_memory_mb: float | None


@dataclass(frozen=True)
class Provenance:
    """Conditions of the numbers: versions by package, machine, threads, precision, seed, config, commit."""

    versions: Mapping[str, str]
    platform: str | None
    processor: str | None
    threads: int | None
    precision: str | None
    seed: int | None
    config_hash: str | None
    commit: str | None


@dataclass(frozen=True)
class Summary:
    """Summary of a run; a run that was killed, or still runs, has the status ``failed`` and no samples here.

    ``message`` is the error, ``numbers`` are numbers of the whole run by name, ``momentum`` is the balance along
    x [mass velocity per length out of the plane], ``error_estimate`` is there after ``--estimate-error``.
    """

    name: str
    status: Literal["done", "diverged", "interrupted", "failed"]
    message: str | None
    samples: tuple[SampleErrors, ...]
    numbers: Mapping[str, Value]
    momentum: Mapping[str, float | None]
    cost: Cost
    provenance: Provenance
    error_estimate: Mapping[str, Any] | None


def typed(data: Mapping[str, Any], name: str) -> Summary:
    """Return the contents of a ``summary.json``, of the run ``name`` where it does not say so.

    ValueError where it is none.
    """
    if not isinstance(data, dict) or "status" not in data or any("t" not in each for each in data.get("samples", [{}])):
        raise ValueError("it is no summary of a run")
    return Summary(
        name=data.get("name", name),
        status=data["status"],
        message=data.get("message"),
        samples=tuple(_known(SampleErrors, {**sample, "measures": sample}) for sample in data["samples"]),
        numbers=data.get("numbers", {}),
        momentum=data.get("momentum", {}),
        cost=_known(Cost, data.get("cost", {})),
        provenance=_known(Provenance, {"versions": {}, **data.get("provenance", {})}),
        error_estimate=data.get("error_estimate"),
    )


def _known(kind: type[T], data: Mapping[str, Any]) -> T:
    return kind(**{each.name: data.get(each.name) for each in fields(kind)})  # type: ignore[arg-type]


if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from tisph.config import Config
    from tisph.rheometry.viscometers import Reading
    from tisph.scenes._scene import Scene


class Arrays(ByName, Mapping[str, np.ndarray]):
    """The arrays in a ``group`` of an HDF5 file by name, each read when it is used."""

    def __init__(self, path: Path, group: str = "/"):
        self._path, self._group = path, group

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.units:
            raise unknown(name, self.units)
        with readable(self._path), h5py.File(self._path, "r") as file:
            return np.asarray(file[self._group][name])

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of each array by its name."""
        found: dict[str, str] = {}

        def take(name: str, item: object) -> None:
            if isinstance(item, h5py.Dataset):
                found[name] = str(item.attrs.get("units", ""))

        with readable(self._path), h5py.File(self._path, "r") as file:
            file[self._group].visititems(take)
        return found


class Sample(Arrays):
    """The fluid particles at time ``t``, after ``step`` steps: arrays of shape (particles,) by name.

    ``x``, ``y``, ``u``, ``v``, ``density``, ``pressure``, with polymer ``stress_xx``, ``stress_xy``, ``stress_yy``, and
    the reference there, ``u_exact`` and so on; of bodies ``bodies/centre`` and so on, of shape (bodies, ...).
    """

    def __init__(self, path: Path, group: str, t: float, step: int):
        super().__init__(path, group)
        self.t, self.step = t, step

    def __repr__(self) -> str:
        return f"<Sample t={self.t:g}: {', '.join(self)}>"

    def columns(self) -> dict[str, np.ndarray]:
        """Return every array of the particles by its name, positions first."""
        names = [name for name in self if "/" not in name]
        return {name: self[name] for name in sorted(names, key=lambda name: (name not in ("x", "y"), name))}


class Samples(list[Sample]):
    """The samples of a run in the order of time."""

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame`` with a row a particle and sample, as in the exported CSV: t, particle, x, ...

        ImportError where there is no pandas.
        """
        import pandas  # not needed otherwise

        frames = [pandas.DataFrame({"t": each.t, "particle": range(len(each["x"])), **each.columns()}) for each in self]
        return pandas.concat(frames, ignore_index=True) if frames else pandas.DataFrame()


class History(np.recarray):
    """A row a time: ``history.t``, and by their names in the file ``history["u(y=0.5)"]`` and so on.

    Numbers are in the units of the config; a missing number is NaN.
    """

    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, str) and which not in (names := self.dtype.names or ()):
            raise unknown(which, names)
        return super().__getitem__(which)

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame``, a column a name; ImportError where there is no pandas."""
        import pandas  # not needed otherwise

        return pandas.DataFrame({name: self[name] for name in self.dtype.names or ()})


@dataclass(frozen=True)
class Movie:
    """The movie in the file ``path``; ``os.fspath`` takes it, too."""

    path: Path
    title: str

    def __fspath__(self) -> str:
        return str(self.path)

    def _repr_html_(self) -> str:
        from tisph.results.page import movie_element

        return movie_element(self.path, self.title)


class Trajectories(Arrays):
    """Bodies in the fluid at evenly spaced times: arrays by name, each read when it is used.

    ``t`` (times,); ``centre`` (times, bodies, 2), not wrapped by periods; ``angle`` [radians], ``angular_velocity``
    (times, bodies), counterclockwise; ``velocity``, ``force`` and ``contact_force`` (times, bodies, 2); ``torque``,
    ``stresslet`` (times, bodies). Loads are per length across the plane, NaN at the start. All are in the units of the
    config.
    """

    def __repr__(self) -> str:
        return f"<Trajectories of {len(self.names)} bodies: {', '.join(self)}>"

    @cached_property
    def _attributes(self) -> dict[str, Any]:
        with readable(self._path), h5py.File(self._path, "r") as file:
            return dict(file.attrs)

    @property
    def names(self) -> list[str]:
        """Number of each body in the config, as in columns of the history."""
        return list(map(str, self._attributes["names"]))

    @property
    def shapes(self) -> list[str]:
        """Shape of each body, such as ``circle``."""
        return list(map(str, self._attributes["shapes"]))

    @property
    def free(self) -> np.ndarray:
        """Whether the flow carries each of the bodies, bool (bodies,)."""
        return np.asarray(self._attributes["free"], dtype=bool)


class Results:
    """The results of a run in ``folder``, read when they are used. All numbers are in the units of the config."""

    def __init__(self, folder: "str | PathLike[str]"):
        self.folder = Path(folder)

    def __repr__(self) -> str:
        return f"<Results of {self.summary.name} in {self.folder}: {self.summary.status}>"

    @cached_property
    def config(self) -> "Config":
        """The config with every default filled in."""
        from tisph import config

        return config.load(self._files.config)

    @cached_property
    def summary(self) -> Summary:
        """Status, errors at each sample, numbers of the run, balance of momentum, cost, provenance."""
        with readable(self._files.summary):
            return typed(self._files.read_summary(), self.folder.name)

    @cached_property
    def accuracy(self) -> Mapping[str, Mapping[str, Any]]:
        """Error bars of a run with ``until``: number -> value, bar, parts, goal, reached, reason, runs; else empty."""
        path = self._files.accuracy
        if not path.is_file():
            return {}
        with readable(path):
            return json.loads(path.read_text(encoding="utf-8"))

    @cached_property
    def samples(self) -> Samples:
        """The particles at each sample time, in the order of time: ``samples[-1]["u"]`` is an array (particles,)."""
        path = self._files.samples
        if not path.is_file():
            return Samples()
        with readable(path), h5py.File(path, "r") as file:
            groups = sorted(file.values(), key=lambda group: group.attrs["t"])
            found = [(group.name, float(group.attrs["t"]), int(group.attrs["step"])) for group in groups]
        return Samples(Sample(path, *each) for each in found)

    @cached_property
    def history(self) -> History:
        """Quantities followed in time, a NumPy record array (times,); ``to_pandas()`` where pandas is installed.

        No rows where there is no such file, or a run was killed before its first one.
        """
        path = self._files.history
        with readable(path):
            names, rows = read_rows(path) if path.is_file() else (["t"], [])
            return np.array(rows, dtype=[(name, float) for name in names]).view(History)

    @cached_property
    def bodies(self) -> Trajectories | None:
        """The bodies in the fluid over time: ``bodies["centre"]``; None where the flow carries none."""
        return Trajectories(self._files.bodies) if self._files.bodies.is_file() else None

    @cached_property
    def movie(self) -> "Movie | None":
        """The movie (``.path``; a notebook plays it), None where the run made none."""

        return Movie(self._files.movie, self.summary.name) if self._files.movie.is_file() else None

    def snapshots(self, frames: bool = False) -> Iterator[Snapshot]:
        """Yield the samples with their references, or the stored ``frames``; none where there is no file."""
        path = self._files.frames if frames else self._files.samples
        if path.is_file():
            yield from read_snapshots(path, FRAME_FIELDS if frames else FIELDS)

    def followed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return times, followed numbers (times, numbers), and whether resolved (times,) if the file says so."""
        if not self._files.history.is_file():
            return np.empty(0), np.empty((0, 0)), None
        return *read_history(self._files.history), read_resolved(self._files.history)

    def exact(self, field: str, x: "ArrayLike", y: "ArrayLike", t: "ArrayLike") -> np.ndarray:
        """Return the reference for ``field`` (``u``, ...) at places and times, which broadcast; or ConfigError."""
        scene = self._scene
        if field not in scene.fields:
            known = ", ".join(scene.fields) or "none"
            raise ConfigError(f"field {field!r}: scene {self.config.scene} has no reference for it; it has {known}")
        places = np.broadcast_arrays(*(np.asarray(each, dtype=float) for each in (x, y, t)))
        return np.asarray(scene.exact(field, *places))

    def rheometry(self) -> "Reading":
        """Return the run read as a rheometer, its ``numbers`` by name; ConfigError where it is no flow of one."""
        from tisph.rheometry.rheometers import read
        from tisph.rheometry.viscometers import VISCOMETERS

        config, history, scene = self.config, self.history, self._scene
        readable = config.scene in ("annulus", *VISCOMETERS)
        if config.scene == "channel":
            readable = config.parallel or scene.has_free_bodies
        if not readable:
            raise ConfigError(
                f"{self.folder}: rheometry reads runs in a channel (without bodies, or with free bodies), between "
                "cylinders, in a pipe, and of a falling ball; this run is none of them"
            )
        last = self.summary.samples[-1] if self.summary.samples else None
        table = {name: history[name] for name in history.dtype.names or ()}
        try:
            return read(config, scene, table, self.summary.numbers.get("contacts"), last)
        except ConfigError as error:
            raise ConfigError(f"{self.folder}: {error}") from None

    def profile_figure(self) -> "Figure":
        """Return profiles at the samples, with the exact curves and the errors, as a matplotlib figure."""
        from tisph.report.plots import profile_figure

        snapshots = list(self.snapshots())
        if not snapshots:
            raise ConfigError(f"{self.folder}: the run has no sample, so there is no profile")
        return profile_figure(self._scene, snapshots)

    def history_figure(self) -> "Figure":
        """Return the quantities followed in time, with the exact curves, as a matplotlib figure."""
        from tisph.report.plots import history_figure

        times, values, resolved = self.followed()
        if not len(times):
            raise ConfigError(f"{self.folder}: the run has no history")
        return history_figure(self._scene, self.config.time_series, times, values, resolved)

    def _repr_html_(self) -> str:
        from tisph.results.page import fragment

        return fragment(self)

    @cached_property
    def _files(self) -> Folder:
        return Folder(self.folder)

    @cached_property
    def _scene(self) -> "Scene":
        from tisph import scenes

        return scenes.of(self.config)


def open_run(folder: "str | PathLike[str]") -> Results:
    """Return the ``Results`` of a run that ended, however it did; ConfigError where ``folder`` has no run."""
    results = Results(folder)
    if not Folder(results.folder).config.is_file():
        raise ConfigError(f"{results.folder}: is no folder of results, it has no config.resolved.yaml")
    return results
