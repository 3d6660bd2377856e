"""Taichi, imported and initialised in one place.

Everything that needs Taichi imports ``ti`` from here, so that another compatible package can take its place
by changing one line, and so that its banner never reaches the user's terminal.
"""

import atexit
import contextlib
import inspect
import io
import linecache
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from types import ModuleType


def _cache_home():
    """Return a folder for compiled kernels: in the user's home, else one that lasts as long as this process."""
    try:
        folder = Path.home() / ".cache" / "tisph"
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except (OSError, RuntimeError):
        folder = Path(tempfile.mkdtemp(prefix="tisph-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        os.environ["XDG_CACHE_HOME"] = os.environ["MPLCONFIGDIR"] = str(folder)
    os.environ.setdefault("XDG_CACHE_HOME", str(folder.parent))
    return folder


CACHE = _cache_home()
"""Compiled kernels. Taichi has a folder of its own too, and ends the process where it cannot be written."""

CACHE_BYTES = 2**30
"""Room for compiled kernels in each of the two folders: a config needs 1 to 5 MB, and Taichi's 100 MB made a study of
some dozens compile everything again and again."""

WRITTEN_SECONDS = 60
"""After which nobody is writing to a cache any more; it takes one."""

os.environ.update(
    ENABLE_TAICHI_HEADER_PRINT="0",  # no banner
    TI_ENABLE_TORCH="0",  # no import of what happens to be installed
    TI_ENABLE_PADDLE="0",
)

_check = ModuleType("taichi._version_check")
_check.start_version_check_thread = lambda: None
sys.modules[_check.__name__] = _check
"""In its place: a request to a server, once a day, and the import of all that it takes."""


@contextlib.contextmanager
def _frames_in_short():
    """Let Taichi find in a moment the line that a frame is at, which it asks for at each function that it decorates.

    ``inspect`` looks through all modules for it, which is a third of the time that importing Taichi takes.
    """

    def in_short(frame, context=1):
        file, line = frame.f_code.co_filename, frame.f_lineno
        return inspect.Traceback(file, line, frame.f_code.co_name, [linecache.getline(file, line)], 0)

    whole, inspect.getframeinfo = inspect.getframeinfo, in_short
    try:
        yield
    finally:
        inspect.getframeinfo = whole


with _frames_in_short():
    import taichi as ti  # it reads the environment while it is imported

    from tisph.runtime import _fields, _launching, _loops, _reading

from tisph.config.memory import size_class  # noqa: E402 (what follows imports Taichi)
from tisph.runtime._fields import holding, integer, real, scalar, view  # noqa: E402
from tisph.runtime._loops import unrolled  # noqa: E402
from tisph.runtime._reading import compile_seconds  # noqa: E402

_fields.install()
_launching.install()
_loops.install()
_reading.install()

__all__ = [
    "available_threads",
    "compile_seconds",
    "holding",
    "integer",
    "real",
    "scalar",
    "size_class",
    "start",
    "stop",
    "threads",
    "ti",
    "unrolled",
    "view",
]


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
    others = _thread_ids()
    _fields.forget()
    os.environ.pop("TI_ARCH", None)  # a run depends on its config alone
    cache = CACHE / ("serial" if threads == 1 else "parallel")
    _unlock(cache)
    with contextlib.redirect_stdout(io.StringIO()):
        ti.init(
            offline_cache=True,
            offline_cache_file_path=str(cache),
            offline_cache_max_size_of_files=CACHE_BYTES,
            arch=ti.cpu,
            default_fp=ti.f64 if precision == "f64" else ti.f32,
            cpu_max_num_threads=threads,
            fast_math=False,
            log_level=ti.ERROR,
        )
    _loops.forbid_longer_turns()
    _share_processors(sorted(_thread_ids() - others), threads)


def _unlock(cache):
    """Let kernels be added to a cache again that a process was killed in while it wrote there.

    Taichi 1.7.4 leaves them out for as long as the lock file is there, and says so only to those who let it warn:
    every process compiles anew what came later, and waits 0.4 s for the lock before it ends.
    """
    lock = cache / "ticache.lock"
    with contextlib.suppress(OSError):
        if time.time() - lock.stat().st_mtime > WRITTEN_SECONDS:
            lock.unlink()


def threads():
    """Return the number of threads among which Taichi shares a loop, as given at the start."""
    return ti.lang.impl.current_cfg().cpu_max_num_threads


def stop():
    """Write the compiled kernels to the cache and give all fields back.

    Taichi would do so when its last object dies, which a process that ends in a hurry does not wait for.
    """
    ti.reset()


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
    with contextlib.suppress(OSError):  # a container may forbid it, and a thread may have ended
        for index, thread in enumerate(new_threads):
            os.sched_setaffinity(thread, processors[index % count :: count])
