"""Verlet lists that are reused for as long as they are provably complete.

A list holds every pair closer than ``radius`` = ``cutoff`` + skin when it was built. Since then particle i has
moved by w(y_i) t + e_i, where w is a reference velocity profile (the row means at the build, linear in
between) with the largest slope s. A pair that is now within the cutoff was then at most
stretch (cutoff + 2 max|e|) apart, where stretch = (st + sqrt((st)^2 + 4)) / 2 is the norm of a shear by st. As
long as that is within the radius no pair is missing: shear alone, however fast, hardly requires a new list.
The mirror image of a particle keeps its x, and |y_i - y_j| <= |y_i + y_j|, so that the bound holds for images too;
wall particles move with the walls, where w is the wall velocity. (A mirror point of a dummy particle also moves with
the wall, but w differs from the wall velocity there: lists of mirror points are complete only up to three quarters of
the cutoff.) In two-dimensional flow, in a box without plane walls, no profile predicts the motion, and w = 0.
"""

import math

import numpy as np

from tisph.numerics.domain import ChannelDomain, PeriodicDomain
from tisph.runtime import integer, real, scalar, ti, view
from tisph.schemes.wcsph.cells import Cells, Particles
from tisph.schemes.wcsph.kernels import list_radius

ROOM = 1.6
"""Capacity of a row over the mean number of particles within the radius."""


