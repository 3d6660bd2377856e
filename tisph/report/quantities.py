"""What colours the particles of a movie and fills its profile panel, with names, units and ranges over the run."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tisph.report import style
from tisph.report.labels import unit_label
from tisph.scenes._views import Profile
from tisph.snapshot import Snapshot

_MARGIN = 0.08  # of the range of the profile panel, at both ends: overshoot stays in sight


@dataclass(frozen=True)
class Quantity:
    """A quantity with its names, its unit and its ranges over the run.

    ``colour_name``, ``colour_map`` and ``colour_range`` are for the discs, whose values ``of_discs`` takes from a
    snapshot, array (particles,); ``profile`` and ``profile_range`` are for the profile panel. ``error`` names the field
    whose error is given, in words; None for the velocity.
    """

    unit: str
    colour_name: str
    colour_map: str
    colour_range: tuple[float, float]
    of_discs: Callable[[Snapshot], np.ndarray]
    profile: Profile
    profile_range: tuple[float, float]
    error: tuple[str, str] | None


def quantity(name: str, scene, end: float) -> Quantity:
    """Return the quantity that ``output.video.color_by`` calls ``name``, for a run of ``scene`` to time ``end``."""
    view = scene.movie_view(name, end)
    largest = _largest(view.ends, view.otherwise)
    return Quantity(
        unit=unit_label(view.profile.unit, scene.units),
        colour_name=view.name,
        colour_map=style.DIVERGING_MAP if view.signed else style.COLOUR_MAP,
        colour_range=(-largest if view.signed else 0.0, largest),
        of_discs=view.of,
        profile=view.profile,
        profile_range=_with_margin(view.ends, largest),
        error=view.error,
    )


def _largest(ends: Sequence[float], otherwise: float) -> float:
    """Return the largest size of ``ends``, rounded up to three digits for a scale that ends at a tick."""
    largest = max(abs(value) for value in ends)
    if largest == 0.0:  # a run in which nothing moves
        return otherwise
    digit = 10.0 ** (math.floor(math.log10(largest)) - 2)
    return float(f"{math.ceil(largest / digit * (1.0 - 1e-6)) * digit:.2e}")


def _with_margin(ends: Sequence[float], largest: float) -> tuple[float, float]:
    """Return the range from the smallest to the largest of ``ends`` and 0, and a margin."""
    lowest, highest = min(0.0, *ends), max(0.0, *ends)
    if lowest == highest:
        highest = largest
    margin = _MARGIN * (highest - lowest)
    return lowest - margin, highest + margin
