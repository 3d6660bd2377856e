"""The logarithm P of a conformation tensor A, by which A stays positive definite however the flow stretches it.

Where a fluid is stretched A grows and falls off exponentially from path to path and from step to step; its logarithm
does so linearly, and for any P the tensor A = exp P is positive definite. In two dimensions P = p 1 + E, E without
trace, of which e = (P_xx - P_yy)/2 and f = P_xy are the components, and with s^2 = e^2 + f^2

    A = exp(p) (cosh s 1 + sinh(s)/s E).

With L = grad u, its symmetric part D = (d/2) 1 + D', d the trace, and w half the vorticity,

    dp/dt = d + ...,    dE/dt = 2 w J E + 2 c D' + 2 (1 - c)/s^2 (E . D') E + ...,    c = s coth s,

J E = (-f, e), E . D' = e D'_xx + f D'_xy; relaxation R, which has the axes of A in every law, adds A^-1 R. All of these
are functions of s^2 and as smooth as A. Sources: R. Fattal and R. Kupferman, J. Non-Newtonian Fluid Mech. 123 (2004)
281-285; here without finding the axes.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

SMALL = 1e-3
"""Value of s^2 below which series are used; their truncation error is below 1e-16."""


def conformation_excess(state: Any) -> Sequence[np.ndarray]:
    """Return the components xx, xy, yy and, where there is one, zz of A - 1, of arrays (3 or 4, ...) of P."""
    half, shear = 0.5 * (state[0] - state[2]), state[1]
    grown, even, odd, _, _ = _functions(0.5 * (state[0] + state[2]), half, shear)
    return _excess(grown * even - 1.0, grown * odd, half, shear, state[3:])


def logarithm(conformation_excess: Any) -> np.ndarray:
    """Return P, arrays (3 or 4, n), of the components of A - 1."""
    xx, xy, yy, *others = conformation_excess
    mean, half = 1.0 + 0.5 * (xx + yy), 0.5 * (xx - yy)
    size = np.hypot(half, xy)
    middle = 0.5 * (np.log(mean + size) + np.log(mean - size))
    stretch = np.where(size > 0.0, np.arctanh(size / mean) / np.where(size > 0.0, size, 1.0), 1.0 / mean)
    return np.stack([middle + stretch * half, stretch * xy, middle - stretch * half, *map(np.log1p, others)])


def _excess(
    isotropic: np.ndarray, odd: np.ndarray, half: np.ndarray, shear: np.ndarray, others: Any
) -> Sequence[np.ndarray]:
    """``conformation_excess`` of A = (1 + isotropic) 1 + odd E."""
    return (isotropic + odd * half, odd * shear, isotropic - odd * half, *(np.exp(zz) - 1.0 for zz in others))


def rate(law: Any, state: Any, gradient: np.ndarray) -> Sequence[np.ndarray]:
    """Return dP/dt of a mode with this ``law`` for the components xx, xy, yx, yy of the velocity ``gradient``.

    A fifth one, zz, is that across the plane, as of axisymmetric flow.
    """
    xx, xy, yy, *others = state
    half = 0.5 * (xx - yy)
    grown, even, odd, scaled, rest = _functions(0.5 * (xx + yy), half, xy)
    relaxation = law.relaxation(_excess(grown * even - 1.0, grown * odd, half, xy, others))
    mean, slope, shear = 0.5 * (relaxation[0] + relaxation[2]), 0.5 * (relaxation[0] - relaxation[2]), relaxation[1]
    lxx, lxy, lyx, lyy, *lzz = gradient
    stretch, strain, rotation = 0.5 * (lxx - lyy), 0.5 * (lxy + lyx), lyx - lxy
    aligned = 2.0 * rest * (half * stretch + xy * strain) - odd * mean / grown
    trace = lxx + lyy + (even * mean - odd * (half * slope + xy * shear)) / grown
    first = -rotation * xy + 2.0 * scaled * stretch + aligned * half + even * slope / grown
    second = rotation * half + 2.0 * scaled * strain + aligned * xy + even * shear / grown
    beside = [rate_of_axis / np.exp(zz) for rate_of_axis, zz in zip(relaxation[3:], others, strict=True)]
    if lzz:
        beside = [rate_of_axis + 2.0 * lzz[0] for rate_of_axis in beside]
    return (trace + first, second, trace - first, *beside)


def _functions(mean: np.ndarray, half: np.ndarray, shear: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return exp(p), cosh s, sinh(s)/s, s coth s and (1 - s coth s)/s^2."""
    square = half * half + shear * shear
    small = np.abs(square) < SMALL
    root = np.sqrt(np.where(small, 1.0, square))
    up = np.exp(root)
    even, odd = 0.5 * (up + 1.0 / up), 0.5 * (up - 1.0 / up)
    q = np.where(small, square, 0.0)
    rest = -1 / 3 + q * (1 / 45 - q * (2 / 945 - q / 4725))
    scaled = np.where(small, 1.0 - q * rest, root * even / odd)
    rest = np.where(small, rest, (1.0 - scaled) / np.where(small, 1.0, square))
    ratio = np.where(small, 1.0 + q * (1 / 6 + q * (1 / 120 + q / 5040)), odd / root)
    even = np.where(small, 1.0 + q * (0.5 + q * (1 / 24 + q * (1 / 720 + q / 40320))), even)
    return np.exp(mean), even, ratio, scaled, rest
