"""Run time against error: every point several times, interleaved, beside the peers; table, picture, numbers.

Runs are processes of their own, one at a time, kept in the folder of the results, so that an interrupted benchmark goes
on where it was. The error of a run does not depend on what else the machine does; its time does, which is why each is
run in every round and medians are compared.
"""

import json
import os
import platform
from pathlib import Path
from statistics import median

from rich.console import Console

from tisph.errors import TisphError
from tisph.studies.frontier import peers
from tisph.studies.frontier.cases import BENCHMARKS, points
from tisph.studies.frontier.comparison import (
    comparison_table,
    comparisons,
    equal_resolution,
    equal_resolution_table,
    speedups,
)
from tisph.studies.frontier.pareto import Measured, pareto_front
from tisph.studies.frontier.picture import plot_frontier
from tisph.studies.store import Store
from tisph.text_table import format_header, format_row
from tisph.version import __version__

HEADER = ("flow", "method", "across", "threads", "steps", "error", "loop [s]", "process [s]", "front")
WIDTHS = (25, 6, 7, 5, 7, 26, 23, 5)
ROUNDS = {"channel": 3, "oldroyd_b": 3}
"""Rounds by group, else one: PySPH's vortices take minutes, and ratios of many hundreds need no median."""


def run(folder, quick=False, peers_folder=None, group="channel"):
    """Measure the flows of a group, print the tables, and leave ``frontier.png`` and ``frontier.json`` in ``folder``.

    ``peers_folder``: where the peers' scripts are, None to measure none. Returns False if a peer comes closer than its
    bound allows, else True.
    """
    folder.mkdir(parents=True, exist_ok=True)
    wanted, theirs = points(group, quick), peers.runs(group, quick)
    rounds = {point.name: [] for point in wanted}
    store = Store(folder / "runs")
    print(f"finished runs are kept in {folder} and used again by the same command\n", flush=True)
    others = []
    for number in range(ROUNDS.get(group, 1)):
        for point in wanted:
            rounds[point.name].append(outcome(store, f"{point.name}_round_{number}", point.config))
        if peers_folder:
            others.append(peers.measure(peers_folder, folder / "peers", number, theirs))
    rows = [*(measured(point, rounds[point.name]) for point in wanted), *peers.merged(others, group)]
    return show(folder, rows)


def outcome(store, name, config):
    """Return the summary of a run, kept or new. Raises TisphError where it could not even start."""
    with Console(stderr=True).status(name):
        ((_, result, message),) = store.outcomes({name: config}, 1)
    if "cost" not in result.summary:
        raise TisphError(f"{name}: {message}")
    return result.summary


def measured(point, summaries):
    """Return what the rounds of a point gave, from their summaries."""
    costs = [summary["cost"] for summary in summaries]
    samples = summaries[0]["samples"]
    return Measured(
        flow=point.flow,
        method=point.method,
        across=point.across,
        threads=summaries[0]["provenance"]["threads"],
        steps=costs[0]["steps"],
        l2=BENCHMARKS[point.flow].error(samples[-1]) if samples else float("nan"),
        loops=tuple(cost["wall_loop_s"] for cost in costs),
        processes=tuple(cost["wall_total_s"] for cost in costs),
    )


def show(folder, rows):
    """Print the tables of ``rows``, write picture and numbers into ``folder``; False if a bound is missed."""
    fronts = {flow: pareto_front([row for row in rows if row.flow == flow and row.ours]) for flow in BENCHMARKS}
    _print_points(rows, fronts)
    found, same = comparisons(rows), equal_resolution(rows)
    print("", *speedups(rows), "", comparison_table(found), sep="\n")
    if same:
        print("", equal_resolution_table(same), sep="\n")
    place = machine()
    numbers = {
        "machine": place,
        "points": [row.numbers for row in rows],
        "comparisons": [one.numbers for one in found],
        "equal_number": [one.numbers for one in same],
    }
    (folder / "frontier.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    plot_frontier(folder / "frontier.png", rows, fronts)
    print(f"\n{place['processor']}, {place['cores']} cores, {place['platform']}")
    print(f"picture: {folder / 'frontier.png'}; numbers: {folder / 'frontier.json'}")
    return all(one.passed for one in (*found, *same))


def _print_points(rows, fronts):
    rounds = max(len(row.loops) for row in rows)
    print(f"{rounds} interleaved rounds, median (smallest..largest)\n" if rounds > 1 else "one round\n")
    widths = (max(len(BENCHMARKS[row.flow].title) for row in rows), *WIDTHS)
    print(format_header(HEADER, widths))
    for row in rows:
        cells = (
            BENCHMARKS[row.flow].title,
            row.method,
            str(row.across),
            str(row.threads),
            "" if row.steps is None else str(row.steps),
            f"{row.l2:.1e}",
            "quoted " * row.quoted + _median_and_range(row.loops),
            _median_and_range(row.processes) if row.processes else "",
            "*" if row in fronts[row.flow] else "",
        )
        print(format_row(cells, widths))


def _median_and_range(seconds):
    return (
        f"{median(seconds):.3f} ({min(seconds):.3f}..{max(seconds):.3f})" if len(seconds) > 1 else f"{seconds[0]:.3f}"
    )


CPUINFO = Path("/proc/cpuinfo")
"""Where Linux tells the name of the processor; elsewhere Python knows it."""


def machine():
    """``processor``, ``cores``, ``platform``, and ``version`` of this program, as a dictionary."""
    lines = CPUINFO.read_text(encoding="utf-8").splitlines() if CPUINFO.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": names[0] if names else platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "platform": platform.platform(),
        "version": __version__,
    }
