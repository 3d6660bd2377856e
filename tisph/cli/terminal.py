"""Standard output and error that take all text, and outlive who reads them: a closed pipe ends no command."""

import errno
import io
import os
import sys
from typing import Any, TextIO

NOBODY_READS = (errno.EPIPE, errno.EIO)
"""Errors of a closed pipe and of a terminal that is gone, as against a full disk: there somebody meant to keep it."""


class Lasting(io.RawIOBase):
    """Writes to what is below ``stream`` and drops what that does not take any more; ``lost`` is the first error."""

    def __init__(self, stream: Any):
        self._stream = stream  # without this it would be closed, and what is below with it
        self._raw = getattr(stream.buffer, "raw", stream.buffer)  # python -u has no buffer between
        self.lost: OSError | None = None

    def writable(self) -> bool:
        """Say that it can be written."""
        return True

    def fileno(self) -> int:
        """Return the descriptor below."""
        return self._raw.fileno()

    def isatty(self) -> bool:
        """Tell whether it is a terminal."""
        return self._raw.isatty()

    def write(self, data: Any) -> int | None:
        """Write or drop ``data``; return the number of bytes, None where a write would have to wait."""
        try:
            return self._raw.write(data)
        except OSError as error:
            self.lost = self.lost or error
            return memoryview(data).nbytes


def lasting(stream: TextIO | None) -> TextIO:
    """Return a text stream that writes to where ``stream`` does, as long as somebody takes it.

    Letters that its encoding does not have are escaped, as in ``\\u0142``. Each line is written at once.
    """
    if stream is None:  # it was closed from the start
        return open(os.devnull, "w", encoding="utf-8")
    stream.flush()
    shown = {"encoding": stream.encoding, "errors": "backslashreplace", "line_buffering": True}
    return io.TextIOWrapper(io.BufferedWriter(Lasting(stream)), write_through=stream.write_through, **shown)


def outlive_readers() -> None:
    """Make standard output and error lasting."""
    # Taichi takes a stdout other than __stdout__ for that of a notebook
    sys.stdout = sys.__stdout__ = lasting(sys.stdout)
    sys.stderr = sys.__stderr__ = lasting(sys.stderr)


def output_lost() -> OSError | None:
    """Return why standard output could not be written, None where it was, or where nobody was reading any more."""
    sys.stdout.flush()
    lost = getattr(getattr(sys.stdout.buffer, "raw", None), "lost", None)
    return None if lost is None or lost.errno in NOBODY_READS else lost
