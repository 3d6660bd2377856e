"""Time integration of u' = nu A u + s(t): an L-stable Runge-Kutta method of third order with an error estimate.

ARK3(2)4L[2]SA, the implicit part: C. A. Kennedy and M. H. Carpenter, Appl. Numer. Math. 44 (2003) 139-181. One explicit
stage and three implicit ones with the same matrix 1 - gamma h nu A. It damps the stiffest modes completely, so that an
impulsively started wall needs no other method for its first steps, as Crank-Nicolson does.
"""

import numpy as np

GAMMA = 1767732205903 / 4055673282236

A = (
    (0.0, 0.0, 0.0, 0.0),
    (GAMMA, GAMMA, 0.0, 0.0),
    (2746238789719 / 10658868560708, -640167445237 / 6845629431997, GAMMA, 0.0),
    (1471266399579 / 7840856788654, -4482444167858 / 7529755066697, 11266239266428 / 11593286722821, GAMMA),
)
B = A[3]
C = (0.0, 2.0 * GAMMA, 0.6, 1.0)

B_HAT = (
    2756255671327 / 12835298489170,
    -10771552573575 / 22201958757719,
    9247589265047 / 10645013368117,
    2193209047091 / 5459859503100,
)
"""Weights of the second-order result; the difference from ``B`` estimates the error."""

EMBEDDED_ORDER = 2

DEFECT = tuple(b - b_hat for b, b_hat in zip(B, B_HAT, strict=True))


def stage_predictors():
    """Weights (4, 4) of the rates before a stage in the predicted velocities: their polynomial, integrated."""
    weights = np.zeros((4, 4))
    for stage in range(1, 4):
        powers = np.arange(stage)
        nodes = np.array(C[:stage])[:, None] ** powers
        weights[stage, :stage] = np.linalg.solve(nodes.T, C[stage] ** (powers + 1) / (powers + 1))
    return weights


def weighted(weights, values):
    """Return the sum of the ``values`` so far, numbers or arrays, each with its weight."""
    total = weights[0] * values[0]
    for weight, value in zip(weights[1:], values[1:], strict=False):
        total = total + weight * value
    return total
