"""Ghosts of the implicit scheme: points beyond the walls, whose values close the rows of the particles near them.

Of a field u that obeys u_t = nu u_yy + g near a wall with velocity U(t), the Taylor series in the distance d from the
wall gives for a particle F and its mirror image I

    u_I = 2 U - u_F + d^2 w_2 + d^4/12 w_4 + O(d^6),    w_2 = u_yy = (U' - g)/nu,  w_4 = u_yyyy = U''/nu^2

(the odd terms cancel; p_x = 0 at the wall as in ``walls/consistent_image.py``, of which this is the continuation to
the order of the operators): ``consistent_image``. Without the terms in w: ``comoving_image``, and ``virtual_image``,
where the ghosts stay on the lattice and u_F is interpolated at their mirror points.

At a massless stress-controlled wall it is the slope that is known, and the even terms cancel: ``even_reflection``, see
``schemes/_stages/massless_wall.py``. The series is then one of odd powers.

There are few of them: what is not asked for in each iteration of a solver is computed by NumPy, for all at once.
"""

import math

import numpy as np

from tisph.runtime import ti, view


@ti.data_oriented
class Ghosts:
    """What all ghosts have; arrays ``depth`` beyond wall ``side`` (0 bottom, 1 top), in the order of their slots.

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
        """Take note of the particles near walls, and prepare what ghosts take from them, at their final places."""
        height = self.heights()
        self.near = np.flatnonzero((height < self.cutoff) | (self.gap - height < self.cutoff))
        below = height[self.near].astype(float)
        self.offset = np.stack([below, self.gap - below])
        table, listed = self.points.listed_neighbours(self.near)
        self.row, self.entry = np.nonzero(listed & (table >= self.points.capacity) & (table < self.points.slots))
        self.listed = table[self.row, self.entry] - self.points.capacity

    def sums(self, rows, differences):
        """Return the sums of what ghosts contribute to ``rows``, by near particle and by wall.

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
        """Return what the series of its wall prescribes for each ghost."""
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

    def parities(self, *usual):
        """Return the parities of fields of the velocity along the channel, ``usual`` but for even reflections."""
        usual = np.array(usual)
        return np.multiply.outer(self.sign(), usual) if any(self.even_reflection) else usual


@ti.data_oriented
class MirrorGhosts(Ghosts):
    """Mirror images: ghost k is that of particle ``source[k]``."""

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
