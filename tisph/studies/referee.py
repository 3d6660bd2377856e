"""``tisph compare`` of a flow without an exact solution, with a reference made by the chain of ``until.py``.

The data are fields, velocities and pressures at points and times, or numbers of samples at times. Each is a
``Quantity``; all its values together are compared with those of a run at the same points and times. With the norm
|a| = (sum a_i^2)^(1/2), the data d and the reference r, the difference is

    D^2 = (|d - r|^2 - |s|^2) / |d|^2                                                                            (1)

where s is the scatter of d - r around the mean of its nearest neighbours, an error of the data that is not systematic.
The chain refines until its bar B of r, over |d|, is a tenth of D, but a third of ``DETAIL`` at the least. Both mean
squares of n values have a standard error of s^2 (2/n)^(1/2): where nothing but scatter is left, D is uncertain by
N = 2^(1/2) s/n^(1/4). The verdict is

    differs     D is more than ``DETAIL``, and at least 3 (B^2 + N^2)^(1/2)
    agrees      D is at most ``DETAIL`` or (B^2 + N^2)^(1/2), and B is at most ``DETAIL``
    undecided   else: the reference is not good enough, or the data scatter too much

A change explains the data if d - r - sum c_j r_j has at most the part ``EXPLAINS`` of D. The r_j are derivatives of
the reference with respect to a factor of all values, to places along x and y, or to a key of the config, and c_j are
fitted. Derivatives with respect to keys are differences of two runs with the coarsest spacing of the chain. Changes
that leave the same but for the bar cannot be told apart.
"""

import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tisph import scenes
from tisph.assessment import alignment, columns, judge, readers
from tisph.config.fields import nearest
from tisph.config.goals import Goal
from tisph.config.loader import loaded
from tisph.config.schema import Config
from tisph.errors import ConfigError, TisphError
from tisph.folder import Folder, replaced
from tisph.measures.fits import interpolated
from tisph.results import open_run
from tisph.scenes._scene import Scene
from tisph.snapshot import Snapshot
from tisph.studies import until
from tisph.studies.processes import Result
from tisph.studies.store import claimed
from tisph.studies.sweep import sample_names

DETAIL = 1e-3
"""Difference of which nothing more is asked, if ``--bound`` does not say which one."""

SURE = 3.0
"""Difference over the bar from which on it is certain: no bar of ``tisph verify bars`` was too small by this factor."""

TENTH = 0.1
"""Bar over the difference that the chain aims at."""

EXPLAINS = 0.3
"""A change explains a difference if no more than this part of it remains, as in ``assessment/diagnosis.py``."""

MOST_POINTS, MOST_TIMES = 500, 20
"""Most points of a time, and most times, that are compared; of more data so many are chosen evenly."""

WALL = 0.25
"""Distance from a wall [spacings of the config] below which points are left out: there the velocity is given."""

STEP = 0.02
"""Relative change of a key for a derivative."""

KEYS = {
    "fluid.kinematic_viscosity": "viscosity",
    "fluid.dynamic_viscosity": "viscosity",
    "fluid.rheology.relaxation_time": "relaxation time",
    "drive.acceleration": "drive",
}
"""Key of a config -> name of what it sets, whose change may explain a difference."""


