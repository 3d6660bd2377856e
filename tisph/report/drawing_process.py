"""Pictures and movies drawn by a process of their own, beside the simulation.

Matplotlib takes a second to import, and a movie as long as some simulations: both happen elsewhere. This side neither
imports matplotlib nor waits for a frame; the other, ``tisph.report.drawing_worker``, knows no Taichi. It is started,
not forked: a fork of a process in which Taichi runs hangs. It is no ``concurrent.futures.ProcessPoolExecutor``: the
worker of a pool outlives a run that is killed, dies of a Ctrl-C while it starts, runs a script without a main guard
again, and cannot be had in a worker of ``multiprocessing.Pool``; and Python waits for a pool when it ends.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from queue import Queue
from types import SimpleNamespace
from typing import Any

import numpy as np

from tisph.errors import TisphError
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot


def apart_from_terminal() -> dict:
    """Return the settings that keep Ctrl-C and a closed terminal from a process: it must live to finish its file.

    It writes UTF-8, which is how its messages are read, whatever the terminal shows.
    """
    settings = {"env": {**os.environ, "PYTHONIOENCODING": "utf-8"}}
    if sys.platform == "win32":
        return {**settings, "creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {**settings, "start_new_session": True}


BACKLOG = 64
"""Tasks that may wait for the process that draws, such as frames of 3 MB for 10^5 particles: then the run waits."""

_PROGRAM = "import sys; sys.path[:] = sys.argv[1:]; from tisph.report.drawing_worker import main; main()"
_NOT_DRAWN: dict[str, Any] = {"density": np.empty(0), "pressure": np.empty(0), "stress_xx": None, "stress_yy": None}
"""Values in place of the fields of a snapshot that no picture shows, unless the scene asks for them."""


class DrawingProcess:
    """A process that draws. It finishes its movie and ends when this process ends, for any reason.

    A task that fails, and an end of the process, raise TisphError only where the result of a task is read.
    """

    def __init__(self) -> None:
        self._messages = tempfile.TemporaryFile()  # noqa: SIM115 (it lives as long as the process)
        self._process: Any = subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._messages,
            **apart_from_terminal(),
        )
        self._tasks: Queue[tuple[Future, bytes]] = Queue(BACKLOG)
        self._sent: Queue[Future] = Queue()
        for endless in (self._send, self._receive):  # two: the next frame is there as soon as it can be drawn
            threading.Thread(target=endless, daemon=True).start()  # Python does not wait for it when it ends

    @property
    def works(self) -> bool:
        """Whether the process still runs."""
        return self._process.poll() is None

    def request(self, task: str, *arguments: Any) -> Future:
        """Send ``task``, a method of ``drawing_worker.Worker``, which runs after all earlier ones; return a future."""
        future: Future = Future()
        self._tasks.put((future, pickle.dumps((task, arguments), pickle.HIGHEST_PROTOCOL)))
        return future

    def _send(self) -> None:
        while True:
            future, task = self._tasks.get()
            self._sent.put(future)
            with contextlib.suppress(OSError):  # the process has ended: the answer says so
                self._process.stdin.write(task)
                self._process.stdin.flush()

    def _receive(self) -> None:
        while True:
            future = self._sent.get()
            try:
                result, message = pickle.load(self._process.stdout)
            except (EOFError, OSError, pickle.UnpicklingError):
                result, message = None, self._last_words()
            future.set_exception(TisphError(message)) if message else future.set_result(result)

    def _last_words(self) -> str:
        status = self._process.wait()
        self._messages.seek(0)
        lines = self._messages.read().decode(errors="replace").strip().splitlines()
        return f"the process that draws has ended: {lines[-1] if lines else f'status {status}'}"


class RemoteMovie:
    """A movie (arguments as for ``tisph.report.movie.Movie``) that ``process`` draws; ``close`` raises errors."""

    def __init__(self, process: DrawingProcess, path: str | Path, scene: Scene, video: Any, title: str, end: float):
        self._process = process
        shown = scene.movie_fields(video.color_by)
        self._not_drawn = {name: nothing for name, nothing in _NOT_DRAWN.items() if name not in shown}
        self._carried = {*shown} & {*scene.substance_colours}
        place = Path(path).absolute()  # the process stays where it started
        self._requested = [process.request("movie", place, *described(scene, video), title, end)]

    def add(self, snapshot: Snapshot) -> None:
        """Append the picture of ``snapshot``, some time."""
        carried = {name: snapshot.field(name) for name in self._carried}
        self._requested.append(self._process.request("frame", replace(snapshot, **self._not_drawn, substances=carried)))

    def close(self) -> None:
        """Wait until the file is finished; raise the first error of the movie, once."""
        requested, self._requested = [*self._requested, self._process.request("close")], []
        for each in requested:
            each.result()


def described(scene: Scene, video: Any = None) -> list:
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
