"""The progress bar of one run on a terminal: percentage, words and remaining time."""

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
