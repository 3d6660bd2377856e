"""The program of the process that draws: tasks from standard input, answers to standard output, both pickled.

``tisph.report.drawing_process`` starts it and sends the tasks. Each is answered before the next one is read. The
program ends where its input does, that is, with the run.
"""

import contextlib
import io
import os
import pickle
import signal
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from tisph.errors import TisphError
from tisph.report.movie import Movie
from tisph.report.plots import history_figure, profile_figure
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot

PLOTS: dict[str, Any] = {"profiles": profile_figure, "history": history_figure}


class Worker:
    """The tasks. A movie that fails is finished as far as it goes, and takes no more frames."""

    def __init__(self) -> None:
        self._movie: Movie | None = None

    def movie(self, path: Path, scene: Scene, video: Any, title: str, end: float) -> None:
        """Begin a movie; arguments as for ``tisph.report.movie.Movie``."""
        self.abandon()
        self._movie = Movie(path, scene, video, title, end)

    def frame(self, snapshot: Snapshot) -> None:
        """Add a frame to the movie."""
        if self._movie:
            try:
                self._movie.add(snapshot)
            except Exception:
                self.abandon()
                raise

    def close(self) -> None:
        """Finish the movie."""
        movie, self._movie = self._movie, None
        if movie:
            movie.close()

    def abandon(self) -> None:
        """Finish the movie, if there is one, as it is."""
        with contextlib.suppress(Exception):
            self.close()

    def still(self, scene: Scene, video: Any, title: str, end: float, snapshot: Snapshot) -> bytes:
        """Return the picture of ``snapshot`` as PNG."""
        picture = io.BytesIO()
        Movie("", scene, video, title, end).save_frame(picture, snapshot)
        return picture.getvalue()

    def plots(self, scene: Scene, wanted: dict[str, tuple]) -> dict[str, bytes]:
        """Return the plots ``wanted`` as PNG: arguments beside the scene by name, of ``PLOTS``.

        They are drawn side by side, where a process can be forked: at the end of a run all processors are free.
        """
        if len(wanted) == 1 or not hasattr(os, "fork"):
            return {name: _plot(name, scene, *arguments) for name, arguments in wanted.items()}
        with ProcessPoolExecutor(len(wanted), get_context("fork")) as pool:
            drawn = {name: pool.submit(_plot, name, scene, *arguments) for name, arguments in wanted.items()}
            return {name: image.result() for name, image in drawn.items()}

    def answer(self, task: str, arguments: Sequence[Any]) -> tuple[object, str | None]:
        """Return the result and the error message of ``task``, one of them None."""
        try:
            return getattr(self, task)(*arguments), None
        except TisphError as error:
            return None, str(error)
        except Exception as error:
            return None, f"{task}: {type(error).__name__}: {error}"


def main() -> None:
    """Run the tasks from standard input until it ends."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the run decides how to end
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # libraries may print; standard output has answers only
    worker = Worker()
    with contextlib.suppress(EOFError, OSError, pickle.UnpicklingError):  # the run has ended, maybe in mid-word
        while True:
            pickle.dump(worker.answer(*pickle.load(sys.stdin.buffer)), answers, pickle.HIGHEST_PROTOCOL)
            answers.flush()
    worker.abandon()
    os._exit(0)  # nothing is left to clear up


def _plot(name: str, *arguments: Any) -> bytes:
    return PLOTS[name](*arguments).png()
