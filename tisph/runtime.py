"""Taichi, imported and initialised in one place.

Everything that needs Taichi imports ``ti`` from here, so that another compatible package can take its place
by changing one line, and so that its banner never reaches the user's terminal.
"""

import contextlib
import io
import os
from pathlib import Path

os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")

import taichi as ti

__all__ = ["available_threads", "real", "scalar", "start", "ti"]


def available_threads():
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def start(precision, threads):
    """Initialise Taichi on the CPU; fields made earlier are gone.

    ``precision`` is "f64" or "f32". Without ``fast_math``: it re-associates sums and folds away NaN tests.
    Compiled kernels are kept apart for one thread and for several, because Taichi 1.7.4 takes a loop compiled
    with ``serialize`` for the same as one without, and would run it on one thread ever after.
    """
    cache = _cache_folder("serial" if threads == 1 else "parallel")
    others = _thread_ids()
    with contextlib.redirect_stdout(io.StringIO()):
        ti.init(
            offline_cache=cache is not None,
            offline_cache_file_path=cache or "",
            arch=ti.cpu,
            default_fp=ti.f64 if precision == "f64" else ti.f32,
            cpu_max_num_threads=threads,
            fast_math=False,
            log_level=ti.ERROR,
        )
    _share_processors(sorted(_thread_ids() - others), threads)


def _cache_folder(kind):
    """Return the folder of compiled kernels, None where the user has none that can be written."""
    try:
        folder = Path.home() / ".cache" / "tisph" / kind
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return str(folder) if os.access(folder, os.W_OK) else None


def _thread_ids():
    """Return the system's numbers of this process' threads where it tells them (Linux), else none."""
    folder = Path("/proc/self/task")
    return {int(entry.name) for entry in folder.iterdir()} if folder.exists() else set()


def _share_processors(new_threads, count):
    """Let no two of the ``count`` loop threads meet on one processor, each having a share of them all.

    Loops last half a millisecond here. Linux often wakes the threads of such a loop on one processor, where
    they run one after the other, and moves them apart too late: without this two threads of a 5000 particle
    run were a third slower. Loop threads are numbered one after another, whatever else is among the new ones.
    """
    if count == 1 or not hasattr(os, "sched_setaffinity"):
        return
    processors = sorted(os.sched_getaffinity(0))
    if len(processors) < count:
        return
    for index, thread in enumerate(new_threads):
        os.sched_setaffinity(thread, processors[index % count :: count])


def real():
    """Return the floating-point type chosen at the start."""
    return ti.lang.impl.get_runtime().default_fp


def scalar(value):
    """Return a 0-D field holding ``value``: a number that kernels read but that is not compiled in."""
    field = ti.field(real(), shape=())
    field[None] = value
    return field
