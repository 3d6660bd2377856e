"""What the parts of a run cost, in seconds of the clock."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from tisph import runtime


class Costs:
    """The ``seconds`` of a run by kind, and when it ``began``.

    Kinds are imports, compiling kernels, the loop over the steps, and output.
    """

    def __init__(self) -> None:
        self.began = time.perf_counter()
        self.seconds = {"import": 0.0, "compile": 0.0, "loop": 0.0, "output": 0.0}

    @contextmanager
    def timed(self, kind: str) -> Iterator[None]:
        """Add the seconds that this takes to those of a ``kind``, but for those of compiling kernels."""
        began, compiled = time.perf_counter(), runtime.compile_seconds()
        try:
            yield
        finally:
            compiling = runtime.compile_seconds() - compiled  # at the first launch of a kernel, wherever that is
            self.seconds["compile"] += compiling
            self.seconds[kind] += time.perf_counter() - began - compiling
