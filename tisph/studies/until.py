"""``tisph run --until NUMBER=GOAL``: the cheapest run whose number has an error bar inside the goal.

A chain of runs, from the coarsest that ``tisph check`` calls resolved, each finer by a factor of 2^(1/2); spacings at
bodies, walls and places are scaled with it, and steps with it (``schemes.coarsen_steps``). All runs are kept in a
folder of the results, and read from there by the same command after an interruption.

Three runs of spacings h_1 > h_2 > h_3 with numbers n_i show an order p: n_i = n + C h_i^p. The bar of the finest run is

    bar^2 = (SAFETY C h_3^q)^2 + time^2 + scatter^2 + steadiness^2 + ends^2,    q = p, from 1.5 to 4.    (1)

* time: the change of the number by shorter steps in the coarsest run, scaled with h^3 at most;
* scatter: twice the standard error of the number, where it scatters from step to step or from time to time;
* steadiness: the change of a number in a flow that is not steady yet, in the time by which its steadiness is judged;
* ends: the change of the number in the coarsest run, where lengths of the geometry are other ones (``--vary``).

Where p is outside 1.5 to 6, or the numbers go up and down, the first term of (1) is the least that is safe. A number
with p < 1.5 has the bar of p, which is 0.1 at least; this is also that of numbers that do not converge. Numbers that go
up and down, or with p > 6, have SAFETY times |n_2 - n_3|, or what |n_1 - n_2| leaves at h_3 by the order of the
scheme. With four runs n, C and p are fitted by least squares, with weights 1/h; with an order in the range the bar is
SAFETY C h^q + 2 sigma if that is smaller, sigma being the standard deviation of the residuals. A number without an
order in two successive runs, whose bar is outside the goal, is refused.

With a known order the spacing that the goal needs is known: runs in between are skipped.

Sources: P. J. Roache, J. Fluids Eng. 116 (1994) 405-413; L. Eca and M. Hoekstra, J. Comput. Phys. 262 (2014) 104-130,
for the fit.
"""

import json
import math
import re
import shutil
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from rich.console import Console

from tisph import scenes, schemes
from tisph.config.fields import nearest
from tisph.config.goals import FIELDS, MEAN, Goal, goals
from tisph.config.loader import loaded
from tisph.config.schema import Config
from tisph.errors import ConfigError, TisphError
from tisph.folder import LOCK, Folder, replaced
from tisph.measures.steadiness import Followed, steadiness
from tisph.report.chain import draw
from tisph.results import open_run
from tisph.rheometry.viscometers import batch_means
from tisph.schemes._forecast import forecast
from tisph.studies import error_estimate
from tisph.studies.processes import Result
from tisph.studies.store import Store, claimed
from tisph.text_table import format_table

RUNS = "chain"
"""Folder of the runs of the chain, in the folder of the results."""

FINER = 2.0**0.5
"""Ratio of the spacings of successive runs."""

LEAST, MOST = 2.0**0.25, 2.0**1.5
"""Least and largest ratio of spacings where runs are skipped. Differences of closer runs are scatter; farther away the
observed order may be another one."""

LEAST_ACROSS = 10
"""Least number of particles across in a run of the chain: operators of order 4 reach over five rows."""

ORDERS = 1.5, 6.0
"""Least and largest order that counts as observed."""

HIGHEST = 4.0
"""Largest order that is extrapolated with: that of the operators. A larger one is chance."""

SAFETY = 1.5
"""Factor of the extrapolated error. ``tisph verify bars`` tests it."""

MARGIN = 0.9
"""Part of the goal that the bar of the next run is aimed at."""

TIME_ORDER = 3.0
"""Order of the schemes in time."""

SHORTER = 0.1
"""Tolerance of the run with shorter steps, over that of the coarsest run."""

STANDARD_ERRORS = 2.0
"""Standard errors in the part of scatter: 95 of 100 values of a normal distribution are inside."""

LASTING = "steadiness", "ends"
"""Parts of a bar that finer runs do not change."""

ROUNDING = {"f64": 1e-12, "f32": 1e-5}
"""Rounding error of a number over its size, by precision: sums over a thousand particles and a thousand steps."""

MOST_RUNS = 12