@dataclass
class Quantity:
    """Data (n, components) at ``places`` (n, axes), and the values of the ``reference`` there, once it is known.

    ``times``: of the data, NaN for the end of the run; ``samples``: numbers of the samples of these times, in a run.
    ``notes``: how the data were read, in words.
    """

    name: str
    data: np.ndarray
    places: np.ndarray
    times: np.ndarray
    notes: tuple[str, ...] = ()
    samples: tuple[int, ...] = ()
    reference: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def of(self, result: Result) -> np.ndarray:
        """Return the values (n, components) of a run."""
        raise NotImplementedError

    def reading(self, result: Result) -> tuple[float, float]:
        """Return scatter, and change in a flow that is not steady yet, of the values of a run over the size of data."""
        return 0.0, 0.0

    @property
    def size(self) -> float:
        """Norm of the data."""
        return float(np.linalg.norm(self.data))

    @property
    def scatter(self) -> float:
        """Norm of the scatter of d - r over that of the data."""
        near = 2 * self.places.shape[1] + (self.places.shape[1] == 2) * 2
        if len(self.data) < 2 * near:
            return 0.0
        from scipy.spatial import cKDTree  # a fifth of a second to import

        residual = self.data - self.reference
        nearest_ones = cKDTree(self.places).query(self.places, near + 1)[1][:, 1:]
        rough = residual - residual[nearest_ones].mean(axis=1)
        return float(np.linalg.norm(rough)) / math.sqrt(1.0 + 1.0 / near) / self.size

    @property
    def difference(self) -> float:
        """The difference D of equation (1)."""
        return math.sqrt(max((np.linalg.norm(self.data - self.reference) / self.size) ** 2 - self.scatter**2, 0.0))

    @property
    def words(self) -> str:
        """The difference in words, with its largest value and the place of it."""
        off = self.data - self.reference
        share = float(np.sum(off * self.reference) / max(np.sum(self.reference**2), 1e-300))
        along = abs(share) * np.linalg.norm(self.reference) >= math.sqrt(0.5) * np.linalg.norm(off)
        text = f"{100 * abs(share):.3g} % too {'large' if share > 0 else 'small'}, " if along else ""
        return f"{text}{self._place(int(np.argmax(np.linalg.norm(off, axis=1))))}".rstrip(", ")

    def _place(self, index: int) -> str:
        return ""


@dataclass
class Field(Quantity):
    """Components ``parts`` of a field at points, the ``places``, at one time; a pressure is known up to a constant."""

    parts: tuple[str, ...] = ()
    free: bool = False
    """Whether points in free bodies are still to be left out: a run says where these are."""

    def of(self, result: Result) -> np.ndarray:
        """Return the values (n, components) of a run."""
        if self.free:
            scene, snapshot = self._run(result)
            self.keep(_within(scene, scene.seen(snapshot).bodies, self.places, snapshot.t))
            self.free = False
        return self.at(result, self.places)

    def _run(self, result: Result) -> tuple[Scene, Snapshot]:
        run = open_run(result.folder)
        return scenes.of(run.config), list(run.snapshots())[self.samples[0]]

    def at(self, result: Result, points: np.ndarray) -> np.ndarray:
        """Return the values of a run at ``points`` (n, 2)."""
        scene, snapshot = self._run(result)
        positions = np.stack([snapshot.x, snapshot.y], axis=1).astype(float)
        values = np.stack([getattr(snapshot, part) for part in self.parts], axis=1).astype(float)
        found = interpolated(scene, positions, values, points)
        return found - found.mean(axis=0) if self.parts == ("pressure",) else found

    def keep(self, chosen: np.ndarray) -> None:
        """Leave out all points but the ``chosen`` ones."""
        self.data, self.places = self.data[chosen], self.places[chosen]
        if self.parts == ("pressure",):
            self.data = self.data - self.data.mean(axis=0)

    def _place(self, index: int) -> str:
        x, y = self.places[index]
        return f"the most at ({x:.4g}, {y:.4g})"


@dataclass
class Number(Quantity):
    """The number ``key`` of samples; the ``places`` are its times."""

    key: str = ""

    def of(self, result: Result) -> np.ndarray:
        """Return the values (n, 1) of a run."""
        values = [sample.get(self.key) for sample in self._samples(result)]
        if not all(isinstance(value, int | float) for value in values):
            raise TisphError(f"{self.key} has no value in a sample of the run {result.folder.name}")
        return np.array(values, float)[:, None]

    def reading(self, result: Result) -> tuple[float, float]:
        """Return scatter, and change in a flow that is not steady yet, of the values of a run over the size of data."""
        found = self._samples(result)
        scatter = math.hypot(*(until.scatter_of(self.key, sample) for sample in found))
        of_the_end = np.isnan(self.times).any()
        change = until.change_of(self.key, result) * abs(found[-1][self.key]) if of_the_end else 0.0
        return scatter / self.size, change / self.size

    def _samples(self, result: Result) -> list[Any]:
        return [result.summary["samples"][number] for number in self.samples]

    def _place(self, index: int) -> str:
        return f"the most at t = {self.times[index]:.4g}" if len(self.times) > 1 else ""


