"""Readers of other codes' files: each returns the particles, or points, of every time as ``Frame`` objects.

- NumPy's archives, also PySPH's with its particles as Python objects.
- HDF5: tisph's own samples, PySPH's output, and any file whose arrays are in one group.
- JSON: lists by name, {"x": [...], "u": [...]}, a list of these, or a list of points, [{"x": 0.1, "u": 0.2}, ...].
- LAMMPS: dumps as text (``dump custom``, ``write_dump``) and profiles (``fix ave/chunk``), a frame for each time step.
  If a dump has atoms of several types, some may be walls: the user must name the types of the fluid.
- Tables as text: columns separated by semicolons, tabs, commas or blanks, with or without a header. A comma that does
  not separate columns is a decimal point, and ``D`` may begin an exponent, as in Fortran.
- VTK's files (legacy, XML and HDF5), read by VTK itself: points or cell centres, and their data; collections of files.
- Extended XYZ (libAtoms, ASE, OVITO): a frame for each time, with its columns and its time in the second line.

``select`` names the group of particles to read, if a format has groups; None leaves the choice to the reader.
"""

import csv
import io
import json
import pickle
import re
import zipfile
import zlib
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import h5py
import numpy as np
from numpy.lib import format as npy

from tisph.assessment.columns import SIZES, SYMBOL, Frame, recognised
from tisph.errors import ConfigError


def decoded(path: Path) -> str:
    """Return the text of a file in UTF-16 with a byte-order mark, in UTF-8 or in Windows' cp1252.

    UnicodeDecodeError if it is in none of these encodings.
    """
    content = path.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252")


def time_of(entries: Mapping[str, Any]) -> Any:
    """Return the entry ``t``, ``time``, ``TIME`` or ``TimeValue`` of a mapping; None without such an entry."""
    return next((entries[name] for name in entries if name == "t" or name.lower() in ("time", "timevalue")), None)


def split(arrays: Mapping[str, Any], path: Path) -> list[Frame]:
    """Return the frames of arrays (points,), (points, components), (times, points) or (times, points, components).

    ``arrays``: by name. Raises ConfigError where it is not clear which index is the time.
    """
    arrays = {name: array for name, each in arrays.items() if (array := np.asarray(each)).dtype.kind in "fiub"}
    times = np.ravel([] if (found := time_of(arrays)) is None else found)
    one = {len(each) for each in arrays.values() if each.ndim == 1 or (each.ndim == 2 and each.shape[1] <= 3)}
    one -= {len(times)}  # numbers of points of arrays without a time index; arrays of this length have none either
    many = {name: each for name, each in arrays.items() if each.ndim > 1 and each.shape[1] > 3 and len(each) not in one}
    if not many and (len(times) < 2 or not one):
        return [Frame(flat(arrays), float(times[0]) if len(times) == 1 else None)]
    (count, points), *others = {each.shape[:2] for each in many.values()} or {(0, 0)}
    if others or count == points or len(times) not in (0, count):
        shapes = ", ".join(f"{name} {each.shape}" for name, each in arrays.items())
        raise ConfigError(f"{path}: which index is the time? It must be the first one; the arrays are {shapes}")
    fixed = {name: each for name, each in arrays.items() if name not in many and each.ndim and len(each) == points}
    found = [flat(fixed | {name: each[index] for name, each in many.items()}) for index in range(count)]
    return [Frame(*each) for each in zip(found, times.tolist() or [None] * count, strict=True)]


