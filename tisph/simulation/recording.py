"""The folder of results: the observers that leave its files, and what is written when the run ends.

``summary.json`` has the numbers of the run and what else they come from. The drawing process makes the movie and the
pictures, whose files are written here.
"""

import hashlib
import json
import math
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from importlib import metadata
from itertools import islice
from pathlib import Path

import numpy as np

from tisph import config, runtime, scenes
from tisph.config.checks import colours
from tisph.config.schema import Video
from tisph.errors import ConfigError, DivergedError, TisphError
from tisph.folder import Folder, claimed
from tisph.measures.metrics import sample_metrics
from tisph.measures.resolution import steady_since
from tisph.observers._storage import hdf5_file, replaced, write_snapshot
from tisph.observers.history import History, Trajectories, read_history, read_resolved
from tisph.observers.samples import Frames, Samples, read_frames, read_samples
from tisph.observers.schedule import Checkpoints, even_times
from tisph.report import drawing_process
from tisph.report.drawing_process import RemoteMovie, described, shared
from tisph.simulation import checkpoint
from tisph.simulation.process import Interrupts, log, logging_to
from tisph.version import __version__


class Recording:
    """What a ``simulation`` leaves in ``folder``: with the movie and the plots, if they are wanted.

    It gives its observers to the simulation, which tells it how the run ended. ``interrupts`` counts those of a run
    that is to end with all its results; they wait as long as there is a state to go on from that is not written.
    """

    def __init__(self, simulation, folder, *, pictures, video, interrupts=None):
        self.simulation, self.folder = simulation, folder
        self.drawn = pictures
        self.interrupts = interrupts or Interrupts(wait=True)
        self.about = simulation.about
        self.status, self.message, self.summary = "failed", None, None
        self.pictures = []
        self.held = ExitStack()
        self.ended = False
        settings, scene = simulation.config, simulation.scene
        wanted = video and settings.output.video
        self.movie = movie(folder, settings, scene) if wanted else None
        with simulation.costs.timed("output"):
            self._open(simulation.time if simulation.restored else None)

    @classmethod
    def of(cls, simulation, root, *, overwrite, video):
        """Return the record of a run that is stepped by hand; the folder is kept from others until the run ends.

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

    def _open(self, resumed_at):
        settings, scene, folder = self.simulation.config, self.simulation.scene, self.folder
        with replaced(folder.config) as new:
            new.write_text(self.about.resolved, encoding="utf-8")
        end, output = settings.time.end, settings.output
        followed = scene.time_series(**settings.time_series)
        self.samples = Samples(folder.samples, scene, settings.time.samples, resumed_at, self.about)
        self.history = History(folder.history, scene, followed, end, resumed_at, self.about)
        self.observers = [self.samples, self.history]
        if scene.has_free_bodies:
            self.observers.append(Trajectories(folder.bodies, scene, end, resumed_at, self.about))
        if output.vtk:
            from tisph.observers.vtk import Vtk  # who does not want it does not pay for it

            self.observers.append(Vtk(folder.vtk, self.samples, resumed_at, self.about))
        if self.movie:
            times = even_times(scene.start_time, end, output.video.frames)
            more = {field for name in colours(settings) for field in scene.movie_fields(name)}
            self.observers.append(Frames(folder.frames, self.movie, times, resumed_at, more))
        self.simulation.observe(*self.observers)
        if output.checkpoint_every:
            self.simulation.observe(Checkpoints(output.checkpoint_every, self.save))

    def save(self):
        """Write the checkpoint, and all that came before it, which a run that goes on from there needs."""
        try:
            for observer in self.observers:
                observer.flush()
        finally:
            checkpoint.save(self.folder.checkpoint, self.simulation.scheme, self.about.resolved)

    def fail(self, error):
        """Write what is known once ``error`` has ended the run; no other error comes in its place."""
        if isinstance(error, DivergedError):
            self._end("diverged", str(error))
        else:
            self._end("failed", f"{type(error).__name__}: {error}")

    def finish(self, status):
        """Write what is known once the run is ``done`` or ``interrupted``; raises what kept a file from being written.

        TisphError for one that the system does not let be written.
        """
        failures = self._end(status, None)
        if failures and isinstance(failures[0], OSError):
            raise TisphError(f"{self.folder.root}: the results cannot be written: {failures[0]}") from failures[0]
        if failures:
            raise failures[0]

    def _end(self, status, message):
        """Write what is known at the end; return the errors, none of which keeps the rest from being written."""
        if self.ended:
            return []
        self.ended, self.status, self.message = True, status, message
        failures = []
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

    def _last_files(self):
        """Yield what writes the last files, the most precious first; a second interrupt leaves out the rest of them."""
        if self.interrupts.wait or self.status != "interrupted":
            if self.status == "interrupted":
                yield self.save
            if self.drawn:
                yield self._begin_pictures  # drawn beside the rest
            yield self._summarise
        self.interrupts.wait = False
        if self.interrupts.count > 1:
            raise KeyboardInterrupt
        good = self.simulation.guard.last_good
        if self.status == "diverged" and good is not None:
            yield lambda: write_last_good(self.folder, self.simulation.scene, self.simulation.config, good)
        yield from (observer.close for observer in self.observers)
        yield from (picture.write for picture in self.pictures)

    def _begin_pictures(self):
        self.pictures = begin_pictures(self.folder, self.simulation.config, self.simulation.scene)

    def _summarise(self):
        self.summary = summarise(self)
        write_summary(self.folder.summary, self.summary)


def summarise(recording):
    """Return the summary of a run that has ended in whatever way, from its ``Recording``."""
    simulation, history = recording.simulation, recording.history
    scene, config = simulation.scene, simulation.config
    snapshots = recording.samples.snapshots
    return {
        "name": config.name,
        "status": recording.status,
        **({"message": recording.message} if recording.message else {}),
        "samples": [sample_metrics(scene, snapshot, history.reading(snapshot)) for snapshot in snapshots],
        "numbers": _numbers(scene, simulation.scheme, history),
        "momentum": _momentum(simulation.scheme),
        "cost": cost(simulation),
        "provenance": provenance(config, recording.about.resolved, simulation.threads),
    }


def _numbers(scene, scheme, history):
    return {
        "reynolds": scene.reynolds,
        "reference_velocity": scene.reference_velocity,
        "spacing": scene.spacing,
        "particles_fluid": scene.particles,
        **scheme.numbers(),
        **_steady(history),
        "dt_min": scheme.shortest if scheme.steps else None,
        "dt_max": scheme.longest if scheme.steps else None,
    }


def _steady(history):
    """Since when the numbers that the scene follows have been the last ones, of scenes that may become steady."""
    series = history.time_series
    if not series.sizes:
        return {}
    drifting = set(series.drifting)
    sizes = [math.inf if name in drifting else size for name, size in zip(series.columns, series.sizes, strict=True)]
    return {"steady_since": steady_since(*read_history(history.path), sizes)}


def _momentum(scheme):
    """The balance of momentum along x [mass * velocity per length out of the plane]; None for what is no number."""
    balance = scheme.momentum_balance()
    return {key: value if value is not None and math.isfinite(value) else None for key, value in balance.items()}


def cost(simulation):
    """Return what the run has cost by now; times elapsed, in seconds of the clock."""
    steps, loop = simulation.steps - simulation.first_step, simulation.costs.seconds["loop"]
    return {
        "steps": simulation.steps,
        "wall_total_s": time.perf_counter() - simulation.costs.began,
        **{f"wall_{kind}_s": seconds for kind, seconds in simulation.costs.seconds.items()},
        "particle_steps_per_s": steps * simulation.scene.particles / loop if loop > 0 else None,
        "peak_memory_mb": peak_memory_mb(),
    }


def write_last_good(folder, channel, config, snapshot):
    """Keep the last sound state of a run that went wrong, as data and as a picture."""
    with replaced(folder.last_good) as new, hdf5_file(new) as file:
        write_snapshot(file, snapshot)
    begin_still(folder.last_good_picture, config, channel, snapshot).write()


def write_summary(path, summary):
    """Write ``summary`` as JSON, whole or not at all."""
    with replaced(path) as new:
        new.write_text(json.dumps(summary, indent=2, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8")


def provenance(config, resolved, threads):
    """Return what else a number in the summary depends on; ``resolved`` is the config as YAML."""
    packages = (runtime.PACKAGE, "numpy", "scipy", "h5py", "pydantic", "matplotlib")
    return {
        "versions": {
            "tisph": __version__,
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in packages},
        },
        "platform": platform.platform(),
        "processor": platform.machine(),
        "threads": threads,
        "precision": config.discretisation.precision,
        "seed": config.initial.seed,
        "config_hash": fingerprint(resolved),
        "commit": _commit(),
    }


def fingerprint(resolved):
    """Return a hash of all that decides a run's outcome: the ``resolved`` config as YAML."""
    return hashlib.sha256(resolved.encode()).hexdigest()[:16]


