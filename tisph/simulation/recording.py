"""The folder of results: the observers that write its files, and the files that are written when the run ends.

``summary.json`` has the numbers of the run and their provenance. The drawing process draws the movie and the pictures,
whose files are written here.
"""

import hashlib
import json
import math
import platform
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from itertools import islice
from os import PathLike
from pathlib import Path
from typing import Any

from tisph import config, runtime, scenes
from tisph.config.schema import Config, colours
from tisph.config.sections import Video
from tisph.errors import ConfigError, DivergedError, TisphError
from tisph.folder import Folder, claimed, extended, hdf5_file, replaced
from tisph.measures.metrics import sample_metrics
from tisph.measures.steadiness import steady_since
from tisph.observers.history import History, Trajectories, read_history
from tisph.observers.protocol import Checkpoints, Observer, even_times
from tisph.observers.samples import Frames, Samples, write_snapshot
from tisph.report import drawing_process
from tisph.report.drawing_process import RemoteMovie, described, shared
from tisph.results import Results
from tisph.scenes._scene import Scene
from tisph.simulation import checkpoint
from tisph.simulation.process import Interrupts, log, logging_to
from tisph.snapshot import Snapshot
from tisph.version import __version__


class Recording:
    """Writes the results of a ``simulation`` into ``folder``; ``pictures`` and ``video`` ask for plots and movie.

    It adds its observers to the simulation, which calls ``finish`` or ``fail`` at the end of the run. ``interrupts``
    counts the signals that end the run; they are delayed while the present state of the run is not written.
    ``added``: the observers that it has added.
    """

    def __init__(
        self,
        simulation: Any,
        folder: Folder,
        *,
        pictures: bool,
        video: bool,
        interrupts: Interrupts | None = None,
    ):
        self.simulation, self.folder = simulation, folder
        self.drawn = pictures
        self.interrupts = interrupts or Interrupts(wait=True)
        self.about = simulation.about
        self.status = "failed"
        self.message: str | None = None
        self.summary: dict[str, Any] | None = None
        self.pictures: list[Picture] = []
        self.held = ExitStack()
        self.ended = False
        settings, scene = simulation.config, simulation.scene
        with simulation.costs.timed("import"):
            if not scene.parallel:
                import scipy.spatial  # noqa: F401 (numbers of samples need it)
        wanted = video and settings.output.video
        self.movie = movie(folder, settings, scene) if wanted else None
        with simulation.costs.timed("output"):
            self._open(simulation.time if simulation.restored else None)

    @classmethod
    def of(cls, simulation: Any, root: Path, *, overwrite: bool, video: bool) -> "Recording":
        """Return the recording of a run that is stepped from Python; the folder is locked until the run ends.

        TisphError where the results cannot be written, ConfigError where the folder must not be used.
        """
        folder, held = Folder(root), ExitStack()
        try:
            held.enter_context(claimed(folder.root, overwrite=overwrite, resume=simulation.restored))
            drawing_process.shared()
            held.enter_context(logging_to(folder.log, append=simulation.restored))
            recording = cls(simulation, folder, pictures=True, video=video)
        except BaseException:
            held.close()
            raise
        recording.held = held
        return recording

    def _open(self, resumed_at: float | None) -> None:
        settings, scene, folder = self.simulation.config, self.simulation.scene, self.folder
        with replaced(folder.config) as new:
            new.write_text(self.about.resolved, encoding="utf-8")
        end, output = settings.time.end, settings.output
        followed = scene.time_series(**settings.time_series)
        self.samples = Samples(folder.samples, scene, settings.time.samples, resumed_at, self.about)
        self.history = History(folder.history, scene, followed, end, resumed_at, self.about)
        self.observers: list[Observer] = [self.samples, self.history]
        if scene.has_free_bodies:
            self.observers.append(Trajectories(folder.bodies, scene, end, resumed_at, self.about))
        if output.vtk:
            from tisph.observers.vtk import Vtk  # imported only where it is wanted

            self.observers.append(Vtk(folder.vtk, self.samples, resumed_at, self.about))
        if self.movie:
            times = even_times(scene.start_time, end, output.video.frames)
            more = {field for name in colours(settings) for field in scene.movie_fields(name)}
            self.observers.append(Frames(folder.frames, self.movie, times, resumed_at, more))
        every = [Checkpoints(output.checkpoint_every, self.save)] if output.checkpoint_every else []
        self.added = [*self.observers, *every]
        self.simulation.observe(*self.added)

    def save(self) -> None:
        """Write the checkpoint, and all earlier output, which a resumed run needs."""
        try:
            for observer in self.observers:
                observer.flush()
        finally:
            checkpoint.save(self.folder.checkpoint, self.simulation.scheme, self.about.resolved)

    def fail(self, error: Exception) -> None:
        """Write the results once ``error`` has ended the run; raises no other error."""
        if isinstance(error, DivergedError):
            self._end("diverged", str(error))
        else:
            self._end("failed", f"{type(error).__name__}: {error}")

    def finish(self, status: str) -> None:
        """Write the results once the run is ``done`` or ``interrupted``; raises the first error of writing a file.

        TisphError for a file that the system refuses to write.
        """
        failures = self._end(status, None)
        if failures and isinstance(failures[0], OSError):
            raise TisphError(f"{self.folder.root}: the results cannot be written: {failures[0]}") from failures[0]
        if failures:
            raise failures[0]

    def _end(self, status: str, message: str | None) -> list[Exception]:
        """Write all files of the end, whatever fails in between; return the errors."""
        if self.ended:
            return []
        self.ended, self.status, self.message = True, status, message
        failures: list[Exception] = []
        try:
            with self.simulation.costs.timed("output"):
                for write in self._last_files():
                    try:
                        write()
                    except Exception as error:
                        log.error("%s", error)
                        failures.append(error)
            if self.summary and not failures:
                write_summary(self.folder.summary, {**self.summary, "cost": cost(self.simulation)})
            steps, time = self.simulation.steps, self.simulation.time
            log.info("%s after %d steps, t = %.6g%s", status, steps, time, f": {message}" if message else "")
        finally:
            self.held.close()
        return failures

    def _last_files(self) -> Iterator[Callable[[], None]]:
        """Yield the functions that write the last files, the most precious first; a second interrupt skips the rest."""
        if self.interrupts.wait or self.status != "interrupted":
            if self.status == "interrupted":
                yield self.save
            if self.drawn:
                yield self._begin_pictures  # drawn while other files are written
            yield self._summarise
        self.interrupts.wait = False
        if self.interrupts.count > 1:
            raise KeyboardInterrupt
        good = self.simulation.guard.last_good
        if self.status == "diverged" and good is not None:
            yield lambda: write_last_good(self.folder, self.simulation.scene, self.simulation.config, good)
        yield from (observer.close for observer in self.observers)
        yield from (picture.write for picture in self.pictures)

    def _begin_pictures(self) -> None:
        self.pictures = begin_pictures(self.folder, self.simulation.config, self.simulation.scene)

    def _summarise(self) -> None:
        self.summary = summarise(self)
        write_summary(self.folder.summary, self.summary)


