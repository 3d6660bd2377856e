"""The quantity of the colours and of the profile panel of a movie, with names, units and ranges over the run."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import Colormap

from tisph.report import style
from tisph.report.labels import unit_label
from tisph.scenes._scene import Scene
from tisph.scenes._views import MovieView, Profile

_MARGIN = 0.08  # of the range of a panel, at both ends: overshoot stays in sight
_BEYOND, _ROOM = 0.05, 1.5  # share of the sum of sizes beyond L; colours end at so many L, or at the largest size
_MOST = 0.99  # of the values are within the limits
_SANE = 0.999  # of the sizes; larger ones, which may be infinite, count as the largest of these
_FEW = 0.01  # share of the sum of sizes of the values of one sign: below it they count as none
_DRAWN = 4000  # values of a frame that count
_WHOLE = 0.98  # of the frames, where all values of a frame count: a start may be infinite
_ROUNDING = 1e-9  # of the largest: values of the other sign up to it are none

Ends = tuple[float, float]


@dataclass(frozen=True)
class Quantity:
    """A quantity with its names, its unit and its ranges over the run.

    ``colour_name``, empty for a field that needs no colour bar, ``colour_map`` and ``colour_range`` are for the field;
    ``profile`` and ``profile_range`` are for the profile panel. ``error`` names the field whose error is given, in
    words; None for the velocity. ``of_frame``: function of the limits of the values of one frame that returns its
    ``colour_range``, where the colours follow the frames; else None.
    """

    unit: str
    colour_name: str
    colour_map: str | Colormap
    colour_range: Ends
    profile: Profile
    profile_range: Ends
    error: tuple[str, str] | None
    of_frame: Callable[[Ends], Ends] | None = None


def quantity(
    view: MovieView, scene: Scene, limits: str | Sequence[float], ends: tuple[Ends, Ends] | None = None
) -> Quantity:
    """Return the quantity that ``view`` of ``scene`` shows, in the colour ``limits`` of the config.

    ``ends`` are the limits of the colours, and the smallest and largest value of the profile, in the frames, where the
    view has none. They are relative to the ``base`` of the view.
    """
    limited = limits_of(np.empty(0) if view.values is None else view.values)
    bounded = view.profile.unit == "velocity"  # all of it is shown
    colours, along = ends or (limited, (view.ends or limited) if bounded else limited)
    if not view.from_zero:
        colours = along = ends[0] if ends else (min(view.ends or limited), max(view.ends or limited))
    largest = _largest(colours)
    signed = view.signed and min(colours) < -_ROUNDING * largest
    diverging = signed and max(colours) > _ROUNDING * largest

    def automatic(colours: Ends) -> Ends:
        largest = _largest(colours)
        if not view.from_zero:
            return colours[0], max(colours[1], colours[0] + _ROUNDING * largest)
        least, most = -largest if signed else 0.0, largest if diverging or not signed else 0.0
        return view.base + least, view.base + most

    low, high = automatic(colours) if isinstance(limits, str) else limits
    zero = (*((0.0,) if view.from_zero else ()), *view.walls)
    least, most = with_margin((min(*zero, *along), max(*zero, *along)), largest)
    return Quantity(
        unit=unit_label(view.profile.unit, scene.units),
        colour_name=view.name,
        colour_map=style.DIVERGING_MAP if diverging or (view.signed and low < 0.0 < high) else style.COLOUR_MAP,
        colour_range=(low, high),
        profile=view.profile,
        profile_range=(view.base + least, view.base + most),
        error=view.error,
        of_frame=automatic if limits == "frame" else None,
    )


def limits_of(values: np.ndarray) -> Ends:
    """Return the limits of the colours of ``values`` (n,), which are spread evenly over fluid and time.

    They are as far from 0 as the larger of 1.5 L and the 99 % quantile of |v|, or as the lowest and the highest value.
    L is the size with sum max(0, |v| - L) = 0.05 sum |v|: fluid at rest, however much, does not lower it, and high
    values at corners and at starts hardly raise it. Of |v| larger ones than the 99.9 % quantile count as that. Values
    that are linear in space are within the limits.
    """
    values = values[np.isfinite(values)]
    if not values.any():
        return 0.0, 0.0
    size = np.sort(np.abs(values))[::-1]
    size = np.minimum(size, np.quantile(size, _SANE))
    total = np.cumsum(size)
    beyond = total - size * np.arange(1, len(size) + 1)  # of L = size[k]
    room = max(_ROOM * size[np.searchsorted(beyond, _BEYOND * total[-1], "right") - 1], np.quantile(size, _MOST))
    low, high = (float(min(room, max(0.0, (sign * values).max()))) for sign in (-1.0, 1.0))
    few = [np.maximum(0.0, sign * values).sum() <= _FEW * total[-1] for sign in (-1.0, 1.0)]
    return 0.0 if few[0] else -low, 0.0 if few[1] else high


class Extremes:
    """The range of values that come frame by frame, without the few frames that stand out."""

    def __init__(self) -> None:
        self._least: list[float] = []
        self._most: list[float] = []

    def add(self, values: np.ndarray, weight: Any = 1.0) -> None:
        """Take the ``values`` of one frame, of any ``weight``; those that are no finite numbers are left out."""
        values = values[np.isfinite(values)]
        if values.size:
            self._least.append(float(values.min()))
            self._most.append(float(values.max()))

    @property
    def ends(self) -> Ends:
        """The smallest and the largest value; (0, 0) where there were none."""
        if not self._most:
            return 0.0, 0.0
        return float(np.quantile(self._least, 1.0 - _WHOLE)), float(np.quantile(self._most, _WHOLE))


class Spread:
    """The limits of values that come frame by frame, from evenly chosen ones of all frames; see ``limits_of``."""

    def __init__(self) -> None:
        self._values: list[np.ndarray] = []

    def add(self, values: np.ndarray, weight: Any = 1.0) -> None:
        """Take the ``values`` of one frame, whose particles have areas of this ``weight`` (n,)."""
        upper = np.cumsum(np.broadcast_to(weight, values.shape))
        even = style.evenly_chosen(len(values), _DRAWN)
        self._values.append(values[np.searchsorted(upper, even + 0.5)])

    @property
    def ends(self) -> Ends:
        """The lower and the upper limit; (0, 0) where there were no values."""
        return limits_of(np.concatenate([np.empty(0), *self._values]))


def _largest(ends: Sequence[float]) -> float:
    """Return the largest size of ``ends``, rounded up to three digits for a scale that ends at a tick."""
    largest = max(abs(value) for value in ends)
    if largest == 0.0:  # a run in which nothing moves
        return 1.0
    digit = 10.0 ** (math.floor(math.log10(largest)) - 2)
    return float(f"{math.ceil(largest / digit * (1.0 - 1e-6)) * digit:.2e}")


def with_margin(ends: Ends, otherwise: float) -> Ends:
    """Return the range of ``ends`` and a margin; ``otherwise`` is its length where both are the same."""
    lowest, highest = ends
    if lowest == highest:
        highest = lowest + otherwise
    margin = _MARGIN * (highest - lowest)
    return lowest - margin, highest + margin
