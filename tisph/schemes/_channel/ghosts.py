"""Ghosts of the implicit scheme: points beyond the walls, whose values close the rows of the particles near them.

Of a field u that obeys u_t = nu u_yy + g near a wall with velocity U(t), the Taylor series in the distance d from the
wall gives for a particle F and its mirror image I

    u_I = 2 U - u_F + d^2 w_2 + d^4/12 w_4 + O(d^6),    w_2 = u_yy = (U' - g)/nu,  w_4 = u_yyyy = U''/nu^2

(the odd terms cancel; p_x = 0 at the wall as in ``walls/consistent_image.py``, of which this is the continuation to
the order of the operators): ``consistent_image``. Without the terms in w: ``comoving_image``, and ``virtual_image``,
where the ghosts stay on the lattice and u_F is interpolated at their mirror points: by a least-squares fit of c0 + c1 x
+ c2 y + c3 x^2 + c4 x y + c5 y^2 to the fluid particles around it (F. Bierbrauer, "No-Slip Boundary Conditions in
Smoothed Particle Hydrodynamics", slides 4 and 6, second way, whose fit is linear: the Laplacian of a fourth-order row
needs the curvature right).

At a massless stress-controlled wall it is the slope that is known, and the even terms cancel: ``even_reflection``, see
``schemes/_channel/stress_controlled.py``. The series is then one of odd powers.

Ghosts are few: except for the values that each iteration of a solver needs, NumPy computes all of them at once.
"""

import math

import numpy as np

from tisph.runtime import holding, real, scalar, ti, view

UNKNOWNS = 6

SMALLEST_PIVOT = 1e-8
"""Of the moments, scaled to the sum of the weights: below, the unknown is left out."""


@ti.data_oriented
class Ghosts:
    """Base of ghosts; arrays ``depth`` beyond wall ``side`` (0 bottom, 1 top), in the order of their slots.

    ``count``: how many there are. ``near``: the particles within ``cutoff`` of a wall, which have ghosts among their
    neighbours; ``offset``: their distance from each wall (2, near). ``listed``: those neighbours one after another, in
    the lists of the near particles ``row``. ``even_reflection``: of velocities in the (bottom, top) wall, else odd.
    """

    mirrors = False
    """Whether the points list the neighbours of mirror points."""

    even_reflection = (False, False)

    def __init__(self, points, channel, cutoff):
        self.points, self.gap, self.cutoff = points, channel.gap, cutoff
        self.count, self.needed = points.ghosts, 0
        self.side, self.depth = np.empty(0, dtype=np.int32), np.empty(0)
        self.series = np.zeros((2, 3))

    def find(self):
        """Place the ghosts for the present places of the particles, before neighbours are listed."""

    def follow(self):
        """Let the ghosts follow particles that have been shifted."""

    def prepare(self):
        """Find the particles near walls, and prepare the values of ghosts, at their final places."""
        height = self.heights()
        self.near = np.flatnonzero((height < self.cutoff) | (self.gap - height < self.cutoff))
        below = height[self.near].astype(float)
        self.offset = np.stack([below, self.gap - below])
        table, listed = self.points.listed_neighbours(self.near)
        self.row, self.entry = np.nonzero(listed & (table >= self.points.capacity) & (table < self.points.slots))
        self.listed = table[self.row, self.entry] - self.points.capacity

    def sums(self, rows, differences):
        """Return the sums over the ghosts in ``rows``, by near particle and by wall.

        ``differences`` of the value of each ghost in the lists of the near particles from that particle's.
        """
        shares = view(rows)[self.near[self.row], self.entry] * differences
        return np.bincount(self.row, shares, self.near.size), np.bincount(self.side[self.listed], shares, 2)

    def heights(self):
        """Return the y of the particles (fluid), in place."""
        return view(self.points.position)[: self.points.fluid, 1]

    def part(self, values):
        """Return the part of an array over the slots that belongs to the ghosts, in place."""
        return values[self.points.capacity :][: self.side.size]

    def overflow(self):
        """Return the number of ghosts if there was no room for them, else 0."""
        return self.needed if self.needed > self.points.ghost_capacity else 0

    def prescribe(self, bottom, top):
        """Take up the series of each wall, c0 + c1 d^2 + c2 d^4: three numbers; d times that with even reflection."""
        self.series[...] = bottom, top

    def boundary_values(self):
        """Return the series of its wall at each ghost."""
        constant, second, fourth = self.series[self.side].T
        square = self.depth * self.depth
        values = constant + square * (second + square * fourth)
        return np.where(self.sign() < 0.0, self.depth * values, values) if any(self.even_reflection) else values

    def series_slope(self):
        """Return the derivative across the channel of the series at each ghost."""
        constant, second, fourth = self.series[self.side].T
        square = self.depth * self.depth
        outwards = 2.0 * self.depth * (second + 2.0 * square * fourth)
        if any(self.even_reflection):
            odd = constant + square * (3.0 * second + 5.0 * square * fourth)
            outwards = np.where(self.sign() < 0.0, odd, outwards)
        return np.where(self.side == 1, outwards, -outwards)

    def sign(self):
        """Return 1 for each ghost, -1 beyond a wall with even reflection."""
        return np.where(np.array(self.even_reflection)[self.side], -1.0, 1.0)


