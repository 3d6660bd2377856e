"""Walls made of dummy particles, which move with the wall and carry values extrapolated from the fluid.

In a channel they are rows of the lattice, in bodies of any smooth shape layers along the wall.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tisph.geometry.body import Body
from tisph.geometry.shape import Boundary, Shape
from tisph.numerics.domain import ChannelDomain
from tisph.runtime import real, ti, view
from tisph.scenes._channel import Channel
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.verlet import VerletLists
from tisph.schemes.wcsph.walls import WallParameters
from tisph.schemes.wcsph.walls._treatment import SolidWalls, WallTreatment
from tisph.size_class import size_class


@ti.data_oriented
class Dummies(WallTreatment):
    """Dummy particles of any wall. The treatment has ``extrapolate(buffer, k)``, which sets the values of particle k.

    The subclass for a kind of wall has ``advance(now, k, elapsed)``, which moves the particle, ``velocity_at(buffer,
    k)``, the velocity of its wall, and, where ``accelerates``, ``acceleration_at(k)``, the acceleration of its wall.
    """

    has_dummies = True
    accelerates = False

    @ti.kernel
    def refresh(self, now: ti.i32):
        """Extrapolate to all dummy particles once their lists are built."""
        ti.loop_config(serialize=True)
        for number in range(self.particles.fluid_number[None], self.particles.mobile_number[None]):
            self.extrapolate(now, self.particles.slot(number))

    @ti.func
    def set_dummy(self, buffer, k, velocity, pressure, stress):
        """Set velocity, pressure and stress of dummy particle ``k``."""
        self.write(buffer, k, self.particles.mid_position[buffer, k], velocity, pressure, stress)

    @ti.func
    def give_wall_values(self, buffer, k):
        """Set the values of dummy particle ``k``, without fluid in reach, to the wall velocity and no stress."""
        velocity = self.velocity_at(buffer, k)
        if ti.static(self.particles.carries_stress):
            self.set_dummy(buffer, k, velocity, 0.0, ti.Vector([0.0, 0.0, 0.0]))
        else:
            self.set_dummy(buffer, k, velocity, 0.0, 0.0)


@ti.data_oriented
class DummyWalls(Dummies):
    """Dummy particles on the continued lattice, beyond the walls of a channel."""

    domain: ChannelDomain

    @staticmethod
    def wall_slots(channel: Channel, cutoff: float) -> tuple[int, int]:
        """Return the number of dummy particles, in layers as deep as ``cutoff`` on both walls, and 0 for images."""
        return 2 * _layers(channel.spacing, cutoff) * channel.columns, 0

    def load(self, channel: Channel) -> None:
        """Place the dummy particles on the lattice continued beyond both walls, at rest relative to them."""
        depth = _layers(channel.spacing, self.lists.radius)
        column, layer = np.meshgrid(np.arange(channel.columns), np.arange(depth))
        x = (column.ravel() + 0.5) * channel.spacing
        beyond = (layer.ravel() + 0.5) * channel.spacing
        places = np.concatenate([np.stack([x, -beyond], 1), np.stack([x, channel.gap + beyond], 1)])
        first, last = self.particles.first_wall, self.particles.first_wall + self.particles.dummies
        view(self.particles.mid_position)[0, first:last] = places
        velocities = view(self.domain.bottom_velocity), view(self.domain.top_velocity)
        view(self.particles.mid_velocity)[0, first:last, 0] = np.repeat(velocities, len(places) // 2)

    @ti.func
    def advance(self, now, k, elapsed):
        """Move dummy particle ``k`` with its wall, into the other buffer."""
        position = self.particles.mid_position[now, k]
        position.x += self.wall_velocity(position.y) * elapsed
        self.particles.mid_position[1 - now, k] = position

    @ti.func
    def velocity_at(self, buffer, k):
        """Return the velocity of the wall that dummy particle ``k`` belongs to."""
        return ti.Vector([self.wall_velocity(self.particles.mid_position[buffer, k].y), 0.0])

    @ti.func
    def depth(self, y):
        """Return the distance of a dummy particle at height ``y`` from its wall."""
        return ti.select(y < 0.0, -y, y - self.domain.height[None])

    @ti.func
    def wall_velocity(self, y):
        """Return the velocity of the wall that a dummy particle at height ``y`` belongs to."""
        return ti.select(y < 0.0, self.domain.bottom_velocity[None], self.domain.top_velocity[None])


def _layers(spacing: float, cutoff: float) -> int:
    """Return the number of layers, at the depths (k + 1/2) ``spacing``, within ``cutoff`` of a particle at the wall."""
    return math.ceil(cutoff / spacing - 0.5)


@dataclass(frozen=True)
class Layers:
    """Dummy particles in the frames of their bodies: ``place`` and nearest wall point, ``wall_point``, (n, 2) each.

    ``body`` (n,): number of the body of each particle.
    """

    place: np.ndarray
    wall_point: np.ndarray
    body: np.ndarray

    @property
    def slots(self) -> tuple[int, int]:
        """Number of particles, and room for images."""
        return len(self.place), 0

    def radius(self, body: int, mirrored: bool) -> float:
        """Return the largest distance of the particles in a body from its centre; ``mirrored``: or of mirror points."""
        places, wall_points = self.place[self.body == body], self.wall_point[self.body == body]
        farthest = [np.linalg.norm(places, axis=1).max()]
        if mirrored:
            farthest.append(np.linalg.norm(2.0 * wall_points - places, axis=1).max())
        return float(max(farthest))


def layers_in(bodies: Sequence[Body], spacing: float, cutoff: float) -> Layers:
    """Return the ``Layers`` of bodies at the depths (k + 1/2) ``spacing`` within ``cutoff`` of a particle at the wall.

    In each layer particles are about a spacing apart; there is none where the wall's centre of curvature is nearer.
    """
    wall_points, places, numbers = [], [], []
    for number, body in enumerate(bodies):
        for layer in range(_layers(spacing, cutoff)):
            depth = (layer + 0.5) * spacing
            part = _outline(body.shape, spacing, depth)
            if part is None:
                break
            wall_points.append(part.point)
            places.append(part.point - depth * part.normal)
            numbers.append(np.full(len(part.point), number))
    return Layers(np.concatenate(places), np.concatenate(wall_points), np.concatenate(numbers))


def _outline(shape: Shape, spacing: float, depth: float) -> Boundary | None:
    """Return wall points for a layer at ``depth`` behind the wall, whose particles are a ``spacing`` apart.

    None where the centre of curvature is nearer than ``depth``.
    """
    wall = shape.boundary_points(spacing)
    shrinking = 1.0 - depth * wall.curvature
    if shrinking.min() <= 0.0:
        return None
    return shape.boundary_points(spacing * wall.length.sum() / (wall.length * shrinking).sum())


@ti.data_oriented
class LayerWalls(Dummies, SolidWalls):
    """Dummy particles in bodies.

    ``number[k]``: index among the ``layers`` of the particle in the k-th wall slot; a sort permutes it. With
    ``uses_mirror_points`` the mirror points are stored in the lists.
    """

    accelerates = True

    def __init__(
        self,
        lists: VerletLists,
        kernel: Any,
        fluid: Fluid,
        parameters: WallParameters | None,
        layers: Layers,
        bodies: Sequence[Body],
        origin: np.ndarray,
    ):
        super().__init__(lists, kernel, fluid, parameters, bodies, origin)
        self.layers = layers
        slots, vector = size_class(self.particles.dummies), ti.types.vector(2, real())
        self.number, self.sorted = (ti.field(ti.i32, shape=slots) for _ in range(2))
        self.body = ti.field(ti.i32, shape=slots)
        self.lever_arm, self.wall_point = (ti.field(vector, shape=slots) for _ in range(2))
        self.number.used = self.body.used = self.lever_arm.used = self.wall_point.used = np.s_[: self.particles.dummies]
        self.sorted.used = None

    @staticmethod
    def arrange(bodies: Sequence[Body], spacing: float, cutoff: float) -> Layers:
        """Return the ``Layers`` of bodies, for lists of the radius ``cutoff``."""
        return layers_in(bodies, spacing, cutoff)

    def load(self, time: float) -> None:
        """Place the dummy particles in the bodies at the start ``time``."""
        count = self.particles.dummies
        view(self.number)[:count] = np.arange(count)
        view(self.body)[:count] = self.layers.body
        view(self.lever_arm)[:count], view(self.wall_point)[:count] = self.layers.place, self.layers.wall_point
        self.place_bodies(time)
        slots = slice(self.particles.first_wall, self.particles.first_wall + count)
        for number, body in enumerate(self.bodies):
            own = self.layers.body == number
            places = body.at(time).to_lab_frame(self.layers.place[own]) - self.origin
            view(self.particles.mid_position)[0, slots][own] = places

    @ti.kernel
    def lay_out(self, now: ti.i32):
        """Update ``number`` after a sort, and the mirror points."""
        first, fluid = self.particles.first_wall, self.particles.fluid_number[None]
        count = self.particles.mobile_number[None] - fluid
        ti.loop_config(serialize=True)
        for k in range(count):
            self.sorted[k] = self.number[self.cells.order[fluid + k] - first]
        ti.loop_config(serialize=True)
        for k in range(count):
            self.number[k] = self.sorted[k]
            if ti.static(self.uses_mirror_points):
                self.mirror(first + k)

    @ti.func
    def advance(self, now, k, elapsed):
        """Move dummy particle ``k`` with its body, into the other buffer."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        self.particles.mid_position[1 - now, k] = self.centre[body] + self.rotated(body, self.lever_arm[number])
        if ti.static(self.uses_mirror_points):
            self.mirror(k)

    @ti.func
    def mirror(self, k):
        """Store the mirror point of dummy particle ``k`` in the lists."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        lever_arm = self.rotated(body, 2.0 * self.wall_point[number] - self.lever_arm[number])
        self.lists.mirror[k - self.particles.first_wall] = self.centre[body] + lever_arm

    @ti.func
    def velocity_at(self, buffer, k):
        """Return the velocity of the wall point nearest to dummy particle ``k``."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        return self.velocity_of(body, self.rotated(body, self.wall_point[number]))

    @ti.func
    def acceleration_at(self, k):
        """Return the acceleration of the wall point nearest to dummy particle ``k``."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        return self.acceleration_of(body, self.rotated(body, self.wall_point[number]))
