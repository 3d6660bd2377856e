"""The error of a run from its differences to two coarser ones, and whether they fall as they should.

Errors e_i = C h_i^p of three runs of spacings h_1 > h_2 > h_3 make the differences |e_i - e_j| where they have one
shape (Richardson), and sqrt(e_i^2 + e_j^2), as norms, where they are independent, as for disordered particles, of
which those of one run are at no position of the other's. Of both models C and p are fitted to the logarithms of the
three norms 1-2, 2-3 and 1-3; that which fits better is taken. Spacings may have any ratios.

Source: P. J. Roache, J. Fluids Eng. 116 (1994) 405-413, for errors of one shape.
"""

import math
from dataclasses import dataclass

import numpy as np

PAIRS = ((0, 1), (1, 2), (0, 2))

ORDERS = 0.1, 12.0
"""Between which orders are looked for."""

ROUNDING = 1e-13
"""Differences over the size of what differs that are rounding errors."""

LARGEST_MISFIT = math.log(2.0)
"""Largest deviation of the logarithm of a difference from the fit: what the scatter of disordered runs makes of it."""


@dataclass(frozen=True)
class Extrapolation:
    """``order`` that was observed and ``error`` of the finest run, in what the differences are in.

    Where no error can be estimated, it is None and ``reason`` says why, in words; ``order`` is None where there is
    none.
    """

    order: float | None
    error: float | None
    reason: str | None = None


def of_number(spacings, values, expected, size=None):
    """Return the Extrapolation of a number with ``values`` in runs of ``spacings``, three each, from coarse to fine.

    ``expected``: smallest and largest order with which an error is estimated; ``size``: what round-off errors refer to,
    the largest value by default. The error is absolute.
    """
    first, second = values[0] - values[1], values[1] - values[2]
    size = max(map(abs, values)) if size is None else size
    if max(abs(first), abs(second)) > ROUNDING * size and first * second <= 0:
        return Extrapolation(None, None, "not monotone: it goes up and down with the spacing")
    return of_norms(spacings, [abs(values[one] - values[other]) for one, other in PAIRS], expected, size)


def of_pair(spacings, difference, expected):
    """Return the Extrapolation of the coarser of two runs of ``spacings`` from the norm of their ``difference``.

    Its order cannot be seen: that is the least of the ``expected``, with which the error is largest.
    """
    if not math.isfinite(difference):
        return Extrapolation(None, None, "not a number in one of the runs")
    return Extrapolation(None, float(difference / (1.0 - (spacings[1] / spacings[0]) ** expected[0])))


def of_norms(spacings, norms, expected, size=1.0, order=None):
    """Return the Extrapolation of a field from the ``norms`` of its differences 1-2, 2-3 and 1-3.

    With an ``order`` the error is that at this one, be the observed one what it may in between ``expected``: that of
    one field at one time scatters.
    """
    if not np.isfinite(norms).all():
        return Extrapolation(None, None, "not a number in one of the runs")
    if max(norms) <= ROUNDING * size:
        return Extrapolation(None, None, "the runs agree but for rounding")
    if not norms[0] > norms[1] > 0.0:
        return Extrapolation(None, None, "does not converge: the finer two runs differ no less than the coarser two")
    observed, misfit, model = _fitted(np.asarray(spacings), np.asarray(norms))
    reason = None
    if misfit > LARGEST_MISFIT:
        reason = "no one order: the three differences do not fit a power of the spacing"
    elif not expected[0] <= observed <= expected[1]:
        reason = f"order {observed:.2g} where {expected[0]:g} to {expected[1]:g} is to be expected"
    if reason:
        return Extrapolation(observed, None, reason)
    scale, _ = _scale(np.asarray(spacings), np.asarray(norms), order or observed, model)
    return Extrapolation(observed, scale * (spacings[2] / spacings[0]) ** (order or observed))


def _fitted(spacings, norms):
    """Order and misfit of the model that fits better, and that model."""
    from scipy.optimize import minimize_scalar

    def misfit(order, model):
        return float(np.sum(_scale(spacings, norms, order, model)[1] ** 2))

    found = []
    for model in (np.subtract, np.hypot):
        order = float(minimize_scalar(misfit, bounds=ORDERS, args=(model,), options={"xatol": 1e-9}).x)
        found.append((np.abs(_scale(spacings, norms, order, model)[1]).max(), order, model))
    most, order, model = min(found, key=lambda each: each[0])
    return order, float(most), model


def _scale(spacings, norms, order, model):
    """Error of the coarsest run that fits the ``norms`` best, and the residual of their logarithms."""
    errors = (spacings / spacings[0]) ** order
    left = np.log(norms) - np.log([model(errors[one], errors[other]) for one, other in PAIRS])
    return float(np.exp(left.mean())), left - left.mean()
