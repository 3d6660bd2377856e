"""Readers of other codes' files: each returns the particles, or points, of every time as ``Frame`` objects.

NumPy's archives, also PySPH's with its particles as Python objects. HDF5: tisph's own samples, PySPH's output, and any
file whose arrays lie together in one group. JSON: lists by name, {"x": [...], "u": [...]}, a list of these, or a list
of points, [{"x": 0.1, "u": 0.2}, ...]. LAMMPS' dumps as text (``dump custom``, ``write_dump``) and profiles (``fix
ave/chunk``), a frame a time step; where a dump has atoms of several types, walls may be among them: the types of the
fluid must be said. Tables as text: columns separated by semicolons, tabs, commas or blanks, with or without a header; a
comma is a decimal point where it does not separate the columns, and ``D`` may begin an exponent, as Fortran writes it.
VTK's files (legacy, XML and HDF5), by VTK itself: points or cell centres, and their data; collections of files.
Extended XYZ: a frame a time, with its columns and its time in the second line (of libAtoms, as ASE and OVITO).

``select`` names the group of particles to read, where a format has groups; None leaves the choice to the reader.
"""

import csv
import io
import json
import pickle
import re
import zipfile
import zlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree import ElementTree

import h5py
import numpy as np
from numpy.lib import format as npy

from tisph.assessment.columns import SIZES, SYMBOL, recognised
from tisph.errors import ConfigError


@dataclass(frozen=True)
class Frame:
    """Columns of one time by name, arrays (points,), as the file has them: its names, units and axes.

    ``time`` is None where the file does not say it; ``label`` may tell such frames of a file apart. ``units`` has the
    unit of a column, or of ``time``, where the file states one. ``notes`` say in words how it was read.
    """

    columns: dict[str, np.ndarray]
    time: float | None = None
    label: str = ""
    units: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def decoded(path):
    """Text of a file in UTF-16 with a byte-order mark, in UTF-8 or in Windows' cp1252; UnicodeDecodeError for none."""
    content = path.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252")


def time_of(entries):
    """The entry of a mapping that is called ``t``, ``time``, ``TIME`` or ``TimeValue``; None without one."""
    return next((entries[name] for name in entries if name == "t" or name.lower() in ("time", "timevalue")), None)


def split(arrays, path):
    """Frames of named arrays (points,), (points, components), (times, points) or (times, points, components).

    Raises ConfigError where it is not clear which index is the time.
    """
    arrays = {name: array for name, each in arrays.items() if (array := np.asarray(each)).dtype.kind in "fiub"}
    times = np.ravel([] if (found := time_of(arrays)) is None else found)
    one = {len(each) for each in arrays.values() if each.ndim == 1 or (each.ndim == 2 and each.shape[1] <= 3)}
    one -= {len(times)}  # numbers of points in arrays without a time; arrays as long as these have none either
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


def flat(arrays):
    """Columns (points,) of named ``arrays``: one of shape (points, k) becomes ``name_x``, ``name_y``, ``name_z``.

    Only numbers, and only arrays as long as the longest: others are no quantity of the points.
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


def pysph_frame(particles, time, select, path):
    """The frame of PySPH's own output, version 2: of its groups of ``particles`` by name."""
    group = chosen_group(particles, select, path)
    return Frame(flat(particles[group]["arrays"]), None if time is None else float(time))


def chosen_group(groups, wanted, path):
    """Name of the group of particles: the ``wanted`` one, else ``fluid`` or the like, else the only one.

    ``groups`` are their names. Raises ConfigError where that leaves a choice.
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
"""What an array, a number or a text is made of in a pickle: nothing that could run a program of the file's choice."""


class _Unpickler(pickle.Unpickler):
    def find_class(self, module, name):
        if (module, name) not in _HARMLESS:
            raise pickle.UnpicklingError(f"{module}.{name} is not read")
        return super().find_class(module, name)


def read_arrays(path, select=None):
    """Frames of the arrays, as ``split`` has them."""
    with zipfile.ZipFile(path) as archive:
        arrays = {name.removesuffix(".npy"): _array(archive.read(name), path) for name in archive.namelist()}
    if "particles" in arrays and isinstance(arrays["particles"], dict):
        return [pysph_frame(arrays["particles"], arrays.get("solver_data", {}).get("t"), select, path)]
    return split(arrays, path)


def _array(content, path):
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


def read_hdf5(path, select=None):
    """Frames in the order of their names; a group with an attribute ``t`` or ``time`` is one time."""
    try:
        with h5py.File(path, "r") as file:
            if "particles" in file and "solver_data" in file:
                return [pysph_frame(file["particles"], file["solver_data"].attrs.get("t"), select, path)]
            return _groups(file, select, path)
    except (OSError, RuntimeError, KeyError) as error:
        raise ConfigError(f"{path}: is no HDF5 file, or damaged: {error}") from None


