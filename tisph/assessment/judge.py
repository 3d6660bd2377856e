"""``tisph compare``: the result of any code against the reference of a config, as numbers, text, JSON and a picture.

The numbers are the same as for a run of tisph. Beside them stand the place of the error, the order of convergence, and
the faults that explain the error.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tisph import scenes
from tisph.assessment import alignment, columns, diagnosis, readers
from tisph.assessment.columns import Frame
from tisph.assessment.diagnosis import error_location, trend
from tisph.config.schema import Config
from tisph.errors import ConfigError
from tisph.measures.metrics import fitted_order, sample_metrics
from tisph.measures.steadiness import with_followed
from tisph.report.plots import profile_figure
from tisph.scenes._scene import Scene
from tisph.text_table import format_table

NUMBERS, PICTURE = "comparison.json", "comparison.png"

ERRORS = {"l2": "L2 error", "rms": "rms error / U", "linf": "largest error / U"}

STEADY_TIMES = 101
"""Times with the same numbers, which make data that are compared with a steady reference a steady flow."""

BLIND = (
    "Slope and intercept are those of a straight line through the probes. They are blind to every error that is\n"
    "symmetric about mid-gap, so they can verify nothing by themselves: read L2, centreline and wall shear."
)


@dataclass(frozen=True)
class Question:
    """How to read the data: options of ``tisph compare``."""

    times: Sequence[float] = ()
    columns: Sequence[str] = ()
    units: Sequence[str] = ()
    orientation: str | None = None
    origin: tuple[float, float] | None = None
    select: str | None = None


@dataclass(frozen=True)
class Sample:
    """One time of one file: its data in the scene, its numbers as in ``summary.json``, and the place of its error."""

    path: Path
    aligned: alignment.Aligned
    numbers: dict[str, Any]
    location: dict[str, Any]

    @property
    def scene(self) -> Any:
        """The scene with the spacing of the data."""
        return self.aligned.scene

    @property
    def across(self) -> int:
        """Number of points across the reference length of the scene."""
        return round(self.scene.reference_length / self.scene.spacing)

    @property
    def error(self) -> float | None:
        """L2 error; without a scale for it the root mean square error over U, or the largest error over U."""
        name = "rms" if self.scene.vanishing_scale or self.numbers["l2"] is None else "l2"
        return self.location["largest_error"] if self.numbers[name] is None else self.numbers[name]


@dataclass(frozen=True)
class Judgement:
    """Samples in the order of resolution and time, and findings on all of them.

    ``trends``: growth of the error, in words; ``orders``: time -> order of convergence; ``diagnoses``: name of a set of
    samples -> ``diagnosis.Diagnosis``.
    """

    samples: list[Sample]
    trends: list[str]
    orders: dict[float, float]
    diagnoses: dict[str, diagnosis.Diagnosis]


def has_reference(config: Config) -> bool:
    """Return whether the flow of a ``config`` has an exact or published solution, which ``judge`` needs."""
    scene = scenes.of(config)
    return bool({"u", "v"} & set(scene.fields)) or _steady(scene)


def judge(config: Config, paths: Sequence[Path], question: Question) -> Judgement:
    """Compare the files ``paths`` with the reference of a ``config``; ConfigError where that is not possible."""
    scene = scenes.of(config)
    samples = [_sample(*each, scene, question, config) for each in frames(paths, question, scene)]
    samples.sort(key=lambda each: (-each.scene.spacing, each.numbers["t"]))
    if _steady(scene):
        return Judgement(samples, [], {}, {})
    by_resolution: dict[int, list[Sample]] = {}
    for each in samples:
        by_resolution.setdefault(each.across, []).append(each)
    trends = [trend([(each.numbers["t"], each.numbers["rms"]) for each in own]) for own in by_resolution.values()]
    orders = {}
    for t in sorted({each.numbers["t"] for each in samples}):
        errors = {each.across: each.error for each in samples if each.numbers["t"] == t}
        if len(errors) > 1 and all(errors.values()):
            orders[t] = fitted_order(errors.keys(), [error for error in errors.values() if error])
    return Judgement(samples, [text for text in trends if text], orders, _diagnoses(by_resolution))


def _steady(scene: Scene) -> bool:
    """Return whether the reference of the scene is one of its steady state alone."""
    return any(profile.steady for profile in scene.profiles())


def _diagnoses(by_resolution: dict[int, list[Sample]]) -> dict[str, diagnosis.Diagnosis]:
    """Return a diagnosis for each resolution; if no fault explains all its times, also for each time alone."""
    found = {}
    for across, samples in by_resolution.items():
        label = f"{across} across"
        found[label] = diagnosis.diagnose([each.aligned for each in samples])
        if len(samples) > 1 and not found[label].explaining:
            for each in samples:
                found[f"{label}, t = {each.numbers['t']:g} alone"] = diagnosis.diagnose([each.aligned])
    return found


def frames(paths: Sequence[Path], question: Question, scene: Scene) -> Iterator[tuple[Path, Frame, float]]:
    """Yield (path, frame, time) of all data to compare: columns by quantity, in the units of the config."""
    chosen, times = columns.parsed(question.columns), list(question.times)
    if len(paths) > 1 and len(times) > 1 and len(times) != len(paths):
        raise ConfigError(f"--time: give one, or one for each of the {len(paths)} files")
    for index, path in enumerate(paths):
        found = [columns.by_quantity(frame, chosen, path) for frame in readers.frames(path, question.select)]
        found = [part for frame in found for part in columns.by_time(columns.in_plane(frame, chosen), path)]
        found = [columns.in_config(frame, question.units, scene.units, path) for frame in found]
        own = times if len(paths) == 1 or len(times) < 2 else [times[index]]
        paired = _paired(found, own, path)
        if not paired:
            raise ConfigError(f"{path}: has t = 0 alone, where no reference is compared; give data of a later time")
        yield from ((path, frame, t) for frame, t in paired)


def _paired(frames: list[Frame], times: list[float], path: Path) -> list[tuple[Frame, float]]:
    """Return pairs (frame, time): of each of ``times`` the nearest frame, or the frames in order if without times.

    Without ``times`` all frames after t = 0. ConfigError, which lists the frames, where that leaves a choice.
    """
    if len(frames) == len(times) == 1:
        return [(frames[0], times[0])]
    timed = [(frame, frame.time) for frame in frames if frame.time is not None]
    if len(timed) < len(frames):
        if len(frames) == len(times):
            return list(zip(frames, times, strict=True))
        if len(frames) == 1:
            raise ConfigError(f"{path}: does not say of which time it is; give --time once")
        labels = columns.shown([frame.label or f"frame {number}" for number, frame in enumerate(frames, 1)])
        raise ConfigError(f"{path}: has {len(frames)} frames without times, {labels}; give --time for each, in order")
    if not times:
        return [(frame, own) for frame, own in timed if own > 0]
    pairs = []
    for t in times:
        distances = [abs(own - t) for _, own in timed]
        frame, nearest = timed[distances.index(min(distances))]
        if abs(nearest - t) > 1e-3 * abs(t):
            known = columns.shown([f"{own:.6g}" for _, own in timed])
            raise ConfigError(f"{path}: has no data of t = {t:g}; it has {known}")
        pairs.append((frame, t))
    return pairs


def _sample(path: Path, frame: Frame, t: float, scene: Scene, question: Question, config: Config) -> Sample:
    aligned = _aligned(path, frame, t, scene, question)
    series: Any = None
    if text := alignment.errors_alone(aligned):
        aligned = aligned.noted(text)
    else:
        own = aligned.scene.time_series(**config.time_series)
        values = own.measure(aligned.snapshot)
        times = t * np.linspace(0.0, 1.0, STEADY_TIMES) if _steady(scene) else np.array([t])
        constant = np.nan_to_num(values, nan=1.0)  # loads on bodies, of which the data say nothing, are constant, too
        record = times, np.tile(constant, (len(times), 1))
        series = with_followed((own.places, values, record), own.judged_sizes)
    numbers = sample_metrics(aligned.scene, aligned.snapshot, series, errors_alone=series is None)
    if not _steady(scene):
        return Sample(path, aligned, numbers, error_location(aligned.scene, aligned.snapshot))
    aligned = aligned.noted("the data are taken for the steady state, of which the reference is")
    on_lines = numbers.get("centre_line_error")
    largest, place = (on_lines, " on the centre lines") if on_lines else (numbers["linf"], "")
    why_none = f"unknown: {numbers.get('steady_reason') or 'too few points'}"
    words = f"at most {largest:.1e} U{place}" if largest else why_none
    return Sample(path, aligned, numbers, {"largest_error": largest, "words": words})


def _aligned(path: Path, frame: Frame, t: float, scene: Scene, question: Question) -> alignment.Aligned:
    if t < scene.start_time or t <= 0:
        raise ConfigError(f"--time {t:g}: is not after the start of the flow, {scene.start_time:g}")
    names: Sequence[str] = "xyu" if scene.parallel else ("x", "y", "u", "v", "w", "r", "u_r", "u_theta")
    needed = [frame.columns[name] for name in names if name in frame.columns]
    finite = np.all([np.isfinite(column) for column in needed], axis=0)
    if finite.sum() < alignment.LEAST:
        text = f"has fewer than five points with a place and a velocity, {finite.sum()}"
        raise ConfigError(f"{path}: {text}: at least {alignment.LEAST} are compared")
    values = {name: array[finite] for name, array in frame.columns.items()}
    axes = alignment.orientation(question.orientation) if question.orientation else None
    aligned = alignment.align(values, scene, t, axes=axes, origin=question.origin)
    lost = len(finite) - int(finite.sum())
    if lost:
        aligned = aligned.noted(f"{lost} points without a number are left out")
    for text in frame.notes:
        aligned = aligned.noted(text)
    if frame.time is not None and not np.isclose(frame.time, t):
        aligned = aligned.noted(f"the file says t = {frame.time:g}, --time {t:g} was taken")
    return aligned


def text(judgement: Judgement, name: str) -> str:
    """Return the printed text: a heading, a table with a column for each sample, then the findings.

    ``name``: name of the config.
    """
    samples = judgement.samples
    heading = [f"against the reference of {name}:"]
    paths = list(dict.fromkeys(each.path for each in samples))
    for path in paths:
        own = [each for each in samples if each.path == path]
        spacing = f"{own[0].scene.spacing:.4g} {own[0].scene.units.length}"
        heading.append(f"  {path}: {own[0].aligned.points} points, spacing {spacing}")
        heading += [f"    {note}" for note in dict.fromkeys(note for each in own for note in each.aligned.notes)]
    header = [f"{each.path.stem if len(paths) > 1 else ''} t = {each.numbers['t']:g}".strip() for each in samples]
    parts = ["\n".join(heading), format_table(["", *header], _rows(samples))]
    if any(each.numbers.get("slope") is not None for each in samples):
        parts.append(BLIND)
    return "\n\n".join([*parts, "\n".join(_findings(judgement))])


def _rows(samples: list[Sample]) -> list[list[str]]:
    rows = [["t*", *(f"{each.numbers['t_star']:.4g}" for each in samples)]]
    rows.append(["resolved", *("yes" if each.numbers["resolved"] else "no" for each in samples)])
    for key, label in ERRORS.items():
        rows.append([label, *("-" if each.numbers[key] is None else f"{each.numbers[key]:.3e}" for each in samples)])
    keys = dict.fromkeys(key for each in samples for key in each.numbers)
    for key in keys:
        if f"{key}_exact" in keys:
            rows.append([f"{key.replace('_', ' ')} (exact)", *(_with_exact(each.numbers, key) for each in samples)])
    return rows


def _with_exact(numbers: dict[str, Any], key: str) -> str:
    """Return a number with its exact value and the relative difference, if the exact value is not 0."""
    value, exact = numbers.get(key), numbers.get(f"{key}_exact")
    if value is None or exact is None:
        return "-"
    off = ""
    if exact:
        difference = abs(value / exact - 1)
        if difference > 1:
            off = f", {value / exact:.2g} times"
        elif difference > 1e-8:
            off = f", {100 * difference:.2g} % off"
    return f"{value:.5g} ({exact:.5g}{off})"


def _findings(judgement: Judgement) -> Iterator[str]:
    for each in judgement.samples:
        yield f"t = {each.numbers['t']:g}, {each.across} across: error {each.location['words']}"
        if not each.numbers["resolved"]:
            yield f"  not resolved: {each.numbers['reason']}"
    yield from judgement.trends
    for t, order in judgement.orders.items():
        yield f"t = {t:g}: the error falls with the power {order:.2g} of the spacing"
    for label, found in judgement.diagnoses.items():
        if not found.explaining:
            if found.fits:
                yield f"{label}: no single fault that is looked for explains the error"
            continue
        several = len(found.explaining) > 1
        yield f"{label}: what would explain the error" + (
            ", and cannot be told apart by these data:" if several else ":"
        )
        for one in found.explaining:
            yield f"  {one.words}; the rms error would fall from {found.error:.2e} U to {one.remain:.2e} U"
        if several:
            yield "  data of more times, or of a flow with another drive, may tell them apart"


def write(judgement: Judgement, folder: Path) -> tuple[Path, Path]:
    """Write numbers and picture into ``folder``, where they replace an earlier comparison; return their paths."""
    samples = [
        {
            "file": str(each.path),
            "points": each.aligned.points,
            "spacing": float(each.scene.spacing),
            "placed": list(each.aligned.notes),
            **each.numbers,
            "where": each.location,
        }
        for each in judgement.samples
    ]
    diagnoses = {
        label: {
            "rms": found.error,
            "explained_by": [each.fault.name for each in found.explaining],
            "words": [each.words for each in found.explaining],
            "fits": {each.fault.name: {"value": each.value, "rms_that_remains": each.remain} for each in found.fits},
        }
        for label, found in judgement.diagnoses.items()
    }
    data = {
        "samples": samples,
        "trends": judgement.trends,
        "orders": {str(t): order for t, order in judgement.orders.items()},
        "diagnoses": diagnoses,
    }
    folder.mkdir(parents=True, exist_ok=True)
    numbers, picture = folder / NUMBERS, folder / PICTURE
    numbers.write_text(json.dumps(data, indent=1), encoding="utf-8")
    finest = min(each.scene.spacing for each in judgement.samples)
    shown = [each for each in judgement.samples if each.scene.spacing == finest]
    profile_figure(shown[0].scene, [each.aligned.snapshot for each in shown]).save(picture)
    return numbers, picture
