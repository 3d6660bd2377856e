"""Walls that start or stop at once: their impulse on the fluid, by the images that obey the momentum equation.

A wall whose velocity jumps by J at t = 0 has the acceleration J delta(t), and there the images of ``consistent_image``
have the velocity d^2 J/nu_s delta(t): no velocity, but a displacement xi = d^2 J/nu_s in no time. The rates are linear
in the velocities, so that the fluid's velocity changes by

    du = nu_s lap xi

as if xi were a velocity: in the row next to the wall by about J/4, the momentum that the wall gives to the layer which
the particles cannot resolve yet. It halves the error of start-up Couette flow.

The displacement also strains the polymer by gamma = xi_y, with no time to relax. The stress of the particles and its
slope at the wall (``walls/_track.py``), where u_yy = J/nu_s delta(t), become

    S -> F (S + G) F^T - G,  F = 1 + gamma e_x e_y,        S_xx,y += 2 S_xy J/nu_s,  S_xy,y += (S_yy + G) J/nu_s

Without the slope the wall shear stress of start-up flow converges with the first order only.
"""

import numpy as np

from tisph.runtime import view


class ImpulsiveStart:
    """Applies the jumps of the wall velocities to particles just loaded, of an image treatment.

    The kernel of a step evaluates the rates: of a step of length 1 the velocities alone are kept. A kernel of its own
    would take as long to compile as that one.
    """

    def __init__(self, stepper):
        self.stepper, self.walls = stepper, stepper.walls
        self.particles, self.domain, self.fluid = stepper.particles, stepper.domain, stepper.fluid
        # no shift in no time, no finite force, and nothing that is not linear
        self.disabled = [stepper.operators.shift_speed]
        if stepper.operators.has_artificial_viscosity:
            self.disabled.append(stepper.operators.artificial_viscosity)
        if self.domain.has_body_force:
            self.disabled.append(self.domain.acceleration)
        particles = self.particles
        self.unchanged = [particles.position, particles.mid_position, particles.compression]
        self.copied = [*self.unchanged, particles.velocity, particles.identity]
        self.middles = [particles.mid_velocity, particles.mid_pressure, particles.mid_compression]
        if particles.carries_stress:
            self.copied.append(particles.stress)
            self.middles.append(particles.mid_stress)
        self.modulus = float(view(self.fluid.stress.modulus)) if particles.carries_stress else 0.0
        self.points = self.walls.track.fields() if self.walls.tracks_walls else []

    def apply(self, now, jumps):
        """Change velocities and stresses in buffer ``now``; return the velocity gained, summed over the particles.

        ``jumps``: of the bottom and the top wall, taken one after the other; returns an array of shape (2,). Needs the
        lists and the images in buffer ``now``, and leaves the images behind.
        """
        particles, gains = self.particles, [0.0, 0.0]
        for top, jump in enumerate(jumps):
            if jump != 0.0:
                before = particles.momentum(now)
                self.displace(now, top, jump)
                self.change(now)
                if self.modulus > 0.0:
                    self.shear(now, top, jump)
                particles.set_middle(now)
                gains[top] = particles.momentum(now) - before
        return gains

    def displace(self, now, top, jump):
        """Copy the state to the other buffer, with displacements of the images beyond one wall for velocities."""
        particles, other = self.particles, 1 - now
        for field in self.copied:
            view(field)[other] = view(field)[now]
        for field in self.middles:
            view(field)[other] = 0.0
        images = slice(particles.first_wall, particles.first_wall + self.walls.present_images())
        y = view(particles.mid_position)[now, images, 1]
        depth = y - view(self.domain.height) if top else -y
        displacement = depth * depth * jump / view(self.fluid.kinematic_viscosity)
        view(particles.mid_velocity)[other, images, 0] = np.where(depth > 0.0, displacement, 0.0)

    def change(self, now):
        """Change the velocities and the stresses in buffer ``now`` by the displacements, and nothing else."""
        kept = [*self.disabled, *self.points]
        values = [view(field).copy() for field in kept]
        for field in self.disabled:
            view(field)[...] = 0.0
        self.stepper.step(1 - now, 1.0, 0.0, 0.0, 0.0)
        for field, value in zip(kept, values, strict=True):
            view(field)[...] = value
        for field in self.unchanged:
            view(field)[now] = view(field)[1 - now]
        for field in self.middles:
            view(field)[now] = 0.0

    def shear(self, now, top, jump):
        """Strain the polymer of the particles, whose S_xy the step changed by G gamma, and of one wall's points."""
        stress, track, modulus = self.particles.stress, self.walls.track, self.modulus
        xx, xy, yy = view(stress)[1 - now].T
        strain = (view(stress)[now, :, 1] - xy) / modulus
        view(stress)[now] = np.stack(
            [xx + strain * (2.0 * xy + strain * (yy + modulus)), xy + strain * (yy + modulus), yy], 1
        )
        points, curvature = slice(int(view(track.count))), jump / view(self.fluid.kinematic_viscosity)
        _, wall_xy, wall_yy = view(track.stress)[top, points].T
        for slope in (view(track.slope)[top, points], view(track.mid_slope)[top, points]):
            slope[:, 0] += 2.0 * curvature * wall_xy
            slope[:, 1] += curvature * (wall_yy + modulus)