def quantities(config: Config, paths: Sequence[Path], question: judge.Question) -> list[Quantity]:
    """Return the quantities of the data in files ``paths``; ConfigError where there is nothing to compare."""
    known = sample_names(config) - until.NO_NUMBERS
    found: list[Quantity] = []
    for path in paths:
        own: list[Quantity] = []
        for frame in readers.frames(path, question.select):
            own += _numbers(frame, known, question, path)
        found += own or _fields(config, path, question, known)
    names, begin, end = [each.name for each in found], scenes.of(config).start_time, config.time.end
    for each in found:
        if names.count(each.name) > 1:
            raise ConfigError(f"{each.name}: stands in several data; compare one of them at a time")
        if not each.size:
            raise ConfigError(f"{each.name}: all values are 0: nothing can be compared")
        for t in each.times:
            if t > end * (1.0 + 1e-9) or t <= begin:
                raise ConfigError(f"--time {t:g}: is not within the run, from t = {begin:g} to time.end = {end:g}")
    return found


def sampled(config: Config, compared: Sequence[Quantity]) -> Config:
    """Return the config with samples at the times of the data, and an end at the last of them."""
    wanted = {float(config.time.end if np.isnan(t) else t) for each in compared for t in each.times}
    times = sorted(min(t, config.time.end) for t in wanted)
    for each in compared:
        each.samples = tuple(-1 if np.isnan(t) else int(np.argmin(np.abs(np.array(times) - t))) for t in each.times)
    return loaded(config, {"time.samples": times, "time.end": times[-1], "accuracy": None})


def _numbers(frame: Any, known: set[str], question: judge.Question, path: Path) -> Iterator[Number]:
    """Yield the numbers of a table: columns with the names of numbers of samples, and not 0 in all rows."""
    clock = columns.recognised("time", {name: name for name in frame.columns})
    listed = frame.columns[clock] if clock else np.array(question.times)
    for name, column in frame.columns.items():
        if name not in known:
            continue
        times = listed if len(listed) == len(column) else np.full(len(column), np.nan)
        if len(listed) != len(column) and len(column) > 1:
            raise ConfigError(f"{path}: has {len(column)} values of {name} without times; give a column t")
        chosen = np.isfinite(column) & ~(times <= 0.0)
        if chosen.any() and np.any(column[chosen]):
            some = np.flatnonzero(chosen)
            some = some[np.unique(np.linspace(0, len(some) - 1, MOST_TIMES).round().astype(int))]
            notes = (f"{len(some)} of {int(chosen.sum())} times are compared",) if len(some) < chosen.sum() else ()
            yield Number(name, column[some, None], times[some, None], times[some], notes, key=name)


def _fields(config: Config, path: Path, question: judge.Question, known: set[str]) -> list[Quantity]:
    """Return velocity and pressure of each time of a file."""
    scene: Any = scenes.of(config)
    try:
        found = list(judge.frames([path], question, scene))
    except ConfigError as error:
        if "no column is recognised" not in str(error):
            raise
        names = [name for frame in readers.frames(path, question.select) for name in frame.columns]
        near = next((text for name in names if (text := nearest(name, sorted(known))) and len(name) > 1), "")
        raise ConfigError(
            f"{error}; none is a number of a sample{near}; there are {', '.join(sorted(known))}"
        ) from None
    found = [found[index] for index in np.unique(np.linspace(0, len(found) - 1, MOST_TIMES).round().astype(int))]
    fixed = [body for body in scene.bodies if not body.free]
    axes = alignment.orientation(question.orientation) if question.orientation else alignment.ORIENTATIONS[0]
    made: list[Quantity] = []
    for _, frame, t in found:
        values = alignment.oriented(frame.columns, scene, axes, question.origin or (0.0, 0.0))
        if missing := [name for name in "xyu" if name not in values]:
            raise ConfigError(f"--columns: this flow needs {' and '.join(missing)}, too")
        parts = tuple(name for name in ("u", "v", "w") if name in values and (name != "w" or scene.axisymmetric))
        for name, each in (("velocity", parts), ("pressure", ("pressure",))):
            if set(each) <= values.keys():
                table = np.stack([values[part] for part in ("x", "y", *each)], axis=1)
                places, when = table[:, :2], np.array([t])
                quantity = Field(f"{name} at t = {t:g}", table[:, 2:], places, when, frame.notes, parts=each)
                quantity.free = scene.has_free_bodies
                inside = np.isfinite(table).all(axis=1) & _within(scene, fixed, quantity.places, t)
                if inside.sum() < alignment.LEAST:
                    text = f"{inside.sum()} of {len(inside)} points are in the fluid, {alignment.LEAST} are needed"
                    raise ConfigError(f"{path}: {text}; give --unit, --origin or --orientation")
                if not inside.all():
                    text = f"{int((~inside).sum())} points at walls or outside the fluid are left out"
                    quantity.notes = (*quantity.notes, text)
                some = np.random.default_rng(0).permutation(np.flatnonzero(inside))[:MOST_POINTS]
                quantity.keep(np.sort(some))
                made.append(quantity)
    return made


