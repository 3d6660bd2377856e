"""``tisph run``: a simulation to its end, with the observers that write the folder of results.

Progress is a bar with the remaining time on a terminal, plain lines otherwise.
"""

import math
import sys
import time
from collections.abc import Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from tisph import events, version
from tisph.config import Config
from tisph.errors import DivergedError, TisphError
from tisph.folder import Folder
from tisph.observers.protocol import LastStep, StateObserver
from tisph.report import drawing_process
from tisph.simulation.first_run import FirstRun
from tisph.simulation.process import Interrupts, logging_to
from tisph.simulation.recording import Recording
from tisph.simulation.simulation import Simulation

REFRESH = 0.2
"""Seconds between two updates of the bar."""

LOOK = 0.05
"""Seconds between two checks of the progress."""

LINES = 10
"""Plain lines over a whole run of medium length."""

SHORTEST_PAUSE, LONGEST_PAUSE = 1.0, 60.0
"""Least and largest number of seconds between two plain lines; the first and the last one are printed at once."""

LEAST_BAR = 30
"""Columns of the terminal reserved for bar, percentage and remaining time."""


class RunProgress(StateObserver):
    """Shows the progress of a run from ``start`` to ``end``, and its particle-steps per second.

    It is its own schedule, on the wall clock.
    """

    def __init__(self, start: float, end: float, particles: int, unit: str):
        self.start, self.end = start, end
        self.particles, self.unit = particles, unit
        self.schedule = self
        self.looked = -math.inf
        self.began = self.shown = time.perf_counter()
        self.first_step = 0
        self.lines = 0
        self.bar = None
        if sys.stderr.isatty():
            from tisph.report.terminal_bar import terminal_bar  # imported only on a terminal

            self.bar = terminal_bar()
            self.task = self.bar.add_task("", total=1.0, state="")

    def __enter__(self) -> "RunProgress":
        if self.bar:
            self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar:
            self.bar.stop()

    def begin(self, start: float, time: float, steps: int) -> None:
        """Count the steps from here."""
        self.first_step = steps

    def take(self, now: float, steps: int) -> list[float] | None:
        """Return no times, as no state is needed, where the next check is due."""
        if now < self.end and time.perf_counter() - self.looked <= LOOK:
            return None
        self.looked = time.perf_counter()
        return []

    def tell(self, step: LastStep, times: Sequence[float]) -> None:
        """Show the progress."""
        if step.steps > self.first_step:
            self.update(step.time, step.steps)

    def update(self, now: float, steps: int) -> None:
        """Show simulated time ``now`` and ``steps``, unless the last output is too recent."""
        wall = time.perf_counter()
        part = (now - self.start) / (self.end - self.start)
        if self.bar and (wall - self.shown > REFRESH or part >= 1.0):
            self.shown = wall
            state = self._state(now, steps, wall, self.bar.console.width - LEAST_BAR)
            self.bar.update(self.task, completed=part, state=state)
            return
        pause = wall - self.shown
        further = int(part * LINES) > self.lines and (pause > SHORTEST_PAUSE or self.lines == 0 or part >= 1.0)
        if not self.bar and (further or pause > LONGEST_PAUSE):
            self.lines, self.shown = int(part * LINES), wall
            left = (wall - self.began) * (1.0 - part) / part
            events.progress(part, f"{self._state(now, steps, wall)}  {left:.0f} s left")

    def _state(self, now: float, steps: int, wall: float, columns: int = sys.maxsize) -> str:
        """Return time, step and speed, as many of them as fit into ``columns``."""
        rate = (steps - self.first_step) * self.particles / max(wall - self.began, 1e-9)
        state = ""
        for text in (f"t = {now:.4g} {self.unit}", f"step {steps}", f"{rate / 1e6:.2f} M particle-steps/s"):
            longer = f"{state}  {text}" if state else text
            if len(longer) > columns:
                break
            state = longer
        return state


def run(
    config: Config, out_dir: str | PathLike[str], *, pictures: bool = True, video: bool = True, resume: bool = False
) -> Path:
    """Run ``config`` into the folder ``out_dir`` and return its path; ``pictures`` and ``video`` ask for them.

    ``resume`` continues from the checkpoint there. Raises ConfigError for a checkpoint that does not fit, DivergedError
    for a diverged run and KeyboardInterrupt after Ctrl-C. The last two leave all results up to then and a status in
    ``summary.json``; Ctrl-C leaves a checkpoint, too. TisphError where the results cannot be written: it names the
    first file that failed, and the files written before it are complete.
    """
    folder = Folder(out_dir)
    simulation = None
    try:
        folder.root.mkdir(parents=True, exist_ok=True)
        if pictures or video:
            drawing_process.shared()  # it starts while this process compiles
        interrupts = Interrupts()
        with logging_to(folder.log, append=resume), interrupts.counted():
            imported = np.array([time.perf_counter() - version.PROCESS_START, time.process_time()])
            if config.discretisation.refine == "auto" and not resume:
                config = after_first_run(config, interrupts)
            simulation = Simulation.restore(folder.checkpoint, config) if resume else Simulation(config)
            simulation.costs.began, simulation.costs.seconds["import"] = version.PROCESS_START, imported
            recording = Recording(simulation, folder, pictures=pictures, video=video, interrupts=interrupts)
            _to_the_end(simulation, recording, interrupts)
    except OSError as error:
        raise TisphError(f"{folder.root}: the results cannot be written: {error}") from error
    finally:
        if simulation is not None:
            simulation.release()
    return folder.root


def after_first_run(config: Config, interrupts: Interrupts) -> Config:
    """Return the ``config`` of the run that follows the first run of refine auto, with its places.

    DivergedError where the first run diverges, and KeyboardInterrupt after Ctrl-C.
    """
    first = FirstRun(config)
    simulation = Simulation(first.config)
    try:
        simulation.observe(first)
        print("first run, which tells where particles are to be closer to one another", file=sys.stderr)
        _step(simulation, interrupts)
        if not simulation.finished:
            raise KeyboardInterrupt
        return first.refined(simulation.scene)
    except DivergedError as error:
        raise DivergedError(f"the first run of discretisation.refine: {error}") from error
    finally:
        simulation.release()


def _step(simulation: Simulation, interrupts: Interrupts) -> None:
    """Step to the end, or until an interrupt, and show the progress."""
    scene, end = simulation.scene, simulation.config.time.end
    with RunProgress(simulation.time, end, scene.particles, scene.units.time) as progress:
        simulation.observe(progress)
        simulation.begin()
        while not simulation.finished and not interrupts.count:
            simulation.step()


def _to_the_end(simulation: Simulation, recording: Recording, interrupts: Interrupts) -> None:
    """Step to the end, or until an interrupt, and write the results, whatever ends the run."""
    try:
        simulation.place()
        interrupts.wait = True
        _step(simulation, interrupts)
    except KeyboardInterrupt:
        recording.finish("interrupted")
        raise
    except Exception as error:
        recording.fail(error)
        raise
    recording.finish("done" if simulation.finished else "interrupted")
    if not simulation.finished:
        raise KeyboardInterrupt
