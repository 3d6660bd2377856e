"""Run a sweep: a line as each run ends, then table, picture, orders, and the cheapest run within the bound."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from tisph.studies.engine import Engine
from tisph.studies.processes import prepare
from tisph.studies.store import Store, claimed
from tisph.studies.sweep import cluster, picture, plan, table
from tisph.text_table import format_table

PICTURE = "sweep.png"


def run(path, folder, forecast, processes, scheduler=None):
    """Run the study in the file ``path`` and leave its results in ``folder``; the ``table.Row``s, in their order.

    ``processes`` runs at a time on this machine, or on the workers of the ``scheduler`` at an address. Runs that have
    ended are kept and not run again. Raises ConfigError where the study or the folder cannot be used.
    """
    if not scheduler:
        prepare()
    with Console(stderr=True).status("checking the configs"):
        study = plan.read(path, forecast)
    folder = Path(folder or Path("runs") / study.name)
    with claimed(folder, "another sweep is running there"):
        return Sweep(study, folder).run(processes, scheduler)


class Sweep:
    """The rows of a study so far, kept in ``folder``."""

    def __init__(self, study, folder):
        self.study, self.folder = study, folder
        self.store = Store(folder / "runs")
        self.cases = {case.name: case for case in reversed(study.cases)}
        self.rows = {}

    def run(self, processes, scheduler):
        """Run what is missing; print and write as runs end."""
        missing = self._known()
        print(f"{len(self.study.cases)} runs, {len(self.study.cases) - len(missing)} of them known", flush=True)
        try:
            if missing:
                self._run(missing, processes, scheduler)
        finally:
            self._write()
        drawn = picture.plot(self.study, self._ordered(), self.folder / PICTURE)
        print(f"\n{self._conclusion()}\n")
        for name in (table.TABLE, table.COSTS, table.ARRAYS, *([PICTURE] if drawn else [])):
            print(self.folder / name)
        return self._ordered()

    def _known(self):
        """Take over refused and kept runs; return the cases that are left, one of each name."""
        missing = {}
        for case in self.study.cases:
            kept = None if case.refusal else self.store.kept(case.name, case.config)
            if case.refusal:
                self._add(case.name, None, case.refusal)
            elif kept:
                self._add(case.name, kept[0].summary, kept[1])
            else:
                missing[case.name] = case
        return list(missing.values())

    def _run(self, missing, processes, scheduler):
        configs = {case.name: case.config for case in missing}
        source = cluster.outcomes(configs, self.store, scheduler) if scheduler else None
        engine = Engine(self.store, processes, {case.name: case.seconds for case in missing})
        with engine, closing(engine.outcomes(configs, source=source)) as outcomes:
            for count, (name, result, message) in enumerate(outcomes, 1):
                self._add(name, result.summary, message)
                engine.say(self._line(name, count, len(missing), engine.seconds_left))
                self._write()

    def _line(self, name, count, total, rest):
        found = self.rows[name]
        values = ", ".join(f"{key.rpartition('.')[2]} = {value}" for key, value in found.case.values.items())
        error = found.numbers[self.study.error]
        result = f"{self.study.error} {error:.2e}" if error is not None else found.message or found.status
        return f"{count}/{total}  {values}: {result}" + (f"  ({rest:.0f} s left)" if count < total else "")

    def _add(self, name, summary, message):
        self.rows[name] = table.row(self.study, self.cases[name], summary, message)

    def _ordered(self):
        """Rows of the cases that are known, in their order; several may be one run."""
        return [replace(self.rows[case.name], case=case) for case in self.study.cases if case.name in self.rows]

    def _write(self):
        table.write(self.study, self._ordered(), self.folder)

    def _conclusion(self):
        study, rows = self.study, self._ordered()
        states = [each.status for each in rows]
        counts = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
        lines = [f"{len(rows)} runs: {counts}"]
        powers = [(key, f"{power:.2f}", str(count)) for key, (power, count) in table.orders(study, rows).items()]
        if powers:
            lines += ["", format_table(("key", f"{study.error} ~ key^", "groups of runs"), powers), ""]
        best = table.cheapest(study, rows)
        within = "" if study.bound is None else f" with {study.error} <= {study.bound:g}"
        if best is None:
            return "\n".join([*lines, f"no run{within}"])
        setting = ", ".join(f"{key} = {value}" for key, value in best.case.values.items())
        cost = f"{best.numbers[study.error]:.2e} in {best.seconds:.3g} s, {best.steps} steps"
        return "\n".join([*lines, f"cheapest run{within}: {setting}: {cost}"])
