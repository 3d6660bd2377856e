"""The balance of momentum along the channel: the impulses of walls and drive against the momentum of the fluid."""

EVERY_STEP_UNTIL = 64
STRIDE = 16
"""Wall forces are summed at every step first, when impulsive walls pull hardest, then at every STRIDE-th: the
trapezoidal rule over 16 steps of a force ~ t^-1/2 has an error of 0.4 % right after step 64, and less and less."""


class MomentumBalance:
    """Adds up the impulses of the walls over the run; all per unit of density and of a particle's area.

    ``impulse``: of the bottom and the top wall by the trapezoidal rule over the middles of steps; ``initial`` is
    the sum of velocities along x at the start. Kept in plain numbers so that a checkpoint holds them.
    """

    def __init__(self, start_time):
        self.start_time = self.time = start_time
        self.initial = 0.0
        self.impulse = [0.0, 0.0]
        self.force = None

    def due(self, steps):
        """Tell whether the forces of step number ``steps`` are to be added."""
        return steps < EVERY_STEP_UNTIL or steps % STRIDE == 0

    def add(self, time, force):
        """Take the wall forces at ``time``; the first count from the start on."""
        before = self.force if self.force is not None else force
        self.impulse = [
            float(total + 0.5 * (time - self.time) * (old + new))
            for total, old, new in zip(self.impulse, before, force, strict=True)
        ]
        self.time, self.force = time, [float(one) for one in force]

    def add_impulse(self, impulse):
        """Take the impulses of the walls in a step as they are."""
        self.impulse = [float(total + more) for total, more in zip(self.impulse, impulse, strict=True)]

    def report(self, channel, time, velocity_sum):
        """Return the balance at ``time`` in the units of the config, per unit length out of the plane.

        ``closure`` is the relative imbalance, a fraction of the largest of the terms; None where nothing happened.
        """
        particle_mass = channel.density * channel.spacing**2
        rest = time - self.time
        walls = [total + rest * force for total, force in zip(self.impulse, self.force or [0.0, 0.0], strict=True)]
        terms = {
            "change": particle_mass * (velocity_sum - self.initial),
            "drive": channel.density * channel.gap * channel.length * channel.acceleration * (time - self.start_time),
            "bottom_wall": particle_mass * walls[0],
            "top_wall": particle_mass * walls[1],
        }
        largest = max(abs(value) for value in terms.values())
        missing = terms["change"] - terms["drive"] - terms["bottom_wall"] - terms["top_wall"]
        return {**terms, "closure": abs(missing) / largest if largest > 0 else None}
