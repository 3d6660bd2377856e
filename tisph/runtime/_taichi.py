"""Taichi, or Quadrants, its maintained fork, where there is no Taichi: the package, its program, and its compile time.

The two differ in their names alone: everything that tisph uses has the same name and meaning in both.
"""

import functools
import importlib
import os
import time
from importlib import metadata
from importlib.util import find_spec
from typing import TYPE_CHECKING

from tisph.runtime import _cache  # noqa: F401 (it finds a folder for Taichi, too, before that is imported)

NAME = "taichi" if find_spec("taichi") else "quadrants"

PREFIX = {"taichi": "TI", "quadrants": "QD"}[NAME]
"""Of the environment variables that the package reads."""

os.environ.update(
    {
        f"ENABLE_{NAME.upper()}_HEADER_PRINT": "0",  # no banner
        f"{PREFIX}_ENABLE_TORCH": "0",  # no import of what happens to be installed
        f"{PREFIX}_ENABLE_PADDLE": "0",
        f"{PREFIX}_SKIP_VERSION_CHECK": "ON",  # no request to a server
    }
)

KNOWN = NAME == "taichi" and metadata.version(NAME) == "1.7.4"
"""Whether the package is the one whose inner parts this program knows (``_inner``)."""

if TYPE_CHECKING:
    from tisph.runtime import taichi_types as ti
else:
    ti = importlib.import_module(NAME)  # it reads the environment


def mark():
    """Let the program that was just started be known as one of this package."""
    ti.lang.impl.get_runtime().mark = object()


def program():
    """Return what tells the present program of this package from all others; None where there is none."""
    return getattr(ti.lang.impl.get_runtime(), "mark", None)


def foreign_program():
    """Tell whether there is a program that this package has not started."""
    runtime = vars(ti.lang.impl.get_runtime())
    running = runtime.get("prog", runtime.get("_prog"))  # the second is what Quadrants calls it
    return running is not None and program() is None


# two methods of kernels are timed; no part of the package is replaced for that
if NAME == "taichi":
    Kernel, _TRANSLATED = ti.lang.kernel_impl.Kernel, "compiled_kernels"
else:
    Kernel, _TRANSLATED = importlib.import_module("quadrants.lang.kernel").Kernel, "materialized_kernels"
_spent = 0.0
_timing = False
_unlaunched = set()


def compile_seconds():
    """Return the seconds that this process has spent so far on translating, compiling and first launching kernels."""
    return _spent


def _timed(method):
    """Return ``method``, whose time counts; not again where one kernel needs another, as the layout of fields does."""

    @functools.wraps(method)
    def timed(*args, **kwargs):
        global _spent, _timing
        if _timing:
            return method(*args, **kwargs)
        began, _timing = time.perf_counter(), True
        try:
            return method(*args, **kwargs)
        finally:
            _timing = False
            _spent += time.perf_counter() - began

    return timed


def time_kernels():
    """Time the translation of every kernel, and its first launch, in which its machine code is made."""
    translate, launch = Kernel.materialize, Kernel.launch_kernel
    translate_timed, launch_timed = _timed(translate), _timed(launch)

    def materialize(self, key, *args, **kwargs):
        if key in getattr(self, _TRANSLATED):
            return translate(self, key, *args, **kwargs)
        _unlaunched.add(self)
        return translate_timed(self, key, *args, **kwargs)

    def launch_kernel(self, *args, **kwargs):
        if self not in _unlaunched:
            return launch(self, *args, **kwargs)
        _unlaunched.discard(self)
        return launch_timed(self, *args, **kwargs)

    Kernel.materialize, Kernel.launch_kernel = materialize, launch_kernel
