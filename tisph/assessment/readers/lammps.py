"""LAMMPS' dumps as text (``dump custom``, ``write_dump``): a frame a time step.

Where a dump has atoms of several types, walls may be among them: the types of the fluid must be said.
"""

import numpy as np

from tisph.assessment.readers.frame import Frame
from tisph.errors import ConfigError

SUFFIXES = (".dump", ".lammpstrj")

BEGINS = "ITEM: "


def read(path, select=None):
    """Frames in the order of the file; times where it has them (``dump_modify ... time yes``).

    ``select`` are the types of the fluid, such as ``1`` or ``1,2``.
    """
    lines = path.read_text(encoding="utf-8").splitlines()
    starts = [_start(lines, index) for index, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP")]
    ends = [*starts[1:], len(lines)]
    if not starts:
        raise ConfigError(f"{path}: has no line 'ITEM: TIMESTEP'")
    return [_frame(lines[start:end], path, select) for start, end in zip(starts, ends, strict=True)]


def _start(lines, index):
    """First line of the frame whose time step stands at ``index``: LAMMPS writes its time before it."""
    return index - 2 if index >= 2 and lines[index - 2].startswith("ITEM: TIME") else index


def _frame(lines, path, select):
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
    return _selected(Frame(columns, before), select, path)


def _selected(frame, select, path):
    """The frame of the atoms of the types ``select``, or of all where there is one type."""
    types = frame.columns.get("type", np.zeros(0))
    known = [f"{each:g}" for each in np.unique(types)]
    if select is None and len(known) < 2:
        return frame
    if select is None:
        raise ConfigError(f"{path}: which types are the fluid? Give --select {known[0]}; it has {', '.join(known)}")
    wanted = select.split(",")
    if not set(wanted) <= set(known):
        raise ConfigError(f"{path}: has no atoms of type {select}; it has {', '.join(known) or 'no types'}")
    chosen = np.isin(types, np.array(wanted, dtype=float))
    columns = {name: column[chosen] for name, column in frame.columns.items()}
    return Frame(columns, frame.time, select, tuple(known))
