"""Points and their neighbours, found anew for each arrangement: for steps so long that no list outlives one.

Fluid particles 0 .. fluid-1 keep their numbers, so that nothing is copied; ghost points beyond the walls follow from
``most`` on, then one sentinel far away that pads rows. In shear flow rows of particles slide along one another and stay
near one another in memory.
"""

import math

import numpy as np

from tisph.runtime import integer, real, scalar, size_class, ti, view

LANES = 4
"""Rows are padded to a multiple of this with the sentinel, so that loops over them can be unrolled."""

ROOM = 1.6
"""Capacity of a row over the mean number of neighbours within reach."""

WIDER = 1.3
"""That mean near walls, where some reach farther, over the one elsewhere."""


def used(field):
    """Return what the fluid particles use of a field that ``Points`` made for them, in place: (..., fluid)."""
    return view(field)[field.used]


@ti.data_oriented
class Points:
    """Places of all points, of which fluid particle i has slot i and ghost k slot ``most`` + k.

    ``domain`` is that of a channel or a ``PeriodicBox``, without ghosts; there places must be inside the box.
    ``particles`` and ``ghosts`` are their numbers at present; there is ``room`` for ghosts. ``most``, ``slots`` and the
    ``sentinel`` after them depend on a rung of the ladder of sizes alone: they may be compiled in, ``fluid`` may not.
    Neighbours of the fluid within ``reach`` are ``table[i, k]``, k < ``count[i]``. With ``mirrors`` the table goes on
    with a row for each ghost, in its slot: the fluid particles around its mirror point ``mirror[k]``. Where
    ``reach`` is a pair, the usual and the largest one, less than twice that, each point has its own, ``radius``.
    """

    def __init__(self, channel, domain, reach, room_for_ghosts, serial, mirrors=False):
        self.domain = domain
        self.serial = serial
        self.fluid, self.room = channel.particles, room_for_ghosts
        self.particles, self.ghosts = integer(self.fluid), integer(0)
        self.liquid = self.particles
        self.most, self.most_ghosts = size_class(self.fluid), size_class(self.room)
        self.slots = self.sentinel = self.most + self.most_ghosts
        self.varying = isinstance(reach, tuple)
        reach, largest = reach if self.varying else (reach, reach)
        self.reach_squared = scalar(reach**2)
        if self.varying:
            self.radius = ti.field(real(), shape=self.most)
        # counted in spacings, of which length and gap are whole numbers: no cell is lost to rounding
        columns = int(channel.columns * channel.spacing / reach * (1 + 1e-12))
        rows = max(1, int(channel.rows * channel.spacing / reach * (1 + 1e-12)))
        least = 5 if largest > reach else 3
        if columns < least or (domain.open_across and rows < least):
            axis = f"{columns} cells along x" if columns < 3 else f"{rows} cells along y"
            raise ValueError(f"{axis}: a pair and its periodic copy would both be listed")
        self.columns, self.rows = integer(columns), integer(rows)
        mean = math.pi * (reach / channel.spacing) ** 2 * (WIDER if self.varying else 1.0)
        self.capacity = math.ceil((ROOM * mean + LANES) / LANES) * LANES
        self.place = ti.field(ti.types.vector(2, real()), shape=self.slots + 1)
        self.mirrors = mirrors
        listed = self.slots if mirrors else self.most
        self.table = ti.field(ti.i32, shape=(listed, self.capacity))
        self.count = ti.field(ti.i32, shape=listed)
        if mirrors:
            self.mirror = ti.field(ti.types.vector(2, real()), shape=self.most_ghosts)
        self.longest = integer(0)
        self.start = ti.field(ti.i32, shape=size_class((rows + 2) * columns + 2))
        self.cell = ti.field(ti.i32, shape=self.slots)
        self.order = ti.field(ti.i32, shape=self.slots)
        self.far = scalar(1e3 * (channel.gap + channel.length))

    def field(self, kind, *axes):
        """Return a field of ``kind`` with a number for each fluid particle along its last axis; see ``used``."""
        field = ti.field(kind, (*axes, self.most))
        field.used = (*[slice(None)] * len(axes), slice(self.fluid))
        return field

    @ti.kernel
    def find_neighbours(self):
        """Sort all points into cells, stably, and list the neighbours of the fluid particles."""
        self.longest[None] = 0
        particles = self.particles[None]
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.sort(particles)
        ti.loop_config(serialize=self.serial)
        for i in range(particles):
            ti.atomic_max(self.longest[None], self.gather(i, self.place[i], self.slots))
        if ti.static(self.mirrors):
            ti.loop_config(serialize=self.serial)
            for k in range(self.ghosts[None]):
                ti.atomic_max(self.longest[None], self.gather(self.most + k, self.mirror[k], self.most))

    @ti.func
    def sort(self, particles):
        """Fill ``order`` with the points cell by cell, row by row of cells, and ``start`` with where a cell begins."""
        self.place[self.sentinel] = [self.far[None], self.far[None]]
        total = particles + self.ghosts[None]
        cells = (self.rows[None] + 2) * self.columns[None]
        for cell in range(cells + 1):
            self.start[cell] = 0
        self.start[cells + 1] = total
        for number in range(total):
            k = self.slot(number, particles)
            place = self.place[k]
            self.cell[k] = self.row_of(place.y, k) * self.columns[None] + self.column_of(place.x)
            self.start[self.cell[k] + 1] += 1
        for cell in range(cells):
            self.start[cell + 1] += self.start[cell]
        for back in range(total):
            k = self.slot(total - 1 - back, particles)
            # from the end of each cell to its beginning, which leaves in start[cell + 1] the beginning of the cell
            self.start[self.cell[k] + 1] -= 1
            self.order[self.start[self.cell[k] + 1]] = k

    @ti.func
    def slot(self, number, particles):
        """Return the slot of a point counted without a gap between fluid and ghosts."""
        return number + ti.select(number < particles, 0, self.most - particles)

    @ti.func
    def column_of(self, x):
        """Return the column of cells of ``x``, kept inside even where ``x`` is not a number."""
        columns = self.columns[None]
        column = ti.cast(self.domain.wrapped(x) / self.domain.length[None] * columns, ti.i32)
        return ti.max(0, ti.min(columns - 1, column))

    @ti.func
    def row_of(self, y, k):
        """Return the row of cells of point ``k`` at height ``y``: 1 .. rows for fluid, beyond them for ghosts."""
        rows = self.rows[None]
        row = ti.max(0, ti.min(rows - 1, ti.cast(y / self.domain.gap[None] * rows, ti.i32))) + 1
        if k >= self.most:
            row = ti.select(y < 0.0, 0, rows + 1)
        return row

    @ti.func
    def gather(self, i, place, end):
        """Fill row ``i`` of the table with the points before ``end`` around ``place``; return how many it needed.

        They come from the 3 x 3 cells around it, or 5 x 5: in a row those before the end of the period, then those
        beyond it.
        """
        columns, column, row = self.columns[None], self.column_of(place.x), self.row_of(place.y, 0)
        found, span = 0, 1
        if ti.static(self.varying):
            span = ti.select(self.radius[i] ** 2 > self.reach_squared[None], 2, 1)
        for level in range(row - span, row + span + 1):
            near = level
            if ti.static(self.domain.open_across):
                near = self.domain.row_inside(level, self.rows[None])
            first, last = ti.max(column - span, 0), ti.min(column + span + 1, columns)
            for _ in range(ti.select(column < span or column >= columns - span, 2, 1)):
                begin = self.start[near * columns + first + 1]
                found = self.append(i, place, end, begin, self.start[near * columns + last + 1], found)
                before = column < span
                first = ti.select(before, columns + column - span, 0)
                last = ti.select(before, columns, column + span + 1 - columns)
        filled = ti.min(found, self.capacity)
        padded = (filled + LANES - 1) // LANES * LANES
        for k in range(filled, padded):
            self.table[i, k] = self.sentinel
        self.count[i] = padded
        return found

    @ti.func
    def append(self, i, place, end, first, last, found):
        """Append what is within reach of ``order[first .. last-1]``, without a branch; return the new count."""
        limit = self.reach_squared[None]
        if ti.static(self.varying):
            limit = self.radius[i] ** 2
        for s in range(first, last):
            j = self.order[s]
            apart = self.domain.shortest(self.place[j] - place)
            self.table[i, ti.min(found, self.capacity - 1)] = j
            near = ti.cast(apart.dot(apart) < limit, ti.i32) * ti.cast(j != i, ti.i32)
            found += near * ti.cast(j < end, ti.i32)
        return found

    @ti.func
    def separation(self, i, j):
        """Return the vector from point ``i`` to point ``j``, to its nearest periodic copy."""
        return self.domain.shortest(self.place[j] - self.place[i])

    def listed(self, rows):
        """Return the table of the chosen ``rows`` and where it holds points and no left-overs, (chosen, capacity)."""
        return view(self.table)[rows], np.arange(self.capacity) < view(self.count)[rows, None]

    def mean_length(self):
        """Return the mean number of neighbours within reach of a fluid particle, padding not counted."""
        count, table = view(self.count)[: self.fluid], view(self.table)[: self.fluid]
        listed = sum(np.count_nonzero((table[:, k] != self.sentinel) & (count > k)) for k in range(self.capacity))
        return listed / self.fluid

    def overflow(self):
        """Return the longest row if it may not have fitted into the table, else 0."""
        longest = int(view(self.longest))
        return longest if longest >= self.capacity else 0
