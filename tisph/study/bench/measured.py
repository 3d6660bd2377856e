"""A point of run time against error, and what is asked of many: which are in front, which is the fastest."""

from dataclasses import dataclass
from statistics import median

OURS = "tisph"


@dataclass(frozen=True)
class Measured:
    """What the runs of one flow in one way gave: error and seconds of every round.

    ``l2``: the L2 error, or another where the ``Flow`` says so, NaN where a run stopped. ``steps``: None where they are
    not known. ``loops`` are seconds of the time loop, ``processes`` those of the whole process where they are known.
    ``code``: the program. ``elsewhere``: quoted from a measurement at another time.
    """

    flow: str
    way: str
    across: int
    threads: int
    steps: int | None
    l2: float
    loops: tuple[float, ...]
    processes: tuple[float, ...] = ()
    code: str = OURS
    elsewhere: bool = False

    @property
    def loop(self):
        """Median loop time [s]."""
        return median(self.loops)

    @property
    def ours(self):
        """Whether this program did it, and not a peer."""
        return self.code == OURS


def front(rows):
    """Those of ``rows`` (of one flow) that no other beats in both error and loop time."""
    return [
        row
        for row in rows
        if row.l2 == row.l2 and not any(other.l2 <= row.l2 and other.loop < row.loop for other in rows)
    ]


def fastest(rows, error, *starts):
    """Our row with the shortest loop among those with an L2 of at most ``error``; None without one.

    With ``starts`` only ways that begin with one of them count.
    """
    found = [row for row in rows if row.ours and row.l2 <= error and row.way.startswith(starts or "")]
    return min(found, key=lambda row: row.loop, default=None)
