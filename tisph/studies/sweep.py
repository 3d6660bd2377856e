"""Sweeps: one config with some of its keys varied, run on all processors or on many machines, as one table.

STUDY.yaml says which keys take which values, together or each with each:

base: couette.yaml                      # a config, beside this file, or its keys as a map
vary:
  discretisation.particles_across: [10, 20, 40]
  time.tolerance: {from: 1.0e-5, to: 1.0e-3, count: 3, spacing: log}
  "fluid.density, walls.top.velocity": [[1.0, 0.5], [2.0, 0.25]]    # go together
collect: [l2, wall_shear_top]           # numbers of the last sample, of numbers or of cost
error: l2                               # by which the summary judges
bound: 1.0e-3                           # the cheapest run below it is named

The table has a row a run. ``table.csv`` depends on the configs alone, and is the same to the last byte however, where
and in how many attempts the runs were made; ``costs.csv`` has the seconds, which are not. ``table.h5`` has the columns
of both.
"""

import csv
import hashlib
import itertools
import json
import statistics
import tempfile
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from rich.console import Console

from tisph.config import load
from tisph.config.fields import nearest
from tisph.config.yaml_text import YamlTextError, dump, parse
from tisph.errors import ConfigError
from tisph.measures.metrics import fitted_order
from tisph.observers._storage import hdf5_file, replaced
from tisph.report import style
from tisph.studies import sweep_cluster
from tisph.studies.processes import prepare
from tisph.studies.store import Engine, Store, claimed
from tisph.text_table import format_table

KEYS = ("name", "base", "vary", "collect", "error", "bound")
RANGE = {"from", "to", "count", "spacing"}

MOST = 100_000
"""Runs; more are a slip of the pen."""

TABLE, COSTS, ARRAYS, PICTURE = "table.csv", "costs.csv", "table.h5", "sweep.png"

MOST_LINES = 12
"""Lines of a panel of the picture that has a legend."""


@dataclass(frozen=True)
class Case:
    """One run: the ``values`` of the varied keys, its ``config`` as a plain dict, ``seconds`` that it may take.

    ``name`` is the hash of the config, by which a run is known again. ``refusal`` says why a config is not valid, None
    where it is.
    """

    name: str
    values: dict
    config: dict | None
    seconds: float = 1.0
    refusal: str | None = None


@dataclass(frozen=True)
class Study:
    """A sweep: its name, the varied ``keys``, its cases, the numbers to ``collect``, and the bound of an ``error``."""

    name: str
    keys: tuple[str, ...]
    cases: tuple[Case, ...]
    collect: tuple[str, ...]
    error: str
    bound: float | None