def _within(scene: Scene, bodies: Sequence[Any], points: np.ndarray, t: float) -> np.ndarray:
    """Return whether each of the ``points`` (n, 2) is in the box, and farther than ``WALL`` from ``bodies``."""
    low, size = np.asarray(scene.origin), np.asarray(scene.extent)
    wrapped = np.nan_to_num(np.where(scene.periodic, low + (points - low) % size, points))
    inside = ((wrapped >= low) & (wrapped <= low + size)).all(axis=1)
    for body in bodies:
        inside &= body.nearest(wrapped, t).distance >= WALL * scene.spacing
    return inside


@dataclass(frozen=True)
class Tenth(Goal):
    """A tenth of the difference of a ``quantity``, but a third of ``amount`` at the least."""

    quantity: Any = None

    def size(self, value: float) -> float:
        """Return the largest error over the size of the data."""
        return max(TENTH * self.quantity.difference, self.amount / SURE)


class Referee(until.Runs):
    """Runs of a chain, whose values are read at the points and times of ``compared``."""

    def __init__(self, config: Config, root: Path, wanted: Sequence[Tenth]):
        super().__init__(config, root, wanted, {})
        self.compared: Mapping[str, Quantity] = {goal.name: goal.quantity for goal in wanted}
        self.finest: until.Point
        self._values: dict[tuple[str, Path], np.ndarray] = {}

    def run(self, factor: float) -> until.Point:
        """Return the run with ``factor`` times the spacing of the config, and take it as the reference."""
        self.finest = super().run(factor)
        for each in self.compared.values():
            each.reference = self.values(each, self.results[self.finest.folder])
        return self.finest

    def values(self, quantity: Quantity, result: Result) -> np.ndarray:
        """Return the values of a run, computed once."""
        key = quantity.name, result.folder
        if key not in self._values:
            self._values[key] = quantity.of(result)
        return self._values[key]

    def _reading(self, name: str, result: Result) -> tuple[float | None, float, float]:
        quantity = self.compared[name]
        values = self.values(quantity, result)
        return float(values.sum()) / quantity.size if values.size == 1 else None, *quantity.reading(result)

    def _apart(self, name: str, one: Result, other: Result) -> float:
        quantity = self.compared[name]
        return float(np.linalg.norm(self.values(quantity, one) - self.values(quantity, other))) / quantity.size

    def norms(self, name: str, points: Sequence[until.Point]) -> list[float]:
        """Return the norms of the differences 1-2, 2-3 and 1-3 of three runs over that of the data."""
        a, b, c = (self.results[each.folder] for each in points)
        return [self._apart(name, a, b), self._apart(name, b, c), self._apart(name, a, c)]

    def changed(self, overrides: Mapping[str, Any], name: str) -> Result:
        """Return the run of the coarsest spacing with other values of keys."""
        coarse = self._config(self.coarsest)
        return self._result(f"across_{coarse.particles_across}_{name}", loaded(coarse, overrides))

    @property
    def first(self) -> Result:
        """The run of the coarsest spacing."""
        return self.results[f"across_{self._config(self.coarsest).particles_across}"]


@dataclass(frozen=True)
class Finding:
    """The ``verdict`` on a ``quantity`` by its ``difference``, the ``bar`` of the reference and the ``noise`` of D.

    All are over the size of the data. ``reason``: why the bar is not smaller, or empty.
    """

    quantity: Quantity
    difference: float
    bar: float
    noise: float
    verdict: str
    reason: str

    @property
    def text(self) -> str:
        """The verdict in words."""
        numbers = f"a difference of {_percent(self.difference)}, a bar of the reference of {_percent(self.bar)}"
        scatter = self.quantity.scatter
        noise = f", a scatter of the data of {_percent(scatter)}" if scatter > TENTH * self.difference else ""
        more = f": {self.quantity.words}" if self.verdict == "differs" else ""
        reason = f"; {self.reason}" if self.reason and self.verdict == "undecided" else ""
        return f"{self.quantity.name}: {self.verdict}{more} ({numbers}{noise}){reason}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if math.isfinite(share) else "unknown size"


