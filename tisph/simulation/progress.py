"""Progress: a bar with remaining time on a terminal, plain lines otherwise."""

import sys
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

REFRESH = 0.2
"""Seconds between two updates of the bar."""

LINES = 10
"""Plain lines over a whole run."""


class RunProgress:
    """Shows how far a run from ``start`` to ``end`` is, and its particle-steps per second."""

    def __init__(self, start, end, particles, unit):
        self.start = start
        self.end = end
        self.particles = particles
        self.unit = unit
        self.began = self.shown = time.perf_counter()
        self.first_step = None
        self.lines = 0
        self.bar = None
        if sys.stderr.isatty():
            self.bar = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TaskProgressColumn(),
                TextColumn("{task.fields[state]}"),
                TimeRemainingColumn(elapsed_when_finished=True),
                console=Console(stderr=True),
                refresh_per_second=5,
            )
            self.task = self.bar.add_task("running", total=1.0, state="")

    def __enter__(self):
        if self.bar:
            self.bar.start()
        return self

    def __exit__(self, *_):
        if self.bar:
            self.bar.stop()

    def update(self, now, steps):
        """Show simulated time ``now`` and ``steps`` if it is time to."""
        if self.first_step is None:
            self.first_step = steps
        wall = time.perf_counter()
        part = (now - self.start) / (self.end - self.start)
        if self.bar and (wall - self.shown > REFRESH or part >= 1.0):
            self.shown = wall
            self.bar.update(self.task, completed=part, state=self._state(now, steps, wall))
        elif not self.bar and int(part * LINES) > self.lines:
            self.lines = int(part * LINES)
            left = (wall - self.began) * (1.0 - part) / part
            print(
                f"{part:4.0%}  {self._state(now, steps, wall)}  {left:.0f} s left",
                file=sys.stderr,
                flush=True,
            )

    def _state(self, now, steps, wall):
        rate = (steps - self.first_step) * self.particles / max(wall - self.began, 1e-9)
        return f"t = {now:.4g} {self.unit}  step {steps}  {rate / 1e6:.2f} M particle-steps/s"
