"""Points and their neighbours, found anew for each arrangement: implicit steps are so long that no list outlives one.

Fluid particles 0 .. fluid-1 keep their numbers, so that nothing is copied; ghost points beyond the walls follow from
``capacity`` on, then one sentinel far away that pads rows. In shear flow whole layers of particles move past one
another, so that neighbours in space stay near one another in memory.
"""

import math
from typing import Any

import numpy as np

from tisph.numerics.counting_sort import counting_sort, slot_of
from tisph.numerics.domain import ChannelDomain, PeriodicDomain
from tisph.runtime import CHUNK, holding, integer, real, scalar, threads, ti, view
from tisph.size_class import size_class

LANES = 4
"""Rows are padded to a multiple of this with the sentinel, so that loops over them can be unrolled."""

CAPACITY_FACTOR = 1.6
"""Largest number of neighbours over the mean number within the cutoff."""

CELLS_WITHIN = 3
"""Cells within the cutoff along an axis. With 1 the search took up to 1.5 times as long, since three of four candidates
were beyond the cutoff."""

ROOM = 1.3
"""Particles that there is room for, over those at the start, where the spacing varies."""

GRADED_FACTOR = 1.8
"""Mean number of neighbours where the spacing varies, over the mean elsewhere: supports are wider there. Points on
walls at the coarse edge of a fine part had 1.35 times as many."""

WALL_FACTOR = 1.3
"""Mean number of neighbours near walls, where some cutoffs are larger, over the mean elsewhere."""


def active(field: Any) -> np.ndarray:
    """Return the values (..., points) of a field of ``PointCloud.field`` at the points, as a view."""
    return view(field)[field.used]


