"""One start of Taichi for many tests: a Scheme with the fields of the one before gets those, and kernels made for them.

A start costs 0.2 s here, and a scheme's kernels, found in the cache, another 0.3 to 0.9 s of machine code; the steps of
a test cost milliseconds. So while this is installed ``runtime.start`` keeps the program where precision, threads and
cache stay the same, and fields are handed out again, zeroed, as long as the same are asked for in the same order. Every
kernel is still read anew, from the objects of the new Scheme: Taichi itself finds whether it has it, as in the cache.
Where another field is asked for, before any kernel is launched, Taichi starts after all. Runs in processes of their own
start as users' do.
"""

import os

from taichi.lang.impl import get_runtime
from taichi.lang.kernel_impl import Kernel

from tisph import runtime
from tisph.runtime import _fields, ti

start, stop = runtime.start, runtime.stop
vector_field, scalar_field, launch = ti.Vector.field, ti.field, Kernel.launch_kernel


class Kept:
    """The program that runs, as ``asked``; ``made`` are its fields, with how they were asked for, ``used`` of them."""

    def __init__(self):
        self.program = self.asked = None
        self.made, self.used = [], 0
        self.launched = self.within = False

    def start(self, precision, threads):
        """Stand in for ``runtime.start``."""
        asked = precision, threads, runtime.CACHE, os.environ.get("TI_DEBUG")
        kept = self.program is not None and self.program is get_runtime().prog and get_runtime().materialized
        if not kept or asked != self.asked:
            start(precision, threads)
            self.program, self.asked, self.made = get_runtime().prog, asked, []
        for kernel in get_runtime().kernels:
            kernel.compiled_kernels = {}
            kernel.mapper.mapping.clear()
        _fields._waiting.clear()
        self.used, self.launched = 0, False

    def restart(self):
        """Start Taichi after all: the fields handed out so far become new ones."""
        waiting, handed = _fields._waiting.copy(), self.made[: self.used]
        written = [(field, runtime.view(field).copy()) for *_, field in handed if "_kept_view" in vars(field)]
        start(*self.asked[:2])
        self.program, self.made = get_runtime().prog, handed
        for make, arguments, field in handed:
            vars(field).update(vars(make(*arguments)))
        _fields._waiting.extend([*written, *waiting])

    def field(self, make, *arguments):
        """Return what ``make(*arguments)`` does, or the field that was made so in this place the last time."""
        if self.within or self.program is not get_runtime().prog:
            return make(*arguments)
        self.within = True
        try:
            if self.used < len(self.made):
                if alike((make, arguments), self.made[self.used][:2]):
                    self.used += 1
                    return self.zeroed(self.made[self.used - 1][2])
                if self.launched:
                    del self.made[self.used :]
                else:
                    self.restart()
            self.made.append((make, arguments, make(*arguments)))
            self.used += 1
            return self.made[-1][2]
        finally:
            self.within = False

    def zeroed(self, field):
        """Return a field as if it were new."""
        launched = self.launched
        runtime.view(field)[...] = 0
        self.launched = launched  # what finds the memory is no kernel that would be in the way of a start
        for said in vars(field).keys() & {"used", "_kept_view"}:
            del vars(field)[said]
        return field


def alike(one, other):
    """Whether two fields are asked for in the same words; vectors have types of their own, each time."""
    (make, (*kind, shape)), (other_make, (*other_kind, other_shape)) = one, other
    return make is other_make and shape == other_shape and list(map(name, kind)) == list(map(name, other_kind))


def name(kind):
    """What tells a type of numbers, or a length, from another."""
    return (kind.n, kind.dtype) if hasattr(kind, "n") else kind


kept = Kept()


def forget():
    """Let the next ``runtime.start`` be a start, for tests of what it leaves."""
    kept.program = None


def install():
    """Put this in the place of Taichi's own."""

    def launched(*arguments):
        kept.launched = True
        return launch(*arguments)

    runtime.start, runtime.stop = kept.start, lambda: None
    ti.field = lambda dtype, shape: kept.field(scalar_field, dtype, shape)
    ti.Vector.field = lambda n, dtype, shape: kept.field(vector_field, n, dtype, shape)
    Kernel.launch_kernel = launched


def uninstall():
    """Take it back, and write the compiled kernels to the cache."""
    runtime.start, runtime.stop = start, stop
    ti.field, ti.Vector.field, Kernel.launch_kernel = scalar_field, vector_field, launch
    stop()
