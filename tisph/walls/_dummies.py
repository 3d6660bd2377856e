"""Walls made of dummy particles: layers that move with the wall and carry extrapolated fluid values."""

import math

import numpy as np

from tisph.runtime import ti, view
from tisph.walls._treatment import WallTreatment


@ti.data_oriented
class Dummies(WallTreatment):
    """Dummy particles, wherever they are; ``extrapolate`` comes from the treatment.

    Where they are and move, ``advance(now, k, elapsed)``, and the velocity of their walls, ``velocity_at(buffer, k)``,
    come from subclasses; where ``accelerates``, the acceleration of these, ``acceleration_at(k)``, too.
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
        """Set what dummy particle ``k`` carries."""
        self.write(buffer, k, self.particles.mid_position[buffer, k], velocity, pressure, stress)

    @ti.func
    def give_wall_values(self, buffer, k):
        """Let dummy particle ``k``, which has no fluid in cutoff, move with its wall."""
        velocity = self.velocity_at(buffer, k)
        if ti.static(self.particles.carries_stress):
            self.set_dummy(buffer, k, velocity, 0.0, ti.Vector([0.0, 0.0, 0.0]))
        else:
            self.set_dummy(buffer, k, velocity, 0.0, 0.0)


@ti.data_oriented
class DummyWalls(Dummies):
    """Dummy particles on the continued lattice, beyond the walls of a channel."""

    @staticmethod
    def wall_slots(channel, cutoff):
        """Return (dummy particles, room for images): layers as deep as the kernel reaches, on both walls."""
        return 2 * layers(channel, cutoff) * channel.columns, 0

    def load(self, channel):
        """Put the dummy particles on the lattice continued beyond both walls, at rest relative to them."""
        depth = layers(channel, self.lists.radius)
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
        """Carry dummy particle ``k`` along with its wall into the other buffer."""
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


def layers(channel, cutoff):
    """Return the number of layers on each wall that a fluid particle at the wall could see."""
    return math.ceil(cutoff / channel.spacing - 0.5)
