"""Walls made of dummy particles in bodies of any smooth shape: layers along the wall that move with the body."""

import math
from dataclasses import dataclass

import numpy as np

from tisph.runtime import real, room, ti, view
from tisph.walls._dummies import Dummies


@dataclass(frozen=True)
class Layers:
    """Dummy particles in the frames of their bodies: ``place`` and ``foot``, the nearest wall point, (n, 2) each.

    ``body`` (n,) is the number of the body that each is in.
    """

    place: np.ndarray
    foot: np.ndarray
    body: np.ndarray

    def radius(self, body):
        """Distance of the farthest particle in a body from its centre."""
        return float(np.linalg.norm(self.place[self.body == body], axis=1).max())


def layers_in(bodies, spacing, reach):
    """Return the ``Layers`` of bodies: (k + 1/2) ``spacing`` behind the wall, as many as a particle at it could see.

    In each layer particles are about a spacing apart; there is none where the wall's centre of curvature is nearer.
    """
    feet, places, numbers = [], [], []
    for number, body in enumerate(bodies):
        for layer in range(math.ceil(reach / spacing - 0.5)):
            depth = (layer + 0.5) * spacing
            part = _outline(body.shape, spacing, depth)
            if part is None:
                break
            feet.append(part.point)
            places.append(part.point - depth * part.normal)
            numbers.append(np.full(len(part.point), number))
    return Layers(np.concatenate(places), np.concatenate(feet), np.concatenate(numbers))


def _outline(shape, spacing, depth):
    """Return wall points whose like at a ``depth`` behind the wall are a spacing apart; None where none can be."""
    wall = shape.boundary_points(spacing)
    shrinking = 1.0 - depth * wall.curvature
    if shrinking.min() <= 0.0:
        return None
    return shape.boundary_points(spacing * wall.length.sum() / (wall.length * shrinking).sum())


@ti.data_oriented
class LayerWalls(Dummies):
    """Dummy particles in bodies, in the periodic box around them, whose lowest corner is ``origin``.

    ``number[k]`` tells which of the ``Layers`` the k-th wall slot holds: a sort permutes them, and nothing else of
    theirs but that is kept by slot from step to step. The bodies are where ``place_bodies`` has put them last.
    """

    accelerates = True

    def __init__(self, lists, kernel, liquid, parameters, layers, bodies, origin):
        super().__init__(lists, kernel, liquid, parameters)
        self.layers, self.bodies, self.origin = layers, bodies, origin
        slots, vector = room(self.particles.dummies), ti.types.vector(2, real())
        self.number, self.sorted = (ti.field(ti.i32, shape=slots) for _ in range(2))
        self.body = ti.field(ti.i32, shape=slots)
        self.arm, self.foot = (ti.field(vector, shape=slots) for _ in range(2))
        self.number.used = self.body.used = self.arm.used = self.foot.used = np.s_[: self.particles.dummies]
        self.sorted.used = None
        # of each body: centre in the box, cosine and sine of its angle, and its motion
        self.centre, self.turn, self.velocity, self.acceleration = (
            ti.field(vector, shape=len(bodies)) for _ in range(4)
        )
        self.spin, self.spin_rate = (ti.field(real(), shape=len(bodies)) for _ in range(2))

    def place_bodies(self, time):
        """Put the bodies where they are at ``time``."""
        for number, body in enumerate(self.bodies):
            place, motion = body.at(time), body.motion
            view(self.centre)[number] = place.centre - self.origin
            view(self.turn)[number] = math.cos(place.angle), math.sin(place.angle)
            view(self.velocity)[number] = motion.velocity(time)
            view(self.acceleration)[number] = motion.acceleration(time)
            view(self.spin)[number] = motion.turning.velocity(time)
            view(self.spin_rate)[number] = motion.turning.acceleration(time)

    def load(self, time):
        """Put the dummy particles into the bodies at the start."""
        count = self.particles.dummies
        view(self.number)[:count] = np.arange(count)
        view(self.body)[:count] = self.layers.body
        view(self.arm)[:count], view(self.foot)[:count] = self.layers.place, self.layers.foot
        self.place_bodies(time)
        slots = slice(self.particles.first_wall, self.particles.first_wall + count)
        for number, body in enumerate(self.bodies):
            own = self.layers.body == number
            places = body.at(time).outside(self.layers.place[own]) - self.origin
            view(self.particles.mid_position)[0, slots][own] = places

    @ti.kernel
    def lay_out(self, now: ti.i32):
        """Follow a sort: find which particle each slot holds."""
        first, count = self.particles.first_wall, self.particles.mobile_number[None] - self.particles.fluid_number[None]
        ti.loop_config(serialize=True)
        for k in range(count):
            self.sorted[k] = self.number[self.cells.order[first + k] - first]
        ti.loop_config(serialize=True)
        for k in range(count):
            self.number[k] = self.sorted[k]

    @ti.func
    def advance(self, now, k, elapsed):
        """Carry dummy particle ``k`` along with its body into the other buffer."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        self.particles.mid_position[1 - now, k] = self.centre[body] + self.turned(body, self.arm[number])

    @ti.func
    def turned(self, body, vector):
        """Return a vector of the frame of a body as seen from outside."""
        turn = self.turn[body]
        return ti.Vector([turn.x * vector.x - turn.y * vector.y, turn.y * vector.x + turn.x * vector.y])

    @ti.func
    def velocity_at(self, buffer, k):
        """Return the velocity of the wall point nearest to dummy particle ``k``."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        arm = self.turned(body, self.foot[number])
        return self.velocity[body] + self.spin[body] * ti.Vector([-arm.y, arm.x])

    @ti.func
    def acceleration_at(self, k):
        """Return the acceleration of the wall point nearest to dummy particle ``k``."""
        number = self.number[k - self.particles.first_wall]
        body = self.body[number]
        arm = self.turned(body, self.foot[number])
        along = self.spin_rate[body] * ti.Vector([-arm.y, arm.x])
        return self.acceleration[body] + along - self.spin[body] ** 2 * arm
