"""Goals of accuracy: the largest error of a number, ``0.1%`` of it or in its unit; key ``accuracy`` and ``--until``."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

FIELDS = ("l2", "linf")
"""Norms of the error of the velocity, relative by themselves."""

PERCENT = re.compile(r"([-+.\deE]+|nan|inf) ?%")
MEAN = re.compile(r"mean\((.+)\)")
"""Name of the mean of a column of ``history.csv`` over the last quarter of the run."""


@dataclass(frozen=True)
class Goal:
    """Largest error of the number ``name``: ``amount``, times the number where it is ``relative``.

    ``asked``: the goal as it was written.
    """

    name: str
    amount: float
    relative: bool
    asked: str

    def size(self, value: float) -> float:
        """Return the largest error in the unit of the number, which has this ``value``."""
        return self.amount * abs(value) if self.relative else self.amount


def goal(name: str, given: Any) -> Goal:
    """Return the goal of the number ``name``; ``given`` is a number or a text. ValueError for another value."""
    text = str(given).strip()
    share = PERCENT.fullmatch(text)
    try:
        amount = float(share[1]) / 100.0 if share else float(text)
    except ValueError:
        raise ValueError(f"{name} = {text}: must be a number, or a percentage such as 0.1%") from None
    if isinstance(given, bool) or not (math.isfinite(amount) and amount > 0.0):
        raise ValueError(f"{name} = {text}: must be a finite number greater than 0, or a percentage such as 0.1%")
    return Goal(name, amount, bool(share) and name not in FIELDS, text)


def goals(given: Mapping[str, Any]) -> list[Goal]:
    """Return the goals of ``given``, name -> number or text. ValueError where one is none, or there are none."""
    if not given:
        raise ValueError("must name a number, such as {drag_coefficient: 0.1%}")
    return [goal(str(name), value) for name, value in given.items()]
