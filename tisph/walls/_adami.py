"""What Taichi compiles for ``adami.py``, where its formulas are."""

from tisph.runtime import real, scalar, ti
from tisph.walls._dummies import Dummies, DummyWalls, LayerWalls


@ti.data_oriented
class ShepardDummies(Dummies):
    """Kernel averages (Shepard) of the fluid at every dummy particle."""

    def __init__(self, lists, kernel, fluid, parameters, *layers):
        super().__init__(lists, kernel, fluid, parameters, *layers)
        self.value = ti.func(kernel.value)
        self.smoothing_length = scalar(lists.cutoff / kernel.SUPPORT)
        self.tensor = ti.types.vector(3, real())

    @ti.func
    def extrapolate(self, buffer, k):
        """Set what dummy particle ``k`` carries; without fluid in reach, the velocity of the wall."""
        position = self.particles.mid_position[buffer, k]
        inverse_length = 1.0 / self.smoothing_length[None]
        weights = 0.0
        first = ti.Vector([0.0, 0.0])
        pressure = 0.0
        velocity = ti.Vector([0.0, 0.0])
        stress = self.tensor(0.0)
        for n in range(self.lists.count[k]):
            j = self.lists.table[k, n]
            apart = self.particles.mid_position[buffer, j] - position
            apart = self.domain.minimum_image(apart)
            weight = self.value(ti.sqrt(apart.dot(apart)) * inverse_length)
            weights += weight
            pressure += weight * self.particles.mid_pressure[buffer, j]
            velocity += weight * self.particles.mid_velocity[buffer, j]
            if ti.static(self.accelerates):
                first += weight * apart
            if ti.static(self.particles.carries_stress):
                stress += weight * self.particles.mid_stress[buffer, j]
        if weights > 0.0:
            wall = self.velocity_at(buffer, k)
            if ti.static(self.accelerates):
                pressure += self.acceleration_at(k).dot(first)
            self.set_dummy(buffer, k, 2.0 * wall - velocity / weights, pressure / weights, stress / weights)
        else:
            self.give_wall_values(buffer, k)


@ti.data_oriented
class Treatment(ShepardDummies, DummyWalls):
    """At the walls of a channel."""


@ti.data_oriented
class BodyTreatment(ShepardDummies, LayerWalls):
    """At the walls of bodies."""
