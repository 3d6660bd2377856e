"""With as many particles as a peer: how much smaller error and time of tisph are, and whether that is enough."""

from tisph.study.bench.cases import FLOWS
from tisph.study.bench.comparison import Judged
from tisph.verification.table import format_table

HEADER = ("peer", "across", "its L2", "its time [s]", "tisph with as many particles", "error", "time", "bound", "")


class Equal(Judged):
    """A peer's run, and that of our ``rival`` way with as many particles."""

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
        return self.asked and self.asked.more_exact

    @property
    def passed(self):
        """Whether we are as much more exact as asked, and faster; True without a bound."""
        return self.bound is None or (self.errors >= self.bound and self.times > 1)

    @property
    def ratios(self):
        """Both ratios by name."""
        return {"errors": self.errors, "times": self.times}


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
    rows = [one.cells([f"{one.errors:.0f}", f"{one.times:.3g}"], "error >= {:g}, time > 1") for one in found]
    title = "At an equal number of particles, ratios of the peer's error and time to ours"
    return f"{title}:\n\n{format_table(HEADER, rows)}"
