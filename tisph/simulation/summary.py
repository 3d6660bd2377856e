"""``summary.json`` and the last good state of a run."""

import math
import time

from tisph import clock
from tisph.measures.metrics import sample_metrics
from tisph.measures.steady import steady_since
from tisph.observers._files import hdf5_file, replaced
from tisph.observers._storage import write_snapshot
from tisph.observers.history import read_history
from tisph.simulation.drawing import begin_still
from tisph.simulation.results import peak_memory_mb, provenance


def summarise(job):
    """Return the summary of a run that has ended in whatever way."""
    return {
        "name": job.config.name,
        "status": job.status,
        **({"message": job.message} if job.message else {}),
        "samples": [
            sample_metrics(job.channel, snapshot, job.history.reading(snapshot)) for snapshot in job.samples.snapshots
        ],
        "numbers": _numbers(job),
        "momentum": _momentum(job),
        "cost": cost(job),
        "provenance": provenance(job.config, job.about.resolved, job.threads),
    }


def _numbers(job):
    channel, scheme = job.channel, job.scheme
    return {
        "reynolds": channel.reynolds,
        "reference_velocity": channel.reference_velocity,
        "spacing": channel.spacing,
        "particles_fluid": job.particles,
        **scheme.numbers(),
        **_steady(job),
        "dt_min": scheme.shortest if scheme.steps else None,
        "dt_max": scheme.longest if scheme.steps else None,
    }


def _steady(job):
    """Since when the numbers that the scene follows have been the last ones, of scenes that may become steady."""
    sizes = job.history.followed.sizes
    return {"steady_since": steady_since(*read_history(job.history.path), sizes)} if sizes else {}


def _momentum(job):
    """The balance of momentum along x [mass * velocity per length out of the plane]; None for what is no number."""
    balance = job.scheme.momentum_balance()
    return {key: value if value is not None and math.isfinite(value) else None for key, value in balance.items()}


def cost(job):
    """Return what the run has cost by now; times in seconds of the clock."""
    steps = job.scheme.steps - job.first_step
    loop = job.costs["loop"]
    return {
        "steps": job.scheme.steps,
        "wall_total_s": time.perf_counter() - clock.PROCESS_START,
        **{f"wall_{kind}_s": seconds for kind, seconds in job.costs.items()},
        "particle_steps_per_s": steps * job.particles / loop if loop > 0 else None,
        "peak_memory_mb": peak_memory_mb(),
    }


def write_last_good(folder, channel, config, snapshot):
    """Keep the last sound state of a run that went wrong, as data and as a picture."""
    with replaced(folder.last_good) as new, hdf5_file(new) as file:
        write_snapshot(file, snapshot)
    begin_still(folder.last_good_picture, config, channel, snapshot).write()
