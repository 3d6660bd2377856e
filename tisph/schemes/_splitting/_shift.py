"""Particle shifting down the gradient of the concentration, in the arrangement at the end of a step.

S. J. Lind, R. Xu, P. K. Stansby, B. D. Rogers, J. Comput. Phys. 231 (2012) 1499-1523: particles diffuse, by -D grad C,
from where they are dense to where they are not. Without it they gather along the lines that the flow stretches, and the
rows become singular there. On a lattice it does nothing, however much that is stretched, because all pushes cancel:
what starts on one is scattered a little beforehand.
"""

import math

import numpy as np

from tisph.runtime import real, scalar, ti, view

SUPPORT = 2.0
"""Radius of the kernel of the concentration (Wendland C2), in particle spacings."""

RATE = 0.4
"""D of a sweep, in spacings squared: from 0.6 on sweeps overshoot, below 0.25 they are slower than the flow stretches a
lattice."""

LARGEST = 0.2
"""Largest move of a sweep, in particle spacings."""

SWEEPS = 4

SCATTER = 0.05
"""Largest displacement along each axis that breaks a lattice up, in particle spacings."""


@ti.data_oriented
class Shift:
    """Moves the places of the points; ``moved`` (fluid) is by how much."""

    def __init__(self, points, spacing):
        self.points, self.scatter = points, SCATTER * spacing
        vector = ti.types.vector(2, real())
        self.move, self.moved = ti.field(vector, points.most), ti.field(vector, points.most)
        self.per_support = scalar(1.0 / (SUPPORT * spacing))
        # slope of the kernel over the distance in supports: 7/pi (1 - q)^4 (1 + 4 q) has -140/pi (1 - q)^3
        self.strength = scalar(RATE * spacing**2 * 140.0 / math.pi / (SUPPORT * spacing) ** 3 * spacing**2)
        self.largest = scalar(LARGEST * spacing)

    def spread(self, first):
        """Move all points to a more even arrangement; ``first``: after scattering them, the same way in every run."""
        fluid = self.points.fluid
        view(self.moved)[:fluid] = 0.0
        if first:
            scattered = np.random.default_rng(0).uniform(-self.scatter, self.scatter, (fluid, 2))
            view(self.moved)[:fluid] = scattered
            view(self.points.place)[:fluid] += scattered
        for _ in range(SWEEPS):
            self.sweep()

    @ti.kernel
    def sweep(self):
        """One move of all points."""
        particles = self.points.particles[None]
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            scale = self.per_support[None]
            push = ti.Vector([0.0, 0.0])
            for k in range(self.points.count[i]):
                apart = scale * self.points.separation(i, self.points.table[i, k])
                nearness = ti.max(0.0, 1.0 - ti.sqrt(apart.dot(apart)))
                push -= nearness * nearness * nearness * apart
            push *= self.strength[None]
            size = ti.sqrt(push.dot(push))
            self.move[i] = push * ti.min(1.0, self.largest[None] / ti.max(size, self.largest[None]))
        ti.loop_config(serialize=self.points.serial)
        for i in range(particles):
            self.points.place[i] += self.move[i]
            self.moved[i] += self.move[i]
