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
