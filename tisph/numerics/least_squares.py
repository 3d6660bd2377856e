"""Least-squares operators: polynomially consistent to degree 2 or 4, also for disordered particles.

For particle i and the vectors r = (x, y) to its neighbours j, in units of the support radius, minimise

    sum_j w(r) (f_j - f_i - sum_k c_k phi_k(r))^2,    phi_k = x^a y^b, 1 <= a + b <= order,    w = (1 - r^2)^4.

With M = sum_j w phi phi^T, an operator e . c (the Laplacian: 2 (c_xx + c_yy)) is sum_j a_ij (f_j - f_i), where
a_ij = w z . phi(r_ij) and M z = e: generalised moving least squares (as in S. J. Lind, P. K. Stansby, J. Comput. Phys.
326 (2016) 290-311, and J. R. C. King, S. J. Lind, A. M. A. Nasar, J. Comput. Phys. 415 (2020) 109549, with a basis of
Taylor monomials). The entries of M are the sums of w x^a y^b of degree 2 .. 2 order: 42 for order 4 instead of 105.
Near a curved wall the vectors r are mapped to polar coordinates (``to_polar``); weights depend on distances in x, y.

Three loops, each in the form that compiles to the fastest code:

1. moments: the vectors and weights are stored where the operators will be; all moments of a particle stay in local
   variables, and each is the one before times y;
2. solve: M = L D L^T without a branch, one particle per SIMD lane: each number is a vector over BLOCK particles.
   The unknowns of the operators come last, so that forward substitution is nearly free, and the unknowns of order 2
   are the last of all;
3. weights of the operators: w P(x, y) by Horner's rule, in place.
"""

from typing import Any

import numpy as np

from tisph.numerics.point_cloud import LANES, PointCloud
from tisph.runtime import CHUNK, holding, integer, real, scalar, threads, ti, unrolled, view

BLOCK = 16
"""Particles whose moments lie side by side: a multiple of every SIMD width."""

FEW = 10_000
"""Particles up to which a second thread gains nothing in a loop of one row for each particle."""

FEW_NUMBERS = 10 * FEW
"""Particles up to which a second thread gains nothing in a loop over a few numbers of each particle."""

SMALLEST_PIVOT = 1e-2
"""Smallest pivot over its diagonal entry. Below, the neighbours hardly determine the unknown, and the entries of the
row are many times the usual ones. On a lattice the smallest is 0.15; one of 1e4 neighbourhoods of
disordered particles is below."""

LOWEST = 5
"""Number of unknowns of order 2, which are the last of all."""

LAPLACIAN, D_DX, D_DY = range(3)

ACROSS = -3
"""Index of the unknown y^2 from the end; the unknown y is the last."""

NEAR_WALLS = 1.2
"""Distance from the axis, in supports, up to which all functions are taken to be even beside walls, where supports are
wider; elsewhere it is 1. With 1 the equations of the pressure were singular once, at points on a sphere near the axis
that a polymer flows past. With 1.2 everywhere the errors of starting flow in pipes are largest on the axis."""

RADIAL_NUMBERS = 4
"""Numbers of each particle in axisymmetric flow: a, b, c and whether it is near the axis."""

Powers = list[tuple[int, int]]
"""Exponents (a, b) of monomials x^a y^b."""


def _powers(order: int, axisymmetric: bool) -> Powers:
    """Return the unknowns; the unknowns of the operators come last.

    In axisymmetric flow the unknowns that are not in the basis near the axis come first.
    """
    high = [(degree - b, b) for degree in range(order, 2, -1) for b in range(degree + 1)]
    if axisymmetric:
        high.sort(key=lambda power: _is_even(power, order))
    return [*high, (1, 1), (2, 0), (0, 2), (1, 0), (0, 1)]


def _is_even(power: tuple[int, int], order: int) -> bool:
    """Return whether x^a r^(2b) is in the basis near the axis, a + 2 b <= ``order``."""
    return power[0] + 2 * power[1] <= order


