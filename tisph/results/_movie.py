"""``movie.mp4`` as an object that a notebook plays."""

from dataclasses import dataclass
from pathlib import Path


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
