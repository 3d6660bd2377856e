"""VTKHDF: all samples as one UnstructuredGrid over time, each particle a vertex (VTK 9.3 and later, ParaView 5.12).

https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from tisph.observers._files import hdf5_file
from tisph.results.export._fields import fields, places

if TYPE_CHECKING:
    from tisph.results import Results
    from tisph.results._samples import Sample

VERSION = (2, 0)
VERTEX = 1


def write(path: Path, run: "Results") -> None:
    """Write ``velocity``, ``pressure``, ``density``, ``stress`` and ``particle`` of every sample, and the exact ones.

    Field data: ``units``, a text that names that of each field, and ``config``, the config as YAML.
    """
    with hdf5_file(path) as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = VERSION
        root.attrs.create("Type", np.bytes_("UnstructuredGrid"))  # of fixed length and ASCII, or VTK does not know it
        counts = np.array([len(sample["x"]) for sample in run.samples])
        _write_cells(root, counts)
        data = root.create_group("PointData")
        first = np.concatenate([[0], np.cumsum(counts)])
        for sample, begin, end in zip(run.samples, first[:-1], first[1:], strict=True):
            _fill(root, "Points", places(sample), begin, end, first[-1])
            for name, array, _ in fields(sample):
                _fill(data, name, array, begin, end, first[-1])
        texts = {"units": _units(run.samples[0], run.config.units), "config": run.config.resolved_yaml()}
        _write_steps(root, [sample.t for sample in run.samples], first[:-1], list(data), texts)


def _write_cells(root: Any, counts: np.ndarray) -> None:
    """Make every particle a cell of its own: steps one after the other, in each cells from 0 on."""
    for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
        root[name] = counts
    root["Connectivity"] = np.concatenate([np.arange(count) for count in counts])
    root["Offsets"] = np.concatenate([np.arange(count + 1) for count in counts])
    root["Types"] = np.full(counts.sum(), VERTEX, np.uint8)


def _fill(group: Any, name: str, array: np.ndarray, begin: int, end: int, total: int) -> None:
    if name not in group:
        group.create_dataset(name, shape=(total, *array.shape[1:]), dtype=array.dtype)
    group[name][begin:end] = array


def _write_steps(root: Any, times: list[float], first: np.ndarray, names: list[str], texts: dict[str, str]) -> None:
    """Say where the points and cells of each step begin; the texts are the same at every step."""
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = len(times)
    steps["Values"] = np.array(times)
    steps["PartOffsets"] = np.arange(len(times))
    steps["NumberOfParts"] = np.ones(len(times), int)
    steps["PointOffsets"] = first
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = first[:, None]
    offsets = steps.create_group("PointDataOffsets")
    for name in names:
        offsets[name] = first
    for name, text in texts.items():  # without offsets, or in other characters, VTK 9.7 ends the process
        root.create_dataset(f"FieldData/{name}", data=[_ascii(text)], dtype=h5py.string_dtype("ascii"))
        steps[f"FieldDataOffsets/{name}"] = np.zeros(len(times), int)
        steps[f"FieldDataSizes/{name}"] = np.ones((len(times), 2), int)


def _units(sample: "Sample", units: Any) -> str:
    named = [("Points", units.length), ("time", units.time), *((name, unit) for name, _, unit in fields(sample))]
    return ", ".join(f"{name} [{unit or '-'}]" for name, unit in named)


def _ascii(text: str) -> str:
    return text.replace("µ", "u").encode("ascii", "backslashreplace").decode()
