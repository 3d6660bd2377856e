"""Movie and pictures again from the files of a run."""

from tisph import config, families
from tisph.folder import Folder
from tisph.observers._files import replaced
from tisph.observers.frames import read_frames
from tisph.observers.history import read_history
from tisph.observers.samples import read_samples
from tisph.report.history import plot_history
from tisph.report.movie import Movie
from tisph.report.profiles import plot_profiles


def render(run_dir):
    """Draw what the files in ``run_dir`` allow and return the paths of the pictures.

    Raises ConfigError where ``run_dir`` is no results folder or its files cannot be read, TisphError where the pictures
    cannot be written.
    """
    folder = Folder(run_dir)
    settings = config.load(folder.config)
    channel = families.load("scenes", settings.scene).Scene.from_config(settings)
    drawn = pictures(folder, settings, channel)
    if settings.output.video and folder.frames.exists():
        with Movie(folder.movie, channel, settings.output.video, settings.name, settings.time.end) as movie:
            for snapshot in read_frames(folder.frames):
                movie.add(snapshot)
        drawn.append(folder.movie)
    return drawn


def pictures(folder, settings, channel):
    """Draw profiles.png and history.png from the stored samples and history; return what was drawn."""
    drawn = []
    snapshots = read_samples(folder.samples)
    if snapshots:
        with replaced(folder.profiles_picture) as new:
            plot_profiles(new, channel, snapshots)
        drawn.append(folder.profiles_picture)
    times, velocities = read_history(folder.history)
    if len(times):
        heights = channel.tracer_positions(settings.tracers.count, settings.tracers.x)[1]
        with replaced(folder.history_picture) as new:
            plot_history(new, channel, times, heights, velocities)
        drawn.append(folder.history_picture)
    return drawn
