"""A run's folder as an object."""

from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph.errors import ConfigError
from tisph.folder import Folder
from tisph.observers._storage import readable
from tisph.results._history import History, read
from tisph.results._samples import Samples
from tisph.results._summary import Summary, typed
from tisph.results._trajectories import Trajectories

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from tisph.config import Config
    from tisph.results._movie import Movie


class Results:
    """What a run left in ``folder``; read when it is asked for. All numbers are in the units of the config."""

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
    def samples(self) -> Samples:
        """The particles at each sample time: ``samples[-1]["u"]`` is an array (particles,)."""
        return Samples(self._files.samples)

    @cached_property
    def history(self) -> History:
        """What the scene follows in time, a NumPy record array (times,); ``to_pandas()`` where pandas is there."""
        return read(self._files.history)

    @cached_property
    def bodies(self) -> Trajectories | None:
        """What the bodies in the fluid do over time: ``bodies["centre"]``; None where the flow carries none."""
        return Trajectories(self._files.bodies) if self._files.bodies.is_file() else None

    @cached_property
    def movie(self) -> "Movie | None":
        """The movie (``.path``; a notebook plays it), None where the run made none."""
        from tisph.results._movie import Movie

        return Movie(self._files.movie, self.summary.name) if self._files.movie.is_file() else None

    def exact(self, field: str, x: "ArrayLike", y: "ArrayLike", t: "ArrayLike") -> np.ndarray:
        """Return the reference for ``field`` (``u``, ``v``, ...) at places and times, which broadcast.

        ConfigError where the scene has none for this field.
        """
        scene = self._scene
        if field not in scene.fields:
            known = ", ".join(scene.fields) or "none"
            raise ConfigError(f"field {field!r}: scene {self.config.scene} has no reference for it; it has {known}")
        places = np.broadcast_arrays(*(np.asarray(each, dtype=float) for each in (x, y, t)))
        return np.asarray(scene.exact(field, *places))

    def profile_figure(self) -> "Figure":
        """Return profiles at the samples, with the exact curves and the errors, as a matplotlib figure."""
        from tisph.observers.samples import read_samples
        from tisph.report.plots import profile_figure

        snapshots = read_samples(self._files.samples) if self._files.samples.is_file() else []
        if not snapshots:
            raise ConfigError(f"{self.folder}: the run has no sample, so there is no profile")
        return profile_figure(self._scene, snapshots)

    def history_figure(self) -> "Figure":
        """Return what is followed in time, with the exact curves, as a matplotlib figure."""
        from tisph.observers.history import read_history, read_resolved
        from tisph.report.plots import history_figure

        times, values = read_history(self._files.history) if self._files.history.is_file() else ([], [])
        if not len(times):
            raise ConfigError(f"{self.folder}: the run has no history")
        resolved = read_resolved(self._files.history)
        return history_figure(self._scene, self.config.time_series, times, values, resolved)

    def _repr_html_(self) -> str:
        from tisph.results.page import fragment

        return fragment(self)

    @cached_property
    def _files(self) -> Folder:
        return Folder(self.folder)

    @cached_property
    def _scene(self) -> Any:
        from tisph import scenes

        return scenes.of(self.config)


def open_run(folder: "str | PathLike[str]") -> Results:
    """Return the ``Results`` of a run that is finished, or was interrupted, or diverged; starts nothing.

    ConfigError where ``folder`` is none of a run.
    """
    results = Results(folder)
    if not Folder(results.folder).config.is_file():
        raise ConfigError(f"{results.folder}: is no folder of results, it has no config.resolved.yaml")
    return results
