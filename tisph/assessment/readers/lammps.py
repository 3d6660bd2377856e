"""LAMMPS' dumps as text (``dump custom``, ``write_dump``) and profiles (``fix ave/chunk``): a frame a time step.

Where a dump has atoms of several types, walls may be among them: the types of the fluid must be said.
"""

from dataclasses import replace

import numpy as np

from tisph.assessment.readers.frame import Frame, decoded
from tisph.errors import ConfigError

SUFFIXES = (".dump", ".lammpstrj")

BEGINS = "ITEM: "
CHUNKS = "# Chunk-averaged data"


def read(path, select=None):
    """Frames in the order of the file; times where a dump has them (``dump_modify ... time yes``).

    ``select`` are the types of the fluid, such as ``1`` or ``1,2``.
    """
    lines = decoded(path).splitlines()
    if lines and lines[0].startswith(CHUNKS):
        return _profiles(lines, path)
    starts = [index for index, line in enumerate(lines) if line.startswith("ITEM: TIMESTEP")]
    if not starts:
        raise ConfigError(f"{path}: has no line 'ITEM: TIMESTEP'")
    # the time of a frame is written before its step
    starts = [index - 2 if lines[index - 2].strip() == "ITEM: TIME" else index for index in starts]
    ends = [*starts[1:], len(lines)]
    return [_frame(lines[start:end], path, select) for start, end in zip(starts, ends, strict=True)]


def _profiles(lines, path):
    """Frames of the chunks that hold atoms, from blocks "step, number of chunks, number of atoms" and their rows.

    Chunks along one axis only are along y, whatever its name in LAMMPS is: the file does not say it.
    """
    rows, frames = [line.split() for line in lines if not line.startswith("#")], []
    try:
        names = lines[2].lstrip("# ").split()
        names = ["y" if name == "Coord1" and "Coord2" not in names else name for name in names]
        while rows:
            step, count = rows[0][0], int(rows[0][1])
            table = np.array(rows[1 : count + 1], dtype=float).reshape(count, len(names))
            columns = dict(zip(names, table[table[:, names.index("Ncount")] > 0].T, strict=True))
            frames.append(Frame(columns, label=f"step {step}"))
            rows = rows[count + 1 :]
    except (ValueError, IndexError) as error:
        raise ConfigError(f"{path}: is damaged after {len(frames)} blocks of chunks: {error}") from None
    return frames


def _frame(lines, path, select):
    found = {line[len(BEGINS) :]: index for index, line in enumerate(lines) if line.startswith(BEGINS)}
    atoms = next((name for name in found if name.startswith("ATOMS ")), None)
    if atoms is None or "NUMBER OF ATOMS" not in found:
        raise ConfigError(f"{path}: has no line 'ITEM: ATOMS' with the names of its columns, or none with their number")
    # a list of named columns, of which those that are no numbers (an element's name) are left out
    rows = [line.split() for line in lines[found[atoms] + 1 :] if line and not line.startswith(BEGINS)]
    if [str(len(rows))] != lines[found["NUMBER OF ATOMS"] + 1].split() or len({len(row) for row in rows}) != 1:
        raise ConfigError(f"{path}: a frame is damaged: it has {len(rows)} rows, or rows of several lengths")
    columns = {}
    for name, cells in zip(atoms.split()[1:], zip(*rows, strict=False), strict=False):
        try:
            columns[name] = np.array(cells, dtype=float)
        except ValueError:
            continue
    before = next((float(lines[index + 1]) for name, index in found.items() if name == "TIME"), None)
    return _selected(Frame(columns, before, label=f"step {lines[found['TIMESTEP'] + 1]}"), select, path)


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
    return replace(frame, columns=columns)
