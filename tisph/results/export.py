"""Samples of a run in the files of other programs, one function a format.

* csv: a line a particle and sample; lines before the header that begin with ``#`` describe the file.
* extxyz, extended XYZ: a frame a sample, its box and its columns in the second line (of libAtoms, as ASE and OVITO read
  it), https://github.com/libAtoms/extxyz.
* npz: arrays by name, ``t`` and ``step`` (samples,), ``x``, ``y``, ``u`` and so on (samples, particles); samples with
  fewer particles than others end in NaN, or in -1 for whole numbers.
* vtkhdf: all samples as one UnstructuredGrid over time, as a run writes it with ``output: {vtk: true}``.
"""

import json
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tisph.errors import ConfigError
from tisph.folder import extended, hdf5_file, replaced
from tisph.observers.samples import Description
from tisph.observers.vtk import append, append_bodies, beside, fields, has_outlines, places

if TYPE_CHECKING:
    from tisph.results import Results

SPECIES = "X"
"""The name of an element in extended XYZ, where there is no atom."""


def write_csv(path: Path, run: "Results") -> None:
    """Write the columns t, particle, x, y, u, v and so on, whose units are in the second line."""
    time = run.config.units.time
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for index, sample in enumerate(run.samples):
            found = sample.columns()
            if index == 0:
                units = {"t": time, "particle": "", **{name: sample.units[name] for name in found}}
                file.write(f"# {run.summary.name}: particles at the samples of a run of tisph\n")
                file.write(f"# units: {', '.join(f'{name} {unit}'.strip() for name, unit in units.items())}\n")
                file.write(",".join(units) + "\n")
            values = [array.tolist() for array in found.values()]  # repr of a float is exact
            for number, row in enumerate(zip(*values, strict=True)):
                file.write(f"{sample.t!r},{number}," + ",".join(map(repr, row)) + "\n")


def write_extxyz(path: Path, run: "Results") -> None:
    """Write positions, velocity and all fields of each particle; the box is as deep as a particle is wide."""
    scene = run._scene
    box = np.diag([*scene.extent, scene.spacing])
    lattice = " ".join(f"{value:.17g}" for value in box.ravel())
    origin = " ".join(f"{value:.17g}" for value in (*scene.origin, 0.0))
    periodic = " ".join("T" if each else "F" for each in (*scene.periodic, False))
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for sample in run.samples:
            found = list(fields(sample))
            kinds = [f"{name}:{'I' if array.dtype.kind == 'i' else 'R'}:{array[0].size}" for name, array, _ in found]
            file.write(
                f'{len(sample["x"])}\nLattice="{lattice}" Origin="{origin}" pbc="{periodic}" Time={sample.t!r} '
                f"Properties=species:S:1:pos:R:3:{':'.join(kinds)}\n"
            )
            table = [places(sample), *(array.reshape(len(array), -1) for _, array, _ in found)]
            rows = zip(*(part.tolist() for part in table), strict=True)
            for row in rows:
                file.write(f"{SPECIES} {' '.join(repr(value) for part in row for value in part)}\n")


def write_npz(path: Path, run: "Results") -> None:
    """Write them, and as texts ``units`` (JSON, by name) and ``config`` (YAML)."""
    samples = run.samples
    units = {"t": run.config.units.time, **{name: unit for name, unit in samples[0].units.items() if "/" not in name}}
    found = [sample.columns() for sample in samples]
    arrays: dict[str, Any] = {
        "t": np.array([sample.t for sample in samples]),
        "step": np.array([sample.step for sample in samples]),
        "units": np.array(json.dumps(units)),
        "config": np.array(run.config.resolved_yaml()),
        **{name: _stacked([each[name] for each in found]) for name in found[0]},
    }
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def _stacked(arrays: list[np.ndarray]) -> np.ndarray:
    """Return ``arrays`` (particles,) of samples as (samples, particles), the largest number of particles."""
    most, gap = max(map(len, arrays)), -1 if arrays[0].dtype.kind == "i" else np.nan
    return np.stack([np.pad(each, (0, most - len(each)), constant_values=gap) for each in arrays])


def write_vtkhdf(path: Path, run: "Results", frames: bool = False, add: Callable = append) -> None:
    """Write every sample, or every frame of the movie; field data are the units and the config.

    ``add`` appends the particles of a snapshot to the open file, or its bodies.
    """
    about = Description(run.config, run._scene)
    with hdf5_file(path) as file:
        for snapshot in run.snapshots(frames):
            add(file, snapshot, about)


FORMATS = {"csv": write_csv, "extxyz": write_extxyz, "npz": write_npz, "vtkhdf": write_vtkhdf}
"""By the names of the formats, which are the endings of files."""


def export(run: "Results", form: str, path: Path | None = None, *, frames: bool = False) -> Path:
    """Write the samples of ``run`` as ``form``, one of ``FORMATS``, and return the file's path.

    It is ``path``, or ``samples.FORM`` in the run's folder; with ``frames``, of vtkhdf only, the frames of the movie
    and ``frames.vtkhdf``. Bodies of vtkhdf are in ``..._bodies.vtkhdf`` beside it. ConfigError where there is no sample
    or frame, or the run still goes on and the file were in its folder; TisphError where the file cannot be written. An
    existing one stays unchanged.
    """
    if form not in FORMATS:
        raise ConfigError(f"--to {form}: must be one of {', '.join(FORMATS)}")
    if frames and form != "vtkhdf":
        raise ConfigError(f"--frames: frames of the movie are exported as vtkhdf only, not as {form}")
    what = "frames" if frames else "samples"
    if not (run._files.frames.is_file() if frames else len(run.samples)):
        raise ConfigError(f"{run.folder}: the run has no {what[:-1]} to export")
    path = path or run.folder / f"{what}.{form}"
    with extended(run.folder) if path.parent.absolute() == run.folder.absolute() else nullcontext():
        with replaced(path) as new:
            FORMATS[form](new, run, *([True] if frames else []))
        if form == "vtkhdf" and has_outlines(run._scene):
            with replaced(beside(path)) as new:
                write_vtkhdf(new, run, frames, append_bodies)
    return path