def _moments(order: int) -> dict[tuple[int, int], int]:
    """Return {(a, b): index} of the sums of w x^a y^b in the systems up to ``order``."""
    exponents = [(degree - b, b) for degree in range(2, 2 * order + 1) for b in range(degree + 1)]
    return {power: index for index, power in enumerate(exponents)}


def _moment_chains(order: int) -> list[list[int]]:
    """Return, for each power of x from 0, the indices of the moments by power of y: -1 for no moment."""
    moments = _moments(order)
    return [[moments.get((a, b), -1) for b in range(2 * order - a + 1)] for a in range(2 * order + 1)]


def _horner(order: int, basis: Powers) -> list[list[int]]:
    """Return, for each power of x downwards, the coefficients by falling power of y: -1 for the missing constant."""
    place = {power: index for index, power in enumerate(basis)}
    return [[place.get((a, b), -1) for b in range(order - a, -1, -1)] for a in range(order, -1, -1)]


def _moment_of_entries(order: int, basis: Powers) -> list[int]:
    """Return the index of the moment in each entry of the lower triangle of M, row by row."""
    moments = _moments(order)
    return [moments[(x + a, y + b)] for i, (x, y) in enumerate(basis) for a, b in basis[: i + 1]]


def _targets(basis: Powers, scale: float) -> list[list[float]]:
    """Return the vectors e of the Laplacian, d/dx and d/dy, with lengths in units of 1/``scale``."""
    second, first = 2.0 * scale * scale, scale
    operators = [{(2, 0): second, (0, 2): second}, {(1, 0): first}, {(0, 1): first}]
    return [[operator.get(power, 0.0) for power in basis] for operator in operators]


@ti.func
def to_polar(vector, bend):
    """Return a ``vector`` in polar coordinates around the centre of curvature of a wall, both as complex numbers.

    For z = x + i y from a particle and the centre at z = -1/b, b = ``bend``, they are log(1 + b z)/b: differences of
    the logarithm of the radius, and of the angle. A flow around a circle is smooth in these coordinates; its Taylor
    series in x and y is in powers of distance over radius. The map is analytic with the derivative 1 at the particle,
    so that gradient and Laplacian there are the same as in x and y. This also holds for its Pade approximant, which is
    evaluated, z (6 + 3 b z)/(6 + 6 b z + b^2 z^2).
    """
    x = ti.Vector([bend.x * vector.x - bend.y * vector.y, bend.x * vector.y + bend.y * vector.x])
    squared = ti.Vector([x.x * x.x - x.y * x.y, 2.0 * x.x * x.y])
    upper = ti.Vector([6.0 + 3.0 * x.x, 3.0 * x.y])
    lower = ti.Vector([6.0, 0.0]) + 6.0 * x + squared
    share = ti.Vector([upper.dot(lower), upper.y * lower.x - upper.x * lower.y]) / lower.dot(lower)
    return ti.Vector([share.x * vector.x - share.y * vector.y, share.x * vector.y + share.y * vector.x])


