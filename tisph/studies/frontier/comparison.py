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
class Comparison:
    """A peer's run, and one of ours beside it, None where no run reaches its error.

    ``ratios`` by name: of theirs over ours. ``bound``: the least allowed value of the first of them, None where nothing
    is asked for. ``faster``: whether we are to be the faster ones, too.
    """

    peer: Measured
    ours: Measured | None
    ratios: dict[str, float]
    bound: float | None
    faster: bool = False

    @property
    def passed(self):
        """Whether the bound holds; True without one."""
        first, *_ = self.ratios.values()
        return self.bound is None or (first >= self.bound and not (self.faster and self.ratios["times"] <= 1))

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


def _at_its_error(peer, of_flow):
    """A ``Comparison`` with our fastest run whose error is no larger: of loop times, 0 where none is."""
    ours, asked = fastest(of_flow, peer.l2), BENCHMARKS[peer.flow].bound(peer)
    return Comparison(peer, ours, {"ratio": peer.loop / ours.loop if ours else 0.0}, asked and asked.speedup)


def _at_its_resolution(peer, ours):
    """A ``Comparison`` with our run of as many particles: of errors and of loop times."""
    ratios, asked = {"errors": peer.l2 / ours.l2, "times": peer.loop / ours.loop}, BENCHMARKS[peer.flow].bound(peer)
    return Comparison(peer, ours, ratios, asked and asked.accuracy_ratio, faster=True)


def comparisons(rows):
    """A ``Comparison`` for each peer's row that has an error, flow by flow in the order of ``BENCHMARKS``."""
    found = []
    for flow in BENCHMARKS:
        of_flow = [row for row in rows if row.flow == flow]
        peers = [row for row in of_flow if not row.ours and row.l2 == row.l2]
        found += [_at_its_error(peer, of_flow) for peer in peers]
    return found


def equal_resolution(rows):
    """A ``Comparison`` for each peer's row with an error where our method ran with as many particles."""
    ours = {
        (row.flow, row.across): row
        for row in rows
        if row.ours and row.method == BENCHMARKS[row.flow].equal_resolution_method and row.l2 == row.l2
    }
    peers = [row for row in rows if not row.ours and row.l2 == row.l2 and (row.flow, row.across) in ours]
    return [_at_its_resolution(peer, ours[peer.flow, peer.across]) for peer in peers]


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
    texts = [[f"{one.ratios['errors']:.0f}", f"{one.ratios['times']:.3g}"] for one in found]
    rows = [one.cells(text, "error >= {:g}, time > 1") for one, text in zip(found, texts, strict=True)]
    title = "At an equal number of particles, ratios of the peer's error and time to ours"
    return f"{title}:\n\n{format_table(EQUAL_HEADER, rows)}"


def _ratio(one):
    """Ratio of the medians, and where the peer ran in several rounds the smallest and the largest within a round."""
    text = f"{one.ratios['ratio']:.0f}"
    if not one.ours or len(one.peer.loops) == 1:
        return text
    ratios = [theirs / ours for theirs, ours in zip(one.peer.loops, one.ours.loops, strict=True)]
    return f"{text} ({min(ratios):.0f}..{max(ratios):.0f})"


def name(row):
    """What a row of ours ran, its error and its time."""
    return f"{row.method}, {row.across} across: {row.l2:.1e} in {row.loop:.3f} s"
