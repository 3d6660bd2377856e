"""How long translating, compiling and first launching kernels takes.

No part of Taichi is replaced for it: two methods of its kernels are timed.
"""

import functools
import time

from tisph.runtime._taichi import kernel_class

Kernel, _TRANSLATED = kernel_class()
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


def install():
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
