"""The process of a run: its claim on Taichi, signals, ``run.log``, and the cost of its parts.

Taichi has one program. Therefore a process has one simulation at a time: starting another destroys its fields.
"""

import logging
import signal
import sys
import threading
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from tisph import runtime
from tisph.errors import TisphError, ending_signals

INSTEAD = "tisph.run has a process of its own for each run"

_open: weakref.ref[Any] | None = None


def claim(simulation: Any) -> None:
    """Claim Taichi for ``simulation``; TisphError where another open simulation or a foreign program uses it.

    A finished simulation is closed and keeps its last state. One without any reference does not count.
    """
    global _open
    other = _open() if _open else None
    if other is not None and other.finished:
        other.close()
    elif other is not None:
        raise TisphError(
            f"the simulation {other.config.name!r} is open, at t = {other.time:g}, and there can be one in a process: "
            f"end it with its close(), or use tisph.run: {INSTEAD}"
        )
    if runtime.foreign_program():
        raise TisphError(
            "another Taichi program is in this process, and its fields would be destroyed: call ti.reset() if they are "
            f"of no use any more, or use tisph.run: {INSTEAD}"
        )
    _open = weakref.ref(simulation)


def release(simulation: Any) -> None:
    """Release Taichi, if it is claimed by ``simulation``."""
    global _open
    if _open is not None and _open() is simulation:
        _open = None
        if not runtime.foreign_program():
            runtime.stop()


class Interrupts:
    """Their ``count``; ``wait`` is true while the present state of the run is not written yet."""

    def __init__(self, wait: bool = False):
        self.count, self.wait = 0, wait

    @contextmanager
    def counted(self) -> Iterator[None]:
        """Count the ``ending_signals`` inside, for a run that ends after its step; a second one stops it.

        With ``wait`` the second one, too, takes effect after the step, the checkpoint and the summary.
        """

        def handle(number: int, frame: FrameType | None) -> None:
            self.count += 1
            if self.count > 1 and not self.wait:
                raise KeyboardInterrupt

        def unraisable(failure: Any) -> None:
            if failure.exc_type is not KeyboardInterrupt:  # where Python cannot raise it, it was counted at least
                report(failure)

        report = sys.unraisablehook
        try:
            previous = {number: signal.signal(number, handle) for number in ending_signals()}
        except ValueError:  # not in the main thread: the caller decides
            yield
            return
        sys.unraisablehook = unraisable
        try:
            yield
        finally:
            sys.unraisablehook = report
            for number, handler in previous.items():
                signal.signal(number, handler)


@contextmanager
def interrupts_after() -> Iterator[None]:
    """Delay Ctrl-C, which may come at any time in a notebook, until the block has ended."""
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler) or threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: list[tuple[int, FrameType | None]] = []
    signal.signal(signal.SIGINT, lambda number, frame: heard.append((number, frame)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    for each in heard:
        handler(*each)


log = logging.getLogger("tisph")
log.addHandler(logging.NullHandler())  # else Python prints warnings a second time


def warn(text: str) -> None:
    """Print a warning and write it to ``run.log``."""
    log.warning(text)
    print(f"warning: {text}", file=sys.stderr)


class _LogFile(logging.FileHandler):
    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 (logging calls it so)
        """Do nothing on a full disk: writing the results raises an error of its own."""


@contextmanager
def logging_to(path: Path, append: bool) -> Iterator[None]:
    """Write messages logged inside to the file ``path``, and the error that ends the block, if any."""
    handler = _LogFile(path, mode="a" if append else "w", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    except TisphError as error:
        log.error("%s", error)
        raise
    except Exception:
        log.exception("unexpected failure")
        raise
    finally:
        log.removeHandler(handler)
        with suppress(OSError):
            handler.close()


class Costs:
    """The ``seconds`` (2,) of a run by kind, of the clock and of processor time; it ``began`` at a time of the clock.

    Kinds are imports, compiling kernels, the loop over the steps, and output.
    """

    def __init__(self) -> None:
        self.began = time.perf_counter()
        self.seconds = {kind: np.zeros(2) for kind in ("import", "compile", "loop", "output")}

    @contextmanager
    def timed(self, kind: str) -> Iterator[None]:
        """Add the seconds of the block to ``kind``, and the seconds of compiling kernels to that kind."""
        began, compiled = runtime.clocks(), runtime.compile_seconds()
        try:
            yield
        finally:
            compiling = runtime.compile_seconds() - compiled  # a kernel is compiled at its first launch, anywhere
            self.seconds["compile"] += compiling
            self.seconds[kind] += runtime.clocks() - began - compiling
