"""Sweeps: one config with some of its keys varied, run on all processors or on many machines, as one table.

STUDY.yaml says which keys take which values, in all combinations or together:

base: couette.yaml                      # a config, beside this file, or its keys as a map
vary:
  discretisation.particles_across: [10, 20, 40]
  time.tolerance: {from: 1.0e-5, to: 1.0e-3, count: 3, spacing: log}
  "fluid.density, walls.top.velocity": [[1.0, 0.5], [2.0, 0.25]]    # vary together
until: {wall_shear_top: 0.1%}            # refine each run until the error bar of a number is inside a goal
collect: [l2, wall_shear_top]           # numbers of the last sample, of numbers, of cost or of tisph rheometry
error: l2                               # the number that the summary judges
bound: 1.0e-3                           # the summary names the cheapest run below it

The table has a row for each run. ``table.csv`` depends on the configs alone: it has the same bytes wherever, and in
however many attempts, the runs were made. ``costs.csv`` has the seconds, which vary. ``table.h5`` has the columns of
both.
"""

import csv
import hashlib
import itertools
import json
import math
import multiprocessing
import re
import statistics
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from filelock import Timeout
from matplotlib.axes import Axes
from rich.console import Console

from tisph import scenes
from tisph.config import load
from tisph.config.fields import nearest
from tisph.config.loader import copy_shapes, override_texts
from tisph.config.schema import Config
from tisph.config.yaml_text import dump
from tisph.errors import ConfigError
from tisph.folder import hdf5_file, held, replaced
from tisph.measures.metrics import fitted_order, sample_metrics
from tisph.measures.steadiness import with_followed
from tisph.report import style
from tisph.results import open_run
from tisph.rheometry import rheometers
from tisph.schemes._forecast import forecast
from tisph.studies.processes import Outcomes, Result, prepare, run_config
from tisph.studies.store import START_SECONDS, Engine, Store, claimed, config_text, fingerprint
from tisph.studies.suites import document
from tisph.text_table import format_table

KEYS = ("name", "base", "vary", "until", "collect", "error", "bound")
RANGE = {"from", "to", "count", "spacing"}

MOST = 100_000
"""Largest number of runs; a larger one is taken for a mistake in the file."""

TABLE, COSTS, ARRAYS, PICTURE = "table.csv", "costs.csv", "table.h5", "sweep.png"

MOST_REASONS = 10
"""Largest number of reasons of refused runs that are printed."""

MOST_LINES = 12
"""Largest number of lines in a panel of the picture with a legend."""

TAKEN = "another sweep is running there"

RESOLUTION = ("discretisation.particles_across", "discretisation.spacing", "time.cfl", "time.tolerance")
"""Keys of the resolution in space and time: the error scales with a power of them."""

SUMMARY_NAMES = """
reynolds reference_velocity spacing smallest_spacing particles_fluid steady_since dt_min dt_max mach sound_speed
neighbours_mean neighbour_rebuilds particles_wall steps_rejected order_reduced neighbourhoods_dropped divergence
iterations_pressure iterations_velocity contacts contact_time contact_force steps wall_total_s wall_import_s
wall_compile_s wall_loop_s wall_output_s processor_loop_s processor_output_s particle_steps_per_s peak_memory_mb
"""
"""Names in the parts ``numbers`` and ``cost`` of ``summary.json``, of all flows and schemes."""

NOT_SENT = ("frames.h5", "checkpoint.h5", ".lock")
"""Large files that a worker does not send back, since no table needs them."""


@dataclass(frozen=True)
class Case:
    """One run: the ``values`` of the varied keys, its ``config`` as a plain dict, and its estimated ``seconds``.

    ``name``: hash of the config, which identifies the run. ``refusal``: why the config is not valid, else None.
    """

    name: str
    values: dict[str, Any]
    config: dict[str, Any] | None
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


def read(path: str | Path) -> Study:
    """Return the ``Study`` that the file ``path`` describes; ConfigError with one message for a mistake in it."""
    path = Path(path)
    data = document(path).data
    if not isinstance(data, dict) or not {"base", "vary"} <= set(data):
        raise ConfigError(f"{path}: must be a map with the keys base and vary")
    for key in set(data) - set(KEYS):
        raise ConfigError(f"{path}: unknown key {key}{nearest(key, list(KEYS))}")
    keys, rows = _rows(data["vary"], path)
    collect = data.get("collect", ["l2"])
    if not isinstance(collect, list) or not all(isinstance(name, str) for name in collect):
        raise ConfigError(f"{path}: collect must be a list of names, such as [l2, steps]")
    with tempfile.TemporaryDirectory() as scratch:
        if isinstance(data["base"], dict):
            base = Path(scratch) / f"{path.stem}.yaml"
            base.write_text(dump(data["base"]), encoding="utf-8")
            copy_shapes(data["base"], path.parent, Path(scratch))
        else:
            beside = path.parent / str(data["base"])
            base = beside if beside.is_file() else Path(str(data["base"]))
        cases = tuple(_case(base, dict(zip(keys, row, strict=True)), data.get("until")) for row in rows)
        judged = str(data.get("error", collect[0] if collect else "l2"))
        collected = tuple(dict.fromkeys((judged, *collect)))
        _require_names(path, collected, base, cases)
    return Study(data.get("name", path.stem), keys, cases, collected, judged, data.get("bound"))


