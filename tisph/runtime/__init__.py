"""Taichi, imported and initialised in one place.

Everything that needs Taichi imports ``ti`` from here, and does not know whether that is Taichi or Quadrants, its
maintained fork, which takes its place where Taichi has no wheels (``_taichi``). Of Taichi 1.7.4 three inner parts are
replaced by faster ones (``_inner``), which changes how long a run takes and no bit of its results.
"""

import contextlib
import io
import os

from tisph.runtime import _fields, _taichi
from tisph.runtime._cache import CACHE, CACHE_BYTES, GENERATION, WRITTEN_SECONDS, unlock
from tisph.runtime._fields import holding, integer, real, scalar, unrolled, view
from tisph.runtime._taichi import compile_seconds, foreign_program, program, ti
from tisph.runtime._threads import CHUNK, available_threads, processors_shared

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
"""Name of the package that ``ti`` is, of which a summary gives the version."""

_threads = 1


def start(precision, threads):
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
    with processors_shared(threads), contextlib.redirect_stdout(io.StringIO()):
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


def threads():
    """Return the number of threads among which Taichi shares a loop, as given at the start."""
    return _threads


def stop():
    """Write the compiled kernels to the cache and give all fields back.

    Taichi would do so when its last object dies, which a process that ends in a hurry does not wait for.
    """
    ti.reset()
