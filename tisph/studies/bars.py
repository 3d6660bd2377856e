"""``tisph verify bars``: error bars of ``tisph run --until`` against true errors, in flows with known numbers.

A row is a flow and a goal. The cost of a chain is the processor time of the steps of all its runs. It is compared with
the cost of the coarsest of all known runs of the flow from which on each has an error inside the goal. Where this is
the coarsest run of the chain, three runs cost ten times as much: the other rows have a median of their own.
"""

import json
import math
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tisph.config.loader import loaded
from tisph.references.table import number as table_number
from tisph.studies import suites, until
from tisph.studies.processes import read_result
from tisph.text_table import format_table

AT_MOST = "60s"
"""Longest time of a chain; its bar is judged where it ends there, too."""

INSIDE, FACTOR, TIGHT, FARTHEST = 0.95, 3.0, 0.8, 3.0
"""Least part of the truths inside their bars; largest factor between bar and true error, and the least part of the rows
within it; largest error over the bar."""

COST, HIGHEST_COST = 1.8, 3.0
"""Largest median, and largest, cost over that of the cheapest single run."""

HEADER = "flow", "number", "truth", "goal", "value", "bar", "in", "error", "bar/error", "reached", "cost", "reason"


@dataclass(frozen=True)
class Row:
    """A chain: the ``error`` of its number, and its ``cost`` over that of the cheapest run; None without such a run."""

    flow: str
    kind: str
    number: str
    truth: float
    goal: str
    value: float | None
    bar: float | None
    error: float
    reached: bool
    reason: str | None
    cost: float | None
    coarsest_will_do: bool = False

    @property
    def factor(self) -> float:
        """Bar over true error; infinite without an error."""
        return math.inf if not self.error or self.bar is None else self.bar / self.error


def rows(folder: Path, names: Sequence[str] | None = None) -> Iterator[Row]:
    """Yield the rows of the flows in ``suites/bars.yaml``, or of those with ``names``; runs are kept in ``folder``."""
    study = suites.study("bars")
    for name, flow in study["flows"].items():
        if names and name not in names:
            continue
        config = suites.config_of(flow["suite"], flow["run"])
        config["time"] = {**config["time"], "end": flow["samples"][-1], "samples": flow["samples"]}
        config["runtime"] = {**config.get("runtime", {}), "threads": 1}
        number, root = flow["number"], folder / name
        chains = {}
        for goal in flow.get("goals", study["goals"]):
            found = until.run(loaded({"name": name, **config}, {}), root, {number: goal}, AT_MOST)
            chains[goal] = found[number]
        truth = flow["truth"] if "truth" in flow else read_result(root).last[f"{number}_exact"]
        yield from judged(name, flow, chains, table_number(truth) if isinstance(truth, str) else truth, root)


def judged(name: str, flow: dict[str, Any], chains: dict[str, Any], truth: float, root: Path) -> Iterator[Row]:
    """Yield a row for each goal of a flow, from the entries of ``accuracy.json`` by goal."""
    runs = {each["folder"]: each for entry in chains.values() for each in entry["runs"]}
    finest_first = sorted(runs.values(), key=lambda each: each["spacing"])
    for goal, entry in chains.items():
        if not entry["runs"]:
            yield Row(
                name, flow["kind"], flow["number"], truth, goal, None, None, math.nan, False, entry["reason"], None
            )
            continue
        cheapest = None
        for each in finest_first:
            if abs(each["value"] - truth) > float(goal.rstrip("%")) / 100.0 * abs(truth):
                break
            cheapest = each
        first = entry["runs"][0]["folder"]
        folders = [*(each["folder"] for each in entry["runs"]), f"{first}_shorter_steps"]
        spent = sum(_cost(root / each) for each in folders)
        cost = spent / _cost(root / cheapest["folder"]) if cheapest and entry["reached"] else None
        error, will_do = abs(entry["value"] - truth), cheapest is finest_first[-1]
        yield Row(
            name, flow["kind"], flow["number"], truth, goal, entry["value"], entry["bar"], error, entry["reached"],
            entry["reason"], cost, will_do,
        )  # fmt: skip


def _cost(folder: Path) -> float:
    return read_result(folder).summary["cost"]["processor_loop_s"] if folder.is_dir() else 0.0


def table(found: Sequence[Row]) -> str:
    """Return the rows as a table, and below it how many meet each bound."""
    cells = [
        (
            each.flow, each.number, f"{each.truth:.7g}", each.goal,
            "none" if each.value is None else f"{each.value:.7g}", "none" if each.bar is None else f"{each.bar:.1e}",
            "yes" if each.factor >= 1.0 else "no", f"{each.error:.1e}", f"{each.factor:.2g}",
            "yes" if each.reached else "no", "none" if each.cost is None else f"{each.cost:.2g}", each.reason or "",
        )
        for each in found
    ]  # fmt: skip
    return "\n".join([format_table(HEADER, cells), "", *(f"{text}: {words}" for text, words, _ in bounds(found))])


def bounds(found: Sequence[Row]) -> list[tuple[str, str, bool]]:
    """Return name, numbers in words and verdict of each bound."""
    bars = [each for each in found if each.reached]
    costs = [each.cost for each in bars if each.cost is not None]
    finer = [each.cost for each in bars if each.cost is not None and not each.coarsest_will_do]
    count, total = sum(each.factor >= 1.0 for each in bars), len(bars)
    tight = sum(1.0 / FACTOR <= each.factor <= FACTOR for each in bars)
    worst = max((1.0 / each.factor for each in bars), default=math.nan)
    middle, highest = statistics.median(costs or [math.nan]), max(costs, default=math.nan)
    return [
        ("goals reached", f"{total} of {len(found)}", True),
        ("truth inside the bar", f"{count} of {total}; {INSIDE:.0%} are wanted", count >= INSIDE * total),
        ("largest error", f"{worst:.2g} bars; at most {FARTHEST:g}", worst <= FARTHEST),
        (f"bar within a factor {FACTOR:g}", f"{tight} of {total}; {TIGHT:.0%} are wanted", tight >= TIGHT * total),
        ("median cost", f"{middle:.2g}; at most {COST:g}", middle <= COST),
        ("median cost where the coarsest run misses the goal", f"{statistics.median(finer or [math.nan]):.2g}", True),
        ("largest cost", f"{highest:.2g}; at most {HIGHEST_COST:g}", highest <= HIGHEST_COST),
    ]


def run(out: Path | None = None, as_json: bool = False) -> bool:
    """Print the table; return True if all bounds are met. Runs are kept in ``out``."""
    with ExitStack() as stack:
        folder = Path(out or stack.enter_context(tempfile.TemporaryDirectory(prefix="tisph-bars-")))
        found = list(rows(folder))
    verdicts = bounds(found)
    if as_json:
        kept = [{"name": name, "words": words, "passed": passed} for name, words, passed in verdicts]
        print(json.dumps({"rows": [asdict(each) for each in found], "bounds": kept}, indent=2))
    else:
        print(table(found))
    return all(passed for _, _, passed in verdicts)
