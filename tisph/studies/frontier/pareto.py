"""A point of run time against error, and what is asked of many: which are on the Pareto front, which is the fastest."""

from dataclasses import asdict, dataclass
from statistics import median

OURS = "tisph"


@dataclass(frozen=True)
class Measured:
    """What the runs of one flow by one method gave: error and seconds of every round.

    ``l2``: the L2 error, or another where the ``Benchmark`` says so, NaN where a run stopped. ``steps``: None where
    they are not known. ``loops`` are seconds of the time loop, ``processes`` those of whole processes, where known.
    ``code``: the program. ``quoted``: whether it was measured elsewhere.
    """

    flow: str
    method: str
    across: int
    threads: int
    steps: int | None
    l2: float
    loops: tuple[float, ...]
    processes: tuple[float, ...] = ()
    code: str = OURS
    quoted: bool = False

    @property
    def loop(self):
        """Median loop time [s]."""
        return median(self.loops)

    @property
    def numbers(self):
        """Itself as a dictionary for a file, whose keys are those of files that users have."""
        found = asdict(self)
        return {**found, "way": found.pop("method"), "elsewhere": found.pop("quoted"), "loop": self.loop}

    @property
    def ours(self):
        """Whether this program did it, and not a peer."""
        return self.code == OURS


def pareto_front(rows):
    """Those of ``rows`` (of one flow) that no other beats in both error and loop time."""
    return [
        row
        for row in rows
        if row.l2 == row.l2 and not any(other.l2 <= row.l2 and other.loop < row.loop for other in rows)
    ]


def fastest(rows, error, *starts):
    """Our row with the shortest loop among those with an L2 of at most ``error``; None without one.

    With ``starts`` only methods that begin with one of them count.
    """
    found = [row for row in rows if row.ours and row.l2 <= error and row.method.startswith(starts or "")]
    return min(found, key=lambda row: row.loop, default=None)
