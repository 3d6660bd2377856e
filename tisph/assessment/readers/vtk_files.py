"""VTK's files (legacy, XML and HDF5), by VTK itself: points or cell centres, and their data; collections of files."""

from dataclasses import replace
from xml.etree import ElementTree

import h5py

from tisph.assessment.columns import recognised
from tisph.assessment.readers.frame import Frame, chosen_group, flat, time_of
from tisph.errors import ConfigError

SUFFIXES = (".vtk", ".vtu", ".vtp", ".vti", ".vtr", ".vts", ".pvtu", ".pvtp", ".vtkhdf", ".pvd")


def read(path, select=None):
    """A frame a time of the file; the time is that of its steps, or the field data ``time`` or ``TimeValue``."""
    if path.suffix == ".pvd":
        return _collection(path, select)
    reader, key = _reader(path)
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    steps = 0 if path.suffix == ".vtk" else information.Length(key)  # the legacy format has none, its reader says 0.0
    times, frames = [information.Get(key, step) for step in range(steps)], []
    if not times:
        reader.Update()
        return [_frame(reader.GetOutputDataObject(0), _only_time(path), path)]
    for time in times:
        reader.UpdateTimeStep(time)
        frames.append(_frame(reader.GetOutputDataObject(0), time, path))
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
    return [replace(each, time=each.time if time is None else time) for file, time in files for each in read(file)]


def _only_time(path):
    """Time of a VTKHDF file with one step, which its reader does not tell; None for any other."""
    if path.suffix != ".vtkhdf":
        return None
    with h5py.File(path, "r") as file:
        values = file.get("VTKHDF/Steps/Values")
        return None if values is None else float(values[0])


def _reader(path):
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


def _frame(data, time, path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkFiltersCore import vtkCellCenters

    if data is None or not hasattr(data, "GetNumberOfPoints") or not data.GetNumberOfPoints():
        raise ConfigError(f"{path}: has no points, or VTK cannot read it")
    fields, notes = _arrays(data.GetFieldData(), vtk_to_numpy), ()
    if time is None and (found := time_of(fields)) is not None:
        time = float(found[0])
    if recognised(
        "u", {name: name for name in flat(_arrays(data.GetCellData(), vtk_to_numpy))}
    ):  # beside these the data of points are interpolated
        centres, notes = vtkCellCenters(), ("the data of the cells are taken, at the cell centres",)
        centres.SetInputData(data)
        centres.Update()
        data = centres.GetOutput()
    arrays = {"points": _places(data, vtk_to_numpy), **_arrays(data.GetPointData(), vtk_to_numpy)}
    return Frame(flat(arrays), time, notes=notes)


def _places(data, as_array):
    if hasattr(data, "GetPoints") and hasattr(data.GetPoints(), "GetData"):
        return as_array(data.GetPoints().GetData())
    return [data.GetPoint(index) for index in range(data.GetNumberOfPoints())]  # an image has none of its own


def _arrays(holder, as_array):
    names = [(holder.GetArrayName(index), holder.GetArray(index)) for index in range(holder.GetNumberOfArrays())]
    return {name: as_array(array) for name, array in names if name and array is not None}
