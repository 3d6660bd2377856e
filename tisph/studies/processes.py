"""Runs as processes of their own, so that none can touch another, and what they leave.

No run imports again what the one before it has imported, where processes can be forked safely, that is on Linux: a
server imports it once and is forked for each run before Taichi is initialised. The run is a process like any other, a
second sooner. Elsewhere each starts from nothing.
"""

import math
import multiprocessing
import os
import runpy
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tisph import clock, registry
from tisph.folder import Folder
from tisph.results._arrays import Arrays

METHOD = "forkserver" if sys.platform == "linux" else "spawn"

COMPILED = ("tisph.schemes.implicit._scheme", "tisph.schemes.wcsph._scheme")
MODELS = (*registry.modules("scenes"), *registry.modules("schemes"))
IMPORTED = ("tisph.cli", "tisph.simulation", *MODELS, *COMPILED, __name__)
"""What the server imports; a run imports the rest that it needs."""

POLL_SECONDS = 0.02


@dataclass(frozen=True)
class Result:
    """What a run left behind: its folder and the contents of its ``summary.json``."""

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
        """What the momentum balance of the run leaves open, as a fraction; NaN where there is no balance."""
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
    """Let the server get ready, beside what this process does, if there is to be one and it does not run yet."""
    if METHOD == "forkserver":
        from multiprocessing import forkserver  # not everywhere

        forkserver.set_forkserver_preload(list(IMPORTED))
        forkserver.ensure_running()


def start(arguments, messages):
    """Start the command line with ``arguments`` and return its ``multiprocessing.Process``.

    Its standard error goes to the file ``messages``, what it prints nowhere.
    """
    prepare()
    words = [str(each) for each in arguments]
    process = multiprocessing.get_context(METHOD).Process(target=_be, args=(words, str(messages)))
    process.start()
    return process


def _be(arguments, messages):
    """Be that process: as ``python -m tisph`` with ``arguments``."""
    clock.PROCESS_START = time.perf_counter()
    for path, descriptor in ((os.devnull, 1), (messages, 2)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, descriptor)
        os.close(file)
    sys.stderr.reconfigure(encoding="utf-8")  # as which messages are read
    sys.argv[1:] = arguments
    runpy.run_module("tisph", run_name="__main__")


class Process:
    """``tisph run`` of the config ``config_path`` into ``folder``, in place of what an earlier run left there.

    With ``resume`` it goes on from that one's checkpoint instead. ``estimated``: it states its error, too. It leaves no
    pictures.
    """

    def __init__(self, config_path, folder, resume=False, estimated=False):
        self.folder = folder
        self._messages = folder.with_name(f"{folder.name}.messages")  # a pipe could fill up; stop() removes it
        command = ["run", config_path, "--out", folder, "--no-pictures", "--resume" if resume else "--overwrite"]
        self._process = start([*command, "--estimate-error"] if estimated else command, self._messages)

    @property
    def finished(self):
        """Whether it has ended."""
        return self._process.exitcode is not None

    def outcome(self):
        """``Result`` of the run and its error message, empty if it is done. Waits for the end."""
        self._process.join()
        status = self._process.exitcode
        result = read_result(self.folder)
        message = result.summary.get("message") or self._error() or f"exit status {status}"
        return result, message if status else ""

    def stop(self):
        """End it after its present step, if it still runs."""
        if not self.finished:
            self._process.terminate()
            self._process.join()
        with suppress(OSError):
            self._messages.unlink()

    def _error(self):
        """What it has written to standard error, without the lines of its progress."""
        if not self._messages.exists():
            return ""
        text = self._messages.read_text(encoding="utf-8", errors="replace")
        return text[max(text.rfind("error: "), 0) :].removeprefix("error: ").strip()


def read_result(folder):
    """``Result`` of the finished run in ``folder``; of status ``failed`` where it left no summary."""
    return Result(folder, Folder(folder).read_summary())


def run_config(config_path, folder, estimated=False):
    """Run one config: its ``Result``, and its error message, empty if it is done. ``estimated``: see ``Process``."""
    process = Process(config_path, folder, estimated=estimated)
    try:
        return process.outcome()
    finally:
        process.stop()


def run_resumed(config_path, folder):
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


def run_side_by_side(names, launch, most):
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
