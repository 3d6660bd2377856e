"""With as many particles as a peer: how much smaller error and time of tisph are, and whether that is enough."""

from dataclasses import dataclass

from tisph.study.bench.cases import FLOWS
from tisph.study.bench.comparison import name
from tisph.study.bench.measured import Measured
from tisph.verification.table import format_table

HEADER = ("peer", "across", "its L2", "its time [s]", "tisph with as many particles", "error", "time", "bound", "")


@dataclass(frozen=True)
class Equal:
    """A peer's run, and that of our ``rival`` way with as many particles."""

    peer: Measured
    ours: Measured

    @property
    def errors(self):
        """Error of the peer over ours."""
        return self.peer.l2 / self.ours.l2

    @property
    def times(self):
        """Median loop time of the peer over ours."""
        return self.peer.loop / self.ours.loop

    @property
    def bound(self):
        """Least ratio of the errors allowed; None where nothing is asked for."""
        asked = FLOWS[self.peer.flow].bound(self.peer)
        return asked and asked.more_exact

    @property
    def passed(self):
        """Whether we are as much more exact as asked, and faster; True without a bound."""
        return self.bound is None or (self.errors >= self.bound and self.times > 1)

    @property
    def numbers(self):
        """Itself as a dictionary for a file."""
        return {
            "flow": self.peer.flow,
            "peer": self.peer.way,
            "across": self.peer.across,
            "tisph": name(self.ours),
            "errors": self.errors,
            "times": self.times,
            "bound": self.bound,
            "passed": self.passed,
        }


def equals(rows):
    """An ``Equal`` for each peer's row of a flow with a rival, where that ran with as many particles."""
    rivals = {
        (row.flow, row.across): row
        for row in rows
        if row.ours and row.way == FLOWS[row.flow].rival and row.l2 == row.l2
    }
    peers = [row for row in rows if not row.ours and row.l2 == row.l2 and (row.flow, row.across) in rivals]
    return [Equal(peer, rivals[peer.flow, peer.across]) for peer in peers]


def equals_table(found):
    """Markdown of them."""
    return "At an equal number of particles, ratios of the peer's error and time to ours:\n\n" + format_table(
        HEADER, [_cells(one) for one in found]
    )


def _cells(one):
    judged = one.bound is not None
    return (
        one.peer.way,
        str(one.peer.across),
        f"{one.peer.l2:.1e}",
        f"{one.peer.loop:.3g}",
        name(one.ours),
        f"{one.errors:.0f}",
        f"{one.times:.3g}",
        f"error >= {one.bound:g}, time > 1" if judged else "-",
        ("PASS" if one.passed else "FAIL") if judged else "-",
    )
