"""Adami dummy particles: fixed wall layers whose velocity and pressure are kernel averages of the fluid.

u_w = 2 U_W - sum_f u_f W_wf / sum_f W_wf and p_w = sum_f (p_f + a_W . r_fw) W_wf / sum_f W_wf (Adami, Hu & Adams
2012, J. Comput. Phys. 231, eqs. 22, 23 and 27), p over the density, a_W the acceleration of the wall, r_fw from the
dummy to the fluid particle. In a channel a_W is along the walls, where no pressure difference balances it, and is left
out. U_W and a_W are those of the nearest point of the wall: those of the dummy particle itself, as if the body were
seen there, would move the wall that the liquid feels where the body turns. The extrapolated velocity serves all
operators, also the divergence, where they take the velocity of the wall. Polymer stress is averaged like the pressure.
"""

from typing import Literal

from tisph.config.base import Model
from tisph.runtime import real, scalar, ti
from tisph.walls._dummies import Dummies, DummyWalls
from tisph.walls._layers import LayerWalls


class Parameters(Model):
    """No parameters: the number of layers follows from the kernel support."""

    type: Literal["adami"] = "adami"


@ti.data_oriented
class KernelAverages(Dummies):
    """Kernel averages (Shepard) of the fluid at every dummy particle."""

    def __init__(self, lists, kernel, liquid, parameters, *layers):
        super().__init__(lists, kernel, liquid, parameters, *layers)
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
            apart = self.domain.shortest(apart)
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
            self.give(buffer, k, 2.0 * wall - velocity / weights, pressure / weights, stress / weights)
        else:
            self.give_wall_values(buffer, k)


@ti.data_oriented
class Treatment(KernelAverages, DummyWalls):
    """At the walls of a channel."""


@ti.data_oriented
class BodyTreatment(KernelAverages, LayerWalls):
    """At the walls of bodies."""
