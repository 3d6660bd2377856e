"""Peers beside tisph: how much faster it reaches their errors, how much smaller its error is at equal resolution."""

from dataclasses import dataclass

from tisph.studies.frontier.cases import BENCHMARKS
from tisph.studies.frontier.pareto import Measured, fastest
from tisph.text_table import format_table

HEADER = ("peer", "across", "its L2", "its time [s]", "tisph to the same or smaller L2", "ratio", "bound", "")
EQUAL_HEADER = (
    "peer",
    "across",
    "its L2",
    "its time [s]",
    "tisph with as many particles",
    "error",
    "time",
    "bound",
    "",
)


@dataclass(frozen=True)
class Judged:
    """A peer's run, and one of ours beside it, or None: ``ratios`` of theirs over ours, by name, have a ``bound``."""

    peer: Measured
    ours: Measured | None

    @property
    def requirement(self):
        """The ``Bound`` against the peer; None where nothing is asked for."""
        return BENCHMARKS[self.peer.flow].bound(self.peer)

    @property
    def numbers(self):
        """Itself as a dictionary for a file."""
        return {
            "flow": self.peer.flow,
            "peer": self.peer.method,
            "across": self.peer.across,
            "tisph": name(self.ours) if self.ours else None,
            **self.ratios,
            "bound": self.bound,
            "passed": self.passed,
        }

    def cells(self, ratios, bound):
        """Its row of a table, with ``ratios`` and the ``bound`` in words, in which the number is to be put."""
        verdict = "PASS" if self.passed else "FAIL"
        return (
            self.peer.method,
            str(self.peer.across),
            f"{self.peer.l2:.1e}",
            f"{self.peer.loop:.3g}",
            name(self.ours) if self.ours else "not reached",
            *ratios,
            *(("-", "-") if self.bound is None else (bound.format(self.bound), verdict)),
        )


class Comparison(Judged):
    """A peer's run, and our fastest one with an error that is no larger; None where no run reaches it."""

    @property
    def ratio(self):
        """Median loop time of the peer over ours; 0 without a run of ours."""
        return self.peer.loop / self.ours.loop if self.ours else 0.0

    @property
    def ratios(self):
        """The ratio by name."""
        return {"ratio": self.ratio}

    @property
    def bound(self):
        """Least ratio allowed; None where nothing is asked for."""
        return self.requirement and self.requirement.speedup

    @property
    def passed(self):
        """Whether the bound holds; True without one."""
        return self.bound is None or self.ratio >= self.bound


class EqualResolution(Judged):
    """A peer's run, and ours by the ``equal_resolution_method`` of the flow with as many particles."""

    @property
    def errors(self):
        """Error of the peer over ours."""
        return self.peer.l2 / self.ours.l2

    @property
    def times(self):
        """Median loop time of the peer over ours."""
        return self.peer.loop / self.ours.loop

    @property
    def ratios(self):
        """Both ratios by name."""
        return {"errors": self.errors, "times": self.times}

    @property
    def bound(self):
        """Least ratio of the errors allowed; None where nothing is asked for."""
        return self.requirement and self.requirement.accuracy_ratio

    @property
    def passed(self):
        """Whether we are as much more accurate as asked, and faster; True without a bound."""
        return self.bound is None or (self.errors >= self.bound and self.times > 1)


def comparisons(rows):
    """A ``Comparison`` for each peer's row that has an error, flow by flow in the order of ``BENCHMARKS``."""
    found = []
    for flow in BENCHMARKS:
        of_flow = [row for row in rows if row.flow == flow]
        peers = [row for row in of_flow if not row.ours and row.l2 == row.l2]
        found += [Comparison(peer, fastest(of_flow, peer.l2)) for peer in peers]
    return found


def equal_resolution(rows):
    """An ``EqualResolution`` for each peer's row with an error where our method ran with as many particles."""
    ours = {
        (row.flow, row.across): row
        for row in rows
        if row.ours and row.method == BENCHMARKS[row.flow].equal_resolution_method and row.l2 == row.l2
    }
    peers = [row for row in rows if not row.ours and row.l2 == row.l2 and (row.flow, row.across) in ours]
    return [EqualResolution(peer, ours[peer.flow, peer.across]) for peer in peers]


def speedups(rows):
    """Lines: how much faster than the explicit scheme the implicit one reaches what is asked for."""
    lines = []
    for key, flow in BENCHMARKS.items():
        of_flow = [row for row in rows if row.flow == key]
        errors = [row.l2 for row in of_flow if flow.at_explicit_errors and row.method == "explicit"]
        for error in errors if flow.target_error is None else [flow.target_error]:
            explicit, implicit = fastest(of_flow, error, "explicit"), fastest(of_flow, error, "implicit")
            if explicit and implicit:
                lines.append(
                    f"{flow.title}, {'error' if flow.at_explicit_errors else 'L2'} <= {error:.2g}: {name(implicit)} is "
                    f"{explicit.loop / implicit.loop:.3g} times faster than {name(explicit)}"
                )
    return lines


def comparison_table(found):
    """Markdown of comparisons: a table for each flow, under its title."""
    parts = []
    for key, flow in BENCHMARKS.items():
        rows = [one.cells([_ratio(one)], ">= {:g}") for one in found if one.peer.flow == key]
        if rows:
            parts.append(f"{flow.title}:\n\n{format_table(HEADER, rows)}")
    return "\n\n".join(parts)


def equal_resolution_table(found):
    """Markdown of comparisons at equal resolution."""
    rows = [one.cells([f"{one.errors:.0f}", f"{one.times:.3g}"], "error >= {:g}, time > 1") for one in found]
    title = "At an equal number of particles, ratios of the peer's error and time to ours"
    return f"{title}:\n\n{format_table(EQUAL_HEADER, rows)}"


def _ratio(one):
    """Ratio of the medians, and where the peer ran in several rounds the smallest and the largest within a round."""
    if not one.ours or len(one.peer.loops) == 1:
        return f"{one.ratio:.0f}"
    ratios = [theirs / ours for theirs, ours in zip(one.peer.loops, one.ours.loops, strict=True)]
    return f"{one.ratio:.0f} ({min(ratios):.0f}..{max(ratios):.0f})"


def name(row):
    """What a row of ours ran, its error and its time."""
    return f"{row.method}, {row.across} across: {row.l2:.1e} in {row.loop:.3f} s"