@ti.data_oriented
class LeastSquaresOperators:
    """Weights ``laplacian[k]``, ``d_dx[k]`` and ``d_dy[k]`` of the neighbours that ``points`` lists.

    Neighbours beyond ``support`` [length] have the weight 0. ``varying``: the support of each particle is multiplied by
    the field ``support_factor``. ``curved``: vectors are mapped to polar coordinates by the field ``polar_map``, b of
    ``to_polar`` as a vector, 0 for no map. Where the system of order 4 is singular, by a pivot below
    ``smallest_pivot``, order 2 is used; where order 2 is singular too, the operators are zero. ``order_reduced`` and
    ``singular`` count these particles. ``diagonal[i]``: minus the sum of ``laplacian[k]``, the weight of the
    particle's own value.

    Loops compiled for one thread: with ``serial`` all, also in the assembly; with ``serial_light`` the loops over the
    particles that apply an operator or less; with ``serial_numbers`` the loops over a few numbers of each particle.
    """

    axisymmetric = False

    radial: Any
    """Numbers a, b, c of each particle and whether it is near the axis, in ``AxisymmetricOperators``."""

    def __init__(
        self,
        points: PointCloud,
        support: float,
        order: int,
        smallest_pivot: float = SMALLEST_PIVOT,
        varying: bool = False,
        curved: bool = False,
    ):
        self.points, self.smallest_pivot = points, smallest_pivot
        self.serial = points.serial
        self.serial_light = self.serial or points.capacity <= FEW
        self.serial_numbers = self.serial or points.capacity <= FEW_NUMBERS
        self.workers = 1 if self.serial else threads()
        moments = _moments(order)
        self.zeros = [0.0] * len(moments)
        self.chains = _moment_chains(order)
        basis = _powers(order, self.axisymmetric)
        self.unknowns = len(basis)
        self.begins = [0, self.unknowns - LOWEST]  # first unknown of each attempt
        self.horner = _horner(order, basis)
        self.lanes = list(range(BLOCK))
        self.no_coefficients = [[0.0] * self.unknowns for _ in range(3)]
        self.laplacian, self.d_dx, self.d_dy = (ti.field(real(), points.entries) for _ in range(3))
        self.diagonal = ti.field(real(), points.capacity)
        self.lane = ti.types.vector(BLOCK, real())
        blocks, entries = -(-points.capacity // BLOCK), _moment_of_entries(order, basis)
        self.moments = ti.field(self.lane, (blocks, len(moments)))
        self.coefficients = ti.field(self.lane, (blocks, 3, self.unknowns))
        self.lower = ti.field(self.lane, (self.workers, len(entries)))
        self.inverse = ti.field(self.lane, (self.workers, self.unknowns))
        self.solution = ti.field(self.lane, (self.workers, 3, self.unknowns))
        self.moment_of = holding(ti.field(ti.i32, len(entries)), entries)
        self.targets = holding(ti.field(real(), (3, self.unknowns)), _targets(basis, 1.0 / support))
        self.per_support = scalar(1.0 / support)
        self.varying = varying
        if varying:
            self.support_factor = ti.field(real(), points.capacity)
        self.curved = curved
        if curved:
            self.polar_map = ti.field(ti.types.vector(2, real()), points.capacity)
        self.order_reduced, self.singular = integer(0), integer(0)

    @ti.kernel
    def assemble(self):
        """Compute all operators for the present positions of the points."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.set_offsets(i)
            self.sum_moments(i)
        self.order_reduced[None] = 0
        self.singular[None] = 0
        ti.loop_config(serialize=self.serial)
        for turn in range(self.workers * CHUNK):  # a chunk for each thread, which works in its first turn
            if turn % CHUNK == 0:
                worker, blocks = turn // CHUNK, (particles + BLOCK - 1) // BLOCK
                for block in range(worker * blocks // self.workers, (worker + 1) * blocks // self.workers):
                    self.solve(worker, block, particles)
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            self.set_weights(i)

    @ti.func
    def set_offsets(self, i):
        """Store the scaled vectors to the neighbours of a particle and their weights in the fields of the operators."""
        scale = self.per_support[None]
        if ti.static(self.varying):
            scale /= self.support_factor[i]
        for k in range(self.points.begin[i], self.points.end[i]):
            apart = self.points.separation(i, self.points.neighbours[k]) * scale
            nearness = ti.max(0.0, 1.0 - apart.dot(apart))
            inside = ti.cast(nearness > 0.0, self.laplacian.dtype)  # powers of a sentinel's vector would overflow
            squared = nearness * nearness
            self.laplacian[k] = squared * squared * self.area_ratio(i, self.points.neighbours[k])
            self.d_dx[k] = apart.x * inside
            self.d_dy[k] = apart.y * inside
        straight = True
        if ti.static(self.curved):
            bend = self.polar_map[i] / scale
            straight = not bend.dot(bend) > 0.0
            if not straight:
                for k in range(self.points.begin[i], self.points.end[i]):
                    apart = to_polar(ti.Vector([self.d_dx[k], self.d_dy[k]]), bend)
                    self.d_dx[k] = apart.x
                    self.d_dy[k] = apart.y
        if ti.static(self.axisymmetric):
            self.set_radial(i, 1.0 / scale, straight)

    @ti.func
    def area_ratio(self, i, j):
        """Return the area of point ``j`` over that of particle ``i``, 1 with one spacing."""
        result = 1.0
        if ti.static(self.points.graded):
            known = ti.min(j, self.points.capacity - 1)  # the sentinel has none, and the weight 0
            result = (self.points.relative(known) / self.points.relative(i)) ** 2
        return result

    @ti.func
    def sum_moments(self, i):
        """Sum the moments of particle ``i``."""
        total = ti.Vector(self.zeros)
        for k in range(unrolled(self.points.begin[i]), self.points.end[i]):
            x, y, weighted = self.d_dx[k], self.d_dy[k], self.laplacian[k]
            for chain in ti.static(self.chains):
                product = weighted
                for index in ti.static(chain):
                    if ti.static(index >= 0):
                        total[index] += product
                    product *= y
                weighted *= x
        for index in range(unrolled(ti.static(len(self.zeros)))):
            self.moments[i // BLOCK, index][i % BLOCK] = total[index]

    @ti.func
    def solve(self, worker, block, particles):
        """Solve all systems of a block; singular systems again at order 2."""
        wanted = block * BLOCK + ti.Vector(self.lanes) < particles
        last = ti.static(len(self.begins) - 1)
        for attempt in range(last + 1):
            first = 0
            for number in ti.static(range(1, len(self.begins))):
                first = ti.select(attempt == number, self.begins[number], first)
            singular = self.eliminate(worker, block, first) < self.smallest_pivot
            if ti.static(self.axisymmetric):
                singular = singular | ((self.radial[block, 3] > 0.0) & (attempt == 0))
            self.substitute(worker, block, first)
            for operator, unknown in ti.ndrange(3, self.unknowns):
                found = self.solution[worker, operator, unknown]
                if attempt == last:
                    found = ti.select(singular, 0.0, found)
                if attempt > 0:
                    found = ti.select(wanted, found, self.coefficients[block, operator, unknown])
                self.coefficients[block, operator, unknown] = found
            if attempt == last:
                singular_count = ti.cast(wanted & singular, ti.i32).sum()
                self.singular[None] += singular_count
                self.order_reduced[None] += ti.cast(wanted, ti.i32).sum() - singular_count
            wanted = wanted & singular
            if not wanted.any():
                break

    @ti.func
    def eliminate(self, worker, block, first):
        """Factor M = L D L^T of the unknowns from ``first`` on; return the smallest pivots, 0 if not positive.

        A pivot is taken relative to its diagonal entry.
        """
        for entry in range(ti.static(self.lower.shape[1])):
            self.lower[worker, entry] = self.moments[block, self.moment_of[entry]]
        smallest = self.lane(1.0)
        for k in range(first, self.unknowns):
            diagonal = _entry(k, k)
            pivot = self.lower[worker, diagonal]
            inverse = 1.0 / pivot
            self.inverse[worker, k] = inverse
            relative = pivot / self.moments[block, self.moment_of[diagonal]]
            smallest = ti.min(smallest, ti.select(relative > 0.0, relative, 0.0))  # 0 / 0 is not > 0
            for j in range(k + 1, self.unknowns):
                left = _entry(j, k)
                factor = self.lower[worker, left] * inverse
                for i in range(j, self.unknowns):
                    target = _entry(i, j)
                    self.lower[worker, target] = self.lower[worker, target] - self.lower[worker, _entry(i, k)] * factor
                self.lower[worker, left] = factor
        return smallest

    @ti.func
    def substitute(self, worker, block, first):
        """Solve L D L^T z = e of all operators; the entries of e are zero before the last four."""
        start = self.unknowns - 4
        for operator in range(3):
            for i in range(self.unknowns):
                self.solution[worker, operator, i] = self.lane(0.0) + self.targets[operator, i]
            if ti.static(self.axisymmetric):
                self.set_radial_targets(worker, block, operator)
            for i in range(start, self.unknowns):
                value = self.solution[worker, operator, i]
                for k in range(start, i):
                    value -= self.lower[worker, _entry(i, k)] * self.solution[worker, operator, k]
                self.solution[worker, operator, i] = value
            for i in range(start, self.unknowns):
                self.solution[worker, operator, i] = self.solution[worker, operator, i] * self.inverse[worker, i]
            for back in range(self.unknowns - first):
                i = self.unknowns - 1 - back
                value = self.solution[worker, operator, i]
                for k in range(i + 1, self.unknowns):
                    value -= self.lower[worker, _entry(k, i)] * self.solution[worker, operator, k]
                self.solution[worker, operator, i] = value

    @ti.func
    def set_weights(self, i):
        """Compute the operators of particle ``i`` from the vectors and weights in their fields."""
        coefficients = ti.Matrix(self.no_coefficients)  # local, or they would be read again for every neighbour
        for operator in range(unrolled(3)):
            for unknown in range(unrolled(ti.static(self.unknowns))):
                coefficients[operator, unknown] = self.coefficients[i // BLOCK, operator, unknown][i % BLOCK]
        if ti.static(self.varying):
            per_factor = 1.0 / self.support_factor[i]
            for unknown in range(unrolled(ti.static(self.unknowns))):
                coefficients[LAPLACIAN, unknown] *= per_factor * per_factor
                coefficients[D_DX, unknown] *= per_factor
                coefficients[D_DY, unknown] *= per_factor
        for k in range(unrolled(self.points.begin[i]), self.points.end[i]):
            x, y, weight = self.d_dx[k], self.d_dy[k], self.laplacian[k]
            self.laplacian[k] = weight * self.polynomial(coefficients, LAPLACIAN, x, y)
            self.d_dx[k] = weight * self.polynomial(coefficients, D_DX, x, y)
            self.d_dy[k] = weight * self.polynomial(coefficients, D_DY, x, y)
        total = 0.0
        for k in range(self.points.begin[i], self.points.end[i]):
            total += self.laplacian[k]
        self.diagonal[i] = -total

    @ti.func
    def polynomial(self, coefficients, operator: ti.template(), x, y):
        """Return z . phi(x, y) of an operator, whose z is a row of the ``coefficients``."""
        value = 0.0
        for row in ti.static(self.horner):
            inner = 0.0
            for index in ti.static(row):
                inner *= y
                if ti.static(index >= 0):
                    inner += coefficients[operator, index]
            value = value * x + inner
        return value

    @ti.func
    def apply(self, operator: ti.template(), values: ti.template(), i):
        """Return sum_j operator[i, j] (values[j] - values[i]); the sentinel's value must be finite."""
        own = values[i]
        total = 0.0 * own
        for group in range(unrolled(self.points.begin[i] // LANES), self.points.end[i] // LANES):
            for lane in ti.static(range(LANES)):
                k = group * LANES + lane
                total += operator[k] * (values[self.points.neighbours[k]] - own)
        return total

    def apply_to(self, chosen: np.ndarray, operator: Any, values: np.ndarray) -> np.ndarray:
        """Return sum_j operator[i, j] (values[j] - values[i]) at the particles ``chosen`` (k,), as an array (k,).

        ``values``: array over the slots. The result is bitwise the result of ``apply``, since the sum has the same
        order: terms that cancel there cancel here.
        """
        entries, listed = self.points.rows_of(chosen)
        weights = np.where(listed, view(operator)[entries], 0.0)
        others = values[view(self.points.neighbours)[entries]]
        return np.cumsum(weights * (others - values[chosen, None]), axis=1)[:, -1]


@ti.data_oriented
class AxisymmetricOperators(LeastSquaresOperators):
    """Operators of axisymmetric flow, with x along the axis and y = r, the distance from it; ``d_dy`` is d/ds.

    They are d/dx, d/ds = (1/r) d/dr with s = r^2/2, and the Laplacian d2/dx2 + d2/dr2 + (1/r) d/dr of a scalar: none
    of them is singular on the axis. In place of r_j - r_i the second coordinate of a neighbour is one in which
    solutions are simple:

    * where the fluid reaches the axis, (s_j - s_i)/L, L^2 = r_i^2 + support^2, since smooth fields are even in r.
      Nearer to the axis than the support, the basis has only powers with a + 2 b <= order, all powers of that order in
      r: with half a disc of neighbours others cannot be distinguished, and the Laplacian has growing modes;
    * in a gap around an inner cylinder r_i log(r_j/r_i), in which log r and the powers of r are entire functions.
      Circular Couette flow, 16 spacings across with a radius ratio of 0.5, has errors of 3.5e-4 in s, and of 8e-7 in
      this coordinate.

    For the derivatives D by that coordinate d/ds = b D, and the Laplacian's part across the axis is a D^2 + c D.
    ``lowest_radius``: distance from the axis where y = 0. ``annular``: whether there is an inner cylinder.
    """

    axisymmetric = True

    def __init__(
        self,
        points: PointCloud,
        support: float,
        order: int,
        smallest_pivot: float,
        varying: bool,
        curved: bool,
        *,
        lowest_radius: float,
        annular: bool,
    ):
        super().__init__(points, support, order, smallest_pivot, varying, curved)
        self.annular = annular
        if not annular:
            self.begins.insert(1, sum(not _is_even(power, order) for power in _powers(order, True)))
        self.lowest_radius, self.support = scalar(lowest_radius), scalar(support)
        self.radial = ti.field(self.lane, (self.moments.shape[0], RADIAL_NUMBERS))

    @ti.func
    def radius(self, i):
        """Return the distance of a particle from the axis."""
        return self.points.position[i].y + self.lowest_radius[None]

    @ti.func
    def set_radial(self, i, support, straight):
        """Store a, b and c of particle ``i``, and its second coordinates if ``straight`` (without a polar map)."""
        radius = self.radius(i)
        a, b, c = 1.0, 1.0 / radius, 1.0 / radius
        if straight:
            size = ti.sqrt(radius * radius + support * support)
            a, b, c = (radius / size) ** 2, 1.0 / size, 2.0 / size
            if ti.static(self.annular):
                a, b, c = 1.0, 1.0 / radius, 0.0
            for k in range(self.points.begin[i], self.points.end[i]):
                apart = self.d_dy[k]
                if ti.static(self.annular):
                    self.d_dy[k] = radius / support * ti.log(1.0 + apart * support / radius)
                else:
                    self.d_dy[k] = apart * (2.0 * radius + apart * support) * 0.5 / size
        block, lane = i // BLOCK, i % BLOCK
        self.radial[block, 0][lane] = a
        self.radial[block, 1][lane] = b
        self.radial[block, 2][lane] = c * support / self.support[None]  # it is divided by the support twice later on
        self.radial[block, 3][lane] = 0.0
        if ti.static(not self.annular):
            usual = self.support[None] * self.points.relative(i)
            reach = ti.select(support > 1.001 * usual, NEAR_WALLS, 1.0) * support
            self.radial[block, 3][lane] = ti.cast(radius < reach, self.laplacian.dtype)

    @ti.func
    def set_radial_targets(self, worker, block, operator):
        """Multiply the entries of e for derivatives by the second coordinate by a, b and c of each particle."""
        across, along = self.unknowns + ACROSS, self.unknowns - 1
        if operator == LAPLACIAN:
            self.solution[worker, operator, across] *= self.radial[block, 0]
            self.solution[worker, operator, along] = self.radial[block, 2] * self.targets[D_DY, along]
        if operator == D_DY:
            self.solution[worker, operator, along] *= self.radial[block, 1]

    @ti.func
    def hoop(self, values: ti.template(), i):
        """Return the further term of the Laplacian of v/r and w/r, all components but the first: twice their d/ds."""
        total = 2.0 * self.apply(self.d_dy, values, i)
        total[0] = 0.0
        return total


@ti.func
def _entry(row, column):
    """Return the index of an entry of a lower triangle."""
    return row * (row + 1) // 2 + column
