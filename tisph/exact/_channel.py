"""What the start-up solutions of a plane channel share: dimensionless variables, and one form early, one late.

Early forms sum images, that is, half-space solutions reflected in the walls; late forms sum Fourier series. Both
converge at every time, each fast on its side of ``SWITCH_TIME``.
"""

import math

import numpy as np

SWITCH_TIME = 0.1
"""t* = nu t/gap^2 up to which images are summed, and from which the series: at this time 3 pairs of images or
7 terms of the series reach rounding error."""

# exp(-EXPONENT) = 2e-17 and erfc(sqrt(EXPONENT)) is smaller still: the rest of the series is below double precision.
EXPONENT = 38.5


def erfc(x):
    """The complementary error function of an array, 0 where it is below double rounding of 1.

    SciPy, which has one too, takes a fifth of a second to import, so that it is imported where nothing else will do.
    """
    result, matters = np.zeros(x.shape), ~(x * np.abs(x) >= EXPONENT)  # what is no number stays none
    result[matters] = np.fromiter(map(math.erfc, x[matters].tolist()), float)
    return result


def dimensionless(y, t, gap, kinematic_viscosity):
    """Broadcast pair (y/gap, nu t/gap^2) as float arrays. Raises ValueError for a negative time."""
    eta = np.asarray(y, dtype=float) / gap
    diffusion_time = kinematic_viscosity * np.asarray(t, dtype=float) / gap**2
    if np.any(diffusion_time < 0):
        raise ValueError("this flow starts at t = 0: it is defined for t >= 0 only")
    return np.broadcast_arrays(eta, diffusion_time)


def select(forms, eta, diffusion_time):
    """Evaluate (start, early, late) = ``forms`` each where it holds; a scalar for scalar arguments.

    ``start`` is called at t* = 0, ``early`` up to ``SWITCH_TIME``, ``late`` after it, each with the pairs
    (eta, t*) that are its own as arrays of shape (pairs,).
    """
    at_start = diffusion_time == 0
    early = ~at_start & (diffusion_time <= SWITCH_TIME)
    late = diffusion_time > SWITCH_TIME
    result = np.empty(eta.shape)
    for form, where in zip(forms, (at_start, early, late), strict=True):
        if where.any():
            result[where] = form(eta[where], diffusion_time[where])
    return result[()]


def series_terms(diffusion_time):
    """Numbers n of the terms sin(n pi eta) exp(-n^2 pi^2 t*) that matter at any of the times."""
    return range(1, 1 + int(np.ceil(np.sqrt(EXPONENT / diffusion_time.min()) / np.pi)))


def image_distances(diffusion_time):
    """Odd distances 2k+1: the next image, at least 2k+2 from any eta <= 1, adds less than rounding error."""
    return range(1, 2 + 2 * int(np.ceil(np.sqrt(EXPONENT * diffusion_time.max()))), 2)
