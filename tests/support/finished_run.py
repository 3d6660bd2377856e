"""A run to its end: the flow, its last state and the numbers of that."""

from collections.abc import Mapping
from typing import Any

import tisph
from tisph.snapshot import Snapshot


def finished(config: Mapping[str, Any], **changes: Any) -> tuple[Any, Snapshot, dict[str, Any]]:
    """Return the scene of a ``config`` with ``changes``, the snapshot at the end of its run, and the numbers there."""
    with tisph.Simulation({**config, **changes}) as simulation:
        while not simulation.finished:
            simulation.step()
        snapshot = simulation.scheme.snapshot()
        return simulation.scene, snapshot, simulation.scene.diagnostics(snapshot, [])
