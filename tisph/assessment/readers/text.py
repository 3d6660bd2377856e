"""Tables as text: columns separated by commas, semicolons, tabs or blanks, with or without a header.

Where semicolons separate the columns, a comma between two digits is a decimal point.
"""

import re

import numpy as np

from tisph.assessment.readers.frame import Frame
from tisph.errors import ConfigError

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".xy", "")


def read(path, select=None):
    """One frame; columns are called as the header says, without one ``1``, ``2``, ... from the left.

    Lines that begin with ``#`` or ``%`` are comments; the last one before the numbers may be the header.
    """
    lines = [line.strip() for line in path.read_text(encoding="utf-8-sig").splitlines() if line.strip()]
    if any(";" in line for line in lines if not line.startswith(("#", "%"))):
        lines = [re.sub(r"(?<=\d),(?=\d)", ".", line) for line in lines]
    first = next((index for index, line in enumerate(lines) if _numbers(line)), None)
    if first is None:
        raise ConfigError(f"{path}: has no line of numbers")
    rows = [row for line in lines[first:] if not line.startswith(("#", "%")) and (row := _split(line))]
    width = len(rows[0])
    for index, row in enumerate(rows):
        if len(row) != width:
            raise ConfigError(f"{path}: row {index + 1} of the numbers has {len(row)} columns, the first has {width}")
    try:
        table = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from None
    header = _split(lines[first - 1].lstrip("#% ")) if first else []
    names = header if len(header) == width else [str(index + 1) for index in range(width)]
    return [Frame(dict(zip(names, table.T, strict=True)))]


def _split(line):
    return [cell.strip().strip("\"'") for cell in re.split(r"\s*[,;\t]\s*|\s+", line)]


def _numbers(line):
    try:
        return [float(cell) for cell in _split(line) if cell]
    except ValueError:
        return []
