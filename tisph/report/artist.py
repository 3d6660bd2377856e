"""The program of the process that draws: tasks from standard input, answers to standard output, both pickled.

``tisph.report.studio`` starts it and sends the tasks. It ends where its input does, that is, with the run.
"""

import contextlib
import io
import os
import pickle
import signal
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import BinaryIO

from tisph.errors import TisphError
from tisph.report.history import plot_history
from tisph.report.movie import Movie
from tisph.report.profiles import plot_profiles

PLOTS = {"profiles": plot_profiles, "history": plot_history}


class Artist:
    """The tasks. A movie that has failed fails once, when it is closed."""

    def __init__(self):
        self._movie: Movie | None = None
        self._failure: Exception | None = None

    def movie(self, path, scene, video, title, end) -> None:
        """Begin a movie; arguments as for ``tisph.report.movie.Movie``."""
        self.abandon()
        with self._remembered():
            self._movie = Movie(path, scene, video, title, end)

    def frame(self, snapshot) -> None:
        """Add a frame to the movie."""
        if self._movie and not self._failure:
            with self._remembered():
                self._movie.add(snapshot)

    def close(self) -> None:
        """Finish the movie; raise what went wrong with it."""
        movie, failure, self._movie, self._failure = self._movie, self._failure, None, None
        if movie:
            with contextlib.suppress(TisphError) if failure else contextlib.nullcontext():
                movie.close()
        if failure:
            raise failure

    def abandon(self) -> None:
        """Finish the movie, if there is one, as it is."""
        with contextlib.suppress(Exception):
            self.close()

    def still(self, scene, video, title, end, snapshot) -> dict[str, bytes]:
        """Return the picture of ``snapshot`` as PNG, by the name ``still``."""
        return {"still": _png(Movie("", scene, video, title, end).save_frame, snapshot)}

    def plots(self, scene, wanted) -> dict[str, bytes]:
        """Return the pictures ``wanted`` as PNG: arguments beside the scene by name, of ``PLOTS``.

        They are drawn side by side, where a process can be forked: at the end of a run all processors are free.
        """
        pictures = [(PLOTS[name], scene, *arguments) for name, arguments in wanted.items()]
        if len(pictures) == 1 or not hasattr(os, "fork"):
            return dict(zip(wanted, [_png(*picture) for picture in pictures], strict=True))
        *others, last = pictures
        with ProcessPoolExecutor(len(others), get_context("fork")) as pool:
            drawn = [pool.submit(_png, *picture) for picture in others]
            images = [_png(*last), *(image.result() for image in drawn)]
        return dict(zip(wanted, [*images[1:], images[0]], strict=True))

    @contextlib.contextmanager
    def _remembered(self):
        try:
            yield
        except Exception as error:
            self._failure = error


def main() -> None:
    """Do what standard input asks for, to its end."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the run decides how to end
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints is no answer
    artist = Artist()
    with contextlib.suppress(EOFError, OSError, pickle.UnpicklingError):  # the run has ended, maybe in mid-word
        _work(artist, sys.stdin.buffer, answers)
    artist.abandon()
    os._exit(0)  # nothing is left to clear up


def _work(artist: Artist, tasks: BinaryIO, answers: BinaryIO) -> None:
    while True:
        number, task, arguments = pickle.load(tasks)
        result = message = None
        try:
            result = getattr(artist, task)(*arguments)
        except TisphError as error:
            message = str(error)
        except Exception as error:
            message = f"{task}: {type(error).__name__}: {error}"
        if number is not None:
            pickle.dump((number, result, message), answers, pickle.HIGHEST_PROTOCOL)
            answers.flush()


def _png(draw, *arguments) -> bytes:
    picture = io.BytesIO()
    draw(picture, *arguments)
    return picture.getvalue()
