"""Walls made of images: copies of the fluid particles near a wall, written together with them.

The images of the first (last) row of cells stand in the same order as their sources, so that image k of a
wall is found without a search and the cells beyond the wall are known from those inside.
"""

import math

from tisph.neighbours.cells import cell_rows
from tisph.runtime import ti
from tisph.walls._treatment import WallTreatment

ROOM = 1.5
"""Room for images over the number of particles that a row of cells holds on the lattice."""


@ti.data_oriented
class ImageWalls(WallTreatment):
    """Mirror geometry shared by image treatments; ``image_velocity`` and the rest come from the treatment."""

    def __init__(self, particles, cells, lists, kernel):
        super().__init__(particles, cells, lists, kernel)
        self.images = ti.field(ti.i32, shape=2)
        self.first_top = ti.field(ti.i32, shape=())

    @staticmethod
    def wall_slots(channel, reach):
        """Return (dummy particles, room for images)."""
        row = math.ceil(channel.rows / cell_rows(channel, reach) + 1) * channel.columns
        return 0, min(2 * channel.rows * channel.columns, math.ceil(2 * ROOM * row))

    def present_images(self):
        """Return the number of images in use."""
        return self.images[0] + self.images[1]

    def overflow(self):
        """Return the number of images if there was no room for them, else 0."""
        needed = self.present_images()
        return needed if needed > self.particles.slots - self.particles.mobile else 0

    @ti.kernel
    def lay_out(self, now: ti.i32):
        """Lay out the images after a sort: their cells, then their mid-step values."""
        rows = ti.static(self.cells.rows)
        last = ti.static(self.cells.columns)
        ti.loop_config(serialize=True)
        for _ in range(1):
            below = self.cells.start[1, last]
            first = self.cells.start[rows, 0]
            self.images[0] = below
            self.images[1] = self.particles.fluid - first
            self.first_top[None] = first
            for column in range(last + 1):
                self.cells.start[0, column] = self.particles.mobile + self.cells.start[1, column]
                self.cells.start[rows + 1, column] = (
                    self.particles.mobile + below + self.cells.start[rows, column] - first
                )
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid):
            self.publish_images(
                now,
                i,
                self.particles.mid_position[now, i],
                self.particles.mid_velocity[now, i],
                self.particles.mid_pressure[now, i],
            )

    @ti.func
    def publish(self, buffer, i, position, velocity, pressure):
        """Write the mid-step values of fluid particle ``i`` and of its images."""
        self.write(buffer, i, position, velocity, pressure)
        self.publish_images(buffer, i, position, velocity, pressure)

    @ti.func
    def publish_images(self, buffer, i, position, velocity, pressure):
        """Write the mid-step values of the images of fluid particle ``i``, if it has any, where there is room."""
        slot = self.particles.mobile + i
        if i < self.images[0] and slot < self.particles.slots:
            mirrored = ti.Vector([position.x, -position.y])
            wall_velocity = self.domain.bottom_velocity[None]
            self.write(buffer, slot, mirrored, self.image_velocity(velocity, wall_velocity), pressure)
        slot += self.images[0] - self.first_top[None]
        if i >= self.first_top[None] and slot < self.particles.slots:
            mirrored = ti.Vector([position.x, 2.0 * self.domain.gap[None] - position.y])
            wall_velocity = self.domain.top_velocity[None]
            self.write(buffer, slot, mirrored, self.image_velocity(velocity, wall_velocity), pressure)
