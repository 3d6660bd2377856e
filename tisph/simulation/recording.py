"""The folder of results: the observers that leave its files, and what is written when the run ends."""

from contextlib import ExitStack

from tisph.config.checks import colours
from tisph.errors import DivergedError, TisphError
from tisph.folder import Folder, claimed
from tisph.observers._storage import replaced
from tisph.observers.history import History, Trajectories
from tisph.observers.samples import Frames, Samples
from tisph.observers.schedule import Checkpoints, even_times
from tisph.report import drawing_process
from tisph.simulation import checkpoint, drawing
from tisph.simulation.interrupts import Interrupts
from tisph.simulation.log import log, logging_to
from tisph.simulation.results import write_summary
from tisph.simulation.summary import cost, summarise, write_last_good


class Recording:
    """What a ``simulation`` leaves in ``folder``: with the movie and the plots, if they are wanted.

    It gives its observers to the simulation, which tells it how the run ended. ``interrupts`` counts those of a run
    that is to end with all its results; they wait as long as there is a state to go on from that is not written.
    """

    def __init__(self, simulation, folder, *, pictures, video, interrupts=None):
        self.simulation, self.folder = simulation, folder
        self.drawn = pictures
        self.interrupts = interrupts or Interrupts(wait=True)
        self.about = simulation.about
        self.status, self.message, self.summary = "failed", None, None
        self.pictures = []
        self.held = ExitStack()
        self.ended = False
        settings, scene = simulation.config, simulation.scene
        wanted = video and settings.output.video
        self.movie = drawing.movie(folder, settings, scene) if wanted else None
        with simulation.costs.timed("output"):
            self._open(simulation.time if simulation.restored else None)

    @classmethod
    def of(cls, simulation, root, *, overwrite, video):
        """Return the record of a run that is stepped by hand; the folder is kept from others until the run ends.

        TisphError where the results cannot be written, ConfigError where the folder must not be used.
        """
        folder, held = Folder(root), ExitStack()
        try:
            held.enter_context(claimed(folder.root, overwrite=overwrite, resume=simulation.restored))
            drawing_process.shared()
            held.enter_context(logging_to(folder.log, append=simulation.restored))
            recording = cls(simulation, folder, pictures=True, video=video)
        except BaseException:
            held.close()
            raise
        recording.held = held
        return recording

    def _open(self, resumed_at):
        settings, scene, folder = self.simulation.config, self.simulation.scene, self.folder
        with replaced(folder.config) as new:
            new.write_text(self.about.resolved, encoding="utf-8")
        end, output = settings.time.end, settings.output
        followed = scene.time_series(**settings.time_series)
        self.samples = Samples(folder.samples, scene, settings.time.samples, resumed_at, self.about)
        self.history = History(folder.history, scene, followed, end, resumed_at, self.about)
        self.observers = [self.samples, self.history]
        if scene.has_free_bodies:
            self.observers.append(Trajectories(folder.bodies, scene, end, resumed_at, self.about))
        if output.vtk:
            from tisph.observers.vtk import Vtk  # who does not want it does not pay for it

            self.observers.append(Vtk(folder.vtk, self.samples, resumed_at, self.about))
        if self.movie:
            times = even_times(scene.start_time, end, output.video.frames)
            more = {field for name in colours(settings) for field in scene.movie_fields(name)}
            self.observers.append(Frames(folder.frames, self.movie, times, resumed_at, more))
        self.simulation.observe(*self.observers)
        if output.checkpoint_every:
            self.simulation.observe(Checkpoints(output.checkpoint_every, self.save))

    def save(self):
        """Write the checkpoint, and all that came before it, which a run that goes on from there needs."""
        try:
            for observer in self.observers:
                observer.flush()
        finally:
            checkpoint.save(self.folder.checkpoint, self.simulation.scheme, self.about.resolved)

    def fail(self, error):
        """Write what is known once ``error`` has ended the run; no other error comes in its place."""
        if isinstance(error, DivergedError):
            self._end("diverged", str(error))
        else:
            self._end("failed", f"{type(error).__name__}: {error}")

    def finish(self, status):
        """Write what is known once the run is ``done`` or ``interrupted``; raises what kept a file from being written.

        TisphError for one that the system does not let be written.
        """
        failures = self._end(status, None)
        if failures and isinstance(failures[0], OSError):
            raise TisphError(f"{self.folder.root}: the results cannot be written: {failures[0]}") from failures[0]
        if failures:
            raise failures[0]

    def _end(self, status, message):
        """Write what is known at the end; return the errors, none of which keeps the rest from being written."""
        if self.ended:
            return []
        self.ended, self.status, self.message = True, status, message
        failures = []
        try:
            with self.simulation.costs.timed("output"):
                for write in self._last_files():
                    try:
                        write()
                    except Exception as error:
                        log.error("%s", error)
                        failures.append(error)
            if self.summary and not failures:
                write_summary(self.folder.summary, {**self.summary, "cost": cost(self.simulation)})
            steps, time = self.simulation.steps, self.simulation.time
            log.info("%s after %d steps, t = %.6g%s", status, steps, time, f": {message}" if message else "")
        finally:
            self.held.close()
        return failures

    def _last_files(self):
        """Yield what writes the last files, the most precious first; a second interrupt leaves out the rest of them."""
        if self.interrupts.wait or self.status != "interrupted":
            if self.status == "interrupted":
                yield self.save
            if self.drawn:
                yield self._begin_pictures  # drawn beside the rest
            yield self._summarise
        self.interrupts.wait = False
        if self.interrupts.count > 1:
            raise KeyboardInterrupt
        good = self.simulation.guard.last_good
        if self.status == "diverged" and good is not None:
            yield lambda: write_last_good(self.folder, self.simulation.scene, self.simulation.config, good)
        yield from (observer.close for observer in self.observers)
        yield from (picture.write for picture in self.pictures)

    def _begin_pictures(self):
        self.pictures = drawing.begin_pictures(self.folder, self.simulation.config, self.simulation.scene)

    def _summarise(self):
        self.summary = summarise(self)
        write_summary(self.folder.summary, self.summary)