def flat(arrays: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return columns (points,) of named ``arrays``; an array (points, k) becomes ``name_x``, ``name_y``, ``name_z``.

    Arrays without numbers, or shorter than the longest one, are no quantities of the points and are left out.
    """
    columns = {}
    for name, array in arrays.items():
        array = np.asarray(array)
        if array.dtype.kind not in "fiub" or array.ndim not in (1, 2):
            continue
        if array.ndim == 1:
            columns[name] = array.astype(float)
        elif array.shape[1] <= 3:
            columns |= {f"{name}_{axis}": group.astype(float) for axis, group in zip("xyz", array.T, strict=False)}
    longest = max((len(column) for column in columns.values()), default=0)
    return {name: column for name, column in columns.items() if len(column) == longest}


def pysph_frame(particles: Mapping[str, Any], time: Any, select: str | None, path: Path) -> Frame:
    """Return the frame of PySPH's own output, version 2; ``particles``: its groups by name."""
    group = chosen_group(particles, select, path)
    return Frame(flat(particles[group]["arrays"]), None if time is None else float(time))


def chosen_group(groups: Collection[str], wanted: str | None, path: Path) -> str:
    """Return the name of the group to read: ``wanted``, else ``fluid``, ``liquid`` or ``water``, else the only one.

    ``groups``: names. Raises ConfigError where that leaves a choice.
    """
    if wanted:
        if wanted not in groups:
            raise ConfigError(f"{path}: has no particles called {wanted}; it has {', '.join(groups)}")
        return wanted
    fluid = [name for name in groups if name.lower() in ("fluid", "liquid", "water")]
    if fluid or len(groups) == 1:
        return (fluid or list(groups))[0]
    raise ConfigError(f"{path}: which particles are the fluid? Give --select {' or --select '.join(groups)}")


_HARMLESS = {
    (module, name)
    for core in ("numpy.core", "numpy._core")
    for module, names in (
        (f"{core}.multiarray", ("_reconstruct", "scalar")),
        (f"{core}.numeric", ("_frombuffer",)),
        ("numpy", ("ndarray", "dtype")),
        ("_codecs", ("encode",)),
    )
    for name in names
}
"""Names in the pickle of an array, a number or a text; none of them can run a program that the file chooses."""


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        if (module, name) not in _HARMLESS:
            raise pickle.UnpicklingError(f"{module}.{name} is not read")
        return super().find_class(module, name)


def read_arrays(path: Path, select: str | None = None) -> list[Frame]:
    """Return the frames of a NumPy archive."""
    with zipfile.ZipFile(path) as archive:
        arrays = {name.removesuffix(".npy"): _array(archive.read(name), path) for name in archive.namelist()}
    if "particles" in arrays and isinstance(arrays["particles"], dict):
        return [pysph_frame(arrays["particles"], arrays.get("solver_data", {}).get("t"), select, path)]
    return split(arrays, path)


def _array(content: bytes, path: Path) -> Any:
    stream = io.BytesIO(content)
    version = npy.read_magic(stream)
    _, _, kind = npy.read_array_header_1_0(stream) if version == (1, 0) else npy.read_array_header_2_0(stream)
    if not kind.hasobject:
        return np.load(io.BytesIO(content), allow_pickle=False)
    try:
        found = _Unpickler(stream).load()
    except pickle.UnpicklingError as error:
        raise ConfigError(f"{path}: holds Python objects that are not read: {error}") from None
    return found.item() if found.ndim == 0 else found


def read_hdf5(path: Path, select: str | None = None) -> list[Frame]:
    """Return the frames of an HDF5 file in the order of names; a group with attribute ``t`` or ``time`` is a frame."""
    try:
        with h5py.File(path, "r") as file:
            if "particles" in file and "solver_data" in file:
                return [pysph_frame(file["particles"], file["solver_data"].attrs.get("t"), select, path)]
            return _groups(file, select, path)
    except (OSError, RuntimeError, KeyError) as error:
        raise ConfigError(f"{path}: is no HDF5 file, or damaged: {error}") from None


def _groups(file: h5py.File, select: str | None, path: Path) -> list[Frame]:
    """Return the frames of all groups with arrays: each group is one time, or one kind of particles."""
    items, groups = {"": file}, {}
    file.visititems(lambda name, item: items.update({name: item}))
    for name, item in items.items():
        if isinstance(item, h5py.Group) and name.rpartition("/")[2] != "bodies":
            data = {key: each for key, each in item.items() if isinstance(each, h5py.Dataset)}
            if sum(each.ndim > 0 and each.dtype.kind in "fiu" for each in data.values()) > 1:
                time = time_of(item.attrs)
                groups[name] = {key: each[()] for key, each in data.items()} | ({} if time is None else {"t": time})
    if not groups:
        raise ConfigError(f"{path}: has no group with arrays of one length")
    if len(groups) > 1 and any(time_of(arrays) is None for arrays in groups.values()):
        groups = {name: groups[name] for name in [chosen_group(list(groups), select, path)]}
    return [frame for arrays in groups.values() for frame in split(arrays, path)]


def read_json(path: Path, select: str | None = None) -> list[Frame]:
    """Return the frames of lists by name, of a list of such maps, or of a list of points."""
    try:
        data = json.loads(decoded(path))
        if isinstance(data, list) and not any(isinstance(value, list) for value in data[0].values()):
            data = {name: [point[name] for point in data] for name in data[0]}
        sets = data if isinstance(data, list) else [data]
        return [frame for each in sets for frame in split(each, path)]
    except (ValueError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise ConfigError(f"{path}: is neither lists by name nor a list of points: {error}") from None


LAMMPS_ITEM = "ITEM: "
LAMMPS_CHUNKS = "# Chunk-averaged data"


def read_lammps(path: Path, select: str | None = None) -> list[Frame]:
    """Return the frames of a LAMMPS dump or profile in the order of the file.

    A dump has times after ``dump_modify ... time yes``. ``select``: types of the fluid, such as ``1`` or ``1,2``.
    """
    lines = decoded(path).splitlines()
    if lines and lines[0].startswith(LAMMPS_CHUNKS):
        return _profiles(lines, path)
    starts = [index for index, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP")]
    if not starts:
        raise ConfigError(f"{path}: has no line 'ITEM: TIMESTEP'")
    # the time of a frame is written before its step
    starts = [index - 2 if lines[index - 2].strip() == "ITEM: TIME" else index for index in starts]
    ends = [*starts[1:], len(lines)]
    return [_dump(lines[start:end], path, select) for start, end in zip(starts, ends, strict=True)]


def _profiles(lines: list[str], path: Path) -> list[Frame]:
    """Return a frame for each block "step, number of chunks, number of atoms", from its chunks that contain atoms.

    The file does not name the axis of chunks along one axis: it is taken to be y.
    """
    rows, frames = [line.split() for line in lines if not line.startswith("#")], []
    try:
        names = lines[2].lstrip("# ").split()
        names = ["y" if name == "Coord1" and "Coord2" not in names else name for name in names]
        while rows:
            step, count = rows[0][0], int(rows[0][1])
            table = np.array(rows[1 : count + 1], dtype=float).reshape(count, len(names))
            columns = dict(zip(names, table[table[:, names.index("Ncount")] > 0].T, strict=True))
            frames.append(Frame(columns, label=f"step {step}"))
            rows = rows[count + 1 :]
    except (ValueError, IndexError) as error:
        raise ConfigError(f"{path}: is damaged after {len(frames)} blocks of chunks: {error}") from None
    return frames


def _dump(lines: list[str], path: Path, select: str | None) -> Frame:
    found = {line[len(LAMMPS_ITEM) :]: index for index, line in enumerate(lines) if line.startswith(LAMMPS_ITEM)}
    atoms = next((name for name in found if name.startswith("ATOMS ")), None)
    if atoms is None or "NUMBER OF ATOMS" not in found:
        raise ConfigError(f"{path}: has no line 'ITEM: ATOMS' with the names of its columns, or none with their number")
    # columns without numbers, such as names of elements, are left out
    rows = [line.split() for line in lines[found[atoms] + 1 :] if line and not line.startswith(LAMMPS_ITEM)]
    if [str(len(rows))] != lines[found["NUMBER OF ATOMS"] + 1].split() or len({len(row) for row in rows}) != 1:
        raise ConfigError(f"{path}: a frame is damaged: it has {len(rows)} rows, or rows of several lengths")
    columns = {}
    for name, cells in zip(atoms.split()[1:], zip(*rows, strict=False), strict=False):
        try:
            columns[name] = np.array(cells, dtype=float)
        except ValueError:
            continue
    before = next((float(lines[index + 1]) for name, index in found.items() if name == "TIME"), None)
    return _selected(Frame(columns, before, label=f"step {lines[found['TIMESTEP'] + 1]}"), select, path)


def _selected(frame: Frame, select: str | None, path: Path) -> Frame:
    """Return the frame of the atoms of the types ``select``, or of all atoms if there is one type."""
    types = frame.columns.get("type", np.zeros(0))
    known = [f"{each:g}" for each in np.unique(types)]
    if select is None and len(known) < 2:
        return frame
    if select is None:
        raise ConfigError(f"{path}: which types are the fluid? Give --select {known[0]}; it has {', '.join(known)}")
    wanted = select.split(",")
    if not set(wanted) <= set(known):
        raise ConfigError(f"{path}: has no atoms of type {select}; it has {', '.join(known) or 'no types'}")
    chosen = np.isin(types, np.array(wanted, dtype=float))
    columns = {name: column[chosen] for name, column in frame.columns.items()}
    return replace(frame, columns=columns)


SEPARATORS = (";", "\t", ",", " ")
"""Separators in the order in which they are tried: the first one that splits a line into a row of numbers is taken."""

TIME = re.compile(r"[#% ]*(?:t|time)\s*[=:]?\s*([-+.,\d]+(?:e[-+]?\d+)?)\s*\[?([a-z]*)\]?", re.IGNORECASE)
"""Pattern of a line with the time of a block, such as ``# t = 0.5`` or ``# time: 3 ms``."""

NAME = re.compile(r"(?:\"[^\"]*\"|'[^']*'|\S+)(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
"""Pattern of a name between blanks, with its unit."""


def read_text(path: Path, select: str | None = None) -> list[Frame]:
    """Return a frame for every block of rows; columns have the names of the header, or ``1``, ``2``, ... from the left.

    An empty line or one without numbers ends a block. Lines that begin with ``#`` or ``%`` are comments; the last
    comment before the numbers may be the header, with a row of units below it. A block without a header has the names
    of the block before.
    """
    text = re.sub(r"(?<=[\d.])[dD](?=[-+\d]\d)", "e", decoded(path).replace("\r\r\n", "\n"))
    lines = [line.strip() for line in text.splitlines()]
    separator = next((each for line in lines for each in SEPARATORS if _row(_cells(line, each))), None)
    if separator is None:
        raise ConfigError(f"{path}: has no line of numbers")
    frames: list[Frame] = []
    header: tuple[list[str], dict[str, str]] = ([], {})
    head: list[str] = []
    rows: list[list[float]] = []
    cells: list[str] = []
    signs: set[str] = set()
    for number, line in enumerate([*lines, ""], 1):
        above, cells = cells, _cells(line, separator)
        row = _row(cells)
        fits = row is not None and len(row) == len(rows[0] if rows else row)
        damaged = cells if rows and not fits else above if fits and not rows and len(above) == len(cells) else []
        if any(cell and _number(cell) is not None for cell in damaged):
            line_of = number if rows else number - 1
            raise ConfigError(f"{path}: line {line_of} is no row of numbers as the others: {separator.join(damaged)}")
        if row is not None and fits:
            rows.append(row)
            signs |= {sign for sign in ".," if any(sign in cell for cell in cells)}
            continue
        if rows:
            header = _header(head, separator, len(rows[0])) or header
            frames.append(_block(*header, head, rows, f"lines {number - len(rows)} to {number - 1}"))
            head, rows = [], []
        head += [line] if line else []
    if len(signs) > 1:
        raise ConfigError(f"{path}: some numbers have a decimal point, others a comma")
    return frames


def _block(names: list[str], units: dict[str, str], head: list[str], rows: list[list[float]], label: str) -> Frame:
    table = np.array(rows).T
    names = names if len(names) == len(table) else [""] * len(table)
    called = [name if name and names.count(name) == 1 else str(index) for index, name in enumerate(names, 1)]
    time = next((match for line in head if (match := TIME.fullmatch(line))), None)
    units = units | ({"time": time[2]} if time else {})
    return Frame(dict(zip(called, table, strict=True)), time and _number(time[1]), label=label, units=units)


def _header(head: list[str], separator: str, width: int) -> tuple[list[str], dict[str, str]] | None:
    """Return the names of the columns, and units by name, from the lines before the numbers; None without names."""
    found = [names for line in head if (names := _names(line.lstrip("#% "), separator, width))]
    symbols = {symbol for name in (found or [[]])[-1] for symbol, _ in re.findall(SYMBOL, name)}
    if len(found) > 1 and symbols <= {symbol for sizes in SIZES.values() for symbol in sizes}:
        return found[-2], {name: unit.strip("[]()") for name, unit in zip(*found[-2:], strict=True) if unit}
    return (found[-1], {}) if found else None


def _names(line: str, separator: str, width: int) -> list[str] | None:
    """Return the ``width`` names in a header, with any separator; None for any other line."""
    ways = [_cells(line, each) for each in (separator, *SEPARATORS)] + [NAME.findall(line), re.split(r"\s{2,}", line)]
    found = [[cell.strip(" \t,;\"'") for cell in cells] for cells in ways if len(cells) == width]
    return next((names for names in found if {_number(name) for name in names if name} == {None}), None)


def _cells(line: str, separator: str) -> list[str]:
    """Return the texts of the columns of a line; none for a comment."""
    if line.startswith(("#", "%")):
        return []
    split = [line.split()] if separator == " " else csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [cell.strip(" \t\"'") for cell in next(iter(split), [])]


def _row(cells: list[str]) -> list[float] | None:
    """Return the numbers of two or more columns, NaN for empty cells; None if a cell is no number or all are empty."""
    row = [number for cell in cells if (number := _number(cell)) is not None]
    return row if len(row) == len(cells) > 1 and any(cells) else None


def _number(text: str) -> float | None:
    try:
        return float(text.replace(",", ".") or "nan")
    except ValueError:
        return None


def read_vtk(path: Path, select: str | None = None) -> list[Frame]:
    """Return a frame for each time of a VTK file, from its time steps or the field data ``time`` or ``TimeValue``."""
    if path.suffix == ".pvd":
        return _collection(path, select)
    reader, key = _vtk_reader(path)
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    steps = 0 if path.suffix == ".vtk" else information.Length(key)  # the legacy format has none, its reader says 0.0
    times, frames = [information.Get(key, step) for step in range(steps)], []
    if not times:
        reader.Update()
        return [_vtk_frame(reader.GetOutputDataObject(0), _only_time(path), path)]
    for time in times:
        reader.UpdateTimeStep(time)
        frames.append(_vtk_frame(reader.GetOutputDataObject(0), time, path))
    return frames


def _collection(path: Path, select: str | None) -> list[Frame]:
    """Return the frames of the files of a collection, at its times; ``select``: one of its parts."""
    try:
        parts: dict[str, list[tuple[Path, float | None]]] = {}
        for entry in ElementTree.parse(path).iterfind(".//DataSet"):
            time, part = entry.get("timestep"), entry.get("name") or entry.get("part") or "0"
            file = path.parent / entry.attrib["file"]
            parts.setdefault(part, []).append((file, float(time) if time else None))
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise ConfigError(f"{path}: is no collection of VTK files: {error}") from None
    files = parts[chosen_group(tuple(parts), select, path)]
    return [replace(each, time=each.time if time is None else time) for file, time in files for each in read_vtk(file)]


def _only_time(path: Path) -> float | None:
    """Return the time of a VTKHDF file with one step, which VTK's reader does not return; None for any other file."""
    if path.suffix != ".vtkhdf":
        return None
    with h5py.File(path, "r") as file:
        values = file.get("VTKHDF/Steps/Values")
        return None if values is None else float(values[0])


def _vtk_reader(path: Path) -> tuple[Any, Any]:
    """Return VTK's reader of the file, and the key of its times."""
    try:
        from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
        from vtkmodules.vtkIOHDF import vtkHDFReader
        from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader
        from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader, vtkXMLPUnstructuredGridReader
    except ImportError:
        raise ConfigError(f"{path}: reading it needs VTK: pip install '.[vtk]' in a clone") from None
    kinds = {".vtk": vtkGenericDataObjectReader, ".vtkhdf": vtkHDFReader, ".pvtu": vtkXMLPUnstructuredGridReader}
    return kinds.get(path.suffix, vtkXMLGenericDataObjectReader)(), vtkStreamingDemandDrivenPipeline.TIME_STEPS()


def _vtk_frame(data: Any, time: Any, path: Path) -> Frame:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCellCenters

    if data is None or not hasattr(data, "GetNumberOfPoints") or not data.GetNumberOfPoints():
        raise ConfigError(f"{path}: has no points, or VTK cannot read it")
    fields = _vtk_arrays(data.GetFieldData(), vtk_to_numpy)
    notes: tuple[str, ...] = ()
    if time is None and (found := time_of(fields)) is not None:
        time = float(found[0])
    names = flat(_vtk_arrays(data.GetCellData(), vtk_to_numpy))
    if recognised("u", {name: name for name in names}):  # data of points beside data of cells are interpolated
        centres, notes = vtkCellCenters(), ("the data of the cells are taken, at the cell centres",)
        centres.SetInputData(data)
        centres.Update()
        data = centres.GetOutput()
    arrays = {"points": _vtk_places(data, vtk_to_numpy), **_vtk_arrays(data.GetPointData(), vtk_to_numpy)}
    return Frame(flat(arrays), time, notes=notes)


def _vtk_places(data: Any, as_array: Callable) -> Any:
    if hasattr(data, "GetPoints") and hasattr(data.GetPoints(), "GetData"):
        return as_array(data.GetPoints().GetData())
    return [data.GetPoint(index) for index in range(data.GetNumberOfPoints())]  # an image has none of its own


def _vtk_arrays(holder: Any, as_array: Callable) -> dict[str, np.ndarray]:
    names = [(holder.GetArrayName(index), holder.GetArray(index)) for index in range(holder.GetNumberOfArrays())]
    return {name: as_array(array) for name, array in names if name and array is not None}


def read_xyz(path: Path, select: str | None = None) -> list[Frame]:
    """Return the frames of an extended XYZ file in the order of the file."""
    lines, frames = [line for line in decoded(path).splitlines() if line.strip()], []
    try:
        while lines:
            count, about = int(lines[0]), lines[1]
            properties: Any = re.search(r"Properties=(\S+)", about)  # TypeError without one
            parts = properties[1].split(":")
            names, kinds, widths = parts[::3], parts[1::3], [int(width) for width in parts[2::3]]
            table = np.array([line.split() for line in lines[2 : count + 2]]).reshape(count, sum(widths))
            groups = zip(names, kinds, np.split(table, np.cumsum(widths)[:-1], axis=1), strict=True)
            arrays = {name: group.astype(float) for name, kind, group in groups if kind in "RI"}
            columns = flat({name: group[:, 0] if group.shape[1] == 1 else group for name, group in arrays.items()})
            time = re.search(r"\btime=(\S+)", about, re.IGNORECASE)
            frames.append(Frame(columns, float(time[1]) if time else None))
            lines = lines[count + 2 :]
    except (ValueError, IndexError, TypeError) as error:
        raise ConfigError(f"{path}: frame {len(frames) + 1} is no extended XYZ: {error}") from None
    return frames


READERS = {
    (".npz",): read_arrays,
    (".h5", ".hdf5", ".hdf"): read_hdf5,
    (".json",): read_json,
    (".dump", ".lammpstrj"): read_lammps,
    (".csv", ".tsv", ".txt", ".dat", ".xy", ""): read_text,
    (".vtk", ".vtu", ".vtp", ".vti", ".vtr", ".vts", ".pvtu", ".pvtp", ".vtkhdf", ".pvd"): read_vtk,
    (".xyz", ".extxyz"): read_xyz,
}
"""Endings of file names -> reader."""

HDF5 = b"\x89HDF\r\n\x1a\n"


def frames(path: Path, select: str | None = None) -> list[Frame]:
    """Return the frames of the file ``path``, whose format its first bytes or else the ending of its name determine.

    Raises ConfigError where it cannot be read.
    """
    path = Path(path)
    try:
        with open(path, "rb") as file:
            begins = file.read(32)
        if found := _reader(path, begins)(path, select):
            return found
        raise ConfigError(f"{path}: is empty")
    except UnicodeDecodeError:
        known = ", ".join(suffix for suffixes in READERS for suffix in suffixes if suffix)
        raise ConfigError(f"{path}: is no text, and its ending {path.suffix} is none of {known}") from None
    except (OSError, EOFError, NotImplementedError, zipfile.BadZipFile, zlib.error) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _reader(path: Path, begins: bytes) -> Callable[[Path, str | None], list[Frame]]:
    if begins.startswith((LAMMPS_ITEM.encode(), LAMMPS_CHUNKS.encode())):
        return read_lammps
    if begins.startswith(HDF5) and path.suffix != ".vtkhdf":
        return read_hdf5
    return next((read for suffixes, read in READERS.items() if path.suffix.lower() in suffixes), read_text)