@ti.data_oriented
class MirrorGhosts(Ghosts):
    """Mirror images: ghost k is the image of particle ``source[k]``."""

    def __init__(self, points, channel, cutoff):
        super().__init__(points, channel, cutoff)
        self.source = ti.field(ti.i32, shape=points.ghost_slots)

    @staticmethod
    def ghost_capacity(channel, cutoff):
        """Return the number of ghosts to have room for."""
        rows = math.ceil(1.5 * cutoff / channel.spacing) + 1
        return 2 * min(rows, channel.rows) * channel.columns

    def find(self):
        """Mirror every particle within cutoff of a wall."""
        height = self.heights()
        sources = [np.flatnonzero(height < self.cutoff), np.flatnonzero(self.gap - height < self.cutoff)]
        self.needed = sum(map(len, sources))
        count = min(self.needed, self.points.ghost_slots)
        self.side = np.repeat([0, 1], list(map(len, sources)))[:count]
        view(self.source)[:count] = np.concatenate(sources)[:count]
        view(self.count)[()] = count
        self.follow()

    def follow(self):
        """Place the ghosts where the mirror images of their sources are."""
        count, first, places = self.side.size, self.points.capacity, view(self.points.position)
        place = places[view(self.source)[:count]]
        height, top = place[:, 1].astype(float), self.side == 1
        self.depth = np.where(top, self.gap - height, height)
        place[:, 1] = np.where(top, 2.0 * self.gap - height, -height)
        places[first : first + count] = place

    def source_values(self, values):
        """Return the values of an array over the slots that the ghosts mirror."""
        return values[view(self.source)[: self.side.size]]

    @ti.func
    def value(self, values: ti.template(), k):
        """Return the value that ghost ``k`` mirrors."""
        return values[self.source[k]]