def _require_names(path: Path, collected: tuple[str, ...], base: Path, cases: tuple[Case, ...]) -> None:
    """Raise ConfigError for a collected name that no run of the valid ``cases`` can have."""
    known = {*SUMMARY_NAMES.split(), *rheometers.NUMBERS}
    valid = [case for case in cases if case.config is not None]
    for case in valid:
        if known.issuperset(collected):
            break
        known |= sample_names(load(base, override_texts(case.values)))
    missing = [name for name in collected if name not in known]
    if valid and missing:
        texts = [f"{name}{nearest(name, sorted(known))}" for name in missing]
        raise ConfigError(
            f"{path}: collect, error: no run has the number {', '.join(texts)}; allowed: numbers of the last sample, "
            "of numbers or cost in summary.json, or of tisph rheometry"
        )


def sample_names(config: Config) -> set[str]:
    """Return the names of the numbers of a sample in ``summary.json`` of a valid ``config``, from its start."""
    from tisph.simulation.state import start_snapshot, start_values  # only here: it imports Taichi

    scene = scenes.of(config)
    start = start_snapshot(scene, start_values(scene.in_flow_frame(), config.initial), "f64")
    series = scene.time_series(**config.time_series)
    values = series.measure(start)
    record = np.array([start.t]), values[None]
    return set(sample_metrics(scene, start, with_followed((series.places, values, record), series.judged_sizes)))


def _rows(vary: Any, path: Path) -> tuple[tuple[str, ...], list[tuple]]:
    """Return the keys and all rows of their values, the last key changing fastest."""
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


def _axis(name: str, values: Any, path: Path) -> tuple[tuple[str, ...], list[tuple]]:
    """Return keys that vary together, and their values as tuples."""
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


def _range(name: str, given: dict[str, Any], path: Path) -> list[float]:
    """Return the values of a range, both ends included; whole numbers where both ends are whole."""
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


def _case(base: Path, values: dict[str, Any], until: Any = None) -> Case:
    try:
        config = load(base, override_texts({**values, **({} if until is None else {"accuracy": until})}))
        numbers, _ = forecast(config)
    except ConfigError as error:
        return Case(_hash(values), values, None, refusal=str(error))
    data = config.resolved()
    del data["name"]
    data["output"] = {**data["output"], "video": None}
    if config.runtime.threads == "auto":
        data["runtime"] = {**data["runtime"], "threads": 1}  # the runs share the processors, not their loops
    return Case(_hash(data), values, data, float(numbers["run_time"] or 1.0))


