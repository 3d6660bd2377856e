"""``summary.json`` and the last good state of a run."""

import math
import time

from tisph.measures.metrics import sample_metrics
from tisph.measures.resolution import steady_since
from tisph.observers._storage import hdf5_file, replaced, write_snapshot
from tisph.observers.history import read_history
from tisph.simulation.drawing import begin_still
from tisph.simulation.results import peak_memory_mb, provenance


def summarise(recording):
    """Return the summary of a run that has ended in whatever way, from its ``Recording``."""
    simulation, history = recording.simulation, recording.history
    scene, config = simulation.scene, simulation.config
    snapshots = recording.samples.snapshots
    return {
        "name": config.name,
        "status": recording.status,
        **({"message": recording.message} if recording.message else {}),
        "samples": [sample_metrics(scene, snapshot, history.reading(snapshot)) for snapshot in snapshots],
        "numbers": _numbers(scene, simulation.scheme, history),
        "momentum": _momentum(simulation.scheme),
        "cost": cost(simulation),
        "provenance": provenance(config, recording.about.resolved, simulation.threads),
    }


def _numbers(scene, scheme, history):
    return {
        "reynolds": scene.reynolds,
        "reference_velocity": scene.reference_velocity,
        "spacing": scene.spacing,
        "particles_fluid": scene.particles,
        **scheme.numbers(),
        **_steady(history),
        "dt_min": scheme.shortest if scheme.steps else None,
        "dt_max": scheme.longest if scheme.steps else None,
    }


def _steady(history):
    """Since when the numbers that the scene follows have been the last ones, of scenes that may become steady."""
    series = history.time_series
    if not series.sizes:
        return {}
    drifting = set(series.drifting)
    sizes = [math.inf if name in drifting else size for name, size in zip(series.columns, series.sizes, strict=True)]
    return {"steady_since": steady_since(*read_history(history.path), sizes)}


def _momentum(scheme):
    """The balance of momentum along x [mass * velocity per length out of the plane]; None for what is no number."""
    balance = scheme.momentum_balance()
    return {key: value if value is not None and math.isfinite(value) else None for key, value in balance.items()}


def cost(simulation):
    """Return what the run has cost by now; times elapsed, in seconds of the clock."""
    steps, loop = simulation.steps - simulation.first_step, simulation.costs.seconds["loop"]
    return {
        "steps": simulation.steps,
        "wall_total_s": time.perf_counter() - simulation.costs.began,
        **{f"wall_{kind}_s": seconds for kind, seconds in simulation.costs.seconds.items()},
        "particle_steps_per_s": steps * simulation.scene.particles / loop if loop > 0 else None,
        "peak_memory_mb": peak_memory_mb(),
    }


def write_last_good(folder, channel, config, snapshot):
    """Keep the last sound state of a run that went wrong, as data and as a picture."""
    with replaced(folder.last_good) as new, hdf5_file(new) as file:
        write_snapshot(file, snapshot)
    begin_still(folder.last_good_picture, config, channel, snapshot).write()
