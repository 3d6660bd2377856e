"""Start-up plane Couette flow: fluid at rest between two walls that start to move at t = 0.

Equation: du/dt = nu d2u/dy2 for 0 < y < H, u(y, 0) = 0, u(0, t) = U0, u(H, t) = U1.
With f(eta, T), eta = y/H, T = nu t/H^2, the flow when only the wall eta = 1 moves, with unit velocity,

    u(y, t) = U1 f(y/H, T) + U0 f(1 - y/H, T)

    f = eta + (2/pi) sum_{n>=1} (-1)^n/n sin(n pi eta) exp(-n^2 pi^2 T)                          (series)
    f = sum_{k>=0} erfc((2k+1-eta)/(2 sqrt T)) - erfc((2k+1+eta)/(2 sqrt T))                     (images)

Sources: G. K. Batchelor, An Introduction to Fluid Dynamics, section 4.3 (the series, and the half-space
solution whose reflections in the walls the images are); J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys.
136 (1997) 214-226 (the series, as the test of an SPH code).

Shapes and units: ``y`` and ``t`` broadcast against each other and the result has the broadcast shape; any
self-consistent units, ``kinematic_viscosity`` in length^2/time, wall velocities in length/time.

Both forms converge at every time; the images, half-space solutions reflected in the walls, converge fast up to
``SWITCH_TIME``, and the series after it.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

SWITCH_TIME = 0.1
"""t* = nu t/gap^2 up to which images are summed, and from which the series: at this time 3 pairs of images or
7 terms of the series reach rounding error."""

# exp(-EXPONENT) = 2e-17 and erfc(sqrt(EXPONENT)) is smaller still: the rest of the series is below double precision.
EXPONENT = 38.5


def erfc(x: Any) -> np.ndarray:
    """Return the complementary error function of an array, 0 where it is below double rounding of 1.

    SciPy has it, too, but takes a fifth of a second to import.
    """
    result, matters = np.zeros(x.shape), ~(x * np.abs(x) >= EXPONENT)  # NaN stays NaN
    result[matters] = np.fromiter(map(math.erfc, x[matters].tolist()), float)
    return result


def dimensionless(y: Any, t: Any, gap: float, kinematic_viscosity: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the broadcast pair (y/gap, nu t/gap^2) as float arrays. Raises ValueError for a negative time."""
    eta = np.asarray(y, dtype=float) / gap
    diffusion_time = kinematic_viscosity * np.asarray(t, dtype=float) / gap**2
    if np.any(diffusion_time < 0):
        raise ValueError("this flow starts at t = 0: it is defined for t >= 0 only")
    eta, diffusion_time = np.broadcast_arrays(eta, diffusion_time)
    return eta, diffusion_time


def select(forms: tuple[Callable, ...], eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    """Evaluate each of the ``forms`` (start, early, late) in its range of times; a scalar for scalar arguments.

    ``start`` is called at t* = 0, ``early`` up to ``SWITCH_TIME``, ``late`` after it, each with the pairs (eta, t*) in
    its range as arrays of shape (pairs,).
    """
    at_start = diffusion_time == 0
    early = ~at_start & (diffusion_time <= SWITCH_TIME)
    late = diffusion_time > SWITCH_TIME
    result = np.empty(eta.shape)
    for form, where in zip(forms, (at_start, early, late), strict=True):
        if where.any():
            result[where] = form(eta[where], diffusion_time[where])
    return result[()]


def series_terms(diffusion_time: np.ndarray) -> range:
    """Return the numbers n of the terms sin(n pi eta) exp(-n^2 pi^2 t*) that are above rounding at any of the times."""
    return range(1, 1 + int(np.ceil(np.sqrt(EXPONENT / diffusion_time.min()) / np.pi)))


def image_distances(diffusion_time: np.ndarray) -> range:
    """Return odd distances 2k+1: the next image, at least 2k+2 from any eta <= 1, adds less than rounding error."""
    return range(1, 2 + 2 * int(np.ceil(np.sqrt(EXPONENT * diffusion_time.max()))), 2)


def velocity(y: Any, t: Any, *, gap: float, kinematic_viscosity: float, bottom: float, top: float) -> np.ndarray:
    """Return the velocity u(y, t) along the walls, by the form that converges fastest, to 1e-15 of the wall speed.

    ``t >= 0``; at t = 0 the fluid is at rest and y = 0 and y = gap already have their wall's velocity.
    ``bottom`` and ``top`` are the wall velocities. Raises ValueError for a negative time.
    """
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    by_top, by_bottom = (
        speed * select(_velocity_forms, coordinate, diffusion_time) if speed != 0 else 0.0
        for coordinate, speed in ((eta, top), (1 - eta, bottom))
    )
    return (by_top + by_bottom + np.zeros_like(eta))[()]


def shear_rate(y: Any, t: Any, *, gap: float, kinematic_viscosity: float, bottom: float, top: float) -> np.ndarray:
    """Return the velocity gradient du/dy (1/time), by the form that converges fastest.

    ``t >= 0``; at t = 0 it is 0 in the fluid and infinite at a wall that moves. Otherwise as ``velocity``.
    """
    eta, diffusion_time = dimensionless(y, t, gap, kinematic_viscosity)
    at_top, at_bottom = (
        select(_gradient_forms, coordinate, diffusion_time) if speed != 0 else 0.0
        for coordinate, speed in ((eta, top), (1 - eta, bottom))
    )
    return (top * at_top - bottom * at_bottom + np.zeros_like(eta))[()] / gap


def _series_velocity(eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    total = eta.copy()
    for n in series_terms(diffusion_time):
        decay = np.exp(-((n * np.pi) ** 2) * diffusion_time)
        total += (-1) ** n * 2 / (n * np.pi) * np.sin(n * np.pi * eta) * decay
    return total


def _image_velocity(eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    width = 2 * np.sqrt(diffusion_time)
    total = np.zeros_like(eta)
    for distance in image_distances(diffusion_time):
        total += erfc((distance - eta) / width) - erfc((distance + eta) / width)
    return total


def _series_gradient(eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    total = np.ones_like(eta)
    for n in series_terms(diffusion_time):
        total += (-1) ** n * 2 * np.cos(n * np.pi * eta) * np.exp(-((n * np.pi) ** 2) * diffusion_time)
    return total


def _image_gradient(eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    width = 2 * np.sqrt(diffusion_time)
    total = np.zeros_like(eta)
    for distance in image_distances(diffusion_time):
        total += np.exp(-(((distance - eta) / width) ** 2)) + np.exp(-(((distance + eta) / width) ** 2))
    return 2 / np.sqrt(np.pi) / width * total


def _start_velocity(eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    return np.where(eta >= 1, 1.0, 0.0)


def _start_gradient(eta: np.ndarray, diffusion_time: np.ndarray) -> np.ndarray:
    return np.where(eta >= 1, np.inf, 0.0)


_velocity_forms = (_start_velocity, _image_velocity, _series_velocity)
_gradient_forms = (_start_gradient, _image_gradient, _series_gradient)
