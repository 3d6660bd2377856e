"""From errors to one message on standard error and an exit status."""

import functools
from collections.abc import Callable
from typing import Any

import typer

from tisph.errors import TisphError

INTERRUPTED = 130
"""Exit status of a process that ends by an interrupt, as shells report it."""


def reported(command: Callable[..., None]) -> Callable[..., None]:
    """Make a command end with its error's exit status and message instead of a traceback."""

    @functools.wraps(command)
    def wrapped(*arguments: Any, **options: Any) -> None:
        try:
            command(*arguments, **options)
        except TisphError as error:
            typer.echo(f"error: {error}", err=True)
            raise typer.Exit(error.exit_status) from None
        except KeyboardInterrupt:
            typer.echo("interrupted", err=True)
            raise typer.Exit(INTERRUPTED) from None

    return wrapped
