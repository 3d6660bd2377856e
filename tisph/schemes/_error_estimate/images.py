"""What is beyond the walls of the start lattice, row by row: images = ``wall`` * U - ``mirrored`` @ u + d^2 u_yy.

Row k of the images is at the depth d = (k + 1/2) spacings beyond a wall with velocity U, u are the rows of fluid from
that wall on; u_yy is what treatments that obey the momentum equation take from that.
"""

import math

import numpy as np


def image_shares(treatment, kernel, ratio, layers, rows):
    """Arrays ``mirrored`` (layers, rows) and ``wall`` (layers,) of a treatment's parameters, in scheme ``wcsph``."""
    if treatment.type == "fixed_image":
        return _extrapolated(layers, rows, treatment.least_distance)
    if treatment.type == "adami":
        return _averaged(kernel, ratio, layers, rows)
    if treatment.type == "virtual_image":
        return _fitted(kernel, ratio, layers, rows)
    return mirrored(layers, rows)


def mirrored(layers, rows):
    """Mirror images of the rows."""
    return np.eye(layers, rows), np.full(layers, 2.0)


def _extrapolated(layers, rows, least_distance):
    """Linear extrapolation from the row at the wall."""
    steps = (np.arange(layers) + 0.5) / max(0.5, least_distance)
    shares = np.zeros((layers, rows))
    shares[:, 0] = steps
    return shares, 1.0 + steps


def _averaged(kernel, ratio, layers, rows):
    """Kernel averages; an image without fluid in reach moves with the wall."""
    weights = np.array([_row_weights(kernel, ratio, k + 1.0 + np.arange(rows)) for k in range(layers)])
    totals = weights.sum(axis=1)
    return weights / np.where(totals > 0.0, totals, 1.0)[:, None], np.where(totals > 0.0, 2.0, 1.0)


def _fitted(kernel, ratio, layers, rows):
    """Linear fits around the mirror points."""
    shares = []
    for layer in range(layers):
        apart = np.arange(rows) - float(layer)
        weights = _row_weights(kernel, 0.75 * ratio, apart)
        total, first, second = (float(np.sum(weights * apart**power)) for power in range(3))
        determinant = total * second - first * first
        linear = determinant > 1e-6 * total**2
        shares.append(weights * (second - first * apart) / determinant if linear else weights / max(total, 1e-30))
    return np.array(shares), np.full(layers, 2.0)


def _row_weights(kernel, ratio, heights):
    """Sums of the kernel over the rows at ``heights`` from a point above one of their particles."""
    reach = math.ceil(kernel.SUPPORT * ratio)
    return np.array(
        [sum(kernel.value(math.hypot(x, height) / ratio) for x in range(-reach, reach + 1)) for height in heights]
    )
