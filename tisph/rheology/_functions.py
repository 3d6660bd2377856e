"""Functions that take NumPy arrays, numbers and Taichi expressions alike."""

import numpy as np


def exp(x):
    """The exponential function."""
    if isinstance(x, (np.ndarray, np.number, float, complex)):
        return np.exp(x)
    from tisph.runtime import ti  # an expression in a kernel: Taichi is there already

    return ti.exp(x)
