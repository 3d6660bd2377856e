"""Arrays by name: ``t`` and ``step`` (samples,), ``x``, ``y``, ``u`` and so on (samples, particles)."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph.results.export._columns import columns

if TYPE_CHECKING:
    from tisph.results import Results


def write(path: Path, run: "Results") -> None:
    """Write them, and as texts ``units`` (JSON, by name) and ``config`` (YAML)."""
    samples = run.samples
    units = {"t": run.config.units.time, **{name: unit for name, unit in samples[0].units.items() if "/" not in name}}
    found = [columns(sample) for sample in samples]
    arrays: dict[str, Any] = {
        "t": np.array([sample.t for sample in samples]),
        "step": np.array([sample.step for sample in samples]),
        "units": np.array(json.dumps(units)),
        "config": np.array(run.config.resolved_yaml()),
        **{name: np.stack([each[name] for each in found]) for name in found[0]},
    }
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)
