"""Boundaries of the fluid of an explicit run: the plane walls of a channel, bodies, or periodic copies of the fluid.

Walls that start or stop at once give the fluid an impulse, by the images that obey the momentum equation. A wall whose
velocity jumps by J at t = 0 has the acceleration J delta(t), and there the images of ``consistent_image`` have the
velocity d^2 J/nu_s delta(t): a displacement xi = d^2 J/nu_s in no time. The rates are linear in the velocities, so that
the fluid's velocity changes by

    du = nu_s lap xi

as if xi were a velocity: in the row next to the wall by about J/4, the momentum that the wall gives to the layer which
the particles cannot resolve yet. It halves the error of start-up Couette flow.

The displacement also strains the polymer by gamma = xi_y, with no time to relax. The stress of the particles and its
slope at the wall (``walls/_wall_stress.py``), where u_yy = J/nu_s delta(t), become

    S -> F (S + G) F^T - G,  F = 1 + gamma e_x e_y,        S_xx,y += 2 S_xy J/nu_s,  S_xy,y += (S_yy + G) J/nu_s

Without the slope the wall shear stress of start-up flow converges with the first order only.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from tisph import registry
from tisph.config.schema import Config
from tisph.numerics.domain import ChannelDomain, Lattice, PeriodicDomain
from tisph.runtime import ti, view
from tisph.scenes._channel import Channel
from tisph.scenes._scene import Scene
from tisph.schemes._momentum import MomentumBalance
from tisph.schemes._step_control import Kept
from tisph.schemes.wcsph.operators._pairs import PairOperators
from tisph.schemes.wcsph.verlet import VerletLists
from tisph.schemes.wcsph.walls._treatment import WallTreatment
from tisph.snapshot import Snapshot


class Boundary(Kept):
    """Boundary of the fluid, which here has no particles, does not move and exerts no force.

    ``box``: is covered by the cells, from ``origin`` [length] on.
    ``slots``: number of dummy particles, and room for images. ``treatment``: class of the ``walls``.
    ``displacement_factor``: largest displacement of a wall particle over the displacement of the fluid particle that
    it is the image of. ``now`` is a buffer of the particles; ``middle`` the time in the middle of a step [time].
    """

    origin: Sequence[float] = (0.0, 0.0)
    slots = (0, 0)
    displacement_factor = 1.0
    treatment: type[Any] = WallTreatment
    box: Lattice
    domain: PeriodicDomain | ChannelDomain
    walls: Any

    def create_walls(self, operators: PairOperators, kernel: Any) -> WallTreatment:
        """Create the ``walls`` for the lists and the fluid of ``operators``; return them."""
        self.walls = self.treatment(operators.lists, kernel, operators.fluid, None)
        return self.walls

    def drifts(self) -> Iterable[float]:
        """Return distances of wall particles from their positions as the lists predict them [length]."""
        return [0.0]

    def begin(self, momentum: float) -> None:
        """Place the wall particles at the start; ``momentum``: sum of the fluid's velocities along x."""

    def jump(self, stepper: Any, now: int) -> None:
        """Apply the impulse of impulsively started walls to the fluid."""

    def account(self, now: int, steps: int, middle: float) -> None:
        """Add the wall forces in step number ``steps`` to the balance of momentum."""

    def move_on(self, before: float, middle: float) -> None:
        """Move the walls from the middle of one step, ``before``, to the middle of the next."""

    def rebuilt(self, now: int, middle: float) -> None:
        """Prepare the wall particles for new lists."""

    def momentum_balance(self, time: float, momentum: float) -> Mapping[str, float | None]:
        """Return the balance of momentum along x up to ``time``, see ``MomentumBalance.report``."""
        raise NotImplementedError

    def described(self, snapshot: Snapshot) -> Snapshot:
        """Return the ``snapshot`` with the bodies."""
        return snapshot


class PeriodicBoundaries(Boundary):
    """A box that is periodic in x and y: nothing changes the momentum of the fluid, ``initial`` at the start."""

    kept: tuple[str, ...] = ("initial",)

    def __init__(self, scene: Scene):
        self.box = scene
        self.particle_mass = scene.density * scene.spacing**2
        self.domain = PeriodicDomain(*scene.extent)
        self.initial = 0.0

    def begin(self, momentum: float) -> None:
        """Store the sum of the velocities along x at the start."""
        self.initial = momentum

    def momentum_balance(self, time: float, momentum: float) -> Mapping[str, float | None]:
        """Return the ``change`` of momentum along x [mass * velocity per length], which has no cause."""
        return {"change": self.particle_mass * (momentum - self.initial)}


@ti.data_oriented
class WallForces:
    """Force along x of each wall on the fluid, by the pairs of particles that straddle it."""

    def __init__(self, lists: VerletLists, operators: PairOperators):
        self.particles, self.cells, self.operators = lists.particles, lists.cells, operators
        self.pull = ti.field(ti.f64, shape=2)

    def __call__(self, now: int) -> np.ndarray:
        """Return the acceleration along x summed over the particles (2,), by the bottom and the top wall."""
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


