"""One run: set up, step, observe, and leave a folder of results whatever happens."""

import logging
import math
import signal
import time
from contextlib import contextmanager

import numpy as np

from tisph import PROCESS_START, families, runtime
from tisph.errors import DivergedError, TisphError
from tisph.observers.frames import Frames, frame_times
from tisph.observers.guard import INTERVAL, Guard
from tisph.observers.history import History
from tisph.observers.samples import Samples
from tisph.report.movie import Movie
from tisph.simulation import checkpoint
from tisph.simulation.progress import RunProgress
from tisph.simulation.render import pictures
from tisph.simulation.results import Folder, fingerprint
from tisph.simulation.summary import write_last_good, write_summary

PARTICLES_PER_THREAD = 512
"""Taichi does not split a loop into shorter pieces than this."""

log = logging.getLogger("tisph")


def run(config, out_dir, *, video=True, resume=False):
    """Run ``config`` into the folder ``out_dir`` and return its path.

    ``resume`` goes on from the checkpoint there. Raises ConfigError for a checkpoint that does not fit,
    DivergedError for a run that went wrong and KeyboardInterrupt after Ctrl-C; the last two leave all results
    up to then and say so in ``summary.json``, and after Ctrl-C a checkpoint too.
    """
    folder = Folder(out_dir)
    folder.root.mkdir(parents=True, exist_ok=True)
    with _logging_to(folder.log, append=resume):
        job = Run(config, folder)
        job.prepare(video, resume)
        return job.execute()


class Run:
    """A run and its costs; ``costs`` adds up seconds by kind."""

    def __init__(self, config, folder):
        self.config = config
        self.folder = folder
        self.channel = families.load("scenes", config.scene).Scene.from_config(config)
        self.fingerprint = fingerprint(config)
        self.threads = threads(config, self.channel)
        self.costs = {
            "import": time.perf_counter() - PROCESS_START,
            "compile": 0.0,
            "loop": 0.0,
            "output": 0.0,
        }
        self.status = "running"
        self.message = None
        self.interrupted = False

    def prepare(self, video, resume):
        """Compile, place the particles or take up the checkpoint, and open the files."""
        with self._timed("compile"):
            runtime.start(self.config.discretisation.precision, self.threads)
            scheme = families.load("schemes", self.config.scheme.type).Scheme
            self.scheme = scheme(self.config, self.channel, serial=self.threads == 1)
            x, y = self.channel.jittered(self.config.initial.seed, self.config.initial.jitter)
            u = self.channel.initial_velocity(y)
            targets = sorted({*self.config.time.samples, self.config.time.end})
            self.scheme.start(np.stack([x, y], 1), np.stack([u, np.zeros_like(u)], 1), targets)
            if resume:
                checkpoint.restore(self.folder.checkpoint, self.scheme, self.fingerprint)
        self.first_step = self.scheme.steps
        with self._timed("output"):
            self._open(video, self.scheme.time if resume else None)
        log.info("%s: %d particles, %d threads", self.config.name, x.size, self.threads)

    def execute(self):
        """Step to the end, write what is known then, and return the folder's path."""
        try:
            with (
                _interrupts_to(self),
                RunProgress(
                    self.channel.start_time,
                    self.config.time.end,
                    self.scheme.particles.fluid,
                    self.channel.units.time,
                ) as progress,
            ):
                self._loop(progress)
            self.status = "interrupted" if self.interrupted else "done"
        except DivergedError as error:
            self.status, self.message = "diverged", str(error)
            raise
        finally:
            self._finish()
        if self.interrupted:
            raise KeyboardInterrupt
        return self.folder.root

    def _open(self, video, resumed_at):
        self.folder.config.write_text(self.config.resolved_yaml(), encoding="utf-8")
        end = self.config.time.end
        self.tracers = self.channel.tracer_positions(self.config.tracers.count, self.config.tracers.x)
        self.samples = Samples(self.folder.samples, self.config.time.samples, resumed_at)
        self.history = History(self.folder.history, self.channel, self.tracers, end, resumed_at)
        self.observers = [self.samples, self.history]
        settings = self.config.output.video
        if video and settings:
            movie = Movie(self.folder.movie, self.channel, settings, self.config.name)
            times = frame_times(self.channel, end, settings.frames)
            kept = resumed_at if self.folder.frames.exists() else None
            self.observers.append(Frames(self.folder.frames, movie, times, kept))
        self.guard = Guard(self.channel)
        every = self.config.output.checkpoint_every
        self.next_checkpoint = self.scheme.time + every if every else math.inf

    def _loop(self, progress):
        scheme = self.scheme
        self._observe()
        while not scheme.finished and not self.interrupted:
            with self._timed("loop"):
                scheme.advance()
            if scheme.steps % INTERVAL == 0 or any(observer.due(scheme.time) for observer in self.observers):
                self._observe()
            if scheme.time >= self.next_checkpoint:
                self.next_checkpoint += self.config.output.checkpoint_every
                self._save()
            progress.update(scheme.time, scheme.steps)

    def _observe(self):
        with self._timed("output"):
            snapshot = self.scheme.snapshot()
            self.guard.check(snapshot)
            for observer in self.observers:
                if observer.due(snapshot.t):
                    observer.observe(snapshot)

    def _save(self):
        with self._timed("output"):
            checkpoint.save(self.folder.checkpoint, self.scheme, self.fingerprint)

    def _finish(self):
        with self._timed("output"):
            for observer in self.observers:
                observer.close()
            if self.status == "running":
                self.status = "failed"
            if self.status == "interrupted":
                checkpoint.save(self.folder.checkpoint, self.scheme, self.fingerprint)
            if self.status == "diverged" and self.guard.last_good is not None:
                write_last_good(self.folder, self.channel, self.config, self.guard.last_good)
            pictures(self.folder, self.config, self.channel)
        write_summary(self)
        log.info(
            "%s after %d steps, t = %.6g%s",
            self.status,
            self.scheme.steps,
            self.scheme.time,
            f": {self.message}" if self.message else "",
        )

    @contextmanager
    def _timed(self, kind):
        began = time.perf_counter()
        try:
            yield
        finally:
            self.costs[kind] += time.perf_counter() - began


def threads(config, channel):
    """Return the number of threads that ``runtime.threads`` means for this many particles."""
    if config.runtime.threads != "auto":
        return config.runtime.threads
    useful = math.ceil(channel.rows * channel.columns / PARTICLES_PER_THREAD)
    return min(runtime.available_threads(), useful)


@contextmanager
def _interrupts_to(job):
    """Let Ctrl-C or a termination end the run after its step, with all results; a second one stops at once."""

    def handle(number, frame):
        job.interrupted = True
        signal.signal(number, signal.default_int_handler)

    try:
        previous = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:  # not in the main thread: the caller decides
        yield
        return
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


@contextmanager
def _logging_to(path, append):
    handler = logging.FileHandler(path, mode="a" if append else "w", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    except TisphError as error:
        log.error("%s", error)
        raise
    except Exception:
        log.exception("unexpected failure")
        raise
    finally:
        log.removeHandler(handler)
        handler.close()
