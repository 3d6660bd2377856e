"""What all commands share: lasting output, shared options, and one message with an exit status for an error.

Standard output and error take all text, and outlive who reads them: a closed pipe ends no command.
"""

import atexit
import errno
import functools
import io
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from tisph.errors import INTERRUPTED, TisphError, ending_signals


def reported(command: Callable[..., None]) -> Callable[..., None]:
    """Make a command end with its error's status and message instead of a traceback; an ending signal interrupts it."""

    @functools.wraps(command)
    def wrapped(*arguments: Any, **options: Any) -> None:
        previous = {number: signal.signal(number, signal.default_int_handler) for number in ending_signals()}
        try:
            command(*arguments, **options)
        except TisphError as error:
            print(f"error: {error}", file=sys.stderr)
            raise typer.Exit(error.exit_status) from None
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            raise typer.Exit(INTERRUPTED) from None
        finally:
            for number, handler in previous.items():
                signal.signal(number, handler)
            # once Python clears up, an interrupt could only spoil the status and show a traceback
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)

    return wrapped


@contextmanager
def held_back() -> Iterator[None]:
    """Let an interrupt wait for what is done inside: imports, which may lose it or turn it into another error."""
    heard: list[int] = []
    previous = {number: signal.signal(number, lambda number, _: heard.append(number)) for number in ending_signals()}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
    if heard:
        raise KeyboardInterrupt


ConfigFile = Annotated[str, typer.Argument(metavar="CONFIG", help="YAML file that describes the run.")]

Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY.PATH=VALUE", help="Replace one value of the config; may be repeated."),
]


def out_folder(words: str) -> Any:
    """Return the option of the folder of results, whose help is ``words``."""
    return typer.Option("--out", metavar="DIR", parser=folder_name, help=words)


def folder_name(text: str) -> Path:
    """Parse the name of a folder; an empty one, as of an unset variable of a shell, is not the current folder."""
    if not text.strip():
        raise typer.BadParameter("the name is empty; give a folder (. is the current one)")
    return Path(text)


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
