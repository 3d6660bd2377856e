"""The results folder: the one list of the files that a run may leave."""

from pathlib import Path


def partial(path):
    """Return where the file that is to take the place of ``path`` is written."""
    return path.with_name(f"{path.name}.partial")


def spare(path):
    """Return where the file before ``path`` is for a moment."""
    return path.with_name(f"{path.name}.spare")


class Folder:
    """Paths of a run's files in ``root``."""

    def __init__(self, root):
        self.root = Path(root)
        self.config = self.root / "config.resolved.yaml"
        self.summary = self.root / "summary.json"
        self.samples = self.root / "samples.h5"
        self.history = self.root / "history.csv"
        self.frames = self.root / "frames.h5"
        self.movie = self.root / "movie.mp4"
        self.profiles_picture = self.root / "profiles.png"
        self.history_picture = self.root / "history.png"
        self.log = self.root / "run.log"
        self.checkpoint = self.root / "checkpoint.h5"
        self.last_good = self.root / "last_good.h5"
        self.last_good_picture = self.root / "last_good.png"

    def files(self):
        """Return the paths of all of them, and of what a killed run was writing."""
        paths = [path for name, path in vars(self).items() if name != "root"]
        return [*paths, *map(partial, paths), spare(self.samples), spare(self.frames)]
