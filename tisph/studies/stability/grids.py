"""Sub-matrices of the stability matrix: cells with every value of several axes."""

from dataclasses import dataclass
from itertools import product

from tisph.equation_of_state import SCALE_RATIO
from tisph.schemes.implicit._walls import OBEY_MOMENTUM
from tisph.studies.stability.cells import Cell

BOTH = ("explicit", "implicit 4")

LEAST_COLUMNS = 10
"""Particles along the channel that the neighbour search of the explicit scheme needs."""


@dataclass(frozen=True)
class SubMatrix:
    """Cells under a title, and the axes along which the columns and rows of their map go; none for a list by axis."""

    title: str
    cells: tuple[Cell, ...]
    columns: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()


def grid(**values):
    """All cells that there are with one of the values of every named axis, the last axis varying fastest."""
    rows = [dict(zip(values, chosen, strict=True)) for chosen in product(*values.values())]
    return tuple(Cell(**row) for row in rows if exists(row))


def exists(values):
    """Whether a config can have these values of axes together, of which some may be missing."""
    across, aspect = values.get("across"), values.get("aspect")
    if across and aspect and (across * aspect % 1 or across * aspect < LEAST_COLUMNS):
        return False
    if values.get("scheme", "explicit") == "explicit":
        return True
    return (
        values.get("sound", SCALE_RATIO) == SCALE_RATIO and values.get("treatment", "consistent_image") in OBEY_MOMENTUM
    )