UNITS = {"s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0}


@dataclass(frozen=True)
class Point:
    """A run of the chain: its number of particles ``across``, ``spacing``, cost in ``seconds``, and name of its folder.

    ``values``, ``scatter`` and ``steadiness`` are by name of a number; a norm of the error without an exact solution
    has no value. ``remark``: why its last sample is not resolved, or empty.
    """

    across: int
    spacing: float
    seconds: float
    folder: str
    values: Mapping[str, float]
    scatter: Mapping[str, float] = field(default_factory=dict)
    steadiness: Mapping[str, float] = field(default_factory=dict)
    remark: str = ""


class Source(Protocol):
    """What a chain needs: runs by the ratio of their spacing to that of the config, and their numbers."""

    rounding: float

    @property
    def coarsest(self) -> float:
        """Spacing of the first run, over that of the config."""

    @property
    def orders(self) -> tuple[float, float]:
        """Least and largest expected order."""

    @property
    def spent(self) -> float:
        """Cost of the runs so far in this command [s]."""

    def run(self, factor: float) -> Point:
        """Make a run, or read it where it is kept. TisphError where it is impossible, or does not end."""

    def time_errors(self) -> dict[str, float]:
        """Return name -> change of the number of the coarsest run with shorter steps."""

    def end_errors(self) -> dict[str, float]:
        """Return name -> change of the number of the coarsest run in another geometry; empty without one."""

    def seconds(self, factor: float) -> float:
        """Return the expected cost of a run; 0 where it is kept."""

    def norms(self, name: str, points: Sequence[Point]) -> list[float]:
        """Return the norms of the differences 1-2, 2-3 and 1-3 of the velocities of three runs."""


@dataclass(frozen=True)
class Bar:
    """A number of the finest run: its ``value`` and the ``parts`` of its error bar.

    ``order``: observed order, None without three runs. ``doubt``: why the order is none to rely on, or empty.
    """

    value: float
    parts: Mapping[str, float]
    order: float | None = None
    doubt: str = ""

    @property
    def size(self) -> float:
        """Half width of the bar."""
        return math.hypot(*self.parts.values())


def extrapolated(
    spacings: Sequence[float], norms: Sequence[float], monotone: bool, rounding: float, expected: float
) -> tuple[float, float | None, str]:
    """Return the part ``spacing`` of equation (1), the order, and the ``doubt`` of a ``Bar``.

    ``norms``: of the differences 1-2, 2-3 and 1-3 of three runs. Differences below ``rounding`` are none. ``expected``:
    order of the scheme.
    """
    if max(norms) <= rounding:
        return rounding, None, ""
    finest, coarsest = spacings[1] / spacings[2], spacings[0] / spacings[1]
    least = SAFETY * max(norms[1], norms[0] / (coarsest**expected - 1.0) / finest**expected)
    if not monotone:
        return least, None, "it goes up and down from run to run"
    if norms[1] <= rounding:
        return least, None, ""
    lowest = SAFETY * max(norms[:2]) / (finest ** error_estimate.ORDERS[0] - 1.0)
    if norms[0] <= norms[1]:
        return lowest, None, "it does not converge: the finer two runs differ no less than the coarser two"
    h = np.asarray(spacings)
    observed, _, model = error_estimate.fitted(h, np.asarray(norms))
    order = min(observed, HIGHEST)
    scale, _ = error_estimate.scale(h, np.asarray(norms), order, model)
    error = SAFETY * scale * (h[2] / h[0]) ** order
    if ORDERS[0] <= observed <= ORDERS[1]:
        return error, observed, ""
    doubt = f"order {observed:.2g} where {ORDERS[0]:g} to {ORDERS[1]:g} is to be expected"
    return error if observed < ORDERS[0] else max(least, error), observed, doubt


def fitted(spacings: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Return the part ``spacing`` and the order of the least-squares fit of n + C h^p to four or more runs."""
    from scipy.optimize import minimize_scalar

    h, numbers = np.asarray(spacings) / spacings[-1], np.asarray(values)
    weights = np.sqrt(1.0 / h)

    def solved(order: float) -> tuple[float, np.ndarray]:
        """Return C and the residuals."""
        matrix = np.stack([np.ones_like(h), h**order], axis=1)
        found = np.linalg.lstsq(weights[:, None] * matrix, weights * numbers, rcond=None)[0]
        return float(found[1]), weights * (matrix @ found - numbers)

    def misfit(order: float) -> float:
        return float(np.sum(solved(order)[1] ** 2))

    order = float(minimize_scalar(misfit, bounds=error_estimate.ORDERS, options={"xatol": 1e-6}).x)
    scale, residuals = solved(min(max(order, ORDERS[0]), HIGHEST))
    deviation = math.sqrt(float(np.sum(residuals**2)) / (len(h) - 3) / float(np.mean(weights**2)))
    return SAFETY * abs(scale) + STANDARD_ERRORS * deviation, order


@dataclass
class Chain:
    """Runs of ``source``, from coarse to fine, until each of the ``goals`` is reached or refused.

    ``at_most``: largest cost [s] of all runs of this command. ``say`` prints a line about the way.
    """

    source: Source
    goals: Sequence[Goal]
    at_most: float = math.inf
    say: Callable[[str], None] = print
    points: list[Point] = field(default_factory=list)
    in_time: dict[str, float] = field(default_factory=dict)
    at_ends: dict[str, float] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    stopped: str = ""
    doubts: dict[str, int] = field(default_factory=dict)

    def run(self) -> None:
        """Make the runs; afterwards ``entries`` tells of the finest one."""
        factor = self.source.coarsest
        while len(self.points) < MOST_RUNS:
            self.say(self._outlook(factor))
            expected = self.source.seconds(factor)
            if expected and self.source.spent + expected > self.at_most:
                self.stopped = f"the next run costs about {_time(expected)}, with the runs so far more than --at-most"
                return
            try:
                self.points.append(self.source.run(factor))
                if len(self.points) == 1:
                    self.in_time = self.source.time_errors()
                    self.at_ends = self.source.end_errors()
            except TisphError as error:
                self.stopped = str(error)
                return
            if self._judged():
                return
            factor *= self._ratio()
        self.stopped = f"no bar inside the goal in {MOST_RUNS} runs"

    def bar(self, goal: Goal) -> Bar:
        """Return the bar of a number of the finest run, from the last three."""
        last = self.points[-3:]
        end, name = last[-1], goal.name
        value = end.values.get(name)
        if value is not None and name in FIELDS:
            return Bar(value, {"error": value})
        if len(last) < 3:
            found = self._of_two(last, name) if len(last) == 2 else math.inf
            return Bar(math.nan if value is None else value, {"spacing": found}, doubt="fewer than three runs")
        spacings = [each.spacing for each in last]
        if value is None:
            norms, monotone, rounding = self.source.norms(name, last), True, self.source.rounding
        else:
            a, b, c = (each.values[name] for each in last)
            norms, monotone = [abs(a - b), abs(b - c), abs(a - c)], (a - b) * (b - c) >= 0.0
            rounding = self.source.rounding * max(map(abs, (a, b, c)))
        error, order, doubt = extrapolated(spacings, norms, monotone, rounding, self._expected)
        if doubt and value is not None and len(self.points) > 3:
            four = self.points[-4:]
            wide, slope = fitted([each.spacing for each in four], [each.values[name] for each in four])
            if ORDERS[0] <= slope <= ORDERS[1] and wide < error:
                error, order, doubt = wide, slope, ""
        power = 2.0 if order is None else min(max(order, ORDERS[0]), TIME_ORDER)
        parts = {
            "spacing": error,
            "time": self.in_time.get(name, 0.0) * (end.spacing / self.points[0].spacing) ** power,
            "scatter": STANDARD_ERRORS * end.scatter.get(name, 0.0),
            "steadiness": end.steadiness.get(name, 0.0),
            **({"ends": self.at_ends[name]} if name in self.at_ends else {}),
        }
        return Bar(math.hypot(*parts.values()) if value is None else value, parts, order, doubt)

    def _of_two(self, last: Sequence[Point], name: str) -> float:
        """Return the error of the finer of two runs with the least order."""
        if name not in last[0].values:
            return math.inf
        difference = abs(last[0].values[name] - last[1].values[name])
        return SAFETY * difference / ((last[0].spacing / last[1].spacing) ** self.source.orders[0] - 1.0)

    def reached(self, goal: Goal) -> bool:
        """Return whether the bar of a number is inside its goal."""
        bar = self.bar(goal)
        known = goal.name in FIELDS and goal.name in self.points[-1].values
        return (known or len(self.points) > 2) and bar.size <= goal.size(bar.value)

    def _judged(self) -> bool:
        """Return whether each goal is reached or refused."""
        for goal in self.goals:
            bar = self.bar(goal)
            self.refused.pop(goal.name, None)
            if len(self.points) < 3 or self.reached(goal):
                continue
            self.doubts[goal.name] = self.doubts.get(goal.name, 0) + 1 if bar.doubt else 0
            if goal.size(bar.value) < self.source.rounding * abs(bar.value):
                self.refused[goal.name] = "the goal is below the rounding error"
            elif self.doubts[goal.name] == 2:
                remark = self.points[-1].remark
                self.refused[goal.name] = f"{bar.doubt}{f'; the sample is not resolved: {remark}' if remark else ''}"
            elif lasting := [part for part in LASTING if bar.parts.get(part, 0.0) > goal.size(bar.value)]:
                why = [f"{part} alone is outside the goal, and finer runs do not change it" for part in lasting]
                self.refused[goal.name] = f"the part {'; the part '.join(why)}"
            elif goal.relative and bar.size > abs(bar.value) and len(self.points) > 3:
                self.refused[goal.name] = "it is zero within its bar: a percentage of it is no goal, give a number"
        return all(goal.name in self.refused or self.reached(goal) for goal in self.goals)

    def _ratio(self) -> float:
        """Return the spacing of the next run over that of the last one."""
        return 1.0 / FINER if len(self.points) < 3 else max(1.0 / MOST, min(1.0 / LEAST, self._needed()))

    def _needed(self) -> float:
        """Return the spacing that the goals need over that of the last run, 2^(-1/2) where an order is not known."""
        ratios = [1.0]
        for goal in self.goals:
            if goal.name in self.refused or self.reached(goal):
                continue
            bar = self.bar(goal)
            order = min(bar.order or self._expected, HIGHEST)
            known = len(self.points) == 2 or (bar.order is not None and not bar.doubt)
            wanted = MARGIN * goal.size(bar.value) / bar.size if known and bar.size else math.nan
            ratios.append(wanted ** (1.0 / order) if 0.0 < wanted < math.inf else 1.0 / FINER)
        return min(ratios)

    @property
    def _expected(self) -> float:
        return math.sqrt(math.prod(self.source.orders))

    def _outlook(self, factor: float) -> str:
        """Return a line about the next run, and about the run that will do."""
        cost = f"{'next' if self.points else 'first'} run: {_cost(self.source.seconds(factor))}"
        if len(self.points) < 2:
            return cost
        end, needed = self.points[-1], min(1.0, self._needed())
        kind = "the scheme's order" if len(self.points) == 2 else "the observed order"
        enough = self.source.coarsest * end.spacing / self.points[0].spacing * needed
        every = f"{end.across / needed:.0f} particles across, {_cost(self.source.seconds(enough))}"
        return f"{cost}; by {kind} the goal needs {every}"

    def entries(self) -> dict[str, Any]:
        """Return the contents of ``accuracy.json``: number -> value, bar, parts, goal, reached, reason and runs."""
        found = {}
        for goal in self.goals:
            if not self.points:
                found[goal.name] = {**_EMPTY, "asked": goal.asked, "reason": self.stopped}
                continue
            bar = self.bar(goal)
            reached = self.reached(goal)
            reason = bar.doubt if reached else self.refused.get(goal.name) or self.stopped
            found[goal.name] = {
                "value": _plain(bar.value),
                "bar": _plain(bar.size),
                "parts": {name: _plain(part) for name, part in bar.parts.items()},
                "goal": _plain(goal.size(bar.value)),
                "asked": goal.asked,
                "order": bar.order,
                "reached": reached,
                "reason": reason or None,
                "runs": [
                    {
                        "particles_across": each.across,
                        "spacing": each.spacing,
                        "value": each.values.get(goal.name),
                        "seconds": each.seconds,
                        "folder": f"{RUNS}/{each.folder}",
                    }
                    for each in self.points
                ],
            }
        return found


_EMPTY: dict[str, Any] = {
    "value": None, "bar": None, "parts": {}, "goal": None, "order": None, "reached": False, "runs": [],
}  # fmt: skip


def _plain(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _time(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"


def _cost(seconds: float) -> str:
    return f"about {_time(seconds)}" if seconds else "made before"


class Runs:
    """The ``Source`` of real runs of a ``config``, kept in the folder ``root``.

    ``moved``: values by key of the geometry whose ends tell the error of the distance of ends.
    """

    def __init__(self, config: Config, root: Path, wanted: Sequence[Goal], moved: Mapping[str, float]):
        self.config, self.wanted, self.moved = config, wanted, moved
        self.rounding = ROUNDING[config.discretisation.precision]
        root.mkdir(parents=True, exist_ok=True)
        self.store = Store(root)
        self.results: dict[str, Result] = {}
        self.began = time.perf_counter()
        self.measured: list[tuple[float, float, float]] = []

    @property
    def spent(self) -> float:
        """Time since the start [s]."""
        return time.perf_counter() - self.began

    @cached_property
    def orders(self) -> tuple[float, float]:
        """Least and largest expected order."""
        return schemes.orders(schemes.resolve(self.config)[0])

    @cached_property
    def coarsest(self) -> float:
        """Spacing of the coarsest run without more warnings than that of the config, over the spacing of the config."""
        usual, factor = len(forecast(self.config)[1]), 1.0
        while True:
            try:
                wider = self._config(factor * FINER)
                if len(forecast(wider)[1]) > usual or wider.particles_across < LEAST_ACROSS:
                    return factor
            except ConfigError:
                return factor
            factor *= FINER

    def _config(self, factor: float) -> Config:
        return error_estimate.validated(self.config, error_estimate.respaced(self.config, factor))

    def run(self, factor: float) -> Point:
        """Return the run with ``factor`` times the spacing of the config, new or kept."""
        config = self._config(factor)
        name = _name(config)
        result = self._result(name, config)
        if self.config.discretisation.refine == "auto":  # later runs have the places of this one
            places = open_run(result.folder).config
            scaled = error_estimate.validated(places, error_estimate.respaced(places, 1.0 / factor))
            self.config = scaled.model_copy(update={"name": self.config.name})
        cost, sample = result.summary["cost"], result.last
        self.measured.append((factor, forecast(self._config(factor))[0]["run_time"], cost["wall_loop_s"]))
        readings = {goal.name: self._reading(goal.name, result) for goal in self.wanted}
        return Point(
            across=config.particles_across,
            spacing=config.spacing,
            seconds=cost["wall_total_s"],
            folder=name,
            values={key: value for key, (value, _, _) in readings.items() if value is not None},
            scatter={key: scatter for key, (_, scatter, _) in readings.items()},
            steadiness={key: change for key, (_, _, change) in readings.items()},
            remark="" if sample["resolved"] else sample["reason"],
        )

    def _result(self, name: str, config: Config) -> Result:
        with Console(stderr=True).status(f"running {name}"):
            result, message = self.store.outcome(name, _data(config))
        if message:
            raise TisphError(f"the run {name} did not finish: {message}")
        self.results[name] = result
        return result

    def _reading(self, name: str, result: Result) -> tuple[float | None, float, float]:
        """Return value, standard error and change of a number; no value for a norm without an exact solution."""
        sample = result.last
        if mean := MEAN.fullmatch(name):
            history = open_run(result.folder).history
            late = history["t"] >= 0.75 * history["t"][-1] + 0.25 * history["t"][0]
            return *batch_means(np.asarray(history[mean[1]][late], float)), 0.0
        value = sample.get(name)
        if value is None and name in FIELDS:
            return None, 0.0, 0.0
        if isinstance(value, bool) or not isinstance(value, int | float):
            known = [key for key, each in sample.items() if type(each) is float and not key.endswith("_exact")]
            text = (
                "has no value in the last sample"
                if name in sample
                else f"is no number of a sample{nearest(name, known)}"
            )
            raise ConfigError(f"--until {name}: {text}; there are {', '.join(known)}")
        return value, scatter_of(name, sample), abs(value) * change_of(name, result)

    def time_errors(self) -> dict[str, float]:
        """Return name -> difference of the coarsest run from the same with shorter steps, as an error."""
        coarse = self._config(self.coarsest)
        if coarse.time.cfl != "auto":
            shorter, ratio = {"time.cfl": 0.5 * coarse.time.cfl}, 0.5
        elif coarse.time.tolerance != "auto":
            shorter = {"time.tolerance": max(SHORTER * coarse.time.tolerance, 1e-10)}
            ratio = (shorter["time.tolerance"] / coarse.time.tolerance) ** 0.25
            if getattr(coarse.scheme, "error_ratio", None):  # balanced tolerances are then shorter by the same factor
                shorter["scheme.error_ratio"] = coarse.scheme.error_ratio * ratio**TIME_ORDER
        else:
            shorter, ratio = {"scheme.largest_courant": 0.5 * coarse.scheme.largest_courant}, 0.5
        changes = self._changes("shorter_steps", coarse, shorter)
        return {name: change / (1.0 - ratio**TIME_ORDER) for name, change in changes.items()}

    def end_errors(self) -> dict[str, float]:
        """Return name -> difference of the coarsest run from the same in the geometry ``moved``."""
        return self._changes("other_ends", self._config(self.coarsest), self.moved) if self.moved else {}

    def _changes(self, name: str, coarse: Config, values: Mapping[str, float]) -> dict[str, float]:
        """Return name of a goal -> absolute change of the number of the ``coarse`` run by other ``values`` of keys."""
        plain = self.results[_name(coarse)]
        other = self._result(f"{_name(coarse)}_{name}", loaded(coarse, values))
        found = {}
        for goal in self.wanted:
            if (change := self._apart(goal.name, plain, other)) is not None:
                found[goal.name] = change
        return found

    def _apart(self, name: str, one: Result, other: Result) -> float | None:
        """Return the difference of a number between two runs; None for a norm without an exact solution."""
        first, second = (self._reading(name, each)[0] for each in (one, other))
        return None if first is None or second is None else abs(first - second)

    def seconds(self, factor: float) -> float:
        """Return the expected cost of a run by the forecast and the cost of the last run; 0 where it is kept."""
        try:
            config = self._config(factor)
        except ConfigError:
            return 0.0  # the run itself says why it is impossible
        if self.store.kept(_name(config), _data(config)):
            return 0.0
        numbers = forecast(config)[0]
        if not self.measured:
            return numbers["run_time"] + START
        _, expected, loop = self.measured[-1]
        return loop * numbers["run_time"] / expected + START

    def norms(self, name: str, points: Sequence[Point]) -> list[float]:
        """Return the norms of the differences of the velocities, at the particles of the coarsest of three runs."""
        compared = [scenes.of(open_run(self.results[each.folder].folder).config) for each in points]
        snapshots = [list(open_run(self.results[each.folder].folder).snapshots())[-1] for each in points]
        return error_estimate.field_norms(compared, snapshots, None if name == "l2" else np.inf)["velocity"]


def _name(config: Config) -> str:
    return f"across_{config.particles_across}"


def _data(config: Config) -> dict[str, Any]:
    data = config.resolved()
    del data["name"]
    return {**data, "output": {**data["output"], "video": None}}


START = 4.0
"""Approximate time [s] of a run apart from its steps."""


def change_of(name: str, result: Result) -> float:
    """Return the relative change of a number over the slowest time of a flow that is not steady yet.

    It is that of its own history where there is one, else the largest change of all that the sample states.
    """
    sample = result.last
    if sample.get("steady", True):
        return 0.0
    run, column = open_run(result.folder), name.replace("_coefficient", "")
    if column not in (run.history.dtype.names or ()):
        return sample.get("steady_change") or 0.0
    times, values = (np.asarray(run.history[key], float) for key in ("t", column))
    own = Followed(times, values[:, None], {column: np.nan_to_num(np.abs(values)).max() or 1.0})
    return steadiness(scenes.of(run.config), sample["t"], own).change or 0.0


def scatter_of(name: str, sample: Mapping[str, Any]) -> float:
    """Return the scatter of a load or of its coefficient, or of the pressure drop; 0 for other numbers."""
    kind, *rest = name.replace("_coefficient", "").split("_", 1)
    load = "_".join([kind, *rest])
    found = sample.get("_".join([kind, "scatter", *rest]), sample.get(f"{name}_scatter")) or 0.0
    return found * abs(sample[name] / sample[load]) if load != name and sample.get(load) else found


def limit(text: str | None) -> float:
    """Return a time in seconds; ``text`` is such as 10min, 90s, 2h. ConfigError for another text."""
    if text is None:
        return math.inf
    parts = re.fullmatch(r"([\d.]+) ?(s|sec|min|h)", text.strip())
    try:
        seconds = float(parts[1]) * UNITS[parts[2]] if parts else 0.0
    except ValueError:
        seconds = 0.0
    if not seconds:
        raise ConfigError(f"--at-most {text}: must be a time such as 90s, 10min or 2h")
    return seconds


NO_NUMBERS = {"t", "t_star", "resolved", "reason", "step", "steady", "steady_reason", "zero_within_error"}
"""Names in a sample that are no numbers of the flow."""


def _require_names(config: Config, wanted: Sequence[Goal]) -> None:
    """Raise ConfigError for a goal whose name no sample and no history of the ``config`` has."""
    from tisph.studies.sweep import sample_names  # it imports Taichi and matplotlib

    known = (sample_names(config) | set(FIELDS)) - NO_NUMBERS
    columns = {f"mean({name})" for name in scenes.of(config).time_series(**config.time_series).columns}
    for each in wanted:
        if each.name not in known | columns:
            text = f"no number of a sample, and no mean of the history{nearest(each.name, sorted(known | columns))}"
            raise ConfigError(f"--until {each.name}: {text}; there are {', '.join(sorted(known))}")


def _moved(config: Config, vary: Mapping[str, Any]) -> dict[str, float]:
    """Return values by key of the geometry; ``vary`` is key -> factor. ConfigError for other keys and factors."""
    values, geometry = {}, config.resolved()["geometry"]
    lengths = {f"geometry.{name}": value for name, value in geometry.items() if type(value) in (int, float)}
    for key, given in vary.items():
        if key not in lengths:
            raise ConfigError(f"--vary {key}: must be a length of the geometry: {', '.join(lengths)}")
        try:
            factor = float(given)
        except ValueError:
            factor = math.nan
        if not 0.0 < factor < math.inf or factor == 1.0:
            raise ConfigError(f"--vary {key}={given}: must be a factor, such as 1.25")
        values[key] = factor * lengths[key]
    try:
        loaded(config, values)
    except ConfigError as error:
        raise ConfigError(f"--vary: {error}") from None
    return values


HEADER = "number", "value", "bar", "goal", "reached", "spacing", "time", "scatter", "steadiness", "ends"


def table(found: Mapping[str, Any]) -> str:
    """Return the contents of ``accuracy.json`` as a table, with the reasons below it."""
    header = HEADER if any("ends" in entry["parts"] for entry in found.values()) else HEADER[:-1]
    rows, reasons = [], []
    for name, entry in found.items():
        parts = {"spacing": entry["parts"].get("error"), **entry["parts"]}
        cells = [entry["value"], entry["bar"], entry["goal"], *(parts.get(part) for part in header[5:])]
        texts = ["none" if each is None else f"{each:.{8 if k == 0 else 2}g}" for k, each in enumerate(cells)]
        rows.append((name, *texts[:3], "yes" if entry["reached"] else "no", *texts[3:]))
        if entry["reason"]:
            reasons.append(f"{name}: {'note: ' if entry['reached'] else 'not reached: '}{entry['reason']}")
    return "\n".join([format_table(header, rows), *reasons])


def run(
    config: Config,
    folder: Path,
    asked: Mapping[str, Any] | None = None,
    at_most: str | None = None,
    overwrite: bool = False,
    vary: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Run the chain of a ``config`` in ``folder``; return the contents of ``accuracy.json``.

    ``asked``: name -> goal, in place of the config's ``accuracy``. ``vary``: key of the geometry -> factor, for the
    part ``ends`` of the bars. The files of the finest run are copied into ``folder``. Raises ConfigError for a bad goal
    or factor, and where the folder has other results, without ``overwrite``.
    """
    try:
        wanted = goals(asked or config.accuracy or {})
    except ValueError as error:
        raise ConfigError(f"{'--until' if asked else 'accuracy'}: {error}") from None
    most = limit(at_most)
    _require_names(config, wanted)
    plain = config.model_copy(update={"accuracy": None})
    others = folder.is_dir() and not (folder / RUNS).is_dir() and any(folder.iterdir())
    if others and not overwrite:
        raise ConfigError(f"--out {folder}: the folder is not empty; choose another one, or add --overwrite")
    moved = _moved(plain, vary or {})
    with claimed(folder, "another run is writing there"):
        source = Runs(plain, folder / RUNS, wanted, moved)
        chain = Chain(source, wanted, most, lambda text: print(text, file=sys.stderr, flush=True))
        chain.run()
        found = chain.entries()
        files = Folder(folder)
        for path in files.files():
            path.unlink(missing_ok=True)
        if chain.points:
            for path in (folder / RUNS / chain.points[-1].folder).iterdir():
                if path.is_file() and path.name != LOCK:
                    shutil.copy2(path, folder / path.name)
            draw(found, config, files.accuracy_picture)
        with replaced(files.accuracy) as new:
            new.write_text(json.dumps(found, indent=2), encoding="utf-8")
    return found