@ti.data_oriented
class FixedGhosts(Ghosts):
    """Fixed ghosts; ``share[k, n]`` is the weight of neighbour n of the mirror point of ghost k."""

    mirrors = True

    def __init__(self, points, channel, cutoff):
        super().__init__(points, channel, cutoff)
        self.share = ti.field(real(), shape=(points.ghost_slots, points.row_capacity))
        self.radius = scalar(cutoff)
        self.vector, self.matrix = ti.types.vector(UNKNOWNS, real()), ti.types.matrix(UNKNOWNS, UNKNOWNS, real())
        self.place(channel)

    @staticmethod
    def ghost_capacity(channel, cutoff):
        """Return the number of ghosts: all layers within cutoff."""
        return 2 * min(math.ceil(cutoff / channel.spacing), channel.rows) * channel.columns

    def place(self, channel):
        """Lay out the layers; they stay where they are."""
        layers = self.points.ghost_capacity // (2 * channel.columns)
        layer, column = np.divmod(np.arange(layers * channel.columns), channel.columns)
        x, depth = (column + 0.5) * channel.spacing, (layer + 0.5) * channel.spacing
        heights, mirrored = np.concatenate([-depth, channel.gap + depth]), np.concatenate([depth, channel.gap - depth])
        count, first = heights.size, self.points.capacity
        holding(self.points.position, _padded(np.stack([np.tile(x, 2), heights], 1), first, self.points.slots + 1))
        holding(self.points.mirror, _padded(np.stack([np.tile(x, 2), mirrored], 1), 0, self.points.ghost_slots))
        holding(self.count, count)
        self.depth, self.side = np.tile(depth, 2), np.repeat([0, 1], depth.size)

    def prepare(self):
        """Fit at all mirror points."""
        super().prepare()
        self.fit()

    @ti.kernel
    def fit(self):
        """Compute all shares."""
        ti.loop_config(serialize=self.points.serial)
        for k in range(self.count[None]):
            row = self.points.capacity + k
            moments = self.matrix(0.0)
            for n in range(self.points.count[row]):
                basis, weight = self.weighted_basis(k, self.points.neighbours[row, n])
                moments += weight * basis.outer_product(basis)
            coefficients = self.solved(moments)
            for n in range(self.points.count[row]):
                basis, weight = self.weighted_basis(k, self.points.neighbours[row, n])
                self.share[k, n] = weight * coefficients.dot(basis)

    @ti.func
    def weighted_basis(self, k, j):
        """Return basis and weight of point ``j`` around mirror point ``k``; the sentinel has the weight 0."""
        apart = self.points.position[j] - self.points.mirror[k]
        x, y = self.points.domain.minimum_image_x(apart.x) / self.radius[None], apart.y / self.radius[None]
        nearness = ti.max(0.0, 1.0 - x * x - y * y)
        inside = ti.cast(nearness > 0.0, self.share.dtype)
        x, y = x * inside, y * inside
        return self.vector(1.0, x, y, x * x, x * y, y * y), nearness * nearness

    @ti.func
    def solved(self, moments):
        """Return the first row of the inverse of ``moments``, by L D L^T; undetermined unknowns are left out."""
        lower, first = moments, self.vector(0.0)
        first[0] = 1.0
        for k in ti.static(range(UNKNOWNS)):
            usable = ti.cast(lower[k, k] > SMALLEST_PIVOT * moments[0, 0], self.share.dtype)
            inverse = usable / ti.select(usable > 0.0, lower[k, k], 1.0)
            for i in ti.static(range(k + 1, UNKNOWNS)):
                factor = lower[i, k] * inverse
                for j in ti.static(range(k + 1, UNKNOWNS)):
                    lower[i, j] -= factor * lower[k, j]
                first[i] -= factor * first[k]
        for back in ti.static(range(UNKNOWNS)):
            k = ti.static(UNKNOWNS - 1 - back)
            usable = ti.cast(lower[k, k] > SMALLEST_PIVOT * moments[0, 0], self.share.dtype)
            for j in ti.static(range(k + 1, UNKNOWNS)):
                first[k] -= lower[k, j] * first[j]
            first[k] *= usable / ti.select(usable > 0.0, lower[k, k], 1.0)
        return first

    def source_values(self, values):
        """Return the values at the mirror points, of an array over the slots or of two, (slots + 1, 2)."""
        count = self.side.size
        table, listed = self.points.listed_neighbours(slice(self.points.capacity, self.points.capacity + count))
        return np.einsum("nk,nk...->n...", np.where(listed, view(self.share)[:count], 0.0), values[table])

    @ti.func
    def value(self, values: ti.template(), k):
        """Return the value at the mirror point of ghost ``k``."""
        row = self.points.capacity + k
        total = 0.0 * values[0]
        for n in range(self.points.count[row]):
            total += self.share[k, n] * values[self.points.neighbours[row, n]]
        return total


def _padded(values, first, size):
    """Return an array of ``size`` with ``values`` from ``first`` on, else zeros."""
    after = size - first - len(values)
    return np.pad(values, [(first, after)] + [(0, 0)] * (values.ndim - 1))
