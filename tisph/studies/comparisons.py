"""``tisph verify comparisons``: verdicts of ``tisph compare`` on data of flows without an exact solution.

The data are finer runs of this program with other first places of the particles, as they are or with one change: a key
of the config, all values by a factor, or all places by a distance. A verdict is right if data without a change agree,
and if data with a change differ and the change is named with its value. It is wrong if the opposite is said, or if
other changes are named alone: an undecided verdict, or a difference that nothing explains, is neither.
"""

import json
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tisph.assessment.judge import Question
from tisph.config.loader import loaded
from tisph.errors import TisphError
from tisph.results import open_run
from tisph.studies import referee, suites
from tisph.studies.processes import Result
from tisph.studies.store import Store, claimed
from tisph.text_table import format_table

NEAR = 0.1
"""Largest error of the value of a change, over the change, beside three of its stated uncertainties."""

RIGHT, WRONG, NEITHER = "right", "WRONG", "neither"


@dataclass(frozen=True)
class Row:
    """A data set of a ``flow``, the ``change`` in it and what the comparison says."""

    flow: str
    change: str
    difference: float
    bar: float
    verdict: str
    explained: tuple[str, ...]
    judged: str


def rows(folder: Path, names: Sequence[str] | None = None) -> Iterator[Row]:
    """Yield the rows of ``suites/comparisons.yaml``, or of its flows ``names``; runs are kept in ``folder``."""
    for name, flow in suites.study("comparisons")["flows"].items():
        if names and name not in names:
            continue
        config, root = loaded({"name": name, **flow["config"]}, {"runtime.threads": 1}), folder / name
        root.mkdir(parents=True, exist_ok=True)
        store = Store(root)
        for change, given in flow["data"].items():
            finer = loaded(config, {**flow["finer"], **given.get("keys", {})}).resolved()
            result, message = store.outcome(change, {key: finer[key] for key in finer if key != "name"})
            if message:
                raise TisphError(f"{name}, {change}: the run did not finish: {message}")
            data = root / f"{change}.csv"
            _write(result, data, given)
            found = referee.compare(config, [data], Question(), root / "reference")
            yield judged(name, change, given.get("by"), found)


def _write(result: Result, path: Path, given: dict[str, Any]) -> None:
    """Write the data of a run into a CSV file: a number over time, or fields."""
    factor, shift = given.get("factor", 1.0), given.get("shift", (0.0, 0.0))
    if number := given.get("number"):
        names = ["t", number]
        table = np.array([[sample["t"], factor * sample[number]] for sample in result.summary["samples"]])
    else:
        names, parts = ["t", "x", "y", "u", "v", "p"], []
        for each in open_run(result.folder).snapshots():
            place, velocity = (each.x + shift[0], each.y + shift[1]), (factor * each.u, factor * each.v)
            parts.append(np.stack([np.full(len(each.x), each.t), *place, *velocity, each.pressure], axis=1))
        table = np.concatenate(parts)
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="", fmt="%.10g")


def judged(flow: str, change: str, by: Any, found: referee.Comparison) -> Row:
    """Return the row of a comparison; ``by``: the value of the change, None where there is none."""
    main = found.findings[0]
    verdicts = {each.verdict for each in found.findings}
    if by is None:
        verdict = RIGHT if verdicts == {"agrees"} else WRONG if "differs" in verdicts else NEITHER
    elif "differs" not in verdicts:
        verdict = WRONG if verdicts == {"agrees"} else NEITHER
    else:
        true = np.atleast_1d(by)
        named = [each for each in found.explained if each.name == change.replace("_", " ")]
        off = [np.abs(np.array(each.values) - true) for each in named]
        near = NEAR * np.abs(true).max()
        right = any(np.all(o <= near + 3.0 * np.array(each.uncertain)) for o, each in zip(off, named, strict=True))
        verdict = RIGHT if right else WRONG if found.explained else NEITHER
    words = tuple(each.words for each in found.explained)
    return Row(flow, change, main.difference, main.bar, "/".join(sorted(verdicts)), words, verdict)


HEADER = "flow", "data", "difference", "bar", "verdict", "explained by", "judged"


def table(found: Sequence[Row]) -> str:
    """Return the rows as a table, and below it how many are right and wrong."""
    cells = [
        (each.flow, each.change, f"{each.difference:.2g}", f"{each.bar:.2g}", each.verdict,
         "; ".join(each.explained) or "-", each.judged)
        for each in found
    ]  # fmt: skip
    counts = [f"{sum(each.judged == kind for each in found)} of {len(found)} {kind}" for kind in (RIGHT, WRONG)]
    return f"{format_table(HEADER, cells)}\n\n{', '.join(counts)}"


def run(out: Path | None = None, as_json: bool = False) -> bool:
    """Print the table; return True if all verdicts are right. Runs are kept in ``out``."""
    with ExitStack() as stack:
        if out:
            stack.enter_context(claimed(Path(out), "another verification is writing there"))
        folder = Path(out or stack.enter_context(tempfile.TemporaryDirectory(prefix="tisph-comparisons-")))
        found = list(rows(folder))
    print(json.dumps([asdict(each) for each in found], indent=2) if as_json else table(found))
    return all(each.judged == RIGHT for each in found)