def read(path: str | Path, forecast: Callable) -> Study:
    """``Study`` that the file ``path`` describes; ConfigError with one message where it cannot be understood.

    ``forecast(config)`` returns the numbers and the warnings of ``tisph check``, or raises ConfigError.
    """
    path = Path(path)
    try:
        data = parse(path.read_text(encoding="utf-8")).data
    except YamlTextError as error:
        raise ConfigError(f"{path}:{error.line or 1}: {error.text}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not isinstance(data, dict) or not {"base", "vary"} <= set(data):
        raise ConfigError(f"{path}: must be a map with the keys base and vary")
    for key in set(data) - set(KEYS):
        raise ConfigError(f"{path}: unknown key {key}{nearest(key, list(KEYS))}")
    keys, rows = _rows(data["vary"], path)
    collect = tuple(data.get("collect", ("l2",)))
    with tempfile.TemporaryDirectory() as scratch:
        base = _base(data["base"], path, Path(scratch))
        cases = tuple(_case(base, dict(zip(keys, row, strict=True)), forecast) for row in rows)
    error = data.get("error", collect[0] if collect else "l2")
    return Study(
        data.get("name", path.stem), keys, cases, tuple(dict.fromkeys((error, *collect))), error, data.get("bound")
    )


def _base(base, path, scratch):
    """Path of the config; a map is written into ``scratch``."""
    if isinstance(base, dict):
        file = scratch / f"{path.stem}.yaml"
        file.write_text(dump(base), encoding="utf-8")
        return file
    found = path.parent / str(base)
    return found if found.is_file() else Path(str(base))


def _rows(vary, path):
    """Keys and all rows of their values, the last key changing fastest."""
    if not isinstance(vary, dict) or not vary:
        raise ConfigError(f"{path}: vary must be a map of keys and their values")
    axes = [_axis(name, values, path) for name, values in vary.items()]
    keys = tuple(key for names, _ in axes for key in names)
    if len(set(keys)) < len(keys):
        raise ConfigError(f"{path}: vary: a key is given twice")
    count = int(np.prod([len(values) for _, values in axes], dtype=object))
    if not 0 < count <= MOST:
        raise ConfigError(f"{path}: vary: {count} runs; 1 to {MOST} are possible")
    return keys, [sum(row, ()) for row in itertools.product(*(values for _, values in axes))]


def _axis(name, values, path):
    """Keys that go together, and their values as tuples."""
    names = tuple(part.strip() for part in name.split(","))
    if isinstance(values, dict):
        values = _range(name, values, path)
    if not isinstance(values, list) or not values:
        raise ConfigError(f"{path}: vary.{name}: must be a list, or a range such as {{from: 1, to: 9, count: 3}}")
    if len(names) == 1:
        return names, [(value,) for value in values]
    if not all(isinstance(value, list) and len(value) == len(names) for value in values):
        raise ConfigError(f"{path}: vary.{name}: each item must be a list of {len(names)} values")
    return names, [tuple(value) for value in values]


def _range(name, given, path):
    """Values from one end to the other, of whole numbers whole ones."""
    if not {"from", "to", "count"} <= set(given) <= RANGE or given.get("spacing", "linear") not in ("linear", "log"):
        raise ConfigError(f"{path}: vary.{name}: a range has the keys from, to, count and spacing (linear or log)")
    ends = given["from"], given["to"]
    try:
        spaced = np.geomspace if given.get("spacing") == "log" else np.linspace
        values = spaced(*ends, given["count"])
    except (TypeError, ValueError) as error:
        raise ConfigError(f"{path}: vary.{name}: {error}") from None
    if all(isinstance(end, int) for end in ends):
        return list(dict.fromkeys(round(value) for value in values))
    return [float(f"{value:.12g}") for value in values]


def _case(base, values, forecast):
    try:
        config = load(base, [f"{key}={json.dumps(value)}" for key, value in values.items()])
        numbers, _ = forecast(config)
    except ConfigError as error:
        return Case(_hash(values), values, None, refusal=str(error))
    data = config.resolved()
    del data["name"]
    data["output"] = {**data["output"], "video": None}
    if config.runtime.threads == "auto":
        data["runtime"] = {**data["runtime"], "threads": 1}  # the runs share the processors, not their loops
    return Case(_hash(data), values, data, float(numbers["run_time"] or 1.0))


def _hash(data):
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Row:
    """A case and the outcome of its run: the collected ``numbers`` by name, None where the run has none."""

    case: Case
    status: str
    message: str
    numbers: dict
    steps: int | None = None
    particles: int | None = None
    seconds: float | None = None
    total: float | None = None


def row(study: Study, case: Case, summary: dict[str, Any] | None, message: str) -> Row:
    """``Row`` of a run that left a ``summary``; of a config that is refused ``summary`` is None."""
    if summary is None:
        return Row(case, "refused", message, dict.fromkeys(study.collect))
    cost, numbers = summary.get("cost", {}), summary.get("numbers", {})
    return Row(
        case,
        summary["status"],
        message,
        {name: _collected(summary, name) for name in study.collect},
        cost.get("steps"),
        numbers.get("particles_fluid"),
        cost.get("wall_loop_s"),
        cost.get("wall_total_s"),
    )


def _collected(summary, name):
    """Number of the last sample if the run reached it, else of ``numbers`` or ``cost``."""
    last = summary["samples"][-1] if summary["status"] == "done" and summary.get("samples") else {}
    for place in (last, summary.get("numbers", {}), summary.get("cost", {})):
        if isinstance(place.get(name), int | float):
            return place[name]
    return None


def write(study: Study, rows: list[Row], folder: Path) -> None:
    """Write all files from ``rows``, in the order of the cases."""
    names = [each.case.name for each in rows]
    computed = {
        "run": names,
        **{key: [each.case.values[key] for each in rows] for key in study.keys},
        "status": [each.status for each in rows],
        "particles": [each.particles for each in rows],
        "steps": [each.steps for each in rows],
        **{name: [each.numbers[name] for each in rows] for name in study.collect},
        "message": [each.message for each in rows],
    }
    costs = {"run": names, "loop_s": [each.seconds for each in rows], "total_s": [each.total for each in rows]}
    for name, columns in ((TABLE, computed), (COSTS, costs)):
        with replaced(folder / name) as new, new.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(zip(*(map(_text, column) for column in columns.values()), strict=True))
    with replaced(folder / ARRAYS) as new, hdf5_file(new) as file:
        for name, column in {**computed, **costs}.items():
            numeric = all(value is None or isinstance(value, int | float) for value in column)
            kind = float if numeric else h5py.string_dtype()
            values = [np.nan if value is None else value for value in column] if numeric else map(_text, column)
            file.create_dataset(name, data=np.array(list(values), dtype=object).astype(kind))


def _text(value):
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)


def orders(study: Study, rows: list[Row]) -> dict[str, tuple[float, int]]:
    """Powers with which the error scales with each varied number: median over the runs that agree in all else.

    Pairs (key, (power, groups)); none where an error does not exist or is zero.
    """
    found = {}
    for key in study.keys:
        lines = [zip(*points, strict=True) for points in groups(study, rows, key).values() if len(points) > 1]
        slopes = [-fitted_order(values, errors) for values, errors in lines]
        if slopes:
            found[key] = statistics.median(slopes), len(slopes)
    return found


