"""From errors to one message on standard error and an exit status."""

import atexit
import functools
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import typer

from tisph.errors import INTERRUPTED, TisphError
from tisph.signals import ending_signals


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
