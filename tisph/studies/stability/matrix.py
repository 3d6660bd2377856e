"""Which cells there are, from ``cells.yaml``: sub-matrices of the axes that matter, and a covering set of all axes."""

from dataclasses import dataclass
from functools import cache
from itertools import combinations, product
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

from tisph.equation_of_state import SCALE_RATIO
from tisph.schemes._stages.walls import OBEY_MOMENTUM
from tisph.studies.flows import digits
from tisph.studies.stability.cells import Cell

TABLE = YAML(typ="safe", pure=True).load(Path(__file__).with_name("cells.yaml"))
AXES = TABLE["covering"]

LEAST_COLUMNS = 10
"""Particles along the channel that the neighbour search of the explicit scheme needs."""

LARGEST_REYNOLDS = 1000.0
"""Where the elasticity number is given: steps, limited by strain, are about as many as the Reynolds number."""

WAVES = 3
"""Times that an elastic wave crosses the gap there: it takes sqrt(E) viscous times, E the elasticity number."""


@dataclass(frozen=True)
class SubMatrix:
    """Cells under a title, and the axes along which the columns and rows of their map go; none for a list by axis."""

    title: str
    cells: tuple[Cell, ...]
    columns: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()


def sub_matrices(quick=False, only=None):
    """All sub-matrices, or a few short cells of every kind, in a fixed order; cells may be in several of them.

    ``only``: those with this text in their title; ValueError where there is none.
    """
    parts = _parts("quick" if quick else "full")
    chosen = [part for part in parts if only is None or only in part.title]
    if not chosen:
        titles = ", ".join(part.title for part in parts)
        raise ValueError(f"no sub-matrix has {only!r} in its title; there are {titles}")
    return chosen


def cells(chosen):
    """Every cell of sub-matrices once, each after the baseline that it is compared with."""
    return list(dict.fromkeys(each for part in chosen for cell in part.cells for each in (cell.baseline, cell)))


@cache  # the covering set is a second of work
def _parts(extent):
    return [_part(**given) for given in TABLE[extent]]


def _part(title, grids=None, columns=(), rows=()):
    """A sub-matrix as ``cells.yaml`` has it; without grids it is the covering set."""
    if grids is None:
        return SubMatrix(title, tuple(Cell(**row) for row in covering_set(AXES, covered)))
    return SubMatrix(title, sum((grid(**values) for values in grids), ()), tuple(columns), tuple(rows))


def grid(**values):
    """All cells that there are with one of the values of every named axis, the last axis varying fastest."""
    choices = [each if isinstance(each, list | tuple) else [each] for each in values.values()]
    rows = [dict(zip(values, chosen, strict=True)) for chosen in product(*choices)]
    found = [_cell(**row) for row in rows if exists(row)]
    return tuple(cell for cell in found if "elasticity" not in values or cell.reynolds <= LARGEST_REYNOLDS)


def _cell(elasticity=None, **values):
    """A cell; one of a given elasticity number runs until waves have crossed the gap ``WAVES`` times."""
    if elasticity is not None:
        values["reynolds"] = digits(Cell(flow=values["flow"]).weissenberg / elasticity)
        values["t_star"] = max(1.0, round(WAVES * elasticity**0.5))
    return Cell(**values)


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


def covered(values):
    """Whether the covering set has these values together; viscoelastic fluids have sub-matrices of their own."""
    viscoelastic = Cell(flow=values.get("flow", "couette")).has_polymer
    return exists(values) and not (viscoelastic and values.get("scheme", "explicit") != "explicit")


def covering_set(axes, exists):
    """Return rows, dicts with a value of every axis, that together have every possible pair of values.

    ``axes``: values by the name of the axis. ``exists(values)``: whether two values, a dict of two axes, can be had
    together. Greedy: each row is the first of those that bring the most new pairs, so that the set is always the same.
    Two libraries were tried: allpairspy 2.5 misses 19 of 622 pairs of the matrix, because of the values that exclude
    one another; covertable 3.2 finds them all, in 45 rows, where this needs 48.
    """
    values = [(name, value) for name, choices in axes.items() for value in choices]
    sizes = [len(choices) for choices in axes.values()]
    first = np.cumsum([0, *sizes[:-1]])
    rows = np.indices(sizes).reshape(len(sizes), -1).T + first  # every row there is, as positions in ``values``
    possible = np.array([[exists(dict([one, other])) for other in values] for one in values])
    columns = list(combinations(range(len(sizes)), 2))
    pairs = np.stack([rows[:, one] * len(values) + rows[:, other] for one, other in columns], axis=1)
    whole = possible.ravel()[pairs].all(axis=1)
    rows, pairs = rows[whole], pairs[whole]
    missing = np.zeros(possible.size, dtype=bool)
    missing[pairs] = True
    chosen = []
    while missing.any():
        best = int(np.argmax(missing[pairs].sum(axis=1)))
        missing[pairs[best]] = False
        chosen.append(dict(values[position] for position in rows[best]))
    return chosen
