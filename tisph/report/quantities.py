"""What colours the particles of a movie and fills its profile panel: speed, or polymer shear stress."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tisph.report import style
from tisph.report.labels import stress_unit, velocity_unit
from tisph.snapshot import Snapshot

_TIMES, _HEIGHTS = 60, 101  # at which the exact solution is looked at
_WALL_TIMES = 2000  # a wall that oscillates is looked at more often: it costs nothing, and there speeds peak
_MARGIN = 0.08  # of the range of the profile panel, at both ends: overshoot stays in sight


@dataclass(frozen=True)
class Quantity:
    """A quantity with its names, its unit and its ranges over the run.

    ``colour_name``, ``colour_map`` and ``colour_range`` are for the discs, ``profile_name`` and
    ``profile_range`` for the profile panel; ``of_discs`` and ``of_profile`` take both values from a snapshot,
    arrays of shape (particles,), and ``exact`` the profile's exact values at heights and times.
    """

    unit: str
    colour_name: str
    colour_map: str
    colour_range: tuple[float, float]
    of_discs: Callable[[Snapshot], np.ndarray]
    profile_name: str
    profile_range: tuple[float, float]
    of_profile: Callable[[Snapshot], np.ndarray]
    exact: Callable[[np.ndarray, float], np.ndarray]


def quantity(name: str, channel, end: float) -> Quantity:
    """Return the quantity that ``output.video.color_by`` calls ``name``, for a run of ``channel`` to time ``end``."""
    return {"speed": _speed, "shear_stress": _shear_stress}[name](channel, end)


def _speed(channel, end: float) -> Quantity:
    ends = [*_extremes(channel.exact_velocity, channel, end), *_wall_extremes(channel, end)]
    largest = _largest(ends, channel.reference_velocity)
    return Quantity(
        unit=velocity_unit(channel.units),
        colour_name="speed",
        colour_map=style.COLOUR_MAP,
        colour_range=(0.0, largest),
        of_discs=lambda snapshot: np.hypot(snapshot.u, snapshot.v),
        profile_name="u",
        profile_range=_with_margin(ends, largest),
        of_profile=lambda snapshot: snapshot.u,
        exact=channel.exact_velocity,
    )


def _shear_stress(channel, end: float) -> Quantity:
    ends = _extremes(channel.exact_polymer_shear_stress, channel, end)
    largest = _largest(ends, channel.dynamic_viscosity * channel.reference_velocity / channel.gap)
    return Quantity(
        unit=stress_unit(channel.units),
        colour_name="polymer shear stress Sxy",
        colour_map=style.DIVERGING_MAP,
        colour_range=(-largest, largest),
        of_discs=lambda snapshot: snapshot.stress_xy,
        profile_name="polymer shear stress Sxy",
        profile_range=_with_margin(ends, largest),
        of_profile=lambda snapshot: snapshot.stress_xy,
        exact=channel.exact_polymer_shear_stress,
    )


def _extremes(exact: Callable, channel, end: float) -> tuple[float, float]:
    """Return the smallest and largest finite value that ``exact`` takes from the start of the run to ``end``.

    More times early on, where a start changes fastest. Between the last two times lies 1/30 of the run: what
    peaks there in between can pass the range by little.
    """
    times = channel.start_time + (end - channel.start_time) * np.linspace(0.0, 1.0, _TIMES) ** 2
    heights = np.linspace(0.0, channel.gap, _HEIGHTS)
    values = exact(heights[:, None], times[None, :])
    values = values[np.isfinite(values)]
    return float(values.min()), float(values.max())


def _wall_extremes(channel, end: float) -> tuple[float, float]:
    times = np.linspace(channel.start_time, end, _WALL_TIMES)
    walls = (channel.bottom, channel.top)
    velocities = np.concatenate([wall.velocity(times) for wall in walls])
    if channel.start_time == 0.0:  # the liquid still has the velocity that a wall had before
        velocities = np.append(velocities, [wall.before for wall in walls if wall.before is not None])
    return float(velocities.min()), float(velocities.max())


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
