"""Judgement of steadiness: one rule for samples, summaries, movies, tables and viscometers.

A flow is steady if its slowest time has passed since the start, or since its drive last jumped, and if no number that
its scene follows has changed over that time. The slowest time is the longest of ``FlowInBox.slow_times``: the
relaxation time of each polymer mode, the decay time of shear by viscosity where there is inertia, the convective time
of bodies that change their places. A rest that decays with that time is smaller than its change over it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.measures.flow import FlowInBox

CHANGE = 1e-3
"""Largest change of a steady number over the slowest time, relative to the largest number of its kind."""

LAST = 0.1
"""Part of the run at its end in which a steady number is constant."""

LEAST_RECORDS = 9
"""Records that are compared at least: three in each third. Where the slowest time has fewer, a longer time counts."""

SCATTER = 6.0
"""Standard errors of the difference of two means, for independent values, up to which it is scatter: twice three, since
successive values are correlated. Means over particles scatter by 2e-3 in a cavity of 25 x 25."""

LARGEST_SCATTER = 0.01
"""Largest scatter of a steady number, relative as ``CHANGE``: the scatter of a load in a resolved sample. A number that
swings further, as behind a cylinder that sheds vortices, is not constant."""

LEAST_TURNS = 8
"""Least number of times at which scatter changes its sign beside a parabola. A bend, as after a start, does so some
three to five times: its size is no scatter."""


@dataclass(frozen=True)
class Followed:
    """Numbers that a scene follows: ``times`` (n,), ``values`` (n, numbers), and the ``sizes`` of each by its name.

    Numbers of one kind, such as drag and lift, have the same size; numbers of infinite size may change in steady flow.
    """

    times: np.ndarray
    values: np.ndarray
    sizes: Mapping[str, float]

    def scales(self, chosen: np.ndarray) -> np.ndarray:
        """Return the largest magnitude (numbers,) of the numbers of each kind among the ``chosen`` records.

        It is at least ``CHANGE`` times the size: smaller numbers count as zero.
        """
        sizes = np.array(list(self.sizes.values()))
        known = np.nan_to_num(np.abs(self.values[chosen]))
        found = np.array([known[:, sizes == size].max(initial=0.0) for size in sizes])
        return np.where(np.isinf(sizes), np.inf, np.maximum(found, CHANGE * np.where(np.isinf(sizes), 0.0, sizes)))


@dataclass(frozen=True)
class Steadiness:
    """Whether a flow is ``steady``, the largest relative ``change`` over its slowest time, and the ``reason`` if not.

    The change is None where it is unknown.
    """

    steady: bool
    change: float | None = None
    reason: str | None = None

    @property
    def numbers(self) -> dict[str, Any]:
        """The judgement as numbers of a sample."""
        return {"steady": self.steady, "steady_change": self.change, "steady_reason": self.reason}


def with_followed(series: tuple[Any, ...], sizes: Mapping[str, float]) -> tuple[Any, ...]:
    """Return a ``series`` of places, numbers, and times with numbers so far, with these and their ``sizes`` as an item.

    Without sizes the series stays as it is: nothing is judged.
    """
    times, values = series[2]
    return (*series, Followed(times, values, sizes)) if sizes else series


def followed(series: Sequence[Any] | None) -> Followed | None:
    """Return the numbers of a ``series``, the argument of ``Scene.diagnostics``; None where it has none to judge."""
    return series[3] if series and len(series) > 3 else None


def steadiness(flow: FlowInBox, t: float, numbers: Followed | None) -> Steadiness:
    """Return the judgement of a ``flow`` at time ``t`` from the ``numbers`` that its scene has followed so far."""
    if flow.driven_periodically:
        return Steadiness(False, reason="walls or the drive oscillate: the flow is periodic at best")
    since = max([flow.start_time, *(time for time in flow.jump_times if time < t)])
    slowest, name = max((time, name) for name, time in {"": 0.0, **flow.slow_times}.items())
    if t - since < slowest * (1.0 - 1e-9):
        return Steadiness(False, reason=f"the flow has run for {t - since:.3g}, less than the {name}, {slowest:.3g}")
    # the start itself, at which walls may jump, does not count
    known = np.zeros(0, bool) if numbers is None else (numbers.times <= t) & (numbers.times > since)
    if numbers is None or np.count_nonzero(known) < LEAST_RECORDS:
        return Steadiness(False, reason="the history has too few times")
    first = min(np.count_nonzero(numbers.times < t - slowest), np.flatnonzero(known)[-LEAST_RECORDS])
    chosen = np.flatnonzero(known & (np.arange(len(known)) >= first))
    changes, scatters, noise = _changes(numbers, chosen)
    if not len(changes):
        return Steadiness(True, 0.0)
    worst, names = int(np.argmax(changes - noise)), list(numbers.sizes)
    change, over = float(changes[worst]), f"over the last {t - numbers.times[first]:.3g}"
    over += f", the {name}" if slowest >= t - numbers.times[first] - 1e-9 * abs(t) and name else ""
    if not change <= max(CHANGE, noise[worst]):
        return Steadiness(False, change, f"{names[worst].replace('_', ' ')} changes by {change:.1e} {over}")
    swings = int(np.argmax(scatters))
    if not scatters[swings] <= LARGEST_SCATTER:
        text = f"{names[swings].replace('_', ' ')} goes up and down by {scatters[swings]:.1e} {over}"
        return Steadiness(False, change, text)
    return Steadiness(True, change)


def _changes(numbers: Followed, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return change, scatter and the part of the change that may be scatter, of each number over the chosen records.

    The change is the largest difference of the means over three thirds. All are relative to the scales.
    """
    values = np.nan_to_num(numbers.values[chosen])
    relative = values / numbers.scales(chosen)
    thirds = np.array([part.mean(axis=0) for part in np.array_split(relative, 3)])
    place = np.linspace(-1.0, 1.0, len(chosen))
    beside = relative - np.stack([np.polyval(np.polyfit(place, column, 2), place) for column in relative.T], axis=1)
    turns = np.count_nonzero(np.diff(np.sign(beside), axis=0), axis=0)
    scatters = np.where(turns >= LEAST_TURNS, beside.std(axis=0), 0.0)
    return np.ptp(thirds, axis=0), scatters, SCATTER * scatters * math.sqrt(6.0 / len(chosen))


def steady_since(flow: FlowInBox, numbers: Followed) -> float | None:
    """Return the first time from which the ``numbers`` equal the last ones, in a flow that is steady at the last time.

    None if the flow is not steady then, or if that time is within the last tenth of the times.
    """
    times, values = numbers.times, numbers.values
    if not len(times) or not steadiness(flow, float(times[-1]), numbers).steady:
        return None
    return constant_since(times, values, numbers.scales(np.array([len(times) - 1])))


def constant_since(times: np.ndarray, values: np.ndarray, sizes: Sequence[float] | np.ndarray) -> float | None:
    """Return the first of ``times`` (n,) from which ``values`` (n, numbers) equal the last ones; None if it is late.

    Changes are relative to ``sizes`` (numbers,). Late is within the last tenth of the times.
    """
    off = ~(np.abs(values - values[-1]) <= CHANGE * np.asarray(sizes)).all(axis=1)
    first = np.flatnonzero(off)[-1] + 1 if off.any() else 0
    quiet = first < len(times) and times[first] <= times[-1] - LAST * (times[-1] - times[0])
    return float(times[first]) if quiet else None
