"""HDF5: tisph's own samples, PySPH's output, and any file whose arrays lie together in one group."""

import h5py

from tisph.assessment.readers.frame import chosen_group, pysph_frame, split, time_of
from tisph.errors import ConfigError

SUFFIXES = (".h5", ".hdf5", ".hdf")


def read(path, select=None):
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
    found = []
    file.visititems(lambda name, item: found.append(name) if _holds_arrays(item) else None)
    names = [name for name in ([""] if _holds_arrays(file) else []) + found if name.rpartition("/")[2] != "bodies"]
    if not names:
        raise ConfigError(f"{path}: has no group with arrays of one length")
    groups = {name: _arrays(file[name or "/"]) for name in names}
    if len(names) > 1 and any(time_of(arrays) is None for arrays in groups.values()):
        groups = {name: groups[name] for name in [chosen_group(names, select, path)]}
    return [frame for arrays in groups.values() for frame in split(arrays, path)]


def _holds_arrays(item):
    return (
        isinstance(item, h5py.Group)
        and sum(array.ndim > 0 and array.dtype.kind in "fiu" for array in _datasets(item).values()) > 1
    )


def _datasets(group):
    return {name: item for name, item in group.items() if isinstance(item, h5py.Dataset)}


def _arrays(group):
    """Arrays by name, and the time where an attribute has it."""
    time = time_of(group.attrs)
    return {name: item[()] for name, item in _datasets(group).items()} | ({} if time is None else {"t": time})
