"""Stress with memory point by point: its modes, and implicit equations C = K + g F(C) of a few unknowns a particle.

Those are solved side by side by Newton's method.
"""

import itertools

import numpy as np

SMALL = 1e-30
"""Imaginary step of derivatives; its square vanishes beside 1."""

MOST_ITERATIONS = 30
CONVERGED = 1e-13
"""Residual, over 1 plus the largest component, at which Newton's method is done: rounding is left."""

SLOW = 0.1
"""Part of the residual before, above which slopes that were kept are made anew."""


class Modes:
    """Laws of a fluid's modes, each with its ``part`` of the states (``components`` of all modes, ...).

    ``excess``: function that returns C = A - 1, the excess of the conformation tensor, of the state of one mode.
    ``components``: of each mode, if it is another number than that of its law.
    """

    def __init__(self, rheology, kinematic_viscosity, excess=tuple, components=None):
        self.laws, self.excess = rheology.laws(kinematic_viscosity), excess
        ends = itertools.accumulate((components or law.components for law in self.laws), initial=0)
        self.parts = [slice(first, last) for first, last in itertools.pairwise(ends)]
        self.components = self.parts[-1].stop

    def __iter__(self):
        return zip(self.laws, self.parts, strict=True)

    def stress(self, state, components=3):
        """Return S_xx, S_xy, S_yy (and S_zz) per unit density, the sums over the modes."""
        each = [law.stress(self.excess(state[part]))[:components] for law, part in self]
        return np.stack([sum(column) for column in zip(*each, strict=True)])


def solve(rate, known, duration, guess, slopes=None):
    """Solve C = ``known`` + ``duration`` ``rate``(C), arrays (numbers, n), from a ``guess``.

    ``rate`` takes real and complex arrays. Returns C and the last ``matrix``. ``slopes``: one that is near enough, used
    as long as residuals fall fast; without, Newton's method makes its own in each turn.
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


def matrix(rate, state, duration):
    """Return 1 - ``duration`` dF/dC, rows of columns of arrays."""
    size, columns = len(state), []
    for column in range(size):
        ahead = state.astype(complex)
        ahead[column] += 1j * SMALL
        slopes = [np.imag(value) / SMALL for value in rate(ahead)]
        columns.append([float(row == column) - duration * slopes[row] for row in range(size)])
    return [[columns[column][row] for column in range(size)] for row in range(size)]


def eliminate(matrix, right):
    """Solve small systems side by side, without exchanging rows: they are near 1 where time steps are sensible."""
    matrix, right = [list(row) for row in matrix], list(right)
    size = len(right)
    for k in range(size):
        inverse = 1.0 / matrix[k][k]
        for i in range(k + 1, size):
            factor = matrix[i][k] * inverse
            for j in range(k + 1, size):
                matrix[i][j] = matrix[i][j] - factor * matrix[k][j]
            right[i] = right[i] - factor * right[k]
    for k in reversed(range(size)):
        for j in range(k + 1, size):
            right[k] = right[k] - matrix[k][j] * right[j]
        right[k] = right[k] / matrix[k][k]
    return np.stack(right)