@ti.data_oriented
class PointCloud:
    """Positions of all points: fluid particle i has slot i, ghost k slot ``capacity`` + k.

    In a ``PeriodicDomain`` there are no ghosts, and positions must be inside the box. ``particles`` and ``ghosts`` are
    their present numbers; there is space for ``ghost_capacity``. ``capacity``, ``slots`` and the ``sentinel`` after
    them depend only on the size class and may be compiled in, ``fluid`` may not. ``fluid`` and ``particles`` also
    count the points ``on_walls``, which follow the particles; ``in_fluid`` and ``n_fluid`` do not. ``cutoff`` [length]:
    a number, or the usual and the largest cutoff, below twice the usual one; then each point has its own, ``radius``.
    ``finest``: smallest spacing over the largest; below 1 each point has its own, ``relative_spacing``, and there is
    room for more particles. ``flow``: has ``particles``, ``columns``, ``rows``, ``spacing``, and where cutoffs vary
    ``crowding``, a factor of the largest number of neighbours.

    Neighbours of particle i within the cutoff are ``neighbours[k]``, ``begin[i]`` <= k < ``end[i]``, a row; fields
    with a number for each of them have the size ``entries``. Rows follow one another without gaps, for each thread:
    with room for the longest between them, steps take up to half as long again. A row has at most ``row_capacity``
    entries. With ``mirrors`` each ghost has a row, too: the fluid particles around its mirror point ``mirror[k]``.
    """

    def __init__(
        self,
        flow: Any,
        domain: PeriodicDomain | ChannelDomain,
        cutoff: float | tuple[float, float],
        ghost_capacity: int,
        serial: bool,
        mirrors: bool = False,
        on_walls: int = 0,
        finest: float = 1.0,
    ):
        self.domain = domain
        self.serial = serial
        self.fluid, self.in_fluid, self.ghost_capacity = flow.particles, flow.particles - on_walls, ghost_capacity
        self.particles, self.n_fluid, self.ghosts = integer(self.fluid), integer(self.in_fluid), integer(0)
        self.graded = finest < 1.0
        room = ROOM if self.graded else 1.0
        self.capacity, self.ghost_slots = size_class(room * self.fluid), size_class(self.ghost_capacity)
        self.counted: list[Any] = []
        self.slots = self.sentinel = self.capacity + self.ghost_slots
        self.varying = isinstance(cutoff, tuple)
        usual, largest = cutoff if isinstance(cutoff, tuple) else (cutoff, cutoff)
        self.cutoff_squared = scalar(usual**2)
        if self.varying:
            self.radius = ti.field(real(), shape=self.capacity)
        if self.graded:
            self.relative_spacing = holding(ti.field(real(), shape=self.capacity), 1.0)
        # counted in spacings: length and height are whole numbers of spacings, and no cell is lost to round-off
        side = finest * usual / CELLS_WITHIN
        columns = int(flow.columns * flow.spacing / side * (1 + 1e-12))
        rows = max(1, int(flow.rows * flow.spacing / side * (1 + 1e-12)))
        least = 2 * math.ceil(largest / side) + 1
        if columns < least or (domain.periodic_y and rows < least):
            axis = f"{columns} cells along x" if columns < least else f"{rows} cells along y"
            raise ValueError(f"{axis}: a pair and its periodic copy would both be listed")
        self.side = scalar(side)
        self.columns, self.rows = integer(columns), integer(rows)
        mean = math.pi * (usual / flow.spacing) ** 2 * (WALL_FACTOR * flow.crowding if self.varying else 1.0)
        mean *= GRADED_FACTOR if self.graded else 1.0
        self.row_capacity = math.ceil((CAPACITY_FACTOR * mean + LANES) / LANES) * LANES
        self.position = ti.field(ti.types.vector(2, real()), shape=self.slots + 1)
        self.mirrors = mirrors
        listed = self.slots if mirrors else self.capacity
        self.entries = listed * self.row_capacity
        self.neighbours = ti.field(ti.i32, shape=self.entries)
        self.begin, self.end = ti.field(ti.i32, shape=listed), ti.field(ti.i32, shape=listed)
        self.workers = 1 if serial else threads()
        if mirrors:
            self.mirror = ti.field(ti.types.vector(2, real()), shape=self.ghost_slots)
        self.longest = integer(0)
        self.start = ti.field(ti.i32, shape=size_class((rows + 2) * columns + 2))
        self.cell = ti.field(ti.i32, shape=self.slots)
        self.order = ti.field(ti.i32, shape=self.slots)
        self.far = scalar(1e3 * flow.spacing * (flow.rows + flow.columns))

    @property
    def on_walls(self) -> slice:
        """Slots of the points on walls."""
        return slice(self.in_fluid, self.fluid)

    def set_spacing(self, relative: np.ndarray) -> None:
        """Set the ``relative`` spacing (points,) of each point, over the largest one."""
        view(self.relative_spacing)[: self.fluid] = relative

    @property
    def areas(self) -> Any:
        """Areas (in_fluid,) of the particles over that of one of the largest spacing."""
        return np.square(view(self.relative_spacing)[: self.in_fluid].astype(float)) if self.graded else 1.0

    @property
    def area(self) -> float:
        """Sum of these areas."""
        return float(self.areas.sum()) if self.graded else self.in_fluid

    def resize(self, inside: int, on_walls: int) -> None:
        """Let there be ``inside`` particles, with the points ``on_walls`` after them."""
        self.fluid, self.in_fluid = inside + on_walls, inside
        view(self.particles)[()], view(self.n_fluid)[()] = self.fluid, inside
        for field in self.counted:
            field.used = (*field.used[:-1], slice(self.fluid))

    @ti.func
    def relative(self, i):
        """Return the spacing at a point over the largest one."""
        result = 1.0
        if ti.static(self.graded):
            result *= self.relative_spacing[i]
        return result

    def field(self, kind: Any, *axes: int) -> Any:
        """Return a field of ``kind`` with a value for each fluid particle along its last axis; see ``active``."""
        return self.count(ti.field(kind, (*axes, self.capacity)))

    def count(self, field: Any) -> Any:
        """Return a ``field`` with a value for each point along its last axis, of which those of the points count."""
        field.used = (*[slice(None)] * (len(field.shape) - 1), slice(self.fluid))
        self.counted.append(field)
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
        for turn in range(self.workers * CHUNK):  # a chunk for each thread, which works in its first turn
            if turn % CHUNK == 0:
                self.fill(turn // CHUNK, particles)

    @ti.func
    def fill(self, worker, particles):
        """Fill the rows of a thread one after another."""
        rows = particles
        if ti.static(self.mirrors):
            rows += self.ghosts[None]
        first, last = worker * rows // self.workers, (worker + 1) * rows // self.workers
        free, longest = first * self.row_capacity, 0
        for number in range(first, last):
            i = slot_of(number, particles, self.capacity)
            centre, end = self.position[i], self.slots
            if ti.static(self.mirrors):
                of_ghost = number >= particles
                centre = ti.select(of_ghost, self.mirror[ti.max(0, number - particles)], centre)
                end = ti.select(of_ghost, self.capacity, end)
            found = self.gather(i, free, centre, end)
            longest, free = ti.max(longest, found), self.end[i]
        ti.atomic_max(self.longest[None], longest)

    @ti.func
    def sort(self, particles):
        """Fill ``order`` with the points cell by cell, row by row, and ``start`` with the first point of each cell."""
        self.position[self.sentinel] = [self.far[None], self.far[None]]
        ghosts = self.ghosts[None]
        for number in range(particles + ghosts):
            k = slot_of(number, particles, self.capacity)
            position = self.position[k]
            self.cell[k] = self.row_of(position.y, k) * self.columns[None] + self.column_of(position.x)
        cells = (self.rows[None] + 2) * self.columns[None]
        counting_sort(self.cell, self.start, self.order, cells, particles, ti.Vector([ghosts, self.capacity]))

    @ti.func
    def column_of(self, x):
        """Return the column of cells of ``x``, kept inside even where ``x`` is not a number."""
        columns = self.columns[None]
        column = ti.cast(self.domain.wrap_x(x) / self.domain.length[None] * columns, ti.i32)
        return ti.max(0, ti.min(columns - 1, column))

    @ti.func
    def row_of(self, y, k):
        """Return the row of cells of point ``k`` at height ``y``: 1 .. rows for fluid, beyond them for ghosts."""
        rows = self.rows[None]
        row = ti.max(0, ti.min(rows - 1, ti.cast(y / self.domain.height[None] * rows, ti.i32))) + 1
        if k >= self.capacity:
            row = ti.select(y < 0.0, 0, rows + 1)
        return row

    @ti.func
    def gather(self, i, free, centre, end):
        """Fill row ``i``, from entry ``free`` on, with the points before ``end`` around ``centre``; return how many.

        They come from the cells around it, ``span`` on each side: in a row first the cells before the end of the
        period, then the cells beyond it. Ghosts beyond a wall are in one row of cells, however deep they lie.
        """
        columns, column, row = self.columns[None], self.column_of(centre.x), self.row_of(centre.y, 0)
        found, span, rows, limit = 0, CELLS_WITHIN, self.rows[None], self.cutoff_squared[None]
        if ti.static(self.varying):
            span = ti.max(span, ti.cast(ti.ceil(self.radius[i] / self.side[None]), ti.i32))
            limit = self.radius[i] ** 2
        lowest, highest = row - span, row + span
        if ti.static(not self.domain.periodic_y):
            lowest, highest = ti.max(lowest, 0), ti.min(highest, rows + 1)
        for level in range(lowest, highest + 1):
            near = level
            if ti.static(self.domain.periodic_y):
                near = self.domain.wrap_row(level, rows)
            first, last = ti.max(column - span, 0), ti.min(column + span + 1, columns)
            for _ in range(ti.select(column < span or column >= columns - span, 2, 1)):
                for s in range(self.start[near * columns + first + 1], self.start[near * columns + last + 1]):
                    j = self.order[s]  # without a branch: the next point overwrites one that is no neighbour
                    apart = self.domain.minimum_image(self.position[j] - centre)
                    self.neighbours[free + ti.min(found, self.row_capacity - 1)] = j
                    is_near = ti.cast(apart.dot(apart) < limit, ti.i32) * ti.cast(j != i, ti.i32)
                    found += is_near * ti.cast(j < end, ti.i32)
                before = column < span
                first = ti.select(before, columns + column - span, 0)
                last = ti.select(before, columns, column + span + 1 - columns)
        filled = ti.min(found, self.row_capacity)
        padded = (filled + LANES - 1) // LANES * LANES
        for k in range(filled, padded):
            self.neighbours[free + k] = self.sentinel
        self.begin[i], self.end[i] = free, free + padded
        return found

    @ti.func
    def separation(self, i, j):
        """Return the vector from point ``i`` to point ``j``, to its nearest periodic copy."""
        return self.domain.minimum_image(self.position[j] - self.position[i])

    def rows_of(self, chosen: np.ndarray | slice) -> tuple[np.ndarray, np.ndarray]:
        """Return the entries of the rows ``chosen``, (rows, row_capacity), and which of them are a row's own."""
        entries = view(self.begin)[chosen, None] + np.arange(self.row_capacity)
        return np.minimum(entries, self.entries - 1), entries < view(self.end)[chosen, None]

    def mean_length(self) -> float:
        """Return the mean number of neighbours within the cutoff of a fluid particle, padding not counted."""
        begin, end = view(self.begin)[: self.fluid, None], view(self.end)[: self.fluid, None]
        last = end - np.arange(1, LANES)  # a row ends with fewer sentinels than this
        padding = np.count_nonzero((last >= begin) & (view(self.neighbours)[last] == self.sentinel))
        return float((end - begin).sum() - padding) / self.fluid

    def overflow(self) -> int:
        """Return the longest row if it may not have fitted into the table, else 0."""
        longest = int(view(self.longest))
        return longest if longest >= self.row_capacity else 0
