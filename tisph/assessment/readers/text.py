"""Tables as text: columns separated by semicolons, tabs, commas or blanks, with or without a header.

A comma is a decimal point where it does not separate the columns. ``D`` may begin an exponent, as Fortran writes it.
"""

import csv
import re

import numpy as np

from tisph.assessment.readers.frame import Frame, decoded
from tisph.assessment.units import SIZES, SYMBOL
from tisph.errors import ConfigError

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".xy", "")

SEPARATORS = (";", "\t", ",", " ")
"""In the order in which they are tried: the first one that makes a row of numbers out of a line is taken."""

TIME = re.compile(r"[#% ]*(?:t|time)\s*[=:]?\s*([-+.,\d]+(?:e[-+]?\d+)?)\s*\[?([a-z]*)\]?", re.IGNORECASE)
"""A line with the time of a block, such as ``# t = 0.5`` or ``# time: 3 ms``."""

NAME = re.compile(r"(?:\"[^\"]*\"|'[^']*'|\S+)(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
"""A name between blanks, with its unit."""


def read(path, select=None):
    """A frame for every block of rows; columns are called as the header says, or ``1``, ``2``, ... from the left.

    An empty line or one without numbers ends a block. Lines that begin with ``#`` or ``%`` are comments; the last one
    before the numbers may be the header, with a row of units below it. Blocks share the last header before them.
    """
    text = re.sub(r"(?<=[\d.])[dD](?=[-+\d]\d)", "e", decoded(path).replace("\r\r\n", "\n"))
    lines = [line.strip() for line in text.splitlines()]
    separator = next((each for line in lines for each in SEPARATORS if _row(_cells(line, each))), None)
    if separator is None:
        raise ConfigError(f"{path}: has no line of numbers")
    frames, header, head, rows, cells, signs = [], ([], {}), [], [], [], set()
    for number, line in enumerate([*lines, ""], 1):
        above, cells = cells, _cells(line, separator)
        row = _row(cells)
        fits = row and len(row) == len(rows[0] if rows else row)
        damaged = cells if rows and not fits else above if fits and not rows and len(above) == len(row) else []
        if any(cell and _number(cell) is not None for cell in damaged):
            line_of = number if rows else number - 1
            raise ConfigError(f"{path}: line {line_of} is no row of numbers as the others: {separator.join(damaged)}")
        if fits:
            rows.append(row)
            signs |= {sign for sign in ".," if any(sign in cell for cell in cells)}
            continue
        if rows:
            header = _header(head, separator, len(rows[0])) or header
            frames.append(_frame(*header, head, rows, f"lines {number - len(rows)} to {number - 1}"))
            head, rows = [], []
        head += [line] if line else []
    if len(signs) > 1:
        raise ConfigError(f"{path}: some numbers have a decimal point, others a comma")
    return frames


def _frame(names, units, head, rows, label):
    table = np.array(rows).T
    names = names if len(names) == len(table) else [""] * len(table)
    called = [name if name and names.count(name) == 1 else str(index) for index, name in enumerate(names, 1)]
    time = next((match for line in head if (match := TIME.fullmatch(line))), None)
    units = units | ({"time": time[2]} if time else {})
    return Frame(dict(zip(called, table, strict=True)), time and _number(time[1]), label=label, units=units)


def _header(head, separator, width):
    """Names of the columns, and units by name, from the lines before the numbers; None where there are no names."""
    found = [names for line in head if (names := _names(line.lstrip("#% "), separator, width))]
    symbols = {symbol for name in (found or [[]])[-1] for symbol, _ in re.findall(SYMBOL, name)}
    if len(found) > 1 and symbols <= {symbol for sizes in SIZES.values() for symbol in sizes}:
        return found[-2], {name: unit.strip("[]()") for name, unit in zip(*found[-2:], strict=True) if unit}
    return (found[-1], {}) if found else None


def _names(line, separator, width):
    """The ``width`` names in a header, however it separates them; None for any other line."""
    ways = [_cells(line, each) for each in (separator, *SEPARATORS)] + [NAME.findall(line), re.split(r"\s{2,}", line)]
    found = [[cell.strip(" \t,;\"'") for cell in cells] for cells in ways if len(cells) == width]
    return next((names for names in found if {_number(name) for name in names if name} == {None}), None)


def _cells(line, separator):
    """Texts of the columns of a line; none of a comment."""
    if line.startswith(("#", "%")):
        return []
    split = [line.split()] if separator == " " else csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [cell.strip(" \t\"'") for cell in next(iter(split), [])]


def _row(cells):
    """Numbers of two or more columns, NaN in an empty one; None where one is no number, or all are empty."""
    row = [_number(cell) for cell in cells]
    return row if len(row) > 1 and any(cells) and None not in row else None


def _number(text):
    try:
        return float(text.replace(",", ".") or "nan")
    except ValueError:
        return None
