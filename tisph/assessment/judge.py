"""The numbers of a result: those that a run of tisph has of itself, where its error is, its order, what is wrong."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tisph import scenes
from tisph.assessment import alignment, columns, diagnosis, readers
from tisph.assessment.diagnosis import error_location, trend
from tisph.errors import ConfigError
from tisph.measures.metrics import fitted_order, sample_metrics


@dataclass(frozen=True)
class Question:
    """How data are to be read: all as on the command line of ``tisph compare``."""

    times: Sequence[float] = ()
    columns: Sequence[str] = ()
    units: Sequence[str] = ()
    orientation: str | None = None
    origin: tuple[float, float] | None = None
    select: str | None = None


@dataclass(frozen=True)
class Sample:
    """One time of one file: where it lies, its numbers as in ``summary.json``, where its error is."""

    path: Path
    aligned: alignment.Aligned
    numbers: dict
    location: dict

    @property
    def scene(self):
        """The scene with the spacing of the data."""
        return self.aligned.scene

    @property
    def across(self):
        """Points across the scene's own length."""
        return round(self.scene.reference_length / self.scene.spacing)

    @property
    def error(self):
        """L2 error, or where the flow has no scale for it the root mean square error over U."""
        name = "rms" if self.scene.vanishing_scale or self.numbers["l2"] is None else "l2"
        return self.numbers[name]


@dataclass(frozen=True)
class Judgement:
    """Samples in the order of resolution and time, and what they say together: ``trends`` and orders in words,
    ``orders`` by time, ``diagnosis.Diagnosis`` by what they are of."""

    samples: list[Sample]
    trends: list[str]
    orders: dict[float, float]
    diagnoses: dict[str, diagnosis.Diagnosis]


def judge(config, paths, question):
    """``Judgement`` of the files ``paths`` against the reference of a ``config``; ConfigError where that cannot be."""
    scene = scenes.of(config)
    if not {"u", "v"} & set(scene.fields):
        raise ConfigError(f"{config.name}: scene {config.scene} has no reference to compare with")
    samples = [_sample(*each, scene, question, config) for each in _frames(paths, question, scene)]
    samples.sort(key=lambda each: (-each.scene.spacing, each.numbers["t"]))
    series = _series(samples)
    trends = [trend([(each.numbers["t"], each.numbers["rms"]) for each in one]) for one in series.values()]
    return Judgement(samples, [text for text in trends if text], _orders(samples), _diagnoses(series))


def _frames(paths, question, scene):
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


def _paired(frames, times, path):
    """Pairs (frame, time): of each of ``times`` the nearest frame, or the frames in order where they have no times.

    Without ``times`` all frames after t = 0. ConfigError, which lists the frames, where that leaves a choice.
    """
    if len(frames) == len(times) == 1:
        return [(frames[0], times[0])]
    if any(frame.time is None for frame in frames):
        if len(frames) == len(times):
            return list(zip(frames, times, strict=True))
        if len(frames) == 1:
            raise ConfigError(f"{path}: does not say of which time it is; give --time once")
        labels = columns.shown([frame.label or f"frame {number}" for number, frame in enumerate(frames, 1)])
        raise ConfigError(f"{path}: has {len(frames)} frames without times, {labels}; give --time for each, in order")
    if not times:
        return [(frame, frame.time) for frame in frames if frame.time > 0]
    nearest = [(min(frames, key=lambda frame, t=t: abs(frame.time - t)), t) for t in times]
    for frame, t in nearest:
        if abs(frame.time - t) > 1e-3 * abs(t):
            known = columns.shown([f"{each.time:.6g}" for each in frames])
            raise ConfigError(f"{path}: has no data of t = {t:g}; it has {known}")
    return nearest


def _sample(path, frame, t, scene, question, config):
    aligned = _aligned(path, frame, t, scene, question)
    series = None
    if text := alignment.errors_alone(aligned):
        aligned = aligned.noted(text)
    else:
        own = aligned.scene.time_series(**config.time_series)
        values = own.measure(aligned.snapshot)
        series = own.places, values, (np.array([t]), np.asarray(values)[None])
    numbers = sample_metrics(aligned.scene, aligned.snapshot, series, errors_alone=series is None)
    return Sample(path, aligned, numbers, error_location(aligned.scene, aligned.snapshot))


def _aligned(path, frame, t, scene, question):
    if t < scene.start_time or t <= 0:
        raise ConfigError(f"--time {t:g}: is not after the start of the flow, {scene.start_time:g}")
    names = "xyu" if scene.parallel else ("x", "y", "u", "v", "w", "r", "u_r", "u_theta")
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


def _series(samples):
    """Samples of one resolution each, by particles across."""
    found = {}
    for each in samples:
        found.setdefault(each.across, []).append(each)
    return found


def _diagnoses(series):
    """Of each resolution; where no fault explains all its times also of each of them alone."""
    found = {}
    for rows, samples in series.items():
        label = f"{rows} across"
        found[label] = diagnosis.diagnose([each.aligned for each in samples])
        if len(samples) > 1 and not found[label].explaining:
            for each in samples:
                found[f"{label}, t = {each.numbers['t']:g} alone"] = diagnosis.diagnose([each.aligned])
    return found


def _orders(samples):
    """Order of the fall of the error, by time, where two or more resolutions are given."""
    found = {}
    for t in sorted({each.numbers["t"] for each in samples}):
        own = {each.across: each.error for each in samples if each.numbers["t"] == t}
        if len(own) > 1 and all(own.values()):
            found[t] = fitted_order(own.keys(), list(own.values()))
    return found
