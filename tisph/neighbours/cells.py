"""Particles of the explicit scheme, sorted into cells.

The cells of the fluid fill the channel in rows 1 .. rows; row 0 lies below the bottom wall and row rows + 1
above the top wall. Rows follow one another in memory as 1 .. rows, then rows + 1, then 0: the fluid comes
first. In a box that is periodic both ways those two are empty, and stand for their copies inside; wall particles
of bodies in it are in rows rows + 1 .. 2 rows, which cover the box once more.
"""

import numpy as np

from tisph.neighbours.counting_sort import counting_sort
from tisph.runtime import integer, ti
from tisph.size_class import size_class


@ti.data_oriented
class Cells:
    """Cells no smaller than ``cutoff`` (the radius of the neighbour lists), fitted to the box.

    ``rows`` and ``columns`` are not compiled in; ``levels`` are these rows and those of wall particles.
    ``order[n]`` is the slot of the n-th particle, cell by cell;
    ``start[place(row, column)]`` is the first slot of a cell and ``start[place(row, columns)]`` the end of its row, so
    that neighbouring cells of one row are one range of slots.
    """

    def __init__(self, particles, domain, channel, cutoff):
        self.particles = particles
        self.domain = domain
        # counted in spacings, of which length and gap are whole numbers: no cell is lost to round-off
        columns = int(channel.columns / (cutoff / channel.spacing))
        rows = cell_rows(channel, cutoff)
        if columns < 3 or (domain.periodic_y and rows < 3):
            axis = f"{columns} cells along x" if columns < 3 else f"{rows} cells along y"
            raise ValueError(f"{axis}: a pair and its periodic copy would both be listed")
        levels = 2 * rows + 1 if domain.periodic_y and particles.has_walls else rows + 2
        self.rows, self.columns, self.levels = integer(rows), integer(columns), integer(levels)
        cells = size_class(levels * (columns + 1))
        self.start = ti.field(ti.i32, shape=cells)
        self.start.used = np.s_[: levels * (columns + 1)]
        self.begin = ti.field(ti.i32, shape=size_class(levels * columns + 2))
        self.cell = ti.field(ti.i32, shape=particles.mobile_slots)
        self.order = ti.field(ti.i32, shape=particles.mobile_slots)
        self.begin.used = self.cell.used = self.order.used = None  # after a sort of no use

    @ti.func
    def place(self, row, column):
        """Return the place of a cell in ``start``."""
        return row * (self.columns[None] + 1) + column

    @ti.func
    def column_of(self, x):
        """Return the column of ``x``, kept inside even where ``x`` is not a number."""
        column = ti.cast(x / self.domain.length[None] * self.columns[None], ti.i32)
        return ti.max(0, ti.min(self.columns[None] - 1, column))

    @ti.func
    def row_of(self, y, k):
        """Return the row of particle ``k`` at height ``y``: 1 .. rows for fluid, more or 0 for wall particles."""
        rows = self.rows[None]
        row = ti.max(0, ti.min(rows - 1, ti.cast(y / self.domain.height[None] * rows, ti.i32))) + 1
        if k >= self.particles.first_wall:
            row = row + rows if ti.static(self.domain.periodic_y) else ti.select(y < 0.0, 0, rows + 1)
        return row

    @ti.kernel
    def sort(self, now: ti.i32):
        """Wrap the particles into the period and fill ``order`` and ``start`` from their positions."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            levels, columns = self.levels[None], self.columns[None]
            fluid, mobile = self.particles.fluid_number[None], self.particles.mobile_number[None]
            for number in range(mobile):
                k = self.particles.slot(number)
                self.wrap(now, k)
                position = self.particles.mid_position[now, k]
                rank = (self.row_of(position.y, k) + levels - 1) % levels
                self.cell[k] = rank * columns + self.column_of(position.x)
            walls = ti.Vector([mobile - fluid, self.particles.first_wall])
            counting_sort(self.cell, self.begin, self.order, levels * columns, fluid, walls)
            for cell in range(levels * columns):
                row, column = (cell // columns + 1) % levels, cell % columns
                offset = ti.select(cell < self.rows[None] * columns, 0, self.particles.first_wall - fluid)
                self.start[self.place(row, column)] = self.begin[cell + 1] + offset
                self.start[self.place(row, column + 1)] = self.begin[cell + 2] + offset

    @ti.func
    def wrap(self, now, k):
        """Move particle ``k`` by whole periods so that its mid-step position lies in the box."""
        place = self.particles.mid_position[now, k]
        inside = ti.Vector([self.domain.wrap_x(place.x), place.y])
        if ti.static(self.domain.periodic_y):
            inside = self.domain.wrap(place)
        self.particles.mid_position[now, k] = inside
        if k < self.particles.first_wall:
            self.particles.position[now, k] += inside - place


def cell_rows(channel, cutoff):
    """Return the number of rows of cells, each at least ``cutoff`` high, between the walls."""
    return max(1, int(channel.rows / (cutoff / channel.spacing)))
