"""Pictures and movies drawn by a process of their own, beside the simulation.

Matplotlib takes a second to import, and a movie as long as some simulations: both happen elsewhere. This side neither
imports matplotlib nor waits for a frame; the other, ``tisph.report.artist``, knows no Taichi. It is started, not
forked: a fork of a process in which Taichi runs hangs.
"""

import atexit
import contextlib
import pickle
import subprocess
import sys
import tempfile
import threading
from collections import deque
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from tisph.errors import TisphError
from tisph.report.processes import apart_from_terminal

ROOM = 256 * 2**20
"""Bytes that may wait for the process that draws: then the run waits for it."""

_PROGRAM = "import sys; sys.path[:] = sys.argv[1:]; from tisph.report.artist import main; main()"
_UNSEEN = {"density": np.empty(0), "pressure": np.empty(0), "stress_xx": None, "stress_yy": None}
"""What stands for the fields of a snapshot that no picture shows, unless the scene says so."""


class Studio:
    """A process that draws. It ends with this one, whatever ends that, and finishes the movie it is at.

    What it cannot do, and its own end, is a TisphError where the answer is asked for, and nowhere else.
    """

    def __init__(self):
        self._answers = {}
        self._asked = 0
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 (it lives as long as the process)
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._messages,
            **apart_from_terminal(),
        )
        self._mail = _Mail(self._process.stdin)

    @property
    def works(self) -> bool:
        """Whether the process still runs."""
        return self._process.poll() is None

    def tell(self, task: str, *arguments) -> None:
        """Let the process do ``task``, a method of ``artist.Artist``, some time; errors are for what is asked later."""
        self._mail.post(pickle.dumps((None, task, arguments), pickle.HIGHEST_PROTOCOL))

    def ask(self, task: str, *arguments) -> "Answer":
        """Let it do ``task`` and return where its result will be."""
        self._asked += 1
        self._mail.post(pickle.dumps((self._asked, task, arguments), pickle.HIGHEST_PROTOCOL))
        return Answer(self, self._asked)

    def wait_for(self, number: int):
        """Return the result of what was asked as ``number``; TisphError where there is none."""
        while number not in self._answers:
            try:
                found, *answer = pickle.load(self._process.stdout)
            except (EOFError, OSError, pickle.UnpicklingError) as error:
                raise TisphError(f"the process that draws has ended: {self._last_words()}") from error
            self._answers[found] = answer
        result, message = self._answers.pop(number)
        if message:
            raise TisphError(message)
        return result

    def close(self) -> None:
        """Let the process end once it has done what it was told."""
        self._mail.close()

    def _last_words(self) -> str:
        status = self._process.wait()
        self._messages.seek(0)
        lines = self._messages.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"status {status}"


class Answer:
    """What comes of a task."""

    def __init__(self, studio: Studio, number: int):
        self._studio, self._number = studio, number
        self._result = None

    def result(self):
        """Wait for the result and return it; TisphError where there is none."""
        if self._result is None:
            self._result = self._studio.wait_for(self._number)
        return self._result


class DistantMovie:
    """A movie (arguments as for ``tisph.report.movie.Movie``) that a studio draws; ``close`` raises what went wrong."""

    def __init__(self, studio: Studio, path, scene, video, title: str, end: float):
        self._studio = studio
        shown = scene.shown_fields(video.color_by)
        self._unseen = {name: nothing for name, nothing in _UNSEEN.items() if name not in shown}
        studio.tell("movie", path, *described(scene, video), title, end)

    def add(self, snapshot) -> None:
        """Append the picture of ``snapshot``, some time."""
        self._studio.tell("frame", replace(snapshot, **self._unseen))

    def close(self) -> None:
        """Wait until the file is finished."""
        self._studio.ask("close").result()


def described(scene, video=None) -> list:
    """Return both without the config's own types, which take another process a while to import."""
    video = [SimpleNamespace(**vars(video))] if video is not None else []
    return [replace(scene, units=SimpleNamespace(**vars(scene.units))), *video]


_shared: Studio | None = None


def shared() -> Studio:
    """Return the studio of this process, started by the first call and again where it has ended."""
    global _shared
    if _shared is None or not _shared.works:
        _shared = Studio()
    return _shared


@atexit.register
def _close() -> None:
    if _shared is not None:
        _shared.close()


class _Mail:
    """Writes letters to ``pipe`` in a thread of its own, up to ``ROOM`` bytes behind."""

    def __init__(self, pipe):
        self._pipe, self._letters, self._size = pipe, deque(), 0
        self._changed = threading.Condition()
        self._open = True
        threading.Thread(target=self._deliver, daemon=True).start()

    def post(self, letter: bytes) -> None:
        """Leave a letter to be delivered; nothing happens once nobody reads them."""
        with self._changed:
            self._changed.wait_for(lambda: self._size < ROOM or not self._open)
            if self._open:
                self._letters.append(letter)
                self._size += len(letter)
                self._changed.notify_all()

    def close(self) -> None:
        """Close the pipe; what is not delivered yet is forgotten."""
        with self._changed:
            self._open = False
            self._changed.notify_all()

    def _deliver(self) -> None:
        with contextlib.suppress(OSError):  # nobody reads any more: the answers will say why
            while letter := self._next():
                self._pipe.write(letter)
                self._pipe.flush()
                with self._changed:
                    self._size -= len(letter)
                    self._changed.notify_all()
        self.close()
        with contextlib.suppress(OSError):
            self._pipe.close()

    def _next(self) -> bytes | None:
        with self._changed:
            self._changed.wait_for(lambda: self._letters or not self._open)
            return self._letters.popleft() if self._open else None