def _commit():
    """Return the commit of the checkout that the package lies in, None for an installed package."""
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


def peak_memory_mb():
    """Return the largest resident memory of this process so far, None where the system does not tell."""
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6, 1)


VIDEO = "output.video."
"""What the keys of the movie begin with."""


@dataclass(frozen=True)
class Picture:
    """A picture that is being drawn, for the file ``path``: ``image`` waits for it and returns it as PNG."""

    path: Path
    image: Callable

    def write(self):
        """Wait for it and write it. TisphError where it could not be drawn or cannot be written."""
        image = self.image()
        with replaced(self.path) as new:
            new.write_bytes(image)


def movie(folder, settings, channel):
    """Return the movie of a run, to which frames can be added."""
    return RemoteMovie(shared(), folder.movie, channel, settings.output.video, settings.name, settings.time.end)


def begin_pictures(folder, settings, channel):
    """Let profiles.png and history.png be drawn from the stored samples and history; return those there will be."""
    wanted, paths = {}, {"profiles": folder.profiles_picture, "history": folder.history_picture}
    snapshots = read_samples(folder.samples) if folder.samples.exists() else []
    if snapshots:
        wanted["profiles"] = (snapshots,)
    times, values = read_history(folder.history) if folder.history.exists() else ((), ())
    if len(times):
        wanted["history"] = settings.time_series, times, values, read_resolved(folder.history)
    drawn = shared().request("plots", described(channel)[0], wanted) if wanted else None
    return [Picture(paths[name], lambda name=name: drawn.result()[name]) for name in wanted]


