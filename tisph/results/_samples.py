"""``samples.h5`` as a sequence: nothing of it is read before it is asked for."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import overload

import h5py
import numpy as np

from tisph.observers._files import readable


class Sample(Mapping[str, np.ndarray]):
    """The fluid particles at time ``t``, after ``step`` steps: arrays of shape (particles,) by name.

    ``x``, ``y``, ``u``, ``v``, ``density``, ``pressure``, with polymer ``stress_xx``, ``stress_xy``, ``stress_yy``, and
    what the reference says there, ``u_exact`` and so on; of bodies ``bodies/centre`` and so on, of shape (bodies, ...).
    """

    def __init__(self, path: Path, group: str, t: float, step: int):
        self._path, self._group = path, group
        self.t, self.step = t, step

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.units:
            raise KeyError(f"{name!r}; there are {', '.join(self.units)}")
        with readable(self._path), h5py.File(self._path, "r") as file:
            return np.asarray(file[self._group][name])

    def __iter__(self) -> Iterator[str]:
        return iter(self.units)

    def __len__(self) -> int:
        return len(self.units)

    def __repr__(self) -> str:
        return f"<Sample t={self.t:g}: {', '.join(self)}>"

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


class Samples(Sequence[Sample]):
    """The samples of a run in the order of time."""

    def __init__(self, path: Path):
        self._samples: list[Sample] = []
        if path.is_file():
            with readable(path), h5py.File(path, "r") as file:
                groups = sorted(file.values(), key=lambda group: group.attrs["t"])
                self._samples = [
                    Sample(path, group.name, float(group.attrs["t"]), int(group.attrs["step"])) for group in groups
                ]

    @overload
    def __getitem__(self, index: int) -> Sample: ...
    @overload
    def __getitem__(self, index: slice) -> list[Sample]: ...
    def __getitem__(self, index: int | slice) -> Sample | list[Sample]:
        return self._samples[index]

    def __len__(self) -> int:
        return len(self._samples)

    def __repr__(self) -> str:
        return f"<Samples at t = {', '.join(f'{sample.t:g}' for sample in self)}>"