def _groups(file, select, path):
    """Frames of every group that holds arrays; one time each, or particles of several kinds."""
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


def read_json(path, select=None):
    """Frames of the lists, as ``split`` has them; of a list of sets of lists those of each set."""
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


def read_lammps(path, select=None):
    """Frames in the order of the file; times where a dump has them (``dump_modify ... time yes``).

    ``select`` are the types of the fluid, such as ``1`` or ``1,2``.
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


def _profiles(lines, path):
    """Frames of the chunks that hold atoms, from blocks "step, number of chunks, number of atoms" and their rows.

    Chunks along one axis only are along y, whatever its name in LAMMPS is: the file does not say it.
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


def _dump(lines, path, select):
    found = {line[len(LAMMPS_ITEM) :]: index for index, line in enumerate(lines) if line.startswith(LAMMPS_ITEM)}
    atoms = next((name for name in found if name.startswith("ATOMS ")), None)
    if atoms is None or "NUMBER OF ATOMS" not in found:
        raise ConfigError(f"{path}: has no line 'ITEM: ATOMS' with the names of its columns, or none with their number")
    # a list of named columns, of which those that are no numbers (an element's name) are left out
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


def _selected(frame, select, path):
    """The frame of the atoms of the types ``select``, or of all where there is one type."""
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
"""In the order in which they are tried: the first one that makes a row of numbers out of a line is taken."""

TIME = re.compile(r"[#% ]*(?:t|time)\s*[=:]?\s*([-+.,\d]+(?:e[-+]?\d+)?)\s*\[?([a-z]*)\]?", re.IGNORECASE)
"""A line with the time of a block, such as ``# t = 0.5`` or ``# time: 3 ms``."""

