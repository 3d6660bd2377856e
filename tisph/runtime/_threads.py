"""Threads of loops, and the processors that they run on."""

import contextlib
import os
from pathlib import Path

CHUNK = 512
"""Taichi gives a thread at least this many iterations of a parallel loop."""


def available_threads():
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def processors_shared(count):
    """Let no two of the ``count`` loop threads that start meanwhile meet on one processor, each having a share of them.

    Loops last half a millisecond here. Linux often wakes the threads of such a loop on one processor, where
    they run one after the other, and moves them apart too late: without this two threads of a 5000 particle
    run were a third slower. Loop threads are numbered one after another, whatever else is among the new ones.
    """
    others = _thread_ids()
    yield
    if count == 1 or not hasattr(os, "sched_setaffinity"):
        return
    processors = sorted(os.sched_getaffinity(0))
    if len(processors) < count:
        return
    with contextlib.suppress(OSError):  # a container may forbid it, and a thread may have ended
        for index, thread in enumerate(sorted(_thread_ids() - others)):
            os.sched_setaffinity(thread, processors[index % count :: count])


def _thread_ids():
    """Return the system's numbers of this process' threads where it tells them (Linux), else none."""
    folder = Path("/proc/self/task")
    return {int(entry.name) for entry in folder.iterdir()} if folder.exists() else set()
