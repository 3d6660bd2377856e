"""Adami dummy particles: fixed wall layers whose velocity and pressure are kernel averages of the fluid.

u_w = 2 U_W - sum_f u_f W_wf / sum_f W_wf and p_w = sum_f (p_f + a_W . r_fw) W_wf / sum_f W_wf (Adami, Hu & Adams
2012, J. Comput. Phys. 231, eqs. 22, 23 and 27), p per unit density, a_W the acceleration of the wall, r_fw from the
dummy to the fluid particle. In a channel a_W is along the walls, where no pressure difference balances it, and is left
out. U_W and a_W are taken at the nearest point of the wall: taken at the dummy particle, the effective wall would move
where the body rotates. All operators use the extrapolated velocity, also the divergence, for which Adami et al. take
the velocity of the wall. Polymer stress is averaged like the pressure.
"""

from functools import cache
from typing import Any, Literal

from tisph.schemes.wcsph.walls import Treatments, WallParameters


class Parameters(WallParameters):
    """No parameters: the number of layers follows from the kernel support."""

    type: Literal["adami"] = "adami"


@cache
def treatments() -> Treatments:
    """Return the classes that Taichi compiles."""
    from tisph.runtime import real, scalar, ti
    from tisph.schemes.wcsph.verlet import VerletLists
    from tisph.schemes.wcsph.walls._dummies import Dummies, DummyWalls, LayerWalls

    @ti.data_oriented
    class ShepardDummies(Dummies):
        """Kernel averages (Shepard) of the fluid at every dummy particle."""

        def __init__(self, lists: VerletLists, kernel: Any, *others: Any):
            super().__init__(lists, kernel, *others)
            self.value = ti.func(kernel.value)
            self.smoothing_length = scalar(lists.cutoff / kernel.SUPPORT)
            self.tensor = ti.types.vector(3, real())

        @ti.func
        def extrapolate(self, buffer, k):
            """Set the values of dummy particle ``k``; without fluid in reach, the velocity of the wall."""
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
        """The walls of a channel."""

    @ti.data_oriented
    class BodyTreatment(ShepardDummies, LayerWalls):
        """The walls of bodies."""

    return Treatments(Treatment, BodyTreatment)
