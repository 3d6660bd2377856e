"""Least-squares operators: polynomially consistent to degree 2 or 4, also for disordered particles.

For particle i and the vectors r = (x, y) to its neighbours j, in units of the support radius, minimise

    sum_j w(r) (f_j - f_i - sum_k c_k phi_k(r))^2,    phi_k = x^a y^b, 1 <= a + b <= order,    w = (1 - r^2)^4.

With M = sum_j w phi phi^T, an operator e . c (the Laplacian: 2 (c_xx + c_yy)) is sum_j a_ij (f_j - f_i), where
a_ij = w z . phi(r_ij) and M z = e: generalised moving least squares (as in S. J. Lind, P. K. Stansby, J. Comput. Phys.
326 (2016) 290-311, and J. R. C. King, S. J. Lind, A. M. A. Nasar, J. Comput. Phys. 415 (2020) 109549, with a basis of
Taylor monomials). The entries of M are the sums of w x^a y^b of degree 2 .. 2 order: 42 for order 4 instead of 105.
Near a curved wall the vectors r are mapped to polar coordinates (``to_polar``); weights remain those of the distances.

Three loops, each in the form that compiles to the fastest code:

1. moments: the vectors and weights are stored where the operators will be; all moments of a particle stay in local
   variables, and each is the one before times y;
2. solve: M = L D L^T without a branch, one particle per SIMD lane: each number is a vector of those of BLOCK particles.
   The unknowns in demand come last, so that forward substitution is nearly free, and those of order 2 last of all;
3. weights of the operators: w P(x, y) by Horner's rule, in place.
"""

import numpy as np

from tisph.neighbours.point_cloud import LANES
from tisph.runtime import CHUNK, holding, integer, real, scalar, threads, ti, unrolled, view


def powers(order, axisymmetric=False):
    """Return the exponents (a, b) of the unknowns x^a y^b, those that operators ask for last.

    In axisymmetric flow those that are not in the basis near the axis come first.
    """
    high = [(degree - b, b) for degree in range(order, 2, -1) for b in range(degree + 1)]
    if axisymmetric:
        high.sort(key=lambda power: _is_even(power, order))
    return [*high, (1, 1), (2, 0), (0, 2), (1, 0), (0, 1)]


def even_powers(order):
    """Return where the exponents begin that are in the basis near the axis, degree counting y as the square it is."""
    return sum(not _is_even(power, order) for power in powers(order))


def _is_even(power, order):
    return power[0] + 2 * power[1] <= order


def moment_indices(order):
    """Return {(a, b): index} of the sums of w x^a y^b that the systems up to ``order`` are made of."""
    exponents = [(degree - b, b) for degree in range(2, 2 * order + 1) for b in range(degree + 1)]
    return {power: index for index, power in enumerate(exponents)}


def moment_chains(order):
    """Return, for each power of x from 0, the indices of the moments by power of y: -1 where none is needed."""
    moments = moment_indices(order)
    return [[moments.get((a, b), -1) for b in range(2 * order - a + 1)] for a in range(2 * order + 1)]


def horner(order, basis):
    """Return, per power of x downwards, the coefficients by falling power of y: -1 for the missing constant.

    ``basis``: the exponents of ``powers``.
    """
    place = {power: index for index, power in enumerate(basis)}
    return [[place.get((a, b), -1) for b in range(order - a, -1, -1)] for a in range(order, -1, -1)]


def moment_of_entries(order, basis):
    """Return the index of the moment in each entry of the lower triangle of M, row by row."""
    moments = moment_indices(order)
    return [moments[(x + a, y + b)] for i, (x, y) in enumerate(basis) for a, b in basis[: i + 1]]


def targets(basis, scale):
    """Return what the Laplacian, d/dx and d/dy ask for of each unknown, lengths being in units of 1/``scale``."""
    degrees = [{(2, 0): 2, (0, 2): 2}, {(1, 0): 1}, {(0, 1): 1}]
    numbers = {2: 2.0 * scale * scale, 1: scale, None: 0.0}
    return [[numbers[asked.get(power)] for power in basis] for asked in degrees]


