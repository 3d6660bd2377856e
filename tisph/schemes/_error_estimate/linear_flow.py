"""Linear equations of the rows with the walls' and the drive's part in them, solved at any time by their eigenmodes."""

import numpy as np


class LinearFlow:
    """x' = viscosity_ratio * (matrix x + walls(t)) + drive, from the state ``start`` at ``start_time``.

    walls(t) = ``steady`` + Re sum(amplitude exp(i w t)) over ``waves``, pairs (w, amplitude). All arrays (size,),
    ``matrix`` (size, size) without an eigenvalue 0. ``mirror``: pair of arrays, for each entry of a state that in its
    place when the channel is turned upside down, and its sign then. The equations stay the same, so that even and odd
    states are solved apart: smaller matrices, which BLAS does not split over threads either.
    """

    def __init__(self, matrix, steady, waves, drive, start, start_time, mirror):
        known = np.stack([steady, drive, start, *(wave for _, wave in waves)], 1)
        frequencies = [frequency for frequency, _ in waves]
        bases = [_basis(*mirror, parity) for parity in (1.0, -1.0)]
        self.parts = [
            _Part(product(basis.T, product(matrix, basis)), product(basis.T, known), frequencies, basis)
            for basis in bases
        ]
        self.start_time = start_time

    def at(self, time, viscosity_ratio=1.0):
        """Return the state at ``time``."""
        return sum(part.at(time, self.start_time, viscosity_ratio) for part in self.parts)


class _Part:
    """The states of one parity; ``known`` (size, 3 + waves): steady part, drive, start and amplitudes."""

    def __init__(self, matrix, known, frequencies, basis):
        self.values, modes = np.linalg.eig(matrix)
        # a real wave is half of a complex one and half of its conjugate, which has other amplitudes of the modes
        solved = np.linalg.solve(modes, np.concatenate([known, np.conj(known[:, 3:])], 1).astype(complex)).T
        self.steady, self.drive, self.start = solved[:3]
        self.waves = list(zip([*frequencies, *(-one for one in frequencies)], 0.5 * solved[3:], strict=True))
        self.modes = product(basis, modes)

    def at(self, time, start_time, viscosity_ratio):
        deviation = self.start - self._particular_solution(start_time, viscosity_ratio)
        deviation = deviation * np.exp(viscosity_ratio * self.values * (time - start_time))
        return product(self.modes, self._particular_solution(time, viscosity_ratio) + deviation).real

    def _particular_solution(self, time, viscosity_ratio):
        """Amplitudes of the modes that are left after a long time."""
        state = -(self.steady + self.drive / viscosity_ratio) / self.values
        for frequency, amplitude in self.waves:
            state = state + amplitude * np.exp(1j * frequency * time) / (1j * frequency / viscosity_ratio - self.values)
        return state


def product(matrix, other):
    """Matrix times matrix or vector, not by BLAS, which splits even small ones over threads: slow where it is busy."""
    return np.einsum("ij,j...->i...", matrix, other)


def _basis(partner, sign, parity):
    """Orthonormal states (size, states) that keep, or change, their sign when the channel is turned upside down."""
    own = np.arange(len(partner))
    first = own[(own < partner) | ((own == partner) & (sign == parity))]
    basis = np.zeros((len(partner), len(first)))
    column = np.arange(len(first))
    basis[first, column] = 1.0
    basis[partner[first], column] = np.where(partner[first] == first, 1.0, parity * sign[first])
    return basis / np.linalg.norm(basis, axis=0)
