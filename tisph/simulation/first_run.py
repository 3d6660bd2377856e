"""The first run of ``discretisation.refine: auto``, with the spacings of the config; it finds the places to refine."""

from pathlib import Path

from tisph.config.loader import loaded
from tisph.config.schema import Config
from tisph.observers.protocol import StateObserver, Times
from tisph.scenes._automatic import places_of
from tisph.scenes._scene import Scene
from tisph.simulation import checkpoint
from tisph.simulation.process import log
from tisph.snapshot import Snapshot

MOST_SAMPLES = 8
"""Number of samples from which places are found: the last ones."""

REFINE = "discretisation.refine"


class FirstRun(StateObserver):
    """Observes the samples of the first run for ``automatic``, a config with refine auto; it has the ``config``."""

    def __init__(self, automatic: Config):
        self.automatic = automatic
        given = automatic.discretisation
        growth = given.growth if automatic.spacings else None
        changed = given.model_copy(update={"refine": (), "growth": growth})
        self.config = automatic.model_copy(update={"discretisation": changed})
        later = [time for time in automatic.time.samples if time > automatic.start_time]
        self.schedule = Times(later[-MOST_SAMPLES:] or [automatic.time.end])
        self.snapshots: list[Snapshot] = []

    def observe(self, snapshot: Snapshot) -> None:
        """Store the state of a sample."""
        self.snapshots.append(snapshot)

    def refined(self, scene: Scene) -> Config:
        """Return the config of the run that follows, with its places, from the samples in the first run's ``scene``."""
        places = places_of(self.automatic, scene, self.snapshots)
        smallest = min([scene.wanted_spacing.smallest, *(each.spacing for each in places)])
        log.info("%s: %d places from a first run, smallest spacing %.4g", REFINE, len(places), smallest)
        if not places:
            return self.config
        return loaded(self.automatic, {REFINE: [each.model_dump(exclude_none=True) for each in places]})


def restored(config: Config, path: Path) -> Config:
    """Return a ``config`` with refine auto with the places of the run in the checkpoint ``path``."""
    places = checkpoint.config_of(path)["discretisation"].get("refine")
    return loaded(config, {REFINE: places}) if places else FirstRun(config).config
