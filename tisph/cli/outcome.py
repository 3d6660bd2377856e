"""From errors to one message on standard error and an exit status."""

import atexit
import functools
import signal
from collections.abc import Callable
from typing import Any

import typer

from tisph.errors import TisphError

INTERRUPTED = 130
"""Exit status of a process that ends by an interrupt, as shells report it."""


def reported(command: Callable[..., None]) -> Callable[..., None]:
    """Make a command end with its error's status and message instead of a traceback; a termination interrupts it."""

    @functools.wraps(command)
    def wrapped(*arguments: Any, **options: Any) -> None:
        previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            command(*arguments, **options)
        except TisphError as error:
            typer.echo(f"error: {error}", err=True)
            raise typer.Exit(error.exit_status) from None
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None
        finally:
            signal.signal(signal.SIGTERM, previous)
            # once Python clears up, an interrupt could only spoil the status and show a traceback
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)

    return wrapped
