"""Operators on the start lattice, where the velocity depends on the row alone: weights of the rows around a row.

Lengths are in particle spacings. Rows are -reach .. reach from the one whose operator it is.
"""

import math

import numpy as np

from tisph.least_squares import SUPPORT

SHIFTS = 8
"""Places of sliding rows over one another, over which their viscosity is averaged."""


def banded(weights, rows):
    """Return the operator (rows, images + rows + images) of a row's ``weights``, as many images as these reach.

    It takes differences from the row itself.
    """
    images = len(weights) // 2
    matrix = np.zeros((rows, rows + 2 * images))
    for row in range(rows):
        matrix[row, row : row + len(weights)] = weights
        matrix[row, row + images] -= weights.sum()
    return matrix


def least_squares(order):
    """Weights (rows,) of the Laplacian and of the derivative across, of the least-squares rows of ``order``."""
    support = SUPPORT[order]
    y, x = _neighbours(support)
    powers = [(a, degree - a) for degree in range(1, order + 1) for a in range(degree + 1)]
    basis = np.stack([(x / support) ** a * (y / support) ** b for a, b in powers], 1)
    weights = (1.0 - (x * x + y * y) / support**2) ** 4
    wanted = np.zeros((len(powers), 2))
    wanted[powers.index((2, 0)), 0] = wanted[powers.index((0, 2)), 0] = 2.0 / support**2
    wanted[powers.index((0, 1)), 1] = 1.0 / support
    entries = weights[:, None] * (basis @ np.linalg.solve(basis.T @ (weights[:, None] * basis), wanted))
    return tuple(_by_row(y, one, int(support)) for one in entries.T)


def kernel_sums(kernel, ratio, standard):
    """Weights (rows,) of the Laplacian and of the derivative across, of the operators of scheme ``wcsph``.

    ``kernel`` is a module of ``kernels/``, ``ratio`` smoothing length over spacing; ``standard`` operators are those
    of that name, else the consistent ones.
    """
    reach = kernel.SUPPORT * ratio
    y, x = _neighbours(reach)
    weights, squares = _pair_weights(kernel, ratio, x, y), x * x + y * y
    if standard:
        laplacian = 2.0 / ratio**4 * weights * squares / (squares + 0.01 * ratio**2)
    else:
        laplacian = 4.0 * weights / np.sum(weights * squares)
    across = weights * y / np.sum(weights * y * y)
    return tuple(_by_row(y, one, int(reach)) for one in (laplacian, across))


def sliding_viscosity(kernel, ratio, slide):
    """Viscosity of the consistent operators over the true one, while rows slide by up to ``slide`` over the next.

    Their Laplacian is normalised by the trace of the second moment of the weights; of a flow along the rows it takes
    the part across, which is half of it on a square lattice alone.
    """
    y, x = _neighbours(kernel.SUPPORT * ratio, wide=True)
    inside, parts = kernel.SUPPORT * ratio, []
    for shift in min(slide, 1.0) * (np.arange(SHIFTS) + 0.5) / SHIFTS:
        sheared = x + shift * y
        near = sheared**2 + y * y < inside**2
        weights = _pair_weights(kernel, ratio, sheared[near], y[near])
        along, across = np.sum(weights * sheared[near] ** 2), np.sum(weights * y[near] ** 2)
        parts.append(2.0 * across / (along + across))
    return float(np.mean(parts))


def _neighbours(reach, wide=False):
    """Places (y, x) of the lattice around one of its points and nearer than ``reach``, or ``wide`` enough to shear."""
    most = int(reach)
    sideways = most * (2 if wide else 1) + 1
    y, x = (axis.ravel() for axis in np.mgrid[-most : most + 1.0, -sideways : sideways + 1.0])
    near = (y != 0) | (x != 0)
    if not wide:
        near &= x * x + y * y < reach * reach
    return y[near], x[near]


def _pair_weights(kernel, ratio, x, y):
    return np.array([kernel.slope_over_q(math.sqrt(square) / ratio) for square in (x * x + y * y).tolist()])


def _by_row(y, entries, reach):
    return np.bincount((y + reach).astype(int), weights=entries, minlength=2 * reach + 1)
