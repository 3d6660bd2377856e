"""Walls made of images: copies of the fluid particles near a plane wall or a circle, written together with them.

Plane walls. The images of the first (last) row of cells are in the order of their sources, so that image k of a wall
is found without a search, and the cells beyond the wall follow from the cells inside.

Circles. The image of a particle is on the same ray. Beyond a circle in the fluid it is as far from the wall as the
particle, d_I = d_F, and images are denser than the fluid. Beyond a circle around the fluid images have the area of
their sources, r_I^2 = 2 R^2 - r_F^2: with d_I = d_F they would be too thin, and shifting, which evens densities out,
would push fluid through the wall. (With equal areas beyond a circle in the fluid, particles leave through the gaps in
rows.) Let U_W be the velocity of the wall point between particle and image, and s = u_F - U_W. The image continues s
through the wall by the Taylor series s = d s_n + d^2/2 s_nn,

    u_I = U_W - (d_I/d_F) (1 + kappa d_I/2)/(1 - kappa d_F/2) (s - d_F^2 f/2) + d_I^2 f/2,
    f = -U_W,tt,   s_nn = f - kappa s_n,   around the fluid d_I/d_F = (2 + kappa d_F)/(2 - kappa d_I),

where kappa is the curvature, positive where the fluid is outside, and U_W,tt is taken along the wall. The flow has no
Laplacian at the wall, as a steady flow around an axis; without kappa, second differences have an error of kappa s_n
there. Fluid in rigid rotation with the wall is continued exactly. p_I = p_F + a_W . r_FI per unit density, a_W the
acceleration of the wall point, r_FI from the image to the particle. Images of circles are in cells of their own, in
the order of their sources, so that image k is found without a search.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.geometry.body import Body
from tisph.numerics.counting_sort import counting_sort
from tisph.numerics.domain import ChannelDomain
from tisph.runtime import integer, real, ti, view
from tisph.scenes._channel import Channel
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.cells import cell_rows
from tisph.schemes.wcsph.verlet import VerletLists
from tisph.schemes.wcsph.walls import WallParameters
from tisph.schemes.wcsph.walls._treatment import SolidWalls, WallTreatment

ROOM = 1.5
"""Room for images over the number of particles of the lattice that have images."""


@ti.data_oriented
class ImageWalls(WallTreatment):
    """Mirror images in plane walls; a treatment may override ``image_velocity`` and ``image_stress``."""

    domain: ChannelDomain

    def __init__(self, lists: VerletLists, kernel: Any, fluid: Fluid, parameters: WallParameters | None):
        super().__init__(lists, kernel, fluid, parameters)
        self.images = ti.field(ti.i32, shape=2)
        self.first_top = integer(0)

    @staticmethod
    def wall_slots(channel: Channel, cutoff: float) -> tuple[int, int]:
        """Return no dummy particles, and the room for images of a row of cells at each wall."""
        row = math.ceil(channel.rows / cell_rows(channel, cutoff) + 1) * channel.columns
        return 0, min(2 * channel.rows * channel.columns, math.ceil(2 * ROOM * row))

    def present_images(self) -> int:
        """Return the number of images in use."""
        return int(view(self.images).sum())

    def lay_out(self, now: int) -> None:
        """Update the images after a sort, before the lists are built."""
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
        """Return the velocity of the image of a particle: u_I = 2 U_W - u_F, v_I = -v_F."""
        return ti.Vector([2.0 * self.domain.wall_velocity(top) - velocity.x, -velocity.y])

    @ti.func
    def image_stress(self, top: ti.template(), position, stress):
        """Return the polymer stress of the image, S_I = S_F, as follows from the reflected velocities."""
        return stress


@dataclass(frozen=True)
class Images:
    """Images in circles: ``slots`` has no dummy particles, and the room for images."""

    slots: tuple[int, int]

    def radius(self, body: int, mirrored: bool) -> float:
        """Return 0: images do not rotate with their circle."""
        return 0.0


@ti.data_oriented
class CircleImages(SolidWalls):
    """Images in circles whose centres are at rest, rotating or not."""

    def __init__(
        self,
        lists: VerletLists,
        kernel: Any,
        fluid: Fluid,
        parameters: WallParameters | None,
        images: Images,
        bodies: Sequence[Body],
        origin: np.ndarray,
    ):
        super().__init__(lists, kernel, fluid, parameters, bodies, origin)
        self.radius, self.side = (ti.field(real(), shape=len(bodies)) for _ in range(2))
        circles: list[Any] = [body.shape for body in bodies]
        view(self.radius)[:] = [circle.radius for circle in circles]
        view(self.side)[:] = [1.0 if circle.fluid_side == "outside" else -1.0 for circle in circles]
        self.image = ti.field(ti.i32, shape=(self.particles.first_wall, len(bodies)))
        capacity = self.particles.slots - self.particles.first_wall
        self.image_cell, self.image_order, self.image_slot = (ti.field(ti.i32, shape=capacity) for _ in range(3))
        self.image_cell.used = self.image_order.used = self.image_slot.used = None  # of no use after a sort
        self.images = integer(0)
        farthest, cutoff = 1.0, lists.radius  # largest displacement of an image over its source's
        for radius, side in zip(view(self.radius), view(self.side), strict=True):
            if side < 0.0:
                source = math.sqrt(max(2.0 * radius**2 - (radius + cutoff) ** 2, lists.spacing**2))
                farthest = max(farthest, (radius + cutoff) / source)
        self.displacement_factor = 0.5 * (1.0 + farthest)  # mean of a particle and an image: a list has one of each

    @staticmethod
    def arrange(bodies: Sequence[Body], spacing: float, cutoff: float) -> Images:
        """Return the ``Images`` in ``bodies``, which are circles, for lists of the radius ``cutoff``."""
        rings = sum(body.shape.length + 2 * math.pi * cutoff for body in bodies) * cutoff
        return Images((0, math.ceil(ROOM * rings / spacing**2)))

    def load(self, time: float) -> None:
        """Place the circles at the start ``time``."""
        self.place_bodies(time)

    def present_images(self) -> int:
        """Return the number of images in use."""
        return int(view(self.images))

    @ti.kernel
    def lay_out(self, now: ti.i32):
        """Find the particles that have images, after a sort; sort the images into cells and set their values."""
        ti.loop_config(serialize=True)
        for _ in range(1):
            self.sort_images(now)
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid_number[None]):
            velocity, pressure = self.particles.mid_velocity[now, i], self.particles.mid_pressure[now, i]
            self.publish_images(now, i, self.particles.mid_position[now, i], velocity, pressure)

    @ti.func
    def sort_images(self, now):
        """Assign slots to the images, cell by cell, in the rows of cells of wall particles; without room, none."""
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

        ``source`` and ``image``: distances of the particle and its image from the centre.
        """
        wall, radius = self.velocity_of(body, wall_point), self.radius[body]
        along = wall - self.velocity[body]  # which is R^2 f
        inside, beyond = source / radius - 1.0, 1.0 - image / radius  # kappa d_F, kappa d_I
        share = ti.select(self.side[body] > 0.0, 1.0, (1.0 + 0.5 * inside) / (1.0 - 0.5 * beyond))
        share *= (1.0 + 0.5 * beyond) / (1.0 - 0.5 * inside)
        return wall - share * (velocity - wall - 0.5 * inside**2 * along) + 0.5 * beyond**2 * along
