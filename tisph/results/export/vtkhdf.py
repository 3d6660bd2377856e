"""VTKHDF: all samples as one UnstructuredGrid over time, as a run writes it with ``output: {vtk: true}``."""

from pathlib import Path
from typing import TYPE_CHECKING

from tisph.observers._files import hdf5_file
from tisph.observers._vtkhdf import append

if TYPE_CHECKING:
    from tisph.results import Results


def write(path: Path, run: "Results") -> None:
    """Write every sample, its field data being the units and the config."""
    config = run.config.resolved_yaml()
    with hdf5_file(path) as file:
        for sample in run.samples:
            append(file, sample, run.config.units, config)
