"""Boundaries of the fluid of an explicit run: the plane walls of a channel, bodies, or copies of the fluid itself.

``box`` says how many ``columns`` and ``rows`` of ``spacing`` the cells have to cover, from ``origin`` on; ``slots`` how
many wall particles of their own and how much room for images there has to be (``tisph/neighbours/cells.py``);
``displacement_factor`` how much farther wall particles go than the fluid that they are images of.

Walls that start or stop at once give the fluid an impulse, by the images that obey the momentum equation. A wall whose
velocity jumps by J at t = 0 has the acceleration J delta(t), and there the images of ``consistent_image`` have the
velocity d^2 J/nu_s delta(t): no velocity, but a displacement xi = d^2 J/nu_s in no time. The rates are linear in the
velocities, so that the fluid's velocity changes by

    du = nu_s lap xi

as if xi were a velocity: in the row next to the wall by about J/4, the momentum that the wall gives to the layer which
the particles cannot resolve yet. It halves the error of start-up Couette flow.

The displacement also strains the polymer by gamma = xi_y, with no time to relax. The stress of the particles and its
slope at the wall (``walls/_wall_stress.py``), where u_yy = J/nu_s delta(t), become

    S -> F (S + G) F^T - G,  F = 1 + gamma e_x e_y,        S_xx,y += 2 S_xy J/nu_s,  S_xy,y += (S_yy + G) J/nu_s

Without the slope the wall shear stress of start-up flow converges with the first order only.
"""

import numpy as np

from tisph import registry
from tisph.domain import ChannelDomain, PeriodicDomain
from tisph.runtime import ti, view
from tisph.schemes._momentum import MomentumBalance
from tisph.schemes._step_control import Kept
from tisph.walls._treatment import WallTreatment


@ti.data_oriented
class WallForces:
    """Force along x that each wall exerts on the fluid, by the pairs of particles that straddle it."""

    def __init__(self, lists, operators):
        self.particles, self.cells, self.operators = lists.particles, lists.cells, operators
        self.pull = ti.field(ti.f64, shape=2)

    def __call__(self, now):
        """Return the acceleration along x summed over the particles, by the bottom and the top wall."""
        self.add_up(now)
        return view(self.pull).copy()

    @ti.kernel
    def add_up(self, now: ti.i32):
        """Sum the forces of wall particles on the fluid in the rows of cells at the walls."""
        self.pull[0] = 0.0
        self.pull[1] = 0.0
        ti.loop_config(serialize=True)
        for i in range(self.particles.fluid_number[None]):
            first_top = self.cells.start[self.cells.place(self.cells.rows[None], 0)]
            if i < self.cells.start[self.cells.place(1, self.cells.columns[None])] or i >= first_top:
                pull = self.operators.wall_pull(now, i)
                self.pull[0] += pull[0]
                self.pull[1] += pull[1]


class PlaneWalls(Kept):
    """The walls of a channel: their particles, how far these drift, and the momentum that they give to the fluid.

    ``drift``: of the bottom and the top wall, how far dummy particles are from where the lists expect them.
    """

    origin = (0.0, 0.0)
    displacement_factor = 1.0
    kept = "drift", "built_velocity"

    def __init__(self, config, channel, radius):
        self.channel, self.parameters = channel, config.walls.treatment
        self.box = channel
        self.treatment = registry.load("walls", self.parameters.type).treatments().channel
        self.slots = self.treatment.wall_slots(channel, radius)
        self.domain = ChannelDomain(channel)
        self.balance = MomentumBalance(channel.start_time)
        self.drift, self.built_velocity = [0.0, 0.0], [0.0, 0.0]

    def surround(self, operators, kernel):
        """Make the ``walls`` that particles see, for the lists and the fluid of ``operators``; return them."""
        self.walls = self.treatment(operators.lists, kernel, operators.fluid, self.parameters)
        self.wall_forces = WallForces(operators.lists, operators)
        return self.walls

    def begin(self, momentum):
        """Place the wall particles around a fluid whose velocities along x add up to ``momentum``."""
        self.walls.load(self.channel)
        self.balance.initial = momentum

    def jump(self, stepper, now):
        """Give the fluid in buffer ``now`` the impulse of impulsively started walls."""
        if self.parameters.obeys_momentum and any(self.channel.wall_jumps):
            self.balance.impulse = ImpulsiveStart(stepper).apply(now, self.channel.wall_jumps)
            self.walls.lay_out(now)

    def account(self, now, steps, middle):
        """Add the wall forces at the ``middle`` of step number ``steps`` to the balance, where they are due."""
        if self.balance.due(steps):
            self.balance.add(middle, self.wall_forces(now))

    def move_on(self, before, middle):
        """Move the walls from the middle of one step to that of the next."""
        self.domain.move_on(middle)
        if self.domain.oscillates and self.walls.has_dummies:
            motions = zip(self.drift, self.domain.motions, self.built_velocity, strict=True)
            elapsed = middle - before
            self.drift = [drift + elapsed * (wall.velocity(middle) - built) for drift, wall, built in motions]

    def rebuilt(self, now, middle):
        """Prepare the wall particles for lists that were built anew."""
        self.walls.refresh(now)
        self.built_velocity = [wall.velocity(middle) for wall in self.domain.motions]
        self.drift = [0.0, 0.0]

    def momentum_balance(self, time, momentum):
        """Return the balance of momentum along x up to ``time``, see ``MomentumBalance.report``."""
        return self.balance.report(self.channel, time, momentum)

    def described(self, snapshot):
        """Return the ``snapshot``, which says all of plane walls."""
        return snapshot

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {**super().host_state(), "balance": vars(self.balance)}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        super().restore_host_state(state)
        vars(self.balance).update(state["balance"])


class PeriodicBoundaries(Kept):
    """A box that is periodic in x and y: nothing moves but the fluid, and nothing changes its momentum."""

    treatment = WallTreatment
    drift = (0.0,)
    origin = (0.0, 0.0)
    slots = (0, 0)
    displacement_factor = 1.0
    kept: tuple[str, ...] = ("initial",)

    def __init__(self, config, scene):
        self.box = scene
        self.particle_mass = scene.density * scene.spacing**2
        self.domain = PeriodicDomain(*scene.extent)
        self.initial = 0.0

    def surround(self, operators, kernel):
        """Return walls of no particles."""
        return WallTreatment(operators.lists, kernel, operators.fluid, None)

    def begin(self, momentum):
        """Note the sum of the velocities along x at the start."""
        self.initial = momentum

    def jump(self, stepper, now):
        """Nothing gives the fluid an impulse."""

    def account(self, now, steps, middle):
        """Nothing exerts a force."""

    def move_on(self, before, middle):
        """Nothing moves."""

    def rebuilt(self, now, middle):
        """Lists are all there is."""

    def momentum_balance(self, time, momentum):
        """Return the ``change`` of momentum along x [mass * velocity per length], which has no cause."""
        return {"change": self.particle_mass * (momentum - self.initial)}

    def described(self, snapshot):
        """Return the ``snapshot``: there is nothing but fluid."""
        return snapshot


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