def summarise(recording: Recording) -> dict[str, Any]:
    """Return the summary of a run that has ended in whatever way, from its ``Recording``."""
    simulation, history = recording.simulation, recording.history
    scene, config, scheme = simulation.scene, simulation.config, simulation.scheme
    snapshots = recording.samples.snapshots
    balance = scheme.momentum_balance()
    return {
        "name": config.name,
        "status": recording.status,
        **({"message": recording.message} if recording.message else {}),
        "samples": [sample_metrics(scene, snapshot, history.reading(snapshot)) for snapshot in snapshots],
        "numbers": {
            "reynolds": scene.reynolds,
            "reference_velocity": scene.reference_velocity,
            "spacing": scene.spacing,
            **({"smallest_spacing": scene.wanted_spacing.smallest} if scene.wanted_spacing.varies else {}),
            "particles_fluid": scene.particles,
            **scheme.numbers(),
            **_steady(scene, history),
            "dt_min": scheme.shortest if scheme.steps else None,
            "dt_max": scheme.longest if scheme.steps else None,
        },
        "momentum": {key: part if part is not None and math.isfinite(part) else None for key, part in balance.items()},
        "cost": cost(simulation),
        "provenance": provenance(config, recording.about.resolved, simulation.threads),
    }


def _steady(scene: Scene, history: History) -> dict[str, float | None]:
    """Return ``steady_since`` of the numbers that the scene follows; empty for scenes that never become steady."""
    if not history.time_series.judged_sizes:
        return {}
    return {"steady_since": steady_since(scene, history.followed(*read_history(history.path)))}


