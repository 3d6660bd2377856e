"""Movie and pictures of a run: the drawing process makes them, the files are written here."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tisph import config, scenes
from tisph.folder import Folder
from tisph.observers._files import replaced
from tisph.observers.frames import read_frames
from tisph.observers.history import read_history
from tisph.observers.samples import read_samples
from tisph.report.drawing_process import RemoteMovie, described, shared


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


def render(run_dir):
    """Draw what the files in ``run_dir`` allow and return the paths of the pictures.

    Raises ConfigError where ``run_dir`` is no results folder or its files cannot be read, TisphError where the pictures
    cannot be written.
    """
    folder = Folder(run_dir)
    settings = config.load(folder.config)
    channel = scenes.of(settings)
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
    return drawn


def movie(folder, settings, channel):
    """Return the movie of a run, to which frames can be added."""
    return RemoteMovie(shared(), folder.movie, channel, settings.output.video, settings.name, settings.time.end)


def begin_pictures(folder, settings, channel):
    """Let profiles.png and history.png be drawn from the stored samples and history; return those there will be."""
    wanted, paths = {}, {"profiles": folder.profiles_picture, "history": folder.history_picture}
    snapshots = read_samples(folder.samples)
    if snapshots:
        wanted["profiles"] = (snapshots,)
    times, values = read_history(folder.history)
    if len(times):
        wanted["history"] = settings.time_series, times, values
    drawn = shared().request("plots", described(channel)[0], wanted) if wanted else None
    return [Picture(paths[name], lambda name=name: drawn.result()[name]) for name in wanted]


def begin_still(path, settings, channel, snapshot):
    """Let the frame of ``snapshot`` be drawn for the file ``path``."""
    video = settings.output.video or type(settings.output).model_fields["video"].default
    scene = described(channel, video)
    return Picture(path, shared().request("still", *scene, settings.name, settings.time.end, snapshot).result)
