"""``samples.h5`` as a sequence: nothing of it is read before it is asked for."""

from collections.abc import Sequence
from pathlib import Path
from typing import overload

import h5py

from tisph.observers._storage import readable
from tisph.results._arrays import Arrays


class Sample(Arrays):
    """The fluid particles at time ``t``, after ``step`` steps: arrays of shape (particles,) by name.

    ``x``, ``y``, ``u``, ``v``, ``density``, ``pressure``, with polymer ``stress_xx``, ``stress_xy``, ``stress_yy``, and
    what the reference says there, ``u_exact`` and so on; of bodies ``bodies/centre`` and so on, of shape (bodies, ...).
    """

    def __init__(self, path: Path, group: str, t: float, step: int):
        super().__init__(path, group)
        self.t, self.step = t, step

    def __repr__(self) -> str:
        return f"<Sample t={self.t:g}: {', '.join(self)}>"


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
