"""Run the stability matrix: a line as each cell ends, then maps as text and picture, all numbers, and a verdict.

Every cell is a process of its own on one thread, so that nothing that happens in one touches another. Runs are kept in
the folder of the results, so that an interrupted matrix goes on where it was.
"""

import tempfile
from contextlib import closing
from pathlib import Path

from rich.console import Console

from tisph.studies.engine import Engine
from tisph.studies.stability import judge, matrix
from tisph.studies.stability.maps import Row
from tisph.studies.stability.output import Output
from tisph.studies.stability.plan import plan
from tisph.studies.store import Store, claimed


def run(folder, forecast, processes, parts):
    """Run sub-matrices ``parts``, ``processes`` cells at a time, and leave all results in ``folder``.

    ``forecast(config)`` returns the numbers and the warnings of ``tisph check``. Returns True if every requirement is
    met. Raises ConfigError where ``folder`` cannot be used.
    """
    folder = Path(folder)
    with claimed(folder, "another matrix is running there"):
        with tempfile.TemporaryDirectory() as scratch, Console(stderr=True).status("checking the configs"):
            plans = {cell: plan(cell, forecast, Path(scratch)) for cell in matrix.cells(parts)}
        seconds = {cell.name: each.seconds for cell, each in plans.items() if not each.refusal}
        with Engine(Store(folder / "runs"), processes, seconds) as engine:
            output = Output(folder, parts, plans, engine)
            for row in _rows(plans, engine):
                output.add(row)
        return output.conclude()


def _rows(plans, engine):
    """Yield a ``Row`` for every plan as soon as its run and its baseline are known."""
    for each in plans.values():
        if each.refusal:
            yield Row(each, judge.refused(each))
    valid = {cell.name: each for cell, each in plans.items() if not each.refusal}
    ended = {}
    with closing(engine.outcomes({name: each.config for name, each in valid.items()}, limited=True)) as outcomes:
        for name, result, message in outcomes:
            found = valid[name].cell
            ended[found] = result.summary, message
            for cell in [cell for cell in ended if cell == found or cell.baseline == found]:
                if cell.baseline in ended:
                    yield _row(plans[cell], *ended[cell], ended[cell.baseline][0])


def _row(own, summary, message, baseline):
    cost = summary.get("cost", {})
    judgement = judge.judge(own, summary, message, baseline)
    return Row(own, judgement, cost.get("steps", 0), cost.get("wall_total_s", 0.0))
