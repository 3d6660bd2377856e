"""What the implicit step needs beside derivatives: image stresses, and polynomial fits to the fluid near a wall."""

import numpy as np

TERMS = 3
"""Of the polynomial in the wall distance that describes the fluid near a wall."""

EVEN_POWERS = (0, 2, 4)
"""Of the wall distance, in what is fitted for a value at a stress-controlled wall."""


def stress_excess(depth, side, even_reflection, slope, third):
    """Return what images at a ``depth`` beyond the lower (``side`` 0) or upper wall have of S_xy beside their sources'.

    By its first and third derivatives along y at the wall; beyond one with even reflection by the stress there and its
    second derivative.
    """
    if even_reflection:
        return 2.0 * slope + depth**2 * third
    return (1.0 if side == 0 else -1.0) * (depth * (-2.0 * slope - depth**2 / 3.0 * third))


def polynomial_fit(distance, values, radius):
    """Return coefficients (TERMS, quantities) in the wall ``distance`` (n,) of what is nearer than ``radius``.

    Of the least-squares fit to ``values`` (n, quantities).
    """
    near = distance < radius
    powers = (distance[near, None] / radius) ** np.arange(TERMS)
    return np.linalg.lstsq(powers, values[near], rcond=None)[0] / radius ** np.arange(TERMS)[:, None]


def even_fit(distance, radius):
    """Return which points at a wall ``distance`` (n,) are within ``radius``, and their weights in the value there.

    That is the value of the even polynomial that fits best.
    """
    near = np.flatnonzero(distance < radius)
    return near, np.linalg.pinv((distance[near, None] / radius) ** np.array(EVEN_POWERS))[0]
