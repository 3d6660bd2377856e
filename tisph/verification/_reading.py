"""What every protocol of ``rheometry.py`` reads: a title, lines of text, numbers, curves."""

from dataclasses import dataclass, field

import numpy as np

SHOWN = 9
"""Lines of a table over time."""


@dataclass
class Reading:
    """``curves``: (axis, name, abscissae, ordinates, style) with axis a pair of labels and style a line's or a mark's.

    ``numbers`` by name; ``lines`` of text.
    """

    title: str
    lines: list[str]
    numbers: dict[str, float]
    curves: list[tuple] = field(default_factory=list)


def over_time(t, columns):
    """Lines of a table of ``columns`` by name at some of the times, more of them at first."""
    return at_rows(t, columns, np.unique(np.geomspace(1, len(t), SHOWN).astype(int)) - 1)


def at_rows(t, columns, chosen):
    """Lines of a table of ``columns`` by name at the ``chosen`` ones of the times."""
    return [
        f"  {'t':>10} " + " ".join(f"{name:>12}" for name in columns),
        *(f"  {t[k]:10.4g} " + " ".join(f"{values[k]:12.6g}" for values in columns.values()) for k in chosen),
    ]
