"""What is around the fluid of an explicit run: the plane walls of a channel, bodies, or copies of the fluid itself.

``box`` says how many ``columns`` and ``rows`` of ``spacing`` the cells have to cover, from ``origin`` on; ``slots`` how
many wall particles of their own and how much room for images there has to be (``tisph/particles.py``);
``displacement_factor`` how much farther wall particles go than the fluid that they are images of.
"""

from tisph import registry
from tisph.domain import ChannelDomain
from tisph.periodic import PeriodicDomain
from tisph.schemes._momentum import MomentumBalance, WallForces
from tisph.schemes.wcsph._impulse import ImpulsiveStart
from tisph.walls._treatment import WallTreatment


class PlaneWalls:
    """The walls of a channel: their particles, how far these drift, and the momentum that they give to the fluid.

    ``drift``: of the bottom and the top wall, how far dummy particles are from where the lists expect them.
    """

    origin = (0.0, 0.0)
    displacement_factor = 1.0

    def __init__(self, config, channel, radius):
        self.channel, self.parameters = channel, config.walls.treatment
        self.box = channel
        self.treatment = registry.compiled("walls", self.parameters.type).Treatment
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

    def state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {"drift": self.drift, "built_velocity": self.built_velocity, "balance": vars(self.balance)}

    def restore(self, state):
        """Take up the numbers of ``state``."""
        self.drift, self.built_velocity = state["drift"], state["built_velocity"]
        vars(self.balance).update(state["balance"])


class PeriodicBoundaries:
    """A box that is periodic in x and y: nothing moves but the fluid, and nothing changes its momentum."""

    treatment = WallTreatment
    drift = (0.0,)
    origin = (0.0, 0.0)
    slots = (0, 0)
    displacement_factor = 1.0

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

    def state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {"initial": self.initial}

    def restore(self, state):
        """Take up the numbers of ``state``."""
        self.initial = state["initial"]
