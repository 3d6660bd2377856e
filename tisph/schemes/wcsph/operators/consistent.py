"""Consistent operators: exact for linear fields on any particle arrangement, with shifting and diffusion.

One loop over the neighbours sums, with the weights w_j = -W'(r)/r and differences f_ji = f_j - f_i,

    M = sum w r r^T,   b = sum w r,   G_f = sum w f_ji r,   l_f = sum w f_ji,

from which, after the loop, grad f = M^-1 G_f (corrected kernel gradient: Randles & Libersky 1996; Bonet & Lok
1999) and lap f = 4 (l_f - grad f . b) / tr M (Morris' Laplacian without his 0.01 h^2, cleared of its linear
error as in Fatehi & Manzari 2011 and normalised by its own second moment). The volumes V cancel.

    du/dt = -grad p / rho + nu lap u + (du . grad) u
    ds/dt = -(1 + s) div u + du . grad s + DIFFUSION h c lap s
    dx/dt = u + du,   du = -c_s h sum V grad W

The shift du evens out the arrangement (Lind et al. 2012); its arbitrary Lagrangian-Eulerian terms keep the
fields where they are (Oger et al. 2016). Density diffusion follows Antuono et al. 2010; the linear correction above is
their renormalised density gradient.
"""

from typing import Any

from tisph.runtime import real, ti, unrolled
from tisph.schemes.wcsph._fluid import Fluid
from tisph.schemes.wcsph.operators._pairs import PairOperators
from tisph.schemes.wcsph.verlet import VerletLists

DIFFUSION = 0.1
"""Density diffusion coefficient, the value usual in the delta-SPH literature."""


@ti.data_oriented
class Operators(PairOperators):
    """Corrected gradient, moment-normalised Laplacian, particle shifting, density diffusion."""

    def __init__(self, lists: VerletLists, fluid: Fluid, kernel: Any, artificial_viscosity: float, shift_speed: float):
        super().__init__(lists, fluid, kernel, artificial_viscosity, shift_speed)
        stress_sums = {"stress_gradient": ti.types.matrix(3, 2, real())} if fluid.carries_stress else {}
        self.Sums = ti.types.struct(
            moment_xx=real(),
            moment_xy=real(),
            moment_yy=real(),
            first=self.vector,
            velocity_gradient=self.matrix,
            pressure_gradient=self.vector,
            velocity_laplacian=self.vector,
            pressure_laplacian=real(),
            **self.artificial_sums,
            **stress_sums,
        )

    @ti.func
    def rates(self, now, i):
        """Return the rates of fluid particle ``i`` from the mid-step values in buffer ``now``."""
        sums = self.sums(now, i)
        determinant = sums.moment_xx * sums.moment_yy - sums.moment_xy * sums.moment_xy
        diagonal = ti.Vector([sums.moment_yy, sums.moment_xx]) / determinant
        shear = sums.moment_xy / determinant
        correction = self.matrix([[diagonal.x, -shear], [-shear, diagonal.y]])
        laplacian_norm = 4.0 / (sums.moment_xx + sums.moment_yy)
        velocity_gradient = sums.velocity_gradient @ correction
        swapped = ti.Vector([sums.pressure_gradient.y, sums.pressure_gradient.x])
        pressure_gradient = diagonal * sums.pressure_gradient - shear * swapped
        velocity_laplacian = laplacian_norm * (sums.velocity_laplacian - velocity_gradient @ sums.first)
        pressure_laplacian = laplacian_norm * (sums.pressure_laplacian - pressure_gradient.dot(sums.first))

        compression = self.particles.mid_compression[now, i]
        density = 1.0 + compression
        stiffness = self.fluid.stiffness(compression)
        length = self.smoothing_length[None]
        rates = self.Rates()
        rates.transport = -self.shift_speed[None] * length * self.pair_weight[None] * sums.first
        rates.acceleration = (
            -pressure_gradient / density
            + self.fluid.kinematic_viscosity[None] * velocity_laplacian
            + velocity_gradient @ rates.transport
        )
        if ti.static(self.has_artificial_viscosity):
            rates.acceleration += self.artificial_strength() * sums.push
        rates.compression = (
            -density * (velocity_gradient[0, 0] + velocity_gradient[1, 1])
            + rates.transport.dot(pressure_gradient) / stiffness
            + DIFFUSION * length * self.fluid.sound_speed[None] * pressure_laplacian / stiffness
        )
        if ti.static(self.fluid.carries_stress):
            gradient = sums.stress_gradient @ correction
            rates.acceleration += (
                ti.Vector([gradient[0, 0] + gradient[1, 1], gradient[1, 0] + gradient[2, 1]]) / density
            )
            own = self.particles.mid_stress[now, i]
            rates.stress = self.fluid.stress.rate(own, velocity_gradient) + gradient @ rates.transport
        return rates

    @ti.func
    def pair_pull(self, now, i, j, weight, apart):
        """Return the term of a pair in the acceleration along x by viscosity and polymer stress, times tr M.

        It is antisymmetric in the particles: without the linear correction, and with the sum of their stresses, which
        on an even arrangement gives the same force as the difference.
        """
        faster = self.particles.mid_velocity[now, j].x - self.particles.mid_velocity[now, i].x
        pull = 4.0 * self.fluid.kinematic_viscosity[None] * faster
        if ti.static(self.fluid.carries_stress):
            stress = self.particles.mid_stress[now, i] + self.particles.mid_stress[now, j]
            pull += 2.0 * (stress[0] * apart.x + stress[1] * apart.y)
        return weight * pull

    @ti.func
    def pull_norm(self, trace):
        """Return the factor of the sum of ``pair_pull``."""
        return 1.0 / trace

    @ti.func
    def pair_sums(self, now, i, periodic: ti.template()):
        """Return the sums over the neighbours of particle ``i``."""
        velocity = self.particles.mid_velocity[now, i]
        pressure = self.particles.mid_pressure[now, i]
        sums = self.Sums()
        j = self.lists.table[i, 0]
        apart, weight = self.pair(now, i, j, periodic)
        for k in range(unrolled(self.lists.count[i])):
            following = self.lists.table[i, k + 1]
            next_apart, next_weight = self.pair(now, i, following, periodic)
            weighted = weight * apart
            faster = self.particles.mid_velocity[now, j] - velocity
            higher = self.particles.mid_pressure[now, j] - pressure
            sums.moment_xx += weighted.x * apart.x
            sums.moment_xy += weighted.x * apart.y
            sums.moment_yy += weighted.y * apart.y
            sums.first += weighted
            sums.velocity_gradient += faster.outer_product(weighted)
            sums.pressure_gradient += higher * weighted
            sums.velocity_laplacian += weight * faster
            sums.pressure_laplacian += weight * higher
            if ti.static(self.has_artificial_viscosity):
                sums.push += self.artificial_push(weight, apart, faster)
            if ti.static(self.fluid.carries_stress):
                tighter = self.particles.mid_stress[now, j] - self.particles.mid_stress[now, i]
                sums.stress_gradient += tighter.outer_product(weighted)
            j = following
            apart = next_apart
            weight = next_weight
        return sums
