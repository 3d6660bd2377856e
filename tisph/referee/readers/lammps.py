"""LAMMPS' dumps as text (``dump custom``, ``write_dump``): a frame a time step."""

import numpy as np

from tisph.errors import ConfigError
from tisph.referee.frame import Frame

SUFFIXES = (".dump", ".lammpstrj")

BEGINS = "ITEM: "


def read(path, select=None):
    """Frames in the order of the file; times where it has them (``dump_modify ... time yes``)."""
    lines = path.read_text(encoding="utf-8").splitlines()
    starts = [index for index, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP")]
    ends = [*starts[1:], len(lines)]
    if not starts:
        raise ConfigError(f"{path}: has no line 'ITEM: TIMESTEP'")
    return [_frame(lines[start:end], path) for start, end in zip(starts, ends, strict=True)]


def _frame(lines, path):
    found = {line[len(BEGINS) :]: index for index, line in enumerate(lines) if line.startswith(BEGINS)}
    atoms = next((name for name in found if name.startswith("ATOMS ")), None)
    if atoms is None:
        raise ConfigError(f"{path}: has no line 'ITEM: ATOMS' with the names of its columns")
    # a list of named columns, of which those that are no numbers (an element's name) are left out
    rows = [line.split() for line in lines[found[atoms] + 1 :] if line and not line.startswith(BEGINS)]
    columns = {}
    for name, cells in zip(atoms.split()[1:], zip(*rows, strict=False), strict=False):
        try:
            columns[name] = np.array(cells, dtype=float)
        except ValueError:
            continue
    before = next((float(lines[index + 1]) for name, index in found.items() if name == "TIME"), None)
    return Frame(columns, before)
