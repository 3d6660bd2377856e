"""Walls made of images: copies of the fluid particles near a wall, written together with them.

The images of the first (last) row of cells stand in the same order as their sources, so that image k of a
wall is found without a search and the cells beyond the wall are known from those inside.
"""

import math

from tisph.neighbours.cells import cell_rows
from tisph.runtime import integer, ti, view
from tisph.walls._treatment import WallTreatment

ROOM = 1.5
"""Room for images over the number of particles that a row of cells holds on the lattice."""


@ti.data_oriented
class ImageWalls(WallTreatment):
    """Mirror geometry; what the images carry can be replaced by the treatment."""

    def __init__(self, lists, kernel, fluid, parameters):
        super().__init__(lists, kernel, fluid, parameters)
        self.images = ti.field(ti.i32, shape=2)
        self.first_top = integer(0)

    @staticmethod
    def wall_slots(channel, cutoff):
        """Return (dummy particles, room for images)."""
        row = math.ceil(channel.rows / cell_rows(channel, cutoff) + 1) * channel.columns
        return 0, min(2 * channel.rows * channel.columns, math.ceil(2 * ROOM * row))

    def present_images(self):
        """Return the number of images in use."""
        return int(view(self.images).sum())

    def lay_out(self, now):
        """Lay out the images after a sort, before the lists are built."""
        self.lay_out_images(now)

    @ti.kernel
    def lay_out_images(self, now: ti.i32):
        """Find the cells of the images, then their mid-step values."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            rows, last = self.cells.rows[None], self.cells.columns[None]
            bottom, top = self.cells.place(1, 0), self.cells.place(rows, 0)
            below_bottom, above_top = self.cells.place(0, 0), self.cells.place(rows + 1, 0)
            below = self.cells.start[bottom + last]
            first = self.cells.start[top]
            self.images[0] = below
            self.images[1] = self.particles.fluid_number[None] - first
            self.first_top[None] = first
            for column in range(last + 1):
                begin = self.particles.first_wall + self.cells.start[bottom + column]
                self.cells.start[below_bottom + column] = begin
                begin = self.particles.first_wall + below + self.cells.start[top + column] - first
                self.cells.start[above_top + column] = begin
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid_number[None]):
            position = self.particles.mid_position[now, i]
            velocity = self.particles.mid_velocity[now, i]
            pressure = self.particles.mid_pressure[now, i]
            if ti.static(self.particles.carries_stress):
                self.publish_images(now, i, position, velocity, pressure, self.particles.mid_stress[now, i])
            else:
                self.publish_images(now, i, position, velocity, pressure, 0.0)

    @ti.func
    def publish(self, buffer, i, position, velocity, pressure, stress):
        """Write the mid-step values of fluid particle ``i`` and of its images."""
        self.write(buffer, i, position, velocity, pressure, stress)
        self.publish_images(buffer, i, position, velocity, pressure, stress)

    @ti.func
    def publish_images(self, buffer, i, position, velocity, pressure, stress):
        """Write the mid-step values of the images of fluid particle ``i``, if it has any, where there is room."""
        slot = self.particles.first_wall + i
        if i < self.images[0] and slot < self.particles.slots:
            self.publish_image(buffer, slot, position, velocity, pressure, stress, 0)
        slot += self.images[0] - self.first_top[None]
        if i >= self.first_top[None] and slot < self.particles.slots:
            self.publish_image(buffer, slot, position, velocity, pressure, stress, 1)

    @ti.func
    def publish_image(self, buffer, slot, position, velocity, pressure, stress, top: ti.template()):
        """Write the mid-step values of the image of a particle in the bottom (``top`` 0) or top wall (1)."""
        mirrored = self.domain.mirrored(top, position)
        image = self.image_velocity(top, position, velocity)
        if ti.static(self.particles.carries_stress):
            self.write(buffer, slot, mirrored, image, pressure, self.image_stress(top, position, stress))
        else:
            self.write(buffer, slot, mirrored, image, pressure, 0.0)

    @ti.func
    def image_velocity(self, top: ti.template(), position, velocity):
        """Return the velocity of the image of a particle: reflected about that of the wall."""
        return ti.Vector([2.0 * self.domain.wall_velocity(top) - velocity.x, -velocity.y])

    @ti.func
    def image_stress(self, top: ti.template(), position, stress):
        """Return the polymer stress of the image of a particle: the same, as follows from reflected velocities."""
        return stress
