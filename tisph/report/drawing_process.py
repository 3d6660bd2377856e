"""Pictures and movies drawn by a process of their own, beside the simulation.

Matplotlib takes a second to import, and a movie as long as some simulations: both happen elsewhere. This side neither
imports matplotlib nor waits for a frame; the other, ``tisph.report.drawing_worker``, knows no Taichi. It is started,
not forked: a fork of a process in which Taichi runs hangs.
"""

import atexit
import contextlib
import pickle
import subprocess
import sys
import tempfile
import threading
from collections import deque
from concurrent.futures import Future
from dataclasses import replace
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tisph.errors import TisphError
from tisph.report.processes import apart_from_terminal

QUEUE_BYTES = 256 * 2**20
"""Bytes that may wait for the process that draws: then the run waits for it."""

_PROGRAM = "import sys; sys.path[:] = sys.argv[1:]; from tisph.report.drawing_worker import main; main()"
_NOT_DRAWN = {"density": np.empty(0), "pressure": np.empty(0), "stress_xx": None, "stress_yy": None}
"""What stands for the fields of a snapshot that no picture shows, unless the scene says so."""


class DrawingProcess:
    """A process that draws. It ends with this one, whatever ends that, and finishes the movie it is at.

    What it cannot do, and its own end, is a TisphError where the result is asked for, and nowhere else.
    """

    def __init__(self):
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 (it lives as long as the process)
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._messages,
            **apart_from_terminal(),
        )
        self._tasks = _WriteQueue(self._process.stdin)
        self._requested: dict[int, Future] = {}
        self._numbers = count()
        self._lock = threading.Lock()
        self._ended = False
        threading.Thread(target=self._receive, daemon=True).start()

    @property
    def works(self) -> bool:
        """Whether the process still runs."""
        return self._process.poll() is None

    def send(self, task: str, *arguments) -> None:
        """Let it do ``task``, a method of ``drawing_worker.Worker``, some time; errors are for what is requested."""
        self._tasks.put(pickle.dumps((None, task, arguments), pickle.HIGHEST_PROTOCOL))

    def request(self, task: str, *arguments) -> Future:
        """Let it do ``task`` and return the future of its result, which raises TisphError where there is none."""
        future: Future = Future()
        with self._lock:
            if self._ended:
                future.set_exception(self._failure())
                return future
            number = next(self._numbers)
            self._requested[number] = future
        self._tasks.put(pickle.dumps((number, task, arguments), pickle.HIGHEST_PROTOCOL))
        return future

    def close(self) -> None:
        """Let the process end once it has done what it was sent."""
        self._tasks.close()

    def _receive(self) -> None:
        """Hand every answer to the future that waits for it, until the process ends."""
        with contextlib.suppress(EOFError, OSError, pickle.UnpicklingError):
            while True:
                number, result, message = pickle.load(self._process.stdout)
                future = self._requested.pop(number)
                future.set_exception(TisphError(message)) if message else future.set_result(result)
        with self._lock:
            self._ended = True
            for future in self._requested.values():
                future.set_exception(self._failure())

    def _failure(self) -> TisphError:
        status = self._process.wait()
        self._messages.seek(0)
        lines = self._messages.read().decode(errors="replace").strip().splitlines()
        return TisphError(f"the process that draws has ended: {lines[-1] if lines else f'status {status}'}")


class RemoteMovie:
    """A movie (arguments as for ``tisph.report.movie.Movie``) that ``process`` draws; ``close`` raises errors."""

    def __init__(self, process: DrawingProcess, path, scene, video, title: str, end: float):
        self._process = process
        shown = scene.movie_fields(video.color_by)
        self._not_drawn = {name: nothing for name, nothing in _NOT_DRAWN.items() if name not in shown}
        place = Path(path).absolute()  # the process stays where it started
        process.send("movie", place, *described(scene, video), title, end)

    def add(self, snapshot) -> None:
        """Append the picture of ``snapshot``, some time."""
        self._process.send("frame", replace(snapshot, **self._not_drawn))

    def close(self) -> None:
        """Wait until the file is finished."""
        self._process.request("close").result()


def described(scene, video=None) -> list:
    """Return both without the config's own types, which take another process a while to import."""
    video = [SimpleNamespace(**vars(video))] if video is not None else []
    return [replace(scene, units=SimpleNamespace(**vars(scene.units))), *video]


_shared: DrawingProcess | None = None


def shared() -> DrawingProcess:
    """Return the drawing process of this one, started by the first call and again where it has ended."""
    global _shared
    if _shared is None or not _shared.works:
        _shared = DrawingProcess()
    return _shared


@atexit.register
def _close() -> None:
    if _shared is not None:
        _shared.close()


class _WriteQueue:
    """Writes messages to ``pipe`` in a thread of its own, up to ``QUEUE_BYTES`` behind."""

    def __init__(self, pipe):
        self._pipe, self._waiting, self._size = pipe, deque(), 0
        self._changed = threading.Condition()
        self._open = True
        threading.Thread(target=self._write, daemon=True).start()

    def put(self, message: bytes) -> None:
        """Leave a message to be written; nothing happens once nobody reads them."""
        with self._changed:
            self._changed.wait_for(lambda: self._size < QUEUE_BYTES or not self._open)
            if self._open:
                self._waiting.append(message)
                self._size += len(message)
                self._changed.notify_all()

    def close(self) -> None:
        """Close the pipe; what is not written yet is forgotten."""
        with self._changed:
            self._open = False
            self._changed.notify_all()

    def _write(self) -> None:
        with contextlib.suppress(OSError):  # nobody reads any more: the results will say why
            while message := self._next():
                self._pipe.write(message)
                self._pipe.flush()
                with self._changed:
                    self._size -= len(message)
                    self._changed.notify_all()
        self.close()
        with contextlib.suppress(OSError):
            self._pipe.close()

    def _next(self) -> bytes | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or not self._open)
            return self._waiting.popleft() if self._open else None
