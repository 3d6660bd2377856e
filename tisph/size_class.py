"""Sizes of fields: few sizes for all runs, so that runs share compiled kernels."""

SMALL, MIDDLE, LARGE = 10_000, (24_000, 50_000), 100_000
STEP = 1.1
"""Size classes. Runs of few particles take seconds, mostly for compiling, and little memory: there are three sizes for
them. From ``LARGE`` on memory counts more, and classes differ by no more than the factor ``STEP``."""


def size_class(count: float) -> int:
    """Return the size of fields for ``count`` entries: the next larger size class.

    The size of a field is compiled into every kernel that reads it, ``count`` is not: runs of one class share kernels.
    """
    for size in (SMALL, *MIDDLE):
        if count <= size:
            return size
    size = LARGE
    while count > size:
        size = int(size * STEP)
    return size
