"""Extended XYZ: a frame a sample, its box and its columns in the second line (of libAtoms, as ASE and OVITO read it).

https://github.com/libAtoms/extxyz
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tisph.observers.vtk import fields, places

if TYPE_CHECKING:
    from tisph.results import Results

SPECIES = "X"
"""What stands for an element: no atom."""


def write(path: Path, run: "Results") -> None:
    """Write positions, velocity and all fields of each particle; the box is as deep as a particle is wide."""
    scene = run._scene
    box = np.diag([*scene.extent, scene.spacing])
    lattice = " ".join(f"{value:.17g}" for value in box.ravel())
    origin = " ".join(f"{value:.17g}" for value in (*scene.origin, 0.0))
    periodic = " ".join("T" if each else "F" for each in (*scene.periodic, False))
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for sample in run.samples:
            found = list(fields(sample))
            kinds = [f"{name}:{'I' if array.dtype.kind == 'i' else 'R'}:{array[0].size}" for name, array, _ in found]
            file.write(
                f'{len(sample["x"])}\nLattice="{lattice}" Origin="{origin}" pbc="{periodic}" Time={sample.t!r} '
                f"Properties=species:S:1:pos:R:3:{':'.join(kinds)}\n"
            )
            table = [places(sample), *(array.reshape(len(array), -1) for _, array, _ in found)]
            rows = zip(*(part.tolist() for part in table), strict=True)
            for row in rows:
                file.write(f"{SPECIES} {' '.join(repr(value) for part in row for value in part)}\n")