@dataclass(frozen=True)
class Explanation:
    """A change that explains the data, in ``words``, with its fitted values and standard uncertainties.

    ``remain``: part of the difference that it leaves.
    """

    name: str
    values: tuple[float, ...]
    uncertain: tuple[float, ...]
    remain: float
    words: str


def verdict(difference: float, bar: float, noise: float, detail: float) -> str:
    """Return agrees, differs or undecided."""
    both = math.hypot(bar, noise)
    if difference > max(detail, SURE * both):
        return "differs"
    return "agrees" if difference <= max(both, detail) and bar <= detail else "undecided"


def explanations(source: Referee, findings: Sequence[Finding]) -> list[Explanation]:
    """Return the single changes that explain the data, the best first; none for fewer than five values.

    They are fitted to all velocities, or to what differs if no velocity does.
    """
    differing = [each for each in findings if each.verdict == "differs"]
    velocities = [each for each in findings if isinstance(each.quantity, Field) and "u" in each.quantity.parts]
    judged = velocities if any(each in differing for each in velocities) else differing
    if sum(each.quantity.data.size for each in judged) < alignment.LEAST:
        return []

    def stacked(values: Any) -> np.ndarray:
        """Return the values of all quantities, each over the size of its data."""
        return np.concatenate([(values(each.quantity) / each.quantity.size).ravel() for each in judged])

    residual = stacked(lambda each: each.data - each.reference)
    bar = math.hypot(*(math.hypot(each.bar, each.noise) for each in judged))
    scatter = math.hypot(*(each.quantity.scatter for each in judged))

    def systematic(values: np.ndarray) -> float:
        """Return the norm of ``values`` without the scatter."""
        return math.sqrt(max(float(values @ values) - scatter**2, 0.0))

    error = systematic(residual)
    if not error or not any(np.any(each.quantity.reference) for each in judged):  # scatter alone, or a flow at rest
        return []
    tried = []
    for name, words, derivatives in _changes(source, [each.quantity for each in judged]):
        matrix = np.stack([stacked(each) for each in derivatives], axis=1)
        if np.linalg.norm(matrix) < 1e-6:  # a change of which the flow knows nothing
            continue
        values, *_ = np.linalg.lstsq(matrix, residual, rcond=1e-6)
        remain = systematic(residual - matrix @ values) / error
        doubt = bar / np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        tried.append(Explanation(name, tuple(values), tuple(doubt), remain, words(values, doubt)))
    tried.sort(key=lambda each: each.remain)
    least = tried[0].remain + bar / error
    return [each for each in tried if each.remain <= min(EXPLAINS, least)]


def _changes(source: Referee, judged: Sequence[Quantity]) -> Iterator[tuple[str, Any, list[Any]]]:
    """Yield name, words and derivatives of each change; a derivative is a function of a quantity."""

    def times(name: str) -> Any:
        return lambda values, doubt: f"{name} {1 + values[0]:.4g} times as large (+- {doubt[0]:.1g})"

    yield "factor", times("all values are"), [lambda each: each.reference]
    if all(isinstance(each, Field) for each in judged):
        finest, unit, step = source.results[source.finest.folder], source.config.units.length, source.finest.spacing / 4

        def slope(axis: int) -> Any:
            shift = step * np.eye(2)[axis]
            return lambda each: (
                (each.at(finest, each.places - shift) - each.at(finest, each.places + shift)) / (2 * step)
            )

        def words(values: np.ndarray, doubt: np.ndarray) -> str:
            place = ", ".join(f"{value:.3g} (+- {each:.1g})" for value, each in zip(values, doubt, strict=True))
            return f"the places are off by ({place}) {unit}"

        yield "place", words, [slope(0), slope(1)]
    config, first = source.config, source.first
    resolved = config.resolved()
    changes: dict[str, tuple[str, dict[str, Any]]] = {}
    for key, name in KEYS.items():
        value: Any = resolved
        for part in key.split("."):
            value = value.get(part) if isinstance(value, dict) else None
        if isinstance(value, float) and value:
            changes[name] = f"the {name} is", {key: value * (1.0 + STEP)}
    moments = {"time.samples": [t * (1 + STEP) for t in config.time.samples], "time.end": config.time.end * (1 + STEP)}
    changes["clock"] = "the data are of times", moments
    for name, (words_of, overrides) in changes.items():
        other = source.changed(overrides, name.replace(" ", "_"))

        def derivative(each: Quantity, other: Result = other) -> np.ndarray:
            return (each.of(other) - source.values(each, first)) / STEP

        yield name, times(words_of), [derivative]