def cost(simulation: Any) -> dict[str, float | None]:
    """Return the cost of the run so far: steps, seconds of the clock and of processor time, speed and memory."""
    steps, spent = simulation.steps - simulation.first_step, simulation.costs.seconds
    loop = spent["loop"][0]
    return {
        "steps": simulation.steps,
        "wall_total_s": time.perf_counter() - simulation.costs.began,
        **{f"wall_{kind}_s": clock for kind, (clock, _) in spent.items()},
        **{f"processor_{kind}_s": spent[kind][1] for kind in ("loop", "output")},
        "particle_steps_per_s": steps * simulation.scene.particles / loop if loop > 0 else None,
        "peak_memory_mb": peak_memory_mb(),
    }


def write_last_good(folder: Folder, scene: Scene, config: Config, snapshot: Snapshot) -> None:
    """Write the last sound state of a diverged run, as data and as a picture."""
    with replaced(folder.last_good) as new, hdf5_file(new) as file:
        write_snapshot(file, snapshot)
    video = config.output.video or type(config.output).model_fields["video"].default
    frame = shared().request("still", *described(scene, video), config.heading, config.time.end, snapshot)
    Picture(folder.last_good_picture, frame.result).write()


def write_summary(path: Path, summary: dict[str, Any]) -> None:
    """Write ``summary`` as JSON, whole or not at all."""
    with replaced(path) as new:
        new.write_text(json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8")


def provenance(config: Config, resolved: str, threads: int) -> dict[str, Any]:
    """Return versions, machine and settings that the numbers depend on; ``resolved`` is the config as YAML."""
    packages = (runtime.PACKAGE, "numpy", "scipy", "h5py", "pydantic", "matplotlib")
    return {
        "versions": {
            "tisph": __version__,
            "python": platform.python_version(),
            **{name: _version(name) for name in packages},
        },
        "platform": platform.platform(),
        "processor": platform.machine(),
        "threads": threads,
        "precision": config.discretisation.precision,
        "seed": config.initial.seed,
        "config_hash": fingerprint(resolved),
        "commit": _commit(),
    }


def _version(package: str) -> str:
    """Return the version of a ``package``: ``metadata.version`` parses a whole page, which takes ten times as long."""
    found = re.search(r"^Version: *(.+)$", metadata.distribution(package).read_text("METADATA") or "", re.MULTILINE)
    return found[1].strip() if found else metadata.version(package)


def fingerprint(resolved: str) -> str:
    """Return a hash of the ``resolved`` config as YAML, which determines the outcome of a run."""
    return hashlib.sha256(resolved.encode()).hexdigest()[:16]


def _commit() -> str | None:
    """Return the commit of the checkout that contains the package; None for an installed package."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    try:
        run = subprocess.run(
            ["git", "-C", str(root), "rev-parse", "HEAD"],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return run.stdout.strip()


def peak_memory_mb() -> float | None:
    """Return the largest resident memory of this process so far; None where the system does not report it."""
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6, 1)


VIDEO = "output.video."
"""Start of the keys of the movie."""


@dataclass(frozen=True)
class Picture:
    """A picture that is being drawn for the file ``path``: ``image`` waits for it and returns it as PNG."""

    path: Path
    image: Callable[[], Any]

    def write(self) -> None:
        """Wait for the picture and write it; TisphError where it could not be drawn or cannot be written."""
        image = self.image()
        with replaced(self.path) as new:
            new.write_bytes(image)


def movie(folder: Folder, settings: Any, scene: Scene) -> RemoteMovie:
    """Return the movie of a run, to which frames can be added."""
    return RemoteMovie(shared(), folder.movie, scene, settings.output.video, settings.heading, settings.time.end)


def begin_pictures(folder: Folder, settings: Any, scene: Scene) -> list[Picture]:
    """Start to draw profiles.png and history.png from the stored samples and history, as far as there are any."""
    results, wanted = Results(folder.root), dict[str, tuple[Any, ...]]()
    paths = {"profiles": folder.profiles_picture, "history": folder.history_picture}
    snapshots = list(results.snapshots())
    if snapshots:
        wanted["profiles"] = (snapshots,)
    times, values, resolved = results.followed()
    if len(times):
        wanted["history"] = settings.time_series, times, values, resolved
    if not wanted:
        return []
    drawn = shared().request("plots", described(scene)[0], wanted)
    return [Picture(paths[name], partial(lambda name: drawn.result()[name], name)) for name in wanted]


def render(run_dir: str | PathLike[str], overrides: Sequence[str] = (), gif: bool = False) -> list[Path]:
    """Draw the pictures for which ``run_dir`` has files, and return their paths.

    ``overrides`` are texts ``output.video.KEY=VALUE``, for another movie of the same frames; with ``gif`` it is also
    written as GIF, and its last frame as JPEG. Raises ConfigError where ``run_dir`` is no results folder, its run still
    goes on, or its files cannot be read or lack a wanted field; TisphError where the pictures cannot be written.
    """
    folder = Folder(run_dir)
    if not any(path.exists() for path in (folder.samples, folder.history, folder.frames)):
        raise ConfigError(f"{folder.root}: has nothing to draw: neither samples.h5 nor history.csv nor frames.h5")
    _require_movie_keys(folder, overrides)
    with extended(folder.root):
        return _rendered(folder, overrides, gif)


def _rendered(folder: Folder, overrides: Sequence[str], gif: bool) -> list[Path]:
    """Draw the pictures of ``render``, and return their paths."""
    settings: Any = config.load(folder.config, overrides)
    scene = scenes.of(settings)
    if overrides:
        _require_fields(folder, scene, settings.output.video.color_by)
    pictures = begin_pictures(folder, settings, scene)
    for picture in pictures:
        picture.write()
    drawn = [picture.path for picture in pictures]
    if settings.output.video and folder.frames.exists():
        film = movie(folder, settings, scene)
        try:
            for snapshot in Results(folder.root).snapshots(frames=True):
                film.add(snapshot)
        finally:
            film.close()
        drawn.append(folder.movie)
    return [*drawn, *_small(folder)] if gif else drawn


def _small(folder: Folder) -> tuple[Path, Path]:
    """Write the movie as GIF and its last frame, and return their paths; ConfigError where there is no movie."""
    from tisph.report.encoder import poster, write_gif  # a run does not import imageio-ffmpeg and Pillow

    if not folder.movie.is_file():
        raise ConfigError(f"{folder.root}: there is no {folder.movie.name} to make a GIF of")
    write_gif(folder.movie, folder.movie_gif)
    image = poster(folder.movie)
    if image is None:
        raise ConfigError(f"{folder.movie}: is no complete movie")
    with replaced(folder.poster) as new:
        new.write_bytes(image)
    return folder.movie_gif, folder.poster


def _require_movie_keys(folder: Folder, overrides: Sequence[str]) -> None:
    """Raise ConfigError for an unknown key of the movie, another number of frames, or where there are no frames."""
    for text in overrides:
        key = text.partition("=")[0].strip()
        if not key.startswith(VIDEO) or key == f"{VIDEO}frames":
            known = ", ".join(name for name in Video.model_fields if name != "frames")
            raise ConfigError(f"--set {text}: a finished run is drawn again with other {VIDEO}KEY only; KEY: {known}")
    if overrides and not folder.frames.exists():
        raise ConfigError(f"{folder.root}: the run kept no frames ({folder.frames.name}), so there is no other movie")


def _require_fields(folder: Folder, scene: Scene, color_by: str) -> None:
    """Raise ConfigError where the stored frames lack a field that a movie coloured by ``color_by`` shows."""
    for snapshot in islice(Results(folder.root).snapshots(frames=True), 1):
        found = {name: snapshot.field(name) for name in scene.movie_fields(color_by)}
        lacking = [name for name, values in found.items() if values is None or not len(values)]
        if lacking:
            raise ConfigError(
                f"{VIDEO}color_by = {color_by}: {folder.frames} has no {', '.join(lacking)}; "
                f"run again with --set {VIDEO}color_by={color_by}"
            )
