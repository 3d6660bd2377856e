"""Movie and pictures of a run: the drawing process makes them, the files are written here."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from tisph import config, scenes
from tisph.config.schema import Video
from tisph.errors import ConfigError
from tisph.folder import Folder
from tisph.observers._storage import replaced
from tisph.observers.history import read_history, read_resolved
from tisph.observers.samples import read_frames, read_samples
from tisph.report.drawing_process import RemoteMovie, described, shared

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
