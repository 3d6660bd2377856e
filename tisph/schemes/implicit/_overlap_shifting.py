"""Particle shifting: keeps particles apart where disorder would make the least-squares systems nearly singular.

Discs of 0.9 spacings that overlap push one another apart, half of the overlap at a time, in the arrangement in which
the operators are to be assembled: no other matters. A sheared lattice has no overlap, so that shifting does nothing
there, exactly. The velocities are transferred by their Taylor series (``_motion.py``).
"""

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
