"""One start of Taichi for many tests: a Scheme with the fields of an earlier one gets those, and kernels made for them.

A start costs 0.2 s here, and a scheme's kernels, found in the cache, another 0.5 to 5 s of machine code; the steps of
a test cost milliseconds. So while this is installed ``runtime.start`` keeps the program where precision, threads and
cache stay the same, and fields are handed out again, zeroed, as long as they are asked for in an order in which some
test did so before; from then on there are new ones. Every kernel is still read anew, from the objects of the new
Scheme: Taichi itself finds whether it has it, as in the cache. Runs in processes of their own start as users' do.

It saves most of the time of ``make test``. Quadrants, and another version of Taichi, have other inner parts: every test
starts it anew there, which shows that nothing here hides a fault.
"""

import os

from tisph import runtime
from tisph.runtime import _taichi, ti

PLAIN = not _taichi.KNOWN

if not PLAIN:
    import fast_translation
    import shared_kernels
    from taichi.lang.impl import get_runtime

    from tisph.runtime import _inner

start, stop = runtime.start, runtime.stop
vector_field, scalar_field = ti.Vector.field, ti.field

MOST_TREES = 400
"""That fields are laid out in before Taichi starts again; a program has room for 512."""


class Made:
    """A field, with how it was asked for, and those that were asked for next."""

    def __init__(self, asked=None, field=None):
        self.asked, self.field, self.following = asked, field, []

    def next(self, make, arguments):
        """Return what followed when ``make(*arguments)`` was asked for after this; None where that was never."""
        return next((made for made in self.following if alike((make, arguments), made.asked)), None)


class Kept:
    """The program that runs, as ``asked``; ``first`` is before all its fields, ``last`` what was handed out last.

    ``starts`` counts what was taken for a start, and the end of all: what was built before has lost its fields.
    """

    def __init__(self):
        self.program = self.asked = self.first = self.last = None
        self.within, self.starts = False, 0

    def start(self, precision, threads):
        """Stand in for ``runtime.start``."""
        self.starts += 1
        asked = precision, threads, runtime.CACHE, os.environ.get("TI_DEBUG")
        kept = self.program is not None and self.program is get_runtime().prog and get_runtime().materialized
        if not kept or asked != self.asked or self.program.get_snode_tree_size() > MOST_TREES:
            start(precision, threads)
            shared_kernels.known.clear()
            self.program, self.asked, self.first = get_runtime().prog, asked, Made()
        for kernel in get_runtime().kernels:
            kernel.compiled_kernels = {}
            kernel.mapper.mapping.clear()
        _inner._waiting.clear()
        self.last = self.first

    def field(self, make, *arguments):
        """Return what ``make(*arguments)`` does, or the field that was made so in this place before."""
        if self.within or self.program is not get_runtime().prog:
            return make(*arguments)
        self.within = True
        try:
            found = self.last.next(make, arguments)
            if found is None:
                found = Made((make, arguments), make(*arguments))
                self.last.following.append(found)
            else:
                zero(found.field)
            self.last = found
            return found.field
        finally:
            self.within = False


def zero(field):
    """Leave a field as if it were new."""
    runtime.view(field)[...] = 0
    vars(field).pop("used", None)
    vars(field).pop("_kept_view")  # as of a new field, whose first view lets fields have their first values


def alike(one, other):
    """Whether two fields are asked for in the same words; vectors have types of their own, each time."""
    (make, (*kind, shape)), (other_make, (*other_kind, other_shape)) = one, other
    return make is other_make and shape == other_shape and list(map(name, kind)) == list(map(name, other_kind))


def name(kind):
    """What tells a type of numbers, or a length, from another."""
    return (kind.n, kind.dtype) if hasattr(kind, "n") else kind


kept = Kept()


def started_anew(precision, threads):
    """Start, and count it."""
    kept.starts += 1
    start(precision, threads)


def stopped():
    """Stop, and count it: what was built before has lost its fields."""
    kept.starts += 1
    stop()


def forget():
    """Let the next ``runtime.start`` be a start, for tests of what it leaves."""
    kept.program = None


def install():
    """Put this in the place of Taichi's own; where that is plain, starts are counted alone."""
    if PLAIN:
        runtime.start, runtime.stop = started_anew, stopped
        return
    runtime.start, runtime.stop = kept.start, lambda: None
    fast_translation.install()
    shared_kernels.install()
    ti.field = lambda dtype, shape: kept.field(scalar_field, dtype, shape)
    ti.Vector.field = lambda n, dtype, shape: kept.field(vector_field, n, dtype, shape)


def uninstall():
    """Take it back, and write the compiled kernels to the cache."""
    runtime.start, runtime.stop = start, stop
    if not PLAIN:
        shared_kernels.uninstall()
    ti.field, ti.Vector.field = scalar_field, vector_field
    kept.starts += 1
    stop()
