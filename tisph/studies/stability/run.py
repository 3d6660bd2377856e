"""Run the stability matrix: a line as each cell ends, then maps as text and picture, all numbers, and a verdict.

Every cell is a process of its own on one thread, so that nothing that happens in one touches another. Runs are kept in
the folder of the results, so that an interrupted matrix goes on where it was.
"""

import tempfile
import time
from contextlib import closing
from pathlib import Path

from rich.console import Console

from tisph.studies.processes import read_result
from tisph.studies.stability import judge, matrix
from tisph.studies.stability.maps import Row
from tisph.studies.stability.output import Output
from tisph.studies.stability.plan import plan
from tisph.studies.store import Store, claimed

PATIENCE, ALLOWANCE = 10.0, 600.0
"""A run is ended after that many times its estimated time, and that many seconds besides: machines pause."""


def run(folder, forecast, processes, parts):
    """Run sub-matrices ``parts``, ``processes`` cells at a time, and leave all results in ``folder``.

    ``forecast(config)`` returns the numbers and the warnings of ``tisph check``. Returns True if every promise is kept
    and nothing is WRONG. Raises ConfigError where ``folder`` cannot be used.
    """
    folder = Path(folder)
    with claimed(folder, "another matrix is running there"):
        return _run(folder, forecast, processes, parts)


def _run(folder, forecast, processes, parts):
    with tempfile.TemporaryDirectory() as scratch, Console(stderr=True).status("checking the configs"):
        plans = {cell: plan(cell, forecast, Path(scratch)) for cell in matrix.cells(parts)}
    with Output(folder, parts, plans, processes) as output:
        for row in _rows(plans, Store(folder / "runs"), processes, output):
            output.add(row)
    return output.conclude()


def _rows(plans, store, processes, output):
    """Yield a ``Row`` for every plan as soon as its run and the calm one are known."""
    for each in plans.values():
        if each.refusal:
            yield Row(each, judge.refused(each))
    ended = {}
    with closing(_outcomes(plans, store, processes, output)) as outcomes:
        for found, outcome in outcomes:
            ended[found] = outcome
            for cell in [cell for cell in ended if cell == found or cell.calm == found]:
                if cell.calm in ended:
                    yield _row(plans[cell], *ended[cell], ended[cell.calm][0])


def _row(own, summary, message, calm):
    cost = summary.get("cost", {})
    judgement = judge.judge(own, summary, message, calm)
    return Row(own, judgement, cost.get("steps", 0), cost.get("wall_total_s", 0.0))


def _outcomes(plans, store, processes, output):
    """Yield cells with summary and message of their runs: first of those that are kept."""
    valid = {cell.name: each for cell, each in plans.items() if not each.refusal}
    configs = {name: each.config for name, each in valid.items()}

    def launch(name):
        output.started(name)
        return Limited(store.launch(name, configs[name]), PATIENCE * valid[name].seconds + ALLOWANCE)

    with closing(store.outcomes(configs, processes, launch)) as ended:
        for name, result, message in ended:
            output.ended(name)
            yield valid[name].cell, (result.summary, message)


class Limited:
    """A ``Process`` that is ended after ``seconds``."""

    def __init__(self, process, seconds):
        self.process, self.seconds = process, seconds
        self._began = time.perf_counter()
        self._late = False

    @property
    def finished(self):
        """Whether it has ended, or has been ended for being late."""
        if not self.process.finished and time.perf_counter() - self._began > self.seconds:
            self._late = True
            self.process.stop()
        return self.process.finished

    def outcome(self):
        """``Result`` of the run and its error message, as of a ``Process``."""
        if self._late:
            return read_result(self.process.folder), f"no end after {self.seconds:.0f} s"
        return self.process.outcome()

    def stop(self):
        """End it, if it still runs."""
        self.process.stop()
