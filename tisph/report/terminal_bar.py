"""Bars on a terminal: of one run, with percentage, words and remaining time, and of the many runs of a study."""

import sys

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn


def terminal_bar() -> Progress:
    """Return a bar on standard error, whose tasks have a field ``state``."""
    return Progress(
        BarColumn(bar_width=None),  # the only one that shrinks where columns are few
        TaskProgressColumn(),
        TextColumn("{task.fields[state]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
        console=Console(stderr=True),
        refresh_per_second=5,
    )


def study_bar() -> Progress:
    """Return a bar on standard error whose tasks have a ``description``; nothing where that is no terminal."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        redirect_stdout=False,
        speed_estimate_period=3600.0,
        disable=not sys.stderr.isatty(),
    )
