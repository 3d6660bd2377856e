"""Positions of the particles, how a step moves them, and the shifts that keep them apart.

Disorder would make the least-squares systems nearly singular. Discs of 0.9 spacings that overlap push one another
apart, half of the overlap at a time, in the arrangement in which the operators are to be assembled: no other matters. A
sheared lattice has no overlap, so that shifting does nothing there, exactly. The velocities are transferred by their
Taylor series.
"""

import numpy as np

from tisph.neighbours.point_cloud import active
from tisph.runtime import real, scalar, ti, view

DIAMETER = 0.9
"""In particle spacings."""

SOFTNESS = 0.5
"""Part of an overlap that a sweep removes on each side."""

LARGEST = 0.2
"""Largest move of a sweep, in particle spacings."""

SWEEPS = 4
SMALLEST = 1e-3
"""Sweeps end when nothing moves farther, in particle spacings."""


class Motion:
    """Positions (fluid), what moves them, and positions and velocities (fluid) before the last step."""

    def __init__(self, field, shift, period):
        step = field.step
        self.field, self.step, self.points, self.shift = field, step, step.points, shift
        self.period = period
        self.position, self.start_position = (self.points.field(ti.types.vector(2, real())) for _ in range(2))
        self.start_velocity = self.points.field(real())

    def predict(self, half):
        """Put the points where the particles are in the middle of a step twice as long as ``half``."""
        place = active(self.position).copy()
        place[:, 0] = self.wrapped(place[:, 0] + half * active(self.step.velocity))
        view(self.points.position)[: self.points.fluid] = place

    def shift_fields(self, half):
        """Transfer positions and velocities to the shifted points: by the Taylor series of the velocities.

        A shift D in the middle of the step is one by D_x - ``half`` u_y D_y along the channel at its start.
        """
        shift = view(self.shift.moved)[: self.points.fluid]
        moved = np.flatnonzero(shift.any(axis=1))
        x, y = shift[moved].T
        slope, curvature = active(self.field.slope)[moved], active(self.field.curvature)[moved]
        x = x - half * slope[:, 1] * y
        squares = np.stack([0.5 * x * x, x * y, 0.5 * y * y], axis=1)
        change = slope[:, 0] * x + slope[:, 1] * y + np.einsum("nk,nk->n", curvature, squares)
        self.step.shift_fields(moved, y)
        velocity = active(self.step.velocity)
        velocity[moved] += change
        place = view(self.points.position)[moved]
        place[:, 0] -= half * velocity[moved]
        active(self.position)[moved] = place

    def move(self, dt):
        """Move the particles over the step and take up the velocities at its end."""
        position, velocity, end = (active(field) for field in (self.position, self.step.velocity, self.step.end))
        active(self.start_position)[...] = position
        active(self.start_velocity)[...] = velocity
        position[:, 0] = self.wrapped(position[:, 0] + (0.5 * dt) * (velocity + end))
        self.step.accept()

    def wrapped(self, x):
        """Return ``x`` moved by whole periods into [0, period)."""
        inside = x - np.floor(x / self.period) * self.period
        return np.where(inside < self.period, inside, 0.0)


@ti.data_oriented
class OverlapShifting:
    """Moves the places of the points; ``moved`` (fluid) is by how much."""

    def __init__(self, points, ghosts, spacing):
        self.points, self.ghosts = points, ghosts
        self.spacing = scalar(spacing)
        vector = ti.types.vector(2, real())
        self.move, self.moved = ti.field(vector, points.capacity), ti.field(vector, points.capacity)
        self.farthest = scalar(0.0)

    def shift(self):
        """Push points apart; return whether any moved."""
        view(self.moved)[: self.points.fluid] = 0.0
        farthest = view(self.farthest)
        for sweep in range(SWEEPS):
            self.sweep()
            self.ghosts.follow()
            if farthest <= SMALLEST:
                return sweep > 0 or bool(farthest > 0.0)
        return True

    @ti.kernel
    def sweep(self):
        """One Jacobi sweep over all overlaps."""
        self.farthest[None] = 0.0
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            reach = DIAMETER * self.spacing[None]
            displacement = ti.Vector([0.0, 0.0])
            for k in range(self.points.count[i]):
                apart = self.points.separation(i, self.points.neighbours[i, k])
                distance = ti.sqrt(apart.dot(apart)) + 1e-30
                displacement -= SOFTNESS * ti.max(0.0, reach - distance) / distance * apart
            size = ti.sqrt(displacement.dot(displacement)) / self.spacing[None]
            displacement *= ti.min(1.0, LARGEST / ti.max(size, LARGEST))
            self.move[i] = displacement
            ti.atomic_max(self.farthest[None], size)
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            self.points.position[i] += self.move[i]
            self.moved[i] += self.move[i]
