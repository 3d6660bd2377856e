"""Extended XYZ: a frame a time, with its columns and its time in the second line (of libAtoms, as ASE and OVITO)."""

import re

import numpy as np

from tisph.assessment.readers.frame import Frame, decoded, flat
from tisph.errors import ConfigError

SUFFIXES = (".xyz", ".extxyz")


def read(path, select=None):
    """Frames in the order of the file."""
    lines, frames = decoded(path).splitlines(), []
    try:
        while lines:
            count, about = int(lines[0]), lines[1]
            table = np.array([line.split() for line in lines[2 : count + 2]])
            parts = re.search(r"Properties=(\S+)", about)[1].split(":")
            ends = np.cumsum([int(number) for number in parts[2::3]])
            arrays = dict(zip(parts[::3], np.split(table, ends[:-1], axis=1), strict=True))
            arrays = {
                name: arrays[name].astype(float)
                for name, kind in zip(parts[::3], parts[1::3], strict=True)
                if kind in "RI"
            }
            columns = flat({name: array[:, 0] if array.shape[1] == 1 else array for name, array in arrays.items()})
            time = re.search(r"\btime=(\S+)", about, re.IGNORECASE)
            frames.append(Frame(columns, float(time[1]) if time else None, label=f"frame {len(frames) + 1}"))
            lines = lines[count + 2 :]
    except (ValueError, IndexError, TypeError) as error:
        raise ConfigError(f"{path}: frame {len(frames) + 1} is no extended XYZ: {error}") from None
    return frames
