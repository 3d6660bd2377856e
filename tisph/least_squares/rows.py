"""Rows of least-squares operators: exact for polynomials up to degree 2 or 4 on any arrangement of particles.

For particle i and the vectors r = (x, y) to its neighbours j, in units of the support radius, minimise

    sum_j w(r) (f_j - f_i - sum_k c_k phi_k(r))^2,    phi_k = x^a y^b, 1 <= a + b <= order,    w = (1 - r^2)^4.

With M = sum_j w phi phi^T, an operator e . c (the Laplacian: 2 (c_xx + c_yy)) is sum_j a_ij (f_j - f_i), where
a_ij = w z . phi(r_ij) and M z = e: generalised moving least squares (as in S. J. Lind, P. K. Stansby, J. Comput. Phys.
326 (2016) 290-311, and J. R. C. King, S. J. Lind, A. M. A. Nasar, J. Comput. Phys. 415 (2020) 109549, with a basis of
Taylor monomials). The entries of M are the sums of w x^a y^b of degree 2 .. 2 order: 42 for order 4 instead of 105.
Three loops, each in the form that compiles to the fastest code:

1. moments: the vectors and weights go to where the rows will be; all moments of a particle stay in local variables, and
   each is the one before times y;
2. solve: M = L D L^T, unrolled without a branch, one particle per SIMD lane: the moments of BLOCK particles are
   contiguous. The unknowns in demand come last, so that forward substitution is nearly free;
3. rows: w P(x, y) by Horner's rule, in place.
"""

from tisph.least_squares.elimination import Elimination, horner, moment_chains, moment_indices, powers
from tisph.neighbours.points import LANES
from tisph.runtime import real, scalar, threads, ti

SUPPORT = {2: 1.9, 4: 2.9}
"""Radius in particle spacings by order. About 10 and 27 neighbours: 0.1 less, and sheared disorder becomes singular."""

BLOCK = 16
"""Particles whose moments lie side by side: a multiple of every SIMD width."""

CHUNK = 512
"""Taichi gives a thread at least this many iterations of a parallel loop."""

FEW = 10_000
"""Particles below which a light loop, of one row for each, is over before a second thread has gained anything."""

FEW_NUMBERS = 10 * FEW
"""The same of a loop that goes over a few numbers of each particle only."""

SMALLEST_PIVOT = 1e-2
"""A pivot below this part of its diagonal entry: the neighbours hardly determine the unknown, and the entries of the
row are many times the usual ones. On a lattice the smallest is 0.15; one neighbourhood in 1e4 is below in disorder."""

LAPLACIAN, ALONG, ACROSS = range(3)