class PlaneWalls(Boundary):
    """The walls of a channel.

    ``drift``: distances of the dummy particles of the bottom and the top wall from their positions as the lists predict
    them; ``built_velocity``: wall velocities when the lists were built.
    """

    kept = "drift", "built_velocity"

    def __init__(self, config: Config, channel: Channel, radius: float):
        self.channel, self.parameters = channel, config.walls.treatment
        self.box = channel
        self.treatment = registry.load("walls", self.parameters.type).treatments().channel
        self.slots = self.treatment.wall_slots(channel, radius)
        self.domain: ChannelDomain = ChannelDomain(channel)
        self.balance = MomentumBalance(channel.start_time)
        self.drift, self.built_velocity = [0.0, 0.0], [0.0, 0.0]

    def create_walls(self, operators: PairOperators, kernel: Any) -> WallTreatment:
        """Create the ``walls`` for the lists and the fluid of ``operators``; return them."""
        self.walls = self.treatment(operators.lists, kernel, operators.fluid, self.parameters)
        self.wall_forces = WallForces(operators.lists, operators)
        return self.walls

    def drifts(self) -> Iterable[float]:
        """Return the ``drift`` of both walls."""
        return self.drift

    def begin(self, momentum: float) -> None:
        """Place the wall particles at the start; ``momentum``: sum of the fluid's velocities along x."""
        self.walls.load(self.channel)
        self.balance.initial = momentum

    def jump(self, stepper: Any, now: int) -> None:
        """Apply the impulse of impulsively started walls to the fluid."""
        if self.parameters.obeys_momentum and any(self.channel.wall_jumps):
            self.balance.impulse = ImpulsiveStart(stepper).apply(now, self.channel.wall_jumps)
            self.walls.lay_out(now)

    def account(self, now: int, steps: int, middle: float) -> None:
        """Add the wall forces in step number ``steps`` to the balance of momentum, in steps where they are due."""
        if self.balance.due(steps):
            self.balance.add(middle, self.wall_forces(now))

    def move_on(self, before: float, middle: float) -> None:
        """Set the wall velocities in the ``middle`` of the next step, and update the drift."""
        self.domain.move_on(middle)
        if self.domain.oscillates and self.walls.has_dummies:
            motions = zip(self.drift, self.domain.motions, self.built_velocity, strict=True)
            elapsed = middle - before
            self.drift = [drift + elapsed * (wall.velocity(middle) - built) for drift, wall, built in motions]

    def rebuilt(self, now: int, middle: float) -> None:
        """Prepare the wall particles for new lists."""
        self.walls.refresh(now)
        self.built_velocity = [wall.velocity(middle) for wall in self.domain.motions]
        self.drift = [0.0, 0.0]

    def momentum_balance(self, time: float, momentum: float) -> Mapping[str, float | None]:
        """Return the balance of momentum along x up to ``time``, see ``MomentumBalance.report``."""
        return self.balance.report(self.channel, time, momentum)

    def host_state(self) -> dict[str, Any]:
        """Return the numbers outside the fields that a resumed run needs."""
        return {**super().host_state(), "balance": vars(self.balance)}

    def restore_host_state(self, state: Mapping[str, Any]) -> None:
        """Restore the numbers of ``host_state``."""
        super().restore_host_state(state)
        vars(self.balance).update(state["balance"])


class ImpulsiveStart:
    """Applies the jumps of the wall velocities to particles just loaded, with walls of images.

    The ``stepper``'s kernel evaluates the rates, in a step of length 1 from which only velocities and stresses are
    used. A separate kernel would take as long to compile.
    """

    def __init__(self, stepper: Any):
        self.stepper, self.walls = stepper, stepper.walls
        self.particles, self.domain, self.fluid = stepper.particles, stepper.domain, stepper.fluid
        # there is no time for shifts and finite forces; artificial viscosity is not linear
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

    def apply(self, now: int, jumps: Sequence[float]) -> list[float]:
        """Change velocities and stresses in buffer ``now``; return the gained velocity, summed over the particles.

        ``jumps``: velocity jumps of the bottom and the top wall, applied one after the other; the result has the gain
        by each. Needs the lists and the images in buffer ``now``; the images have to be updated afterwards.
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

    def displace(self, now: int, top: int, jump: float) -> None:
        """Copy the state to the other buffer; the images beyond one wall get displacements as velocities."""
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

    def change(self, now: int) -> None:
        """Change the velocities and the stresses in buffer ``now``, and nothing else, by the displacements."""
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

    def shear(self, now: int, top: int, jump: float) -> None:
        """Strain the polymer of the particles, whose S_xy the step changed by G gamma, and at the points of a wall."""
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
