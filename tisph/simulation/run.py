"""One run: set up, step, observe, and leave a folder of results whatever happens."""

import math
import sys
import time
from contextlib import contextmanager

import numpy as np

from tisph import clock, runtime, scenes, schemes
from tisph.errors import DivergedError, TisphError
from tisph.folder import Folder
from tisph.observers._files import replaced
from tisph.observers.description import Description
from tisph.observers.frames import Frames, frame_times
from tisph.observers.guard import INTERVAL, Guard
from tisph.observers.history import History
from tisph.observers.samples import Samples
from tisph.report import drawing_process
from tisph.simulation import checkpoint, drawing
from tisph.simulation.interrupts import interrupts_to
from tisph.simulation.log import log, logging_to
from tisph.simulation.progress import RunProgress
from tisph.simulation.results import write_summary
from tisph.simulation.start import seen_from_config, start_snapshot, start_values
from tisph.simulation.summary import cost, summarise, write_last_good

PARTICLES_PER_THREAD = 512
"""Taichi does not split a loop into shorter pieces than this."""

OTHER_STEPS = (
    "the steps before the checkpoint led to the old time.end, so that the bits are not those of a run that had the "
    "later one from the start"
)


def run(config, out_dir, *, pictures=True, video=True, resume=False):
    """Run ``config`` into the folder ``out_dir`` and return its path; with the movie and the plots, if they are wanted.

    ``resume`` goes on from the checkpoint there. Raises ConfigError for a checkpoint that does not fit,
    DivergedError for a run that went wrong and KeyboardInterrupt after Ctrl-C; the last two leave all results
    up to then and say so in ``summary.json``, and after Ctrl-C a checkpoint too. TisphError where the results
    cannot be written: it names the first file that could not be, and those written before are as they were.
    """
    folder = Folder(out_dir)
    try:
        folder.root.mkdir(parents=True, exist_ok=True)
        if pictures or video:
            drawing_process.shared()  # it gets ready while this process does
        with logging_to(folder.log, append=resume):
            Run(config, folder, pictures).execute(video, resume)
    except OSError as error:
        raise TisphError(f"{folder.root}: the results cannot be written: {error}") from error
    finally:
        runtime.stop()
    return folder.root


