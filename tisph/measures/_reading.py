"""What every protocol of ``rheometry.py`` reads: a title, lines of text, numbers, curves."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

SHOWN = 9
"""Lines of a table over time."""


class Axes(NamedTuple):
    """Labels of both axes, kinds of their units as in ``report/labels.py``, and whether both are logarithmic."""

    x: str
    y: str
    units: tuple[str, str]
    logarithmic: bool = False


@dataclass
class Reading:
    """``curves``: (``Axes``, name, abscissae, ordinates, style); style is one of ``report/rheometry.py: STYLES``.

    ``numbers`` by name; ``lines`` of text.
    """

    title: str
    lines: list[str]
    numbers: dict[str, float]
    curves: list[tuple] = field(default_factory=list)


NORMALS = (
    ("n1_mean", "run, mean of the gap", "."),
    ("n1", "run, at the wall that moves", "."),
    ("n1_exact", "reference", "-"),
)
"""Column, name and style of an N1: of a channel the mean of the gap, between cylinders at the one that moves."""


def normal_stress(table):
    """N1 of the run; None without a polymer."""
    return table.get("n1", table.get("n1_mean"))


def normal_curves(table, axis, abscissae, rows, scale=1.0):
    """Curves of each N1 over a ``scale``, in the ``rows`` of the ``table``."""
    return [(axis, words, abscissae, table[name][rows] / scale, kind) for name, words, kind in NORMALS if name in table]


def over_time(t, columns):
    """Lines of a table of ``columns`` by name at some of the times, more of them at first."""
    return at_rows(t, columns, np.unique(np.geomspace(1, len(t), SHOWN).astype(int)) - 1)


def at_rows(t, columns, chosen):
    """Lines of a table of ``columns`` by name at the ``chosen`` ones of the times."""
    return [
        f"  {'t':>10} " + " ".join(f"{name:>12}" for name in columns),
        *(f"  {t[k]:10.4g} " + " ".join(f"{values[k]:12.6g}" for values in columns.values()) for k in chosen),
    ]
