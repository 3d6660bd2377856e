"""Standard operators: the usual weakly compressible SPH, for comparison.

    du/dt = -sum V (p_i + p_j) grad W / rho_i + sum V 2 nu (r . grad W) / (r^2 + 0.01 h^2) (u_i - u_j)
    ds/dt = sum V (u_i - u_j) . grad W

Symmetric pressure form (Monaghan 1992), Morris' viscosity with his 0.01 h^2 (Morris, Fox & Zhu 1997, eq. 22),
density by the continuity equation; no correction, shifting or diffusion.
"""

from tisph.neighbours.verlet import LANES
from tisph.operators._pairs import PairOperators
from tisph.runtime import real, ti


@ti.data_oriented
class Operators(PairOperators):
    """Uncorrected sums as they stand in most codes."""

    def __init__(self, particles, lists, liquid, kernel, artificial_viscosity):
        super().__init__(particles, lists, liquid, kernel, artificial_viscosity)
        self.Sums = ti.types.struct(pressure=self.vector, viscosity=self.vector, divergence=real(), push=self.vector)

    @ti.func
    def rates(self, now, i):
        """Return the rates of fluid particle ``i`` from the mid-step values in buffer ``now``."""
        sums = self.sums(now, i)
        volume_weight = self.pair_weight[None]
        rates = self.Rates()
        rates.acceleration = volume_weight * (
            2.0 * self.liquid.kinematic_viscosity[None] * sums.viscosity
            - sums.pressure / (1.0 + self.particles.mid_compression[now, i])
        )
        if ti.static(self.has_artificial_viscosity):
            strength = self.artificial_viscosity[None] * self.liquid.sound_speed[None] * self.smoothing_length[None]
            rates.acceleration += strength * volume_weight * sums.push
        rates.compression = -volume_weight * sums.divergence
        return rates

    @ti.func
    def pair_pull(self, now, i, j, weight, apart):
        """Return a pair's share in the acceleration along x by viscosity and pressure, without the volume."""
        length = self.smoothing_length[None]
        squared = apart.dot(apart)
        faster = self.particles.mid_velocity[now, j].x - self.particles.mid_velocity[now, i].x
        viscous = 2.0 * self.liquid.kinematic_viscosity[None] * squared / (squared + 0.01 * length * length) * faster
        pressure = self.particles.mid_pressure[now, i] + self.particles.mid_pressure[now, j]
        return weight * (viscous - pressure * apart.x / (1.0 + self.particles.mid_compression[now, i]))

    @ti.func
    def pull_norm(self, trace):
        """Return what the sum of ``pair_pull`` is multiplied by."""
        return self.pair_weight[None]

    @ti.func
    def pair_sums(self, now, i, periodic: ti.template()):
        """Return the sums over the neighbours of particle ``i``."""
        velocity = self.particles.mid_velocity[now, i]
        pressure = self.particles.mid_pressure[now, i]
        length = self.smoothing_length[None]
        softening = 0.01 * length * length
        sums = self.Sums()
        for block in range(self.lists.count[i] // LANES):
            for lane in ti.static(range(LANES)):
                j = self.lists.table[i, block * LANES + lane]
                apart = self.separation(now, i, j, periodic)
                squared = apart.dot(apart)
                weight = self.weights.at(squared)
                faster = self.particles.mid_velocity[now, j] - velocity
                sums.pressure += (pressure + self.particles.mid_pressure[now, j]) * weight * apart
                sums.viscosity += weight * squared / (squared + softening) * faster
                sums.divergence += weight * faster.dot(apart)
                if ti.static(self.has_artificial_viscosity):
                    sums.push += self.artificial_push(weight, apart, faster)
        return sums