@ti.data_oriented
class VerletLists:
    """Neighbours ``table[i, k]``, k < ``count[i]``, of fluid and dummy particles; after the last comes i itself.

    Pair loops look one neighbour ahead, and so read one entry after the last neighbour.
    ``crosses[i]``: whether a neighbour lies across the period; most particles need no minimum image.
    Dummy particles list the fluid around them, with ``uses_mirror_points`` the fluid around their mirror points. In a
    channel mirror points follow from the positions; of bodies in a box they are in ``mirror``, by wall slot.
    """

    def __init__(self, cells: Cells, cutoff: float, spacing: float, serial: bool, uses_mirror_points: bool = False):
        self.cells = cells
        self.particles: Particles = cells.particles
        self.domain: PeriodicDomain | ChannelDomain = cells.domain
        self.serial = serial
        self.uses_mirror_points = uses_mirror_points
        self.cutoff = cutoff
        self.spacing = spacing
        self.radius = list_radius(cutoff, spacing)
        self.capacity = math.ceil(ROOM * math.pi * (self.radius / spacing) ** 2) + 4
        self.radius_squared = scalar(self.radius**2)
        mobile, fluid = self.particles.mobile_slots, self.particles.first_wall
        self.table = ti.field(ti.i32, shape=(mobile, self.capacity))
        self.count = ti.field(ti.i32, shape=mobile)
        self.crosses = ti.field(ti.i32, shape=mobile)
        if uses_mirror_points and self.domain.periodic_y:
            self.mirror = ti.field(ti.types.vector(2, real()), shape=mobile - fluid)
            self.mirror.used = None  # set before it is read
        self.longest = integer(0)
        self.built_position = ti.field(ti.types.vector(2, real()), shape=fluid)
        self.built_position.used = np.s_[: self.particles.fluid]
        self.follows_shear = not self.domain.periodic_y
        if self.follows_shear:
            self.reference_velocity = ti.field(real(), shape=fluid)
            self.profile = ti.field(real(), shape=cells.start.shape)
            self.steepest = scalar(0.0)
            self.reference_velocity.used, self.profile.used = self.built_position.used, None
        used = self.particles.first_wall + self.particles.dummies
        self.table.used = self.count.used = self.crosses.used = np.s_[:used]

    def outdated(self, drift_squared: float, elapsed: float) -> bool:
        """Return whether a pair may be missing, from max|e|^2 and the time since the lists were built."""
        tilt = float(view(self.steepest)) * elapsed if self.follows_shear else 0.0
        stretch = 0.5 * (tilt + math.sqrt(tilt * tilt + 4.0))
        return not stretch * (self.cutoff + 2.0 * math.sqrt(drift_squared)) <= self.radius

    @ti.kernel
    def build(self, now: ti.i32):
        """List the neighbours of all sorted particles at their mid-step positions."""
        self.longest[None] = 0
        if ti.static(self.follows_shear):
            ti.loop_config(serialize=True)
            for row in range(self.cells.rows[None] + 2):
                self.profile[row] = self.row_velocity(now, row)
            ti.loop_config(serialize=True)
            for _ in range(1):
                self.steepest[None] = self.largest_slope()
        ti.loop_config(serialize=self.serial)
        for number in range(self.particles.mobile_number[None]):
            i = self.particles.slot(number)
            if i < self.particles.first_wall:
                place = self.particles.mid_position[now, i]
                self.built_position[i] = place
                if ti.static(self.follows_shear):
                    self.reference_velocity[i] = self.profile_at(place.y)
            ti.atomic_max(self.longest[None], self.gather(now, i))

    @ti.func
    def row_velocity(self, now, row):
        """Return the mean velocity of a row of cells, or the wall velocity beyond the first and last row."""
        mean = self.domain.bottom_velocity[None]
        if row > self.cells.rows[None]:
            mean = self.domain.top_velocity[None]
        elif row > 0:
            first = self.cells.start[self.cells.place(row, 0)]
            last = self.cells.start[self.cells.place(row, self.cells.columns[None])]
            total = 0.0
            for i in range(first, last):
                total += self.particles.velocity[now, i].x
            mean = total / ti.max(1, last - first)
        return mean

    @ti.func
    def largest_slope(self):
        """Return the steepest slope of the reference profile: its knots are the row centres and the walls."""
        rows = self.cells.rows[None]
        height = self.domain.height[None] / rows
        steepest = 0.0
        for row in range(rows + 1):
            rise = ti.abs(self.profile[row + 1] - self.profile[row])
            run = ti.select(row == 0 or row == rows, 0.5 * height, height)
            steepest = ti.max(steepest, rise / run)
        return steepest

    @ti.func
    def profile_at(self, y):
        """Return the reference profile at height ``y``, constant beyond the walls."""
        rows = self.cells.rows[None]
        place = y / self.domain.height[None] * rows + 0.5
        row = ti.max(0, ti.min(rows, ti.cast(place, ti.i32)))
        part = place - row
        if row == 0:
            part = 2.0 * part - 1.0
        elif row == rows:
            part = 2.0 * part
        part = ti.max(0.0, ti.min(1.0, part))
        return self.profile[row] + (self.profile[row + 1] - self.profile[row]) * part

    @ti.func
    def gather(self, now, i):
        """Fill row ``i`` of the table from the 3 x 3 cells around it and return how many it needed."""
        place = self.centre(now, i)
        column = self.cells.column_of(place.x)
        row = self.cells.row_of(place.y, 0 if ti.static(self.uses_mirror_points or self.domain.periodic_y) else i)
        lowest = ti.max(row - 1, 0)
        highest = ti.min(row + 1, self.cells.rows[None] + 1)
        if ti.static(not self.domain.periodic_y):  # noqa: SIM102 (Taichi would not see the static one)
            if i >= self.particles.first_wall:
                lowest = ti.max(row - 1, 1)
                highest = ti.min(row + 1, self.cells.rows[None])
        found = 0
        across = 0
        for near in range(lowest, highest + 1):
            level = near
            if ti.static(self.domain.periodic_y):
                level = self.domain.wrap_row(near, self.cells.rows[None])
            found, across = self.append_level(now, i, column, level, level != near, found, across)
            if ti.static(self.domain.periodic_y and self.particles.has_walls):  # noqa: SIM102
                if i < self.particles.first_wall:
                    beyond = level + self.cells.rows[None]
                    found, across = self.append_level(now, i, column, beyond, level != near, found, across)
        self.crosses[i] = across
        self.count[i] = ti.min(found, self.capacity - 1)
        self.table[i, self.count[i]] = i
        return found

    @ti.func
    def append_level(self, now, i, column, level, copied, found, across):
        """Append the particles within the radius in the cells of ``level`` around a ``column``; return the new counts.

        ``copied``: the level stands for its periodic copy. Second count: neighbours across the period.
        """
        last = self.cells.columns[None]
        first = self.cells.place(level, 0)
        begin = self.cells.start[first + ti.max(column - 1, 0)]
        end = self.cells.start[first + ti.min(column + 2, last)]
        before = found
        if ti.static(self.domain.periodic_y):
            found = self.append(now, i, begin, end, found, True)
            across += ti.select(copied, found - before, 0)
        else:
            found = self.append(now, i, begin, end, found, False)
        if column == 0 or column == last - 1:
            other = first + ti.select(column == 0, last - 1, 0)
            before = found
            found = self.append(now, i, self.cells.start[other], self.cells.start[other + 1], found, True)
            across += found - before
        return found, across

    @ti.func
    def centre(self, now, i):
        """Return the point whose neighbours particle ``i`` lists: its position, or its mirror point."""
        place = self.particles.mid_position[now, i]
        if ti.static(self.uses_mirror_points):  # noqa: SIM102 (Taichi would not see the static one)
            if i >= self.particles.first_wall:
                if ti.static(self.domain.periodic_y):
                    place = self.mirror[i - self.particles.first_wall]
                else:
                    place.y = ti.select(place.y < 0.0, -place.y, 2.0 * self.domain.height[None] - place.y)
        return place

    @ti.func
    def append(self, now, i, begin, end, found, periodic: ti.template()):
        """Append the slots begin .. end-1 that lie within the radius, without a branch, and return the new count."""
        place = self.centre(now, i)
        limit = self.radius_squared[None]
        for j in range(begin, end):
            apart = self.particles.mid_position[now, j] - place
            if ti.static(periodic):
                apart = self.domain.minimum_image(apart)
            self.table[i, ti.min(found, self.capacity - 1)] = j
            found += ti.cast(apart.dot(apart) < limit, ti.i32) * ti.cast(j != i, ti.i32)
        return found

    def mean_length(self) -> float:
        """Return the mean number of listed neighbours of a fluid particle."""
        return float(view(self.count)[: self.particles.fluid].mean())

    def overflow(self) -> int:
        """Return the longest row if it may not have fitted into the table, else 0.

        Rejected candidates are written to the entry after the last neighbour, so that a full row is too long.
        """
        longest = int(view(self.longest))
        return longest if longest >= self.capacity else 0
