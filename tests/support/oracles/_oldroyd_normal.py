"""Normal stress of the flow in ``_oldroyd_start``: an integral over the history, by panels that are kept.

In the units of that module, X = S_xx/(density velocity^2), S_yy = 0:

    E X_T + X = 2 E u_eta S,    X(eta, T) = X(eta, 0) exp(-T/E) + 2 int_0^T exp(-(T - s)/E) u_eta S ds

At a wall whose velocity jumps u_eta starts as 1/sqrt(s), and it reaches the height d above the wall at s = d^2/b:
hence Gauss-Legendre points in sqrt(s) on panels [16^j, 16^(j+1)], cut into parts where shear waves or relaxation are
faster. Panels do not depend on T: a second time costs only what is new, and no result depends on what was asked before.
"""

from functools import lru_cache

import numpy as np

from oracles import _chebyshev
from oracles._oldroyd_start import DECAY, profiles_at

HEIGHTS = 257
"""Chebyshev points across the gap; near a wall that jumps X goes as d^2 log d, which they resolve to 1e-9 of X."""

LEVELS = 9
"""Panels down to 16^-LEVELS of the time; below, one more. It holds at most 4^-LEVELS of X and misses a part of it."""

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(12)


def normal_stress_at(problem, eta, time):
    """X at heights ``eta`` (heights,) at one ``time`` >= 0, shape (heights,)."""
    fraction, elasticity = problem.solvent_fraction, problem.elasticity
    start = 2 * elasticity * (1 - fraction) * problem.before.slope(eta) ** 2
    if time == 0 or fraction == 1:
        return start
    history = np.zeros(HEIGHTS)
    for begin, end in _parts(fraction, elasticity, time):
        if end <= time:
            history += np.exp((end - time) / elasticity) * _kept(problem, begin, end)
        else:
            history += _integral(problem, begin, time)
    return start * np.exp(-time / elasticity) + _chebyshev.evaluate(_chebyshev.coefficients(history), eta)


def _parts(fraction, elasticity, time):
    """Intervals (begin, end) that cover what ``time`` remembers; the last one contains ``time``."""
    newest = int(np.floor(np.log(time) / np.log(16)))
    oldest = newest - LEVELS
    remembered = time - DECAY * elasticity
    if remembered < 16.0**oldest:
        yield 0.0, 16.0**oldest
    for level in range(oldest, newest + 1):
        # shear waves, of speed sqrt((1 - b)/E), arrive with fronts that sqrt(2 b E s) of time has smoothed
        longest = min(3.5 * np.sqrt(fraction * elasticity * 16.0**level), 4 * elasticity)
        roots = 4.0**level * np.linspace(1, 4, 1 + int(np.ceil(16.0 ** (level + 1) / longest)))
        edges = roots**2
        wanted = (edges[1:] > remembered) & (edges[:-1] < time)
        yield from zip(edges[:-1][wanted].tolist(), edges[1:][wanted].tolist(), strict=True)


@lru_cache(maxsize=4096)
def _kept(problem, begin, end):
    return _integral(problem, begin, end)


def _integral(problem, begin, end):
    """2 int exp(-(end - s)/E) u_eta S ds over one part, at the Chebyshev points."""
    half = (np.sqrt(end) - np.sqrt(begin)) / 2
    total = np.zeros(HEIGHTS)
    for point, weight in zip(POINTS, WEIGHTS, strict=True):
        root = np.sqrt(begin) + half * (1 + point)
        _, slope, stress = profiles_at(problem, _chebyshev.points(HEIGHTS), root**2)
        total += 4 * weight * half * root * np.exp((root**2 - end) / problem.elasticity) * slope * stress
    return total
