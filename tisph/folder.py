"""The results folder: the one list of the files that a run may leave."""

from pathlib import Path


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
        self.checkpoint_partial = self.root / "checkpoint.partial"
        self.last_good = self.root / "last_good.h5"
        self.last_good_picture = self.root / "last_good.png"

    def files(self):
        """Return the paths of all of them."""
        return [path for name, path in vars(self).items() if name != "root"]
