"""Particle shifting: sweeps that keep the arrangement even enough for the least-squares systems to be solvable.

In parallel flow discs of 0.9 spacings that overlap push one another apart, half of the overlap at a time, in the
arrangement of the middle of a step, in which the operators are to be assembled: no other matters. A sheared lattice has
no overlap, so that shifting does nothing there, exactly. The velocities are transferred by their Taylor series.

In two-dimensional flow particles are shifted down the gradient of the concentration, in the arrangement at the end of a
step. S. J. Lind, R. Xu, P. K. Stansby, B. D. Rogers, J. Comput. Phys. 231 (2012) 1499-1523: particles diffuse, by -D
grad C, from where they are dense to where they are not. Without it they gather along the lines that the flow stretches,
and the operators become singular there. On a lattice it does nothing, however much that is stretched, because all
contributions cancel: particles that start on a lattice are displaced a little at random beforehand.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from tisph.runtime import holding, real, scalar, ti, view

DIAMETER = 0.9
"""Of the discs, in particle spacings."""

SOFTNESS = 0.5
"""Part of an overlap that a sweep removes on each side."""

OVERLAP_SWEEPS = 4
SMALLEST = 1e-3
"""Sweeps against overlap end when nothing moves farther, in particle spacings."""

SUPPORT = 2.0
"""Radius of the kernel of the concentration (Wendland C2), in particle spacings."""

RATE = 0.4
"""D of a sweep, in spacings squared: from 0.6 on sweeps overshoot, below 0.25 they are slower than the flow stretches a
lattice, in steps in which the fastest particle goes ``TRAVEL`` spacings; the less it goes the slower they may be."""

TRAVEL = 0.15

LARGEST = 0.2
"""Largest move of a sweep, in particle spacings."""

SWEEPS = 4
"""With 2 of them the nearest two particles are nearer by 0.05 spacings, and errors larger by 4 to 10 %; 3 at a rate of
0.5 are as even, with errors larger by up to 8 %."""

SWEEPS_ACROSS_AXIS = 16
"""The same where walls lie across the axis of the flow. A particle stands for the more of the half-plane the nearer it
comes to the axis, as 1/r: where flow along a plate met it, at Re = 300 and 990 in a cylinder with one end that turns, a
third of the particles was missing with 4, and runs diverged; with 8 at 990. Behind a sphere they gathered in layers
with 4, and in Oldroyd-B fluids runs with 28 and 32 across were stopped; with 16 they reach their end."""

BEYOND = 0.4
"""Distance beyond the support, in particle spacings, up to which neighbours are listed for the sweeps of a step: more
than two particles approach in them."""

CLOSEST = 0.15
"""Distance from a wall, in particle spacings, to which a particle is moved that has come nearer, between bodies that
close a gap."""

SCATTER = 0.05
"""Largest displacement along each axis that breaks a lattice up, in particle spacings."""


@ti.data_oriented
class Shifting:
    """Jacobi sweeps that move the fluid ``points``; ``moved`` (fluid) is by how much.

    ``displacement(i)`` of a subclass is the move of a particle; moves longer than ``largest`` are cut. ``farthest``:
    length of the longest move of a sweep, before it is cut, where that ``ends`` the sweeps. Both are in ``unit``.
    """

    ends = False
    displacement: Any

    def __init__(self, points: Any, largest: float, unit: float = 1.0) -> None:
        self.points = points
        vector = ti.types.vector(2, real())
        self.move, self.moved = ti.field(vector, points.capacity), ti.field(vector, points.capacity)
        self.largest, self.unit, self.farthest = scalar(largest), scalar(unit), scalar(0.0)

    @ti.kernel
    def sweep(self):
        """Move all particles once."""
        self.farthest[None] = 0.0
        particles = self.points.n_fluid[None]
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            displacement = self.displacement(i)
            size = ti.sqrt(displacement.dot(displacement)) / self.unit[None]
            largest = self.largest[None] * self.points.relative(i)
            self.move[i] = displacement * ti.min(1.0, largest / ti.max(size, largest))
            if ti.static(self.ends):
                ti.atomic_max(self.farthest[None], size)
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            self.points.position[i] += self.move[i]
            self.moved[i] += self.move[i]


@ti.data_oriented
class OverlapShifting(Shifting):
    """Pushes points apart whose discs overlap; ``ghosts`` follow."""

    ends = True

    def __init__(self, points: Any, ghosts: Any, spacing: float) -> None:
        super().__init__(points, LARGEST, spacing)
        self.ghosts = ghosts

    def shift(self) -> bool:
        """Push points apart; return whether any moved."""
        view(self.moved)[: self.points.fluid] = 0.0
        farthest = view(self.farthest)
        for sweep in range(OVERLAP_SWEEPS):
            self.sweep()
            self.ghosts.follow()
            if farthest <= SMALLEST:
                return sweep > 0 or bool(farthest > 0.0)
        return True

    @ti.func
    def displacement(self, i):
        """Return the displacement of particle ``i`` by the overlaps with its neighbours."""
        reach, displacement = DIAMETER * self.unit[None], ti.Vector([0.0, 0.0])
        for k in range(self.points.begin[i], self.points.end[i]):
            apart = self.points.separation(i, self.points.neighbours[k])
            distance = ti.sqrt(apart.dot(apart)) + 1e-30
            displacement -= SOFTNESS * ti.max(0.0, reach - distance) / distance * apart
        return displacement


@ti.data_oriented
class FickianShifting(Shifting):
    """Moves particles down the gradient of their concentration.

    ``walls``: how many walls near a particle count, with their tangents in ``planes`` (fluid, walls) as in
    ``WallPoints.nearest_walls``. There the mirror images of its neighbours, and its own, count as well: with points on
    the wall in their place particles would move to it. With ``off_walls`` none stays nearer than ``CLOSEST`` to one.
    ``across_axis``: flow along the walls goes to the axis, or from it. ``ends``: places x of open ends, which count as
    walls: near them particles are not moved towards or away from them.
    """

    def __init__(
        self,
        points: Any,
        spacing: float,
        walls: int = 0,
        off_walls: bool = False,
        across_axis: bool = False,
        ends: Sequence[float] = (),
    ) -> None:
        super().__init__(points, LARGEST * spacing)
        self.scatter, self.walls, self.off_walls = SCATTER * spacing, walls, off_walls
        self.sweeps = SWEEPS_ACROSS_AXIS if across_axis else SWEEPS
        self.closest = scalar(CLOSEST * spacing)
        if walls:
            self.planes = ti.field(ti.types.vector(3, real()), (points.capacity, walls))
            self.near = scalar(SUPPORT * spacing)
        self.open, self.per_spacing = len(ends), scalar(1.0 / spacing)
        if ends:
            self.ends = holding(ti.field(real(), self.open), ends)
        self.listed, self.last = ti.field(ti.i32, points.entries), ti.field(ti.i32, points.capacity)
        self.listed.used = self.last.used = None
        self.cutoff = scalar((SUPPORT + BEYOND) * spacing)
        self.per_support = scalar(1.0 / (SUPPORT * spacing))
        # slope of the kernel over the distance in supports: 7/pi (1 - q)^4 (1 + 4 q) has -140/pi (1 - q)^3
        self.full = RATE * spacing**2 * 140.0 / math.pi / (SUPPORT * spacing) ** 3 * spacing**2
        self.strength, self.full_rate = scalar(self.full), scalar(self.full)

    def shift(self, first: Any, travelled: float) -> None:
        """Move all particles to a more even arrangement.

        ``travelled``: the way of the fastest one in the step, in the largest spacing; below ``TRAVEL`` of its spacing a
        particle is moved at that part of ``RATE``. ``first``: after scattering them, the same way in every run.
        """
        part = travelled / TRAVEL
        view(self.strength)[()] = self.full * (part if self.points.graded else min(1.0, part))
        fluid = self.points.in_fluid
        view(self.moved)[: self.points.fluid] = 0.0
        if first:
            scattered = np.random.default_rng(0).uniform(-self.scatter, self.scatter, (fluid, 2))
            scattered *= np.reshape(self.points.areas, (-1, 1)) ** 0.5
            view(self.moved)[:fluid] = scattered
            view(self.points.position)[:fluid] += scattered
        self.list_neighbours()
        for _ in range(self.sweeps):
            self.sweep()

    @ti.kernel
    def list_neighbours(self):
        """List the fluid particles that may come within the support, without a branch: six in ten of all neighbours."""
        particles = self.points.n_fluid[None]
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            last, limit = self.points.begin[i], (self.cutoff[None] * self.points.relative(i)) ** 2
            for k in range(self.points.begin[i], self.points.end[i]):
                j = self.points.neighbours[k]
                apart = self.points.separation(i, j)
                self.listed[last] = j
                last += ti.cast(apart.dot(apart) < limit, ti.i32) * ti.cast(j < particles, ti.i32)
            self.last[i] = last

    @ti.func
    def displacement(self, i):
        """Return the displacement of particle ``i`` by its neighbours, and by the walls near it."""
        displacement = ti.Vector([0.0, 0.0])
        if ti.static(self.walls > 0):
            displacement = self.displacement_near_walls(i)
        else:
            for k in range(self.points.begin[i], self.last[i]):
                j = self.listed[k]
                displacement += self.displacement_by(i, j, self.points.separation(i, j))
        displacement *= self.rate(i)
        if ti.static(self.off_walls):
            displacement += self.displacement_off_walls(i)
        for end in ti.static(range(self.open)):
            away = ti.abs(self.points.position[i].x - self.ends[end]) * self.per_spacing[None]
            inside = ti.max(0.0, ti.min(1.0, 0.5 * away - 1.0))
            displacement.x *= inside
            if ti.static(self.sweeps > SWEEPS):  # along one axis alone particles would be pushed past others
                displacement *= inside + (1.0 - inside) * SWEEPS / self.sweeps
        return displacement

    @ti.func
    def rate(self, i):
        """Return the displacement of particle ``i`` by a unit of ``displacement_by``."""
        result = self.strength[None]
        if ti.static(self.points.graded):
            result = ti.min(self.full_rate[None], result / self.points.relative(i))
        return result

    @ti.func
    def displacement_by(self, i, j, apart):
        """Return the displacement of particle ``i``, over the rate, by particle ``j`` at the vector ``apart``.

        With their mean spacing h_ij it is h_ij f(r/h_ij). So particles are at rest where their number is 1/h^2: with
        h_i in place of the factor h_ij pairs push them to where the spacing grows, by 2 - 3/2 of its growth, 2 by their
        number, less 3/2 by h_ij in f.
        """
        relative = 0.5 * (self.points.relative(i) + self.points.relative(j))
        scaled = self.per_support[None] / relative * apart
        nearness = ti.max(0.0, 1.0 - ti.sqrt(scaled.dot(scaled)))
        return -relative * nearness * nearness * nearness * scaled

    @ti.func
    def displacement_near_walls(self, i):
        """Return the displacement by the neighbours of particle ``i``, of their images and of its own."""
        near = False
        for wall in ti.static(range(self.walls)):
            near = near or self.distance(i, wall) < self.near[None] * self.points.relative(i)
        displacement = ti.Vector([0.0, 0.0])
        if near:
            displacement += self.displacement_by_images(i, i)
        for k in range(self.points.begin[i], self.last[i]):
            j = self.listed[k]
            displacement += self.displacement_by(i, j, self.points.separation(i, j))
            if near:
                displacement += self.displacement_by_images(i, j)
        return displacement

    @ti.func
    def displacement_off_walls(self, i):
        """Return the displacement of particle ``i`` to the ``closest`` that it may be to a wall."""
        displacement = ti.Vector([0.0, 0.0])
        for wall in ti.static(range(self.walls)):
            plane = self.planes[i, wall]
            closest = self.closest[None] * self.points.relative(i)
            displacement += ti.max(0.0, closest - self.distance(i, wall)) * ti.Vector([plane.x, plane.y])
        return displacement

    @ti.func
    def distance(self, i, wall):
        """Return how far particle ``i`` is from a wall."""
        plane, position = self.planes[i, wall], self.points.position[i]
        return plane.x * position.x + plane.y * position.y - plane.z

    @ti.func
    def displacement_by_images(self, i, j):
        """Return the displacement of particle ``i`` by the images of particle ``j``: in each wall, and in both."""
        apart, displacement, both = self.points.separation(i, j), ti.Vector([0.0, 0.0]), True
        corner = apart
        for wall in ti.static(range(self.walls)):
            plane, away = self.planes[j, wall], self.distance(j, wall)
            near = away < self.near[None] * self.points.relative(j)
            if near:
                normal = ti.Vector([plane.x, plane.y])
                displacement += self.displacement_by(i, j, apart - 2.0 * away * normal)
                # where the walls face each other this is far away
                corner -= 2.0 * (away + normal.dot(corner - apart)) * normal
            both = both and near
        if both:
            displacement += self.displacement_by(i, j, corner)
        return displacement
