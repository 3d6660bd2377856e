"""Shared parts of all commands: output that cannot fail, options, and one message with an exit status for an error.

Standard output and error accept all text, also after their reader has ended: a closed pipe ends no command.
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

from tisph import events
from tisph.errors import INTERRUPTED, TisphError, ending_signals


@contextmanager
def _handled(handler: Callable[[int, Any], Any]) -> Iterator[None]:
    """Set the ``handler`` of all signals that end a run, and restore the previous handlers afterwards."""
    previous = {number: signal.signal(number, handler) for number in ending_signals()}
    try:
        yield
    finally:
        for number, old in previous.items():
            signal.signal(number, old)


def reported(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that ends with an error's status and message, without traceback; a signal interrupts it."""

    @functools.wraps(command)
    def wrapped(*arguments: Any, **options: Any) -> None:
        try:
            with _handled(signal.default_int_handler):
                command(*arguments, **options)
        except TisphError as error:
            events.error(str(error))
            raise typer.Exit(error.exit_status) from None
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            raise typer.Exit(INTERRUPTED) from None
        finally:
            # while Python exits, an interrupt could only change the status and show a traceback
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)

    return wrapped


@contextmanager
def held_back() -> Iterator[None]:
    """Delay an interrupt to the end of the context: imports may lose it or turn it into another error."""
    heard: list[int] = []
    with _handled(lambda number, _: heard.append(number)):
        yield
    if heard:
        raise KeyboardInterrupt


ConfigFile = Annotated[str, typer.Argument(metavar="CONFIG", help="YAML file that describes the run.")]

Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY.PATH=VALUE", help="Replace one value of the config; may be repeated."),
]


def out_folder(words: str) -> Any:
    """Return the option for the folder of results, whose help is ``words``."""
    return typer.Option("--out", metavar="DIR", parser=_folder_name, help=words)


def _folder_name(text: str) -> Path:
    """Return the folder with this name; an empty name, as of an unset variable of a shell, is an error."""
    if not text.strip():
        raise typer.BadParameter("the name is empty; give a folder (. is the current one)")
    return Path(text)


NOBODY_READS = (errno.EPIPE, errno.EIO)
"""Errors of a closed pipe and of a closed terminal; after other errors, such as a full disk, the command has failed."""


class Lasting(io.RawIOBase):
    """Writes to the raw stream below ``stream`` and drops data that it does not accept; ``lost``: first error."""

    def __init__(self, stream: Any):
        self._stream = stream  # otherwise the stream would be closed, and the raw stream with it
        self._raw = getattr(stream.buffer, "raw", stream.buffer)  # python -u has no buffer between
        self.lost: OSError | None = None

    def writable(self) -> bool:
        """Return that the stream can be written."""
        return True

    def fileno(self) -> int:
        """Return the descriptor of the raw stream."""
        return self._raw.fileno()

    def isatty(self) -> bool:
        """Return whether the raw stream is a terminal."""
        return self._raw.isatty()

    def write(self, data: Any) -> int | None:
        """Write or drop ``data``; return the number of bytes, None where a write would have to wait."""
        try:
            return self._raw.write(data)
        except OSError as error:
            self.lost = self.lost or error
            return memoryview(data).nbytes


def lasting(stream: Any) -> TextIO:
    """Return a text stream that writes to the file of the text ``stream`` (or None) as long as that accepts data.

    Letters that its encoding does not have are escaped, as in ``\\u0142``. Each line is written at once.
    """
    if stream is None:  # it was closed from the start
        return open(os.devnull, "w", encoding="utf-8")
    stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(Lasting(stream)),
        encoding=stream.encoding,
        errors="backslashreplace",
        line_buffering=True,
        write_through=stream.write_through,
    )


def outlive_readers() -> None:
    """Replace standard output and error by ``lasting`` streams."""
    # with a stdout other than __stdout__ Taichi would assume a notebook
    for name in ("stdout", "stderr"):
        stream = lasting(getattr(sys, name))
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def output_lost() -> OSError | None:
    """Return the error of writing standard output; None without one, or where its reader had ended."""
    sys.stdout.flush()
    lost: OSError | None = getattr(getattr(sys.stdout.buffer, "raw", None), "lost", None)
    return None if lost is None or lost.errno in NOBODY_READS else lost