def _hash(data: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Row:
    """A case and the outcome of its run: the collected ``numbers`` by name, None where the run has none.

    ``seconds``: of the time loop; ``total``: of the whole process.
    """

    case: Case
    status: str
    message: str
    numbers: dict[str, Any]
    steps: int | None = None
    particles: int | None = None
    seconds: float | None = None
    total: float | None = None

    @property
    def record(self) -> dict[str, Any]:
        """Values of the row in the table by the names of its columns."""
        return {
            "run": self.case.name,
            **self.case.values,
            "status": self.status,
            "particles": self.particles,
            "steps": self.steps,
            **self.numbers,
            "message": self.message,
        }


def row(study: Study, case: Case, result: Result | None, message: str) -> Row:
    """Return the ``Row`` of a run from its ``result``, which is None for a refused config.

    A collected number is the one of the last sample, if the run reached it, else the one of ``numbers`` or ``cost``,
    else of the run as a rheometer.
    """
    if result is None:
        return Row(case, "refused", message, dict.fromkeys(study.collect))
    summary = result.summary
    cost, numbers = summary.get("cost", {}), summary.get("numbers", {})
    done = summary["status"] == "done"
    last = summary["samples"][-1] if done and summary.get("samples") else {}
    parts: list[dict[str, Any]] = [last, numbers, cost]
    if done and not {*last, *numbers, *cost}.issuperset(study.collect):
        try:
            parts.append(open_run(result.folder).rheometry().numbers)
        except ConfigError as error:
            message = str(error)
    collected = {
        name: next((part[name] for part in parts if _is_number(part.get(name))), None) for name in study.collect
    }
    steps, particles = cost.get("steps"), numbers.get("particles_fluid")
    return Row(
        case, summary["status"], message, collected, steps, particles, cost.get("wall_loop_s"), cost.get("wall_total_s")
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def write(study: Study, rows: list[Row], folder: Path) -> None:
    """Write all files from ``rows``, in the order of the cases."""
    names = ("run", *study.keys, "status", "particles", "steps", *study.collect, "message")
    computed = {name: [each.record[name] for each in rows] for name in names}
    costs: dict[str, list] = {
        "run": computed["run"],
        "loop_s": [each.seconds for each in rows],
        "total_s": [each.total for each in rows],
    }
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


def _text(value: Any) -> str:
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)


def orders(study: Study, rows: list[Row]) -> dict[str, tuple[float, int]]:
    """Return key -> (power, number of groups): the power of each varied key of ``RESOLUTION`` in the error.

    A group is a set of runs with equal values of all other keys; the power is the median over the groups. A key is
    missing where an error does not exist or is zero.
    """
    found = {}
    for key in (key for key in study.keys if key in RESOLUTION):
        lines = [zip(*points, strict=True) for points in groups(study, rows, key).values() if len(points) > 1]
        slopes = [-fitted_order(values, errors) for values, errors in lines]
        if slopes:
            found[key] = statistics.median(slopes), len(slopes)
    return found


Points = list[tuple[float, float]]


def groups(
    study: Study, rows: list[Row], key: str, of: Callable[[Row], float | None] | None = None
) -> dict[tuple[tuple[str, str], ...], Points]:
    """Return pairs (value of ``key``, ``of(row)``, or else the error) by the values of all other keys.

    Only positive values and numbers count.
    """
    found: dict[tuple[tuple[str, str], ...], Points] = {}
    for each in rows:
        value, number = each.case.values[key], of(each) if of else each.numbers[study.error]
        if isinstance(value, bool) or not isinstance(value, int | float) or value <= 0 or not number or number <= 0:
            continue
        others = tuple((name, str(other)) for name, other in each.case.values.items() if name != key)
        found.setdefault(others, []).append((value, number))
    return {others: sorted(points) for others, points in found.items()}


def plot(study: Study, rows: list[Row], path: Path) -> bool:
    """Draw the errors and times of ``rows`` into ``path``; return False, without a file, if no key has two numbers."""
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
            if key in found:
                power, count = found[key]
                median = f", median of {count}" if count > 1 else ""
                axes[0].set_title(f"{study.error} ~ ({key})^{power:.2g}{median}")
            if study.bound:
                axes[0].axhline(study.bound, color=style.EXACT, linewidth=0.9)
        figure.tight_layout()
        figure.save(path)
    return True


def _panel(axes: Axes, groups: dict[tuple[tuple[str, str], ...], Points], label: str, key: str) -> None:
    colours = style.colours(max(len(groups), 2), 0.85)
    lines: list[StyledLine] = []
    for (others, points), colour in zip(groups.items(), colours, strict=False):
        name = ", ".join(f"{other.rpartition('.')[2]} = {value}" for other, value in others)
        lines.append((points, {"marker": "o", "color": colour, "label": name, "markersize": 4}))
    draw_lines(axes, lines, label, key)
    if 1 < len(groups) <= MOST_LINES:
        axes.legend(fontsize=7, frameon=False)


StyledLine = tuple[Iterable[tuple[float, float]], dict[str, Any]]
"""Points (x, y) of a line, and options of matplotlib."""


def draw_lines(axes: Axes, lines: list[StyledLine], label: str, key: str) -> None:
    """Draw ``lines`` on logarithmic axes with a tick at each x; ``label`` names y, ``key`` names x."""
    for points, options in lines:
        axes.loglog(*zip(*points, strict=True), **options)
    values = sorted({value for points, _ in lines for value, _ in points})
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.set_xticks([], minor=True)
    axes.set_xlabel(key)
    axes.set_ylabel(label)
    axes.grid(True, which="both")


def run(
    path: str | Path,
    folder: Path | None,
    processes: int,
    scheduler: str | None = None,
    part: str | None = None,
    executor: Executor | None = None,
) -> list[Row]:
    """Run the study in the file ``path`` and leave its results in ``folder``; return the rows in the study's order.

    ``processes`` runs at a time on this machine, or on an ``executor``, or on the workers of the Dask ``scheduler`` at
    an address. ``part``, such as 3/20: make the runs of one part of 20, beside commands that make the others. Runs that
    have ended are kept and not run again. Raises ConfigError where the study or the folder cannot be used.
    """
    share = part_of(part) if part else None
    if not (scheduler or executor):
        prepare()
    with Console(stderr=True).status("checking the configs"):
        study = read(path)
    folder = Path(folder or Path("runs") / study.name)
    with ExitStack() as stack:
        stack.enter_context(claimed(folder, TAKEN, alone=share is None))
        if scheduler:
            executor = stack.enter_context(_connected(scheduler)).get_executor()
        return Sweep(study, folder, share).run(processes, executor)


def part_of(text: str) -> tuple[int, int]:
    """Return (3, 20) for the part 3/20; ConfigError for another text."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    part, count = map(int, found.groups()) if found else (0, 0)
    if not 1 <= part <= count:
        raise ConfigError(f"--part {text}: must be one of 1/N to N/N, such as 3/20, the third of 20 parts")
    return part, count


def split(seconds: dict[str, float], count: int) -> list[set[str]]:
    """Return ``count`` sets of the names of runs with about equal sums of their estimated ``seconds``.

    Every command that reads the same study finds the same sets: the longest runs first, each into the shortest set.
    """
    parts: list[set[str]] = [set() for _ in range(count)]
    sums = [0.0] * count
    for name in sorted(seconds, key=lambda each: (-seconds[each], each)):
        shortest = sums.index(min(sums))
        parts[shortest].add(name)
        sums[shortest] += seconds[name] + START_SECONDS
    return parts


class Sweep:
    """The known rows of a study, kept in ``folder``; at first the rows of refused configs and of kept runs.

    ``part``: (3, 20) makes the runs of the third of 20 parts; None makes all.
    """

    def __init__(self, study: Study, folder: Path, part: tuple[int, int] | None = None):
        self.study, self.folder = study, folder
        self.store = Store(folder / "runs")
        self.cases = {case.name: case for case in reversed(study.cases)}
        self.known: dict[str, Row] = {}
        self._part = part
        self._read_kept()

    def _read_kept(self, failed: bool = False) -> None:
        """Read the rows of all runs that have ended, with those that ``failed`` on request."""
        for name, case in self.cases.items():
            if name in self.known:
                continue
            if case.config is None:
                self.known[name] = row(self.study, case, None, case.refusal or "")
            elif kept := self.store.kept(name, case.config, failed):
                self.known[name] = row(self.study, case, *kept)

    @property
    def rows(self) -> list[Row]:
        """Rows of the known cases in their order; cases of equal configs share one run."""
        return [replace(self.known[case.name], case=case) for case in self.study.cases if case.name in self.known]

    def run(self, processes: int, executor: Executor | None) -> list[Row]:
        """Run the missing cases, or those of the part; print the rows as runs end. Return and write all rows."""
        study, count = self.study, len(self.study.cases)
        missing = {case.name: case for case in study.cases if case.name not in self.known}
        print(f"{count} runs, {count - len(missing)} of them known", flush=True)
        refused = Counter(case.refusal for case in study.cases if case.refusal)
        for reason, times in refused.most_common(MOST_REASONS):
            print(f"refused, {times} of {count}: {reason}")
        if len(refused) > MOST_REASONS:
            print(f"further reasons: {len(refused) - MOST_REASONS}, in {TABLE}")
        if self._part:
            self._run_part(missing, processes, executor)
            return self.rows
        try:
            if missing:
                self._run(missing, processes, executor)
        finally:
            write(study, self.rows, self.folder)
        self._conclude()
        return self.rows

    def _run_part(self, missing: dict[str, Case], processes: int, executor: Executor | None) -> None:
        """Run the cases of the part; write all rows if the runs of the other parts have ended."""
        part, parts = self._part or (1, 1)
        seconds = {name: case.seconds for name, case in self.cases.items() if case.config is not None}
        share = split(seconds, parts)[part - 1]
        own = {name: case for name, case in missing.items() if name in share}
        print(f"part {part} of {parts}: {len(share)} runs, {len(share) - len(own)} of them known", flush=True)
        if own:
            self._run(own, processes, executor)
        self._read_kept(failed=True)
        left = len(self.cases) - len(self.known)
        if left:
            print(f"{left} runs of other parts are missing: the part that ends last writes {self.folder / TABLE}")
            return
        try:
            with held(self.folder):
                write(self.study, self.rows, self.folder)
                self._conclude()
        except Timeout:
            print(f"another command writes {self.folder / TABLE}")

    def _conclude(self) -> None:
        """Draw the picture, and print the conclusion and the paths of the files."""
        drawn = plot(self.study, self.rows, self.folder / PICTURE)
        print(f"\n{conclusion(self.study, self.rows)}\n")
        for name in (TABLE, COSTS, ARRAYS, *([PICTURE] if drawn else [])):
            print(self.folder / name)

    def _run(self, missing: dict[str, Case], processes: int, executor: Executor | None) -> None:
        study, error = self.study, self.study.error
        configs = {name: case.config for name, case in missing.items() if case.config is not None}
        source = on_executor(configs, self.store, executor) if executor else None
        engine = Engine(self.store, processes, {name: case.seconds for name, case in missing.items()})
        with engine, closing(engine.outcomes(configs, source=source)) as outcomes:
            for count, (name, result, message) in enumerate(outcomes, 1):
                found = self.known[name] = row(study, self.cases[name], result, message)
                values = ", ".join(f"{key.rpartition('.')[2]} = {value}" for key, value in found.case.values.items())
                number = found.numbers[error]
                text = f"{error} {number:.2e}" if number is not None else found.message or found.status
                left = f"  ({engine.seconds_left:.0f} s left)" if count < len(missing) else ""
                engine.say(f"{count}/{len(missing)}  {values}: {text}{left}")
                if not self._part:
                    write(study, self.rows, self.folder)


def conclusion(study: Study, rows: list[Row]) -> str:
    """Return the text below the rows: how many ended how, the orders, and the cheapest run within the bound.

    The cheapest run has the shortest loop.
    """
    states = [each.status for each in rows]
    counts = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
    lines = [f"{len(rows)} runs: {counts}"]
    powers = [(key, f"{power:.2f}", str(count)) for key, (power, count) in orders(study, rows).items()]
    if powers:
        lines += ["", format_table(("key", f"{study.error} ~ key^", "groups of runs"), powers), ""]
    ended = [each for each in rows if each.status == "done" and each.numbers[study.error] is not None]
    ended = [each for each in ended if study.bound is None or each.numbers[study.error] <= study.bound]
    best = min(ended, key=lambda each: each.seconds or np.inf, default=None)
    within = "" if study.bound is None else f" with {study.error} <= {study.bound:g}"
    if best is None:
        return "\n".join([*lines, f"no run{within}"])
    setting = ", ".join(f"{key} = {value}" for key, value in best.case.values.items())
    cost = f"{best.numbers[study.error]:.2e} in {best.seconds:.3g} s, {best.steps} steps"
    return "\n".join([*lines, f"cheapest run{within}: {setting}: {cost}"])


def on_executor(configs: dict[str, dict[str, Any]], store: Store, executor: Executor) -> Outcomes:
    """Yield (name, ``Result``, message) of runs as they end on the workers of an ``executor``.

    ``configs`` (name -> config). A worker needs tisph, of the same code, and nothing else: the config is sent to it,
    and the files of the run are sent back.
    """
    code = fingerprint()
    futures = [executor.submit(run_on_worker, name, config, code) for name, config in configs.items()]
    try:
        for future in as_completed(futures):
            name, files, message = future.result()
            yield name, store.keep(name, configs[name], files, message), message
    finally:
        for future in futures:
            future.cancel()


def run_on_worker(name: str, config: dict[str, Any], code: str) -> tuple[str, dict[str, bytes], str]:
    """Run a config in an empty folder of a worker; return its name, its files by name, and its message."""
    if fingerprint() != code:
        raise ConfigError("a worker has another version of tisph than this command")
    multiprocessing.current_process().daemon = False  # Dask makes it a daemon, which may start no process
    with tempfile.TemporaryDirectory(prefix="tisph-sweep-") as scratch:
        path, folder = Path(scratch) / f"{name}.yaml", Path(scratch) / name
        path.write_text(config_text(name, config), encoding="utf-8")
        _, message = run_config(path, folder)
        sent = [file for file in folder.glob("*") if file.is_file() and file.name not in NOT_SENT]
        return name, {file.name: file.read_bytes() for file in sent}, message


def _imported() -> Any:
    try:
        import distributed
    except ImportError:
        raise ConfigError("--scheduler: needs Dask: pip install '.[dask]' in a clone") from None
    return distributed


def _connected(address: str) -> Any:
    """Return a client of the Dask scheduler at ``address``, a context."""
    distributed = _imported()
    try:
        return distributed.Client(address, timeout="10s")
    except (OSError, ValueError, TimeoutError) as error:
        raise ConfigError(f"--scheduler {address}: cannot be reached: {error}") from None
