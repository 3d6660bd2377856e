"""Cell binning by a stable counting sort.

The cells of the fluid fill the channel in rows 1 .. rows; row 0 lies below the bottom wall and row rows + 1
above the top wall. Rows follow one another in memory as 1 .. rows, then rows + 1, then 0: the fluid comes
first. A stable sort, without atomics, gives the same order whatever the number of threads.
"""

from tisph.runtime import ti


@ti.data_oriented
class Cells:
    """Cells no smaller than ``reach`` (the radius of the neighbour lists), fitted to the channel.

    ``start[row, column]`` is the first slot of a cell and ``start[row, columns]`` the end of its row, so that
    neighbouring cells of one row are one range of slots.
    """

    def __init__(self, particles, domain, channel, reach):
        self.particles = particles
        self.domain = domain
        # counted in spacings, of which length and gap are whole numbers: no cell is lost to rounding
        self.columns = int(channel.columns / (reach / channel.spacing))
        self.rows = cell_rows(channel, reach)
        if self.columns < 3:
            raise ValueError(f"{self.columns} cells along x: a pair and its periodic copy would both be listed")
        self.start = ti.field(ti.i32, shape=(self.rows + 2, self.columns + 1))
        self.cursor = ti.field(ti.i32, shape=(self.rows + 2) * self.columns)
        self.cell = ti.field(ti.i32, shape=particles.mobile)
        self.order = ti.field(ti.i32, shape=particles.mobile)

    @ti.func
    def column_of(self, x):
        """Return the column of ``x``, kept inside even where ``x`` is not a number."""
        column = ti.cast(x / self.domain.length[None] * self.columns, ti.i32)
        return ti.max(0, ti.min(self.columns - 1, column))

    @ti.func
    def row_of(self, y, k):
        """Return the row of particle ``k`` at height ``y``: 1 .. rows for fluid, beyond for wall particles."""
        row = ti.max(0, ti.min(self.rows - 1, ti.cast(y / self.domain.gap[None] * self.rows, ti.i32))) + 1
        if k >= self.particles.fluid:
            row = ti.select(y < 0.0, 0, self.rows + 1)
        return row

    @ti.kernel
    def sort(self, now: ti.i32):
        """Wrap the particles into the period and fill ``order`` and ``start`` from their positions."""
        rows = ti.static(self.rows + 2)
        ti.loop_config(serialize=True)
        for _ in range(1):
            for cell in range(rows * self.columns):
                self.cursor[cell] = 0
            for k in range(self.particles.mobile):
                self.wrap(now, k)
                place = self.particles.mid_position[now, k]
                rank = (self.row_of(place.y, k) + rows - 1) % rows
                self.cell[k] = rank * self.columns + self.column_of(place.x)
                self.cursor[self.cell[k]] += 1
            slot = 0
            for cell in range(rows * self.columns):
                row = (cell // self.columns + 1) % rows
                count = self.cursor[cell]
                self.start[row, cell % self.columns] = slot
                self.cursor[cell] = slot
                slot += count
                self.start[row, cell % self.columns + 1] = slot
            for k in range(self.particles.mobile):
                self.order[self.cursor[self.cell[k]]] = k
                self.cursor[self.cell[k]] += 1

    @ti.func
    def wrap(self, now, k):
        """Move particle ``k`` by whole lengths so that its mid-step position lies in [0, length)."""
        x = self.particles.mid_position[now, k].x
        inside = self.domain.wrapped(x)
        self.particles.mid_position[now, k].x = inside
        if k < self.particles.fluid:
            self.particles.position[now, k].x += inside - x


def cell_rows(channel, reach):
    """Return the number of rows of cells, each at least ``reach`` high, between the walls."""
    return max(1, int(channel.rows / (reach / channel.spacing)))