class Run:
    """A run and its costs; ``costs`` adds up seconds by kind, ``drawn`` tells whether there are plots at the end.

    ``unsaved``: there is a state to go on from, and at the end it is not written yet. An interrupt waits for that.
    """

    def __init__(self, config, folder, drawn):
        self.config = config
        self.folder = folder
        self.drawn = drawn
        self.channel = scenes.of(config)
        self.particles = self.channel.particles
        self.about = Description(config, self.channel)
        self.threads = threads(config, self.channel)
        self.costs = {
            "import": time.perf_counter() - clock.PROCESS_START,
            "compile": 0.0,
            "loop": 0.0,
            "output": 0.0,
        }
        self.status = "failed"
        self.message = self.summary = self.movie = None
        self.pictures = []
        self.interrupts = 0
        self.unsaved = False

    def execute(self, video, resume):
        """Set up, step to the end, and write what is known then, whatever ends the run."""
        with interrupts_to(self):
            if video and self.config.output.video:
                self.movie = drawing.movie(self.folder, self.config, self.channel)
            with self._timed("compile"):
                self._build(resume)
            with self._timed("output"):
                self._open(self.scheme.time if resume else None)
            try:
                self._step_on(resume)
                self.status = "done" if self.scheme.finished else "interrupted"
            except DivergedError as error:
                self.status, self.message = "diverged", str(error)
                raise
            except KeyboardInterrupt:
                self.status = "interrupted"
                raise
            except Exception as error:
                self.message = f"{type(error).__name__}: {error}"
                raise
            finally:
                failures = self._finish()
        if failures:
            raise failures[0]
        if self.status == "interrupted":
            raise KeyboardInterrupt

    def _build(self, resume):
        runtime.start(self.config.discretisation.precision, self.threads)
        config, reason = schemes.resolve(self.config)
        targets = sorted({*config.time.samples, config.time.end})
        self.scheme = schemes.build(config, self.channel.in_own_frame(), targets, serial=self.threads == 1)
        log.info("scheme %s", reason)
        if resume and not checkpoint.restore(self.folder.checkpoint, self.scheme, self.about.resolved, targets):
            log.warning(OTHER_STEPS)
            print(f"warning: {OTHER_STEPS}", file=sys.stderr)
        self.first_step = self.scheme.steps
        log.info("%s: %d particles, %d threads", self.config.name, self.particles, self.threads)

    def _step_on(self, resume):
        if not resume:
            with self._timed("compile"):
                values = start_values(self.channel.in_own_frame(), self.config.initial)
                self.scheme.start(*values)
        self.unsaved = True
        if resume:
            self._observe()
        else:
            with self._timed("output"):
                start = start_snapshot(self.channel, values, self.config.discretisation.precision)
                self.guard.check(start)
                self._show(start)
        with RunProgress(self.scheme.time, self.config.time.end, self.particles, self.channel.units.time) as progress:
            self._loop(progress)

    def _open(self, resumed_at):
        with replaced(self.folder.config) as new:
            new.write_text(self.about.resolved, encoding="utf-8")
        end = self.config.time.end
        followed = self.channel.followed(**self.config.followed)
        self.samples = Samples(self.folder.samples, self.channel, self.config.time.samples, resumed_at, self.about)
        self.history = History(self.folder.history, self.channel, followed, end, resumed_at, self.about)
        self.observers = [self.samples, self.history]
        if self.config.output.vtk:
            from tisph.observers.vtk import Vtk  # who does not want it does not pay for it

            self.observers.append(Vtk(self.folder.vtk, self.samples, resumed_at, self.about))
        if self.movie:
            video = self.config.output.video
            times, more = frame_times(self.channel, end, video.frames), self.channel.shown_fields(video.color_by)
            self.observers.append(Frames(self.folder.frames, self.movie, times, resumed_at, more))
        self.guard = Guard(self.channel)
        every = self.config.output.checkpoint_every
        self.next_checkpoint = self.scheme.time + every if every else math.inf

    def _loop(self, progress):
        scheme = self.scheme
        while not scheme.finished and not self.interrupts:
            self._advance()
            if scheme.steps % INTERVAL == 0 or any(observer.schedule.due(scheme.time) for observer in self.observers):
                self._observe()
            if scheme.time >= self.next_checkpoint:
                self.next_checkpoint += self.config.output.checkpoint_every
                with self._timed("output"):
                    self._save()
            progress.update(scheme.time, scheme.steps)

    def _advance(self):
        try:
            with self._timed("loop"):
                self.scheme.advance()
        except DivergedError:
            self.guard.check(self._snapshot())  # what has gone wrong may have a plainer name
            raise

    def _snapshot(self, at=None):
        return seen_from_config(self.scheme.snapshot(at), self.channel)

    def _observe(self):
        """Give every observer the states that it waits for, up to now, once the guard has seen the last of them.

        Those before it lie between that one and a state that was sound.
        """
        with self._timed("output"):
            due = sorted({time for observer in self.observers for time in observer.schedule.pending(self.scheme.time)})
            *before, last = self.scheme.output_times(due) or [self.scheme.time]
            latest = self._snapshot(last)
            self.guard.check(latest)
            if self.history.probes:
                self._record([time_ for time_ in self.history.schedule.pending(self.scheme.time) if time_ in before])
            for time_ in before:
                if any(observer.schedule.due(time_) for observer in self.observers):
                    self._show(self._snapshot(time_))
            self._show(latest)

    def _record(self, times):
        """Give the history its lines at ``times`` of the last step, from the particles around its tracers."""
        if times:
            probes, velocity = self.history.probes, self.channel.frame_velocity
            travelled = velocity * (np.array(times) - self.channel.start_time)
            when, x, y, u = self.scheme.around(times, probes.centre - travelled, probes.half_width)
            self.history.record(times, probes.velocities(len(times), when, x + travelled[when], y, u + velocity))

    def _show(self, snapshot):
        for observer in self.observers:
            if observer.schedule.due(snapshot.t):
                observer.observe(snapshot)

    def _save(self):
        try:
            for observer in self.observers:
                observer.flush()  # a run that goes on from the checkpoint needs what came before it
        finally:
            checkpoint.save(self.folder.checkpoint, self.scheme, self.about.resolved)

    def _begin_pictures(self):
        self.pictures = drawing.begin_pictures(self.folder, self.config, self.channel)

    def _finish(self):
        """Write what is known at the end; return the errors, none of which keeps the rest from being written."""
        failures = []
        with self._timed("output"):
            for write in self._last_files():
                try:
                    write()
                except Exception as error:
                    log.error("%s", error)
                    failures.append(error)
        if self.summary and not failures:
            write_summary(self.folder.summary, {**self.summary, "cost": cost(self)})
        log.info(
            "%s after %d steps, t = %.6g%s",
            self.status,
            self.scheme.steps,
            self.scheme.time,
            f": {self.message}" if self.message else "",
        )
        return failures

    def _last_files(self):
        """Yield what writes the last files, the most precious first; a second interrupt leaves out the rest of them."""
        if self.unsaved or self.status != "interrupted":
            if self.status == "interrupted":
                yield self._save
            if self.drawn:
                yield self._begin_pictures  # drawn beside the rest
            yield self._summarise
        self.unsaved = False
        if self.interrupts > 1:
            raise KeyboardInterrupt
        if self.status == "diverged" and self.guard.last_good is not None:
            yield lambda: write_last_good(self.folder, self.channel, self.config, self.guard.last_good)
        yield from (observer.close for observer in self.observers)
        yield from (picture.write for picture in self.pictures)

    def _summarise(self):
        self.summary = summarise(self)
        write_summary(self.folder.summary, self.summary)

    @contextmanager
    def _timed(self, kind):
        began, compiled = time.perf_counter(), runtime.compile_seconds()
        try:
            yield
        finally:
            compiling = runtime.compile_seconds() - compiled  # at the first launch of a kernel, wherever that is
            self.costs["compile"] += compiling
            self.costs[kind] += time.perf_counter() - began - compiling


def threads(config, channel):
    """Return the number of threads that ``runtime.threads`` means for this many particles."""
    if config.runtime.threads != "auto":
        return config.runtime.threads
    useful = math.ceil(channel.particles / PARTICLES_PER_THREAD)
    return min(runtime.available_threads(), useful)
