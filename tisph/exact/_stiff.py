"""Stiff equations in time to many digits: collocation at Radau points of sqrt(t), dense between the steps.

dX/dt = f(X, t) with s = sqrt(t), in which flows are smooth that start with a layer sqrt(t) deep. In each step X is the
polynomial of degree ``stages`` in s that meets the equation at the Radau points of the step: an implicit Runge-Kutta
method, L-stable, of order 2 stages - 1 at the steps' ends and stages + 1 between. Newton's method finds its stages,
with one Jacobian a step; the eigenvectors of the method's matrix, which the weight dt/ds = 2 s is part of, take the
stages apart. The last Legendre coefficient of each step's polynomial is kept below ``tolerance`` of the largest value.

The steps depend on the equations alone, not on what is asked. Source: E. Hairer and G. Wanner, Solving Ordinary
Differential Equations II, sections IV.5 and IV.8 (method, Newton's method).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from tisph.errors import UnsolvedError
from tisph.exact._elements import barycentric_weights, interpolation

ITERATIONS = 12
LARGEST_GROWTH, LEAST_GROWTH = 2.0, 0.2
SAFETY = 0.85
MOST_STEPS = 4_000
ROUNDING = 10.0
"""Of the tolerance: what may be left where Newton's method comes no nearer."""


@dataclass(frozen=True)
class Method:
    """``points`` (stages,) of a step, on (0, 1], and the ``matrix`` of integrals from 0 to each of their polynomial.

    ``nodes``: 0 and the points, with their barycentric ``weights``; ``last``: what takes increments at the points to
    their last Legendre coefficient.
    """

    points: np.ndarray
    matrix: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    last: np.ndarray


@lru_cache
def radau(stages):
    """The Method of Radau's points."""
    left, right = legendre.Legendre.basis(stages - 1), legendre.Legendre.basis(stages)
    x = np.sort((right - left).roots().real)
    x[-1] = 1.0
    values = legendre.legvander(x, stages)
    integrals = np.empty((stages, stages))
    integrals[:, 0] = (x + 1) / 2
    for k in range(1, stages):
        integrals[:, k] = (values[:, k + 1] - values[:, k - 1]) / (2 * k + 1) / 2
    points = (x + 1) / 2
    nodes = np.concatenate([[0.0], points])
    last = np.linalg.inv(legendre.legvander(2 * nodes - 1, stages))[-1, 1:]
    return Method(points, integrals @ np.linalg.inv(values[:, :stages]), nodes, barycentric_weights(nodes), last)


class RadauSolution:
    """The solution of ``equations`` from ``start`` (size,) at t = 0 on; as far as it has been asked for.

    More ``stages`` take longer steps, where the solution has as many derivatives and Newton's method goes as far.
    ``equations`` has ``rates(states, forcing(times))`` with states (stages, size), ``scales(states)`` (size,), what 1
    is in the tolerance, and ``jacobian(state, time)``, an object whose ``solver(shifts)`` solves (shift - J) x = b for
    all shifts at once. Raises UnsolvedError where Newton's method finds no step of any length.
    """

    def __init__(self, equations, start, first_step, tolerance, stages):
        self.equations, self.tolerance, self.method = equations, tolerance, radau(stages)
        self.begins, self.lengths, self.pieces = [], [], []
        self.root, self.next_length, self.state = 0.0, first_step, np.array(start, dtype=float)
        self.largest = np.zeros(len(self.state))

    def at(self, time):
        """State (size,) at one ``time`` >= 0."""
        root = np.sqrt(time)
        while self.root < root or not self.pieces:
            self._step()
        k = max(int(np.searchsorted(self.begins, root, side="right")) - 1, 0)
        local = np.array([(root - self.begins[k]) / self.lengths[k]])
        return (interpolation(self.method.nodes, local, self.method.weights) @ self.pieces[k])[0]

    def _step(self):
        if len(self.pieces) >= MOST_STEPS:
            raise UnsolvedError(f"the reference came no further than t = {self.root**2:g} in {MOST_STEPS} steps")
        length, smooth, before = self.next_length, True, np.inf
        while True:
            found = self._stages(length, smooth)
            if found is None:
                length, smooth = length / 3, False
                if length < 1e-14 * max(self.root, self.next_length):
                    raise UnsolvedError(f"the equations have no solution that goes on after t = {self.root**2:g}")
                continue
            scales = np.maximum(self.largest, self.equations.scales(self.state + found))
            error = np.max(np.abs(self.method.last @ found) / scales)
            factor = SAFETY * (self.tolerance / max(error, 1e-300)) ** (1 / len(self.method.points))
            if error <= self.tolerance:
                break
            if error > before / 2 and error < ROUNDING * self.tolerance:
                factor = 1.0  # a shorter step is no better: these are rounding errors
                break
            length, before = length * max(min(factor, 0.9), LEAST_GROWTH), error
        self.largest = scales
        self.pieces.append(np.concatenate([self.state[None], self.state + found]))
        self.begins.append(self.root)
        self.lengths.append(length)
        self.state, self.root = self.state + found[-1], self.root + length
        self.next_length = length * min(max(factor, LEAST_GROWTH), LARGEST_GROWTH if smooth else 1.0)

    def _stages(self, length, extrapolate):
        """Increments (stages, size) of the stages of a step, None where Newton's method does not find them."""
        points, nodes = self.method.points, self.method.nodes
        roots = self.root + length * points
        inverse = np.linalg.inv(self.method.matrix * (2 * roots)) / length
        found = np.zeros((len(points), len(self.state)))
        if extrapolate and self.pieces:
            found = interpolation(nodes, 1 + points * length / self.lengths[-1]) @ self.pieces[-1] - self.state
        with np.errstate(all="ignore"):  # what is no number is no step
            return self._newton(found, roots**2, inverse)

    def _newton(self, found, times, inverse):
        values, vectors = np.linalg.eig(inverse)
        backwards = np.linalg.inv(vectors)
        kept = np.flatnonzero(values.imag >= 0)
        middle = len(times) // 2
        jacobian = self.equations.jacobian(self.state + found[middle], times[middle])
        if jacobian is None:
            return None
        solve, forcing = jacobian.solver(values[kept]), self.equations.forcing(times)
        into, out = backwards[kept], vectors[:, kept] * (1 + (values[kept].imag > 0))
        before = np.inf
        for _ in range(ITERATIONS):
            residual = self.equations.rates(self.state + found, forcing) - inverse @ found
            change = (out @ solve(into @ residual)).real
            found = found + change
            scales = np.maximum(self.largest, self.equations.scales(self.state + found))
            size = np.max(np.abs(change) / scales)
            if not size < 2 * before:
                return None
            stalled = size > before / 3  # rounding errors, of a fluid that is nearly solid somewhere, remain
            if size < (ROUNDING if stalled else 0.02) * self.tolerance:
                return found
            before = size
        return None
