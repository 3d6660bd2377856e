"""The engine of everything that runs many configs: processes, kept runs, a bar on a terminal.

Sweeps, the stability matrix and the comparison of wall treatments give it configs by name. A run that has ended once,
with this config and this code, is not run again: an interrupted command goes on where it was.
"""

import math
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

from tisph.report.terminal_bar import study_bar
from tisph.studies.store import Outcome, Store

START_SECONDS = 2.0
"""Rough time of a run besides its steps, for the time that is left."""

PATIENCE, ALLOWANCE = 10.0, 600.0
"""A limited run is ended after that many times its estimated time, and that many seconds besides: machines pause."""


class Engine:
    """Runs configs, ``processes`` at a time, and keeps the runs in a ``Store``.

    ``seconds``: estimated time of each run, by name, for the bar. A context, in which the bar shows on standard error
    where that is a terminal.
    """

    def __init__(self, store: Store, processes: int, seconds: dict[str, float]):
        self._store, self._processes = store, processes
        self._began = time.perf_counter()
        self._seconds = {name: estimate + START_SECONDS for name, estimate in seconds.items()}
        self._running, self._ended, self._done = [], 0, 0.0
        self._bar = study_bar()
        self._task = self._bar.add_task("", total=sum(self._seconds.values()))

    def __enter__(self):
        self._bar.start()
        return self

    def __exit__(self, *_):
        self._bar.stop()

    def outcomes(
        self, configs: dict[str, dict[str, Any]], limited: bool = False, source: Iterator[Outcome] | None = None
    ) -> Iterator[Outcome]:
        """Yield (name, ``Result``, message) of the runs of ``configs``, by name: first of those that are kept.

        ``limited``: runs are ended that take much longer than estimated. ``source``: where outcomes come from, if not
        from processes on this machine.
        """

        def launch(name):
            self._running.append(name)
            self._show()
            limit = PATIENCE * self._seconds[name] + ALLOWANCE if limited else math.inf
            return self._store.launch(name, configs[name], limit)

        with closing(source or self._store.outcomes(configs, self._processes, launch)) as ended:
            for name, result, message in ended:
                self._running = [each for each in self._running if each != name]
                self._ended += 1
                self._done += self._seconds[name]
                self._bar.update(self._task, completed=self._done)
                self._show()
                yield name, result, message

    def say(self, text: str) -> None:
        """Print a line of the result, out of the way of the bar."""
        self._bar.stop()  # while it shows, the two would write into one another
        print(text, flush=True)
        self._bar.start()

    @property
    def seconds_left(self) -> float:
        """Time for the runs that have not ended, if they take as much over their estimates as the earlier ones."""
        return (time.perf_counter() - self._began) * (sum(self._seconds.values()) / max(self._done, 1e-9) - 1.0)

    def _show(self):
        text = "; ".join([f"{self._ended} of {len(self._seconds)} runs", *self._running])
        self._bar.update(self._task, description=text)
