"""Taichi, imported and initialised in one place, and the threads of its loops.

Everything that needs Taichi imports ``ti`` from here, whether that is Taichi or Quadrants (``_taichi``). Of Taichi
1.7.4 four inner parts are replaced by faster ones (``_inner``): runs take less time, with bitwise the same results.
"""

import contextlib
import io
import os
from collections.abc import Iterator
from pathlib import Path

from tisph.runtime import _fields, _taichi
from tisph.runtime._fields import holding, integer, real, scalar, unrolled, view
from tisph.runtime._taichi import (
    CACHE,
    CACHE_BYTES,
    GENERATION,
    WRITTEN_SECONDS,
    clocks,
    compile_seconds,
    foreign_program,
    program,
    ti,
    unlock,
)

_taichi.time_kernels()
if _taichi.KNOWN:
    from tisph.runtime import _inner

    _inner.install()

__all__ = [
    "CACHE",
    "CHUNK",
    "PACKAGE",
    "WRITTEN_SECONDS",
    "available_threads",
    "clocks",
    "compile_seconds",
    "foreign_program",
    "holding",
    "integer",
    "program",
    "real",
    "scalar",
    "start",
    "stop",
    "threads",
    "ti",
    "unrolled",
    "view",
]

PACKAGE = _taichi.NAME
"""Name of the package that ``ti`` is; a summary has its version."""

CHUNK = 512
"""Least number of iterations of a parallel loop that Taichi gives a thread."""

_threads = 1


def start(precision: str, threads: int) -> None:
    """Initialise Taichi on the CPU; fields made earlier are gone.

    ``precision`` is "f64" or "f32". Without ``fast_math``: it re-associates sums and folds away NaN tests.
    Compiled kernels are kept apart for one thread and for several, because Taichi 1.7.4 takes a loop compiled
    with ``serialize`` for the same as one without, and would run it on one thread ever after. Without
    ``cache_loop_invariant_global_vars``: it reads a[0] before an inner loop that writes a[i], where it runs serially.
    """
    global _threads
    os.environ.pop(f"{_taichi.PREFIX}_ARCH", None)  # a run depends on its config alone
    cache = CACHE / GENERATION / ("serial" if threads == 1 else "parallel")
    unlock(cache)
    with _processors_shared(threads), contextlib.redirect_stdout(io.StringIO()):
        ti.init(
            offline_cache=True,
            offline_cache_file_path=str(cache),
            offline_cache_max_size_of_files=CACHE_BYTES,
            arch=ti.cpu,
            default_fp=ti.f64 if precision == "f64" else ti.f32,
            cpu_max_num_threads=threads,
            fast_math=False,
            cache_loop_invariant_global_vars=False,
            log_level=ti.ERROR,
        )
    _fields.begin(precision)
    if _taichi.KNOWN:
        _inner.begin()
    _taichi.mark()
    _threads = threads


def threads() -> int:
    """Return the number of threads among which Taichi shares a loop, as given at the start."""
    return _threads


def stop() -> None:
    """Write the compiled kernels to the cache and free all fields.

    Taichi would do so when its last object is deleted, for which a process that ends early does not wait.
    """
    ti.reset()


def available_threads() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextlib.contextmanager
def _processors_shared(count: int) -> Iterator[None]:
    """Share the processors among the ``count`` loop threads that start meanwhile, so that no two use the same one.

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


def _thread_ids() -> set[int]:
    """Return the system's numbers of this process' threads on Linux, an empty set elsewhere."""
    folder = Path("/proc/self/task")
    return {int(entry.name) for entry in folder.iterdir()} if folder.exists() else set()