@dataclass(frozen=True)
class Comparison:
    """Findings on all data, changes that explain them, and the contents of the ``accuracy.json`` of the chain.

    ``late``: whether the time of ``--at-most`` was over, so that no changes were tried.
    """

    findings: list[Finding]
    explained: list[Explanation]
    chain: dict[str, Any]
    late: bool = False

    @property
    def agrees(self) -> bool:
        """Whether all data agree with the reference."""
        return all(each.verdict == "agrees" for each in self.findings)


def compare(
    config: Config,
    paths: Sequence[Path],
    question: judge.Question,
    folder: Path,
    at_most: str | None = None,
    detail: float | None = None,
) -> Comparison:
    """Compare the files ``paths`` with a reference that is made, or kept, in ``folder``.

    ``at_most``: longest time of the chain, such as 10min; ``detail``: difference of which nothing more is asked.
    ConfigError where the data cannot be compared, or no run ends.
    """
    detail, limit = detail or DETAIL, until.limit(at_most)
    compared = quantities(config, paths, question)
    wanted = [Tenth(each.name, detail, False, "a tenth of the difference", each) for each in compared]
    with claimed(folder, "another comparison is writing there"):
        source = Referee(sampled(config, compared), folder / until.RUNS, wanted)
        chain = until.Chain(source, wanted, limit, lambda text: print(text, file=sys.stderr, flush=True))
        chain.run()
        if not chain.points:
            raise ConfigError(f"{config.name}: no reference: {chain.stopped}")
        entries = chain.entries()
        findings = []
        for goal in wanted:
            each, bar = goal.quantity, chain.bar(goal).size
            noise = each.scatter * (4.0 / each.data.size) ** 0.25
            reason = "" if entries[goal.name]["reached"] else entries[goal.name]["reason"] or ""
            found = verdict(each.difference, bar, noise, detail)
            findings.append(Finding(each, each.difference, bar, noise, found, reason))
        late = source.spent > limit
        explained = [] if late else explanations(source, findings)
        with replaced(Folder(folder).accuracy) as new:
            new.write_text(json.dumps(entries, indent=2), encoding="utf-8")
    return Comparison(findings, explained, entries, late)


def text(found: Comparison, name: str, folder: Path) -> str:
    """Return the printed text: a line for each quantity, then what explains the differences."""
    across = next(iter(found.chain.values()))["runs"][-1]["particles_across"]
    lines = [f"against runs of {name} in {folder}, the finest with {across} particles across:"]
    for note in dict.fromkeys(note for each in found.findings for note in each.quantity.notes):
        lines.append(f"  {note}")
    lines += [each.text for each in found.findings]
    if any(each.verdict == "differs" for each in found.findings):
        several = ", and cannot be told apart by these data" if len(found.explained) > 1 else ""
        none = "changes are not tried, --at-most is over" if found.late else "no change that is tried explains it"
        lines.append(f"what explains the difference{several}:" if found.explained else none)
        lines += [f"  {each.words}; {_percent(each.remain)} of the difference remains" for each in found.explained]
    return "\n".join(lines)


def write(found: Comparison, folder: Path) -> Path:
    """Write the numbers into ``folder``, where they replace an earlier comparison; return the path."""
    data = {
        "quantities": [
            {
                "name": each.quantity.name,
                "values": int(each.quantity.data.size),
                "verdict": each.verdict,
                "difference": each.difference,
                "bar": each.bar if math.isfinite(each.bar) else None,
                "scatter": each.quantity.scatter,
                "reason": each.reason,
                "words": each.text,
                "notes": each.quantity.notes,
            }
            for each in found.findings
        ],
        "explained_by": [
            {"name": each.name, "values": each.values, "uncertain": each.uncertain, "remain": each.remain,
             "words": each.words}
            for each in found.explained
        ],
    }  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    with replaced(folder / judge.NUMBERS) as new:
        new.write_text(json.dumps(data, indent=1), encoding="utf-8")
    return folder / judge.NUMBERS
