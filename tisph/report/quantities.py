"""The quantity of the colours and of the profile panel of a movie, with names, units and ranges over the run."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import Colormap

from tisph.report import style
from tisph.report.labels import unit_label
from tisph.scenes._views import MovieView, Profile

_MARGIN = 0.08  # of the range of a panel, at both ends: overshoot stays in sight
_SHARE, _FRAMES = 0.98, 0.9  # of the particles of a frame, and of the frames, that a range holds: corners do not count
_WHOLE = 0.98  # of the frames, where all values of a frame count: a start may be infinite
_ROUNDING = 1e-9  # of the largest: values of the other sign up to it are none

Ends = tuple[float, float]


@dataclass(frozen=True)
class Quantity:
    """A quantity with its names, its unit and its ranges over the run.

    ``colour_name``, empty for a field that needs no colour bar, ``colour_map`` and ``colour_range`` are for the field;
    ``profile`` and ``profile_range`` are for the profile panel. ``error`` names the field whose error is given, in
    words; None for the velocity.
    """

    unit: str
    colour_name: str
    colour_map: str | Colormap
    colour_range: Ends
    profile: Profile
    profile_range: Ends
    error: tuple[str, str] | None


def quantity(
    view: MovieView, scene: Any, limits: str | Sequence[float], ends: tuple[Ends, Ends] | None = None
) -> Quantity:
    """Return the quantity that ``view`` of ``scene`` shows, in the colour ``limits`` of the config.

    ``ends`` are the smallest and largest colour and value of the profile in the frames, where the view has none.
    """
    colours, along = ends or (view.ends or (0.0, 0.0), view.ends or (0.0, 0.0))
    largest = _largest(colours)
    signed = view.signed and min(colours) < -_ROUNDING * largest
    diverging = signed and max(colours) > _ROUNDING * largest
    automatic = (-largest if signed else 0.0, largest if diverging or not signed else 0.0)
    low, high = automatic if isinstance(limits, str) else limits
    return Quantity(
        unit=unit_label(view.profile.unit, scene.units),
        colour_name=view.name,
        colour_map=style.DIVERGING_MAP if diverging else style.COLOUR_MAP,
        colour_range=(low, high),
        profile=view.profile,
        profile_range=with_margin((min(0.0, *along), max(0.0, *along)), largest),
        error=view.error,
    )


class Extremes:
    """The range of values that come frame by frame: without the few in a frame, and the few frames, that stand out.

    With ``whole`` all values of a frame count, as for a curve; a field has outliers.
    """

    def __init__(self, whole: bool = False):
        self._least: list[float] = []
        self._most: list[float] = []
        self._values, self._frames = (1.0, _WHOLE) if whole else (_SHARE, _FRAMES)

    def add(self, values: np.ndarray) -> None:
        """Take the ``values`` of one frame; those that are no finite numbers are left out."""
        values = values[np.isfinite(values)]
        if values.size:
            least, most = np.quantile(values, (1.0 - self._values, self._values))
            self._least.append(least)
            self._most.append(most)

    @property
    def ends(self) -> Ends:
        """The smallest and the largest value; (0, 0) where there were none."""
        if not self._most:
            return 0.0, 0.0
        return float(np.quantile(self._least, 1.0 - self._frames)), float(np.quantile(self._most, self._frames))


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
