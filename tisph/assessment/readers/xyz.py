"""Extended XYZ: a frame a time, with its columns and its time in the second line (of libAtoms, as ASE and OVITO)."""

import re

import numpy as np

from tisph.assessment.readers.frame import Frame, decoded, flat
from tisph.errors import ConfigError

SUFFIXES = (".xyz", ".extxyz")


def read(path, select=None):
    """Frames in the order of the file."""
    lines, frames = [line for line in decoded(path).splitlines() if line.strip()], []
    try:
        while lines:
            count, about = int(lines[0]), lines[1]
            parts = re.search(r"Properties=(\S+)", about)[1].split(":")
            names, kinds, widths = parts[::3], parts[1::3], [int(width) for width in parts[2::3]]
            table = np.array([line.split() for line in lines[2 : count + 2]]).reshape(count, sum(widths))
            groups = zip(names, kinds, np.split(table, np.cumsum(widths)[:-1], axis=1), strict=True)
            arrays = {name: group.astype(float) for name, kind, group in groups if kind in "RI"}
            columns = flat({name: group[:, 0] if group.shape[1] == 1 else group for name, group in arrays.items()})
            time = re.search(r"\btime=(\S+)", about, re.IGNORECASE)
            frames.append(Frame(columns, float(time[1]) if time else None))
            lines = lines[count + 2 :]
    except (ValueError, IndexError, TypeError) as error:
        raise ConfigError(f"{path}: frame {len(frames) + 1} is no extended XYZ: {error}") from None
    return frames
