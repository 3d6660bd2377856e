"""What a run needs of its process: Taichi for itself, signals, ``run.log``, and the cost of its parts.

Taichi has one program: there is one simulation at a time in a process, and whoever starts another destroys its fields.
"""

import logging
import signal
import sys
import threading
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from tisph import runtime
from tisph.errors import TisphError, ending_signals

INSTEAD = "tisph.run has a process of its own for each run"

_open = None


def claim(simulation):
    """Let ``simulation`` have Taichi; TisphError where another simulation, or a program of somebody else, has it.

    A simulation that is finished, or that nobody holds any more, gives way; the finished one keeps its last state.
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


def require(simulation):
    """Raise TisphError where there is nothing left of ``simulation`` to step."""
    if simulation.scheme is None:
        raise TisphError("the simulation is closed; its last state is all that is left of it")
    if runtime.program() is not simulation.program:
        raise TisphError("the fields of this simulation are gone: ti.init or ti.reset was called since it began")


def release(simulation):
    """Give Taichi back, if it is that of ``simulation``."""
    global _open
    if _open is not None and _open() is simulation:
        _open = None
        if not runtime.foreign_program():
            runtime.stop()


class Interrupts:
    """Their ``count``; with ``wait`` there is a state to go on from which is not written yet."""

    def __init__(self, wait=False):
        self.count, self.wait = 0, wait

    @contextmanager
    def counted(self):
        """Let any of the ``ending_signals`` be counted, for a run that ends after its step; a second one stops it.

        Where there is a state to go on from, that is after the step, the checkpoint and the summary.
        """

        def handle(number, frame):
            self.count += 1
            if self.count > 1 and not self.wait:
                raise KeyboardInterrupt

        def unraisable(failure):
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
def interrupts_after():
    """Let Ctrl-C, which may come at any time in a notebook, take effect after what is done inside."""
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler) or threading.current_thread() is not threading.main_thread():
        yield
        return
    heard = []
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


@contextmanager
def logging_to(path, append):
    """Write what is logged meanwhile to ``path``, and the error that ends it, if any."""
    handler = logging.FileHandler(path, mode="a" if append else "w", encoding="utf-8")
    handler.handleError = lambda record: None  # a full disk: the results have errors of their own
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
    """The ``seconds`` of a run by kind, and when it ``began``.

    Kinds are imports, compiling kernels, the loop over the steps, and output.
    """

    def __init__(self) -> None:
        self.began = time.perf_counter()
        self.seconds = {"import": 0.0, "compile": 0.0, "loop": 0.0, "output": 0.0}

    @contextmanager
    def timed(self, kind: str) -> Iterator[None]:
        """Add the seconds that this takes to those of a ``kind``, but for those of compiling kernels."""
        began, compiled = time.perf_counter(), runtime.compile_seconds()
        try:
            yield
        finally:
            compiling = runtime.compile_seconds() - compiled  # at the first launch of a kernel, wherever that is
            self.seconds["compile"] += compiling
            self.seconds[kind] += time.perf_counter() - began - compiling
