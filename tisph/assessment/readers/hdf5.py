"""HDF5: tisph's own samples, PySPH's output, and any file whose arrays lie together in one group."""

import h5py
import numpy as np

from tisph.assessment.readers.frame import Frame, chosen_group, flat, pysph_frame
from tisph.errors import ConfigError

SUFFIXES = (".h5", ".hdf5", ".hdf")


def read(path, select=None):
    """Frames in the order of their names; a group with an attribute ``t`` or ``time`` is one time."""
    try:
        with h5py.File(path, "r") as file:
            if "particles" in file and "solver_data" in file:
                return [pysph_frame(file["particles"], file["solver_data"].attrs.get("t"), select, path)]
            return _groups(file, select, path)
    except OSError as error:
        raise ConfigError(f"{path}: is no HDF5 file, or damaged: {error}") from None


def _groups(file, select, path):
    """A frame of every group that holds arrays; one time each, or particles of several kinds."""
    found = []
    file.visititems(lambda name, item: found.append(name) if _holds_arrays(item) else None)
    names = [name for name in ([""] if _holds_arrays(file) else []) + found if name.rpartition("/")[2] != "bodies"]
    if not names:
        raise ConfigError(f"{path}: has no group with arrays of one length")
    times = {name: _time(file[name or "/"]) for name in names}
    if len(names) > 1 and None in times.values():
        names = [chosen_group(names, select, path)]
    return [Frame(flat({key: item[()] for key, item in _arrays(file[name or "/"])}), times[name]) for name in names]


def _holds_arrays(item):
    return isinstance(item, h5py.Group) and len(flat({key: np.empty(array.shape) for key, array in _arrays(item)})) > 1


def _arrays(group):
    return [(key, item) for key, item in group.items() if isinstance(item, h5py.Dataset) and item.ndim in (1, 2)]


def _time(group):
    return next((float(group.attrs[name]) for name in ("t", "time") if name in group.attrs), None)
