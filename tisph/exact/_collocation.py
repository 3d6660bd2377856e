"""Polynomials across a gap and in time: spectral elements, and collocation at Radau points in sqrt(t).

The elements have Legendre-Gauss-Lobatto points, and fields are continuous where elements meet.
``count`` elements of one ``order`` p between ``edges`` (count + 1,), which may be as close together as a layer at a
wall needs. Continuous fields, such as a velocity, have one value a node, (..., count p + 1); others, such as a stress,
have values of their own in each element, (..., count, p + 1). Integrals by the rule of the same points make the mass
diagonal: an equation in time stays one.

Around an axis the continuous field v is the angular velocity u/r, along an axis and between planes it is u itself:

    around   r^3 dv/dt = d/dr (r^2 stress),   shear rate r dv/dr
    along    r dv/dt = d/dr (r stress),       shear rate dv/dr

In all flows r^power dv/dt = d/dy (r^power/lever stress) and u = lever v, of the shear rate lever dv/dy: ``power`` is 3,
1 or 0 and the lever r, 1 or 1. An axis, r = 0, within the fluid has no mass: there the flux of momentum is 0, and v is
regular.

In time dX/dt = f(X, t) is stiff; in s = sqrt(t) flows are smooth that start with a layer sqrt(t) deep. In each step X
is the polynomial of degree ``stages`` in s that meets the equation at the Radau points of the step: an implicit
Runge-Kutta method, L-stable, of order 2 stages - 1 at the steps' ends and stages + 1 between. Newton's method solves
for its stages, with one Jacobian a step; the eigenvectors of the method's matrix, which the weight dt/ds = 2 s is part
of, decouple the stages. The last Legendre coefficient of each step's polynomial is kept below ``tolerance`` of the
largest value. The steps depend on the equations alone, not on the times that are asked for.

Sources: C. Canuto, M. Y. Hussaini, A. Quarteroni and T. A. Zang, Spectral Methods: Fundamentals in Single Domains
(2006), chapters 1 to 3; E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.polynomial.legendre import Legendre

from tisph.errors import UnsolvedError

AXIS_MASS = 1e-10
"""Mass of a node on an axis over the mass of the next node, in place of 0, which would leave an algebraic equation."""


def barycentric_weights(points: np.ndarray) -> np.ndarray:
    """Return the weights of barycentric interpolation through distinct ``points`` (n,)."""
    gaps = points[:, None] - points[None, :]
    np.fill_diagonal(gaps, 1.0)
    return 1 / gaps.prod(axis=1)


def interpolation(points: np.ndarray, x: Any, weights: np.ndarray | None = None) -> np.ndarray:
    """Return the matrix (len(x), n) that interpolates values at ``points`` (n,) to ``x`` by their polynomial.

    ``weights``: the ``barycentric_weights``, where they are known.
    """
    distance = x[:, None] - points[None, :]
    hit = distance == 0
    ratios = (barycentric_weights(points) if weights is None else weights) / np.where(hit, 1.0, distance)
    matrix = ratios / ratios.sum(axis=1, keepdims=True)
    return np.where(hit.any(axis=1, keepdims=True), hit.astype(float), matrix)


def lobatto(order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the Lobatto points (order + 1,) on [-1, 1], their quadrature weights, and their differentiation matrix."""
    inner = np.sort(Legendre.basis(order).deriv().roots().real)
    points = np.concatenate([[-1.0], (inner - inner[::-1]) / 2, [1.0]])  # symmetric to the last bit
    weights = 2 / (order * (order + 1) * Legendre.basis(order)(points) ** 2)
    bary = barycentric_weights(points)
    gaps = points[:, None] - points[None, :] + np.eye(order + 1)
    derivative = bary[None, :] / bary[:, None] / gaps
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return points, weights, derivative


