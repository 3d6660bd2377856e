"""Walls made of images in circles: copies of the fluid particles near one, written together with them.

The image of a particle is on the same ray. Beyond a circle in the fluid it is as far from the wall as the particle,
d_I = d_F, and images are denser than the fluid; beyond one around it they take up as much room as the fluid does,
r_I^2 = 2 R^2 - r_F^2: with d_I = d_F they would be too thin, and shifting, which evens densities out, would push fluid
through the wall. (Within a circle in the fluid as much room does not do: particles leave through the gaps in rows.)
With s = u_F - U_W its velocity relative to that of the wall point between them, the image goes on through the wall as
s = d s_n + d^2/2 s_nn does,

    u_I = U_W - (d_I/d_F) (1 + kappa d_I/2)/(1 - kappa d_F/2) (s - d_F^2 f/2) + d_I^2 f/2,
    f = -U_W,tt,   s_nn = f - kappa s_n,   around the fluid d_I/d_F = (2 + kappa d_F)/(2 - kappa d_I),

where kappa is the curvature, positive where the fluid is outside, and U_W,tt is taken along the wall. That is the
flow without Laplacian at the wall, as the steady one around an axis is: without kappa second differences are off by
kappa s_n there. Fluid that turns with the wall as a solid is continued exactly. p_I = p_F + a_W . r_FI per unit
density, a_W the acceleration of the wall point, r_FI from the image to the particle.

Images are in cells of their own, in the order of their sources, so that image k is found without a search.
"""

import math
from dataclasses import dataclass

from tisph.neighbours.counting_sort import counting_sort
from tisph.runtime import integer, real, ti, view
from tisph.walls._treatment import SolidWalls

ROOM = 1.5
"""Room for images over the number of particles that lie within cutoff of the walls in an even arrangement."""


@dataclass(frozen=True)
class Images:
    """``slots``: number of particles of their own, 0, and room for images."""

    slots: tuple[int, int]

    def radius(self, body, mirrored):
        """No image goes around with a circle that turns."""
        return 0.0


