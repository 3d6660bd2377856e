"""Arrays of an HDF5 file as a mapping."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np

from tisph.observers._storage import readable


class Arrays(Mapping[str, np.ndarray]):
    """Those in a ``group`` of the file by name, read when they are asked for."""

    def __init__(self, path: Path, group: str = "/"):
        self._path, self._group = path, group

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.units:
            raise KeyError(f"{name!r}; there are {', '.join(self.units)}")
        with readable(self._path), h5py.File(self._path, "r") as file:
            return np.asarray(file[self._group][name])

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    @cached_property
    def units(self) -> dict[str, str]:
        """Unit of each array by its name."""
        found: dict[str, str] = {}

        def take(name: str, item: object) -> None:
            if isinstance(item, h5py.Dataset):
                found[name] = str(item.attrs.get("units", ""))

        with readable(self._path), h5py.File(self._path, "r") as file:
            file[self._group].visititems(take)
        return found
