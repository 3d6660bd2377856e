"""Interpolation in 0 <= eta <= 1 through Chebyshev points, which lie closest together at the walls.

Source: L. N. Trefethen, Approximation Theory and Approximation Practice, chapters 2 to 4.
"""

import numpy as np
from numpy.polynomial.chebyshev import chebval


def points(count):
    """The ``count`` points (1 - cos(pi k/(count - 1)))/2, upwards from 0 to 1, shape (count,)."""
    return np.sin(np.linspace(0.0, np.pi / 2, count)) ** 2


def coefficients(values):
    """Chebyshev coefficients of the polynomial through ``values`` (..., count) at ``points(count)``.

    By the Fourier transform of their even continuation around the circle; SciPy has a cosine transform, and takes a
    quarter of a second to import.
    """
    around = np.concatenate([values[..., ::-1], values[..., 1:-1]], axis=-1)
    scaled = np.fft.rfft(around).real / (values.shape[-1] - 1)
    scaled[..., [0, -1]] /= 2
    return scaled


def resolved(series, tolerance):
    """Whether the last tenth of the coefficients ``series`` (..., count) is below tolerance * the largest."""
    size = np.abs(series)
    tail = size[..., -(series.shape[-1] // 10) :]
    return bool(np.all(tail.max(axis=-1) <= tolerance * size.max(axis=-1)))


def evaluate(series, eta):
    """Values (..., heights) at ``eta`` (heights,) of the polynomials with coefficients ``series`` (..., count)."""
    return chebval(2 * eta - 1, np.moveaxis(series, -1, 0))
