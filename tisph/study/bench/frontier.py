"""Run time against error: every point several times, interleaved, beside the peers; table, picture, numbers.

Runs are processes of their own, one at a time, kept in the folder of the results, so that an interrupted benchmark goes
on where it was. The error of a run does not depend on what else the machine does; its time does, which is why each is
run in every round and medians are compared.
"""

import json
import os
import platform
from dataclasses import dataclass
from statistics import median

from rich.console import Console

import tisph
from tisph.study.bench import peers
from tisph.study.bench.cases import FLOWS, points
from tisph.study.bench.picture import plot_frontier
from tisph.study.processes import run_side_by_side
from tisph.study.store import Store
from tisph.verification.table import format_header, format_row

HEADER = ("flow", "way", "across", "steps", "L2", "loop [s]", "process [s]", "front")
WIDTHS = (27, 26, 6, 6, 8, 22, 20, 5)
ROUNDS = 3


@dataclass(frozen=True)
class Measured:
    """A point's outcome: L2, steps, loop and whole-process seconds of every round; NaN where a run stopped.

    ``elsewhere``: the time is scaled, from a shorter run here or from another machine.
    """

    flow: str
    way: str
    across: int
    steps: int
    l2: float
    loops: tuple[float, ...]
    processes: tuple[float, ...]
    elsewhere: bool = False

    @property
    def loop(self):
        """Median loop time [s]."""
        return median(self.loops)


def run(folder, quick=False, peers_folder=None):
    """Measure, print the table, and leave ``frontier.png`` and ``frontier.json`` in ``folder``.

    ``peers_folder``: where the peers' scripts are, None to leave them out. Returns True: nothing is judged here.
    """
    folder.mkdir(parents=True, exist_ok=True)
    wanted = points(quick)
    rounds = {point: [] for point in range(len(wanted))}
    store = Store(folder / "runs")
    print(f"finished runs are kept in {store.folder} and used again by the same command\n", flush=True)
    others = []
    for turn in range(ROUNDS):
        for number, point in enumerate(wanted):
            rounds[number].append(outcome(store, f"{point.name}_round_{turn}", point.config))
        if peers_folder:
            others.append(peers.measure(peers_folder, folder / "peers", turn))
    ours = [measured(point, rounds[number]) for number, point in enumerate(wanted)]
    rows = [*ours, *peers.merged(others)]
    _show(folder, rows)
    return True


def outcome(store, name, config):
    """Return the summary of a run, kept or new."""
    kept = store.kept(name, config)
    if kept:
        return kept[0].summary
    with Console(stderr=True).status(name):
        ((_, result, _),) = run_side_by_side([name], lambda wanted: store.launch(wanted, config), 1)
    return result.summary


def measured(point, summaries):
    """Return what the rounds of a point gave, from their summaries."""
    costs = [summary["cost"] for summary in summaries]
    samples = summaries[0]["samples"]
    return Measured(
        flow=point.flow,
        way=point.way,
        across=point.across,
        steps=costs[0]["steps"],
        l2=samples[-1]["l2"] if samples else float("nan"),
        loops=tuple(cost["wall_loop_s"] for cost in costs),
        processes=tuple(cost["wall_total_s"] for cost in costs),
    )


def front(rows):
    """Those of ``rows`` (of one flow) that no other beats in both error and loop time."""
    return [
        row
        for row in rows
        if row.l2 == row.l2 and not any(other.l2 <= row.l2 and other.loop < row.loop for other in rows)
    ]


def fastest(rows, error, *starts):
    """The row with the shortest loop among those with an L2 of at most ``error`` whose way has one of ``starts``."""
    found = [row for row in rows if row.l2 <= error and row.way.startswith(starts)]
    return min(found, key=lambda row: row.loop, default=None)


def _show(folder, rows):
    print(format_header(HEADER, WIDTHS))
    fronts = {flow: front([row for row in rows if row.flow == flow and not row.elsewhere]) for flow in FLOWS}
    for row in rows:
        cells = (
            FLOWS[row.flow][0],
            row.way,
            str(row.across),
            str(row.steps),
            f"{row.l2:.1e}",
            _spread(row.loops),
            _spread(row.processes) if row.processes else "",
            "*" if row in fronts[row.flow] else "",
        )
        print(format_row(cells, WIDTHS))
    print("\n" + "\n".join(comparisons(rows)))
    place = {"platform": platform.platform(), "cores": os.cpu_count(), "version": tisph.__version__}
    numbers = {"machine": place, "points": [vars(row) | {"loop": row.loop} for row in rows]}
    (folder / "frontier.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    plot_frontier(folder / "frontier.png", rows, fronts)
    print(f"\n{place['platform']}, {place['cores']} cores; {ROUNDS} rounds, median (smallest..largest)")
    print(f"picture: {folder / 'frontier.png'}; numbers: {folder / 'frontier.json'}")


def _spread(seconds):
    return f"{median(seconds):.3f} ({min(seconds):.3f}..{max(seconds):.3f})"


def comparisons(rows):
    """Lines that compare the fastest ways to reach an error."""
    lines = []
    for flow, error in (("couette_2.7", 1e-3), ("couette_20", 1e-4)):
        of_flow = [row for row in rows if row.flow == flow]
        explicit, implicit = fastest(of_flow, error, "explicit"), fastest(of_flow, error, "implicit")
        if explicit and implicit:
            lines.append(
                f"{FLOWS[flow][0]}, L2 <= {error:g}: {_name(implicit)} is {explicit.loop / implicit.loop:.3g} times "
                f"faster than {_name(explicit)}"
            )
        for peer in of_flow:
            if not peer.way.startswith(("explicit", "implicit")):
                for bound in sorted({peer.l2, error}, reverse=True):
                    ours = fastest(of_flow, bound, "explicit", "implicit")
                    if ours:
                        lines.append(
                            f"{FLOWS[flow][0]}, L2 <= {bound:.1e}: {_name(ours)} is {peer.loop / ours.loop:.4g} times "
                            f"faster than {peer.way}, which ends at {peer.l2:.1e}"
                        )
    return lines


def _name(row):
    return f"{row.way}, {row.across} across ({row.l2:.1e} in {row.loop:.3f} s)"
