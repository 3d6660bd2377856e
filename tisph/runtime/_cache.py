"""The folder of compiled kernels."""

import atexit
import contextlib
import os
import shutil
import tempfile
import time
from pathlib import Path

CACHE_BYTES = 2**30
"""Room for compiled kernels in each of the two folders: a config needs 1 to 5 MB, and Taichi's 100 MB made a study of
some dozens compile everything again and again."""

GENERATION = "2"
"""Folder of the kernels within that: another one with each option of ``ti.init`` that Taichi 1.7.4 leaves out of the
key by which it finds a kernel again, as it does ``cache_loop_invariant_global_vars``."""

LOCKS = "ticache.lock", "qdcache.lock"
"""Of Taichi and of Quadrants: who finds its own adds nothing to the cache."""

WRITTEN_SECONDS = 60
"""After which nobody is writing to a cache any more; it takes one."""


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


def unlock(cache):
    """Let kernels be added to a cache again that a process was killed in while it wrote there.

    Taichi 1.7.4 leaves them out for as long as the lock file is there, and says so only to those who let it warn:
    every process compiles anew what came later, and waits 0.4 s for the lock before it ends.
    """
    for name in LOCKS:
        lock = cache / name
        with contextlib.suppress(OSError):
            if time.time() - lock.stat().st_mtime > WRITTEN_SECONDS:
                lock.unlink()
