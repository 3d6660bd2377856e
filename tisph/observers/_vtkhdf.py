"""VTKHDF: snapshots as one UnstructuredGrid over time, each particle a vertex (VTK 9.3 and later, ParaView 5.12).

https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html
"""

from typing import Any

import h5py
import numpy as np

from tisph.observers._fields import Particles, fields, places

VERSION = (2, 0)
VERTEX = 1

LARGEST_CHUNK = 65536
"""Rows of a dataset that HDF5 keeps in one piece, at the most."""


def append(file: Any, particles: Particles, units: Any, config: str) -> None:
    """Append ``particles`` as the next step to an open HDF5 ``file``, which is empty before the first one.

    It has ``velocity``, ``pressure``, ``density``, ``stress`` and ``particle``, and the exact ones. Field data:
    ``units``, a text that names that of each field, by those of the config, ``units``; and the ``config`` as YAML.
    """
    root = file.get("VTKHDF") or _begun(file, _units(particles, units), config)
    count, first = len(particles["x"]), len(root["Points"]) if "Points" in root else 0
    _add(root, "Points", places(particles))
    for name, array, _ in fields(particles):
        _add(root["PointData"], name, array)
    _add_cells(root, count)
    _add_step(root["Steps"], particles.t, first, list(root["PointData"]), list(root["FieldData"]))


def _begun(file: Any, units: str, config: str) -> Any:
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = VERSION
    root.attrs.create("Type", np.bytes_("UnstructuredGrid"))  # of fixed length and ASCII, or VTK does not know it
    root.create_group("PointData")
    root.create_group("Steps").attrs["NSteps"] = 0
    for name, text in (("units", units), ("config", config)):  # in other characters VTK 9.7 ends the process
        root.create_dataset(f"FieldData/{name}", data=[_ascii(text)], dtype=h5py.string_dtype("ascii"))
    return root


def _add_cells(root: Any, count: int) -> None:
    """Make every particle a cell of its own: steps one after the other, in each cells from 0 on."""
    for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
        _add(root, name, np.array([count]))
    _add(root, "Connectivity", np.arange(count))
    _add(root, "Offsets", np.arange(count + 1))
    _add(root, "Types", np.full(count, VERTEX, np.uint8))


def _add_step(steps: Any, time: float, first: int, names: list[str], texts: list[str]) -> None:
    """Say where the points and cells of a step begin; the texts are the same at every step."""
    number = int(steps.attrs["NSteps"])
    _add(steps, "Values", np.array([time]))
    _add(steps, "PartOffsets", np.array([number]))
    _add(steps, "NumberOfParts", np.array([1]))
    _add(steps, "PointOffsets", np.array([first]))
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        _add(steps, name, np.array([[first]]))
    for name in names:
        _add(steps, f"PointDataOffsets/{name}", np.array([first]))
    for name in texts:  # without offsets VTK 9.7 ends the process
        _add(steps, f"FieldDataOffsets/{name}", np.array([0]))
        _add(steps, f"FieldDataSizes/{name}", np.array([[1, 1]]))
    steps.attrs["NSteps"] = number + 1


def _add(group: Any, name: str, rows: np.ndarray) -> None:
    """Append ``rows`` to a dataset, which is made if there is none."""
    if name not in group:
        chunk = (min(max(len(rows), 64), LARGEST_CHUNK), *rows.shape[1:])
        group.create_dataset(name, data=rows, maxshape=(None, *rows.shape[1:]), chunks=chunk)
        return
    data = group[name]
    data.resize(len(data) + len(rows), axis=0)
    data[-len(rows) :] = rows


def _units(particles: Particles, units: Any) -> str:
    named = [("Points", units.length), ("time", units.time)]
    named += [(name, unit) for name, _, unit in fields(particles)]
    return ", ".join(f"{name} [{unit or '-'}]" for name, unit in named)


def _ascii(text: str) -> str:
    return text.replace("µ", "u").encode("ascii", "backslashreplace").decode()