def groups(study: Study, rows: list[Row], key: str, of: Callable[[Row], float] | None = None) -> dict[tuple, list]:
    """Pairs (value of ``key``, ``of(row)``, or else the error) by the values of all other keys; positive ones only."""
    found = {}
    for each in rows:
        value, number = each.case.values[key], of(each) if of else each.numbers[study.error]
        if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0 or not number or number <= 0:
            continue
        others = tuple((name, str(other)) for name, other in each.case.values.items() if name != key)
        found.setdefault(others, []).append((value, number))
    return {others: sorted(points) for others, points in found.items()}


def cheapest(study: Study, rows: list[Row]) -> Row | None:
    """The run of the shortest loop whose error is within the bound; None without one."""
    within = [each for each in rows if each.status == "done" and each.numbers[study.error] is not None]
    within = [each for each in within if study.bound is None or each.numbers[study.error] <= study.bound]
    return min(within, key=lambda each: each.seconds or np.inf, default=None)


def plot(study: Study, rows: list[Row], path: Path) -> bool:
    """Draw into ``path``; nothing where no key has two numbers."""
    keys = [key for key in study.keys if any(len(points) > 1 for points in groups(study, rows, key).values())]
    if not keys:
        return False
    found = orders(study, rows)
    with style.plot_style():
        figure = style.plot_figure(rows=len(keys))
        grid = figure.subplots(len(keys), 2, squeeze=False)
        for axes, key in zip(grid, keys, strict=True):
            _panel(axes[0], groups(study, rows, key), f"error: {study.error}", key)
            _panel(axes[1], groups(study, rows, key, lambda each: each.seconds), "time of the loop [s]", key)
            power, count = found[key]
            axes[0].set_title(f"{study.error} ~ ({key})^{power:.2g}" + (f", median of {count}" if count > 1 else ""))
            if study.bound:
                axes[0].axhline(study.bound, color=style.EXACT, linewidth=0.9)
        figure.tight_layout()
        figure.save(path)
    return True


def _panel(axes, groups, label, key):
    colours = style.colours(max(len(groups), 2), 0.85)
    lines = []
    for (others, points), colour in zip(groups.items(), colours, strict=False):
        name = ", ".join(f"{other.rpartition('.')[2]} = {value}" for other, value in others)
        lines.append((points, {"marker": "o", "color": colour, "label": name, "markersize": 4}))
    draw_lines(axes, lines, label, key)
    if 1 < len(groups) <= MOST_LINES:
        axes.legend(fontsize=7, frameon=False)


def draw_lines(axes: Any, lines: list[tuple], label: str, key: str) -> None:
    """Draw ``lines``, pairs of points (x, y) and options of matplotlib, on logarithmic axes with a tick at each x."""
    for points, options in lines:
        axes.loglog(*zip(*points, strict=True), **options)
    values = sorted({value for points, _ in lines for value, _ in points})
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.set_xticks([], minor=True)
    axes.set_xlabel(key)
    axes.set_ylabel(label)
    axes.grid(True, which="both")


def run(
    path: str | Path, folder: Path | None, forecast: Callable, processes: int, scheduler: str | None = None
) -> list[Row]:
    """Run the study in the file ``path`` and leave its results in ``folder``; the ``Row``s, in their order.

    ``processes`` runs at a time on this machine, or on the workers of the ``scheduler`` at an address. Runs that have
    ended are kept and not run again. Raises ConfigError where the study or the folder cannot be used.
    """
    if not scheduler:
        prepare()
    with Console(stderr=True).status("checking the configs"):
        study = read(path, forecast)
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
        """Run the cases that are missing; print and write as runs end."""
        missing = self._known()
        print(f"{len(self.study.cases)} runs, {len(self.study.cases) - len(missing)} of them known", flush=True)
        try:
            if missing:
                self._run(missing, processes, scheduler)
        finally:
            self._write()
        drawn = plot(self.study, self._ordered(), self.folder / PICTURE)
        print(f"\n{self._conclusion()}\n")
        for name in (TABLE, COSTS, ARRAYS, *([PICTURE] if drawn else [])):
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
        source = sweep_cluster.outcomes(configs, self.store, scheduler) if scheduler else None
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
        self.rows[name] = row(self.study, self.cases[name], summary, message)

    def _ordered(self):
        """Rows of the cases that are known, in their order; several may be one run."""
        return [replace(self.rows[case.name], case=case) for case in self.study.cases if case.name in self.rows]

    def _write(self):
        write(self.study, self._ordered(), self.folder)

    def _conclusion(self):
        study, rows = self.study, self._ordered()
        states = [each.status for each in rows]
        counts = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
        lines = [f"{len(rows)} runs: {counts}"]
        powers = [(key, f"{power:.2f}", str(count)) for key, (power, count) in orders(study, rows).items()]
        if powers:
            lines += ["", format_table(("key", f"{study.error} ~ key^", "groups of runs"), powers), ""]
        best = cheapest(study, rows)
        within = "" if study.bound is None else f" with {study.error} <= {study.bound:g}"
        if best is None:
            return "\n".join([*lines, f"no run{within}"])
        setting = ", ".join(f"{key} = {value}" for key, value in best.case.values.items())
        cost = f"{best.numbers[study.error]:.2e} in {best.seconds:.3g} s, {best.steps} steps"
        return "\n".join([*lines, f"cheapest run{within}: {setting}: {cost}"])
