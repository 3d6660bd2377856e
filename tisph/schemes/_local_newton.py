"""Viscoelastic stress point by point: the modes of a fluid, and implicit equations C = K + g F(C) of each particle.

These equations have a few unknowns a particle. Newton's method solves the equations of all particles side by side.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

SMALL = 1e-30
"""Imaginary step of derivatives; its square vanishes beside 1."""

MOST_ITERATIONS = 30
CONVERGED = 1e-13
"""Residual, over 1 plus the largest component, at which Newton's method ends: round-off remains."""

SLOW = 0.1
"""Factor by which the residual of an iteration must fall; else a Jacobian from before is computed anew."""


class Modes:
    """Laws of the modes of a fluid, each with its ``part`` of the states (``components`` of all modes, ...).

    ``excess``: function of the state of one mode that returns C = A - 1, the excess of the conformation tensor.
    ``components``: number of states of each mode, if it is not the number of its law.
    """

    def __init__(
        self,
        rheology: Any,
        kinematic_viscosity: float,
        excess: Callable[[Any], Sequence[Any]] = tuple,
        components: int | None = None,
    ) -> None:
        self.laws, self.excess = rheology.laws(kinematic_viscosity), excess
        ends = itertools.accumulate((components or law.components for law in self.laws), initial=0)
        self.parts = [slice(first, last) for first, last in itertools.pairwise(ends)]
        self.components: int = self.parts[-1].stop

    def __iter__(self) -> Iterator[tuple[Any, slice]]:
        return zip(self.laws, self.parts, strict=True)

    def stress(self, state: np.ndarray, components: int = 3) -> np.ndarray:
        """Return S_xx, S_xy, S_yy (and S_zz) per unit density, the sums over the modes."""
        each = [law.stress(self.excess(state[part]))[:components] for law, part in self]
        return np.stack([sum(column) for column in zip(*each, strict=True)])


def solve(
    rate: Callable[[Any], Any], known: np.ndarray, duration: float, guess: np.ndarray, slopes: Any = None
) -> tuple[np.ndarray, Any]:
    """Solve C = ``known`` + ``duration`` ``rate``(C), arrays (components, n), from a ``guess``.

    ``rate`` takes real and complex arrays. Returns C and the last ``matrix``. ``slopes``: a matrix from before, used as
    long as residuals fall fast; without one, each iteration computes its own.
    """
    state, kept, last = guess.copy(), slopes is not None, np.inf
    for _ in range(MOST_ITERATIONS):
        residual = known + duration * np.stack(rate(state)) - state
        left = np.abs(residual).max()
        if slopes is not None and not left > CONVERGED * (1.0 + np.abs(state).max()):
            break
        if not (kept and left < SLOW * last):
            slopes = matrix(rate, state, duration)
        state += eliminate(slopes, residual)
        last = left
    return state, slopes


def matrix(rate: Callable[[Any], Any], state: np.ndarray, duration: float) -> list[list[Any]]:
    """Return 1 - ``duration`` dF/dC: rows of columns of arrays (n,)."""
    size, columns = len(state), []
    for column in range(size):
        ahead = state.astype(complex)
        ahead[column] += 1j * SMALL
        slopes = [np.imag(value) / SMALL for value in rate(ahead)]
        columns.append([float(row == column) - duration * slopes[row] for row in range(size)])
    return [[columns[column][row] for column in range(size)] for row in range(size)]


def eliminate(matrix: Sequence[Sequence[Any]], right: Any) -> np.ndarray:
    """Solve small systems side by side, without exchanging rows: they are near 1 where time steps are sensible."""
    rows, right = [list(row) for row in matrix], list(right)
    size = len(right)
    for k in range(size):
        inverse = 1.0 / rows[k][k]
        for i in range(k + 1, size):
            factor = rows[i][k] * inverse
            for j in range(k + 1, size):
                rows[i][j] = rows[i][j] - factor * rows[k][j]
            right[i] = right[i] - factor * right[k]
    for k in reversed(range(size)):
        for j in range(k + 1, size):
            right[k] = right[k] - rows[k][j] * right[j]
        right[k] = right[k] / rows[k][k]
    return np.stack(right)