@ti.data_oriented
class LeastSquaresRows:
    """Rows ``laplacian[i, k]``, ``along[i, k]`` (d/dx) and ``across[i, k]`` (d/dy) of the neighbours ``points`` lists.

    What lies beyond ``support`` weighs nothing. Where order 4 is singular order 2 takes over, where that is singular
    too the rows are zero: ``reduced`` and ``dropped`` count them. ``pivot`` holds the smallest pivot over its diagonal.
    ``diagonal[i]``: minus the sum of ``laplacian[i, k]``, what it gives particle i of its own value.

    What is to be compiled for one thread: ``serial``: everything, loops of assembly too; ``serial_light``: loops over
    the particles that apply a row or do less; ``serial_numbers``: those that only go over a few numbers of each.
    """

    def __init__(self, points, support, order):
        self.points = points
        self.count = points.fluid
        self.serial = points.serial
        self.serial_light = self.serial or self.count < FEW
        self.serial_numbers = self.serial or self.count < FEW_NUMBERS
        self.blocks = -(-self.count // BLOCK)
        # idle turns make the loop over the blocks long enough to be shared among the threads
        self.stretch = 1 if self.serial else -(-threads() * CHUNK // self.blocks)
        moments = moment_indices(order)
        self.zeros = [0.0] * len(moments)
        self.chains = moment_chains(order)
        unknowns = powers(order)
        self.full = Elimination(order, moments, unknowns)
        self.low = Elimination(2, moments, unknowns)
        self.horner = horner(order)
        self.places = list(range(len(unknowns)))
        self.no_coefficients = [[0.0] * len(unknowns) for _ in range(3)]
        shape = (self.count, points.capacity)
        self.laplacian, self.along, self.across = (ti.field(real(), shape) for _ in range(3))
        self.diagonal = ti.field(real(), self.count)
        self.moments = ti.field(real(), (self.blocks, len(moments), BLOCK))
        self.coefficients = ti.field(real(), (self.blocks, 3, len(unknowns), BLOCK))
        self.pivot = ti.field(real(), (self.blocks, BLOCK))
        self.per_support = scalar(1.0 / support)
        self.reduced = ti.field(ti.i32, ())
        self.dropped = ti.field(ti.i32, ())

    def assemble(self):
        """Compute all rows for the present places of the points."""
        self.sum_moments()
        self.solve()
        self.evaluate()

    @ti.kernel
    def sum_moments(self):
        """Put vectors and weights where the rows will be, and sum the moments."""
        ti.loop_config(serialize=self.serial)
        for i in range(self.count):
            self.measure(i)
            total = ti.Vector(self.zeros)
            for group in range(self.points.count[i] // LANES):
                part = ti.Vector(self.zeros)
                for lane in ti.static(range(LANES)):
                    k = group * LANES + lane
                    x, y, weighted = self.along[i, k], self.across[i, k], self.laplacian[i, k]
                    for chain in ti.static(self.chains):
                        product = weighted
                        for index in ti.static(chain):
                            if ti.static(index >= 0):
                                part[index] += product
                            product *= y
                        weighted *= x
                total += part
            for chain in ti.static(self.chains):
                for index in ti.static(chain):
                    if ti.static(index >= 0):
                        self.moments[i // BLOCK, index, i % BLOCK] = total[index]

    @ti.func
    def measure(self, i):
        """Store the scaled vectors to the neighbours of particle ``i`` and their weights."""
        scale = self.per_support[None]
        for k in range(self.points.count[i]):
            apart = self.points.separation(i, self.points.table[i, k]) * scale
            nearness = ti.max(0.0, 1.0 - apart.dot(apart))
            inside = ti.cast(nearness > 0.0, self.laplacian.dtype)  # powers of a sentinel's vector would overflow
            squared = nearness * nearness
            self.laplacian[i, k] = squared * squared
            self.along[i, k] = apart.x * inside
            self.across[i, k] = apart.y * inside

    @ti.kernel
    def solve(self):
        """Solve all systems, singular ones again at order 2."""
        self.reduced[None] = 0
        self.dropped[None] = 0
        ti.loop_config(serialize=self.serial)
        for turn in range(self.blocks * self.stretch):
            if turn % self.stretch == 0:
                block = turn // self.stretch
                for lane in range(BLOCK):
                    self.pivot[block, lane] = self.solve_one(self.full, block, lane)
        ti.loop_config(serialize=True)
        for i in range(self.count):
            block, lane = i // BLOCK, i % BLOCK
            if self.pivot[block, lane] < SMALLEST_PIVOT:
                if self.solve_one(self.low, block, lane) < SMALLEST_PIVOT:
                    self.dropped[None] += 1
                    for operator in ti.static(range(3)):
                        for unknown in ti.static(self.places):
                            self.coefficients[block, operator, unknown, lane] = 0.0
                else:
                    self.reduced[None] += 1

    @ti.func
    def solve_one(self, system: ti.template(), block, lane):
        """Store the coefficients of one particle and return its smallest relative pivot (0 if not positive)."""
        lower = ti.Vector(system.no_entries)
        inverse = ti.Vector(system.no_unknowns)
        for row in ti.static(system.fill):
            for entry, moment in ti.static(row):
                lower[entry] = self.moments[block, moment, lane]
        smallest = 1.0
        for k, entry, moment in ti.static(system.pivots):
            pivot = lower[entry]
            inverse[k] = 1.0 / pivot
            relative = pivot / self.moments[block, moment, lane]
            smallest = ti.min(smallest, ti.select(relative > 0.0, relative, 0.0))  # 0 / 0 is not > 0
            for left, updates in ti.static(system.columns[k]):
                factor = lower[left] * inverse[k]
                for target, right in ti.static(updates):
                    lower[target] -= lower[right] * factor
                lower[left] = factor
        for operator in ti.static(range(3)):
            self.substitute(system, operator, block, lane, lower, inverse)
        return smallest

    @ti.func
    def substitute(
        self, system: ti.template(), operator: ti.template(), block, lane, lower: ti.template(), inverse: ti.template()
    ):
        """Solve L D L^T z = e for one operator and store z."""
        scale = self.per_support[None]
        z = ti.Vector(system.no_unknowns)
        for i, degree in ti.static(system.units[operator]):
            z[i] = scale if ti.static(degree == 1) else 2.0 * scale * scale
        for i, terms in ti.static(system.forward[operator]):
            for k, entry in ti.static(terms):
                z[i] -= lower[entry] * z[k]
        for i, _ in ti.static(system.forward[operator]):
            z[i] *= inverse[i]
        for i, target, terms in ti.static(system.backward):
            for k, entry in ti.static(terms):
                z[i] -= lower[entry] * z[k]
            self.coefficients[block, operator, target, lane] = z[i]
        for target in ti.static(system.unused):
            self.coefficients[block, operator, target, lane] = 0.0

    @ti.kernel
    def evaluate(self):
        """Turn the vectors and weights into rows."""
        ti.loop_config(serialize=self.serial)
        for i in range(self.count):
            known = ti.Matrix(self.no_coefficients)  # local, or they would be read again for every neighbour
            for operator in ti.static(range(3)):
                for unknown in ti.static(self.places):
                    known[operator, unknown] = self.coefficients[i // BLOCK, operator, unknown, i % BLOCK]
            for k in range(self.points.count[i]):
                x, y, weight = self.along[i, k], self.across[i, k], self.laplacian[i, k]
                self.laplacian[i, k] = weight * self.polynomial(known, LAPLACIAN, x, y)
                self.along[i, k] = weight * self.polynomial(known, ALONG, x, y)
                self.across[i, k] = weight * self.polynomial(known, ACROSS, x, y)
            total = 0.0
            for k in range(self.points.count[i]):
                total += self.laplacian[i, k]
            self.diagonal[i] = -total

    @ti.func
    def polynomial(self, known, operator: ti.template(), x, y):
        """Return z . phi(x, y) of an operator, z being a row of ``known``."""
        value = 0.0
        for row in ti.static(self.horner):
            inner = 0.0
            for index in ti.static(row):
                inner *= y
                if ti.static(index >= 0):
                    inner += known[operator, index]
            value = value * x + inner
        return value

    @ti.func
    def apply(self, rows: ti.template(), values: ti.template(), i):
        """Return sum_j rows[i, j] (values[j] - values[i]); the sentinel's value must be finite."""
        own = values[i]
        total = 0.0 * own
        for group in range(self.points.count[i] // LANES):
            for lane in ti.static(range(LANES)):
                k = group * LANES + lane
                total += rows[i, k] * (values[self.points.table[i, k]] - own)
        return total
