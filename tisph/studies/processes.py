"""Runs as processes of their own, so that none can touch another, and their results.

Where processes can be forked safely, that is on Linux, a server imports the modules of a run once, and is forked for
each run before Taichi is initialised. The run is a process like any other, and starts a second sooner. Elsewhere each
run imports its modules itself.
"""

import math
import multiprocessing
import os
import runpy
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tisph import registry, version
from tisph.folder import Folder
from tisph.results._results import Arrays

METHOD = "forkserver" if sys.platform == "linux" else "spawn"

COMPILED = ("tisph.schemes._channel.scheme", "tisph.schemes.wcsph._scheme")
MODELS = (*registry.modules("scenes"), *registry.modules("schemes"))
IMPORTED = ("tisph.cli", "tisph.simulation", *MODELS, *COMPILED, __name__)
"""Modules that the server imports; a run imports the others that it needs."""

POLL_SECONDS = 0.02


@dataclass(frozen=True)
class Result:
    """The folder of a run and the contents of its ``summary.json``."""

    folder: Path
    summary: dict

    def sample(self, time, key="t_star"):
        """The sample at a ``time``, which ``key`` of samples has, t or t_star; None where there is none."""
        samples = self.summary.get("samples", ())
        return next((one for one in samples if math.isclose(one[key], time, rel_tol=1e-9)), None)

    @property
    def last(self):
        """The sample at the end of the run; None where that was not reached."""
        return self.summary["samples"][-1] if self.summary["status"] == "done" else None

    @property
    def closure(self):
        """Relative residual of the momentum balance of the run; NaN where there is no balance."""
        closure = self.summary.get("momentum", {}).get("closure")
        return math.nan if closure is None else closure

    @property
    def reference_velocity(self):
        """Velocity by which the run's errors are divided."""
        return self.summary["numbers"]["reference_velocity"]

    def arrays(self):
        """Contents of ``samples.h5`` as {"sample/dataset": array}; empty where there is no such file."""
        path = Folder(self.folder).samples
        return dict(Arrays(path)) if path.is_file() else {}

    def bodies(self, field):
        """A ``field`` of ``tisph.snapshot.Bodies`` at all samples, (samples, bodies, ...)."""
        arrays = self.arrays()
        return np.array([arrays[key] for key in sorted(arrays) if key.endswith(f"bodies/{field}")])


def prepare():
    """Start the server in the background, unless it runs already or processes are not forked."""
    if METHOD == "forkserver":
        from multiprocessing import forkserver  # not everywhere

        forkserver.set_forkserver_preload(list(IMPORTED))
        forkserver.ensure_running()


def start(arguments: list, messages: Path) -> multiprocessing.process.BaseProcess:
    """Start the command line with ``arguments`` and return its ``multiprocessing.Process``.

    Its standard error goes to the file ``messages``, its standard output nowhere.
    """
    prepare()
    words = [str(each) for each in arguments]
    process = multiprocessing.get_context(METHOD).Process(target=_be, args=(words, str(messages)))
    process.start()
    return process


def _be(arguments, messages):
    """Be that process: as ``python -m tisph`` with ``arguments``."""
    version.PROCESS_START = time.perf_counter()
    for path, descriptor in ((os.devnull, 1), (messages, 2)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, descriptor)
        os.close(file)
    sys.stderr.reconfigure(encoding="utf-8")  # as which messages are read
    sys.argv[1:] = arguments
    runpy.run_module("tisph", run_name="__main__")


class Process:
    """``tisph run`` of the config ``config_path`` into ``folder``, in place of an earlier run there.

    With ``resume`` it continues the earlier run from its checkpoint instead. ``estimated``: it states its error, too.
    After ``seconds`` it is ended. It leaves no pictures.
    """

    def __init__(
        self,
        config_path: Path,
        folder: Path,
        resume: bool = False,
        seconds: float = math.inf,
        estimated: bool = False,
    ):
        self.folder = folder
        self._seconds, self._began, self._late = seconds, time.perf_counter(), False
        self._messages = folder.with_name(f"{folder.name}.messages")  # a pipe could fill up; stop() removes it
        command = ["run", config_path, "--out", folder, "--no-pictures", "--resume" if resume else "--overwrite"]
        self._process = start([*command, "--estimate-error"] if estimated else command, self._messages)

    @property
    def finished(self):
        """Whether it has ended, or has been ended because it was late."""
        if self._process.exitcode is None:
            self._late = time.perf_counter() - self._began > self._seconds
            if not self._late:
                return False
            self.stop()
        return True

    def outcome(self):
        """``Result`` of the run and its error message, empty if it is done. Waits for the end."""
        if self._late:
            return read_result(self.folder), f"no end after {self._seconds:.0f} s"
        self._process.join()
        status = self._process.exitcode
        result = read_result(self.folder)
        message = result.summary.get("message") or self._error() or f"exit status {status}"
        return result, message if status else ""

    def stop(self):
        """End it after its present step, if it still runs."""
        if self._process.exitcode is None:
            self._process.terminate()
            self._process.join()
        with suppress(OSError):
            self._messages.unlink()

    def _error(self):
        """Its standard error without the lines of its progress."""
        if not self._messages.exists():
            return ""
        text = self._messages.read_text(encoding="utf-8", errors="replace")
        return text[max(text.rfind("error: "), 0) :].removeprefix("error: ").strip()


def read_result(folder: Path) -> Result:
    """``Result`` of the finished run in ``folder``; of status ``failed`` where it left no summary."""
    return Result(folder, Folder(folder).read_summary())


def run_config(config_path: Path, folder: Path, estimated: bool = False) -> tuple[Result, str]:
    """Run one config: its ``Result``, and its error message, empty if it is done. ``estimated``: see ``Process``."""
    process = Process(config_path, folder, estimated=estimated)
    try:
        return process.outcome()
    finally:
        process.stop()


def run_resumed(config_path: Path, folder: Path) -> tuple[Result, str]:
    """Run one config that writes checkpoints, end it after its first one, and go on from there: as ``run_config``."""
    first = Process(config_path, folder)
    try:
        while not (first.finished or Folder(folder).checkpoint.is_file()):
            time.sleep(POLL_SECONDS)
    finally:
        first.stop()
    second = Process(config_path, folder, resume=True)
    try:
        return second.outcome()
    finally:
        second.stop()


def run_side_by_side(
    names: Iterable[str], launch: Callable[[str], Process], most: int
) -> Iterator[tuple[str, Result, str]]:
    """Run ``launch(name)``, which returns a ``Process``, for each of ``names``, at most ``most`` at once.

    Yields (name, ``Result``, message) as they end. Those that still run when the caller gives up are stopped.
    """
    waiting = list(names)
    running = {}
    try:
        while waiting or running:
            while waiting and len(running) < most:
                name = waiting.pop(0)
                running[name] = launch(name)
            for name in [name for name, process in running.items() if process.finished]:
                process = running.pop(name)
                outcome = process.outcome()
                process.stop()
                yield (name, *outcome)
            time.sleep(POLL_SECONDS)
    finally:
        for process in running.values():
            process.stop()
