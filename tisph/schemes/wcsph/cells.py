"""Particles of the explicit scheme, in cells.

The cells of the fluid fill the box in rows 1 .. rows. In a channel row 0 lies below the bottom wall and row rows + 1
above the top wall; rows follow one another in memory as 1 .. rows, then rows + 1, then 0, so that the fluid comes
first. In a box that is periodic in x and y rows 0 and rows + 1 are empty, and stand for their periodic copies; wall
particles of bodies are in rows rows + 1 .. 2 rows, which cover the box once more.
"""

from typing import Any

import numpy as np

from tisph.numerics.counting_sort import counting_sort
from tisph.numerics.domain import ChannelDomain, Lattice, PeriodicDomain
from tisph.runtime import integer, real, ti, view
from tisph.size_class import size_class


@ti.data_oriented
class Particles:
    """Fluid particles in slots 0 .. fluid-1, wall particles from slot ``first_wall`` on.

    Each field has two buffers, shape (2, slots): a step, and a sort, reads buffer ``now`` and writes buffer
    ``1 - now``. ``position``, ``velocity``, ``compression`` (density / reference density - 1, which keeps its digits in
    single precision) are the state of the fluid at the end of a step. The ``mid_`` fields are the state in the middle
    of the coming step, of fluid and walls, which the neighbours read. ``identity`` (fluid) is the number that a
    particle was created with; sorting permutes it. With ``carries_stress`` there are also ``stress`` and
    ``mid_stress``: xx, xy, yy over the reference density.

    Wall slots hold either ``dummies``, particles of their own that are sorted too, or images of fluid particles, for
    which there is room up to ``slots``. Fields are larger, and the beginnings of their parts are compiled in. The
    numbers of particles are not: kernels read them from ``fluid_number`` and ``mobile_number`` (fluid and dummies).
    """

    def __init__(self, fluid: int, dummies: int, images: int, carries_stress: bool):
        self.fluid, self.dummies = fluid, dummies
        self.has_dummies, self.has_walls = dummies > 0, dummies + images > 0
        self.fluid_number, self.mobile_number = integer(fluid), integer(fluid + dummies)
        self.first_wall = size_class(fluid)
        self.mobile_slots = self.first_wall + (size_class(dummies) if dummies else 0)
        self.slots = self.mobile_slots + (size_class(images) if images else 0)
        vector = ti.types.vector(2, real())
        self.position = self._state(vector)
        self.velocity = self._state(vector)
        self.compression = self._state(real())
        self.mid_compression = self._state(real())
        self.identity = self._state(ti.i32)
        beyond = self.first_wall + dummies + images
        self.mid_position = self._middle(vector, beyond)
        self.mid_velocity = self._middle(vector, beyond)
        self.mid_pressure = self._middle(real(), beyond)
        self.carries_stress = carries_stress
        if carries_stress:
            tensor = ti.types.vector(3, real())
            self.stress = self._state(tensor)
            self.mid_stress = self._middle(tensor, beyond)

    def _state(self, kind: Any) -> Any:
        field = ti.field(kind, shape=(2, self.first_wall))
        field.used = np.s_[:, : self.fluid]
        return field

    def _middle(self, kind: Any, used: int) -> Any:
        field = ti.field(kind, shape=(2, self.slots))
        field.used = np.s_[:, :used]
        return field

    def load(self, position: np.ndarray, velocity: np.ndarray, stress: np.ndarray | None) -> None:
        """Fill new fields: uncompressed fluid at ``position`` (fluid, 2) with ``velocity`` (fluid, 2).

        ``stress`` (fluid, 3): polymer stress over the reference density, None where particles carry none.
        """
        view(self.position)[:, : self.fluid] = position
        view(self.mid_position)[0, : self.fluid] = position
        view(self.velocity)[:, : self.fluid] = velocity
        if self.carries_stress:
            view(self.stress)[:, : self.fluid] = stress
        view(self.identity)[:, : self.fluid] = np.arange(self.fluid)
        self.set_middle(0)

    def set_middle(self, now: int) -> None:
        """Set velocities and stresses in the middle of the step to the state in buffer ``now``."""
        view(self.mid_velocity)[now, : self.fluid] = view(self.velocity)[now, : self.fluid]
        if self.carries_stress:
            view(self.mid_stress)[now, : self.fluid] = view(self.stress)[now, : self.fluid]

    def state(self, now: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
        """Return position, velocity (fluid, 2), compression (fluid,), stress (fluid, 3) in the order of creation.

        The stress is None where particles carry none.
        """
        order = np.argsort(view(self.identity)[now, : self.fluid])
        return (
            view(self.position)[now][order],
            view(self.velocity)[now][order],
            view(self.compression)[now][order],
            view(self.stress)[now][order] if self.carries_stress else None,
        )

    def momentum(self, now: int) -> float:
        """Return the sum of the velocities of the fluid along x."""
        return float(view(self.velocity)[now, : self.fluid, 0].astype(float).sum())

    @ti.func
    def slot(self, number):
        """Return the slot of mobile particle ``number``: the fluid comes first, then the dummies."""
        k = number
        if ti.static(self.has_dummies):
            fluid = self.fluid_number[None]
            k = ti.select(number < fluid, number, number - fluid + self.first_wall)
        return k

    @ti.kernel
    def reorder(self, now: ti.i32, order: ti.template(), serial: ti.template()):
        """Copy buffer ``now`` into the other one, the particle in slot ``order[n]`` to the n-th slot."""
        ti.loop_config(serialize=serial)
        for number in range(self.mobile_number[None]):
            k = self.slot(number)
            source = order[number]
            self.mid_position[1 - now, k] = self.mid_position[now, source]
            self.mid_velocity[1 - now, k] = self.mid_velocity[now, source]
            self.mid_pressure[1 - now, k] = self.mid_pressure[now, source]
            if ti.static(self.carries_stress):
                self.mid_stress[1 - now, k] = self.mid_stress[now, source]
            if k < self.first_wall:
                self.position[1 - now, k] = self.position[now, source]
                self.velocity[1 - now, k] = self.velocity[now, source]
                self.compression[1 - now, k] = self.compression[now, source]
                self.mid_compression[1 - now, k] = self.mid_compression[now, source]
                self.identity[1 - now, k] = self.identity[now, source]
                if ti.static(self.carries_stress):
                    self.stress[1 - now, k] = self.stress[now, source]


@ti.data_oriented
class Cells:
    """Cells no smaller than ``cutoff`` (the radius of the neighbour lists), fitted to the box.

    ``rows`` and ``columns`` are not compiled in; ``levels``: number of rows with the rows of wall particles.
    ``order[n]`` is the slot of the n-th particle, cell by cell; ``start[place(row, column)]`` is the first slot of a
    cell and ``start[place(row, columns)]`` the end of its row, so that neighbouring cells of one row are one range of
    slots.
    """

    def __init__(self, particles: Particles, domain: PeriodicDomain | ChannelDomain, box: Lattice, cutoff: float):
        self.particles = particles
        self.domain = domain
        # counted in spacings: length and height are whole numbers of spacings, and no cell is lost to round-off
        columns = int(box.columns / (cutoff / box.spacing))
        rows = cell_rows(box, cutoff)
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
        self.begin.used = self.cell.used = self.order.used = None  # of no use after a sort

    @ti.func
    def place(self, row, column):
        """Return the place of a cell in ``start``."""
        return row * (self.columns[None] + 1) + column

    @ti.func
    def column_of(self, x):
        """Return the column of ``x``, a valid one even where ``x`` is not a number."""
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


def cell_rows(box: Lattice, cutoff: float) -> int:
    """Return the number of rows of cells, each at least ``cutoff`` high, in the height of a ``box``."""
    return max(1, int(box.rows / (cutoff / box.spacing)))
