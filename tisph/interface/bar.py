"""How far a run is, where somebody looks: a bar in a notebook or on a terminal, lines elsewhere."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from tisph.interface.process import Show


@contextmanager
def shown(wanted: bool) -> Iterator[Show]:
    """Yield a function that shows how far a run is; it does nothing unless that is ``wanted``."""
    if not wanted:
        yield lambda part, words: None
    elif _in_a_notebook():
        yield _notebook()
    elif sys.stderr.isatty():
        from tisph.report.terminal_bar import terminal_bar

        with terminal_bar() as bar:
            task = bar.add_task("", total=1.0, state="")
            yield lambda part, words: bar.update(task, completed=part, state=words.rpartition("  ")[0])
    else:
        yield lambda part, words: print(f"{part:4.0%}  {words}", file=sys.stderr, flush=True)


def _in_a_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and hasattr(shell, "kernel")


def _notebook() -> Show:
    from html import escape

    from IPython.display import HTML, display

    def element(part: float, words: str) -> HTML:
        return HTML(f'<progress value="{part:g}" style="width:16em"></progress> {part:.0%} {escape(words)}')

    handle = display(element(0.0, ""), display_id=True)
    return lambda part, words: handle.update(element(part, words))