class Elements:
    """Elements between ``edges``, all of one ``order``; the edges are distances from a plane, or from a cylinder.

    ``inner_radius``: radius of the cylinder, 0 for an axis, None for a plane. ``along``: whether the flow is along it.
    """

    def __init__(
        self, edges: np.ndarray, order: int, inner_radius: float | None | None = None, along: bool = False
    ) -> None:
        self.edges = np.asarray(edges, dtype=float)
        self.order, self.count = order, len(self.edges) - 1
        self.points, self.weights, self.matrix = lobatto(order)
        self.half_width = np.diff(self.edges)[:, None] / 2
        self.nodes = order * np.arange(self.count)[:, None] + np.arange(order + 1)
        self.size = self.count * order + 1
        self.y = self.edges[:-1, None] + self.half_width * (self.points + 1)
        self.inner_radius, self.power = inner_radius, 0 if inner_radius is None else 1 if along else 3
        self.radii, self.levers = self.radius(self.y), self.lever(self.y)
        self.fluxes = self.weights * self.radii ** min(self.power, 2)
        self._slopes = (self.matrix[:, :, None] * self.matrix[:, None, :]).reshape(order + 1, -1)
        self.node_positions = np.append(self.y[:, :-1].ravel(), self.edges[-1])
        self.mass = self.assembled(self.half_width * self.weights * self.radii**self.power)
        if self.inner_radius == 0.0:
            self.mass[0] = AXIS_MASS * self.mass[1]
        self._places: tuple[np.ndarray, Any, Any] = np.empty(0), None, None

    def radius(self, y: Any) -> np.ndarray:
        """Return the distance of ``y`` from the axis; 1 between planes."""
        return np.ones(np.shape(y)) if self.inner_radius is None else self.inner_radius + np.asarray(y)

    def lever(self, y: Any) -> np.ndarray:
        """Return the ratio of the velocity to the continuous field at ``y``."""
        return self.radius(y) if self.power == 3 else np.ones(np.shape(y))

    def shear_rate(self, field: np.ndarray) -> np.ndarray:
        """Return lever d/dy (..., count, p + 1) of a continuous ``field`` (..., size)."""
        return field.take(self.nodes, axis=-1) @ self.matrix.T * (self.levers / self.half_width)

    def weak_divergence(self, flux: np.ndarray) -> np.ndarray:
        """Return d(r^power/lever flux)/dy/r^power (..., size) of ``flux`` (..., count, p + 1).

        Weak form with the basis function of each node, without the flux through the walls.
        """
        return -self.assembled((self.fluxes * flux) @ self.matrix) / self.mass

    def assembled(self, parts: Any) -> np.ndarray:
        """Return the sums (..., size) of the contributions of elements (..., count, p + 1) to each node."""
        whole = np.zeros((*parts.shape[:-2], self.size), dtype=parts.dtype)
        whole[..., :-1] = parts[..., :-1].reshape(*parts.shape[:-2], -1)
        whole[..., self.order :: self.order] += parts[..., -1]
        return whole

    def stiffness(self, coefficient: np.ndarray) -> np.ndarray:
        """Return the matrices (..., p + 1, p + 1) of -d/dy(r^power coefficient d/dy) in each element.

        ``coefficient`` (..., p + 1) is real.
        """
        scaled = coefficient * (self.radii**self.power * self.weights / self.half_width)
        return (scaled @ self._slopes).reshape(*coefficient.shape, -1)

    def integral(self, field: np.ndarray) -> np.ndarray:
        """Return the integrals over y (count, p + 1) from the first edge on of a field (count, p + 1)."""
        values = legendre.legvander(self.points, self.order)
        parts = legendre.legint(np.linalg.solve(values, field.T), lbnd=-1)
        own = self.half_width * legendre.legval(self.points, parts)
        return own + np.concatenate([[0.0], np.cumsum(own[:-1, -1])])[:, None]

    def interpolated(self, field: np.ndarray, y: Any) -> np.ndarray:
        """Return values (..., heights) at ``y`` (heights,) of a field (..., count, p + 1), constant beyond the ends."""
        heights, element, matrix = self._places
        if not np.array_equal(heights, y):
            inside = np.clip(y, self.edges[0], self.edges[-1])
            element = np.clip(np.searchsorted(self.edges, inside, side="right") - 1, 0, self.count - 1)
            matrix = interpolation(self.points, (inside - self.edges[element]) / self.half_width[element, 0] - 1)
            self._places = np.array(y), element, matrix  # many fields and times are evaluated at the same heights
        return np.einsum("...hi,hi->...h", field[..., element, :], matrix)


