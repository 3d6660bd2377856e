"""The arrays of a sample, in the order of tables."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tisph.results._samples import Sample


def columns(sample: "Sample") -> dict[str, np.ndarray]:
    """Return every array of the particles by its name, positions first."""
    names = [name for name in sample if "/" not in name]
    return {name: sample[name] for name in sorted(names, key=lambda name: (name not in ("x", "y"), name))}