def begin_still(path, settings, channel, snapshot):
    """Let the frame of ``snapshot`` be drawn for the file ``path``."""
    video = settings.output.video or type(settings.output).model_fields["video"].default
    scene = described(channel, video)
    return Picture(path, shared().request("still", *scene, settings.name, settings.time.end, snapshot).result)


def render(run_dir, overrides=(), gif=False):
    """Draw what the files in ``run_dir`` allow and return the paths of the pictures.

    ``overrides`` are texts ``output.video.KEY=VALUE``, for another movie of the same frames; with ``gif`` it is also
    written as GIF, and its last frame as JPEG. Raises ConfigError where ``run_dir`` is no results folder, its files
    cannot be read or do not have what is asked for, TisphError where the pictures cannot be written.
    """
    folder = Folder(run_dir)
    if not any(path.exists() for path in (folder.samples, folder.history, folder.frames)):
        raise ConfigError(f"{folder.root}: has nothing to draw: neither samples.h5 nor history.csv nor frames.h5")
    _require_movie_keys(folder, overrides)
    settings = config.load(folder.config, overrides)
    channel = scenes.of(settings)
    if overrides:
        _require_fields(folder, channel, settings.output.video.color_by)
    pictures = begin_pictures(folder, settings, channel)
    for picture in pictures:
        picture.write()
    drawn = [picture.path for picture in pictures]
    if settings.output.video and folder.frames.exists():
        film = movie(folder, settings, channel)
        try:
            for snapshot in read_frames(folder.frames):
                film.add(snapshot)
        finally:
            film.close()
        drawn.append(folder.movie)
    return [*drawn, *_small(folder)] if gif else drawn


def _small(folder):
    """Write the movie as GIF and its last frame, and return their paths; ConfigError where there is no movie."""
    from tisph.report.encoder import (
        poster,
        write_gif,  # a run, which needs neither, does not pay for imageio-ffmpeg and Pillow
    )

    if not folder.movie.is_file():
        raise ConfigError(f"{folder.root}: there is no {folder.movie.name} to make a GIF of")
    write_gif(folder.movie, folder.movie_gif)
    folder.poster.write_bytes(poster(folder.movie))
    return folder.movie_gif, folder.poster


def _require_movie_keys(folder, overrides):
    """Raise ConfigError for what is no key of the movie, or another number of frames, or where there are no frames."""
    for text in overrides:
        key = text.partition("=")[0].strip()
        if not key.startswith(VIDEO) or key == f"{VIDEO}frames":
            known = ", ".join(name for name in Video.model_fields if name != "frames")
            raise ConfigError(f"--set {text}: a finished run is drawn again with other {VIDEO}KEY only; KEY: {known}")
    if overrides and not folder.frames.exists():
        raise ConfigError(f"{folder.root}: the run kept no frames ({folder.frames.name}), so there is no other movie")


def _require_fields(folder, channel, color_by):
    """Raise ConfigError where the stored frames lack a field that a movie coloured by ``color_by`` shows."""
    for snapshot in islice(read_frames(folder.frames), 1):
        lacking = [name for name in channel.movie_fields(color_by) if not np.size(getattr(snapshot, name))]
        if lacking:
            raise ConfigError(
                f"{VIDEO}color_by = {color_by}: {folder.frames} has no {', '.join(lacking)}; "
                f"run again with --set {VIDEO}color_by={color_by}"
            )
