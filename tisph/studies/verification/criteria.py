"""What runs are held to: a bound on an error, nearness to another run or a share of its error, an order of
convergence, equal results, a momentum balance that closes.

A criterion names the runs that it needs and judges their results as a ``Check``. A run that stopped early
lacks samples: its checks fail, with the value NaN.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tisph.measures.metrics import fitted_order


@dataclass(frozen=True)
class Check:
    """One line of the verification table; ``value`` is NaN where the runs gave none."""

    case: str
    quantity: str
    value: float
    bound: str
    passed: bool


@dataclass(frozen=True)
class Criterion:
    """A number, computed from the results of ``runs`` (names), and the values of it that pass."""

    case: str
    quantity: str
    bound: str
    runs: tuple[str, ...]
    value: Callable[..., float]
    accepts: Callable[[float], bool]

    def judge(self, *results):
        """Check of the ``Result`` of each of ``runs``, in their order."""
        value = float(self.value(*results))
        return Check(self.case, self.quantity, value, self.bound, bool(self.accepts(value)))


def at_most(case, t_star, quantity, bound):
    """The sample's number ``quantity`` is at most ``bound`` at dimensionless time ``t_star``."""
    return bounded(case, f"{quantity} at t* = {t_star:g}", bound, lambda result: result.measure(t_star, quantity))


def at_least(case, t_star, quantity, bound):
    """The sample's number ``quantity`` is at least ``bound`` at dimensionless time ``t_star``."""
    quantity_at = f"{quantity} at t* = {t_star:g}"
    return bounded(case, quantity_at, bound, lambda result: result.measure(t_star, quantity), sign=">=")


def closes(case, bound):
    """The momentum balance of the whole run closes within the fraction ``bound``."""
    return bounded(case, "momentum closure", bound, lambda result: result.closure)


def steps_at_most(case, bound, t_star):
    """The sample at dimensionless time ``t_star`` comes after at most ``bound`` steps."""
    return bounded(case, f"steps to t* = {t_star:g}", bound, lambda result: result.measure(t_star, "step"))


def ends_at(case, quantity, expected, bound, value):
    """``value(result)`` of the whole run, called ``quantity``, is ``expected`` within the fraction ``bound``."""
    return of_whole_runs(case, f"{quantity} off {expected:g}", bound, lambda result: abs(value(result) / expected - 1))


def ends_as(case, reference, quantity, bound, value):
    """``value(result)`` of the whole run is that of the run ``reference`` within the fraction ``bound``."""

    def off(ours, other):
        return abs(value(ours) / value(other) - 1)

    return of_whole_runs(case, f"{quantity} off {reference}", bound, off, (case, reference))


def near(case, reference, t_star, tolerance, quantity="l2"):
    """The error is that of the run ``reference`` at the same t*, within a relative ``tolerance``."""

    def off(ours, other):
        return abs(ours.measure(t_star, quantity) / other.measure(t_star, quantity) - 1)

    return bounded(case, f"{quantity} off {reference} at t* = {t_star:g}", tolerance, off, (case, reference))


def share(case, reference, t_star, bound, quantity="l2"):
    """The error over that of the run ``reference`` at the same t* is at most ``bound``."""

    def ratio(ours, other):
        return ours.measure(t_star, quantity) / other.measure(t_star, quantity)

    return bounded(case, f"{quantity} over {reference}'s at t* = {t_star:g}", bound, ratio, (case, reference))


def order(case, resolutions, t_star, bound, quantity="l2"):
    """The error falls with at least the power ``bound`` of the spacing: a fit over all resolutions.

    ``resolutions`` maps run names to particles across the gap.
    """

    def fitted(*results):
        return fitted_order(resolutions.values(), [result.measure(t_star, quantity) for result in results])

    return bounded(case, f"{quantity} order at t* = {t_star:g}", bound, fitted, tuple(resolutions), sign=">=")


def order_of(error, case, quantity, resolutions, bound):
    """The same of an ``error(result)`` of whole runs."""

    def fitted(*results):
        return fitted_order(resolutions.values(), [error(result) for result in results])

    return of_whole_runs(case, quantity, bound, fitted, tuple(resolutions), sign=">=")


def same_velocities(case, reference, bound):
    """Every particle has the velocity (u, v)/U of the run ``reference`` at every sample, within ``bound``."""

    def velocities(result):
        arrays = result.arrays().items()
        return {key: array / result.reference_velocity for key, array in arrays if key.endswith(("/u", "/v"))}

    def largest_difference(ours, other):
        arrays, others = velocities(ours), velocities(other)
        if not arrays or arrays.keys() != others.keys():
            return math.nan
        return max(np.max(np.abs(arrays[key] - others[key])) for key in arrays)

    return bounded(case, f"velocities off {reference}", bound, largest_difference, (case, reference))


def same_bits(case, reference):
    """Every array in ``samples.h5`` is bitwise equal to that in the run ``reference``."""

    def differing_arrays(ours, other):
        arrays, others = ours.arrays(), other.arrays()
        if not arrays or arrays.keys() != others.keys():
            return math.nan
        return sum(arrays[key].tobytes() != others[key].tobytes() for key in arrays)

    return bounded(case, f"arrays that differ from {reference}", 0, differing_arrays, (case, reference), sign="=")


def of_whole_runs(case, quantity, bound, value, runs=None, sign="<="):
    """As ``bounded``; the value is NaN where one of the runs stopped early."""

    def whole(*results):
        return value(*results) if all(result.last for result in results) else math.nan

    return bounded(case, quantity, bound, whole, runs, sign)


def bounded(case, quantity, bound, value, runs=None, sign="<="):
    """The ``Criterion`` that ``value`` of the ``runs``, of ``case`` alone if not given, is beside ``bound``."""

    def accepts(number):
        return {"<=": number <= bound, ">=": number >= bound, "=": number == bound}[sign]

    return Criterion(case, quantity, f"{sign} {bound:g}", runs or (case,), value, accepts)
