"""Taichi, or Quadrants, its maintained fork: the package, the folder of compiled kernels, and the time of compilation.

Quadrants takes the place of Taichi where that has no wheels. The two differ in their names alone: everything that
tisph uses has the same name and meaning in both.
"""

import atexit
import contextlib
import functools
import importlib
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

CACHE_BYTES = 2**30
"""Size limit of each of the two folders of compiled kernels. A config needs 1 to 5 MB; with Taichi's default of 100 MB
a study of some dozens of configs compiled everything again and again."""

GENERATION = "2"
"""Subfolder of the kernels. It has to change with each option of ``ti.init`` that Taichi 1.7.4 leaves out of the key of
a kernel in the cache, such as ``cache_loop_invariant_global_vars``."""

LOCKS = "ticache.lock", "qdcache.lock"
"""Lock files of Taichi and of Quadrants. A process that finds its lock file adds nothing to the cache."""

WRITTEN_SECONDS = 60
"""Age of a lock file above which its process has ended; writing the kernels takes one second."""


def _cache_home() -> Path:
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
"""Folder of compiled kernels. Taichi also has a folder of its own, and ends the process where it cannot write there:
this one has to be found before Taichi is imported."""


def unlock(cache: Path) -> None:
    """Remove the lock files that killed processes have left in the folder ``cache``.

    As long as such a file is there, Taichi 1.7.4 adds no kernel to the cache, and does not warn unless its log level
    allows it: every process compiles the missing kernels anew, and waits 0.4 s for the lock before it ends.
    """
    for name in LOCKS:
        lock = cache / name
        with contextlib.suppress(OSError):
            if time.time() - lock.stat().st_mtime > WRITTEN_SECONDS:
                lock.unlink()


NAME = "taichi" if find_spec("taichi") else "quadrants"

PREFIX = {"taichi": "TI", "quadrants": "QD"}[NAME]
"""Prefix of the environment variables that the package reads."""

os.environ.update(
    {
        f"ENABLE_{NAME.upper()}_HEADER_PRINT": "0",  # no banner
        f"{PREFIX}_ENABLE_TORCH": "0",  # no import of other installed packages
        f"{PREFIX}_ENABLE_PADDLE": "0",
        f"{PREFIX}_SKIP_VERSION_CHECK": "ON",  # no request to a server
    }
)

KNOWN = NAME == "taichi" and metadata.version(NAME) == "1.7.4"
"""Whether the package is the one whose inner parts ``_inner`` replaces."""

if TYPE_CHECKING:
    from tisph.runtime import taichi_types as ti
else:
    ti = importlib.import_module(NAME)  # it reads the environment


def mark() -> None:
    """Mark the Taichi program that was just started as one of tisph."""
    ti.lang.impl.get_runtime().mark = object()


def program() -> object | None:
    """Return the mark of the present Taichi program, different for each program; None where tisph has none."""
    return getattr(ti.lang.impl.get_runtime(), "mark", None)


def foreign_program() -> bool:
    """Return whether there is a Taichi program that tisph has not started."""
    runtime = vars(ti.lang.impl.get_runtime())
    running = runtime.get("prog", runtime.get("_prog"))  # the second name is that in Quadrants
    return running is not None and program() is None


# two methods of kernels are timed; no part of the package is replaced for that
if NAME == "taichi":
    Kernel, _TRANSLATED = ti.lang.kernel_impl.Kernel, "compiled_kernels"
else:
    Kernel, _TRANSLATED = importlib.import_module("quadrants.lang.kernel").Kernel, "materialized_kernels"
_spent = np.zeros(2)
_timing = False
_unlaunched: set[Any] = set()


def clocks() -> np.ndarray:
    """Return the seconds (2,) of the clock, and of processor time of this process, each from an origin of its own."""
    return np.array([time.perf_counter(), time.process_time()])


def compile_seconds() -> np.ndarray:
    """Return the ``clocks`` that have passed in translating, compiling and first launching kernels so far."""
    return _spent


def _timed(method: Callable[..., Any]) -> Callable[..., Any]:
    """Return ``method`` with its time counted, but not within another timed call: the layout of fields has kernels."""

    @functools.wraps(method)
    def timed(*args: Any, **kwargs: Any) -> Any:
        global _spent, _timing
        if _timing:
            return method(*args, **kwargs)
        began, _timing = clocks(), True
        try:
            return method(*args, **kwargs)
        finally:
            _timing = False
            _spent = _spent + clocks() - began

    return timed


def time_kernels() -> None:
    """Time the translation of every kernel and its first launch, which makes the machine code."""
    translate, launch = Kernel.materialize, Kernel.launch_kernel
    translate_timed, launch_timed = _timed(translate), _timed(launch)

    def materialize(self: Any, key: Any, *args: Any, **kwargs: Any) -> Any:
        if key in getattr(self, _TRANSLATED):
            return translate(self, key, *args, **kwargs)
        _unlaunched.add(self)
        return translate_timed(self, key, *args, **kwargs)

    def launch_kernel(self: Any, *args: Any, **kwargs: Any) -> Any:
        if self not in _unlaunched:
            return launch(self, *args, **kwargs)
        _unlaunched.discard(self)
        return launch_timed(self, *args, **kwargs)

    Kernel.materialize, Kernel.launch_kernel = materialize, launch_kernel
