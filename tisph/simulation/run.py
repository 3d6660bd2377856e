"""``tisph run``: a simulation to its end, with the observers that leave a folder of results."""

import time

from tisph import clock
from tisph.errors import TisphError
from tisph.folder import Folder
from tisph.report import drawing_process
from tisph.simulation.interrupts import Interrupts
from tisph.simulation.log import logging_to
from tisph.simulation.progress import RunProgress
from tisph.simulation.recording import Recording
from tisph.simulation.simulation import Simulation


def run(config, out_dir, *, pictures=True, video=True, resume=False):
    """Run ``config`` into the folder ``out_dir`` and return its path; with the movie and the plots, if they are wanted.

    ``resume`` goes on from the checkpoint there. Raises ConfigError for a checkpoint that does not fit,
    DivergedError for a run that went wrong and KeyboardInterrupt after Ctrl-C; the last two leave all results
    up to then and say so in ``summary.json``, and after Ctrl-C a checkpoint too. TisphError where the results
    cannot be written: it names the first file that could not be, and those written before are as they were.
    """
    folder = Folder(out_dir)
    simulation = None
    try:
        folder.root.mkdir(parents=True, exist_ok=True)
        if pictures or video:
            drawing_process.shared()  # it gets ready while this process does
        interrupts = Interrupts()
        with logging_to(folder.log, append=resume), interrupts.counted():
            imported = time.perf_counter() - clock.PROCESS_START
            simulation = Simulation.restore(folder.checkpoint, config) if resume else Simulation(config)
            simulation.costs.began, simulation.costs.seconds["import"] = clock.PROCESS_START, imported
            recording = Recording(simulation, folder, pictures=pictures, video=video, interrupts=interrupts)
            _to_the_end(simulation, recording, interrupts)
    except OSError as error:
        raise TisphError(f"{folder.root}: the results cannot be written: {error}") from error
    finally:
        if simulation is not None:
            simulation.release()
    return folder.root


def _to_the_end(simulation, recording, interrupts):
    """Step to the end, or until an interrupt, and write what is known then, whatever ends the run."""
    try:
        simulation.place()
        interrupts.wait = True
        scene, end = simulation.scene, simulation.config.time.end
        with RunProgress(simulation.time, end, scene.particles, scene.units.time) as progress:
            simulation.observe(progress)
            simulation.begin()
            while not simulation.finished and not interrupts.count:
                simulation.step()
    except KeyboardInterrupt:
        recording.finish("interrupted")
        raise
    except Exception as error:
        recording.fail(error)
        raise
    recording.finish("done" if simulation.finished else "interrupted")
    if not simulation.finished:
        raise KeyboardInterrupt
