"""Runs as separate processes, so that no run can affect another, and their results.

On Linux a server imports the modules of a run once and is forked for each run, before Taichi is initialised: the run
starts a second sooner. On other systems, where a fork is not safe, each run imports its modules itself.
"""

import math
import multiprocessing
import os
import runpy
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from filelock import Timeout

from tisph import registry, version
from tisph.folder import Folder
from tisph.results._results import Arrays

METHOD = "forkserver" if sys.platform == "linux" else "spawn"

PLANAR = ("tisph.schemes.implicit.planar.scheme", "scipy.sparse.linalg", "scipy.spatial")
COMPILED = ("tisph.schemes.implicit.channel.scheme", "tisph.schemes.wcsph._scheme", *PLANAR)
MODELS = (*registry.modules("scenes"), *registry.modules("schemes"), "tisph.schemes._forecast")
IMPORTED = ("tisph.cli", "tisph.simulation", *MODELS, *COMPILED, "filelock", __name__)
"""Modules that the server imports; a run imports any others itself."""

POLL_SECONDS = 0.02

_starting = threading.Lock()


@dataclass(frozen=True)
class Result:
    """The folder of a run and the contents of its ``summary.json``."""

    folder: Path
    summary: dict[str, Any]

    def sample(self, time: float, key: str = "t_star") -> dict[str, Any] | None:
        """Return the sample at a ``time``, the value of its ``key``, t or t_star; None without such a sample."""
        samples = self.summary.get("samples", ())
        return next((one for one in samples if math.isclose(one[key], time, rel_tol=1e-9)), None)

    @property
    def last(self) -> Any:
        """The sample at the end of the run, a dict; None where the run stopped earlier."""
        return self.summary["samples"][-1] if self.summary["status"] == "done" else None

    @property
    def closure(self) -> float:
        """Relative residual of the momentum balance of the run; NaN where there is no balance."""
        closure = self.summary.get("momentum", {}).get("closure")
        return math.nan if closure is None else closure

    @property
    def reference_velocity(self) -> float:
        """Velocity by which the run's errors are divided."""
        return self.summary["numbers"]["reference_velocity"]

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the contents of ``samples.h5`` as {"sample/dataset": array}; empty without such a file."""
        path = Folder(self.folder).samples
        return dict(Arrays(path)) if path.is_file() else {}

    def bodies(self, field: str) -> np.ndarray:
        """Return a ``field`` of ``tisph.snapshot.Bodies`` at all samples, (samples, bodies, ...)."""
        arrays = self.arrays()
        return np.array([arrays[key] for key in sorted(arrays) if key.endswith(f"bodies/{field}")])


Outcomes = Generator[tuple[str, Result, str], None, None]
"""Names of runs, their ``Result`` and their error message, empty if done, in the order in which the runs end."""


def prepare() -> None:
    """Start the server in the background, unless it runs already or processes are not forked."""
    if METHOD == "forkserver":
        from multiprocessing import forkserver  # not everywhere

        with _as_command():
            forkserver.set_forkserver_preload(list(IMPORTED))
            forkserver.ensure_running()


@contextmanager
def _as_command() -> Iterator[None]:
    """Let processes that start inside be processes of the command line, whatever script or notebook this one runs.

    They do not import the script, and have the environment of ``tisph.__main__``.
    """
    with _starting:
        script, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
        given = os.environ.get("OPENBLAS_NUM_THREADS")
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        try:
            yield
        finally:
            sys.modules["__main__"] = script
            if given is None:
                del os.environ["OPENBLAS_NUM_THREADS"]


def start(arguments: list, messages: Path) -> multiprocessing.process.BaseProcess:
    """Start the command line with ``arguments`` and return its ``multiprocessing.Process``.

    Its standard error goes to the file ``messages``; its standard output is discarded.
    """
    prepare()
    words = [str(each) for each in arguments]
    context: Any = multiprocessing.get_context(METHOD)  # the type of a context without a method has no Process
    process = context.Process(target=_run_command, args=(words, str(messages)))
    with _as_command():
        process.start()
    return process


def _run_command(arguments: list[str], messages: str) -> None:
    """Run ``python -m tisph`` with ``arguments`` in this process."""
    version.PROCESS_START = time.perf_counter()
    for path, descriptor in ((os.devnull, 1), (messages, 2)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, descriptor)
        os.close(file)
    stderr: Any = sys.stderr
    stderr.reconfigure(encoding="utf-8")  # the encoding in which ``Process`` reads the messages
    sys.argv[1:] = arguments
    runpy.run_module("tisph", run_name="__main__")


class Process:
    """``tisph run`` of the config ``config_path`` into ``folder``, without pictures; it replaces an earlier run there.

    With ``resume`` it continues the earlier run from its checkpoint instead. ``estimated``: add ``--estimate-error``.
    After ``seconds`` it is stopped. ``stop`` closes the ``lock``.
    """

    def __init__(
        self,
        config_path: Path,
        folder: Path,
        resume: bool = False,
        seconds: float = math.inf,
        estimated: bool = False,
        lock: ExitStack | None = None,
    ):
        self.folder, self._lock = folder, lock
        self._seconds, self._began, self._late = seconds, time.perf_counter(), False
        self._messages = folder.with_name(f"{folder.name}.messages")  # a pipe could fill up; stop() removes it
        command: list[Any] = [
            "run",
            config_path,
            "--out",
            folder,
            "--no-pictures",
            "--resume" if resume else "--overwrite",
        ]
        self._process = start([*command, "--estimate-error"] if estimated else command, self._messages)

    @property
    def finished(self) -> bool:
        """Whether the process has ended; one that is late is stopped here."""
        if self._process.exitcode is None:
            self._late = time.perf_counter() - self._began > self._seconds
            if not self._late:
                return False
            self.stop()
        return True

    def outcome(self) -> tuple[Result, str]:
        """Wait for the end; return the ``Result`` of the run and its error message, empty if it is done."""
        if self._late:
            return read_result(self.folder), f"no end after {self._seconds:.0f} s"
        self._process.join()
        status = self._process.exitcode
        result = read_result(self.folder)
        message = result.summary.get("message") or self._error() or f"exit status {status}"
        return result, message if status else ""

    def stop(self) -> None:
        """Stop the run after its present step, if it still runs, and remove its messages."""
        if self._process.exitcode is None:
            self._process.terminate()
            self._process.join()
        with suppress(OSError):
            self._messages.unlink()
        if self._lock:
            self._lock.close()

    def _error(self) -> str:
        """Return the standard error without its progress lines."""
        if not self._messages.exists():
            return ""
        text = self._messages.read_text(encoding="utf-8", errors="replace")
        return text[max(text.rfind("error: "), 0) :].removeprefix("error: ").strip()


def read_result(folder: Path) -> Result:
    """Return the ``Result`` of the finished run in ``folder``; its status is ``failed`` if there is no summary."""
    return Result(folder, Folder(folder).read_summary())


def run_config(config_path: Path, folder: Path, resume: bool = False, estimated: bool = False) -> tuple[Result, str]:
    """Run one config; return its ``Result`` and its error message, empty if it is done. Options: see ``Process``."""
    process = Process(config_path, folder, resume, estimated=estimated)
    try:
        return process.outcome()
    finally:
        process.stop()


def run_resumed(config_path: Path, folder: Path) -> tuple[Result, str]:
    """Run one config that writes checkpoints, stop it after its first checkpoint, and resume it: as ``run_config``."""
    first = Process(config_path, folder)
    try:
        while not (first.finished or Folder(folder).checkpoint.is_file()):
            time.sleep(POLL_SECONDS)
    finally:
        first.stop()
    return run_config(config_path, folder, resume=True)


@dataclass(frozen=True)
class Ended:
    """In place of a ``Process``: a run that another command has made."""

    result: Result
    message: str
    finished: bool = True

    def outcome(self) -> tuple[Result, str]:
        """Return the ``Result`` of the run and its error message, empty if it is done."""
        return self.result, self.message

    def stop(self) -> None:
        """Do nothing."""


def run_side_by_side(names: Iterable[str], launch: Callable[[str], Process | Ended], most: int) -> Outcomes:
    """Run ``launch(name)`` for each of ``names``, at most ``most`` at a time; yield the outcomes as the runs end.

    A run for which ``launch`` raises Timeout, since another command makes it, is left for later. Processes that still
    run when the caller stops iterating are stopped.
    """
    waiting = list(names)
    running: dict[str, Process | Ended] = {}
    try:
        while waiting or running:
            for name in waiting[:]:
                if len(running) == most:
                    break
                with suppress(Timeout):
                    running[name] = launch(name)
                    waiting.remove(name)
            for name in [name for name, process in running.items() if process.finished]:
                process = running.pop(name)
                outcome = process.outcome()
                process.stop()
                yield (name, *outcome)
            time.sleep(POLL_SECONDS)
    finally:
        for process in running.values():
            process.stop()
