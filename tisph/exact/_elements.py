"""Spectral elements across a gap: polynomials on Legendre-Gauss-Lobatto points, continuous where elements meet.

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

Source: C. Canuto, M. Y. Hussaini, A. Quarteroni and T. A. Zang, Spectral Methods: Fundamentals in Single Domains
(2006), chapters 1 to 3.
"""

import numpy as np
from numpy.polynomial import legendre
from numpy.polynomial.legendre import Legendre

AXIS_MASS = 1e-10
"""Mass of a node on an axis over that of the next, for 0: equations stay ordinary differential ones."""


def barycentric_weights(points):
    """Weights of barycentric interpolation through distinct ``points`` (n,)."""
    gaps = points[:, None] - points[None, :]
    np.fill_diagonal(gaps, 1.0)
    return 1 / gaps.prod(axis=1)


def interpolation(points, x, weights=None):
    """Matrix (len(x), n) that takes values at ``points`` (n,) to those of their polynomial at ``x``.

    ``weights``: the ``barycentric_weights``, where they are known.
    """
    distance = x[:, None] - points[None, :]
    hit = distance == 0
    ratios = (barycentric_weights(points) if weights is None else weights) / np.where(hit, 1.0, distance)
    matrix = ratios / ratios.sum(axis=1, keepdims=True)
    return np.where(hit.any(axis=1, keepdims=True), hit.astype(float), matrix)


def lobatto(order):
    """Points (order + 1,) on [-1, 1], weights of their rule, and the matrix that differentiates their polynomial."""
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

    ``inner_radius``: of that cylinder, 0 for an axis, None for the plane. ``along``: whether the flow is along it.
    """

    def __init__(self, edges, order, inner_radius=None, along=False):
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
        self._places = np.empty(0), None, None

    def radius(self, y):
        """Distance of ``y`` from the axis; 1 between planes."""
        return np.ones(np.shape(y)) if self.inner_radius is None else self.inner_radius + np.asarray(y)

    def lever(self, y):
        """The velocity over the continuous field at ``y``."""
        return self.radius(y) if self.power == 3 else np.ones(np.shape(y))

    def shear_rate(self, field):
        """lever d/dy (..., count, p + 1) of a continuous ``field`` (..., size)."""
        return field.take(self.nodes, axis=-1) @ self.matrix.T * (self.levers / self.half_width)

    def weak_divergence(self, flux):
        """d(r^power/lever flux)/dy/r^power (..., size) of ``flux`` (..., count, p + 1).

        Tested with each node's function, and without what passes through the walls.
        """
        return -self.assembled((self.fluxes * flux) @ self.matrix) / self.mass

    def assembled(self, parts):
        """Sums (..., size) of what elements (..., count, p + 1) give to each node."""
        whole = np.zeros((*parts.shape[:-2], self.size), dtype=parts.dtype)
        whole[..., :-1] = parts[..., :-1].reshape(*parts.shape[:-2], -1)
        whole[..., self.order :: self.order] += parts[..., -1]
        return whole

    def stiffness(self, coefficient):
        """Matrices (..., p + 1, p + 1) of each element, for a real coefficient (..., p + 1).

        The operator is -d/dy(r^power coefficient d/dy).
        """
        scaled = coefficient * (self.radii**self.power * self.weights / self.half_width)
        return (scaled @ self._slopes).reshape(*coefficient.shape, -1)

    def integral(self, field):
        """Integrals over y (count, p + 1) from the first edge on of a field (count, p + 1)."""
        values = legendre.legvander(self.points, self.order)
        parts = legendre.legint(np.linalg.solve(values, field.T), lbnd=-1)
        own = self.half_width * legendre.legval(self.points, parts)
        return own + np.concatenate([[0.0], np.cumsum(own[:-1, -1])])[:, None]

    def interpolated(self, field, y):
        """Values (..., heights) at ``y`` (heights,) of a field (..., count, p + 1); beyond an end that at the end."""
        heights, element, matrix = self._places
        if not np.array_equal(heights, y):
            inside = np.clip(y, self.edges[0], self.edges[-1])
            element = np.clip(np.searchsorted(self.edges, inside, side="right") - 1, 0, self.count - 1)
            matrix = interpolation(self.points, (inside - self.edges[element]) / self.half_width[element, 0] - 1)
            self._places = np.array(y), element, matrix  # many fields and times are asked for at the same heights
        return np.einsum("...hi,hi->...h", field[..., element, :], matrix)


def graded_edges(gap, finest, widest, ratio=3.0):
    """Edges of elements on [0, gap], from ``finest`` at the walls, each ``ratio`` times the last, to ``widest``."""
    sizes = [finest]
    while sizes[-1] * ratio < widest and 2 * (sum(sizes) + sizes[-1] * ratio) < gap:
        sizes.append(sizes[-1] * ratio)
    layer = np.concatenate([[0.0], np.cumsum(sizes)])
    middle = gap - 2 * layer[-1]
    inner = np.linspace(layer[-1], gap - layer[-1], 1 + int(np.ceil(middle / widest)))
    return np.concatenate([layer[:-1], inner, (gap - layer[:-1])[::-1]])
