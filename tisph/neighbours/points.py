"""Points and their neighbours, found anew for each arrangement: for steps so long that no list outlives one.

Fluid particles 0 .. fluid-1 keep their numbers, so that nothing is copied; ghost points beyond the walls follow from
``fluid`` on, at most ``room`` of them, then one sentinel far away that pads rows. In shear flow rows of particles slide
along one another and stay near one another in memory.
"""

import math

from tisph.runtime import real, scalar, ti

LANES = 4
"""Rows are padded to a multiple of this with the sentinel, so that loops over them can be unrolled."""

ROOM = 1.6
"""Capacity of a row over the mean number of neighbours within reach."""


@ti.data_oriented
class Points:
    """Places (slots + 1) of all points; neighbours ``table[i, k]``, k < ``count[i]``, of the fluid within ``reach``.

    ``ghosts`` is the number of points beyond the walls at present. With ``mirrors`` the table goes on with a row for
    each ghost: the fluid particles around its mirror point ``mirror[k]``.
    """

    def __init__(self, channel, domain, reach, room, serial, mirrors=False):
        self.domain = domain
        self.serial = serial
        self.fluid = channel.rows * channel.columns
        self.slots = self.fluid + room
        self.sentinel = self.slots
        self.reach_squared = scalar(reach**2)
        # counted in spacings, of which length and gap are whole numbers: no cell is lost to rounding
        self.columns = int(channel.columns * channel.spacing / reach * (1 + 1e-12))
        self.rows = max(1, int(channel.rows * channel.spacing / reach * (1 + 1e-12)))
        if self.columns < 3:
            raise ValueError(f"{self.columns} cells along x: a pair and its periodic copy would both be listed")
        mean = math.pi * (reach / channel.spacing) ** 2
        self.capacity = math.ceil((ROOM * mean + LANES) / LANES) * LANES
        self.place = ti.field(ti.types.vector(2, real()), shape=self.slots + 1)
        self.ghosts = ti.field(ti.i32, shape=())
        self.mirrors = mirrors
        listed = self.slots if mirrors else self.fluid
        self.table = ti.field(ti.i32, shape=(listed, self.capacity))
        self.count = ti.field(ti.i32, shape=listed)
        if mirrors:
            self.mirror = ti.field(ti.types.vector(2, real()), shape=room)
        self.longest = ti.field(ti.i32, shape=())
        self.start = ti.field(ti.i32, shape=(self.rows + 2) * self.columns + 1)
        self.cell = ti.field(ti.i32, shape=self.slots)
        self.order = ti.field(ti.i32, shape=self.slots)
        far = 1e3 * (channel.gap + channel.length)
        self.place[self.sentinel] = [far, far]

    @ti.kernel
    def find_neighbours(self):
        """Sort all points into cells, stably, and list the neighbours of the fluid particles."""
        self.longest[None] = 0
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.sort()
        ti.loop_config(serialize=self.serial)
        for i in range(self.fluid):
            ti.atomic_max(self.longest[None], self.gather(i, self.place[i], self.slots))
        if ti.static(self.mirrors):
            ti.loop_config(serialize=self.serial)
            for k in range(self.ghosts[None]):
                ti.atomic_max(self.longest[None], self.gather(self.fluid + k, self.mirror[k], self.fluid))

    @ti.func
    def sort(self):
        """Fill ``order`` with the points cell by cell, row by row of cells, and ``start`` with where a cell begins."""
        total = self.fluid + self.ghosts[None]
        cells = (self.rows + 2) * self.columns
        for cell in range(cells + 1):
            self.start[cell] = 0
        for k in range(total):
            place = self.place[k]
            self.cell[k] = self.row_of(place.y, k) * self.columns + self.column_of(place.x)
            self.start[self.cell[k] + 1] += 1
        for cell in range(cells):
            self.start[cell + 1] += self.start[cell]
        for back in range(total):
            k = total - 1 - back
            # from the end of each cell to its beginning, which leaves in start[cell + 1] the beginning of the cell
            self.start[self.cell[k] + 1] -= 1
            self.order[self.start[self.cell[k] + 1]] = k

    @ti.func
    def first(self, cell):
        """Return where a cell begins in ``order``; one cell beyond the last gives the number of points."""
        begin = self.fluid + self.ghosts[None]
        if cell < (self.rows + 2) * self.columns:
            begin = self.start[cell + 1]
        return begin

    @ti.func
    def column_of(self, x):
        """Return the column of cells of ``x``, kept inside even where ``x`` is not a number."""
        column = ti.cast(self.domain.wrapped(x) / self.domain.length[None] * self.columns, ti.i32)
        return ti.max(0, ti.min(self.columns - 1, column))

    @ti.func
    def row_of(self, y, k):
        """Return the row of cells of point ``k`` at height ``y``: 1 .. rows for fluid, beyond them for ghosts."""
        row = ti.max(0, ti.min(self.rows - 1, ti.cast(y / self.domain.gap[None] * self.rows, ti.i32))) + 1
        if k >= self.fluid:
            row = ti.select(y < 0.0, 0, self.rows + 1)
        return row

    @ti.func
    def gather(self, i, place, end):
        """Fill row ``i`` of the table with the points before ``end`` around ``place``; return how many it needed.

        They come from the 3 x 3 cells around it.
        """
        column, row = self.column_of(place.x), self.row_of(place.y, 0)
        found = 0
        for near in range(row - 1, row + 2):
            cells = near * self.columns
            first = self.first(cells + ti.max(column - 1, 0))
            last = self.first(cells + ti.min(column + 2, self.columns))
            found = self.append(i, place, end, first, last, found)
            if column == 0 or column == self.columns - 1:
                other = cells + ti.select(column == 0, self.columns - 1, 0)
                found = self.append(i, place, end, self.first(other), self.first(other + 1), found)
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
        for s in range(first, last):
            j = self.order[s]
            apart = self.place[j] - place
            apart.x = self.domain.nearest(apart.x)
            self.table[i, ti.min(found, self.capacity - 1)] = j
            near = ti.cast(apart.dot(apart) < limit, ti.i32) * ti.cast(j != i, ti.i32)
            found += near * ti.cast(j < end, ti.i32)
        return found

    @ti.func
    def separation(self, i, j):
        """Return the vector from point ``i`` to point ``j``, to its nearest periodic copy."""
        apart = self.place[j] - self.place[i]
        apart.x = self.domain.nearest(apart.x)
        return apart

    def mean_length(self):
        """Return the mean number of neighbours within reach of a fluid particle, padding not counted."""
        count, table = self.count.to_numpy()[: self.fluid], self.table.to_numpy()[: self.fluid]
        listed = sum((table[:, k] != self.sentinel)[count > k].sum() for k in range(self.capacity))
        return float(listed) / self.fluid

    def overflow(self):
        """Return the longest row if it may not have fitted into the table, else 0."""
        longest = self.longest[None]
        return longest if longest >= self.capacity else 0
