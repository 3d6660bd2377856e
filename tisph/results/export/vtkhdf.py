"""VTKHDF: all samples as one UnstructuredGrid over time, as a run writes it with ``output: {vtk: true}``."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from tisph.observers._storage import Description, hdf5_file, replaced
from tisph.observers.samples import read_frames, read_samples
from tisph.observers.vtk import append, append_bodies, beside, has_outlines

if TYPE_CHECKING:
    from tisph.results import Results


def write(path: Path, run: "Results", frames: bool = False) -> None:
    """Write every sample, or every frame of the movie; field data are the units and the config."""
    _write(path, run, frames, append)


def write_bodies(path: Path, run: "Results", frames: bool = False) -> None:
    """Write the bodies, if there are any, beside the file ``path`` of the particles."""
    if has_outlines(run._scene):
        with replaced(beside(path)) as new:
            _write(new, run, frames, append_bodies)


def _write(path: Path, run: "Results", frames: bool, add: Callable) -> None:
    about = Description(run.config, run._scene)
    with hdf5_file(path) as file:
        for snapshot in read_frames(run._files.frames) if frames else read_samples(run._files.samples):
            add(file, snapshot, about)
