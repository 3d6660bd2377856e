"""Walls that start or stop at once: their impulse on the liquid, by the images that obey the momentum equation.

A wall whose velocity jumps by J at t = 0 has the acceleration J delta(t), and there the images of ``consistent_image``
have the velocity d^2 J/nu_s delta(t): no velocity, but a displacement xi = d^2 J/nu_s in no time. The rates are linear
in the velocities, so that the liquid's velocity changes by

    du = nu_s lap xi

as if xi were a velocity: in the row next to the wall by about J/4, the momentum that the wall gives to the layer which
the particles cannot resolve yet. It halves the error of start-up Couette flow. Polymer stress starts unchanged: it
follows from the motion after the jump, and is less accurate with a jump of its own.
"""

import numpy as np

from tisph.runtime import ti


@ti.data_oriented
class ImpulsiveStart:
    """Applies the jumps of the wall velocities to the particles of an image treatment."""

    def __init__(self, operators, domain):
        self.operators, self.domain = operators, domain
        self.particles, self.liquid = operators.particles, operators.liquid

    def apply(self, now, jumps):
        """Change the velocities in buffer ``now``; return the velocity gained, summed over the particles.

        ``jumps``: of the bottom and the top wall, taken one after the other; returns an array of shape (2,). Needs the
        lists and the images in buffer ``now``, and leaves the images behind.
        """
        gains = [0.0, 0.0]
        others = [self.operators.shift_speed]
        if self.operators.has_artificial_viscosity:
            others.append(self.operators.artificial_viscosity)
        values = [field[None] for field in others]
        for field in others:
            field[None] = 0.0  # no shift in no time, and nothing that is not linear
        for top, jump in enumerate(jumps):
            if jump != 0.0:
                before = self.total(now)
                self.displace(now, top, jump)
                self.change(now)
                gains[top] = self.total(now) - before
        for field, value in zip(others, values, strict=True):
            field[None] = value
        return gains

    def total(self, now):
        """Return the sum of the velocities along x."""
        return float(np.sum(self.particles.velocity.to_numpy()[now, :, 0], dtype=float))

    @ti.kernel
    def displace(self, now: ti.i32, top: ti.i32, jump: float):
        """Fill the other buffer with displacements of the images beyond one wall, and nothing else."""
        for k in range(self.particles.slots):
            place = self.particles.mid_position[now, k]
            self.particles.mid_position[1 - now, k] = place
            depth = ti.select(top == 1, place.y - self.domain.gap[None], -place.y)
            displaced = 0.0
            if k >= self.particles.fluid and depth > 0.0:
                displaced = depth * depth * jump / self.liquid.kinematic_viscosity[None]
            self.particles.mid_velocity[1 - now, k] = ti.Vector([displaced, 0.0])
            self.particles.mid_pressure[1 - now, k] = 0.0
            if ti.static(self.particles.carries_stress):
                self.particles.mid_stress[1 - now, k] = ti.Vector([0.0, 0.0, 0.0])

    @ti.kernel
    def change(self, now: ti.i32):
        """Add what the displacements do to the velocities."""
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid):
            self.particles.mid_compression[1 - now, i] = 0.0
            rates = self.operators.rates(1 - now, i)
            self.particles.velocity[now, i] += rates.acceleration
            self.particles.mid_velocity[now, i] += rates.acceleration
