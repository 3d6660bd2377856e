"""Points of a smooth curve along a drawn path, which a spline goes through, and smoothing of paths that are jagged.

A path is smoothed as a function of its own length: with wave numbers k, places z = x + i y have Fourier coefficients
c[k], which become c[k] / (1 + strength (k^3 - k)^2). Circles stay as they are. An open path is continued by its mirror
image, whose ends are level, or periodically, without the straight line from end to end; its factor is
1 / (1 + strength k^6). ``strength`` is the largest with which no place of the path is farther from the smooth curve
than a tolerance.
"""

import math
from collections.abc import Callable
from typing import Literal

import numpy as np

from tisph.geometry.drawing import ROUNDING, DrawnPath
from tisph.geometry.shape import Shape

Ends = Literal["closed", "level", "periodic"]

COUNTS = (32, 64, 128, 256)
"""Numbers of points that are tried."""

CLOSE = 1e-6
"""Deviation of the curve from the path, over the size of the path, at which no more points are tried."""

MOST_ROWS = 1000
"""Most corners of a polyline that a curve goes through."""

LARGEST_TURN, LARGEST_KINK = math.radians(46.0), math.radians(10.0)
"""Largest turn at a corner of a polyline that a curve goes through, and where curved pieces meet."""

STEPS = 8192
"""Points along a path that is smoothed."""

STRENGTHS, HALVINGS = (-22.0, 4.0), 40
"""Range of the powers of ten of the strength, and number of halvings of this range."""

CHECKED = 2000
"""Places at which the deviation is computed."""


def smooth_points(
    path: DrawnPath, ends: Ends, tolerance: float | None, shape_of: Callable[[np.ndarray], Shape]
) -> np.ndarray:
    """Return points (n, 2) along a ``path``, from its start, through which ``shape_of(points)`` is a smooth curve.

    Without ``tolerance`` [length] they lie on the path; of a polyline they are its corners. ValueError where the path
    has corners, or more than ``MOST_ROWS`` of them.
    """
    closed, places = ends == "closed", path.places
    if closed and path.opening <= ROUNDING * path.size:
        places = places[:-1]  # the start again
    if tolerance is not None:
        places = smoothed(places, ends, tolerance)
    elif path.straight:
        _check_turns(path, LARGEST_TURN)
        if len(places) > MOST_ROWS:
            text = f"has {len(places)} points, and a curve goes through at most {MOST_ROWS}"
            raise ValueError(f"{text}: give file.smoothing, the largest distance of a smoother curve from them")
        return places
    else:
        _check_turns(path, LARGEST_KINK)
    for count in COUNTS:
        points = evenly_chosen(places, count, closed)
        try:
            shape = shape_of(points)
        except ValueError:  # few points of a thin shape make a curve that crosses itself
            if count == COUNTS[-1]:
                raise
            continue
        if deviation(shape, places) <= CLOSE * path.size:
            break
    return points


def _check_turns(path: DrawnPath, largest: float) -> None:
    turn = float(path.corners().max(initial=0.0))
    if turn > largest:
        text = f"the path {path.names[0]} has a corner of {math.degrees(turn):.3g} degrees, and a curve has none"
        raise ValueError(f"{text}: give file.smoothing, which rounds it; straight sides make a polygon")


def deviation(shape: Shape, places: np.ndarray) -> float:
    """Return the largest distance of ``places`` (n, 2) from a curve."""
    chosen = places[:: max(1, len(places) // CHECKED)]
    return float(np.abs(shape.nearest(chosen).distance).max())


def lengths_along(places: np.ndarray) -> np.ndarray:
    """Return the lengths (n,) of a polyline from its first corner to each of its corners (n, 2)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))])


def evenly_chosen(places: np.ndarray, count: int, closed: bool) -> np.ndarray:
    """Return about ``count`` of the ``places`` (n, 2), at even distances; both ends of an open path."""
    along = lengths_along(np.concatenate([places, places[:1]]) if closed else places)
    wanted = np.linspace(0.0, along[-1], count, endpoint=not closed)
    after = np.clip(np.searchsorted(along, wanted), 1, len(along) - 1)
    nearest = np.where(wanted - along[after - 1] < along[after] - wanted, after - 1, after)
    return places[np.unique(nearest % len(places))]


def smoothed(places: np.ndarray, ends: Ends, tolerance: float) -> np.ndarray:
    """Return the smoothest curve (n, 2) no farther than ``tolerance`` from all of the polyline (m, 2).

    An open one begins and ends at the same x as the polyline, a periodic one at one height.
    """
    from scipy.spatial import cKDTree

    closed, levelled, part = ends == "closed", ends == "level", np.linspace(0.0, 1.0, STEPS + 1)
    whole = np.concatenate([places, places[:1]]) if closed else places
    along = lengths_along(whole)
    even = np.interp(part * along[-1], along, whole @ np.array([1.0, 1j]))
    checked = np.concatenate([places, np.stack([even.real, even.imag], axis=1)])
    change = even[-1] - even[0]
    if ends == "periodic" and abs(change.imag) > tolerance:
        raise ValueError(f"both ends of a periodic wall must be at one height, and differ by {abs(change.imag):.4g}")
    line = even[0].real + part * change.real
    waves = even - line - (0.0 if levelled else 1j * change.imag * part)
    period = np.concatenate([waves, -np.conj(waves)[-2:0:-1]]) if levelled else waves[:-1]
    k, spectrum = np.fft.fftfreq(len(period), 1.0 / len(period)), np.fft.fft(period)
    stiffness = (k**3 - k) ** 2 if closed else k**6

    def curve(power: float) -> np.ndarray:
        found = np.fft.ifft(spectrum / (1.0 + 10.0**power * stiffness))
        found = np.append(found, found[0])[: STEPS + 1] + line
        found += 0.0 if closed else even[0].real - found[0].real
        return np.stack([found.real, found.imag], axis=1)[: STEPS if closed else None]

    def far(power: float) -> float:
        return float(cKDTree(curve(power)).query(checked)[0].max())

    low, high = STRENGTHS
    if (least := far(low)) > tolerance:
        raise ValueError(f"needs a file.smoothing of {least:.3g} or more, the precision of the smooth curve")
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if far(middle) <= tolerance else (low, middle)
    return curve(low)