@ti.data_oriented
class CircleImages(SolidWalls):
    """Mirror images in circles that stay where they are, turning or not; copies of the fluid."""

    def __init__(self, lists, kernel, fluid, parameters, images, bodies, origin):
        super().__init__(lists, kernel, fluid, parameters, bodies, origin)
        self.radius, self.side = (ti.field(real(), shape=len(bodies)) for _ in range(2))
        view(self.radius)[:] = [body.shape.radius for body in bodies]
        view(self.side)[:] = [1.0 if body.shape.fluid_side == "outside" else -1.0 for body in bodies]
        self.image = ti.field(ti.i32, shape=(self.particles.first_wall, len(bodies)))
        capacity = self.particles.slots - self.particles.first_wall
        self.image_cell, self.image_order, self.image_slot = (ti.field(ti.i32, shape=capacity) for _ in range(3))
        self.image_cell.used = self.image_order.used = self.image_slot.used = None  # of no use after a sort
        self.images = integer(0)

    @staticmethod
    def arrange(bodies, spacing, cutoff):
        """Return the ``Images`` in bodies, circles all of them, for particles of the support radius ``cutoff``."""
        rings = sum(body.shape.length + 2 * math.pi * cutoff for body in bodies) * cutoff
        return Images((0, math.ceil(ROOM * rings / spacing**2)))

    @property
    def displacement_factor(self):
        """How much farther images go than the particles that they mirror, at most, on the mean with these."""
        farthest, cutoff = 1.0, self.lists.radius
        for radius, side in zip(view(self.radius), view(self.side), strict=True):
            if side < 0.0:
                source = math.sqrt(max(2.0 * radius**2 - (radius + cutoff) ** 2, self.lists.spacing**2))
                farthest = max(farthest, (radius + cutoff) / source)
        return 0.5 * (1.0 + farthest)

    def load(self, time):
        """Find the circles at the start."""
        self.place_bodies(time)

    def present_images(self):
        """Return the number of images in use."""
        return int(view(self.images))

    @ti.kernel
    def lay_out(self, now: ti.i32):
        """Find the particles that have images, after a sort, and where these are; then their mid-step values."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.sort_images(now)
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid_number[None]):
            velocity, pressure = self.particles.mid_velocity[now, i], self.particles.mid_pressure[now, i]
            self.publish_images(now, i, self.particles.mid_position[now, i], velocity, pressure)

    @ti.func
    def sort_images(self, now):
        """Give the images slots cell by cell, in the rows of cells of wall particles; those that find no room: none."""
        rows, columns, first_wall = self.cells.rows[None], self.cells.columns[None], self.particles.first_wall
        fluid, capacity, number = self.particles.fluid_number[None], self.particles.slots - first_wall, 0
        for i in range(fluid):
            for body in range(ti.static(len(self.bodies))):
                cell = self.cell_of(now, i, body)
                self.image[i, body] = ti.select(cell >= 0 and number < capacity, number, -1)
                if cell >= 0:
                    self.image_cell[ti.min(number, capacity - 1)] = cell
                    number += 1
        self.images[None] = number
        number = ti.min(number, capacity)
        counting_sort(self.image_cell, self.cells.begin, self.image_order, rows * columns, number, ti.Vector([0, 0]))
        for cell in range(rows * columns):
            row, column = rows + 1 + cell // columns, cell % columns
            self.cells.start[self.cells.place(row, column)] = first_wall + self.cells.begin[cell + 1]
            self.cells.start[self.cells.place(row, column + 1)] = first_wall + self.cells.begin[cell + 2]
        for rank in range(number):
            self.image_slot[self.image_order[rank]] = first_wall + rank
        for i in range(fluid):
            for body in range(ti.static(len(self.bodies))):
                if self.image[i, body] >= 0:
                    self.image[i, body] = self.image_slot[self.image[i, body]]

    @ti.func
    def cell_of(self, now, i, body):
        """Return the cell of the image of particle ``i`` in a body, counted from the first; -1 where it has none."""
        away = self.away(self.particles.mid_position[now, i], body)
        image = self.mirrored(away, body)
        beyond = image.dot(away) / away.norm() - self.radius[body]
        cell = -1
        if beyond * beyond < self.lists.radius_squared[None]:
            place = self.domain.wrap(self.centre[body] + image)
            cell = (self.cells.row_of(place.y, 0) - 1) * self.cells.columns[None] + self.cells.column_of(place.x)
        return cell

    @ti.func
    def away(self, position, body):
        """Return the vector from the centre of a body to a place."""
        return self.domain.minimum_image(position - self.centre[body])

    @ti.func
    def mirrored(self, away, body):
        """Return the image of a place, both as vectors from the centre of a body."""
        part = self.radius[body] / away.norm()
        even = ti.sqrt(ti.max(2.0 * part * part - 1.0, 0.0))
        return ti.select(self.side[body] > 0.0, 2.0 * part - 1.0, even) * away

    @ti.func
    def publish(self, buffer, i, position, velocity, pressure, stress):
        """Write the mid-step values of fluid particle ``i`` and of its images."""
        self.write(buffer, i, position, velocity, pressure, stress)
        self.publish_images(buffer, i, position, velocity, pressure)

    @ti.func
    def publish_images(self, buffer, i, position, velocity, pressure):
        """Write the mid-step values of the images of fluid particle ``i``."""
        for body in range(ti.static(len(self.bodies))):
            slot = self.image[i, body]
            if slot >= 0:
                away = self.away(position, body)
                image = self.mirrored(away, body)
                wall_point = self.radius[body] / away.norm() * away
                pressed = pressure + self.acceleration_of(body, wall_point).dot(away - image)
                continued = self.image_velocity(body, wall_point, away.norm(), image.norm(), velocity)
                self.write(buffer, slot, self.centre[body] + image, continued, pressed, 0.0)

    @ti.func
    def image_velocity(self, body, wall_point, source, image, velocity):
        """Return the velocity of an image beyond the wall point that is ``wall_point`` from the centre.

        ``source`` and ``image``: how far from the centre the particle and its image are.
        """
        wall, radius = self.velocity_of(body, wall_point), self.radius[body]
        along = wall - self.velocity[body]  # which is R^2 f
        inside, beyond = source / radius - 1.0, 1.0 - image / radius  # kappa d_F, kappa d_I
        share = ti.select(self.side[body] > 0.0, 1.0, (1.0 + 0.5 * inside) / (1.0 - 0.5 * beyond))
        share *= (1.0 + 0.5 * beyond) / (1.0 - 0.5 * inside)
        return wall - share * (velocity - wall - 0.5 * inside**2 * along) + 0.5 * beyond**2 * along