BLOCK = 16
"""Particles whose moments lie side by side: a multiple of every SIMD width."""

FEW = 10_000
"""Particles up to which a light loop, of one row for each, is over before a second thread has gained anything."""

FEW_NUMBERS = 10 * FEW
"""The same of a loop that goes over a few numbers of each particle only."""

SMALLEST_PIVOT = 1e-2
"""A pivot below this part of its diagonal entry: the neighbours hardly determine the unknown, and the entries of the
row are many times the usual ones. On a lattice the smallest is 0.15; one of 1e4 neighbourhoods of
disordered particles is below."""

LOWEST = 5
"""Unknowns of order 2, the last ones of all."""

LAPLACIAN, D_DX, D_DY = range(3)


@ti.func
def to_polar(vector, bend):
    """Return a ``vector`` in polar coordinates around the centre of curvature of a wall, both as complex numbers.

    With z = x + i y and the centre at z = -1/b, b = ``bend``, seen from a particle, they are log(1 + b z)/b:
    differences of the logarithm of the radius, and of the angle. A flow around a circle is smooth in these, and has
    powers of (distance over radius) in x and y. The map is analytic with the derivative 1 at the particle, so that
    gradient and Laplacian there are those in x and y; so is its Pade approximant, z (6 + 3 b z)/(6 + 6 b z + b^2 z^2).
    """
    x = ti.Vector([bend.x * vector.x - bend.y * vector.y, bend.x * vector.y + bend.y * vector.x])
    squared = ti.Vector([x.x * x.x - x.y * x.y, 2.0 * x.x * x.y])
    upper = ti.Vector([6.0 + 3.0 * x.x, 3.0 * x.y])
    lower = ti.Vector([6.0, 0.0]) + 6.0 * x + squared
    share = ti.Vector([upper.dot(lower), upper.y * lower.x - upper.x * lower.y]) / lower.dot(lower)
    return ti.Vector([share.x * vector.x - share.y * vector.y, share.x * vector.y + share.y * vector.x])