def graded_edges(gap: float, finest: float, widest: float, ratio: float = 3.0) -> np.ndarray:
    """Return element edges on [0, gap]: widths grow from ``finest`` at the walls by ``ratio`` each, to ``widest``."""
    sizes = [finest]
    while sizes[-1] * ratio < widest and 2 * (sum(sizes) + sizes[-1] * ratio) < gap:
        sizes.append(sizes[-1] * ratio)
    layer = np.concatenate([[0.0], np.cumsum(sizes)])
    middle = gap - 2 * layer[-1]
    inner = np.linspace(layer[-1], gap - layer[-1], 1 + int(np.ceil(middle / widest)))
    return np.concatenate([layer[:-1], inner, (gap - layer[:-1])[::-1]])


ITERATIONS = 12
LARGEST_GROWTH, LEAST_GROWTH = 2.0, 0.2
SAFETY = 0.85
MOST_STEPS = 4_000
ROUNDING = 10.0
"""Largest residual, in tolerances, at which Newton's method may stall because of round-off."""


@dataclass(frozen=True)
class Method:
    """Collocation at ``points`` (stages,) of a step, on (0, 1].

    ``matrix`` (stages, stages) integrates the polynomial through the points from 0 to each point. ``nodes``: 0 and the
    points, with their barycentric ``weights``. ``last`` (stages,) maps increments at the points to their last Legendre
    coefficient.
    """

    points: np.ndarray
    matrix: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    last: np.ndarray


@lru_cache
def radau(stages: int) -> Method:
    """Return the Method of Radau's points."""
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
    """The solution of ``equations`` from ``start`` (size,) at t = 0 on, computed up to the latest requested time.

    More ``stages`` take longer steps, if the solution is smooth enough and Newton's method converges. ``equations`` has
    ``rates(states, forcing(times))`` with states (stages, size); ``scales(states)`` (size,), to which the tolerance is
    relative; and ``jacobian(state, time)``, an object whose ``solver(shifts)`` solves (shift - J) x = b for all shifts
    at once. Raises UnsolvedError where Newton's method finds no step of any length.
    """

    def __init__(self, equations: Any, start: np.ndarray, first_step: float, tolerance: float, stages: int) -> None:
        self.equations, self.tolerance, self.method = equations, tolerance, radau(stages)
        self.begins: list[float] = []
        self.lengths: list[float] = []
        self.pieces: list[np.ndarray] = []
        self.root, self.next_length, self.state = 0.0, first_step, np.array(start, dtype=float)
        self.largest = np.zeros(len(self.state))

    def at(self, time: float) -> np.ndarray:
        """Return the state (size,) at one ``time`` >= 0."""
        root = np.sqrt(time)
        while self.root < root or not self.pieces:
            self._step()
        k = max(int(np.searchsorted(self.begins, root, side="right")) - 1, 0)
        local = np.array([(root - self.begins[k]) / self.lengths[k]])
        return (interpolation(self.method.nodes, local, self.method.weights) @ self.pieces[k])[0]

    def _step(self) -> None:
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

    def _stages(self, length: float, extrapolate: bool) -> np.ndarray | None:
        """Return the increments (stages, size) of the stages of a step, None if Newton's method does not converge."""
        points, nodes = self.method.points, self.method.nodes
        roots = self.root + length * points
        inverse = np.linalg.inv(self.method.matrix * (2 * roots)) / length
        found = np.zeros((len(points), len(self.state)))
        if extrapolate and self.pieces:
            found = interpolation(nodes, 1 + points * length / self.lengths[-1]) @ self.pieces[-1] - self.state
        with np.errstate(all="ignore"):  # a result that is not a number is rejected
            return self._newton(found, roots**2, inverse)

    def _newton(self, found: np.ndarray, times: np.ndarray, inverse: np.ndarray) -> np.ndarray | None:
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
