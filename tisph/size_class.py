"""Sizes of fields: a few for all runs, which so share compiled kernels."""

SMALL, MIDDLE, LARGE = 10_000, (24_000, 50_000), 100_000
STEP = 1.1
"""Size classes: a few for what runs in seconds, where compiling takes longest by comparison and memory is nothing, and
from ``LARGE`` on never more than this factor apart, where it is the other way round."""


def size_class(count: float) -> int:
    """Return the size of fields that are to hold ``count`` entries: the next larger size class.

    The size of a field is compiled into every kernel that reads it, ``count`` is not: runs of one class share kernels.
    """
    for size in (SMALL, *MIDDLE):
        if count <= size:
            return size
    size = LARGE
    while count > size:
        size = int(size * STEP)
    return size
