"""Standard operators: the usual weakly compressible SPH, for comparison.

    du/dt = -sum V (p_i + p_j) grad W / rho_i + sum V 2 nu (r . grad W) / (r^2 + 0.01 h^2) (u_i - u_j)
    ds/dt = sum V (u_i - u_j) . grad W

Symmetric pressure form (Monaghan 1992), Morris' viscosity with his 0.01 h^2 (Morris, Fox & Zhu 1997, eq. 22),
density by the continuity equation; no correction, shifting or diffusion.
"""

from typing import Any

from tisph.runtime import real, ti, unrolled
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.operators._pairs import PairOperators
from tisph.schemes.wcsph.verlet import VerletLists


@ti.data_oriented
class Operators(PairOperators):
    """Uncorrected sums as they stand in most codes."""

    def __init__(self, lists: VerletLists, fluid: Fluid, kernel: Any, artificial_viscosity: float, shift_speed: float):
        super().__init__(lists, fluid, kernel, artificial_viscosity, shift_speed)
        self.Sums = ti.types.struct(
            pressure=self.vector, viscosity=self.vector, divergence=real(), **self.artificial_sums
        )

    @ti.func
    def rates(self, now, i):
        """Return the rates of fluid particle ``i`` from the mid-step values in buffer ``now``."""
        sums = self.sums(now, i)
        volume_weight = self.pair_weight[None]
        rates = self.Rates()
        rates.acceleration = volume_weight * (
            2.0 * self.fluid.kinematic_viscosity[None] * sums.viscosity
            - sums.pressure / (1.0 + self.particles.mid_compression[now, i])
        )
        if ti.static(self.has_artificial_viscosity):
            rates.acceleration += self.artificial_strength() * sums.push
        rates.compression = -volume_weight * sums.divergence
        return rates

    @ti.func
    def pair_pull(self, now, i, j, weight, apart):
        """Return the term of a pair in the acceleration along x by viscosity and pressure, without the volume."""
        faster = self.particles.mid_velocity[now, j].x - self.particles.mid_velocity[now, i].x
        viscous = 2.0 * self.fluid.kinematic_viscosity[None] * self.softened(apart.dot(apart)) * faster
        pressure = self.particles.mid_pressure[now, i] + self.particles.mid_pressure[now, j]
        return weight * (viscous - pressure * apart.x / (1.0 + self.particles.mid_compression[now, i]))

    @ti.func
    def pull_norm(self, trace):
        """Return the factor of the sum of ``pair_pull``."""
        return self.pair_weight[None]

    @ti.func
    def pair_sums(self, now, i, periodic: ti.template()):
        """Return the sums over the neighbours of particle ``i``."""
        velocity = self.particles.mid_velocity[now, i]
        pressure = self.particles.mid_pressure[now, i]
        sums = self.Sums()
        j = self.lists.table[i, 0]
        apart, weight = self.pair(now, i, j, periodic)
        viscous = weight * self.softened(apart.dot(apart))
        for k in range(unrolled(self.lists.count[i])):
            following = self.lists.table[i, k + 1]
            next_apart, next_weight = self.pair(now, i, following, periodic)
            next_viscous = next_weight * self.softened(next_apart.dot(next_apart))
            faster = self.particles.mid_velocity[now, j] - velocity
            sums.pressure += (pressure + self.particles.mid_pressure[now, j]) * weight * apart
            sums.viscosity += viscous * faster
            sums.divergence += weight * faster.dot(apart)
            if ti.static(self.has_artificial_viscosity):
                sums.push += self.artificial_push(weight, apart, faster)
            j = following
            apart = next_apart
            weight = next_weight
            viscous = next_viscous
        return sums

    @ti.func
    def softened(self, squared):
        """Return r^2 / (r^2 + 0.01 h^2) of a squared distance."""
        length = self.smoothing_length[None]
        return squared / (squared + 0.01 * length * length)