@ti.data_oriented
class LeastSquaresOperators:
    """Weights ``laplacian[i, k]``, ``d_dx[i, k]`` and ``d_dy[i, k]`` of the neighbours that ``points`` lists.

    What lies beyond ``support`` weighs nothing; with ``varying`` it is that times the ``support_factor`` of each
    particle, a field; with ``curved`` vectors are mapped by the ``polar_map`` of each, b as a vector, 0 for not at all.
    Where order 4 is singular, by a pivot below ``smallest_pivot``, order 2 takes over; where that is singular too the
    operators are zero: ``order_reduced`` and ``singular`` count them. ``diagonal[i]``: minus the sum of
    ``laplacian[i, k]``, the weight of the particle's own value.

    What is to be compiled for one thread: ``serial``: everything, loops of assembly too; ``serial_light``: loops over
    the particles that apply an operator or do less; ``serial_numbers``: those that only go over a few numbers of each.
    """

    axisymmetric = False

    def __init__(self, points, support, order, smallest_pivot=SMALLEST_PIVOT, varying=False, curved=False):
        self.points, self.smallest_pivot = points, smallest_pivot
        self.serial = points.serial
        self.serial_light = self.serial or points.capacity <= FEW
        self.serial_numbers = self.serial or points.capacity <= FEW_NUMBERS
        self.workers = 1 if self.serial else threads()
        moments = moment_indices(order)
        self.zeros = [0.0] * len(moments)
        self.chains = moment_chains(order)
        basis = powers(order, self.axisymmetric)
        self.unknowns = len(basis)
        self.begins = [0, self.unknowns - LOWEST]  # of the unknowns that are solved for, in turn
        self.horner = horner(order, basis)
        self.lanes = list(range(BLOCK))
        self.no_coefficients = [[0.0] * self.unknowns for _ in range(3)]
        shape = (points.capacity, points.row_capacity)
        self.laplacian, self.d_dx, self.d_dy = (ti.field(real(), shape) for _ in range(3))
        self.diagonal = ti.field(real(), points.capacity)
        self.lane = ti.types.vector(BLOCK, real())
        blocks, entries = -(-points.capacity // BLOCK), moment_of_entries(order, basis)
        self.moments = ti.field(self.lane, (blocks, len(moments)))
        self.coefficients = ti.field(self.lane, (blocks, 3, self.unknowns))
        self.lower = ti.field(self.lane, (self.workers, len(entries)))
        self.inverse = ti.field(self.lane, (self.workers, self.unknowns))
        self.solution = ti.field(self.lane, (self.workers, 3, self.unknowns))
        self.moment_of = holding(ti.field(ti.i32, len(entries)), entries)
        self.targets = holding(ti.field(real(), (3, self.unknowns)), targets(basis, 1.0 / support))
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
        """Store the scaled vectors to the neighbours of a particle and their weights where the operators will be."""
        scale = self.per_support[None]
        if ti.static(self.varying):
            scale /= self.support_factor[i]
        for k in range(self.points.count[i]):
            apart = self.points.separation(i, self.points.neighbours[i, k]) * scale
            nearness = ti.max(0.0, 1.0 - apart.dot(apart))
            inside = ti.cast(nearness > 0.0, self.laplacian.dtype)  # powers of a sentinel's vector would overflow
            squared = nearness * nearness
            self.laplacian[i, k] = squared * squared
            self.d_dx[i, k] = apart.x * inside
            self.d_dy[i, k] = apart.y * inside
        straight = True
        if ti.static(self.curved):
            bend = self.polar_map[i] / scale
            straight = not bend.dot(bend) > 0.0
            if not straight:
                for k in range(self.points.count[i]):
                    apart = to_polar(ti.Vector([self.d_dx[i, k], self.d_dy[i, k]]), bend)
                    self.d_dx[i, k] = apart.x
                    self.d_dy[i, k] = apart.y
        if ti.static(self.axisymmetric):
            self.set_radial(i, 1.0 / scale, straight)

    @ti.func
    def sum_moments(self, i):
        """Sum the moments of particle ``i``."""
        total = ti.Vector(self.zeros)
        for k in range(unrolled(self.points.count[i])):
            x, y, weighted = self.d_dx[i, k], self.d_dy[i, k], self.laplacian[i, k]
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
        """Solve all systems of a block, those of singular ones again at order 2."""
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
        """Turn the vectors and weights of particle ``i`` into its operators."""
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
        for k in range(unrolled(self.points.count[i])):
            x, y, weight = self.d_dx[i, k], self.d_dy[i, k], self.laplacian[i, k]
            self.laplacian[i, k] = weight * self.polynomial(coefficients, LAPLACIAN, x, y)
            self.d_dx[i, k] = weight * self.polynomial(coefficients, D_DX, x, y)
            self.d_dy[i, k] = weight * self.polynomial(coefficients, D_DY, x, y)
        total = 0.0
        for k in range(self.points.count[i]):
            total += self.laplacian[i, k]
        self.diagonal[i] = -total

    @ti.func
    def polynomial(self, coefficients, operator: ti.template(), x, y):
        """Return z . phi(x, y) of an operator, z being among the ``coefficients``."""
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
        for group in range(unrolled(self.points.count[i] // LANES)):
            for lane in ti.static(range(LANES)):
                k = group * LANES + lane
                total += operator[i, k] * (values[self.points.neighbours[i, k]] - own)
        return total

    def apply_to(self, chosen, operator, values):
        """Return what ``apply`` gives for a few particles, the array ``chosen``, from an array over the slots.

        To the bit, since it adds up in the same order: what cancels there cancels here.
        """
        table, listed = self.points.listed_neighbours(chosen)
        entries = np.where(listed, view(operator)[chosen], 0.0)
        return np.cumsum(entries * (values[table] - values[chosen, None]), axis=1)[:, -1]


@ti.func
def _entry(row, column):
    """Return where an entry of a lower triangle is stored."""
    return row * (row + 1) // 2 + column
