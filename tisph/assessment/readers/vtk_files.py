"""VTK's files (legacy, XML and HDF5), by VTK itself: points and their data."""

import h5py

from tisph.assessment.readers.frame import Frame, flat
from tisph.errors import ConfigError

SUFFIXES = (".vtk", ".vtu", ".vtp", ".vti", ".vtr", ".vts", ".pvtu", ".pvtp", ".vtkhdf")


def read(path, select=None):
    """A frame a time of the file; the time is that of its steps, or the field data ``TimeValue``."""
    reader = _reader(path)
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    key = _executive().TIME_STEPS()
    information = reader.GetOutputInformation(0)
    times = [information.Get(key, step) for step in range(information.Length(key))]
    if not times:
        reader.Update()
        return [_frame(reader.GetOutputDataObject(0), _only_time(path), path)]
    frames = []
    for time in times:
        reader.UpdateTimeStep(time)
        frames.append(_frame(reader.GetOutputDataObject(0), time, path))
    return frames


def _only_time(path):
    """Time of a VTKHDF file with one step, which its reader does not tell; None for any other."""
    if path.suffix != ".vtkhdf":
        return None
    with h5py.File(path, "r") as file:
        values = file.get("VTKHDF/Steps/Values")
        return None if values is None else float(values[0])


def _reader(path):
    try:
        from vtkmodules.vtkIOHDF import vtkHDFReader
        from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader
        from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader, vtkXMLPUnstructuredGridReader
    except ImportError:
        raise ConfigError(f"{path}: reading it needs VTK: pip install '.[vtk]' in a clone") from None
    if path.suffix == ".pvtu":
        return vtkXMLPUnstructuredGridReader()
    return {".vtk": vtkGenericDataObjectReader, ".vtkhdf": vtkHDFReader}.get(
        path.suffix, vtkXMLGenericDataObjectReader
    )()


def _executive():
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    return vtkStreamingDemandDrivenPipeline


def _frame(data, time, path):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if data is None or not hasattr(data, "GetNumberOfPoints") or not data.GetNumberOfPoints():
        raise ConfigError(f"{path}: has no points, or VTK cannot read it")
    arrays = {"points": _places(data, vtk_to_numpy), **_arrays(data.GetPointData(), vtk_to_numpy)}
    fields = _arrays(data.GetFieldData(), vtk_to_numpy)
    if time is None and "TimeValue" in fields:
        time = float(fields["TimeValue"][0])
    return Frame(flat(arrays), time)


def _places(data, as_array):
    if hasattr(data, "GetPoints") and hasattr(data.GetPoints(), "GetData"):
        return as_array(data.GetPoints().GetData())
    return [data.GetPoint(index) for index in range(data.GetNumberOfPoints())]  # an image has none of its own


def _arrays(holder, as_array):
    names = [(holder.GetArrayName(index), holder.GetArray(index)) for index in range(holder.GetNumberOfArrays())]
    return {name: as_array(array) for name, array in names if name and array is not None}
