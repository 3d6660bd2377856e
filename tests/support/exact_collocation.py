"""Chebyshev collocation across the gap: the independent solutions that the exact solutions are tested against."""

import numpy as np


def chebyshev_derivatives(count):
    """Nodes from 1 down to 0, and the collocation matrices of d/dy and d2/dy2 on them."""
    nodes = np.cos(np.pi * np.arange(count + 1) / count)
    weights = np.ones(count + 1)
    weights[[0, -1]] = 2.0
    weights *= (-1.0) ** np.arange(count + 1)
    gaps = nodes[:, None] - nodes[None, :] + np.eye(count + 1)
    first = np.outer(weights, 1 / weights) / gaps
    first -= np.diag(first.sum(axis=1))
    return (nodes + 1) / 2, 2 * first, 4 * first @ first