NAME = re.compile(r"(?:\"[^\"]*\"|'[^']*'|\S+)(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
"""A name between blanks, with its unit."""


def read_text(path, select=None):
    """A frame for every block of rows; columns are called as the header says, or ``1``, ``2``, ... from the left.

    An empty line or one without numbers ends a block. Lines that begin with ``#`` or ``%`` are comments; the last one
    before the numbers may be the header, with a row of units below it. Blocks share the last header before them.
    """
    text = re.sub(r"(?<=[\d.])[dD](?=[-+\d]\d)", "e", decoded(path).replace("\r\r\n", "\n"))
    lines = [line.strip() for line in text.splitlines()]
    separator = next((each for line in lines for each in SEPARATORS if _row(_cells(line, each))), None)
    if separator is None:
        raise ConfigError(f"{path}: has no line of numbers")
    frames, header, head, rows, cells, signs = [], ([], {}), [], [], [], set()
    for number, line in enumerate([*lines, ""], 1):
        above, cells = cells, _cells(line, separator)
        row = _row(cells)
        fits = row and len(row) == len(rows[0] if rows else row)
        damaged = cells if rows and not fits else above if fits and not rows and len(above) == len(row) else []
        if any(cell and _number(cell) is not None for cell in damaged):
            line_of = number if rows else number - 1
            raise ConfigError(f"{path}: line {line_of} is no row of numbers as the others: {separator.join(damaged)}")
        if fits:
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


def _block(names, units, head, rows, label):
    table = np.array(rows).T
    names = names if len(names) == len(table) else [""] * len(table)
    called = [name if name and names.count(name) == 1 else str(index) for index, name in enumerate(names, 1)]
    time = next((match for line in head if (match := TIME.fullmatch(line))), None)
    units = units | ({"time": time[2]} if time else {})
    return Frame(dict(zip(called, table, strict=True)), time and _number(time[1]), label=label, units=units)


def _header(head, separator, width):
    """Names of the columns, and units by name, from the lines before the numbers; None where there are no names."""
    found = [names for line in head if (names := _names(line.lstrip("#% "), separator, width))]
    symbols = {symbol for name in (found or [[]])[-1] for symbol, _ in re.findall(SYMBOL, name)}
    if len(found) > 1 and symbols <= {symbol for sizes in SIZES.values() for symbol in sizes}:
        return found[-2], {name: unit.strip("[]()") for name, unit in zip(*found[-2:], strict=True) if unit}
    return (found[-1], {}) if found else None


def _names(line, separator, width):
    """The ``width`` names in a header, however it separates them; None for any other line."""
    ways = [_cells(line, each) for each in (separator, *SEPARATORS)] + [NAME.findall(line), re.split(r"\s{2,}", line)]
    found = [[cell.strip(" \t,;\"'") for cell in cells] for cells in ways if len(cells) == width]
    return next((names for names in found if {_number(name) for name in names if name} == {None}), None)


def _cells(line, separator):
    """Texts of the columns of a line; none of a comment."""
    if line.startswith(("#", "%")):
        return []
    split = [line.split()] if separator == " " else csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [cell.strip(" \t\"'") for cell in next(iter(split), [])]


def _row(cells):
    """Numbers of two or more columns, NaN in an empty one; None where one is no number, or all are empty."""
    row = [_number(cell) for cell in cells]
    return row if len(row) > 1 and any(cells) and None not in row else None


def _number(text):
    try:
        return float(text.replace(",", ".") or "nan")
    except ValueError:
        return None


def read_vtk(path, select=None):
    """A frame a time of the file; the time is that of its steps, or the field data ``time`` or ``TimeValue``."""
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


def _collection(path, select):
    """Frames of the files that a collection names, at its times; ``select`` is one of its parts."""
    try:
        parts = {}
        for entry in ElementTree.parse(path).iterfind(".//DataSet"):
            time, part = entry.get("timestep"), entry.get("name") or entry.get("part") or "0"
            parts.setdefault(part, []).append((path.parent / entry.get("file"), time and float(time)))
    except (ElementTree.ParseError, TypeError, ValueError) as error:
        raise ConfigError(f"{path}: is no collection of VTK files: {error}") from None
    files = parts[chosen_group(tuple(parts), select, path)]
    return [replace(each, time=each.time if time is None else time) for file, time in files for each in read_vtk(file)]


def _only_time(path):
    """Time of a VTKHDF file with one step, which its reader does not tell; None for any other."""
    if path.suffix != ".vtkhdf":
        return None
    with h5py.File(path, "r") as file:
        values = file.get("VTKHDF/Steps/Values")
        return None if values is None else float(values[0])


def _vtk_reader(path):
    """VTK's reader of the file, and the key of its times."""
    try:
        from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
        from vtkmodules.vtkIOHDF import vtkHDFReader
        from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader
        from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader, vtkXMLPUnstructuredGridReader
    except ImportError:
        raise ConfigError(f"{path}: reading it needs VTK: pip install '.[vtk]' in a clone") from None
    kinds = {".vtk": vtkGenericDataObjectReader, ".vtkhdf": vtkHDFReader, ".pvtu": vtkXMLPUnstructuredGridReader}
    return kinds.get(path.suffix, vtkXMLGenericDataObjectReader)(), vtkStreamingDemandDrivenPipeline.TIME_STEPS()


def _vtk_frame(data, time, path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCellCenters

    if data is None or not hasattr(data, "GetNumberOfPoints") or not data.GetNumberOfPoints():
        raise ConfigError(f"{path}: has no points, or VTK cannot read it")
    fields, notes = _vtk_arrays(data.GetFieldData(), vtk_to_numpy), ()
    if time is None and (found := time_of(fields)) is not None:
        time = float(found[0])
    if recognised(
        "u", {name: name for name in flat(_vtk_arrays(data.GetCellData(), vtk_to_numpy))}
    ):  # beside these the data of points are interpolated
        centres, notes = vtkCellCenters(), ("the data of the cells are taken, at the cell centres",)
        centres.SetInputData(data)
        centres.Update()
        data = centres.GetOutput()
    arrays = {"points": _vtk_places(data, vtk_to_numpy), **_vtk_arrays(data.GetPointData(), vtk_to_numpy)}
    return Frame(flat(arrays), time, notes=notes)


def _vtk_places(data, as_array):
    if hasattr(data, "GetPoints") and hasattr(data.GetPoints(), "GetData"):
        return as_array(data.GetPoints().GetData())
    return [data.GetPoint(index) for index in range(data.GetNumberOfPoints())]  # an image has none of its own


def _vtk_arrays(holder, as_array):
    names = [(holder.GetArrayName(index), holder.GetArray(index)) for index in range(holder.GetNumberOfArrays())]
    return {name: as_array(array) for name, array in names if name and array is not None}


def read_xyz(path, select=None):
    """Frames in the order of the file."""
    lines, frames = [line for line in decoded(path).splitlines() if line.strip()], []
    try:
        while lines:
            count, about = int(lines[0]), lines[1]
            parts = re.search(r"Properties=(\S+)", about)[1].split(":")
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
"""By the endings of file names."""

HDF5 = b"\x89HDF\r\n\x1a\n"


def frames(path, select=None):
    """Return the frames of the file ``path``: by what it begins with where that says it, else by its ending.

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


def _reader(path, begins):
    if begins.startswith((LAMMPS_ITEM.encode(), LAMMPS_CHUNKS.encode())):
        return read_lammps
    if begins.startswith(HDF5) and path.suffix != ".vtkhdf":
        return read_hdf5
    return next((read for suffixes, read in READERS.items() if path.suffix.lower() in suffixes), read_text)
